#include "cli/memory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "cli/exit_status.hpp"
#include "cli/text.hpp"
#include "solver/world.hpp"

namespace salvo::cli {

namespace {

std::uint64_t column_bytes(const scene::Scene& scene, soa::ParticleField which) {
  const soa::Field& field = soa::field(which);
  return field.components * size_of(field.scalar, scene.setup.precision);
}

// The number behind a word of a file of such lines.
std::optional<std::uint64_t> entry_of(const std::filesystem::path& path, std::string_view word) {
  std::ifstream lines(path);
  for (std::string key, rest; lines >> key; std::getline(lines, rest)) {
    std::uint64_t number = 0;
    if (key == word && lines >> number) return number;
  }
  return std::nullopt;
}

constexpr const char* groups = "/sys/fs/cgroup";

// The folder of this process's group in the unified hierarchy.
std::filesystem::path memory_group() {
  std::ifstream lines("/proc/self/cgroup");
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("0::/")) return std::filesystem::path(groups) / line.substr(4);
  }
  return {};
}

std::filesystem::path above(const std::filesystem::path& group) {
  return group == groups ? std::filesystem::path() : group.parent_path();
}

std::optional<std::uint64_t> number_in(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::uint64_t number = 0;
  return file >> number ? std::optional(number) : std::nullopt;  // "max" is none
}

// Bytes that a group may still take. Its idle file pages go when something else needs the room.
std::optional<std::uint64_t> left_in(const std::filesystem::path& group) {
  const auto limit = number_in(group / "memory.max");
  const auto current = number_in(group / "memory.current");
  if (!limit || !current) return std::nullopt;
  const std::uint64_t idle = entry_of(group / "memory.stat", "inactive_file").value_or(0);
  const std::uint64_t used = *current - std::min(idle, *current);
  return *limit - std::min(used, *limit);
}

// Bytes that stepping takes for a while besides the state: a permutation and a column where rows
// are put in order after an emission, and the shares of an energy explosion.
std::uint64_t scratch_bytes(const solver::Setup& setup) {
  constexpr std::uint64_t sorting = 16;  // a row
  constexpr std::uint64_t sharing = 24;  // a particle
  std::uint64_t bytes = 0;
  const bool one_burst =
      setup.emitters.size() == 1 && setup.emitters[0].kind != solver::EmitterKind::jet;
  if (!one_burst) bytes = sorting * solver::World::total_emitted(setup);
  for (const solver::Emitter& emitter : setup.emitters) {
    if (emitter.kind == solver::EmitterKind::energy_explosion) {
      bytes = std::max(bytes, sharing * emitter.count);
    }
  }
  return bytes;
}

// Measured: what a file holds besides its columns. HDF5's structure, our attributes and the seal,
// the scene, and the numbers of the rows for ParaView, deflated.
std::uint64_t overhead(const scene::Scene& scene, std::uint64_t rows) {
  std::uint64_t bytes = 10'000 + scene.text.size() + rows / 28;
  for (const std::string& change : scene.overrides) bytes += change.size();
  return bytes;
}

std::uint64_t kept_rows(const scene::Scene& scene) {
  return static_cast<std::uint64_t>(scene.frames.fraction *
                                    static_cast<double>(solver::World::total_emitted(scene.setup)));
}

}  // namespace

std::optional<std::uint64_t> available_memory() {
  std::optional<std::uint64_t> available = entry_of("/proc/meminfo", "MemAvailable:");
  if (available) *available *= 1024;
  // A container may have less than its machine, and so may each group that it is in.
  for (std::filesystem::path group = memory_group(); !group.empty(); group = above(group)) {
    const std::optional<std::uint64_t> left = left_in(group);
    if (left) available = std::min(*left, available.value_or(*left));
  }
  return available;
}

std::uint64_t frame_bytes(const scene::Scene& scene) {
  std::uint64_t row = 0;
  const std::vector<bool> stored = solver::World::stored_fields(scene.setup);
  for (const soa::ParticleField column : scene.frames.columns) {
    if (stored[static_cast<std::size_t>(column)]) row += column_bytes(scene, column);
  }
  return kept_rows(scene) * row + overhead(scene, kept_rows(scene));
}

std::uint64_t checkpoint_bytes(const scene::Scene& scene) {
  std::uint64_t contacts = 0;
  if (scene.setup.contact_law) {
    contacts = contact_table_bytes(scene.setup, solver::World::total_emitted(scene.setup));
  }
  return solver::World::state_bytes(scene.setup) + contacts +
         overhead(scene, solver::World::total_emitted(scene.setup));
}

std::uint64_t run_bytes(const scene::Scene& scene, bool recorded) {
  std::uint64_t state = solver::World::state_bytes(scene.setup) + scratch_bytes(scene.setup);
  if (scene.setup.contact_law) {
    // A look at the state finds the contacts anew, beside the table of what they remember.
    constexpr std::uint64_t looking = 24;  // the broad phase's room is free then
    const std::uint64_t particles = solver::World::total_emitted(scene.setup);
    state += contact_solver_bytes(scene.setup, particles) +
             contact_table_bytes(scene.setup, particles) + looking * particles;
  }
  // Measured: the program and its libraries, and those that record.
  constexpr std::uint64_t program = 15'000'000;
  constexpr std::uint64_t recorder = 15'000'000;
  state += program;
  if (!recorded) return state;
  // Two frames wait while a third is written. Checkpoints on the way do, too, beside the steps; the
  // one at the end comes when these need no room any more.
  const std::uint64_t checkpoints = scene.checkpoint.every > 0 ? 3 : 1;
  return state + recorder + 3 * frame_bytes(scene) + checkpoints * checkpoint_bytes(scene);
}

void check_memory(const scene::Scene& scene, std::uint64_t bytes) {
  const std::optional<std::uint64_t> available = available_memory();
  if (!available || bytes <= *available) return;
  throw Failure(
      ExitStatus::run_failed,
      fmt::format("{} takes {} of memory for {}, and {} are available", scene.path,
                  bytes_text(bytes), counted(solver::World::total_emitted(scene.setup), "particle"),
                  bytes_text(*available)),
      scene.setup.precision == soa::Precision::float64
          ? "fewer particles, or precision = \"float\", take less"
          : "fewer particles take less");
}

void check_memory(const scene::SweepScene& scene, std::uint64_t bytes) {
  const std::optional<std::uint64_t> available = available_memory();
  if (!available || bytes <= *available) return;
  throw Failure(ExitStatus::run_failed,
                fmt::format("{} takes {} of memory, and {} are available", scene.path,
                            bytes_text(bytes), bytes_text(*available)),
                "fewer samples on the way take less");
}

}  // namespace salvo::cli
