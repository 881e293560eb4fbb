// A TOML document as a tree in which every key and value knows where it was written, with the --set
// overrides put in. The only file that knows the TOML library is document.cpp.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scene/mistakes.hpp"

namespace salvo::scene {

struct Member;

struct Value {
  enum class Kind { boolean, integer, number, string, date, list, table };

  Kind kind = Kind::table;
  Place place;
  bool boolean = false;
  std::int64_t integer = 0;
  /// Of a string what it says, of an integer or number its decimal digits as written.
  std::string text;
  /// Of an override its characters, for keys that take a string: the shell has taken its quotes.
  std::optional<std::string> typed;
  std::vector<Value> items;
  std::vector<Member> members;

  const Value* find(std::string_view key) const;
  Value* find(std::string_view key);
};

struct Member {
  std::string key;
  Place key_place;
  Value value;
};

/// Keys of one table that say the same thing: at most one of them is given.
struct Rivals {
  std::string_view section;  ///< path without indices, such as "emitter"
  std::vector<std::string_view> keys;
};

/// The group that a key belongs to; nullptr when it has no rivals.
const Rivals* rivals_of(std::span<const Rivals> groups, std::string_view section,
                        std::string_view key);

/// "a whole number", "a table" ..: the kind as messages name it.
std::string_view name(Value::Kind kind);

/// The value at a dotted path such as "emitter.0.time", or the deepest one on the way to it.
const Value& deepest(const Value& root, std::string_view path);

/// The tree of a text with the overrides put in, in order; nothing when the text is not TOML. An
/// override takes its key's rivals out of the text. What is wrong goes to `mistakes`.
std::optional<Value> read_document(std::string_view text, const std::vector<std::string>& overrides,
                                   std::span<const Rivals> rivals, Mistakes& mistakes);

}  // namespace salvo::scene
