// The forces one by one: formulas, closed forms and statistics.   [Bourg &
// Bywalec 1.1, 3.2-3.4, 3.6, 18.4.2]
#include "kernels/forces.hpp"

#include <gtest/gtest.h>

#include <random>

#include "integrators/fixed_step.hpp"
#include "models/particle.hpp"
#include "solver/instants.hpp"
#include "tests/physics/flight.hpp"

namespace salvo::tests {

namespace {

using V = kernels::ScalarLane<double>;
using Vec = kernels::Vec3<V>;

std::array<double, 3> plain(Vec v) { return {v.x.value(), v.y.value(), v.z.value()}; }
Vec lanes(const std::array<double, 3>& v) { return {V(v[0]), V(v[1]), V(v[2])}; }

// The air of a scene at any place and step.
class Air {
 public:
  Air(models::ForceSettings forces, std::uint64_t seed, double dt)
      : settings_(solver::completed(std::move(forces))), model_(settings_), seed_(seed), dt_(dt) {}

  std::array<double, 3> at(const std::array<double, 3>& position, std::int64_t step = 0) const {
    std::vector<double> instants;
    solver::instant_coefficients(settings_, seed_, 0, dt_, step, 1, instants);
    return plain(model_.wind(lanes(position), instants.data()));
  }

