#include "solver/contact_time.hpp"

#include <algorithm>
#include <limits>

#include "kernels/sphere_contact.hpp"
#include "solver/world.hpp"

namespace salvo::solver {

namespace {

using S = kernels::ScalarLane<double>;

double rayleigh_time(const models::ContactLaw& law, double mass, double radius) {
  const double density = mass / (4.0 / 3.0 * kernels::pi * radius * radius * radius);
  const double shear = law.young_modulus / (2 * (1 + law.poisson_ratio));
  return kernels::pi * radius * sqrt(S(density / shear)).value() /
         (0.1631 * law.poisson_ratio + 0.8766);
}

struct Haste {
  double factor;
  const char* of;
};

// By how much something else of a contact is faster than its impact without damping, and what. A
// dashpot decays within 1/(2 zeta) of the spring's time; and where solid spheres slip, springs and
// dashpots move 2/7 of the effective mass. A dashpot of the slip has but to be stable, for which
// half is enough.
Haste haste(const models::ContactLaw& law, double damping) {
  const bool hertz = law.kind == models::ContactLawKind::hertz_mindlin;
  Haste most{1, hertz ? "a wave through the largest sphere at the least mass"
                      : "the impact of two of the lightest spheres"};
  const auto consider = [&](double factor, const char* of) {
    if (factor > most.factor) most = {factor, of};
  };
  consider(2 * damping, "the decay of an impact (restitution)");
  if (law.turns()) {
    // Under Hertz' law the tangential springs follow from the material, and its time allows for it.
    if (!hertz) {
      consider(sqrt(S(3.5 * law.tangential_ratio)).value(), "the slip spring (tangential_ratio)");
    }
    consider(3.5 * damping * law.tangential_damping, "the decay of a slip (tangential_damping)");
  }
  return most;
}

}  // namespace

ContactTime contact_time(const Setup& setup) {
  const models::ContactLaw& law = *setup.contact_law;
  const bool hertz = law.kind == models::ContactLawKind::hertz_mindlin;
  double damping = kernels::damping_ratio_of(law.restitution);
  for (const models::Obstacle& obstacle : setup.obstacles) {
    damping = std::max(damping, kernels::damping_ratio_of(obstacle.restitution));
  }
  double shortest = std::numeric_limits<double>::infinity();
  for (const Emitter& emitter : setup.emitters) {
    // Mass and radius are drawn apart: any two may meet in a particle.
    const double mass = emitter.mass.least();
    const double radius = emitter.radius.greatest();
    if (!(mass > 0) || !(radius > 0)) continue;
    const double impact = kernels::pi * sqrt(S(0.5 * mass / law.normal_stiffness)).value();
    shortest = std::min(shortest, hertz ? rayleigh_time(law, mass, radius) : impact);
  }
  const Haste most = haste(law, damping);
  ContactTime time;
  time.of = most.of;
  time.duration = shortest / most.factor;
  time.step = time.duration / (hertz ? 5 : 50);
  time.longest_step = time.duration / (hertz ? 1 : 8);
  return time;
}

}  // namespace salvo::solver
