#include "scene/keys.hpp"

#include <cmath>

#include "scene/nearest.hpp"
#include "scene/units.hpp"

namespace salvo::scene {

namespace {

std::string with_unit(double value, std::string_view unit) {
  return fmt::format("{}{}{}", value, unit.empty() ? "" : " ", unit);
}

std::string words_text(const Words& words, std::string_view before) {
  std::string text(before);
  for (std::size_t i = 0; i < words.size(); ++i) {
    const char* joint = i == 0 ? "" : i + 1 == words.size() ? " or " : ", ";
    text += fmt::format("{}\"{}\"", joint, words[i].word);
  }
  return text;
}

std::vector<std::string_view> spellings(const Words& words) {
  std::vector<std::string_view> spelled;
  for (const Word& word : words) spelled.push_back(word.word);
  return spelled;
}

// The section, anywhere below `section`, that has a key of this name; nullptr when none or several
// do.
const SectionText* owner(const SectionText& section, std::string_view name, int& found) {
  const SectionText* owner_section = nullptr;
  for (const KeyText* key : section.keys()) {
    if (key->name == name && !key->section) {
      owner_section = &section;
      ++found;
    } else if (key->section) {
      if (const SectionText* below = owner(*key->section, name, found)) owner_section = below;
    }
  }
  return owner_section;
}

std::string upper_first(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 32);
  return text;
}

}  // namespace

std::string Bounds::text(std::string_view unit) const {
  const std::string low = with_unit(lowest, unit);
  const std::string high = with_unit(highest, unit);
  const char* over = above_lowest ? "more than " : "at least ";
  if (lowest == -largest_number) {
    return highest == largest_number ? "" : fmt::format("at most {}", high);
  }
  if (highest == largest_number) return over + low;
  return above_lowest ? fmt::format("{}{} and at most {}", over, low, high)
                      : fmt::format("{} to {}", lowest, high);
}

std::string SectionText::label() const {
  if (path_.empty()) return "the scene";
  return list_ ? fmt::format("[[{}]]", path_) : fmt::format("[{}]", path_);
}

std::string Reader::named(const KeyText& key) const {
  return fmt::format("\"{}\" in {}", key.name, section_->label());
}

void Reader::wrong_type(const Value& value, const KeyText& key, std::string_view expected) {
  fail(value, fmt::format("{} is {}", named(key), name(value.kind)),
       fmt::format("expected {}", expected));
}

bool Reader::in_bounds(const Value& value, const KeyText& key, double number) {
  if (key.bounds.contain(number)) return true;
  fail(value, named(key) + " is out of bounds",
       std::abs(number) > largest_number
           ? fmt::format("expected at most {}: no key takes a larger number", largest_number)
           : "expected " + key.bounds.text(key.stored));
  return false;
}

void Reader::read(const Value& value, const KeyText& key, double& out) {
  const bool is_number = value.kind == Value::Kind::integer || value.kind == Value::Kind::number;
  if (!is_number && value.kind != Value::Kind::string) {
    wrong_type(value, key,
               key.unit.empty() ? "a number" : dimension_name(key.unit) + " in " + key.unit);
    return;
  }
  try {
    const double number =
        is_number ? number_in(value.text, key.stored) : quantity(value.text, key.stored);
    if (in_bounds(value, key, number)) out = number;
  } catch (const UnitError& error) {
    fail(value, fmt::format("{}: {}", named(key), error.what()), error.hint());
  }
}

void Reader::read(const Value& value, const KeyText& key, bool& out) {
  if (value.kind == Value::Kind::boolean) {
    out = value.boolean;
  } else {
    wrong_type(value, key, "true or false");
  }
}

void Reader::read(const Value& value, const KeyText& key, std::string& out) {
  if (value.kind == Value::Kind::string) {
    out = value.text;
  } else if (value.typed) {
    out = *value.typed;
  } else {
    wrong_type(value, key, "a string");
  }
}

std::optional<std::int64_t> Reader::whole_number(const Value& value, const KeyText& key) {
  std::int64_t whole = value.integer;
  bool is_whole = value.kind == Value::Kind::integer;
  if (value.kind == Value::Kind::number) {  // 1e6 is a number in TOML
    double number = std::numeric_limits<double>::quiet_NaN();
    try {
      number = number_in(value.text, "");
    } catch (const UnitError&) {  // infinite or not a number: not whole either
    }
    is_whole = std::abs(number) <= 0x1p53 && std::trunc(number) == number;
    if (is_whole) whole = static_cast<std::int64_t>(number);
  }
  if (!is_whole) {
    wrong_type(value, key, "a whole number");
    return std::nullopt;
  }
  if (!in_bounds(value, key, static_cast<double>(whole))) return std::nullopt;
  return whole;
}

