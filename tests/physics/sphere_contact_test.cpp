// Particles that touch against exact solutions: impacts of two spheres, slip and rolling, momentum,
// and whole packings.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "kernels/sphere_contact.hpp"
#include "solver/contact_time.hpp"
#include "solver/world.hpp"

namespace salvo {
namespace {

using models::ContactLaw;
using models::ContactLawKind;
using soa::ParticleField;
using solver::Emitter;
using solver::EmitterKind;
using solver::Setup;
using solver::World;

Setup empty_setup(const ContactLaw& law, soa::Precision precision) {
  Setup setup;
  setup.precision = precision;
  setup.forces.gravity = {0, 0, 0};
  setup.contact_law = law;
  return setup;
}

void add_sphere(Setup& setup, solver::Triple position, solver::Triple velocity, double radius,
                double mass, solver::Triple spin = {}) {
  Emitter emitter;
  emitter.kind = EmitterKind::burst;
  emitter.stream = setup.emitters.size();
  emitter.count = 1;
  emitter.position = position;
  emitter.velocity = velocity;
  emitter.angular_velocity = spin;
  emitter.radius.a = radius;
  emitter.mass.a = mass;
  setup.emitters.push_back(emitter);
}

double value(const World& world, ParticleField field, std::size_t row, std::size_t c) {
  const auto f = static_cast<std::size_t>(field);
  const soa::Table& table = world.particles();
  if (!table.stored(f)) return table.uniform(f);
  return table.precision() == soa::Precision::float32
             ? static_cast<double>(table.column<float>(f, c)[row])
             : table.column<double>(f, c)[row];
}

ContactLaw linear(double stiffness, double restitution, double friction = 0) {
  ContactLaw law;
  law.normal_stiffness = stiffness;
  law.restitution = restitution;
  law.friction = friction;
  return law;
}

ContactLaw hertz(double young, double restitution, double friction = 0) {
  ContactLaw law;
  law.kind = ContactLawKind::hertz_mindlin;
  law.young_modulus = young;
  law.restitution = restitution;
  law.friction = friction;
  return law;
}

// Relative speed after a head-on impact over that before it.
double measured_restitution(const ContactLaw& law, double finer) {
  Setup setup = empty_setup(law, soa::Precision::float64);
  add_sphere(setup, {-0.0101, 0, 0}, {1, 0, 0}, 0.01, 0.02);
  add_sphere(setup, {0.0151, 0, 0}, {-0.5, 0, 0}, 0.015, 0.05);
  setup.dt = solver::contact_time(setup).step / finer;
  World world(setup, {});
  world.advance_to(static_cast<std::int64_t>(0.1 / setup.dt));
  return (value(world, ParticleField::velocity, 1, 0) -
          value(world, ParticleField::velocity, 0, 0)) /
         1.5;
}

// The damping follows from the restitution by an exact formula under both laws; what is left is the
// step's error, of first order because the dashpot sees the velocity of half a step before.
TEST(SphereContact, HeadOnImpactsHaveTheirRestitution) {
  for (const double e : {1.0, 0.9, 0.5, 0.2}) {
    for (const ContactLaw& law : {linear(2e4, e), hertz(1e7, e)}) {
      const double coarse = measured_restitution(law, 1) - e;
      const double fine = measured_restitution(law, 8) - e;
      EXPECT_LT(std::abs(coarse), 0.02) << e;
      EXPECT_LT(std::abs(fine), 0.0025) << e;
    }
  }
}

TEST(SphereContact, DampingRatioAndRestitutionAreInverses) {
  for (const double e : {0.999, 0.7, 0.3, std::exp(-2.0), 0.1, 0.01}) {
    EXPECT_NEAR(kernels::restitution_of(kernels::damping_ratio_of(e)), e, 1e-12);
  }
  // Where acos and arcosh meet.
  EXPECT_NEAR(kernels::restitution_of(1 - 1e-7), std::exp(-2.0), 1e-6);
  EXPECT_NEAR(kernels::restitution_of(1 + 1e-7), std::exp(-2.0), 1e-6);
  EXPECT_NEAR(kernels::impact_duration(1e-12), kernels::pi, 1e-9);
}

// Deepest overlap of a Hertz impact: (15 m* v^2/(16 E* sqrt(R*)))^(2/5).
TEST(SphereContact, HertzOverlapAndDurationAreTheExactOnes) {
  const ContactLaw law = hertz(5e7, 1);
  Setup setup = empty_setup(law, soa::Precision::float64);
  add_sphere(setup, {-0.01, 0, 0}, {0.5, 0, 0}, 0.01, 0.01);
  add_sphere(setup, {0.01, 0, 0}, {-0.5, 0, 0}, 0.01, 0.01);
  setup.dt = solver::contact_time(setup).step / 20;
  World world(setup, {});
  double deepest = 0;
  std::int64_t steps = 0;
  do {
    world.advance_to(++steps);
    deepest = std::max(deepest, 0.02 - (value(world, ParticleField::position, 1, 0) -
                                        value(world, ParticleField::position, 0, 0)));
  } while (value(world, ParticleField::position, 1, 0) -
               value(world, ParticleField::position, 0, 0) <
           0.02);
  const double young = models::effective_young(law);
  const double exact = std::pow(15 * 0.005 * 1 / (16 * young * std::sqrt(0.005)), 0.4);
  EXPECT_NEAR(deepest, exact, 1e-4 * exact);
  // 2.9432.. = 2 sqrt(pi) Gamma(2/5)/(5 Gamma(9/10))   [Landau & Lifshitz, Elasticity 9]
  const double duration = 2.943275 * exact;
  EXPECT_NEAR(static_cast<double>(steps) * setup.dt, duration, 2e-3 * duration);
}

// A sphere that slides over a plane and slips through the whole impact leaves with a tangential
// velocity less by mu (1 + e) v_n and the spin of that impulse.
TEST(SphereContact, ObliqueImpactThatSlipsTakesCoulombsImpulse) {
  const double mu = 0.1;
  const double e = 0.7;
  Setup setup = empty_setup(linear(1e5, e, mu), soa::Precision::float64);
  models::Obstacle floor;
  floor.restitution = e;
  floor.friction = mu;
  setup.obstacles.push_back(floor);
  const double radius = 0.01;
  const double mass = 0.02;
  add_sphere(setup, {0, radius + 1e-4, 0}, {3, -1, 0}, radius, mass);
  setup.dt = solver::contact_time(setup).step / 8;
  World world(setup, {});
  world.advance_to(static_cast<std::int64_t>(0.01 / setup.dt));
  const double impulse = mass * (1 + value(world, ParticleField::velocity, 0, 1));
  EXPECT_NEAR(value(world, ParticleField::velocity, 0, 1), e, 2e-3);
  EXPECT_NEAR(value(world, ParticleField::velocity, 0, 0), 3 - mu * impulse / mass, 1e-6);
  // The lever is the distance of the center from the plane, a little less than the radius.
  const double spin = -mu * impulse * radius / (0.4 * mass * radius * radius);
  EXPECT_NEAR(value(world, ParticleField::angular_velocity, 0, 2), spin, 0.01 * std::abs(spin));
}

// A sliding sphere that friction brings to roll keeps 5/7 of its speed: friction takes 2/7.
TEST(SphereContact, SlidingEndsInRollingAtFiveSevenths) {
  Setup setup = empty_setup(linear(1e5, 0.5, 0.3), soa::Precision::float64);
  setup.forces.gravity = {0, -9.81, 0};
  models::Obstacle floor;
  floor.restitution = 0.5;
  floor.friction = 0.3;
  setup.obstacles.push_back(floor);
  const double radius = 0.01;
  const double mass = 0.02;
  add_sphere(setup, {0, radius - mass * 9.81 / 1e5, 0}, {1, 0, 0}, radius, mass);
  setup.dt = solver::contact_time(setup).step;
  World world(setup, {});
  world.advance_to(static_cast<std::int64_t>(0.5 / setup.dt));
  EXPECT_NEAR(value(world, ParticleField::velocity, 0, 0), 5.0 / 7, 2e-3);
  EXPECT_NEAR(value(world, ParticleField::angular_velocity, 0, 2), -5.0 / 7 / radius, 0.5);
}

struct Totals {
  double momentum[3] = {};
  double angular_momentum[3] = {};
  double energy = 0;
  double size = 0;  // sum of the magnitudes of momenta
};

Totals totals(const World& world) {
  Totals sum;
  for (std::size_t row = 0; row < world.particles().rows(); ++row) {
    const double mass = value(world, ParticleField::mass, row, 0);
    const double radius = value(world, ParticleField::radius, row, 0);
    double x[3];
    double v[3];
    double w[3];
    for (std::size_t c = 0; c < 3; ++c) {
      x[c] = value(world, ParticleField::position, row, c) +
             value(world, ParticleField::residual, row, c);
      v[c] = value(world, ParticleField::velocity, row, c);
      w[c] = value(world, ParticleField::angular_velocity, row, c);
    }
    const double inertia = 0.4 * mass * radius * radius;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t a = (c + 1) % 3;
      const std::size_t b = (c + 2) % 3;
      sum.momentum[c] += mass * v[c];
      sum.angular_momentum[c] += mass * (x[a] * v[b] - x[b] * v[a]) + inertia * w[c];
      sum.energy += 0.5 * mass * v[c] * v[c] + 0.5 * inertia * w[c] * w[c];
      sum.size += mass * std::abs(v[c]);
    }
  }
  return sum;
}

// Forces come in exact pairs and act at one point, so both momenta stay but for rounding.
TEST(SphereContact, MomentumAndAngularMomentumStay) {
  for (ContactLaw law : {linear(1e4, 0.6, 0.5), hertz(1e7, 0.6, 0.5)}) {
    law.rolling_friction = 0.1;
    Setup setup = empty_setup(law, soa::Precision::float64);
    Emitter emitter;
    emitter.kind = EmitterKind::lattice;
    emitter.spacing = 0.0205;
    emitter.size = {0.21, 0.21, 0.21};
    emitter.count = solver::lattice_sites(emitter);
    emitter.speed.a = 1;
    emitter.angular_velocity = {10, -20, 5};
    emitter.radius = {solver::Spread::Kind::uniform, 0.007, 0.01};
    emitter.mass.a = 0.01;
    setup.emitters.push_back(emitter);
    setup.dt = solver::contact_time(setup).step;
    World world(setup, {});
    const Totals before = totals(world);
    ASSERT_GT(world.particles().rows(), 900U);
    world.advance_to(2000);
    const Totals after = totals(world);
    ASSERT_LT(after.energy, 0.9 * before.energy);  // they did collide
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(after.momentum[c], before.momentum[c], 1e-13 * before.size);
      EXPECT_NEAR(after.angular_momentum[c], before.angular_momentum[c], 1e-13 * before.size);
    }
  }
}

}  // namespace
}  // namespace salvo
