// One particle in a world of its own: the shortest way from a book's example to a number.
#pragma once

#include <cmath>
#include <cstdint>

#include "solver/world.hpp"
#include "tests/solver/particles.hpp"
#include "tests/solver/setups.hpp"

namespace salvo::tests {

inline constexpr double pi = 3.14159265358979323846;
inline constexpr double degree = pi / 180;

/// Double precision, one particle, `steps_per_second` steps a second unless dt is set.
class Flight {
 public:
  Flight(const solver::Setup& setup, Triple position, Triple velocity, double mass = 1,
         double drag_area = 0, double radius = 0)
      : world_(with_particle(setup, position, velocity, mass, drag_area, radius),
               {solver::widest_isa(), 1, 64}) {}

  /// The particle after `steps` steps from the start.
  Particle after(std::int64_t steps) {
    world_.advance_to(steps);
    return read_particle(world_.particles(), 0);
  }
  /// The particle at `time`, a whole number of steps after the start.
  Particle at_time(double time) {
    return after(std::llround((time - world_.setup().t0) / world_.setup().dt));
  }

 private:
  static solver::Setup with_particle(solver::Setup setup, Triple position, Triple velocity,
                                     double mass, double drag_area, double radius) {
    setup.emitters = {particles_from(1, position, velocity)};
    setup.emitters[0].mass = constant(mass);
    setup.emitters[0].drag_area = constant(drag_area);
    setup.emitters[0].radius = constant(radius);
    return setup;
  }

  solver::World world_;
};

/// Uniform gravity along -y, Runge-Kutta.
inline solver::Setup falling(double g, double dt) {
  solver::Setup setup = plain_setup();
  setup.dt = dt;
  setup.integrator = IntegratorKind::runge_kutta_4;
  setup.forces.gravity = {0, -g, 0};
  return setup;
}

inline double speed(const Particle& p) {
  return std::hypot(p.velocity[0], p.velocity[1], p.velocity[2]);
}

}  // namespace salvo::tests