std::optional<int> Reader::word(const Value& value, const KeyText& key) {
  if (value.kind != Value::Kind::string) {
    wrong_type(value, key, words_text(key.words, ""));
    return std::nullopt;
  }
  for (const Word& entry : key.words) {
    if (entry.word == value.text) return entry.value;
  }
  const std::string near = did_you_mean(value.text, spellings(key.words));
  fail(value, fmt::format("{} is unknown: \"{}\"", named(key), value.text),
       near.empty() ? words_text(key.words, "expected ") : near);
  return std::nullopt;
}

bool Reader::is_list(const Value& value, const KeyText& key, std::size_t length) {
  if (value.kind != Value::Kind::list) {
    wrong_type(value, key, length == 0 ? "a list" : fmt::format("a list of {} numbers", length));
    return false;
  }
  if (length != 0 && value.items.size() != length) {
    fail(value, fmt::format("{} has length {}", named(key), value.items.size()),
         fmt::format("expected {} numbers", length));
    return false;
  }
  return true;
}

bool Reader::bound_pair(const Value& value, const KeyText& key, std::array<double, 2>& pair) {
  const std::size_t before = mistakes();
  read(value, key, pair);
  return mistakes() == before;
}

void Reader::read(const Value& value, const KeyText& key, solver::Spread& out) {
  using Kind = solver::Spread::Kind;
  constexpr std::string_view forms =
      "a number, { uniform = [low, high] } or { normal = [mean, deviation] }";
  if (value.kind == Value::Kind::list || value.kind == Value::Kind::boolean ||
      value.kind == Value::Kind::date) {
    wrong_type(value, key, forms);
    return;
  }
  if (value.kind != Value::Kind::table) {
    double number = out.a;
    read(value, key, number);
    out = {Kind::constant, number, 0};
    return;
  }
  if (value.members.size() != 1) {
    fail(value, fmt::format("{} has {} keys", named(key), value.members.size()),
         fmt::format("expected {}", forms));
    return;
  }
  const Member& member = value.members.front();
  std::array<double, 2> pair{};
  if (member.key == "uniform") {
    if (!bound_pair(member.value, key, pair)) return;
    if (pair[0] < pair[1]) {
      out = {Kind::uniform, pair[0], pair[1]};
    } else {
      fail(member.value, named(key) + " has no width", "expected [low, high], low below high");
    }
  } else if (member.key == "normal") {
    if (!bound_pair(member.value, key, pair)) return;
    if (pair[1] > 0) {
      out = {Kind::normal, pair[0], pair[1]};
    } else {
      fail(member.value, named(key) + " has no width",
           "expected [mean, deviation], a deviation of more than 0");
    }
  } else {
    const std::array<std::string_view, 2> words{"uniform", "normal"};
    const std::string near = did_you_mean(member.key, words);
    mistakes_->add(member.key_place,
                   fmt::format("unknown distribution \"{}\" of {}", member.key, named(key)),
                   near.empty() ? "expected uniform or normal" : near);
  }
}

namespace {

constexpr std::string_view input_forms =
    "a number, a list, { from = , to = , count = }, { uniform = [low, high] }, "
    "{ normal = [mean, deviation] } with or without within = [low, high], or { column = \"NAME\" }";

std::string keys_of(const Value& table) {
  std::string keys;
  for (const Member& member : table.members) keys += (keys.empty() ? "" : " ") + member.key;
  return keys;
}

}  // namespace

// What stands for a name has nothing between its values, and no distribution.
void Reader::read_words(const Value& value, const KeyText& key, solver::Variation& variation) {
  if (value.kind == Value::Kind::list && !value.items.empty()) {
    variation.kind = solver::Variation::Kind::grid;
    for (const Value& item : value.items) {
      if (const auto found = word(item, key)) variation.values.push_back(*found);
    }
  } else if (value.kind == Value::Kind::string) {
    if (const auto found = word(value, key)) variation = solver::Variation::of(*found);
  } else {
    fail(value, named(key) + " is no name", "expected one name or a list of them");
  }
}

