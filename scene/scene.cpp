#include "scene/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scene/load.hpp"
#include "solver/floating_point_environment.hpp"

namespace salvo::scene {

solver::Digest scene_digest(const SceneText& scene) {
  // Each part with its length, so that no two scenes run together into one.
  std::string bytes = fmt::format("salvo {}\n{}\n", contract_version, scene.text.size());
  bytes += scene.text;
  for (const std::string& override_text : scene.overrides) {
    bytes += fmt::format("\n{}\n", override_text.size());
    bytes += override_text;
  }
  for (const solver::Digest& input : scene.inputs) bytes += "\n" + to_string(input);
  return solver::digest_of(bytes.data(), bytes.size());
}

namespace {

std::uint64_t emitted(const solver::Setup& setup, const solver::Emitter& emitter) {
  return solver::EmissionSchedule(emitter, setup.t0, setup.dt).total();
}

// The smallest lattice of the same shape that stands where the given one does and has so many
// sites: its particles touch as those do, which the first of many layers would not.
void shrink(solver::Emitter& lattice, std::uint64_t sites) {
  const solver::Emitter whole = lattice;
  const auto resize = [&](double factor) {
    for (std::size_t c = 0; c < 3; ++c) {
      lattice.size[c] = whole.spacing + factor * (whole.size[c] - whole.spacing);
    }
    lattice.position[1] = whole.position[1] - 0.5 * (whole.size[1] - lattice.size[1]);
  };
  double small = 0;
  double large = 1;
  for (int i = 0; i < 20; ++i) {
    const double middle = 0.5 * (small + large);
    resize(middle);
    (solver::lattice_sites(lattice) < sites ? small : large) = middle;
  }
  resize(large);
}

void scale(const solver::Setup& setup, solver::Emitter& emitter, double factor) {
  const auto count = static_cast<double>(emitted(setup, emitter));
  if (emitter.kind == solver::EmitterKind::jet) {
    emitter.rate = std::max(emitter.rate * factor, 1 / emitter.duration);
    return;
  }
  emitter.count = static_cast<std::uint64_t>(std::max(1.0, std::floor(count * factor)));
  if (emitter.kind == solver::EmitterKind::lattice) {
    shrink(emitter, static_cast<std::uint64_t>(static_cast<double>(solver::lattice_sites(emitter)) *
                                               factor));
  }
  // The same energy a particle: fewer that share the whole budget would be faster ones.
  emitter.energy *= static_cast<double>(emitter.count) / count;
}

}  // namespace

Scene scaled_for_verify(const Scene& scene) {
  const solver::FloatingPointEnvironment environment;
  Scene scaled = scene;
  const std::uint64_t total = solver::World::total_emitted(scene.setup);
  if (total > scene.verify.rows) {
    const double factor = static_cast<double>(scene.verify.rows) / static_cast<double>(total);
    for (solver::Emitter& emitter : scaled.setup.emitters) scale(scene.setup, emitter, factor);
    scaled.scaling =
        fmt::format("{} of {} particles", solver::World::total_emitted(scaled.setup), total);
  }
  const std::int64_t steps = scene.verify.steps;
  if (steps > 0 && steps < scene.steps) {
    scaled.frames.every = std::min(scene.frames.every, steps);
    scaled.steps = steps / scaled.frames.every * scaled.frames.every;
    scaled.scaling += fmt::format("{}{} of {} steps", scaled.scaling.empty() ? "" : ", ",
                                  scaled.steps, scene.steps);
  }
  return scaled;
}

}  // namespace salvo::scene
