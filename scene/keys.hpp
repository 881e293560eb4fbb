// The keys of a scene, declared once. A section is a list of keys; a key is a name, a unit, a
// meaning, bounds and the member that it fills. Reading, error messages, defaults and the reference
// in docs/scenes.md all come from these lists.
//
//   Section<Gust> section("forces.gust", false, "turbulence", {
//       gust.key("length", "m", &Gust::length, "longest wavelength", positive)});
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "scene/document.hpp"
#include "scene/mistakes.hpp"
#include "scene/sweep_values.hpp"
#include "scene/words.hpp"
#include "soa/particle_fields.hpp"
#include "solver/emitter.hpp"

namespace salvo::scene {

/// In single precision a larger one would be infinite.
inline constexpr double largest_number = 3.4e38;

/// Accepted values of a number.
struct Bounds {
  double lowest = -largest_number;
  double highest = largest_number;
  bool above_lowest = false;  ///< the lowest itself is refused

  bool contain(double value) const {
    return (above_lowest ? value > lowest : value >= lowest) && value <= highest;
  }
  /// Such as "more than 0 s"; "" for all numbers.
  std::string text(std::string_view unit) const;
};

inline constexpr Bounds any_number{};
inline constexpr Bounds positive{0, largest_number, true};
inline constexpr Bounds not_negative{0};
constexpr Bounds between(double lowest, double highest) { return {lowest, highest}; }
constexpr Bounds at_least(double lowest) { return {lowest}; }
constexpr Bounds above(double lowest, double highest) { return {lowest, highest, true}; }

/// The set of a section's kinds that a key belongs to: one bit for each value of the word that
/// decides.
using Kinds = std::uint32_t;
inline constexpr Kinds every_kind = ~Kinds{0};

template <class... E>
constexpr Kinds kinds(E... values) {
  return ((Kinds{1} << static_cast<int>(values)) | ...);
}

class SectionText;

/// What is said about a key, whatever it fills.
struct KeyText {
  std::string name;
  std::string type;
  std::string unit;    ///< SI; that of a number written without one
  std::string stored;  ///< the unit in which the program keeps it
  std::string meaning;
  std::string fallback;  ///< the default as Markdown: `TOML`, or words
  Bounds bounds;
  Words words;
  Kinds belongs = every_kind;  ///< kinds for which the key may be given
  Kinds required = 0;          ///< kinds for which it must be
  const SectionText* section = nullptr;
};

/// What is said about a section: for the reference and for hints.
class SectionText {
 public:
  SectionText(std::string path, bool list, std::string meaning)
      : path_(std::move(path)), list_(list), meaning_(std::move(meaning)) {}
  virtual ~SectionText() = default;
  SectionText(const SectionText&) = default;
  const std::string& path() const { return path_; }
  const std::string& meaning() const { return meaning_; }
  /// "[forces]", "[[emitter]]", or "the scene" for the outermost.
  std::string label() const;
  virtual std::vector<const KeyText*> keys() const = 0;

 private:
  std::string path_;
  bool list_;
  std::string meaning_;
};

/// Reads values, checks them and collects what is wrong. A read leaves its target alone when the
/// value is wrong.
class Reader {
 public:
  Reader(const SectionText& scene, Mistakes& mistakes)
      : scene_(&scene), section_(&scene), mistakes_(&mistakes) {}

  void read(const Value& value, const KeyText& key, double& out);
  void read(const Value& value, const KeyText& key, bool& out);
  void read(const Value& value, const KeyText& key, std::string& out);
  void read(const Value& value, const KeyText& key, solver::Spread& out);
  void read(const Value& value, const KeyText& key, InputValue& out);
  void read_words(const Value& value, const KeyText& key, solver::Variation& variation);
  void read(const Value& value, const KeyText&, Later& out) { out.value = value; }
  template <class I>
  requires(std::is_integral_v<I>) void read(const Value& value, const KeyText& key, I& out) {
    if (const auto whole = whole_number(value, key)) out = static_cast<I>(*whole);
  }
  template <class E>
  requires(std::is_enum_v<E>) void read(const Value& value, const KeyText& key, E& out) {
    if (const auto found = word(value, key)) out = static_cast<E>(*found);
  }
  template <class X, std::size_t N>
  void read(const Value& value, const KeyText& key, std::array<X, N>& out) {
    if (!is_list(value, key, N)) return;
    for (std::size_t i = 0; i < N; ++i) read(value.items[i], key, out[i]);
  }
  template <class X>
  void read(const Value& value, const KeyText& key, std::vector<X>& out) {
    if (!is_list(value, key, 0)) return;
    out.clear();
    for (const Value& item : value.items) {
      std::optional<X> one;
      read(item, key, one);
      if (one) out.push_back(*std::move(one));
    }
  }
  template <class X>
  void read(const Value& value, const KeyText& key, std::optional<X>& out) {
    const std::size_t before = mistakes();
    read(value, key, out.emplace());
    if (mistakes() != before) out.reset();
  }

