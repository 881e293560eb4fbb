#include "cli/options.hpp"

#include <CLI/CLI.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <map>

#include "cli/command_table.hpp"
#include "scene/nearest.hpp"

namespace salvo::cli {

namespace {

using Values = std::vector<std::string>;

// What CLI11 found, before any of it is given a meaning.
struct Found {
  const CommandEntry* command = nullptr;
  Values operands;
  std::map<std::string_view, Values> values;  // by the option's name
  std::map<std::string_view, std::size_t> counts;

  bool has(std::string_view name) const { return counts.contains(name); }
};

std::string in_quotes(std::string_view text) { return fmt::format("\"{}\"", text); }

const CommandEntry* command_named(std::string_view name) {
  for (const CommandEntry& command : commands()) {
    if (command.name == name) return &command;
  }
  return nullptr;
}

const OptionEntry* option_named(const CommandEntry& command, std::string_view name) {
  for (const OptionEntry& option : command.options) {
    if (option.name == name || option.short_name == name) return &option;
  }
  return nullptr;
}

std::string see_help(const CommandEntry* command = nullptr) {
  return command ? fmt::format("salvo {} --help lists its options", command->name)
                 : "salvo --help lists the commands";
}

std::string suggestion(std::string_view word, const std::vector<std::string_view>& candidates,
                       const std::string& otherwise) {
  const std::string meant = scene::did_you_mean(word, candidates);
  return meant.empty() ? otherwise : meant;
}

// "--" ends the options and is none.
bool is_option(std::string_view word) { return word.size() > 1 && word[0] == '-' && word != "--"; }

// The first word that no command claims: an option in front of the command, a file without one, or
// a typing mistake.
[[noreturn]] void refuse_command(const Values& extras, const CommandEntry* parsed) {
  const std::string word = extras.front().substr(0, extras.front().find('='));
  if (is_option(word)) {
    for (const CommandEntry& command : commands()) {
      if ((parsed && parsed != &command) || !option_named(command, word)) continue;
      throw UsageError(
          fmt::format("{} stands in front of the command", word),
          fmt::format("write: salvo {} {} {} ...", command.name, command.operands, word));
    }
    throw UsageError(fmt::format("unknown option {}", in_quotes(word)),
                     suggestion(word, {"--help", "--version"}, see_help()));
  }
  std::vector<std::string_view> names{"help"};
  for (const CommandEntry& command : commands()) names.push_back(command.name);
  std::string hint = suggestion(word, names, see_help());
  if (word.ends_with(".toml")) hint = fmt::format("did you mean: salvo run {}?", word);
  throw UsageError(fmt::format("unknown command {}", in_quotes(word)), hint);
}

[[noreturn]] void refuse_extra(const Values& extras, const CommandEntry& command) {
  const auto option = std::find_if(extras.begin(), extras.end(), is_option);
  if (option != extras.end()) {
    const std::string name = option->substr(0, option->find('='));
    std::vector<std::string_view> names;
    for (const OptionEntry& entry : command.options) names.push_back(entry.name);
    throw UsageError(fmt::format("unknown option {} of salvo {}", in_quotes(name), command.name),
                     suggestion(name, names, see_help(&command)));
  }
  const std::string& word = extras.front();
  std::string hint = fmt::format("usage: salvo {} {} [OPTIONS]", command.name, command.operands);
  if (word.find('=') != std::string::npos && option_named(command, "--set")) {
    hint = fmt::format("did you mean --set {}? Each change has a --set of its own", word);
  }
  throw UsageError(fmt::format("unexpected argument {}", in_quotes(word)), hint);
}

[[noreturn]] void refuse_missing_value(const CommandEntry& command, std::string_view name) {
  const OptionEntry* option = option_named(command, name);
  throw UsageError(fmt::format("{} needs a value", name),
                   option ? fmt::format("{} {}: {}", option->name, option->value, option->help)
                          : see_help(&command));
}

void add_options(CLI::App& app, const CommandEntry& command) {
  app.set_help_flag("");
  app.allow_extras();
  for (const OptionEntry& option : command.options) {
    std::string names(option.name);
    if (!option.short_name.empty()) names += fmt::format(",{}", option.short_name);
    if (option.value.empty()) {
      app.add_flag(names)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    } else {
      app.add_option(names)->type_size(1)->expected(1)->take_all()->allow_extra_args(false);
    }
  }
  app.add_option("operands")->type_size(1)->expected(1, 1 << 20)->take_all()->allow_extra_args();
}

Found split(int argc, const char* const* argv) {
  CLI::App app;
  app.set_help_flag("");
  app.allow_extras();
  app.require_subcommand(0, 1);
  CLI::Option* help = app.add_flag("-h,--help");
  CLI::Option* version = app.add_flag("--version");
  std::map<const CLI::App*, const CommandEntry*> entries;
  for (const CommandEntry& command : commands()) {
    CLI::App* child = app.add_subcommand(std::string(command.name));
    add_options(*child, command);
    entries[child] = &command;
  }
  CLI::App* help_verb = app.add_subcommand("help");
  help_verb->set_help_flag("");
  help_verb->allow_extras();

  Found found;
  const auto parsed_command = [&]() -> const CommandEntry* {
    const auto parsed = app.get_subcommands();
    return parsed.empty() || parsed[0] == help_verb ? nullptr : entries.at(parsed[0]);
  };
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // The one mistake left to CLI11 to find; its text begins with the option's name.
    const std::string text = error.what();
    const CommandEntry* command = parsed_command();
    if (!command) throw UsageError("the command line cannot be read", see_help());
    refuse_missing_value(*command, text.substr(0, text.find(':')));
  }

