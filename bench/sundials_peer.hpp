// ARKODE of SUNDIALS on the shot of bench/trajectories.cpp: one trajectory after another, as its
// users write it.
#pragma once

#include <array>
#include <cstddef>

namespace salvo::bench {

/// State x, y, z, vx, vy, vz; drag function G7, wind to the right, gravity 9.80665 m/s^2.
struct PeerG7Shot {
  std::array<double, 6> state;
  double wind_z;
  double drag_factor;
  double range;
};

/// Takes each shot to its range, or for `longest` seconds where it does not reach it.
void sundials_shot_g7(PeerG7Shot* shots, std::size_t count, double first_step, double longest);

}  // namespace salvo::bench