  void fail(const Value& value, std::string problem, std::string hint = {}) {
    mistakes_->add(value.place, std::move(problem), std::move(hint));
  }
  std::size_t mistakes() const { return mistakes_->count(); }

  bool is_table(const Value& value, const KeyText& key);
  bool is_list_of_tables(const Value& value, const KeyText& key);
  void unknown_key(const Member& member);
  void misplaced_key(const Member& member, const KeyText& key, const KeyText& decider, int kind);
  void missing_key(const Value& table, const KeyText& key);

  /// The section whose keys are being read, which messages name; returns the one before.
  const SectionText* enter(const SectionText* section) { return std::exchange(section_, section); }

 private:
  std::optional<std::int64_t> whole_number(const Value& value, const KeyText& key);
  std::optional<int> word(const Value& value, const KeyText& key);
  bool is_list(const Value& value, const KeyText& key, std::size_t length);
  bool in_bounds(const Value& value, const KeyText& key, double number);
  bool bound_pair(const Value& value, const KeyText& key, std::array<double, 2>& pair);
  void wrong_type(const Value& value, const KeyText& key, std::string_view expected);
  std::string named(const KeyText& key) const;

  const SectionText* scene_;
  const SectionText* section_;
  Mistakes* mistakes_;
};

/// A key of a section whose values go into a T.
template <class T>
struct Key : KeyText {
  std::function<void(Reader&, const Value&, const KeyText&, T&)> read;

  Key only(Kinds of) && {
    belongs = of;
    return std::move(*this);
  }
  /// It must be given (for the kinds that it belongs to).
  Key must() && {
    required = belongs;
    fallback.clear();
    return std::move(*this);
  }
  /// The default in words, where the value does not say it.
  Key otherwise(std::string_view text) && {
    fallback = text;
    return std::move(*this);
  }
  /// The unit in which the member is kept, where that is not SI.
  Key kept_in(std::string_view other) && {
    stored = other;
    return std::move(*this);
  }
};

template <class T>
class Section : public SectionText {
 public:
  Section(std::string path, bool list, std::string meaning, std::vector<Key<T>> keys)
      : SectionText(std::move(path), list, std::move(meaning)), keys_(std::move(keys)) {}

  /// The value of the first key, which decides what the others may be.
  Section decided_by(std::function<int(const T&)> kind) && {
    kind_ = std::move(kind);
    return std::move(*this);
  }

  std::vector<const KeyText*> keys() const override {
    std::vector<const KeyText*> texts;
    for (const Key<T>& key : keys_) texts.push_back(&key);
    return texts;
  }

  void read(Reader& reader, const Value& table, T& out) const {
    const SectionText* outer = reader.enter(this);
    for (const Member& member : table.members) {
      const bool known = std::any_of(keys_.begin(), keys_.end(),
                                     [&](const Key<T>& key) { return key.name == member.key; });
      if (!known) reader.unknown_key(member);
    }
    const std::size_t before = reader.mistakes();
    bool decided = true;
    for (const Key<T>& key : keys_) {
      const bool first = &key == &keys_.front();
      const Kinds kind = kind_ && !first ? kinds(kind_(out)) : every_kind;
      const auto member =
          std::find_if(table.members.begin(), table.members.end(),
                       [&](const Member& candidate) { return candidate.key == key.name; });
      if (member == table.members.end()) {
        if (decided && (key.required & kind) != 0) reader.missing_key(table, key);
      } else if (decided && (key.belongs & kind) == 0) {
        reader.misplaced_key(*member, key, keys_.front(), kind_(out));
      } else {
        key.read(reader, member->value, key, out);
      }
      // Without its kind nothing can be said about what a section must and may hold.
      if (first && kind_) decided = reader.mistakes() == before;
    }
    reader.enter(outer);
  }

