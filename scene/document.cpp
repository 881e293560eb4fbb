#include "scene/document.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <charconv>

namespace salvo::scene {

namespace {

// Where the characters of a source begin in the text that the TOML library was given, and the
// source's number.
struct Origin {
  int source = 0;
  int shift = 0;  // added to columns
};

Place place_of(const toml::source_region& region, Origin origin) {
  const auto line = static_cast<int>(region.begin.line);
  const auto column = static_cast<int>(region.begin.column);
  const bool one_line = region.end.line == region.begin.line;
  const int length = one_line ? static_cast<int>(region.end.column) - column : 1;
  return {origin.source, line, column + origin.shift, std::max(length, 1)};
}

class Converter {
 public:
  // `lines` are those of the text that was parsed: numbers are taken from there, digit by digit.
  Converter(std::string_view text, Origin origin) : origin_(origin) {
    while (true) {
      const std::size_t end = text.find('\n');
      lines_.push_back(text.substr(0, end));
      if (end == std::string_view::npos) break;
      text.remove_prefix(end + 1);
    }
  }

  Value operator()(const toml::node& node) const {
    Value value;
    value.place = place_of(node.source(), origin_);
    switch (node.type()) {
      case toml::node_type::table:
        value.kind = Value::Kind::table;
        for (const auto& [key, child] : *node.as_table()) {
          value.members.push_back(
              {std::string(key.str()), place_of(key.source(), origin_), (*this)(child)});
        }
        break;
      case toml::node_type::array:
        value.kind = Value::Kind::list;
        for (const toml::node& child : *node.as_array()) value.items.push_back((*this)(child));
        break;
      case toml::node_type::string:
        value.kind = Value::Kind::string;
        value.text = node.as_string()->get();
        break;
      case toml::node_type::integer:
        value.kind = Value::Kind::integer;
        value.integer = node.as_integer()->get();
        value.text = fmt::format("{}", value.integer);
        break;
      case toml::node_type::floating_point:
        value.kind = Value::Kind::number;
        value.text = written(node.source());
        break;
      case toml::node_type::boolean:
        value.kind = Value::Kind::boolean;
        value.boolean = node.as_boolean()->get();
        break;
      default:
        value.kind = Value::Kind::date;
        break;
    }
    return value;
  }

 private:
  // The library's own conversion follows the caller's rounding mode; ours starts from the digits.
  std::string written(const toml::source_region& region) const {
    const std::string_view line = lines_[region.begin.line - 1];
    // Columns count characters; a continuation byte of UTF-8 is none.
    std::size_t at = 0;
    for (std::size_t column = 1; column < region.begin.column || is_continuation(line, at); ++at) {
      column += is_continuation(line, at) ? 0 : 1;
    }
    return std::string(line.substr(at, region.end.column - region.begin.column));
  }
  static bool is_continuation(std::string_view line, std::size_t at) {
    return at < line.size() && (static_cast<unsigned char>(line[at]) & 0xC0) == 0x80;
  }

  Origin origin_;
  std::vector<std::string_view> lines_;
};

Value* step_into(Value& at, std::string_view key, const Place& key_place, std::string_view done,
                 Mistakes& mistakes) {
  if (at.kind == Value::Kind::list) {
    std::size_t index = 0;
    const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), index);
    const bool is_index = error == std::errc{} && end == key.data() + key.size();
    if (is_index && index < at.items.size()) return &at.items[index];
    mistakes.add(
        key_place, fmt::format("\"{}\" has no entry {}", done, key),
        at.items.empty() ? "it is empty" : fmt::format("it has 0 to {}", at.items.size() - 1));
    return nullptr;
  }
  if (at.kind != Value::Kind::table) {
    mistakes.add(key_place, fmt::format("\"{}\" is {}: it has no keys", done, name(at.kind)));
    return nullptr;
  }
  if (Value* found = at.find(key)) return found;
  Value table;
  table.place = key_place;
  at.members.push_back({std::string(key), key_place, std::move(table)});
  return &at.members.back().value;
}

std::optional<Value> override_value(std::string_view text, Origin origin) {
  constexpr std::string_view prefix = "v=";
  const std::string line = std::string(prefix) + std::string(text);
  origin.shift -= static_cast<int>(prefix.size());
  try {
    const toml::table parsed = toml::parse(line);
    if (parsed.size() == 1) return Converter(line, origin)(*parsed.get("v"));
  } catch (const toml::parse_error&) {  // not TOML: a string whose quotes the shell has taken
  }
  return std::nullopt;
}

int characters(std::string_view text) {
  return static_cast<int>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
  }));
}

// The path of a key without the indices of lists: "emitter.0" is "emitter".
std::string joined(std::string_view section, std::string_view key) {
  return section.empty() ? std::string(key) : fmt::format("{}.{}", section, key);
}