 private:
  models::ForceSettings settings_;
  models::ParticleForces<V> model_;
  std::uint64_t seed_;
  double dt_;
};

}  // namespace

// ---- 1.1, 1.7 Newton's laws ---------------------------------------------------------------------

TEST(Newton, AccelerationIsTheSumOfForcesOverMass) {  // N2: (3, 0, 0) + (1, -4, 2) N on 2 kg
  solver::Setup setup = falling(0, 1);
  setup.integrator = IntegratorKind::explicit_euler;
  // A blast that lasts: J/tau = 3 N outward from (-1, 0, 0).
  setup.forces.blasts = {{{-1, 0, 0}, 0, 3e9, 1e9, 1, 0}};
  // Drag of 1 kg/s on a body at rest in a wind.
  setup.forces.linear_drag = 1;
  setup.forces.windy = true;
  setup.forces.wind.velocity = {1, -4, 2};
  const Particle p = Flight(setup, {0, 0, 0}, {0, 0, 0}, 2).after(1);
  EXPECT_NEAR(p.velocity[0], 2, 1e-14);
  EXPECT_NEAR(p.velocity[1], -2, 1e-14);
  EXPECT_NEAR(p.velocity[2], 1, 1e-14);
}

TEST(Newton, APairThatAttractsEachOtherKeepsItsMomentum) {  // N1
  using integrators::SemiImplicitEuler;
  constexpr double m1 = 1;
  constexpr double m2 = 3;
  kernels::Motion<V> body1{lanes({-3, 0, 0}), lanes({0.25, -0.6, 0.3})};
  kernels::Motion<V> body2{lanes({1, 0, 0}), lanes({0, 0.3, 0})};
  const auto momentum = [&] { return plain(body1.velocity * V(m1) + body2.velocity * V(m2)); };
  for (int n = 0; n < 100'000; ++n) {
    const Vec on1 = kernels::point_gravity(body1.position, body2.position, V(m2), V(0.1));
    const Vec on2 = kernels::point_gravity(body2.position, body1.position, V(m1), V(0.1));
    body1 = SemiImplicitEuler::step(body1, V(0.01), [&](auto, auto, auto) { return on1; });
    body2 = SemiImplicitEuler::step(body2, V(0.01), [&](auto, auto, auto) { return on2; });
  }
  EXPECT_NEAR(momentum()[0], 0.25, 1e-12);
  EXPECT_NEAR(momentum()[1], 0.3, 1e-12);
  EXPECT_NEAR(momentum()[2], 0.3, 1e-12);
}

// ---- 3.2 gravity --------------------------------------------------------------------------------

TEST(PointGravity, IsTheBooksFieldOfTheEarth) {
  constexpr double gm = 6.673e-11 * 5.98e24;
  struct Row {
    double altitude, g;
  };
  const Row rows[] = {{0, 9.803495445}, {8848, 9.776360},   {1e4, 9.772836},
                      {4e5, 8.680863},  {2.02e7, 0.564823}, {3.5786e7, 0.224439}};
  for (const Row& row : rows) {
    const double r = 6.38e6 + row.altitude;
    const auto a = plain(kernels::point_gravity(lanes({0, r, 0}), lanes({0, 0, 0}), V(gm), V(0)));
    EXPECT_EQ(a[0], 0);
    EXPECT_NEAR(-a[1], row.g, row.altitude == 0 ? 6e-10 : 6e-7) << row.altitude;
  }
  EXPECT_NEAR(rows[0].g, 9.8, 0.05);              // printed
  EXPECT_NEAR(70 * rows[0].g, 686.244681, 6e-7);  // on 70 kg
  // 70 kg pull the Earth as strongly.
  const auto earth = plain(
      kernels::point_gravity(lanes({0, 6.38e6, 0}), lanes({0, 0, 0}), V(6.673e-11 * 70), V(0)));
  EXPECT_NEAR(-earth[1], 1.1476e-22, 5e-27);
  EXPECT_NEAR(-earth[1] * 5.98e24, 686.244681, 6e-7);
}

TEST(PointGravity, PullsToItsCentreAndIsSoftened) {
  const auto a =
      plain(kernels::point_gravity(lanes({1, 2, 3}), lanes({4, 6, 3}), V(250), V(std::sqrt(75.0))));
  EXPECT_NEAR(a[0], 250 * 3 / 1000.0, 1e-14);  // r^2 + softening^2 = 100
  EXPECT_NEAR(a[1], 250 * 4 / 1000.0, 1e-14);
  EXPECT_EQ(a[2], 0);
  const auto centre = plain(kernels::point_gravity(lanes({1, 2, 3}), lanes({1, 2, 3}), V(9), V(0)));
  EXPECT_EQ(centre, (std::array<double, 3>{0, 0, 0}));
}

TEST(PointGravity, HoldsACircularOrbit) {
  for (const auto integrator : {IntegratorKind::runge_kutta_4, IntegratorKind::velocity_verlet}) {
    solver::Setup setup = falling(0, 2 * pi / 3000);
    setup.integrator = integrator;
    setup.forces.point_gravity = {{{0, 0, 0}, 1, 0}};
    Flight flight(setup, {1, 0, 0}, {0, 0, 1});
    const double tolerance = integrator == IntegratorKind::runge_kutta_4 ? 1e-9 : 3e-5;
    for (int quarter = 1; quarter <= 13; ++quarter) {
      const Particle p = flight.after(750 * quarter);
      EXPECT_NEAR(p.position[0], std::cos(quarter * pi / 2), tolerance * quarter);
      EXPECT_NEAR(p.position[2], std::sin(quarter * pi / 2), tolerance * quarter);
      const double r = std::hypot(p.position[0], p.position[1], p.position[2]);
      EXPECT_NEAR(speed(p) * speed(p) / 2 - 1 / r, -0.5, 1e-11);
    }
  }
}

TEST(UniformGravity, PullsInAnyDirection) {
  solver::Setup setup = falling(0, 0.125);
  setup.forces.gravity = {3, -8, 0.5};
  const Particle p = Flight(setup, {0, 0, 0}, {0, 0, 0}).after(8);
  EXPECT_EQ(p.velocity, (std::array<double, 3>{3, -8, 0.5}));
}

// ---- 3.3 dry friction: an obstacle has one coefficient ------------------------------------------

namespace {

// Speed, after a second, of a block of 10 kg pushed from rest along level ground.
double speed_under_a_push(double force, double friction) {
  solver::Setup setup = falling(9.81, 0.01);
  setup.forces.gravity[0] = force / 10;
  models::Obstacle ground;
  ground.restitution = 0;
  ground.friction = friction;
  setup.obstacles = {ground};
  return speed(Flight(setup, {0, 0, 0}, {0, 0, 0}, 10).at_time(1));
}

}  // namespace

TEST(DryFriction, OfWoodHoldsUpToItsLimit) {  // F1: 37.278 N
  EXPECT_EQ(speed_under_a_push(30, 0.38), 0);
  EXPECT_EQ(speed_under_a_push(37, 0.38), 0);
  EXPECT_EQ(speed_under_a_push(37.277, 0.38), 0);
  EXPECT_GT(speed_under_a_push(37.279, 0.38), 0);
  EXPECT_GT(speed_under_a_push(40, 0.38), 0);
  const double a = speed_under_a_push(40, 0.2);
  EXPECT_NEAR(a, 2.038, 1e-10);
  EXPECT_NEAR(40 - 10 * a, 19.62, 1e-9);                        // N, of friction
  EXPECT_NEAR(speed_under_a_push(37.278, 0.2), 1.7658, 1e-10);  // just past the limit
}

TEST(DryFriction, OfTable3_1) {
  struct Row {
    const char* surfaces;
    double at_rest, sliding;
    double percent;  // by which friction falls; the book prints 54 for glass
  };
  const Row rows[] = {{"dry glass on glass", 0.94, 0.4, 57.4},
                      {"dry iron on iron", 1.1, 0.15, 86.4},
                      {"dry rubber on pavement", 0.55, 0.4, 27.3},
                      {"dry steel on steel", 0.78, 0.42, 46.2},
                      {"dry Teflon on Teflon", 0.04, 0.04, 0},
                      {"dry wood on wood", 0.38, 0.2, 47.4},
                      {"ice on ice", 0.1, 0.03, 70},
                      {"oiled steel on steel", 0.10, 0.08, 20}};
  for (const Row& row : rows) {
    const double limit = row.at_rest * 10 * 9.81;
    EXPECT_EQ(speed_under_a_push(0.999 * limit, row.at_rest), 0) << row.surfaces;
    EXPECT_GT(speed_under_a_push(1.001 * limit, row.at_rest), 0) << row.surfaces;
    const double a = speed_under_a_push(limit, row.sliding);
    EXPECT_NEAR(a, (row.at_rest - row.sliding) * 9.81, 1e-9) << row.surfaces;
    EXPECT_NEAR(100 * a / (limit / 10), row.percent, 0.05) << row.surfaces;
  }
}

// ---- 3.4 drag -----------------------------------------------------------------------------------

TEST(Drag, OpposesTheFlow) {  // DR1
  const auto x = [](Vec v) { return v.x.value(); };
  EXPECT_EQ(x(kernels::linear_drag(lanes({5, 0, 0}), V(2), V(1))), -10);
  EXPECT_EQ(x(kernels::linear_drag(lanes({-5, 0, 0}), V(2), V(1))), 10);
  EXPECT_EQ(x(kernels::linear_drag(lanes({5, 0, 0}), V(2), V(0.25))), -2.5);
  EXPECT_EQ(x(kernels::quadratic_drag(lanes({5, 0, 0}), V(0.5))), -12.5);
  EXPECT_EQ(x(kernels::quadratic_drag(lanes({-5, 0, 0}), V(0.5))), 12.5);
  const auto a = plain(kernels::quadratic_drag(lanes({3, 4, 12}), V(2)));
  EXPECT_EQ(a, (std::array<double, 3>{-2 * 13 * 3, -2 * 13 * 4, -2 * 13 * 12}));
}

// ---- 3.6 buoyancy -------------------------------------------------------------------------------

// BU1, BU2: a cube of 0.5 m, as the sphere of its volume, at any depth.
TEST(Buoyancy, OfTheBooksCube) {
  const double radius = std::cbrt(3 * 0.125 / (4 * pi));
  EXPECT_NEAR(radius, 0.3101752454, 5e-11);
  struct Row {
    double density, force;
  };
  for (const Row row : {Row{1000, 1225}, Row{1025, 1255.625}, Row{1.225, 1.500625}}) {
    for (const double height : {-2.25, -33.0}) {
      solver::Setup setup = falling(9.8, 0.01);
      setup.forces.buoyancy = true;
      setup.forces.air_density = row.density;
      const Particle p = Flight(setup, {0, height, 0}, {0, 0, 0}, 1, 0, radius).at_time(1);
      EXPECT_NEAR(p.velocity[1] + 9.8, row.force, 1e-9) << row.density;
    }
  }
}

TEST(Buoyancy, OfABalloonInAir) {  // BU2: 6285.803301 N on a sphere of 5 m
  solver::Setup setup = falling(9.8, 0.01);
  setup.forces.buoyancy = true;
  constexpr double mass = 100;
  const Particle p = Flight(setup, {0, 0, 0}, {0, 0, 0}, mass, 0, 5).at_time(1);
  EXPECT_NEAR((p.velocity[1] + 9.8) * mass, 6285.803301, 1e-6);
}

TEST(Buoyancy, KeepsANeutralParticleAtRest) {
  solver::Setup setup = falling(9.8, 0.01);
  setup.forces.buoyancy = true;
  setup.forces.quadratic_drag = true;
  setup.forces.air_density = 1025;
  const double mass = 1025 * 4 / 3.0 * pi * 0.3 * 0.3 * 0.3;
  const Particle p = Flight(setup, {1, 2, 3}, {0, 0, 0}, mass, 0.1, 0.3).after(3333);
  EXPECT_NEAR(p.position[1], 2, 1e-11);
  EXPECT_NEAR(p.velocity[1], 0, 1e-12);
  EXPECT_EQ(p.position[0], 1);
}

// ---- wind
// -----------------------------------------------------------------------------------------

TEST(Wind, PowerLaw) {
  models::ForceSettings forces;
  forces.windy = true;
  forces.wind.velocity = {6, 0, -3};
  forces.wind.profile = models::WindProfile::power_law;
  forces.wind.ground = 2;
  const Air air(forces, 1, 0.01);
  for (const double height : {0.01, 0.5, 3.0, 10.0, 33.0, 300.0}) {
    const auto wind = air.at({7, 2 + height, 9});
    const double factor = std::pow(height / 10, 1 / 7.0);
    EXPECT_NEAR(wind[0], 6 * factor, 1e-13) << height;
    EXPECT_EQ(wind[1], 0);
    EXPECT_NEAR(wind[2], -3 * factor, 1e-13) << height;
  }
  for (const double height : {0.0, -0.1, -33.0}) {
    EXPECT_EQ(air.at({7, 2 + height, 9})[0], 0) << height;
  }
}

TEST(Wind, LogLaw) {
  models::ForceSettings forces;
  forces.windy = true;
  forces.wind.velocity = {6, 0, 0};
  forces.wind.profile = models::WindProfile::log_law;
  forces.wind.roughness = 0.1;
  forces.wind.reference_height = 20;
  forces.up = {0, 0, 3};  // heights along z; its length does not count
  const Air air(forces, 1, 0.01);
  for (const double height : {0.11, 0.5, 3.0, 20.0, 300.0}) {
    EXPECT_NEAR(air.at({7, 5, height})[0], 6 * std::log(height / 0.1) / std::log(200.0), 1e-13);
  }
  for (const double height : {0.1, 0.05, 0.0, -9.0}) EXPECT_EQ(air.at({7, 5, height})[0], 0);
  EXPECT_NEAR(air.at({0, 0, 20})[0], 6, 1e-14);
}

TEST(Wind, UniformIsTheSameEverywhere) {
  models::ForceSettings forces;
  forces.windy = true;
  forces.wind.velocity = {6, 1, -2};
  const Air air(forces, 1, 0.01);
  EXPECT_EQ(air.at({7, -5, 3}), (std::array<double, 3>{6, 1, -2}));
}

// ---- gusts
// ----------------------------------------------------------------------------------------

namespace {

models::ForceSettings gusty() {
  models::ForceSettings forces;
  forces.gusty = true;
  forces.gust.standard_deviation = {2, 0.5, 1.25};
  forces.gust.length = 50;
  forces.gust.speed = 4;
  forces.gust.direction = {3, 0, 4};  // unit: 0.6, 0, 0.8
  return forces;
}

struct Sums {
  int count = 0;
  std::array<double, 3> sum{};
  std::array<double, 3> square{};
  std::array<double, 3> cross{};  // xy, yz, zx

