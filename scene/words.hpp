// The words by which scenes and reports call the values of an enumeration.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "models/obstacle.hpp"
#include "soa/field.hpp"
#include "solver/emitter.hpp"
#include "solver/particle_pass.hpp"

namespace salvo::scene {

/// A word that a key takes, and the value of an enumeration that it stands for.
struct Word {
  template <class E>
  Word(std::string_view text, E enumerator, std::string_view says = "")
      : word(text), value(static_cast<int>(enumerator)), meaning(says) {}

  std::string_view word;
  int value;
  std::string_view meaning;
};
using Words = std::vector<Word>;

/// All words of an enumeration that is spoken of outside its key, too.
template <class E>
const Words& words_of() = delete;
template <>
const Words& words_of<soa::Precision>();
template <>
const Words& words_of<solver::IntegratorKind>();
template <>
const Words& words_of<solver::EmitterKind>();
template <>
const Words& words_of<models::ObstacleShape>();

template <class E>
std::string_view name(E value) {
  for (const Word& entry : words_of<E>()) {
    if (entry.value == static_cast<int>(value)) return entry.word;
  }
  return {};
}

template <class E>
std::optional<E> named(std::string_view word) {
  for (const Word& entry : words_of<E>()) {
    if (entry.word == word) return static_cast<E>(entry.value);
  }
  return std::nullopt;
}

}  // namespace salvo::scene
