// Many spheres that touch against statics, kinetic theory and what is known of packings and heaps.
#include <gtest/gtest.h>

#include <numbers>
#include <vector>

#include "tests/physics/spheres.hpp"

namespace salvo::tests {
namespace {

using solver::Spread;

std::int64_t steps_of(double time, const solver::Setup& setup) {
  return static_cast<std::int64_t>(time / setup.dt);
}

// A column of n spheres: the k-th contact from above carries k of them, the ground all.
TEST(SpherePacking, ContactsOfAColumnCarryWhatIsAboveThem) {
  constexpr std::size_t spheres = 8;
  constexpr double radius = 0.01;
  constexpr double mass = 0.02;
  for (const ContactLaw& law : {linear(1e4, 0.05), hertz(1e7, 0.05)}) {
    solver::Setup setup = touching_setup(law);
    setup.forces.gravity = {0, -9.81, 0};
    setup.obstacles.push_back(ground(law));
    for (std::size_t k = 0; k < spheres; ++k) {
      add_sphere(setup, {0, radius + static_cast<double>(k) * 2 * radius, 0}, {0, 0, 0}, radius,
                 mass);
    }
    setup.dt = solver::contact_time(setup).step;
    World world(setup, {});
    world.advance_to(steps_of(1, setup));
    const auto depth = [&](double force, double effective_radius) {
      if (law.kind == ContactLawKind::linear_spring) return force / law.normal_stiffness;
      const double factor = 4.0 / 3 * models::effective_young(law) * std::sqrt(effective_radius);
      return std::pow(force / factor, 2.0 / 3);
    };
    const double on_ground = depth(spheres * mass * 9.81, radius);
    EXPECT_NEAR(radius - position(world, 0)[1], on_ground, 1e-6 * on_ground);
    for (std::size_t k = 0; k + 1 < spheres; ++k) {
      const double wanted = depth(static_cast<double>(spheres - 1 - k) * mass * 9.81, radius / 2);
      EXPECT_NEAR(overlap(world, k, k + 1), wanted, 1e-6 * wanted) << k;
    }
  }
}

// ---- a gas that cools ---------------------------------------------------------------------------

// Free cooling of a granular gas: T = T0/(1 + t/tau)^2 with 1/tau = (1 - e^2) w/6 and Enskog's
// frequency of collisions w = 4 n d^2 g sqrt(pi T/m), g = (1 - f/2)/(1 - f)^3 at the volume
// fraction f.   [Haff 1983; Carnahan & Starling 1969]
TEST(SpherePacking, FreeCoolingFollowsHaffsLaw) {
  constexpr double radius = 0.005;
  constexpr double diameter = 2 * radius;
  constexpr double mass = 1e-3;
  constexpr double restitution = 0.9;
  const ContactLaw law = linear(1.2e5, restitution);
  solver::Setup setup = touching_setup(law, Precision::float32);
  constexpr int side = 13;
  constexpr double spacing = 1.737 * diameter;  // f = 0.1
  constexpr double half = 0.5 * side * spacing;
  Obstacle box = hollow_box({0, 0, 0}, {half, half, half}, law);
  box.restitution = 1;
  setup.obstacles.push_back(box);
  Emitter gas = lattice({0, 0, 0}, {2 * half, 2 * half, 2 * half}, spacing, radius, mass);
  gas.speed.a = 1;
  setup.emitters.push_back(gas);
  setup.dt = 2 * solver::contact_time(setup).step;
  World world(setup, {});
  const std::size_t count = world.particles().rows();
  ASSERT_EQ(count, static_cast<std::size_t>(side * side * side));

  const auto temperature = [&] {  // over the mass, m^2/s^2
    return 2 * totals(world).kinetic / (3 * mass * static_cast<double>(count));
  };
  // Away from the walls, where spheres gather a little.
  const auto density = [&] {
    std::size_t within = 0;
    for (std::size_t row = 0; row < count; ++row) {
      const Triple x = position(world, row);
      const double most = std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])});
      within += most < 0.8 * half ? 1 : 0;
    }
    return static_cast<double>(within) / std::pow(1.6 * half, 3);
  };
  // Some collisions each until the speeds are spread as in a gas.
  const double start = 0.06;
  world.advance_to(steps_of(start, setup));
  const double first = temperature();
  double n = 0;
  constexpr int looks = 10;
  const double time = 0.3;
  std::vector<double> slowed;  // sqrt(T0/T) - 1 = t/tau
  for (int look = 1; look <= looks; ++look) {
    world.advance_to(steps_of(start + time * look / looks, setup));
    n += density() / looks;
    slowed.push_back(std::sqrt(first / temperature()) - 1);
  }
  const double last = temperature();
  const double rate = slowed.back() / time;
  // The form of the law, whatever its rate. Where T decays as an exponential, so does sqrt(T) with
  // half the rate, and half the time is far off the line.
  constexpr double bend = 0.04;
  double worst = 0;
  for (int look = 2; look < looks; ++look) {
    const double on_line = slowed.back() * look / looks;
    worst = std::max(worst, std::abs(slowed[static_cast<std::size_t>(look) - 1] / on_line - 1));
  }
  RecordProperty("off_the_straight_line", std::to_string(worst));
  EXPECT_LT(worst, bend);
  const double exponential = std::sqrt(1 + slowed.back()) - 1;
  EXPECT_GT(std::abs(exponential / (0.5 * slowed.back()) - 1), 3 * bend);

  const double f = n * std::numbers::pi / 6 * std::pow(diameter, 3);
  const double g = (1 - 0.5 * f) / std::pow(1 - f, 3);
  const double frequency = 4 * n * diameter * diameter * g * std::sqrt(std::numbers::pi * first);
  const double wanted = (1 - restitution * restitution) * frequency / 6;
  RecordProperty("cooling_rate_over_theory", std::to_string(rate / wanted));
  EXPECT_LT(last, 0.4 * first);
  EXPECT_NEAR(f, 0.105, 0.01);
  // Near the walls a sphere has fewer others to meet.
  EXPECT_NEAR(rate / wanted, 1, 0.1);
}

