// salvo merge: the shards of a sweep become one recording.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>

#include "cli/sweep_verbs.hpp"
#include "cli/verbs.hpp"
#include "recording/directory.hpp"
#include "recording/output_file.hpp"
#include "recording/ownership.hpp"
#include "recording/sweep_part.hpp"
#include "scene/load_sweep.hpp"

namespace salvo::cli {

using solver::Sweep;

ExitStatus merge(const Options& options) {
  if (!options.out) throw UsageError("salvo merge needs --out DIR", "where the whole sweep goes");
  // The parts of all shards, by number; a shard's rows are those of its scene.
  std::map<std::uint64_t, std::filesystem::path> parts;
  std::optional<recording::PartInfo> first;
  for (const std::string& input : options.inputs) {
    const auto files = recording::list_parts(input);
    if (files.empty()) {
      throw Failure(ExitStatus::input_output, fmt::format("{} holds no rows of a sweep", input));
    }
    for (const recording::NumberedFile& file : files) {
      const recording::PartInfo info = recording::read_part_info(file.path);
      if (!first) first = info;
      if (!(info.row_digest == first->row_digest)) {
        throw Failure(ExitStatus::input_output,
                      fmt::format("{} is of another scene than {}", file.path.string(),
                                  parts.begin()->second.string()),
                      fmt::format("their digests are {} and {}", to_string(info.row_digest),
                                  to_string(first->row_digest)));
      }
      const auto [there, added] = parts.emplace(file.number, file.path);
      if (!added && !(recording::read_part_info(there->second).hash == info.hash)) {
        throw Failure(ExitStatus::difference,
                      fmt::format("{} and {} differ", there->second.string(), file.path.string()),
                      "the same rows have the same bits: one of the machines errs");
      }
    }
  }
  const scene::SweepScene scene =
      scene::parse_sweep(first->scene_text, first->scene_path, first->overrides);
  const Sweep sweep(scene.setup);
  const std::uint64_t wanted = (sweep.rows() + Sweep::part_rows - 1) / Sweep::part_rows;
  for (std::uint64_t part = 0; part < wanted; ++part) {
    if (parts.contains(part)) continue;
    throw Failure(ExitStatus::input_output,
                  fmt::format("rows {} to {} are in none of the folders", part * Sweep::part_rows,
                              std::min(sweep.rows(), (part + 1) * Sweep::part_rows) - 1),
                  "run the shard that is missing");
  }
  recording::ensure_directory(*options.out);
  if (!options.force) {
    try {
      recording::check_ownership(*options.out, scene::row_digest(scene));
    } catch (const recording::ForeignRecording& error) {
      throw Failure(ExitStatus::input_output, error.what(),
                    "--out merges elsewhere; --force replaces what is there");
    }
  }
  for (const auto& [part, path] : parts) {
    const std::filesystem::path target =
        *options.out / recording::part_name(static_cast<std::int64_t>(part));
    if (std::filesystem::exists(target) && std::filesystem::equivalent(path, target)) continue;
    recording::copy_file(path, target);
  }
  // All parts are there: what is left of a run is to look at them.
  Options rest = options;
  rest.resume = true;
  rest.force = false;
  return run_sweep(rest, scene);
}

}  // namespace salvo::cli
