// The step that contacts want: of what is fastest in them, whatever the particles.
#include "solver/contact_time.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "solver/world.hpp"

namespace salvo::solver {
namespace {

using std::numbers::pi;

// A cube of 64 spheres that fall into a hollow box and turn.
Setup falling(const models::ContactLaw& law, const Spread& radius) {
  Setup setup;
  setup.precision = soa::Precision::float64;
  setup.seed = 3;
  setup.contact_law = law;
  Emitter cube;
  cube.kind = EmitterKind::lattice;
  cube.count = 64;
  cube.spacing = 0.125;
  cube.size = {0.5, 0.5, 0.5};
  cube.velocity = {0.3, -1, 0.2};
  cube.mass = {Spread::Kind::constant, 0.002, 0};
  cube.radius = radius;
  cube.angular_velocity = {5, 0, 3};
  setup.emitters.push_back(cube);
  models::Obstacle box;
  box.shape = models::ObstacleShape::box;
  box.hollow = true;
  box.half_size = {0.3, 0.3, 0.3};
  box.restitution = law.restitution;
  box.friction = law.friction;
  setup.obstacles.push_back(box);
  return setup;
}

double energy(const World& world) {
  const Diagnostics d = world.diagnose();
  return d.kinetic_energy + d.potential_energy + d.contacts->rotational_energy +
         d.contacts->elastic_energy;
}

models::ContactLaw linear() {
  models::ContactLaw law;
  law.kind = models::ContactLawKind::linear_spring;
  law.normal_stiffness = 5e3;
  law.restitution = 0.9;
  return law;
}

models::ContactLaw hertz() {
  models::ContactLaw law;
  law.kind = models::ContactLawKind::hertz_mindlin;
  law.young_modulus = 2e6;
  law.poisson_ratio = 0.25;
  law.restitution = 1;
  return law;
}

TEST(ContactTime, IsHalfAPeriodOfTheLightestPair) {
  solver::Setup setup = falling(linear(), {Spread::Kind::constant, 0.05, 0});
  setup.emitters[0].mass = {Spread::Kind::uniform, 0.002, 0.2};
  const double impact = pi * std::sqrt(0.001 / 5e3);  // exact-set: a witness
  EXPECT_NEAR(contact_time(setup).duration, impact, 1e-12 * impact);
  setup.emitters[0].mass = {Spread::Kind::normal, 0.006, 0.001};  // within four deviations
  EXPECT_NEAR(contact_time(setup).duration, impact, 1e-12 * impact);
}

// Of spheres of one mass the largest is the stiffest: a wave crosses it soonest.
TEST(ContactTime, IsTheRayleighTimeOfTheLargestAtTheLeastMass) {
  const solver::Setup setup = falling(hertz(), {Spread::Kind::uniform, 0.0006, 0.06});
  const double density = 0.002 / (4.0 / 3.0 * pi * 0.06 * 0.06 * 0.06);
  const double shear = 2e6 / 2.5;
  const double rayleigh =
      pi * 0.06 * std::sqrt(density / shear) / (0.1631 * 0.25 + 0.8766);  // exact-set: a witness
  EXPECT_NEAR(contact_time(setup).duration, rayleigh, 1e-12 * rayleigh);
}

TEST(ContactTime, KnowsWhatIsFasterThanTheImpact) {
  models::ContactLaw law = linear();
  const auto time = [&] { return contact_time(falling(law, {Spread::Kind::constant, 0.05, 0})); };
  const double impact = time().duration;
  law.tangential_ratio = 1000;
  EXPECT_EQ(time().duration, impact);  // nothing slips
  law.friction = 0.5;
  EXPECT_NEAR(time().duration, impact / std::sqrt(3500.0), 1e-9 * impact);  // exact-set: a witness
  EXPECT_NE(std::string(time().of).find("tangential_ratio"), std::string::npos);
  law.tangential_ratio = 2.0 / 7;
  EXPECT_EQ(time().duration, impact);
  law.restitution = 0.05;
  const double damped = time().duration;
  EXPECT_LT(damped, impact);
  law.tangential_damping = 10;
  EXPECT_LT(time().duration, 0.2 * damped);
  EXPECT_NE(std::string(time().of).find("tangential_damping"), std::string::npos);
}

// At the chosen step, and with springs at the longest that is allowed, nothing gains energy.
TEST(ContactTime, StepsFollowTheContacts) {
  const Spread one{Spread::Kind::constant, 0.05, 0};
  const auto run = [](solver::Setup setup, double dt, const char* what) {
    setup.dt = dt;
    World world(setup, {widest_isa(), 1, 1});
    const double start = energy(world);
    const auto steps = static_cast<std::int64_t>(0.3 / setup.dt);
    for (int part = 1; part <= 10; ++part) {
      world.advance_to(steps * part / 10);
      EXPECT_LT(energy(world), start + 0.02 * std::abs(start)) << what << " dt " << dt;
    }
  };
  const auto try_both = [&](const models::ContactLaw& law, const Spread& radius, const char* what) {
    const solver::Setup setup = falling(law, radius);
    run(setup, contact_time(setup).step, what);
    if (law.kind == models::ContactLawKind::linear_spring) {
      run(setup, contact_time(setup).longest_step, what);
    }
  };
  models::ContactLaw law = linear();
  law.friction = 5;
  try_both(law, one, "friction");
  law.tangential_ratio = 100;
  try_both(law, one, "stiff slip spring");
  law.tangential_ratio = 2.0 / 7;
  law.restitution = 0.05;
  law.tangential_damping = 1;
  try_both(law, one, "damped slip");
  law.friction = 0.3;
  try_both(law, one, "damped slip, little friction");
  try_both(hertz(), {Spread::Kind::uniform, 0.0006, 0.06}, "radii 100:1 of one mass");
}

}  // namespace
}  // namespace salvo::solver
