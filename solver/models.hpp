// The models that come with the library, for solver::Batch: `lorenz_kernels` and so on.
#pragma once

#include "solver/batch_kernel.hpp"

SALVO_DECLARE_MODEL(harmonic_oscillator)
SALVO_DECLARE_MODEL(lorenz)
SALVO_DECLARE_MODEL(projectile)
SALVO_DECLARE_MODEL(shot_in_air)