 private:
  std::vector<Key<T>> keys_;
  std::function<int(const T&)> kind_;
};

// How the reference names types and writes defaults.
std::string type_text(const double*);
std::string type_text(const bool*);
std::string type_text(const std::string*);
std::string type_text(const solver::Spread*);
std::string type_text(const InputValue*);
std::string type_text(const Later*);
template <class I>
requires(std::is_integral_v<I>) std::string type_text(const I*) { return "whole number"; }
template <class E>
requires(std::is_enum_v<E>) std::string type_text(const E*) { return "word"; }
template <class X, std::size_t N>
std::string type_text(const std::array<X, N>*) {
  return fmt::format("list of {} {}s", N, type_text(static_cast<const X*>(nullptr)));
}
template <class X>
std::string type_text(const std::vector<X>*) {
  const std::string one = type_text(static_cast<const X*>(nullptr));
  return one.starts_with("list ") ? fmt::format("list of lists{}", one.substr(4))
                                  : fmt::format("list of {}s", one);
}
template <class X>
std::string type_text(const std::optional<X>*) {
  return type_text(static_cast<const X*>(nullptr));
}

std::string default_text(double value, const Words& words);
std::string default_text(bool value, const Words& words);
std::string default_text(const std::string& value, const Words& words);
std::string default_text(const solver::Spread& value, const Words& words);
std::string default_text(const InputValue& value, const Words& words);
template <class I>
requires(std::is_integral_v<I>) std::string default_text(I value, const Words&) {
  return fmt::format("{}", value);
}
template <class E>
requires(std::is_enum_v<E>) std::string default_text(E value, const Words& words) {
  for (const Word& entry : words) {
    if (entry.value == static_cast<int>(value)) return fmt::format("\"{}\"", entry.word);
  }
  return {};
}
template <class List>
requires(requires(const List& list) { list.begin(); }) std::string
    default_text(const List& list, const Words& words) {
  std::string text;
  for (const auto& item : list) text += (text.empty() ? "" : ", ") + default_text(item, words);
  return fmt::format("[{}]", text);
}
template <class X>
std::string default_markdown(const X& value, const Words& words) {
  return fmt::format("`{}`", default_text(value, words));
}
template <class X>
std::string default_markdown(const std::optional<X>&, const Words&) {
  return "none";
}
inline std::string default_markdown(const Later&, const Words&) { return "none"; }

/// Makes the keys of a section whose values go into a T. `access` is a member pointer, or a
/// function T& -> member&.
template <class T>
struct KeysOf {
  /// A key that holds a value.
  template <class Access>
  Key<T> key(std::string_view name, std::string_view unit, Access access, std::string_view meaning,
             Bounds bounds = any_number, const Words& words = {}) const {
    using X = std::remove_reference_t<decltype(std::invoke(access, std::declval<T&>()))>;
    T fresh{};
    Key<T> made;
    made.name = name;
    made.type = type_text(static_cast<const X*>(nullptr));
    made.unit = made.stored = unit;
    made.meaning = meaning;
    made.fallback = default_markdown(std::invoke(access, fresh), words);
    made.bounds = bounds;
    made.words = words;
    made.read = [access](Reader& reader, const Value& value, const KeyText& text, T& out) {
      reader.read(value, text, std::invoke(access, out));
    };
    return made;
  }

  /// A key that holds a word, or a list of words.
  template <class Access>
  Key<T> word(std::string_view name, Access access, std::string_view meaning,
              const Words& words) const {
    return key(name, "", access, meaning, any_number, words);
  }

  /// A key that fills a particle's field: unit, meaning and bounds are the field's.
  template <class Access>
  Key<T> field(soa::ParticleField which, Access access) const {
    const soa::Field& field = soa::field(which);
    return key(std::string(field.name), std::string(field.unit), access, std::string(field.meaning),
               between(field.lowest, field.highest));
  }

  /// A key that is a section of its own; `access` is called when it is given.
  template <class U, class Access>
  Key<T> table(std::string_view name, const Section<U>& section, Access access) const {
    Key<T> made = below(name, section);
    made.read = [&section, access](Reader& reader, const Value& value, const KeyText& text,
                                   T& out) {
      if (reader.is_table(value, text)) section.read(reader, value, std::invoke(access, out));
    };
    return made;
  }

  /// A key that is a list of sections.
  template <class U, class Access>
  Key<T> list(std::string_view name, const Section<U>& section, Access access) const {
    Key<T> made = below(name, section);
    made.read = [&section, access](Reader& reader, const Value& value, const KeyText& text,
                                   T& out) {
      if (!reader.is_list_of_tables(value, text)) return;
      for (const Value& item : value.items) {
        section.read(reader, item, std::invoke(access, out).emplace_back());
      }
    };
    return made;
  }

 private:
  static Key<T> below(std::string_view name, const SectionText& section) {
    Key<T> made;
    made.name = name;
    made.section = &section;
    return made;
  }
};

/// The sections and their keys as Markdown, the outermost first.
std::string reference(const SectionText& scene);

}  // namespace salvo::scene
