// Two spheres, or a sphere and a wall, against exact solutions: restitution, slip, rolling,
// cohesion, momentum and energy.
#include <gtest/gtest.h>

#include <numbers>
#include <string>
#include <vector>

#include "kernels/shapes.hpp"
#include "tests/physics/spheres.hpp"

namespace salvo::tests {
namespace {

std::int64_t steps_of(double time, const solver::Setup& setup) {
  return static_cast<std::int64_t>(time / setup.dt);
}

// ---- head-on ------------------------------------------------------------------------------------

// Relative speed after a head-on impact over that before it, for spheres that touch at the start.
double measured_restitution(const ContactLaw& law, double finer,
                            Precision precision = Precision::float64) {
  solver::Setup setup = touching_setup(law, precision);
  add_sphere(setup, {-0.01, 0, 0}, {1, 0, 0}, 0.01, 0.02);
  add_sphere(setup, {0.015, 0, 0}, {-0.5, 0, 0}, 0.015, 0.05);
  setup.dt = solver::contact_time(setup).step / finer;
  World world(setup, {});
  world.advance_to(steps_of(0.1, setup));
  return (velocity(world, 1)[0] - velocity(world, 0)[0]) / 1.5;
}

// The damping follows from the restitution by an exact formula under both laws. What is left is the
// step's error: of first order, because the dashpot sees the velocity of half a step before.
TEST(SphereContact, HeadOnImpactsHaveTheirRestitution) {
  for (const double e : {0.9, 0.8, 0.5, 0.2}) {
    for (const ContactLaw& law : {linear(2e4, e), hertz(1e7, e)}) {
      const std::string which =
          std::string(law.kind == ContactLawKind::linear_spring ? "linear" : "Hertz") +
          ", restitution " + std::to_string(e);
      double coarser = 0;
      for (const double finer : {1.0, 4.0, 16.0, 64.0}) {
        const double error = std::abs(measured_restitution(law, finer) - e);
        EXPECT_LT(error, 0.02 / finer) << which;
        // Under Hertz's law there are errors of other orders beside it, of the other sign.
        if (coarser > 0 && law.kind == ContactLawKind::linear_spring) {
          EXPECT_NEAR(coarser / error, 4, 0.8) << which << ", " << finer;
        }
        coarser = error;
      }
    }
  }
}

// Without a dashpot the leapfrog keeps the energy, to second order in the step at which the impact
// begins and ends.
TEST(SphereContact, UndampedImpactsLoseNothing) {
  for (const ContactLaw& law : {linear(2e4, 1), hertz(1e7, 1)}) {
    EXPECT_NEAR(measured_restitution(law, 1), 1, 5e-3);
    EXPECT_NEAR(measured_restitution(law, 8), 1, 1e-4);
  }
}

// In float the error is that of the step as long as it is larger than rounding: single precision
// adds what thousands of rounded steps add, and no more.
TEST(SphereContact, FloatFollowsDouble) {
  for (const ContactLaw& law : {linear(2e4, 0.5), hertz(1e7, 0.5)}) {
    for (const double finer : {1.0, 4.0, 16.0}) {
      EXPECT_NEAR(measured_restitution(law, finer, Precision::float32),
                  measured_restitution(law, finer), 5e-6)
          << finer;
    }
  }
}

// A row of spheres with gaps between them that one sphere runs into, eight impacts in all.
std::vector<double> speeds_of_row(const ContactLaw& law, double finer, Precision precision) {
  solver::Setup setup = touching_setup(law, precision);
  for (int k = 0; k < 6; ++k) {
    add_sphere(setup, {0.0205 * k, 0, 0}, {k == 0 ? 2.0 : 0.0, 0, 0}, 0.01, 0.01 + 0.003 * (k % 3));
  }
  setup.dt = solver::contact_time(setup).step / finer;
  World world(setup, {});
  world.advance_to(steps_of(0.02, setup));
  std::vector<double> speeds;
  for (std::size_t row = 0; row < 6; ++row) speeds.push_back(velocity(world, row)[0]);
  return speeds;
}

double greatest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double greatest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    greatest = std::max(greatest, std::abs(a[i] - b[i]));
  }
  return greatest;
}