  void add(const std::array<double, 3>& v) {
    ++count;
    for (std::size_t c = 0; c < 3; ++c) {
      sum[c] += v[c];
      square[c] += v[c] * v[c];
      cross[c] += v[c] * v[(c + 1) % 3];
    }
  }
  double mean(std::size_t axis) const { return sum[axis] / count; }
  double deviation(std::size_t axis) const { return std::sqrt(square[axis] / count); }
  double correlation(std::size_t axis) const {
    return cross[axis] / count / deviation(axis) / deviation((axis + 1) % 3);
  }
};

}  // namespace

// Eight harmonics average exactly over a wavelength, in space at one time and in time at one place.
TEST(Gust, HasItsStandardDeviationOverAWavelengthAndAPeriod) {
  const models::ForceSettings forces = gusty();
  constexpr int points = 33;
  const double period = forces.gust.length / forces.gust.speed;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Air air(forces, seed, period / points);
    Sums space;
    Sums time;
    for (int i = 0; i < points; ++i) {
      const double s = forces.gust.length * i / points;
      space.add(air.at({0.6 * s, 9, 0.8 * s}, 7));
      time.add(air.at({1, 2, 3}, i));
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(space.mean(axis), 0, 1e-12);
      EXPECT_NEAR(time.mean(axis), 0, 1e-12);
      EXPECT_NEAR(space.deviation(axis), forces.gust.standard_deviation[axis], 1e-12);
      EXPECT_NEAR(time.deviation(axis), forces.gust.standard_deviation[axis], 1e-12);
    }
  }
}

