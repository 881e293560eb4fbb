#include "solver/contact_time.hpp"

#include <algorithm>
#include <limits>

#include "kernels/sphere_contact.hpp"
#include "solver/world.hpp"

namespace salvo::solver {

namespace {

using S = kernels::ScalarLane<double>;

// The least that a draw gives: normal draws stay within four deviations, and positive.
double least(const Spread& spread) {
  if (spread.kind != Spread::Kind::normal) return spread.a;
  return std::max(spread.a - 4 * spread.b, 0.01 * spread.a);
}

}  // namespace

ContactTime contact_time(const Setup& setup) {
  const models::ContactLaw& law = *setup.contact_law;
  double damping = kernels::damping_ratio_of(law.restitution);
  for (const models::Obstacle& obstacle : setup.obstacles) {
    damping = std::max(damping, kernels::damping_ratio_of(obstacle.restitution));
  }
  ContactTime time;
  time.duration = std::numeric_limits<double>::infinity();
  for (const Emitter& emitter : setup.emitters) {
    const double mass = least(emitter.mass);
    const double radius = least(emitter.radius);
    if (!(mass > 0) || !(radius > 0)) continue;
    if (law.kind == models::ContactLawKind::hertz_mindlin) {
      const double density = mass / (4.0 / 3.0 * kernels::pi * radius * radius * radius);
      const double shear = law.young_modulus / (2 * (1 + law.poisson_ratio));
      const double rayleigh = kernels::pi * radius * sqrt(S(density / shear)).value() /
                              (0.1631 * law.poisson_ratio + 0.8766);
      time.duration = std::min(time.duration, rayleigh);
    } else {
      // Two of the lightest. Damping makes an impact shorter for the numbers: its dashpot decays
      // within 1/(2 zeta) of the spring's time.
      const double unit = sqrt(S(0.5 * mass / law.normal_stiffness)).value();
      time.duration = std::min(time.duration, unit * kernels::pi / std::max(1.0, 2 * damping));
    }
  }
  const bool hertz = law.kind == models::ContactLawKind::hertz_mindlin;
  time.step = time.duration / (hertz ? 5 : 50);
  time.longest_step = time.duration / (hertz ? 1 : 8);
  return time;
}

}  // namespace salvo::solver
