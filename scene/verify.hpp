// Verifying a scene: that its bits are a function of the scene and of nothing else, checked on this
// machine.
//
// One axis at a time is varied from the reference (scalar, one thread, one step a pass):
// instruction set, threads, steps a pass; stopping and resuming; fewer rows; one emitter alone.
// State hashes are compared at every frame. On a difference both runs go back to the last equal
// frame and take single steps, to name the first step, column and id, or ids of a contact.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scene/difference.hpp"
#include "scene/scene.hpp"
#include "solver/world.hpp"

namespace salvo::scene {

struct VerifyRun;

struct VerifyProgress {
  std::size_t run = 0;  ///< of `runs`, from zero
  std::size_t runs = 0;
  const VerifyRun* what = nullptr;
  std::int64_t step = 0;  ///< of `steps`
  std::int64_t steps = 0;
};

struct VerifyOptions {
  /// Values of the axes besides the reference's. No instruction set: all that this machine has.
  std::vector<solver::Isa> isas;
  std::vector<int> threads{2, 3, 4, 8, 13};
  std::vector<std::int32_t> passes{7, 64};
  /// Called after each frame of each run.
  std::function<void(const VerifyProgress&)> on_progress;
  /// Takes a run's world to a step; World::advance_to unless a test plants a difference here.
  std::function<void(const VerifyRun&, solver::World&, std::int64_t)> advance;
};

enum class VerifyAxis {
  reference,
  isa,      ///< another instruction set
  threads,  ///< more threads
  pass,     ///< more steps a pass
  resume,   ///< stopped at the middle frame, resumed from a copy of its state
  lists,    ///< the broad phase of particles that touch goes about it in another way
  rows,     ///< two rows of three taken out: other lanes, neighbours and tiles for those that stay
  emitter,  ///< one emitter alone
};

std::string_view name(VerifyAxis axis);

struct VerifyRun {
  VerifyAxis axis = VerifyAxis::reference;
  std::string value;  ///< what the axis was set to: "avx2", "13", "step 600"
  solver::Execution execution;
  std::size_t frames = 0;  ///< frames compared
  /// Of the last frame. Runs of fewer rows have a hash of their own; it is compared with that of
  /// the reference's same rows.
  solver::Digest hash;
  std::uint64_t rows = 0;  ///< alive at the last frame
  std::uint64_t particle_steps = 0;
  /// The particle at which the scene stopped the run.
  std::optional<solver::BadRow> stopped;
  std::optional<Difference> difference;
};

struct VerifyResult {
  std::vector<VerifyRun> runs;  ///< the reference first
  std::int64_t steps = 0;

  bool equal() const;
};

/// Runs the whole scene a dozen times; see scaled_for_verify for a smaller one. Throws what World
/// throws, except that a NumericalError is a result: every run has to stop at the same particle.
VerifyResult verify(const Scene& scene, const VerifyOptions& options);

}  // namespace salvo::scene