void Reader::read(const Value& value, const KeyText& key, InputValue& out) {
  using Kind = solver::Variation::Kind;
  out.given = true;
  solver::Variation& variation = out.variation;
  const auto number = [&](const Value& from, double& to) { read(from, key, to); };
  if (!key.words.empty()) {
    read_words(value, key, variation);
  } else if (value.kind == Value::Kind::boolean || value.kind == Value::Kind::date) {
    wrong_type(value, key, input_forms);
  } else if (value.kind == Value::Kind::list) {
    variation.kind = Kind::grid;
    read(value, key, variation.values);
    if (value.items.empty()) fail(value, named(key) + " is empty", "expected at least one value");
  } else if (value.kind != Value::Kind::table) {
    number(value, variation.a);
  } else if (const std::string keys = keys_of(value); value.find("normal")) {
    std::array<double, 2> pair{};
    if (keys != "normal" && keys != "normal within") {
      fail(value, named(key) + " has other keys than normal and within",
           fmt::format("expected {}", input_forms));
      return;
    }
    // A deviation is a difference: it is not held to the bounds of the values.
    KeyText width = key;
    width.bounds = positive;
    const Value& given = *value.find("normal");
    if (!is_list(given, key, 2)) return;
    read(given.items[0], key, pair[0]);
    read(given.items[1], width, pair[1]);
    variation.kind = Kind::normal;
    variation.a = pair[0];
    variation.b = pair[1];
    // Beyond eight deviations lies one value of 10^15.
    if (!value.find("within") && (!key.bounds.contain(pair[0] - 8 * pair[1]) ||
                                  !key.bounds.contain(pair[0] + 8 * pair[1]))) {
      fail(given, named(key) + " would come out of its bounds",
           fmt::format("expected {} within 8 deviations of the mean; within = [low, high] holds it",
                       key.bounds.text(key.stored)));
    }
    if (const Value* within = value.find("within")) {
      if (!bound_pair(*within, key, pair)) return;
      variation.kind = Kind::truncated_normal;
      variation.lowest = pair[0];
      variation.highest = pair[1];
      if (!(pair[0] < pair[1])) {
        fail(*within, named(key) + " has no room", "expected [low, high], low below high");
      } else if (pair[0] > variation.a + 8 * variation.b ||
                 pair[1] < variation.a - 8 * variation.b) {
        fail(*within, named(key) + " is more than 8 deviations away from its mean",
             "expected an interval that values come to");
      }
    }
  } else if (keys == "uniform") {
    std::array<double, 2> pair{};
    if (!bound_pair(value.members.front().value, key, pair)) return;
    variation.kind = Kind::uniform;
    variation.a = pair[0];
    variation.b = pair[1];
    if (!(pair[0] < pair[1])) {
      fail(value, named(key) + " has no width", "expected [low, high], low below high");
    }
  } else if (keys == "column") {
    variation.kind = Kind::column;
    read(value.members.front().value, key, out.column);
  } else if (value.find("from") && value.find("to") && value.find("count") &&
             value.members.size() == 3) {
    std::array<double, 2> ends{};
    const std::size_t before = mistakes();
    number(*value.find("from"), ends[0]);
    number(*value.find("to"), ends[1]);
    KeyText whole;
    whole.name = "count";
    whole.bounds = between(2, 0x1p24);
    const auto count = whole_number(*value.find("count"), whole);
    if (mistakes() != before || !count) return;
    variation.kind = Kind::grid;
    for (std::int64_t i = 0; i < *count; ++i) {
      const double part = static_cast<double>(i) / static_cast<double>(*count - 1);
      variation.values.push_back(i == *count - 1 ? ends[1] : ends[0] + (ends[1] - ends[0]) * part);
    }
  } else {
    fail(value, named(key) + " varies in no known way", fmt::format("expected {}", input_forms));
  }
}

bool Reader::is_table(const Value& value, const KeyText& key) {
  if (value.kind == Value::Kind::table) return true;
  fail(value, fmt::format("\"{}\" is {}", key.name, name(value.kind)),
       fmt::format("expected the table {}", key.section->label()));
  return false;
}

bool Reader::is_list_of_tables(const Value& value, const KeyText& key) {
  const auto is_table = [](const Value& item) { return item.kind == Value::Kind::table; };
  if (value.kind == Value::Kind::list &&
      std::all_of(value.items.begin(), value.items.end(), is_table)) {
    return true;
  }
  fail(value, fmt::format("\"{}\" is {}", key.name, name(value.kind)),
       fmt::format("expected tables {}", key.section->label()));
  return false;
}

