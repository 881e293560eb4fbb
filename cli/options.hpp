// The command line: what the user asks for, checked. CLI11 splits the arguments; the words are
// ours, because its own messages mislead ("A subcommand is required" for a mistyped command) and
// suggest nothing.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/exit_status.hpp"
#include "recording/export.hpp"
#include "solver/world.hpp"

namespace salvo::cli {

enum class Verb { help, version, run, verify, validate, info, hash, export_frames, merge };

struct Options {
  Verb verb = Verb::help;
  std::string help_text;                  ///< of Verb::help
  std::vector<std::string> command_line;  ///< as given
  std::vector<std::string> inputs;        ///< scenes; for an export the recording
  std::vector<std::string> overrides;     ///< "key=value"

  std::vector<solver::Isa> isas;
  std::vector<int> threads;
  std::vector<std::int32_t> passes;

  std::optional<std::filesystem::path> out;
  bool resume = false;
  bool force = false;
  bool json = false;
  bool quiet = false;
  bool full = false;     ///< verify the scene at its own size
  bool profile = false;  ///< say where the time of a run went
  bool keys = false;     ///< list the keys of a scene
  recording::ExportFormat format = recording::ExportFormat::csv;
  std::optional<std::int64_t> frame;
  std::optional<std::uint64_t> index;                            ///< of one row of a sweep
  std::optional<std::pair<std::uint64_t, std::uint64_t>> shard;  ///< i of n, from 1
  std::vector<std::string> columns;

  /// For the commands that take one value of each.
  solver::Execution execution() const;
};

/// Throws UsageError.
Options parse(int argc, const char* const* argv);

}  // namespace salvo::cli
