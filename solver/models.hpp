// The models that come with the library, for solver::Batch: `lorenz_kernels` and so on.
#pragma once

#include <span>

#include "solver/batch_kernel.hpp"

SALVO_DECLARE_MODEL(ball)
SALVO_DECLARE_MODEL(boat)
SALVO_DECLARE_MODEL(cannon)
SALVO_DECLARE_MODEL(harmonic_oscillator)
SALVO_DECLARE_MODEL(lorenz)
SALVO_DECLARE_MODEL(projectile)
SALVO_DECLARE_MODEL(rocket)
SALVO_DECLARE_MODEL(shot_in_air)

namespace salvo::solver {

/// A model as scenes know it: the section of its inputs has its name.
struct ModelEntry {
  std::string_view name;
  std::string_view meaning;
  BatchModel kernels;
};

/// In the order in which they are documented.
std::span<const ModelEntry> models();

}  // namespace salvo::solver
