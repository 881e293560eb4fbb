// The kernels of the library's models, compiled once per instruction set. A new model is a line
// here and one in solver/models.hpp.
#include "models/harmonic_oscillator.hpp"
#include "models/lorenz.hpp"
#include "models/projectile.hpp"
#include "models/shot_in_air.hpp"
#include "solver/batch_kernel.hpp"

SALVO_DEFINE_MODEL(harmonic_oscillator, salvo::models::HarmonicOscillator)
SALVO_DEFINE_MODEL(lorenz, salvo::models::Lorenz)
SALVO_DEFINE_MODEL(projectile, salvo::models::Projectile)
SALVO_DEFINE_MODEL(shot_in_air, salvo::models::ShotInAir)