TEST(Gust, AxesAreIndependentOverSeeds) {
  const models::ForceSettings forces = gusty();
  constexpr int seeds = 9999;
  Sums sums;
  for (int seed = 0; seed < seeds; ++seed) {
    sums.add(Air(forces, static_cast<std::uint64_t>(seed), 0.01).at({5, 0, 11}, 333));
  }
  const double standard_error = 1 / std::sqrt(static_cast<double>(seeds));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double sigma = forces.gust.standard_deviation[axis];
    EXPECT_NEAR(sums.mean(axis), 0, 5 * sigma * standard_error) << axis;
    EXPECT_NEAR(sums.deviation(axis), sigma, 5 * sigma * standard_error) << axis;
    EXPECT_NEAR(sums.correlation(axis), 0, 5 * standard_error) << axis;
  }
}

TEST(Gust, IsCarriedAlongAtItsSpeed) {
  const models::ForceSettings forces = gusty();
  const Air air(forces, 5, 0.125);
  for (const std::int64_t step : {1, 3, 333}) {
    const double way = forces.gust.speed * 0.125 * static_cast<double>(step);
    const auto now = air.at({1 + 0.6 * way, 2, 3 + 0.8 * way}, step);
    const auto start = air.at({1, 2, 3}, 0);
    for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(now[axis], start[axis], 1e-11);
    // Across its direction nothing changes.
    const auto across = air.at({1 + 0.8 * 9, -5, 3 - 0.6 * 9}, 0);
    for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(across[axis], start[axis], 1e-11);
  }
}

