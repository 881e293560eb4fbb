// Verifying a scene of trajectories: that a row's bits are a function of the scene and its index.
// One axis at a time is varied from the reference (scalar, one thread, all rows at once):
// instruction set, threads, the rows that run together, single rows alone.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scene/sweep_scene.hpp"

namespace salvo::scene {

struct SweepVerifyOptions {
  std::vector<solver::Isa> isas;  ///< none: all that this machine has
  std::vector<int> threads{2, 3, 4, 8, 13};
  std::vector<std::uint64_t> chunks{97, 1000};
  /// Rows of the sweep, from the first; 0: SweepScene::verify_rows.
  std::uint64_t rows = 0;
  std::function<void(std::size_t run, std::size_t runs)> on_progress;
  /// Takes the rows of a run; Sweep::run unless a test plants a difference here.
  std::function<solver::SweepRows(const solver::Sweep&, std::uint64_t first, std::uint64_t count,
                                  const solver::Execution&)>
      run;
};

struct SweepDifference {
  std::uint64_t index = 0;
  std::string column;
  double reference = 0;
  double varied = 0;
};

struct SweepVerifyRun {
  std::string axis;   ///< "reference", "isa", "threads", "chunk", "alone"
  std::string value;  ///< what it was set to
  solver::Digest hash;
  std::uint64_t rows = 0;
  std::optional<SweepDifference> difference;
};

/// The reference first.
std::vector<SweepVerifyRun> verify(const SweepScene& scene, const SweepVerifyOptions& options);

}  // namespace salvo::scene
