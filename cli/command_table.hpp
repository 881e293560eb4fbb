// The commands and options of salvo: the one list that drives parsing, help and suggestions.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cli/options.hpp"

namespace salvo::cli {

struct OptionEntry {
  std::string_view name;        ///< "--threads"
  std::string_view short_name;  ///< "-q", or empty
  std::string_view value;       ///< what follows it, "N"; empty for a flag
  std::string_view help;
  bool repeats = false;
};

struct CommandEntry {
  Verb verb;
  std::string_view name;
  std::string_view operands;  ///< "SCENE", "SCENE...", "[SCENE]", "DIR"
  std::string_view summary;
  std::string_view description;  ///< of its own help
  std::vector<OptionEntry> options;
  std::string_view examples;

  bool takes_many() const { return operands.ends_with("..."); }
  bool needs_operand() const { return !operands.starts_with("["); }
};

std::span<const CommandEntry> commands();

std::string general_help();
std::string help_of(const CommandEntry& command);

}  // namespace salvo::cli
