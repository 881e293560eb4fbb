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

void scale(const solver::Setup& setup, solver::Emitter& emitter, double factor) {
  const auto count = static_cast<double>(emitted(setup, emitter));
  if (emitter.kind == solver::EmitterKind::jet) {
    emitter.rate = std::max(emitter.rate * factor, 1 / emitter.duration);
    return;
  }
  emitter.count = static_cast<std::uint64_t>(std::max(1.0, std::floor(count * factor)));
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
