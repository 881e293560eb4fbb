// salvo merge: the shards of a sweep become one recording.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <system_error>
#include <vector>

#include "cli/sweep_verbs.hpp"
#include "cli/text.hpp"
#include "cli/verbs.hpp"
#include "recording/directory.hpp"
#include "recording/output_file.hpp"
#include "recording/ownership.hpp"
#include "recording/sweep_part.hpp"
#include "recording/sweep_recording.hpp"
#include "scene/load_sweep.hpp"

namespace salvo::cli {

using solver::Sweep;

namespace {

namespace fs = std::filesystem;

struct Part {
  fs::path path;
  recording::PartInfo info;
};
// The parts of all shards, by number.
using Parts = std::map<std::uint64_t, Part>;

constexpr const char* one_number = "run the shards with one number of samples";

std::vector<recording::NumberedFile> parts_in(const fs::path& folder) {
  std::error_code error;
  const bool is_folder = fs::is_directory(folder, error);
  if (error) {
    throw Failure(ExitStatus::input_output,
                  fmt::format("cannot read {}: {}", folder.string(), error.message()));
  }
  std::vector<recording::NumberedFile> files;
  if (is_folder) files = recording::list_parts(folder);
  if (files.empty()) {
    throw Failure(ExitStatus::input_output,
                  fmt::format("{} {}", folder.string(),
                              is_folder ? "holds no rows of a sweep" : "is not a folder"));
  }
  return files;
}

void add(Parts& parts, const recording::NumberedFile& file) {
  Part part{file.path, recording::read_part_info(file.path)};
  if (!parts.empty()) {
    const Part& other = parts.begin()->second;
    if (part.info.row_digest != other.info.row_digest) {
      throw Failure(
          ExitStatus::input_output,
          fmt::format("{} is of another scene than {}", file.path.string(), other.path.string()),
          fmt::format("their digests are {} and {}", to_string(part.info.row_digest),
                      to_string(other.info.row_digest)));
    }
  }
  const auto found = parts.find(static_cast<std::uint64_t>(file.number));
  if (found == parts.end()) {
    parts.emplace(file.number, std::move(part));
    return;
  }
  const Part& there = found->second;
  if (there.info.rows != part.info.rows) {
    throw Failure(
        ExitStatus::input_output,
        fmt::format("{} holds {}, and {} {}: the shards have different numbers of samples",
                    there.path.string(), counted(there.info.rows, "row"), part.path.string(),
                    grouped(part.info.rows)),
        one_number);
  }
  if (there.info.hash != part.info.hash) {
    throw Failure(ExitStatus::difference,
                  fmt::format("{} and {} differ", there.path.string(), part.path.string()),
                  "the same rows have the same bits: one of the machines errs");
  }
}

// The last part knows the sweep at its longest: parts before it may be from before it was extended.
scene::SweepScene scene_of(const Parts& parts) {
  const auto& [path, info] = parts.rbegin()->second;
  scene::SweepScene scene = scene::parse_sweep(info.scene_text, info.scene_path, info.overrides);
  if (scene::row_digest(scene) != info.row_digest) {
    throw Failure(ExitStatus::input_output,
                  fmt::format("{} is not of the scene that it names, {}, as that is now",
                              path.string(), info.scene_path),
                  "most likely a table that the scene reads has changed since the shards ran");
  }
  return scene;
}

void require_all(const Parts& parts, const scene::SweepScene& scene, std::uint64_t rows) {
  for (std::uint64_t first = 0; first < rows; first += Sweep::part_rows) {
    const std::uint64_t count = std::min(Sweep::part_rows, rows - first);
    const auto part = parts.find(first / Sweep::part_rows);
    if (part == parts.end()) {
      throw Failure(
          ExitStatus::input_output,
          fmt::format("rows {} to {} are in none of the folders", first, first + count - 1),
          scene.stop ? "[stop] ended the sweep before them: its recording is whole as it "
                       "is, and shards have no [stop]"
                     : "run the shard that is missing");
    }
    const auto& [path, info] = part->second;
    if (info.first != first || info.rows != count) {
      throw Failure(
          ExitStatus::input_output,
          fmt::format("{} holds {} from row {} on, but a sweep of {} has {} from row {} on "
                      "there",
                      path.string(), counted(info.rows, "row"), info.first, grouped(rows),
                      grouped(count), first),
          one_number);
    }
  }
}

// Makes room for the parts. What is there and is an input stays.
void clear(const fs::path& directory, const Parts& parts) {
  for (const fs::path& file : recording::recording_files(directory)) {
    const bool is_input = std::any_of(parts.begin(), parts.end(), [&](const auto& part) {
      return fs::equivalent(file, part.second.path);
    });
    if (!is_input) recording::remove_file(file);
  }
}

void check_target(const fs::path& directory, const scene::SweepScene& scene, std::uint64_t rows) {
  const solver::Digest digest = scene::row_digest(scene);
  try {
    recording::check_ownership(directory, digest);
    recording::check_length(directory, digest, rows);
  } catch (const recording::RecordingError& error) {
    throw Failure(ExitStatus::input_output, error.what(),
                  "--out merges elsewhere; --force replaces what is there");
  }
}

}  // namespace

ExitStatus merge(const Options& options) {
  if (!options.out) throw UsageError("salvo merge needs --out DIR", "where the whole sweep goes");
  Parts parts;
  for (const std::string& input : options.inputs) {
    for (const recording::NumberedFile& file : parts_in(input)) add(parts, file);
  }
  const scene::SweepScene scene = scene_of(parts);
  const std::uint64_t rows = Sweep(scene.setup).rows();
  require_all(parts, scene, rows);
  recording::ensure_directory(*options.out);
  {
    const recording::DirectoryLock lock(*options.out);
    options.force ? clear(*options.out, parts) : check_target(*options.out, scene, rows);
    for (const auto& [number, part] : parts) {
      const fs::path target =
          *options.out / recording::part_name(static_cast<std::int64_t>(number));
      if (fs::exists(target) && fs::equivalent(part.path, target)) continue;
      recording::copy_file(part.path, target);
    }
  }
  // All parts are there: what is left of a run is to look at them.
  Options rest = options;
  rest.resume = true;
  rest.force = false;
  return run_sweep(rest, scene);
}

}  // namespace salvo::cli
