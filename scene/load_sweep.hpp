// Reading scenes of trajectories, and scenes of either kind.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "scene/load.hpp"
#include "scene/sweep_scene.hpp"

namespace salvo::scene {

using AnyScene = std::variant<Scene, SweepScene>;

/// What is common to both.
const SceneText& text_of(const AnyScene& scene);

/// A scene that has the section of a model is one of trajectories, any other one of particles.
/// Throws as load and parse do.
AnyScene load_any(const std::string& path, const std::vector<std::string>& overrides = {});
AnyScene parse_any(const std::string& text, const std::string& path,
                   const std::vector<std::string>& overrides = {});

/// A scene of trajectories. A table that it names is looked for beside `path`.
SweepScene parse_sweep(const std::string& text, const std::string& path,
                       const std::vector<std::string>& overrides = {});

}  // namespace salvo::scene
