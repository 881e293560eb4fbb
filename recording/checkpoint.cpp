#include "recording/checkpoint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "recording/directory.hpp"
#include "recording/frame_reader.hpp"
#include "recording/ownership.hpp"
#include "soa/contact_fields.hpp"
#include "soa/particle_fields.hpp"

namespace salvo::recording {

namespace {

constexpr std::span<const soa::Field> fields = soa::particle_fields;

const FrameColumn* column_named(const std::vector<FrameColumn>& columns, std::string_view name) {
  for (const FrameColumn& column : columns) {
    if (column.name == name) return &column;
  }
  return nullptr;
}

const UniformValue* uniform_named(const FrameInfo& info, std::string_view name) {
  for (const UniformValue& uniform : info.uniform) {
    if (uniform.field == name) return &uniform;
  }
  return nullptr;
}

// Takes the components of a column apart into the table.
void fill(soa::Table& table, std::size_t field, const FrameColumn& column) {
  const std::size_t size = size_of(column.scalar, table.precision());
  for (std::size_t c = 0; c < column.components; ++c) {
    const std::byte* from = column.values.data() + c * size;
    std::byte* to = table.bytes(field, c);
    for (std::size_t row = 0; row < table.rows(); ++row) {
      std::memcpy(to + row * size, from + row * column.components * size, size);
    }
  }
}

bool is_of(const FrameColumn& column, const soa::Field& field) {
  return column.scalar == field.scalar && column.components == field.components;
}

std::optional<soa::Table> contacts_of(const Frame& frame, const std::filesystem::path& path) {
  if (frame.contact_columns.empty()) return std::nullopt;
  std::vector<bool> stored(std::size(soa::contact_fields));
  std::transform(std::begin(soa::contact_fields), std::end(soa::contact_fields), stored.begin(),
                 [&](const soa::Field& field) {
                   return column_named(frame.contact_columns, field.name) != nullptr;
                 });
  const auto fail = [&](std::string_view field, std::string_view what) {
    throw CorruptFile(fmt::format("cannot read {}: {} {}", path.string(), field, what));
  };
  for (const std::size_t f : {0U, 1U}) {
    if (!stored[f]) fail(soa::contact_fields[f].name, "is missing");
  }
  soa::Table table(soa::contact_fields, frame.info.precision, stored);
  table.append(frame.contacts);
  for (std::size_t f = 0; f < stored.size(); ++f) {
    if (!stored[f]) continue;
    const soa::Field& field = soa::contact_fields[f];
    const FrameColumn& column = *column_named(frame.contact_columns, field.name);
    if (!is_of(column, field)) fail(field.name, "has another type than in this version");
    fill(table, f, column);
  }
  return table;
}

soa::Table table_of(const Frame& frame, const std::filesystem::path& path) {
  const auto fail = [&](std::string_view field, std::string_view what) {
    throw CorruptFile(fmt::format("cannot read {}: {} {}", path.string(), field, what));
  };
  std::vector<bool> stored;
  for (std::size_t f = 0; f < fields.size(); ++f) {
    const bool absent = soa::only_of_contacts(f) && !column_named(frame.columns, fields[f].name);
    stored.push_back(!absent && uniform_named(frame.info, fields[f].name) == nullptr);
  }
  if (!stored[0]) fail(fields[0].name, "is not a column");
  soa::Table table(fields, frame.info.precision, stored);
  table.append(frame.rows);
  for (std::size_t f = 0; f < fields.size(); ++f) {
    if (!stored[f]) {
      const UniformValue* value = uniform_named(frame.info, fields[f].name);
      if (value) table.set_uniform(f, value->value);
      continue;
    }
    const FrameColumn* column = column_named(frame.columns, fields[f].name);
    if (!column) fail(fields[f].name, "is missing");
    if (!is_of(*column, fields[f])) fail(fields[f].name, "has another type than in this version");
    fill(table, f, *column);
  }
  if (!table.sorted_by_id()) fail(fields[0].name, "is not ascending");
  return table;
}

void tell(const Report& report, const std::exception& error) {
  if (report) report(error.what());
}

}  // namespace

void CheckpointData::restore(solver::World& world) && {
  for (std::size_t f = 0; f < fields.size(); ++f) {
    assert(particles.stored(f) == world.particles().stored(f));
  }
  world.restore(step, std::move(particles), tally, removed, std::move(contacts));
}

CheckpointData read_checkpoint(const std::filesystem::path& path) {
  const Frame frame = read_frame(path);
  if (!frame.info.complete) {
    throw RecordingError(fmt::format(
        "cannot go on from {}: it holds only some columns or particles", path.string()));
  }
  CheckpointData data{frame.info.step,        table_of(frame, path), contacts_of(frame, path),
                      frame.info.tally,       frame.info.removed,    {},
                      frame.info.scene_digest};
  const solver::Parallel parallel(solver::hardware_threads());
  data.hash = state_hash(data.particles, parallel);
  if (data.contacts) append(data.hash, state_hash(*data.contacts, parallel));
  if (data.hash.total != frame.info.state_hash) {
    throw CorruptFile(fmt::format("cannot read {}: the state in it has the hash {}, not {}",
                                  path.string(), to_string(data.hash.total),
                                  to_string(frame.info.state_hash)));
  }
  return data;
}

std::optional<std::filesystem::path> latest_checkpoint(const std::filesystem::path& directory,
                                                       const Report& report) {
  std::vector<NumberedFile> checkpoints = list_checkpoints(directory);
  std::reverse(checkpoints.begin(), checkpoints.end());
  for (const NumberedFile& checkpoint : checkpoints) {
    try {
      read_frame_info(checkpoint.path);
      return checkpoint.path;
    } catch (const CorruptFile& error) {
      tell(report, error);
    }
  }
  return std::nullopt;
}

bool checkpoint_due(const scene::Scene& scene, std::int64_t step) {
  const scene::CheckpointSettings& wanted = scene.checkpoint;
  return (wanted.every > 0 && step > 0 && step % wanted.every == 0) ||
         (wanted.at_end && step == scene.steps);
}

std::optional<CheckpointData> resume_point(const std::filesystem::path& directory,
                                           const scene::Scene& scene, std::int64_t last_step,
                                           const Report& report) {
  check_ownership(directory, scene::scene_digest(scene));
  std::vector<NumberedFile> states;  // full ones, by step

  // Nothing is recomputed before the state that the run goes on from, so all before it must be in
  // order.
  std::int64_t limit = std::min(last_step, scene.steps);
  const auto belongs = [&](const FrameInfo& info, const NumberedFile& file, std::int64_t step) {
    if (info.step == step && info.scene_digest == scene_digest(scene)) return;
    throw CorruptFile(
        fmt::format("cannot use {}: it is of another step or scene", file.path.string()));
  };
  std::int64_t next = 0;
  for (const NumberedFile& frame : list_frames(directory)) {
    const std::int64_t step = frame.number * scene.frames.every;
    if (frame.number != next || step > limit) break;
    try {
      const FrameInfo info = read_frame_info(frame.path);
      belongs(info, frame, step);
      if (info.complete) states.push_back({step, frame.path});
    } catch (const CorruptFile& error) {
      tell(report, error);
      break;
    }
    ++next;
  }
  limit = std::min(limit, next * scene.frames.every);
  for (const NumberedFile& checkpoint : list_checkpoints(directory)) {
    if (checkpoint.number > limit) break;
    try {
      belongs(read_frame_info(checkpoint.path), checkpoint, checkpoint.number);
      states.push_back(checkpoint);
    } catch (const CorruptFile& error) {
      tell(report, error);
      if (checkpoint_due(scene, checkpoint.number)) limit = checkpoint.number;
    }
  }

  std::stable_sort(states.begin(), states.end(), [](const NumberedFile& a, const NumberedFile& b) {
    return a.number > b.number;
  });
  for (const NumberedFile& state : states) {
    if (state.number > limit) continue;
    try {
      return read_checkpoint(state.path);
    } catch (const RecordingError& error) {
      tell(report, error);
    }
  }
  return std::nullopt;
}

}  // namespace salvo::recording