// Double shows the order of the step over a chain of impacts; float stays close to double at every
// step, far below the error of the step itself.
TEST(SphereContact, AChainOfImpactsConvergesAndFloatFollowsIt) {
  for (const ContactLaw& law : {linear(2e4, 0.8), hertz(2e7, 0.8)}) {
    const std::vector<double> exact = speeds_of_row(law, 256, Precision::float64);
    double coarser = 0;
    for (const double finer : {1.0, 4.0, 16.0}) {
      const std::vector<double> twice = speeds_of_row(law, finer, Precision::float64);
      const std::vector<double> single = speeds_of_row(law, finer, Precision::float32);
      const double error = greatest_difference(twice, exact);
      EXPECT_LT(greatest_difference(single, twice), 0.02 * error + 5e-6) << finer;
      EXPECT_TRUE(coarser == 0 || error < coarser / 2.5)
          << finer << ": " << coarser << ", " << error;
      coarser = error;
    }
    EXPECT_LT(coarser, 2e-3);
    EXPECT_GT(exact[5], 0.9);
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

// Deepest overlap of a Hertz impact: (15 m* v^2/(16 E* sqrt(R*)))^(2/5); it lasts 2.943 of that
// over the speed, 2.9432.. = 4 sqrt(pi) Gamma(7/5)/(... ) = (4/5) sqrt(pi) Gamma(2/5)/Gamma(9/10).
// [Landau & Lifshitz, Theory of Elasticity, section 9, problem 1]
TEST(SphereContact, HertzOverlapAndDurationAreTheExactOnes) {
  const ContactLaw law = hertz(5e7, 1);
  solver::Setup setup = touching_setup(law);
  add_sphere(setup, {-0.01, 0, 0}, {0.5, 0, 0}, 0.01, 0.01);
  add_sphere(setup, {0.01, 0, 0}, {-0.5, 0, 0}, 0.01, 0.01);
  setup.dt = solver::contact_time(setup).step / 20;
  World world(setup, {});
  double deepest = 0;
  std::int64_t steps = 0;
  do {
    world.advance_to(++steps);
    deepest = std::max(deepest, overlap(world, 0, 1));
  } while (overlap(world, 0, 1) > 0);
  const double young = models::effective_young(law);
  const double exact = std::pow(15 * 0.005 * 1 / (16 * young * std::sqrt(0.005)), 0.4);
  EXPECT_NEAR(deepest, exact, 1e-4 * exact);
  const double factor = 0.8 * std::sqrt(std::numbers::pi) * std::tgamma(0.4) / std::tgamma(0.9);
  EXPECT_NEAR(factor, 2.9432, 1e-4);
  // Counted in whole steps.
  EXPECT_NEAR(static_cast<double>(steps) * setup.dt, factor * exact, 1.5 * setup.dt);
  EXPECT_GT(steps, 150);
}

// ---- oblique impacts on a wall ------------------------------------------------------------------

constexpr double radius = 0.01;  // m
constexpr double mass = 0.02;    // kg
constexpr double inertia = 0.4 * mass * radius * radius;

// A sphere that touches the ground and comes down at an angle, after its impact.
World after_impact(const ContactLaw& law, double along, double down, double finer = 8) {
  solver::Setup setup = touching_setup(law);
  setup.obstacles.push_back(ground(law));
  add_sphere(setup, {0, radius, 0}, {along, -down, 0}, radius, mass);
  setup.dt = solver::contact_time(setup).step / finer;
  World world(setup, {});
  world.advance_to(steps_of(5 * solver::contact_time(setup).duration, setup));
  EXPECT_GT(velocity(world, 0)[1], 0);
  return world;
}

// A sphere that slips through the whole impact leaves with the tangential momentum less by mu times
// the normal impulse, and the spin of that impulse.
TEST(SphereContact, ObliqueImpactThatSlipsTakesCoulombsImpulse) {
  const double mu = 0.1;
  const double e = 0.7;
  for (const ContactLaw& law : {linear(1e6, e, mu), hertz(1e9, e, mu)}) {
    const World world = after_impact(law, 3, 1);
    const double impulse = mass * (1 + velocity(world, 0)[1]);
    EXPECT_NEAR(velocity(world, 0)[1], e, 5e-3);
    // Under Hertz's law the spring grows stiffer within the first steps, and slip is late for it.
    const double late = law.kind == ContactLawKind::hertz_mindlin ? 1e-2 : 1e-9;
    EXPECT_NEAR(velocity(world, 0)[0], 3 - mu * impulse / mass, late * mu * impulse / mass);
    // The lever is the distance of the center from the plane, a little less than the radius.
    const double turn = -mu * impulse * radius / inertia;
    EXPECT_NEAR(spin(world, 0)[2], turn, 0.03 * std::abs(turn));
    EXPECT_LT(std::abs(spin(world, 0)[2]), std::abs(turn));
  }
}

// Without slip the tangential spring swings with the mass 2/7 m: its frequency over that of the
// normal spring is sqrt(7/2 k_t/k_n), and the point of contact leaves with -cos(pi) of that times
// the velocity with which it came. k_t/k_n = 2/7 turns it back whole; a quarter of it leaves the
// point at rest, the sphere rolling at 5/7 of its speed.   [Schaefer, Dippel & Wolf 1996]
TEST(SphereContact, ObliqueImpactThatSticksTurnsThePointOfContactBack) {
  for (const double ratio : {2.0 / 7, 0.25 * 2 / 7, 0.4, 2.25 * 2 / 7}) {
    ContactLaw law = linear(1e9, 1, 1e5);
    law.tangential_ratio = ratio;
    law.tangential_damping = 0;
    const World world = after_impact(law, 0.7, 1, 32);
    const double swings = std::sqrt(3.5 * ratio);
    const double expected = 0.7 * std::cos(std::numbers::pi * swings);
    EXPECT_NEAR(velocity(world, 0)[0] + radius * spin(world, 0)[2], expected, 0.005) << ratio;
    // What the impulse at the point of contact takes from the path it gives to the spin.
    EXPECT_NEAR(velocity(world, 0)[0], 0.7 - 2.0 / 7 * (0.7 - expected), 0.003) << ratio;
    EXPECT_NEAR(velocity(world, 0)[1], 1, 1e-3);
  }
}

// ---- slip, rolling ------------------------------------------------------------------------------

solver::Setup sphere_on_ground(const ContactLaw& law, Triple gravity) {
  solver::Setup setup = touching_setup(law);
  setup.forces.gravity = gravity;
  setup.obstacles.push_back(ground(law));
  add_sphere(setup, {0, radius + mass * gravity[1] / law.normal_stiffness, 0}, {0, 0, 0}, radius,
             mass);
  setup.dt = solver::contact_time(setup).step;
  return setup;
}

// A sliding sphere that friction brings to roll keeps 5/7 of its speed, and of its energy.
TEST(SphereContact, SlidingEndsInRollingAtFiveSevenths) {
  solver::Setup setup = sphere_on_ground(linear(1e5, 0.5, 0.3), {0, -9.81, 0});
  setup.emitters[0].velocity = {1, 0, 0};
  World world(setup, {});
  // Slip ends after 2/7 v/(mu g).
  const double slip_time = 2.0 / 7 / (0.3 * 9.81);
  world.advance_to(steps_of(0.5 * slip_time, setup));
  EXPECT_NEAR(velocity(world, 0)[0], 1 - 1.0 / 7, 1e-3);
  EXPECT_NEAR(spin(world, 0)[2], -2.5 / 7 / radius, 0.2);
  world.advance_to(steps_of(0.5, setup));
  EXPECT_NEAR(velocity(world, 0)[0], 5.0 / 7, 1e-3);
  EXPECT_NEAR(spin(world, 0)[2], -5.0 / 7 / radius, 0.1);
  const double energy = 0.5 * mass;
  EXPECT_NEAR(value(world, ParticleField::friction_loss, 0), 2.0 / 7 * energy, 1e-3 * energy);
}

// The greatest rolling moment mu_r R N slows a rolling sphere by 5/7 mu_r g, and then holds it.
TEST(SphereContact, RollingFrictionBringsARollingSphereToRest) {
  ContactLaw law = linear(1e5, 0.5, 0.8);
  law.rolling_friction = 0.05;
  solver::Setup setup = sphere_on_ground(law, {0, -9.81, 0});
  setup.emitters[0].velocity = {0.3, 0, 0};
  setup.emitters[0].angular_velocity = {0, 0, -0.3 / radius};
  World world(setup, {});
  const double deceleration = 5.0 / 7 * law.rolling_friction * 9.81;
  world.advance_to(steps_of(0.5, setup));
  EXPECT_NEAR(velocity(world, 0)[0], 0.3 - 0.5 * deceleration, 2e-3);
  EXPECT_NEAR(spin(world, 0)[2], -velocity(world, 0)[0] / radius, 0.1);
  world.advance_to(steps_of(2, setup));
  EXPECT_NEAR(velocity(world, 0)[0], 0, 1e-6);
  EXPECT_NEAR(spin(world, 0)[2], 0, 1e-4);
  EXPECT_NEAR(position(world, 0)[0], 0.3 * 0.3 / (2 * deceleration), 1e-3);
}

// On a slope the moment of gravity about the point of contact is m g R sin: rolling friction holds
// it up to tan = mu_r; beyond, the sphere rolls down with what is left.
TEST(SphereContact, RollingFrictionHoldsASphereOnASlopeUpToItsCoefficient) {
  ContactLaw law = linear(1e5, 0.5, 0.8);
  law.rolling_friction = 0.05;
  for (const double part : {0.9, 1.2}) {
    const double angle = std::atan(part * law.rolling_friction);
    const Triple gravity{9.81 * std::sin(angle), -9.81 * std::cos(angle), 0};
    World world(sphere_on_ground(law, gravity), {});
    world.advance_to(steps_of(1, world.setup()));
    const double rest = part < 1 ? 0 : 5.0 / 7 * (gravity[0] + law.rolling_friction * gravity[1]);
    EXPECT_NEAR(velocity(world, 0)[0], rest, 1e-5 + 0.02 * rest) << part;
  }
}

// Coulomb friction holds a block of friction mu on a slope up to tan = mu; a sphere rolls on any.
TEST(SphereContact, WithoutRollingFrictionASphereRollsDownAnySlope) {
  const Triple gravity{0.0981, -9.81, 0};
  World world(sphere_on_ground(linear(1e5, 0.5, 0.5), gravity), {});
  world.advance_to(steps_of(1, world.setup()));
  EXPECT_NEAR(velocity(world, 0)[0], 5.0 / 7 * gravity[0], 1e-3);
}

// ---- walls that move --------------------------------------------------------------------------

// A belt brings a sphere at rest to roll on it: friction at the point of contact gives it 2/7 of
// the belt's speed.
TEST(SphereContact, ABeltTakesASphereAlongAtTwoSevenths) {
  solver::Setup setup = sphere_on_ground(linear(1e5, 0.5, 0.3), {0, -9.81, 0});
  setup.obstacles[0].motion.velocity = {1, 0, 0};
  World world(setup, {});
  world.advance_to(steps_of(0.5, setup));
  EXPECT_NEAR(velocity(world, 0)[0], 2.0 / 7, 1e-3);
  EXPECT_NEAR(spin(world, 0)[2], 5.0 / 7 / radius, 0.1);
}

// A sphere that rolls on a turntable goes round in a circle, at 2/7 of the table's rate wherever it
// is: after half a turn it has come back, a diameter aside.   [Weckesser, Am. J. Phys. 65, 736
// (1997)]
TEST(SphereContact, ASphereOnATurntableCirclesAtTwoSevenths) {
  const double rate = 10;
  const double speed = 0.1;
  solver::Setup setup = sphere_on_ground(linear(1e6, 0.5, 0.8), {0, -9.81, 0});
  setup.obstacles[0].motion.angular_velocity = {0, rate, 0};
  Emitter& ball = setup.emitters[0];
  ball.position[0] = 0.1;
  ball.velocity = {0, 0, speed};
  // Its point of contact goes with the table: w = y x (v - rate y x r)/R.
  ball.angular_velocity = {(speed + rate * 0.1) / radius, 0, 0};
  World world(setup, {});
  const double turn = 2.0 / 7 * rate;
  world.advance_to(steps_of(std::numbers::pi / turn, setup));
  EXPECT_NEAR(velocity(world, 0)[2], -speed, 0.02 * speed);
  EXPECT_NEAR(velocity(world, 0)[0], 0, 0.02 * speed);
  EXPECT_NEAR(position(world, 0)[0], 0.1 + 2 * speed / turn, 0.02 * speed / turn);
  EXPECT_NEAR(position(world, 0)[2], 0, 0.02 * speed / turn);
}

// When two spheres roll over each other the plane of contact turns, and the spring with it: it
// stays in the plane, and a step shortens it by no more than the cosine of its turn.
TEST(SphereContact, TheSpringTurnsWithThePlaneOfContact) {
  using D = kernels::ScalarLane<double>;
  using Vec = kernels::Vec3<D>;
  const kernels::ContactSprings<D> springs{D(1), D(3), D(1e4), D(1e-4), D(3)};
  const Vec still{D(0), D(0), D(0)};
  const auto turned = [&](const Vec& displacement, const Vec& normal) {
    return kernels::SlipSpring<D>(displacement, normal, still, springs, D(1), D(1e-5));
  };
  const Vec displacement{D(3e-6), D(-1e-6), D(2e-6)};
  const double length = norm(displacement).value();
  const Vec along = displacement * (D(1) / norm(displacement));
  const Vec across = kernels::any_perpendicular(along);
  for (const double angle : {0.0, 1e-3, 0.1, 1.0}) {
    const Vec normal = across * cos(D(angle)) + along * sin(D(angle));
    const auto spring = turned(displacement, normal);
    EXPECT_NEAR(dot(spring.after, normal).value(), 0, 1e-12 * length);
    EXPECT_NEAR(norm(spring.after).value(), std::cos(angle) * length, 1e-12 * length);
    EXPECT_NEAR(norm(spring.force - spring.after * D(1e4)).value(), 0, 1e-9 * length);
    EXPECT_GT(dot(spring.after, displacement).value(), 0);
  }
}

// ---- cohesion -----------------------------------------------------------------------------------

// Spheres that stick come apart at the force 4 pi R* gamma, whatever the elastic law: R* is R at a
// wall, R/2 between equals. The upper sphere hangs from a ceiling, the lower one from the upper one
// with a little less or more than the sphere's pull-off force as its weight. The loaded chain
// starts at rest where its springs hold it, so that nothing but the load decides.
// [Derjaguin, Muller & Toporov 1975, as a force that does not depend on the overlap]
TEST(SphereContact, CohesionHoldsUpToThePullOffForce) {
  const double gamma = 0.5;                          // J/m^2
  const double pull = 4 * std::numbers::pi * gamma;  // over R*
  for (ContactLaw law : {linear(1e4, 0.3), hertz(1e7, 0.3)}) {
    law.surface_energy = gamma;
    const auto rest = [&](double force, double effective_radius) {
      if (law.kind == ContactLawKind::linear_spring) return force / law.normal_stiffness;
      const double factor = 4.0 / 3 * models::effective_young(law) * std::sqrt(effective_radius);
      return std::pow(force / factor, 2.0 / 3);
    };
    for (const double part : {0.98, 1.02}) {
      const double weight = part * pull * radius / 2;
      const double heavy = weight / 9.81;
      const double light = 0.01 * heavy;
      solver::Setup setup = touching_setup(law);
      setup.forces.gravity = {0, -9.81, 0};
      Obstacle ceiling = ground(law);
      ceiling.axis = {0, -1, 0};
      setup.obstacles.push_back(ceiling);
      const double upper = -radius + rest(pull * radius - 1.01 * weight, radius);
      const double lower =
          upper - 2 * radius + rest(std::max(0.01, 1 - part) * pull * radius / 2, radius / 2);
      add_sphere(setup, {0, upper, 0}, {0, 0, 0}, radius, light);
      add_sphere(setup, {0, lower, 0}, {0, 0, 0}, radius, heavy);
      setup.dt = solver::contact_time(setup).step / 2;
      World world(setup, {});
      world.advance_to(steps_of(0.2, setup));
      EXPECT_NEAR(position(world, 0)[1], upper, 2e-4) << part;
      if (part < 1) {
        EXPECT_NEAR(position(world, 1)[1], lower, 1e-6) << part;
      } else {
        EXPECT_LT(position(world, 1)[1], lower - 0.02) << part;
      }
    }
  }
}

// ---- conservation -------------------------------------------------------------------------------

// A loose cloud of spinning spheres of different sizes that run into each other.
solver::Setup colliding_cloud(ContactLaw law, Precision precision, double size) {
  law.rolling_friction = law.turns() ? 0.1 : 0;
  solver::Setup setup = touching_setup(law, precision);
  Emitter emitter = lattice({0.1, 0.2, -0.1}, {size, size, size}, 0.0205, 0.01, 0.01);
  emitter.speed.a = 1;
  emitter.angular_velocity = {10, -20, 5};
  emitter.radius = {solver::Spread::Kind::uniform, 0.007, 0.01};
  emitter.mass = {solver::Spread::Kind::uniform, 0.005, 0.01};
  setup.emitters.push_back(emitter);
  setup.dt = solver::contact_time(setup).step;
  return setup;
}

// Forces come in exact pairs and act at one point, so both momenta stay but for rounding.
TEST(SphereContact, MomentumAndAngularMomentumStay) {
  for (const ContactLaw& law : {linear(1e4, 0.6, 0.5), hertz(1e7, 0.6, 0.5)}) {
    World world(colliding_cloud(law, Precision::float64, 0.21), {});
    const Totals before = totals(world);
    ASSERT_GT(world.particles().rows(), 900U);
    world.advance_to(2000);
    const Totals after = totals(world);
    ASSERT_LT(after.kinetic, 0.9 * before.kinetic);  // they did collide
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(after.momentum[c], before.momentum[c], 1e-13 * before.momenta);
      EXPECT_NEAR(after.angular_momentum[c], before.angular_momentum[c], 1e-13 * before.momenta);
    }
  }
}

Triple momentum_error(const World& world) { return world.diagnose().contacts->momentum_error; }

// Where nothing but contacts acts, what they gave a particle is what its momentum gained. If forces
// were not opposite the sum of all would show it: it is that of the momenta, and to rounding zero.
TEST(SphereContact, ContactImpulsesAreGainsOfMomentumAndOppositeInPairs) {
  for (const Precision precision : {Precision::float64, Precision::float32}) {
    const double rounding = precision == Precision::float64 ? 1e-15 : 1e-6;
    for (const ContactLaw& law : {linear(1e4, 0.6, 0.5), hertz(1e7, 0.6, 0.5), impulse(0.6, 0.5)}) {
      solver::Setup setup = colliding_cloud(law, precision, 0.21);
      if (law.kind == ContactLawKind::impulse) setup.dt = 1e-4;
      World world(setup, {});
      const std::size_t rows = world.particles().rows();
      std::vector<Triple> before;
      for (std::size_t row = 0; row < rows; ++row) before.push_back(velocity(world, row));
      world.advance_to(1000);
      const Totals after = totals(world);
      ASSERT_GT(after.impulses, 0.1 * after.momenta);
      for (std::size_t row = 0; row < rows; ++row) {
        const double own_mass = value(world, ParticleField::mass, row);
        for (std::size_t c = 0; c < 3; ++c) {
          EXPECT_NEAR(value(world, ParticleField::contact_impulse, row, c),
                      own_mass * (velocity(world, row)[c] - before[row][c]),
                      1000 * rounding * own_mass);
        }
      }
      for (const double error : momentum_error(world)) {
        EXPECT_LT(std::abs(error), rounding * after.impulses);
      }
    }
  }
}

// Obstacles and gravity change the momentum of all and yet are not in its error; a particle that is
// gone is, and so nothing is said any more.
TEST(SphereContact, TheErrorOfMomentumIsOfParticlesAmongThemselves) {
  const ContactLaw law = linear(1e4, 0.6, 0.5);
  solver::Setup setup = colliding_cloud(law, Precision::float64, 0.09);
  setup.forces.gravity = {0, -9.81, 0};
  setup.obstacles.push_back(hollow_box({0.1, 0.2, -0.1}, {0.05, 0.06, 0.05}, law));
  {
    World world(setup, {});
    world.advance_to(3000);
    ASSERT_GT(world.diagnose().contacts->wall_contacts, 0U);
    const Totals now = totals(world);
    EXPECT_GT(now.impulses, 2 * now.momenta);
    for (const double error : momentum_error(world))
      EXPECT_LT(std::abs(error), 1e-15 * now.impulses);
  }
  setup.emitters[0].life =
      solver::Spread{solver::Spread::Kind::uniform, 500 * setup.dt, 1500 * setup.dt};
  World world(setup, {});
  world.advance_to(400);
  for (const double error : momentum_error(world)) EXPECT_LT(std::abs(error), 1e-15);
  EXPECT_GT(world.diagnose().contacts->friction_loss, 0);
  world.advance_to(1000);
  ASSERT_GT(world.particles().rows(), 0U);
  for (const double error : momentum_error(world)) EXPECT_TRUE(std::isnan(error));
  EXPECT_TRUE(std::isnan(world.diagnose().contacts->damping_loss));
  EXPECT_TRUE(std::isnan(world.diagnose().contacts->friction_loss));
  setup.emitters[0].life = std::nullopt;
  setup.contact_law->energy_budget = false;
  for (const double error : momentum_error(World(setup, {}))) EXPECT_TRUE(std::isnan(error));
}

// What the normal springs and the cohesion of all contacts hold, J.
double stored_energy(const World& world) {
  const ContactLaw& law = *world.setup().contact_law;
  using D = kernels::ScalarLane<double>;
  const auto elastic = [&](double depth, double effective_radius) {
    const D d(depth);
    const D r(effective_radius);
    return law.kind == ContactLawKind::linear_spring
               ? kernels::LinearSpring<D>{D(law.normal_stiffness), D(0), D(0), D(0)}
                     .elastic_energy(d, r)
                     .value()
               : kernels::HertzMindlin<D>{D(models::effective_young(law)), D(0), D(0)}
                     .elastic_energy(d, r)
                     .value();
  };
  double energy = 0;
  const std::size_t rows = world.particles().rows();
  for (std::size_t i = 0; i < rows; ++i) {
    const double r = value(world, ParticleField::radius, i);
    const Triple x = position(world, i);
    for (std::size_t j = i + 1; j < rows; ++j) {
      const double other = value(world, ParticleField::radius, j);
      const double depth = overlap(world, i, j);
      if (depth <= 0) continue;
      const double reduced = r * other / (r + other);
      energy +=
          elastic(depth, reduced) - 4 * std::numbers::pi * reduced * law.surface_energy * depth;
    }
    for (const Obstacle& box : world.setup().obstacles) {
      for (std::size_t c = 0; c < 3; ++c) {
        const double depth = std::abs(x[c] - box.center[c]) + r - box.half_size[c];
        if (depth <= 0) continue;
        energy += elastic(depth, r) - 4 * std::numbers::pi * r * law.surface_energy * depth;
      }
    }
  }
  return energy;
}

double potential_energy(const World& world) {
  double energy = 0;
  for (std::size_t row = 0; row < world.particles().rows(); ++row) {
    energy -= value(world, ParticleField::mass, row) * world.setup().forces.gravity[1] *
              position(world, row)[1];
  }
  return energy;
}

// Greatest change of kinetic, potential and stored energy and losses together, over what there was.
double budget_gap(const solver::Setup& setup, double time) {
  World world(setup, {});
  const double before = totals(world).kinetic + potential_energy(world);
  double gap = 0;
  for (int look = 1; look <= 20; ++look) {
    world.advance_to(steps_of(time * look / 20, setup));
    const Totals now = totals(world);
    gap = std::max(gap, std::abs(now.kinetic + potential_energy(world) + stored_energy(world) +
                                 now.losses - before));
  }
  // There was something to account for.
  EXPECT_GT(totals(world).losses, 0.3 * before);
  return gap / before;
}

// The energy that friction and dashpots take is in the losses: the budget closes nearly to the
// second order of the step. What tangential springs hold is in the
// losses as long as they hold it: a contact that ends takes it along, because a spring beside a
// dashpot is still stretched when the force is gone.
TEST(SphereContact, EnergyGoesIntoTheLosses) {
  struct Case {
    const char* name;
    ContactLaw law;
  };
  ContactLaw sticky = linear(1e4, 0.6, 0.5);
  sticky.surface_energy = 0.1;
  for (const auto& [name, law] :
       {Case{"linear, frictionless", linear(1e4, 0.6)}, Case{"linear", linear(1e4, 0.6, 0.5)},
        Case{"linear, cohesive", sticky}, Case{"Hertz, frictionless", hertz(1e7, 0.6)},
        Case{"Hertz", hertz(1e7, 0.6, 0.5)}}) {
    solver::Setup setup = colliding_cloud(law, Precision::float64, 0.09);
    setup.forces.gravity = {0, -9.81, 0};
    setup.obstacles.push_back(hollow_box({0.1, 0.2, -0.1}, {0.05, 0.06, 0.05}, law));
    const double coarse = budget_gap(setup, 0.5);
    setup.dt /= 8;
    const double fine = budget_gap(setup, 0.5);
    EXPECT_LT(coarse, 0.005) << name;
    EXPECT_LT(fine, coarse / 12) << name;
  }
}

// A pile in which all has come to rest, held by friction: nothing is lost any more.
TEST(SphereContact, APileAtRestLosesNothing) {
  const ContactLaw law = linear(1e4, 0.3, 0.5);
  solver::Setup setup = colliding_cloud(law, Precision::float64, 0.09);
  setup.forces.gravity = {0, -9.81, 0};
  setup.obstacles.push_back(hollow_box({0.1, 0.2, -0.1}, {0.05, 0.06, 0.05}, law));
  World world(setup, {});
  world.advance_to(steps_of(3, setup));
  const Totals before = totals(world);
  world.advance_to(steps_of(4, setup));
  const Totals after = totals(world);
  EXPECT_NEAR(after.losses, before.losses, 1e-6 * before.losses);
}

}  // namespace
}  // namespace salvo::tests