TEST(Gust, TakesDirectionAndSpeedFromTheMeanWind) {
  models::ForceSettings forces = gusty();
  forces.gust.direction = {0, 0, 0};
  forces.gust.speed = 0;
  forces.windy = true;
  forces.wind.velocity = {0, 0, -5};
  const models::ForceSettings completed = solver::completed(forces);
  EXPECT_EQ(completed.gust.direction, (Triple{0, 0, -1}));
  EXPECT_EQ(completed.gust.speed, 5);
  forces.windy = false;
  EXPECT_EQ(solver::completed(forces).gust.direction, (Triple{1, 0, 0}));
  EXPECT_EQ(solver::completed(forces).gust.speed, 0);
}

TEST(Gust, OfNoDeviationIsStill) {
  models::ForceSettings forces = gusty();
  forces.gust.standard_deviation = {1, 0, 0};
  const Air air(forces, 5, 0.125);
  EXPECT_EQ(air.at({1, 2, 3}, 9)[1], 0);
  EXPECT_EQ(air.at({1, 2, 3}, 9)[2], 0);
  EXPECT_NE(air.at({1, 2, 3}, 9)[0], 0);
}

// ---- blasts
// ---------------------------------------------------------------------------------------

// The integral of the acceleration over time is J/m (r0/max(r, r0))^n, outward.
TEST(Blast, GivesItsImpulse) {
  constexpr double impulse = 2e-6;  // so weak that the particle stays where it is
  constexpr double mass = 3;
  for (const int exponent : {0, 1, 2, 3, 5}) {
    for (const double r : {0.25, 2.0, 3.0, 9.0}) {
      solver::Setup setup = falling(0, 1e-5);
      setup.forces.blasts = {{{1, 2, 3}, 0.0003, impulse, 0.001, 2, exponent}};
      const Triple outward{2 / 3.0, -1 / 3.0, 2 / 3.0};
      Flight flight(setup, {1 + r * outward[0], 2 + r * outward[1], 3 + r * outward[2]}, {0, 0, 0},
                    mass);
      EXPECT_EQ(speed(flight.after(29)), 0);       // not before its time
      const Particle p = flight.after(30 + 4000);  // 40 decay times
      const double wanted = impulse / mass * std::pow(2 / std::max(r, 2.0), exponent);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        // One end of the first step sees the blast that the other does not: dt/6 tau.
        EXPECT_NEAR(p.velocity[axis], wanted * outward[axis], wanted * 3e-3)
            << exponent << " " << r;
      }
    }
  }
}

