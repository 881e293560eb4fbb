// Scenes and directories for the tests of recording/: small, but with emissions, deaths and
// removals on the way, stored and uniform fields, and a count of particles that is no multiple of
// anything.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <utility>

#include "recording/recorder.hpp"
#include "scene/scene.hpp"
#include "solver/world.hpp"

namespace salvo::recording {

/// A burst of `count` at step 0, a jet that emits on the way, lives that end on the way. 60 steps,
/// frames every 5, a checkpoint every 20 and one at the end. Mass and group are stored, radius and
/// drag area uniform.
inline scene::Scene small_scene(std::uint64_t count = 1237,
                                soa::Precision precision = soa::Precision::float32) {
  using Kind = solver::Spread::Kind;
  scene::Scene scene;
  scene.path = "small.toml";
  scene.text = "# a small scene of " + std::to_string(count) + " particles\n";
  scene.overrides = {"seed=7", ""};
  scene.title = "small";
  solver::Setup& setup = scene.setup;
  setup.precision = precision;
  setup.seed = 7;
  setup.dt = 0.01;
  setup.forces.quadratic_drag = true;
  setup.forces.windy = true;
  setup.forces.wind.velocity = {3, 0, 1};
  solver::Emitter burst;
  burst.kind = solver::EmitterKind::burst;
  burst.name = "burst";
  burst.stream = 1;
  burst.count = count;
  burst.speed = {Kind::uniform, 1, 20};
  burst.mass = {Kind::uniform, 0.5, 1.5};
  burst.radius = {Kind::constant, 0.25, 0};
  burst.drag_area = {Kind::constant, 0.01, 0};
  burst.life = solver::Spread{Kind::uniform, 0.2, 2};
  burst.group = 3;
  solver::Emitter jet = burst;
  jet.kind = solver::EmitterKind::jet;
  jet.name = "jet";
  jet.stream = 5;
  jet.rate = 1000;
  jet.duration = 0.3;
  jet.half_angle = 0.2;
  jet.time = 0.1;
  jet.group = 4;
  setup.emitters = {burst, jet};
  scene.steps = 60;
  scene.frames.every = 5;
  scene.checkpoint.every = 20;
  return scene;
}

inline solver::World small_world(const scene::Scene& scene) {
  solver::Execution execution;
  execution.threads = 2;
  return {scene.setup, execution};
}

/// All columns and particles: frames that a run can go on from.
inline scene::Scene with_complete_frames(scene::Scene scene) {
  scene.frames.columns.clear();
  for (std::size_t f = 0; f < soa::particle_fields.size(); ++f) {
    scene.frames.columns.push_back(static_cast<soa::ParticleField>(f));
  }
  scene.frames.fraction = 1;
  scene.text += "# complete frames\n";
  return scene;
}

/// Runs to `last` or the scene's end and finishes as done or interrupted.
inline void run_on(solver::World& world, Recorder& recorder, const scene::Scene& scene,
                   std::int64_t last) {
  recorder.record_due(world);
  while (world.step() < last) {
    world.advance_to(std::min(last, recorder.next_due(world.step())));
    recorder.record_due(world);
  }
  recorder.finish(last == scene.steps ? RunStatus::done : RunStatus::interrupted);
}

inline void record_run(const scene::Scene& scene, const std::filesystem::path& directory) {
  solver::World world = small_world(scene);
  Recorder recorder(directory, scene, {});
  run_on(world, recorder, scene, scene.steps);
}

/// A directory of the test's own, removed with all that is in it.
class TemporaryDirectory {
 public:
  TemporaryDirectory() {
    std::string name = (std::filesystem::temp_directory_path() / "salvo-test-XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  ~TemporaryDirectory() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

inline std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void put_bytes(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

/// All files of a directory but run.json, by name.
inline std::map<std::string, std::string> contents_of(const std::filesystem::path& directory) {
  std::map<std::string, std::string> contents;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    const std::string name = entry.path().filename().string();
    if (name != "run.json") contents[name] = bytes_of(entry.path());
  }
  return contents;
}

/// Says which file differs rather than printing them.
inline void expect_equal_contents(const std::filesystem::path& a, const std::filesystem::path& b) {
  const auto in_a = contents_of(a);
  const auto in_b = contents_of(b);
  for (const auto& [name, bytes] : in_a) {
    const auto found = in_b.find(name);
    if (found == in_b.end()) {
      ADD_FAILURE() << name << " is missing in the second";
    } else {
      EXPECT_TRUE(bytes == found->second) << name << " differs";
    }
  }
  for (const auto& [name, bytes] : in_b) EXPECT_TRUE(in_a.count(name)) << name << " is extra";
}

}  // namespace salvo::recording