// ---- impacts one after the other ----------------------------------------------------------------

// Balls of one mass hand on the speed of the first: between the last two it is all there, a hair
// apart so that each impact ends before the next begins.
TEST(SpherePacking, OneBallInOneBallOutOfNewtonsCradle) {
  constexpr std::size_t balls = 5;
  constexpr double radius = 0.01;
  constexpr double mass = 0.0329;  // steel
  constexpr double gap = 2e-5;
  const ContactLaw steel = hertz(210e9, 1);
  for (const Precision precision : {Precision::float32, Precision::float64}) {
    solver::Setup setup = touching_setup(steel, precision);
    for (std::size_t k = 0; k < balls; ++k) {
      const double x = k == 0 ? -0.005 : static_cast<double>(k) * (2 * radius + gap);
      add_sphere(setup, {x, 0, 0}, {k == 0 ? 1.0 : 0.0, 0, 0}, radius, mass);
    }
    setup.dt = solver::contact_time(setup).step;
    World world(setup, {});
    world.advance_to(steps_of(0.008, setup));
    const double out = velocity(world, balls - 1)[0];
    double slowest = 0;
    for (std::size_t k = 0; k + 1 < balls; ++k) {
      slowest = std::max(slowest, std::abs(velocity(world, k)[0]));
    }
    RecordProperty(precision == Precision::float32 ? "out_float" : "out", std::to_string(out));
    RecordProperty(precision == Precision::float32 ? "left_float" : "left",
                   std::to_string(slowest));
    EXPECT_NEAR(out, 1, 0.001);
    EXPECT_LT(slowest, 0.001);
    EXPECT_NEAR(totals(world).kinetic, 0.5 * mass, 1e-3 * mass);
  }
}

// ---- at rest under gravity ----------------------------------------------------------------------

// Spheres without friction settle to the random close packing, 0.64, hardly ever below 0.60; the
// ground carries them all.   [Scott & Kilgour 1969; Berryman 1983]
TEST(SpherePacking, FrictionlessSpheresSettleToTheRandomClosePacking) {
  ContactLaw law = linear(1e4, 0.4);
  solver::Setup setup = touching_setup(law, Precision::float32);
  setup.forces.gravity = {0, -9.81, 0};
  setup.obstacles.push_back(hollow_box({0, 0.5, 0}, {0.05, 0.5, 0.05}, law));
  Emitter emitter = lattice({0, 0.185, 0}, {0.1, 0.36, 0.1}, 0.011, 0.005, 5e-4);
  emitter.radius = {Spread::Kind::uniform, 0.0038, 0.005};  // so that they do not crystallize
  emitter.jitter = 2e-4;
  emitter.speed.a = 0.5;
  setup.emitters.push_back(emitter);
  setup.dt = 2 * solver::contact_time(setup).step;
  World world(setup, {});
  const std::size_t count = world.particles().rows();
  ASSERT_GT(count, 2000U);
  world.advance_to(steps_of(0.8, setup));

  const double lowest = 0.02;
  const double highest = 0.14;
  const double across = 0.03;
  double filled = 0;
  double on_ground = 0;
  for (std::size_t row = 0; row < count; ++row) {
    const Triple x = position(world, row);
    const double r = value(world, ParticleField::radius, row);
    on_ground += std::max(0.0, r - x[1]) * law.normal_stiffness;
    if (x[1] < lowest || x[1] > highest) continue;
    if (std::abs(x[0]) > across || std::abs(x[2]) > across) continue;
    filled += 4.0 / 3 * std::numbers::pi * r * r * r;
  }
  const double fraction = filled / ((highest - lowest) * 4 * across * across);
  const double weight = static_cast<double>(count) * 5e-4 * 9.81;
  RecordProperty("packing_fraction", std::to_string(fraction));
  EXPECT_GT(fraction, 0.62);
  EXPECT_LT(fraction, 0.65);
  EXPECT_NEAR(on_ground, weight, 0.01 * weight);
  EXPECT_LT(totals(world).kinetic, 1e-4 * static_cast<double>(count) * 5e-4 * 9.81 * 0.1);
}