void Reader::unknown_key(const Member& member) {
  std::vector<std::string_view> names;
  for (const KeyText* key : section_->keys()) names.push_back(key->name);
  std::string hint = did_you_mean(member.key, names);
  int found = 0;
  const SectionText* elsewhere = owner(*scene_, member.key, found);
  if (found == 1) {
    hint = fmt::format("it belongs to {}", elsewhere->label());
  } else if (hint.empty()) {
    hint = "expected ";
    for (std::size_t i = 0; i < names.size(); ++i) {
      hint += fmt::format("{}{}", i == 0 ? "" : i + 1 == names.size() ? " or " : ", ", names[i]);
    }
  }
  mistakes_->add(member.key_place,
                 fmt::format("unknown key \"{}\" in {}", member.key, section_->label()), hint);
}

namespace {

std::string_view word_of(const KeyText& key, int value) {
  for (const Word& entry : key.words) {
    if (entry.value == value) return entry.word;
  }
  return {};
}

std::string kinds_text(const KeyText& decider, Kinds of) {
  Words some;
  for (const Word& entry : decider.words) {
    if ((of & kinds(entry.value)) != 0) some.push_back(entry);
  }
  return words_text(some, "");
}

}  // namespace

void Reader::misplaced_key(const Member& member, const KeyText& key, const KeyText& decider,
                           int kind) {
  mistakes_->add(member.key_place,
                 fmt::format("\"{}\" does not belong in {} with {} = \"{}\"", key.name,
                             section_->label(), decider.name, word_of(decider, kind)),
                 fmt::format("only with {} = {}", decider.name, kinds_text(decider, key.belongs)));
}

void Reader::missing_key(const Value& table, const KeyText& key) {
  if (key.section) {
    fail(table, fmt::format("missing {}", key.section->label()), key.section->meaning());
    return;
  }
  const std::string what = key.words.empty()
                               ? (key.unit.empty() ? key.type : key.type + " in " + key.unit)
                               : words_text(key.words, "");
  fail(table, fmt::format("missing key \"{}\" in {}", key.name, section_->label()),
       fmt::format("{}: {}", key.meaning, what));
}

std::string type_text(const double*) { return "number"; }
std::string type_text(const bool*) { return "true or false"; }
std::string type_text(const std::string*) { return "string"; }
std::string type_text(const solver::Spread*) { return "number or spread"; }
std::string type_text(const InputValue*) { return "input"; }
std::string type_text(const Later*) { return "value"; }

std::string default_text(double value, const Words&) { return fmt::format("{}", value); }
std::string default_text(bool value, const Words&) { return value ? "true" : "false"; }
std::string default_text(const std::string& value, const Words&) {
  return fmt::format("\"{}\"", value);
}
std::string default_text(const solver::Spread& value, const Words& words) {
  return default_text(value.a, words);
}

std::string default_text(const InputValue& value, const Words& words) {
  return default_text(value.variation.a, words);
}

namespace {

std::string table_cell(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) {
    text.insert(at, "\\");
  }
  return text;
}

std::string table_row(const KeyText& key, const KeyText& decider) {
  const std::string type = key.section ? fmt::format("`{}`", key.section->label()) : key.type;
  std::string meaning = key.section ? key.section->meaning() : key.meaning;
  if (key.belongs != every_kind) {
    meaning += fmt::format("; only with {}", kinds_text(decider, key.belongs));
  }
  return fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", key.name, type, key.unit,
                     key.required != 0 ? "required" : key.fallback, key.bounds.text(""),
                     table_cell(std::move(meaning)));
}

}  // namespace

std::string reference(const SectionText& section) {
  const std::vector<const KeyText*> keys = section.keys();
  std::string text = fmt::format(
      "### {}\n\n{}.\n\n| key | type | unit | default | bounds | meaning |\n"
      "|---|---|---|---|---|---|\n",
      section.path().empty() ? "The scene" : fmt::format("`{}`", section.label()),
      upper_first(section.meaning()));
  std::string words;
  std::string below;
  for (const KeyText* key : keys) {
    text += table_row(*key, *keys.front());
    if (key->section) below += fmt::format("\n{}", reference(*key->section));
    if (key->words.empty()) continue;
    words += fmt::format("\nWords of `{}`:\n\n", key->name);
    for (const Word& entry : key->words) {
      words += fmt::format("- `\"{}\"`{}{}\n", entry.word, entry.meaning.empty() ? "" : ": ",
                           entry.meaning);
    }
  }
  return text + words + below;
}

}  // namespace salvo::scene
