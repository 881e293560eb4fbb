// A scene of trajectories: a model, how its inputs vary, and what is to be told of the outcome.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scene/scene.hpp"
#include "solver/models.hpp"
#include "solver/statistics.hpp"
#include "solver/sweep.hpp"

namespace salvo::scene {

/// The sweep ends early, after a whole part of rows, when the mean of a column is known this well.
struct StopSettings {
  std::size_t column = 0;
  double half_width = 0;
  double confidence = 0.95;
};

/// An input that was solved for.
struct Solved {
  std::size_t input = 0;
  double value = 0;
  std::vector<double> by_point;  ///< values at the points of the grid, where it was for each
  std::string quantity;          ///< the field that it brings
  double target = 0;             ///< to this
};

struct SweepScene : SceneText {
  const solver::ModelEntry* model = nullptr;
  solver::SweepSetup setup;
  solver::StatisticsSettings statistics;
  std::vector<bool> counted;  ///< by outcome: whether the statistics count such rows
  std::optional<StopSettings> stop;
  std::vector<Solved> solved;
  double click = 0;  ///< rad; of a sight, for drop tables; 0: none
  std::uint64_t verify_rows = 50000;
};

/// The digest of all that decides the bits of a row: two scenes that agree in it have equal rows
/// where they have the same indices. The number of samples is no part of it, unless rows depend on
/// it.
solver::Digest row_digest(const SweepScene& scene);

}  // namespace salvo::scene