// What stays on a platform of a pile whose rest fell over the edge, deg. The sides are smooth.
double angle_of_repose(double friction, double rolling_friction, double time) {
  ContactLaw law = linear(5e3, 0.3, friction);
  law.rolling_friction = rolling_friction;
  solver::Setup setup = touching_setup(law, Precision::float32);
  setup.forces.gravity = {0, -9.81, 0};
  constexpr double length = 0.3;
  constexpr double width = 0.05;
  Obstacle platform = ground(law);
  platform.shape = ObstacleShape::box;
  platform.center = {0.5 * length, -0.05, 0};
  platform.half_size = {0.5 * length, 0.05, width};
  setup.obstacles.push_back(platform);
  Obstacle wall = ground(law);
  wall.axis = {1, 0, 0};
  setup.obstacles.push_back(wall);
  for (const double side : {-1.0, 1.0}) {
    wall.center = {0, 0, 0.5 * side * width};
    wall.axis = {0, 0, -side};
    wall.friction = 0;
    setup.obstacles.push_back(wall);
  }
  Emitter emitter = lattice({0.5 * length, 0.11, 0}, {length, 0.22, width}, 0.0102, 0.005, 5e-4);
  emitter.radius = {Spread::Kind::uniform, 0.0044, 0.005};
  emitter.jitter = 1e-4;
  setup.emitters.push_back(emitter);
  setup.domain = {true, {-1, -0.1, -1}, {2, 2, 1}};
  setup.on_bad = solver::BadRowPolicy::remove;
  setup.dt = 2 * solver::contact_time(setup).step;
  World world(setup, {});
  world.advance_to(steps_of(time, setup));
  EXPECT_GT(world.removed(), 300U);
  EXPECT_GT(world.particles().rows(), 300U);

  // A straight line through the highest spheres of each stretch.
  constexpr std::size_t stretches = 10;
  constexpr double from = 0.08;
  std::vector<double> top(stretches, 0);
  for (std::size_t row = 0; row < world.particles().rows(); ++row) {
    const Triple x = position(world, row);
    if (x[0] < from || x[0] >= from + 0.02 * stretches) continue;
    double& highest = top[static_cast<std::size_t>((x[0] - from) / 0.02)];
    highest = std::max(highest, x[1] + value(world, ParticleField::radius, row));
  }
  double sum_xy = 0;
  double sum_xx = 0;
  for (std::size_t i = 0; i < stretches; ++i) {
    const double x = 0.02 * (static_cast<double>(i) - 0.5 * (stretches - 1));
    sum_xy += x * top[i];
    sum_xx += x * x;
  }
  return std::atan(-sum_xy / sum_xx) * 180 / std::numbers::pi;
}

// Heaps of spheres stand at 20 to 40 degrees, ours in between, and steeper the more the spheres
// resist to slide and to roll.   [Zhou, Xu, Yu & Zulli, Phys. Rev. E 64, 021301 (2001); Powder
// Technol. 125, 45 (2002)]
TEST(SpherePacking, AngleOfReposeGrowsWithFriction) {
  const double rough = angle_of_repose(0.5, 0.2, 1.6);
  const double smooth = angle_of_repose(0.15, 0.01, 0.8);
  RecordProperty("angle_of_repose", std::to_string(rough));
  RecordProperty("angle_of_repose_smooth", std::to_string(smooth));
  EXPECT_GT(rough, 23);
  EXPECT_LT(rough, 33);
  EXPECT_LT(smooth, rough - 5);
}

}  // namespace
}  // namespace salvo::tests