// What the file says in place of a key. Another override is left, to be refused.
void remove_rivals(Value& table, std::string_view key, const Rivals& rivals) {
  std::erase_if(table.members, [&](const Member& member) {
    return member.key != key && member.key_place.source == 0 &&
           std::find(rivals.keys.begin(), rivals.keys.end(), member.key) != rivals.keys.end();
  });
}

void apply(Value& root, std::string_view argument, int source, std::span<const Rivals> rivals,
           Mistakes& mistakes) {
  const std::size_t equals = argument.find('=');
  const Place whole{source, 1, 1, std::max(characters(argument), 1)};
  if (equals == std::string_view::npos || equals == 0) {
    mistakes.add(whole, "an override is a key, = and a value",
                 "such as time.duration=2 or emitter.0.count=10");
    return;
  }
  const std::string_view path = argument.substr(0, equals);
  const std::string_view text = argument.substr(equals + 1);
  Value* at = &root;
  std::string section;
  for (std::size_t first = 0; first <= path.size();) {
    const std::size_t last = std::min(path.find('.', first), path.size());
    const std::string_view key = path.substr(first, last - first);
    const Place key_place{source, 1, characters(path.substr(0, first)) + 1,
                          std::max(characters(key), 1)};
    if (key.empty()) {
      mistakes.add(key_place, "a key is missing", "keys are joined by single dots");
      return;
    }
    if (at->kind == Value::Kind::table) {
      if (const Rivals* group = rivals_of(rivals, section, key)) remove_rivals(*at, key, *group);
      section = joined(section, key);
    }
    at = step_into(*at, key, key_place, path.substr(0, first == 0 ? 0 : first - 1), mistakes);
    if (!at) return;
    first = last + 1;
  }
  const int shift = characters(argument.substr(0, equals + 1));
  const Place value_place{source, 1, shift + 1, std::max(characters(text), 1)};
  if (std::optional<Value> value = override_value(text, {source, shift})) {
    *at = std::move(*value);
  } else {
    *at = Value();
    at->kind = Value::Kind::string;
    at->text = text;
    at->place = value_place;
  }
  at->typed = text;
}

}  // namespace

const Value* Value::find(std::string_view key) const {
  const auto found = std::find_if(members.begin(), members.end(),
                                  [&](const Member& member) { return member.key == key; });
  return found == members.end() ? nullptr : &found->value;
}

Value* Value::find(std::string_view key) {
  return const_cast<Value*>(static_cast<const Value*>(this)->find(key));
}

const Rivals* rivals_of(std::span<const Rivals> groups, std::string_view section,
                        std::string_view key) {
  for (const Rivals& group : groups) {
    if (group.section == section &&
        std::find(group.keys.begin(), group.keys.end(), key) != group.keys.end()) {
      return &group;
    }
  }
  return nullptr;
}

std::string_view name(Value::Kind kind) {
  switch (kind) {
    case Value::Kind::boolean:
      return "true or false";
    case Value::Kind::integer:
      return "a whole number";
    case Value::Kind::number:
      return "a number";
    case Value::Kind::string:
      return "a string";
    case Value::Kind::date:
      return "a date";
    case Value::Kind::list:
      return "a list";
    case Value::Kind::table:
      return "a table";
  }
  return "";
}

const Value& deepest(const Value& root, std::string_view path) {
  const Value* at = &root;
  while (!path.empty()) {
    const std::size_t end = std::min(path.find('.'), path.size());
    const std::string_view key = path.substr(0, end);
    const Value* next = nullptr;
    if (at->kind == Value::Kind::list) {
      std::size_t index = at->items.size();
      std::from_chars(key.data(), key.data() + key.size(), index);
      if (index < at->items.size()) next = &at->items[index];
    } else {
      next = at->find(key);
    }
    if (!next) break;
    at = next;
    path.remove_prefix(std::min(end + 1, path.size()));
  }
  return *at;
}

std::optional<Value> read_document(std::string_view text, const std::vector<std::string>& overrides,
                                   std::span<const Rivals> rivals, Mistakes& mistakes) {
  Value root;
  try {
    root = Converter(text, {})(toml::parse(text));
  } catch (const toml::parse_error& error) {
    std::string problem(error.description());
    constexpr std::string_view opening = "Error while parsing ";
    if (problem.starts_with(opening)) problem.erase(0, opening.size());
    mistakes.add(place_of(error.source(), {}), "not TOML: in " + problem);
    return std::nullopt;
  }
  root.place = {};  // the file as a whole
  for (std::size_t i = 0; i < overrides.size(); ++i) {
    apply(root, overrides[i], static_cast<int>(i) + 1, rivals, mistakes);
  }
  return root;
}

}  // namespace salvo::scene
