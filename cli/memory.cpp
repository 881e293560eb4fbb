#include "cli/memory.hpp"

#include <fmt/format.h>

#include <fstream>
#include <string>

#include "cli/exit_status.hpp"
#include "cli/text.hpp"
#include "solver/world.hpp"

namespace salvo::cli {

namespace {

std::uint64_t column_bytes(const scene::Scene& scene, soa::ParticleField which) {
  const soa::Field& field = soa::field(which);
  return field.components * size_of(field.scalar, scene.setup.precision);
}

}  // namespace

std::optional<std::uint64_t> available_memory() {
  std::ifstream lines("/proc/meminfo");
  std::string key;
  std::uint64_t kilobytes = 0;
  std::string unit;
  while (lines >> key >> kilobytes) {
    if (key == "MemAvailable:") return kilobytes * 1024;
    std::getline(lines, unit);
  }
  return std::nullopt;
}

std::uint64_t frame_bytes(const scene::Scene& scene) {
  std::uint64_t row = 0;
  const std::vector<bool> stored = solver::World::stored_fields(scene.setup);
  for (const soa::ParticleField column : scene.frames.columns) {
    if (stored[static_cast<std::size_t>(column)]) row += column_bytes(scene, column);
  }
  const double kept =
      scene.frames.fraction * static_cast<double>(solver::World::total_emitted(scene.setup));
  return static_cast<std::uint64_t>(kept) * row;
}

std::uint64_t checkpoint_bytes(const scene::Scene& scene) {
  return solver::World::state_bytes(scene.setup);
}

std::uint64_t run_bytes(const scene::Scene& scene, bool recorded) {
  const std::uint64_t state = solver::World::state_bytes(scene.setup);
  if (!recorded) return state;
  // Measured peaks: two frames wait while a third is written; one checkpoint, while another is.
  return state + 3 * frame_bytes(scene) + 2 * checkpoint_bytes(scene);
}

void check_memory(const scene::Scene& scene, std::uint64_t bytes) {
  const std::optional<std::uint64_t> available = available_memory();
  if (!available || bytes <= *available) return;
  throw Failure(
      ExitStatus::run_failed,
      fmt::format("{} takes {} of memory for {}, and {} are available", scene.path,
                  bytes_text(bytes), counted(solver::World::total_emitted(scene.setup), "particle"),
                  bytes_text(*available)),
      "fewer particles, or precision = \"float\", take less");
}

}  // namespace salvo::cli
