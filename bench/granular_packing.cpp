#include "bench/granular_packing.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <random>
#include <stdexcept>

namespace salvo::bench {

namespace {

constexpr double glass = 2500;  // kg/m^3

double sphere_mass(double radius, double density) {
  return density * 4 / 3 * M_PI * radius * radius * radius;
}

}  // namespace

double GranularPacking::mass() const { return sphere_mass(radius, density); }

GranularLaw granular_law(double normal_stiffness, double restitution, double friction,
                         double mass) {
  // A collision is half a period of a spring of this frequency, damped by exp(-damping t / 2).
  const double squared = normal_stiffness / (mass / 2);
  const double logarithm = std::log(restitution);
  const double damping =
      -2 * logarithm * std::sqrt(squared / (M_PI * M_PI + logarithm * logarithm));
  return {normal_stiffness, normal_stiffness * 2 / 7, damping, damping / 2, friction, true};
}

double collision_time(const GranularLaw& law, double mass) {
  const double damping = law.normal_damping / 2;
  return M_PI / std::sqrt(law.normal_stiffness / (mass / 2) - damping * damping);
}

GranularPacking agitated_packing(std::size_t count, double fraction, double radius, double density,
                                 double speed, std::uint64_t seed) {
  GranularPacking packing{
      .edge = radius * std::cbrt(static_cast<double>(count) * 4 / 3 * M_PI / fraction),
      .radius = radius,
      .density = density,
      .position = {},
      .velocity = {},
      .spin = {}};
  // Distance of neighbours on the lattice; the outermost centres are half of it from the walls.
  const auto spacing = [&](std::size_t cells) {
    return packing.edge / (static_cast<double>(cells) - 0.5 + M_SQRT1_2) * M_SQRT1_2;
  };
  std::size_t cells = 1;  // along an edge, of four sites each
  while (4 * cells * cells * cells < count || spacing(cells + 1) > 2.2 * radius) ++cells;
  const double gap = spacing(cells) - 2 * radius;
  if (gap <= 0) throw std::invalid_argument("agitated_packing: too dense for a lattice");
  const double jitter = 0.99 * gap / (2 * std::sqrt(3.0));

  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::uniform_real_distribution<double> moved(-jitter, jitter);
  std::normal_distribution<double> drawn(0, speed);  // exact-set: both engines get the same
  std::size_t sites = 4 * cells * cells * cells;
  for (std::size_t site = 0; packing.count() < count; ++site, --sites) {
    // Every choice of `count` sites is as probable (Knuth's algorithm S).
    if (unit(random) * static_cast<double>(sites) >= static_cast<double>(count - packing.count())) {
      continue;
    }
    const std::size_t corner = site % 4;
    const std::size_t place = site / 4;
    const std::array<double, 3> along = {
        static_cast<double>(place % cells) + (corner == 1 || corner == 2 ? 0.5 : 0),
        static_cast<double>(place / cells % cells) + (corner == 1 || corner == 3 ? 0.5 : 0),
        static_cast<double>(place / cells / cells) + (corner == 2 || corner == 3 ? 0.5 : 0)};
    for (const double at : along) {
      packing.position.push_back(spacing(cells) * (0.5 + at * M_SQRT2) + moved(random));
    }
    for (int axis = 0; axis < 3; ++axis) packing.velocity.push_back(drawn(random));
    for (int axis = 0; axis < 3; ++axis) packing.spin.push_back(drawn(random) / radius);
  }
  return packing;
}

GranularPacking GranularScene::packing(std::size_t count) const {
  return agitated_packing(count, fraction, radius, glass, speed, 1);
}

GranularLaw GranularScene::law() { return granular_law(1e4, 0.8, 0.5, sphere_mass(radius, glass)); }

double GranularScene::dt() { return collision_time(law(), sphere_mass(radius, glass)) / 50; }

std::string GranularScene::conditions() {
  const GranularLaw both = law();
  return fmt::format(
      "linear springs of {:.6g} N/m, {:.6g} N/m across, damped by {:.6g} and {:.6g} 1/s, friction "
      "{:.6g}; steps of {:.6g} s, skin {:.6g} m, lists every {} steps",
      both.normal_stiffness, both.tangential_stiffness, both.normal_damping,
      both.tangential_damping, both.friction, dt(), skin, rebuild_every);
}

const std::vector<GranularScene>& granular_scenes() {
  static const std::vector<GranularScene> all = {{"dense", 0.55, 1.3}, {"sparse", 0.1, 1.1}};
  return all;
}

}  // namespace salvo::bench
