// A sweep in a folder: a file a part, one file that shows them all, statistics.json and run.json.
// Parts that are there and intact are kept when a sweep goes on, is extended or is put together
// from shards.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "recording/ownership.hpp"
#include "recording/run_report.hpp"
#include "recording/sweep_part.hpp"
#include "scene/sweep_scene.hpp"

namespace salvo::recording {

struct SweepOptions {
  std::vector<std::string> command_line;
  solver::Execution execution;
  bool resume = false;     ///< keep intact parts of these rows
  bool overwrite = false;  ///< replace another scene's recording, or a longer one
  /// The run is that of a shard: parts [first, second). Those of other shards stay.
  std::optional<std::pair<std::uint64_t, std::uint64_t>> shard;
};

struct PartDigest {
  std::uint64_t first = 0;
  std::uint64_t rows = 0;
  solver::Digest hash;
};

/// Of the parts from the first row on, in order.
solver::Digest sweep_hash(const std::vector<PartDigest>& parts);

/// Throws LongerRecording when the directory holds rows of the scene of this digest after the first
/// `rows`.
void check_length(const std::filesystem::path& directory, const solver::Digest& scene,
                  std::uint64_t rows);

class SweepRecording {
 public:
  /// Creates the folder and run.json. Throws OutputError, ForeignRecording, LongerRecording.
  SweepRecording(std::filesystem::path directory, const scene::SweepScene& scene,
                 const solver::Sweep& sweep, SweepOptions options);

  /// The part of these rows when it is there and intact.
  std::optional<PartDigest> kept(std::uint64_t part, std::uint64_t rows) const;
  PartDigest write(std::uint64_t part, const solver::SweepRows& rows);
  /// Reads columns of parts that were kept or written; rows whose outcome the scene counts.
  solver::ColumnSource counted_columns(const std::vector<PartDigest>& parts) const;
  /// Rows by outcome.
  std::vector<std::uint64_t> outcome_counts(const std::vector<PartDigest>& parts) const;

  /// Writes the file that shows the parts, and says so in run.json. When it is done and no shard,
  /// it removes parts after them; throws LongerRecording rather than remove rows that it was to
  /// keep.
  void finish(RunStatus status, const std::vector<PartDigest>& parts, const std::string& statistics,
              double seconds, const std::string& reason = {});
  std::uint64_t bytes_written() const { return bytes_written_; }

 private:
  void remove_replaced() const;
  void write_index(const std::vector<PartDigest>& parts) const;
  void write_report(RunStatus status, const std::vector<PartDigest>& parts, double seconds,
                    const std::string& reason) const;
  std::filesystem::path part_path(std::uint64_t part) const;

  std::filesystem::path directory_;
  const scene::SweepScene& scene_;
  const solver::Sweep& sweep_;
  SweepOptions options_;
  std::unique_ptr<DirectoryLock> lock_;
  std::string started_;
  std::atomic<std::uint64_t> bytes_written_ = 0;
  std::atomic<std::uint64_t> rows_written_ = 0;
};

}  // namespace salvo::recording
