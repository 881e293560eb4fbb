// The kernels of the library's models, compiled once per instruction set. A new model is a line
// here and one in solver/models.hpp.
#include "models/ball.hpp"
#include "models/boat.hpp"
#include "models/cannon.hpp"
#include "models/harmonic_oscillator.hpp"
#include "models/lorenz.hpp"
#include "models/projectile.hpp"
#include "models/rocket.hpp"
#include "models/shot_in_air.hpp"
#include "solver/batch_kernel.hpp"

SALVO_DEFINE_MODEL(ball, salvo::models::Ball)
SALVO_DEFINE_MODEL(boat, salvo::models::Boat)
SALVO_DEFINE_MODEL(cannon, salvo::models::Cannon)
SALVO_DEFINE_MODEL(harmonic_oscillator, salvo::models::HarmonicOscillator)
SALVO_DEFINE_MODEL(lorenz, salvo::models::Lorenz)
SALVO_DEFINE_MODEL(projectile, salvo::models::Projectile)
SALVO_DEFINE_MODEL(rocket, salvo::models::Rocket)
SALVO_DEFINE_MODEL(shot_in_air, salvo::models::ShotInAir)
