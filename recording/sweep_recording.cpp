#include "recording/sweep_recording.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "recording/directory.hpp"
#include "recording/field_dataset.hpp"
#include "recording/output_file.hpp"
#include "recording/sealed_file.hpp"
#include "recording/sweep_conventions.hpp"
#include "scene/words.hpp"

namespace salvo::recording {

using solver::Sweep;

solver::Digest sweep_hash(const std::vector<PartDigest>& parts) {
  std::vector<std::uint64_t> words;
  for (const PartDigest& part : parts) {
    words.insert(words.end(), {part.first, part.rows, part.hash.high, part.hash.low});
  }
  return solver::digest_of(words.data(), words.size() * sizeof(std::uint64_t));
}

void check_length(const std::filesystem::path& directory, const solver::Digest& scene,
                  std::uint64_t rows) {
  std::vector<NumberedFile> parts = list_parts(directory);
  std::reverse(parts.begin(), parts.end());
  for (const NumberedFile& part : parts) {
    try {
      const PartInfo info = read_part_info(part.path);
      if (info.row_digest != scene) continue;
      if (info.first + info.rows <= rows) return;
      throw LongerRecording(fmt::format(
          "{} holds rows of this sweep up to row {}, more than the {} that are asked for",
          directory.string(), info.first + info.rows - 1, rows));
    } catch (const CorruptFile&) {  // holds no rows
    }
  }
}

SweepRecording::SweepRecording(std::filesystem::path directory, const scene::SweepScene& scene,
                               const Sweep& sweep, SweepOptions options)
    : directory_(std::move(directory)),
      scene_(scene),
      sweep_(sweep),
      options_(std::move(options)),
      started_(utc_now()) {
  ensure_directory(directory_);
  lock_ = std::make_unique<DirectoryLock>(directory_);
  if (!options_.overwrite) {
    const solver::Digest digest = scene::row_digest(scene_);
    check_ownership(directory_, digest);
    if (options_.resume || options_.shard) check_length(directory_, digest, sweep_.rows());
  }
  remove_partial_files(directory_);
  remove_replaced();
  write_report(RunStatus::running, {}, 0, {});
}

// What this run does not go on from: all of another scene's recording; of this scene's the rows
// that are computed anew, and what is told of all rows.
void SweepRecording::remove_replaced() const {
  const bool foreign =
      options_.overwrite && recorded_scene(directory_) != scene::row_digest(scene_);
  if (options_.resume && !foreign) return;
  std::vector<std::filesystem::path> kept;
  if (options_.shard && !foreign) {
    const auto [first, end] = *options_.shard;
    for (const NumberedFile& part : list_parts(directory_)) {
      const auto number = static_cast<std::uint64_t>(part.number);
      if (number < first || number >= end) kept.push_back(part.path);
    }
  }
  for (const std::filesystem::path& file : recording_files(directory_)) {
    if (std::find(kept.begin(), kept.end(), file) == kept.end()) remove_file(file);
  }
}

std::filesystem::path SweepRecording::part_path(std::uint64_t part) const {
  return directory_ / part_name(static_cast<std::int64_t>(part));
}

std::optional<PartDigest> SweepRecording::kept(std::uint64_t part, std::uint64_t rows) const {
  const std::filesystem::path path = part_path(part);
  if (!options_.resume || !std::filesystem::exists(path)) return std::nullopt;
  try {
    const PartInfo info = read_part_info(path);
    const bool same = info.row_digest == scene::row_digest(scene_) &&
                      info.first == part * Sweep::part_rows && info.rows == rows;
    if (same) return PartDigest{info.first, info.rows, info.hash};
  } catch (const CorruptFile&) {  // is computed again
  }
  return std::nullopt;
}

PartDigest SweepRecording::write(std::uint64_t part, const solver::SweepRows& rows) {
  const solver::Digest hash = rows.hash(solver::Parallel(1));
  const std::filesystem::path path = part_path(part);
  write_part(path, scene_, sweep_, rows, hash);
  bytes_written_ += std::filesystem::file_size(path);
  rows_written_ += rows.table.rows();
  return {part * Sweep::part_rows, rows.table.rows(), hash};
}

solver::ColumnSource SweepRecording::counted_columns(const std::vector<PartDigest>& parts) const {
  return [this, parts](std::span<const std::size_t> columns, const solver::PartVisit& visit) {
    std::vector<std::string> names;
    for (const std::size_t column : columns) names.emplace_back(sweep_.fields()[column].name);
    for (const PartDigest& part : parts) {
      PartColumns read = read_part_columns(part_path(part.first / Sweep::part_rows), names);
      for (std::vector<double>& values : read.values) {
        std::size_t kept = 0;
        for (std::size_t row = 0; row < values.size(); ++row) {
          if (scene_.counted[read.outcome[row]]) values[kept++] = values[row];
        }
        values.resize(kept);
      }
      visit(read.values);
    }
  };
}

std::vector<std::uint64_t> SweepRecording::outcome_counts(
    const std::vector<PartDigest>& parts) const {
  std::vector<std::uint64_t> counts(sweep_.outcomes().size());
  for (const PartDigest& part : parts) {
    const PartColumns read = read_part_columns(part_path(part.first / Sweep::part_rows), {});
    for (const std::uint32_t outcome : read.outcome) ++counts[outcome];
  }
  return counts;
}

void SweepRecording::finish(RunStatus status, const std::vector<PartDigest>& parts,
                            const std::string& statistics, double seconds,
                            const std::string& reason) {
  const bool ends_there = status == RunStatus::done && !options_.shard && !parts.empty();
  if (ends_there && options_.resume) {
    check_length(directory_, scene::row_digest(scene_), parts.back().first + parts.back().rows);
  }
  if (!parts.empty()) write_index(parts);
  if (!statistics.empty()) write_file(directory_ / statistics_name, statistics);
  if (ends_there) {
    const std::uint64_t last = parts.back().first / Sweep::part_rows;
    for (const NumberedFile& part : list_parts(directory_)) {
      if (static_cast<std::uint64_t>(part.number) > last) remove_file(part.path);
    }
  }
  write_report(status, parts, seconds, reason);
}

// All parts as one file: HDF5 looks the rows up in theirs.
void SweepRecording::write_index(const std::vector<PartDigest>& parts) const {
  using hdf5::write_attribute;
  const hdf5::Session session;
  hdf5::MemoryFile file;
  std::vector<hdf5::VirtualPart> files;
  std::uint64_t rows = 0;
  for (const PartDigest& part : parts) {
    const auto number = static_cast<std::int64_t>(part.first / Sweep::part_rows);
    files.push_back({part_name(number), part.rows});
    rows += part.rows;
  }
  const auto add = [&](const std::string& path, const soa::Field& field, soa::Precision precision,
                       const hdf5::Extents& extents) {
    const std::size_t slash = path.rfind('/');
    const std::string group = path.substr(1, slash == 0 ? 0 : slash - 1);
    hdf5::Handle parent;
    if (!group.empty()) {
      const std::vector<std::string> groups = hdf5::names_in(file);
      const bool there = std::find(groups.begin(), groups.end(), group) != groups.end();
      parent = there ? hdf5::open_group(file, group) : hdf5::create_group(file, group);
    }
    const hdf5::Handle dataset = hdf5::create_virtual_dataset(
        group.empty() ? hid_t{file} : hid_t{parent}, path.substr(slash + 1),
        type_of(field.scalar, precision), extents, path, files);
    describe(dataset, field);
  };
  for (const soa::Field& field : sweep_.fields()) {
    add(dataset_path(field.name), field, scene_.setup.precision, {rows});
  }
  if (sweep_.levels() != 0) {
    const hdf5::Extents extents{rows, sweep_.levels()};
    add("/samples/time", sample_time_field(), soa::Precision::float64, extents);
    for (const soa::Field& field : sweep_.sample_fields()) {
      add("/samples/" + std::string(field.name), field, soa::Precision::float64, extents);
    }
  }
  write_conventions(file, scene_, sweep_);
  {
    const hdf5::Handle salvo = create_identity(file, scene_, sweep_);
    write_attribute(salvo, "rows", rows);
    write_attribute(salvo, "hash", std::string_view(to_string(sweep_hash(parts))));
    write_attribute(salvo, "model", scene_.model->name);
  }
  write_sealed(directory_ / trajectories_name, file.bytes(), Durability::process);
}

void SweepRecording::write_report(RunStatus status, const std::vector<PartDigest>& parts,
                                  double seconds, const std::string& reason) const {
  SweepReport report;
  report.status = status;
  report.reason = reason;
  report.command_line = options_.command_line;
  report.execution = options_.execution;
  report.started = started_;
  report.wall_seconds = seconds;
  report.bytes_written = bytes_written_;
  report.rows_computed = rows_written_;
  for (const PartDigest& part : parts) report.rows += part.rows;
  if (!parts.empty()) report.hash = sweep_hash(parts);
  write_sweep_report(directory_, scene_, report);
}

}  // namespace salvo::recording