  found.command = parsed_command();
  if (help->count() > 0) found.counts["--help"] = 1;
  if (version->count() > 0) found.counts["--version"] = 1;
  if (help_verb->parsed()) {
    found.counts["--help"] = 1;
    const Values words = help_verb->remaining();
    if (!words.empty() && !(found.command = command_named(words[0])))
      refuse_command(words, nullptr);
    return found;
  }
  if (const Values extras = app.remaining(); !extras.empty()) refuse_command(extras, found.command);
  if (!found.command) return found;
  const CLI::App& child = *app.get_subcommands()[0];
  for (const OptionEntry& option : found.command->options) {
    const CLI::Option* parsed = child.get_option(std::string(option.name));
    if (parsed->count() == 0) continue;
    found.counts[option.name] = parsed->count();
    const Values& values = parsed->results();
    if (option.value.empty()) {
      if (std::count(values.begin(), values.end(), "true") != std::ssize(values)) {
        throw UsageError(fmt::format("{} takes no value", option.name));
      }
      continue;
    }
    // CLI11 takes whatever follows an option as its value, another option too.
    for (const std::string& value : values) {
      if (value.starts_with("--") && option_named(*found.command, value)) {
        refuse_missing_value(*found.command, option.name);
      }
    }
    if (!option.repeats && values.size() > 1) {
      throw UsageError(fmt::format("{} is given {} times", option.name, values.size()),
                       "give it once");
    }
    found.values[option.name] = values;
  }
  found.operands = child.get_option("operands")->results();
  Values extras = child.remaining();
  std::erase(extras, "--");
  if (!extras.empty()) refuse_extra(extras, *found.command);
  return found;
}

// The words of an option that takes a list: separated by commas, in one value or several.
Values words_of(const Found& found, std::string_view name) {
  Values words;
  const auto given = found.values.find(name);
  if (given == found.values.end()) return words;
  for (const std::string& value : given->second) {
    std::size_t first = 0;
    while (first <= value.size()) {
      const std::size_t comma = std::min(value.find(',', first), value.size());
      if (comma == first) {
        throw UsageError(fmt::format("{} {}: an empty entry", name, in_quotes(value)),
                         "separate the entries by single commas");
      }
      words.push_back(value.substr(first, comma - first));
      first = comma + 1;
    }
  }
  return words;
}

std::int64_t whole_number(std::string_view option, const std::string& word, std::int64_t lowest,
                          std::int64_t highest) {
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (error != std::errc() || end != word.data() + word.size() || number < lowest ||
      number > highest) {
    throw UsageError(
        fmt::format("{} {}: expected a whole number from {} to {}", option, word, lowest, highest));
  }
  return number;
}

// "2/8" is the second of eight.
std::pair<std::uint64_t, std::uint64_t> shard_of(const std::string& word) {
  const std::size_t slash = word.find('/');
  if (slash == std::string::npos) {
    throw UsageError(fmt::format("--shard {}: expected i/n", word), "such as 1/4, to 4/4");
  }
  const std::int64_t shards = whole_number("--shard", word.substr(slash + 1), 1, 1'000'000);
  const std::int64_t shard = whole_number("--shard", word.substr(0, slash), 1, shards);
  return {static_cast<std::uint64_t>(shard), static_cast<std::uint64_t>(shards)};
}

solver::Isa isa_of(const std::string& word) {
  std::vector<std::string_view> names;
  for (const solver::Isa isa : solver::available_isas()) names.push_back(solver::name(isa));
  const std::string has = fmt::format("This machine runs {}", fmt::join(names, ", "));
  const std::optional<solver::Isa> isa = solver::isa_named(word);
  if (!isa) {
    const std::string meant = scene::did_you_mean(word, names);
    throw UsageError(fmt::format("unknown instruction set {}", in_quotes(word)),
                     meant.empty() ? has : fmt::format("{} {}", meant, has));
  }
  if (std::find(names.begin(), names.end(), word) == names.end()) {
    throw UsageError(fmt::format("this machine cannot run {} kernels", word), has);
  }
  return *isa;
}

recording::ExportFormat format_of(const std::string& word) {
  const auto& formats = recording::export_formats;
  const auto found = std::find(formats.begin(), formats.end(), word);
  if (found != formats.end()) {
    return static_cast<recording::ExportFormat>(found - formats.begin());
  }
  const std::string meant = scene::did_you_mean(word, formats);
  throw UsageError(fmt::format("unknown format {}", in_quotes(word)),
                   meant.empty() ? "the formats are csv, npy and ply" : meant);
}

void refuse_lists(const Options& options) {
  const auto check = [](std::string_view name, std::size_t entries) {
    if (entries > 1) {
      throw UsageError(fmt::format("{} has {} entries", name, entries),
                       "a list is for salvo verify; here it takes one");
    }
  };
  check("--isa", options.isas.size());
  check("--threads", options.threads.size());
  check("--pass", options.passes.size());
}

// Without a scene there is nothing to change, and the keys are those of every scene.
void check_info(const Options& options) {
  if (options.verb != Verb::info) return;
  if (options.keys && !options.inputs.empty()) {
    throw UsageError("--keys lists the keys of every scene", "leave out the scene, or --keys");
  }
  if (options.inputs.empty() && !options.overrides.empty()) {
    throw UsageError("--set changes a scene, and none is given",
                     "name it: salvo info SCENE --set ...");
  }
}

void check_operands(const Found& found) {
  const CommandEntry& command = *found.command;
  if (found.operands.empty() && command.needs_operand()) {
    const bool recording = command.verb == Verb::export_frames || command.verb == Verb::merge;
    throw UsageError(
        fmt::format("salvo {} needs a {}", command.name, recording ? "recording" : "scene"),
        fmt::format("for example: salvo {} {}{}", command.name,
                    recording ? "out/explosion" : "scenes/explosion.toml",
                    recording ? " --format csv" : ""));
  }
  if (!command.takes_many() && found.operands.size() > 1) {
    refuse_extra({found.operands.begin() + 1, found.operands.end()}, command);
  }
}

}  // namespace

