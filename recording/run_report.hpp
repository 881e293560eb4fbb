// run.json: how a run was made and how it went. The only file of a recording that may differ
// between equal runs: the instruction set, threads, machine and timings are here and nowhere else.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/frame.hpp"
#include "scene/scene.hpp"
#include "scene/sweep_scene.hpp"
#include "solver/world.hpp"

namespace salvo::recording {

enum class RunStatus { running, done, interrupted, failed };

std::string_view name(RunStatus status);

struct RunReport {
  RunStatus status = RunStatus::running;
  std::string reason;  ///< why it failed or was interrupted
  std::vector<std::string> command_line;
  solver::Execution execution;
  std::string started;  ///< UTC, ISO 8601
  double wall_seconds = 0;
  double seconds_waited = 0;
  std::uint64_t bytes_written = 0;
  std::uint64_t frames = 0;
  std::uint64_t particle_steps = 0;
  std::optional<StateInfo> last;  ///< the state recorded last
  /// Up to there, since the run began or went on.
  solver::Removals left_domain;
  solver::Removals non_finite;
};

/// Writes DIRECTORY/run.json beside its target, then renames it. Throws OutputError.
void write_run_report(const std::filesystem::path& directory, const scene::Scene& scene,
                      const RunReport& report);

/// Of a sweep.
struct SweepReport {
  RunStatus status = RunStatus::running;
  std::string reason;
  std::vector<std::string> command_line;
  solver::Execution execution;
  std::string started;
  double wall_seconds = 0;
  std::uint64_t bytes_written = 0;
  std::uint64_t rows = 0;           ///< recorded
  std::uint64_t rows_computed = 0;  ///< of them those that were not there before
  std::optional<solver::Digest> hash;
};
void write_sweep_report(const std::filesystem::path& directory, const scene::SweepScene& scene,
                        const SweepReport& report);

/// Now, ISO 8601.
std::string utc_now();

/// What is known of the recording in a directory.
struct RecordedRun {
  std::string version;
  RunStatus status = RunStatus::running;
  std::string reason;
  std::string scene_path;
  solver::Digest scene_digest;
  std::int64_t step = 0;                     ///< the last recorded
  std::optional<solver::Digest> state_hash;  ///< there
  std::uint64_t rows = 0;                    ///< of a sweep
};

/// Reads DIRECTORY/run.json; nothing when there is none. Throws CorruptFile.
std::optional<RecordedRun> read_run_report(const std::filesystem::path& directory);

}  // namespace salvo::recording
