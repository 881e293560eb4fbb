// What a frame reports of particles that touch.
#pragma once

#include <array>
#include <cstdint>

namespace salvo::solver {

/// Of the contacts at the positions of the frame, each pair counted once. Overlaps of no contact
/// are zero. The last three are NaN where the scene does not keep them (energy_budget), and once a
/// particle is gone, and what it had with it.
struct ContactDiagnostics {
  std::uint64_t pair_contacts = 0;   // of two particles
  std::uint64_t wall_contacts = 0;   // of a particle and a smooth part of an obstacle
  double mean_coordination = 0;      // partners of a particle, without obstacles
  double max_overlap = 0;            // m
  double mean_overlap = 0;           // m
  double max_relative_overlap = 0;   // over the smaller radius
  double mean_relative_overlap = 0;  // likewise
  double rotational_energy = 0;      // J
  double elastic_energy = 0;         // J, of the normal springs, less what cohesion gave
  double damping_loss = 0;           // J, since the start
  double friction_loss = 0;          // J, likewise
  /// N s, the sum of what particles gave each other, of which rounding alone leaves any.
  std::array<double, 3> momentum_error{};
};

}  // namespace salvo::solver
