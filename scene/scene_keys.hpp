// The keys of a scene file and what they fill before the checks that need several of them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scene/keys.hpp"
#include "scene/scene.hpp"
#include "scene/terrain.hpp"

namespace salvo::scene {

struct TimeKeys {
  double start = 0;
  std::optional<double> dt;
  std::optional<double> steps_per_second;
  std::optional<double> duration;
  std::optional<std::int64_t> steps;
};

struct EmitterKeys : solver::Emitter {
  std::optional<std::uint64_t> given_stream;
  std::optional<double> given_time;
  std::optional<double> given_duration;
  std::optional<solver::Spread> given_drag_area;
};

struct ObstacleKeys : models::Obstacle {
  solver::Triple rotation_axis{0, 1, 0};
  double rotation_angle = 0;  // rad
  double spacing = 0;         // m
  std::optional<std::vector<std::vector<double>>> heights;
  std::optional<Hills> hills;
  std::string mesh_file;
  double scale = 1;
};

struct DomainKeys {
  std::optional<solver::Triple> lowest;
  std::optional<solver::Triple> highest;
  solver::BadRowPolicy on_leave = solver::BadRowPolicy::stop;
};

struct FrameKeys : FrameSettings {
  std::optional<std::int64_t> given_every;
  std::optional<std::int64_t> count;
  std::optional<double> per_second;
};

struct SceneKeys : Scene {
  TimeKeys time;
  DomainKeys domain;
  std::vector<ObstacleKeys> obstacles;
  std::vector<EmitterKeys> emitters;
  FrameKeys frame_keys;
};

/// The list of all keys.
const Section<SceneKeys>& scene_section();

/// Those of them that say the same as others.
std::span<const Rivals> rival_keys();

}  // namespace salvo::scene