solver::Execution Options::execution() const {
  solver::Execution execution;
  if (!isas.empty()) execution.isa = isas.front();
  if (!threads.empty()) execution.threads = threads.front();
  if (!passes.empty()) execution.pass_steps = passes.front();
  return execution;
}

Options parse(int argc, const char* const* argv) {
  const Found found = split(argc, argv);
  Options options;
  options.command_line.assign(argv, argv + argc);
  if (found.has("--help") || (!found.command && !found.has("--version"))) {
    options.help_text = found.command ? help_of(*found.command) : general_help();
    return options;
  }
  if (found.has("--version")) {
    options.verb = Verb::version;
    return options;
  }
  check_operands(found);
  options.verb = found.command->verb;
  options.inputs = found.operands;
  if (const auto given = found.values.find("--set"); given != found.values.end()) {
    for (const std::string& change : given->second) {
      if (change.find('=') == std::string::npos || change.front() == '=') {
        throw UsageError(fmt::format("--set {}: expected KEY=VALUE", change),
                         "for example: --set time.dt=1e-3");
      }
    }
    options.overrides = given->second;
  }
  for (const std::string& word : words_of(found, "--isa")) options.isas.push_back(isa_of(word));
  for (const std::string& word : words_of(found, "--threads")) {
    options.threads.push_back(static_cast<int>(whole_number("--threads", word, 1, 1024)));
  }
  for (const std::string& word : words_of(found, "--pass")) {
    options.passes.push_back(static_cast<std::int32_t>(whole_number("--pass", word, 1, 65536)));
  }
  if (options.verb != Verb::verify) refuse_lists(options);
  if (const auto given = found.values.find("--out"); given != found.values.end()) {
    if (given->second[0].empty()) refuse_missing_value(*found.command, "--out");
    options.out = given->second[0];
  }
  if (const auto given = found.values.find("--frame"); given != found.values.end()) {
    options.frame = whole_number("--frame", given->second[0], 0, 999'999'999);
  }
  if (const auto given = found.values.find("--format"); given != found.values.end()) {
    options.format = format_of(given->second[0]);
  } else if (options.verb == Verb::export_frames) {
    throw UsageError("salvo export needs a --format", "the formats are csv, npy and ply");
  }
  if (const auto given = found.values.find("--index"); given != found.values.end()) {
    options.index =
        static_cast<std::uint64_t>(whole_number("--index", given->second[0], 0, 1LL << 40));
  }
  if (const auto given = found.values.find("--shard"); given != found.values.end()) {
    options.shard = shard_of(given->second[0]);
  }
  options.columns = words_of(found, "--columns");
  options.resume = found.has("--resume");
  options.force = found.has("--force");
  if (options.resume && options.force) {
    throw UsageError("--resume keeps what --force replaces", "give one of them");
  }
  if (options.index && (options.shard || options.resume || options.out)) {
    throw UsageError("--index runs one row and records nothing",
                     "leave out --out, --resume and --shard");
  }
  options.json = found.has("--json");
  options.quiet = found.has("--quiet");
  options.full = found.has("--full");
  options.keys = found.has("--keys");
  options.profile = found.has("--profile");
  check_info(options);
  return options;
}

}  // namespace salvo::cli