TEST(Blast, DecaysExponentiallyFromItsTimeOn) {
  models::ForceSettings forces;
  forces.blasts = {{{0, 0, 0}, 0.5, 6, 0.2, 1, 3}, {{0, 0, 0}, 0.25, 1, 1, 1, 3}};
  std::vector<double> instants;
  solver::instant_coefficients(forces, 1, 0, 0.25, 0, 9, instants);
  const std::size_t stride = models::instant_coefficients(2);
  ASSERT_EQ(instants.size(), 19 * stride);
  for (std::size_t half_step = 0; half_step < 19; ++half_step) {
    const double t = 0.125 * static_cast<double>(half_step);
    const double* amplitude = instants.data() + half_step * stride + models::gust_coefficients;
    EXPECT_NEAR(amplitude[0], t < 0.5 ? 0 : 30 * std::exp(-(t - 0.5) / 0.2), 1e-13) << t;
    EXPECT_NEAR(amplitude[1], t < 0.25 ? 0 : std::exp(0.25 - t), 1e-15) << t;
  }
}

TEST(Blast, HasNoDirectionInItsMiddle) {
  const auto a = plain(kernels::blast(lanes({1, 2, 3}), lanes({1, 2, 3}), V(9), V(1), 3));
  EXPECT_EQ(a, (std::array<double, 3>{0, 0, 0}));
}

// The coefficients of an instant are a function of its step: those of a long pass are those of
// short ones.
TEST(Instants, DoNotDependOnThePassTheyAreIn) {
  models::ForceSettings forces = solver::completed(every_force());
  const std::size_t stride = models::instant_coefficients(forces.blasts.size());
  std::vector<float> whole;
  solver::instant_coefficients(forces, 3, -0.7, 0.013, 5, 33, whole);
  for (std::int64_t step = 0; step < 33; ++step) {
    std::vector<float> single;
    solver::instant_coefficients(forces, 3, -0.7, 0.013, 5 + step, 1, single);
    ASSERT_EQ(single.size(), 3 * stride);
    for (std::size_t i = 0; i < single.size(); ++i) {
      EXPECT_EQ(single[i], whole[2 * static_cast<std::size_t>(step) * stride + i]);
    }
  }
}

}  // namespace salvo::tests
