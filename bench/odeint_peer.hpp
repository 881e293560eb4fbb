// Boost.odeint on the problems of bench/trajectories.cpp: one trajectory after another, as its
// users write it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace salvo::bench {

/// State x, y, z, vx, vy, vz; gravity 9.80665 m/s^2 and drag k |v| v.
struct PeerShot {
  std::array<double, 6> state;
  double drag_factor;
};

/// Takes each shot `steps` steps of the classical Runge-Kutta method.
void odeint_rk4_drag(PeerShot* shots, std::size_t count, std::int64_t steps, double dt);
/// Takes each Lorenz system (sigma 10, beta 8/3) `steps` steps of Dormand and Prince's method of
/// order 5 without control of the step.
void odeint_lorenz(std::array<double, 3>* states, const double* rho, std::size_t count,
                   std::int64_t steps, double dt);

}  // namespace salvo::bench
