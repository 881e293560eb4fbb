// Projectiles against closed forms and the numbers of the book.   [Bourg &
// Bywalec 2.3, 3.4, 4.2, 6.1, 6.2]
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/physics/flight.hpp"

namespace salvo::tests {

namespace {

void expect_near(const std::array<double, 3>& got, const std::array<double, 3>& wanted,
                 double tolerance, const char* what = "") {
  for (std::size_t c = 0; c < 3; ++c)
    EXPECT_NEAR(got[c], wanted[c], tolerance) << what << " axis " << c;
}

}  // namespace

// ---- 6.1: no drag; velocity Verlet is exact, so three steps reach the end
// ---------------------------

TEST(SimpleTrajectories, OfTables6_1To6_4) {
  struct Row {
    const char* what;
    double speed, angle;
    double rise;  // of the target over the launch
    double time, range;
    double height;  // of the apex over the launch, over the target where that is lower
    double impact_speed;
  };
  const Row rows[] = {
      {"6-1, 45 deg", 50, 45, 0, 7.215375318230, 255.102040816327, 63.775510204082, 50},
      {"6-1, 30 deg", 50, 30, 0, 5.102040816327, 220.924847904194, 31.887755102, 50},
      {"6-1, 60 deg", 50, 60, 0, 8.836993916168, 220.924847904194, 95.663265306, 50},
      {"6-1, 10 deg", 50, 10, 0, 1.771920180275, 87.250036562671, 3.846133878450, 50},
      {"6-1, 20 m/s", 20, 30, 0, 2.040816326531, 35.347975664671, 5.102040816327, 20},
      {"6-2, 45 deg", 50, 45, 20, 6.596630213376, 233.226097842898, 63.775510204082,
       45.912961132996},
      {"6-2, 20 m/s", 20, 30, 3, 1.675379858607, 29.018430370856, 5.102040816327, 0},
      {"6-3, 45 deg", 50, 45, -20, 7.742544718167, 273.740293692800, 83.775510204082,
       53.777318638995},
      {"6-3, 20 m/s", 20, 30, -3, 2.306284408328, 39.946017719288, 8.102040816327, 0},
      {"6-4, 100 m/s", 100, 0, -500, 10.101525445522, 1010.152544552211, 500, 140.712472794703},
      {"6-4, 60 m/s", 60, 0, -100, 4.517539514526, 271.052370871575, 100, 74.565407529229},
  };
  constexpr double g = 9.8;
  for (const Row& row : rows) {
    const Triple velocity{row.speed * std::cos(row.angle * degree),
                          row.speed * std::sin(row.angle * degree), 0};
    solver::Setup setup = falling(g, row.time / 3);
    setup.integrator = IntegratorKind::velocity_verlet;
    const Particle end = Flight(setup, {0, 0, 0}, velocity).after(3);
    EXPECT_NEAR(end.position[0], row.range, 1e-9) << row.what;
    EXPECT_NEAR(end.position[1], row.rise, 1e-9) << row.what;
    if (row.impact_speed != 0) {
      EXPECT_NEAR(speed(end), row.impact_speed, 1e-9) << row.what;
    }
    if (row.angle == 0) {  // dropped from its highest point
      EXPECT_NEAR(-end.position[1], row.height, 1e-9) << row.what;
      continue;
    }
    setup.dt = velocity[1] / g / 3;
    const Particle top = Flight(setup, {0, 0, 0}, velocity).after(3);
    EXPECT_NEAR(top.position[1] - std::min(row.rise, 0.0), row.height, 1e-9) << row.what;
    EXPECT_NEAR(top.velocity[1], 0, 1e-12) << row.what;
  }
}

// ---- 2.3, 6.2: quadratic drag
// ---------------------------------------------------------------------

TEST(QuadraticDrag, SlowsDownAsOneOverTime) {  // 2.3: v = v1/(1 + v1 k t), s = ln(1 + v1 k t)/k
  struct Row {
    double v1, k, t, v, s;
  };
  const Row rows[] = {{50, 0.01, 1, 33.333333333, 40.546510811},
                      {50, 0.01, 10, 8.333333333, 179.175946923},
                      {30, 0.02, 5, 7.5, 69.314718056},
                      {800, 0.001, 0.625, 533.333333, 405.465108}};
  for (const Row& row : rows) {
    solver::Setup setup = falling(0, row.t / 2000);
    setup.forces.quadratic_drag = true;
    // k = 1/2 rho (Cd A)/m
    const double drag_area = row.k * 3 / (0.5 * setup.forces.air_density);
    for (const double sign : {1.0, -1.0}) {
      const Particle end =
          Flight(setup, {0, 0, 0}, {0, 0, sign * row.v1}, 3, drag_area).after(2000);
      EXPECT_NEAR(sign * end.velocity[2], row.v, row.v * 1e-9);
      EXPECT_NEAR(sign * end.position[2], row.s, row.s * 2e-9);
    }
  }
}

TEST(QuadraticDrag, ReachesTheTerminalVelocitiesOfTable6_5) {
  struct Row {
    const char* what;
    double weight, area;
    double meters_per_second, kilometers_per_hour;
    double printed, tolerance;  // km/h: the book's are whole miles an hour, converted
  };
  const Row rows[] = {
      {"skydiver, free fall", 801, 0.84, 55.80056, 200.882, 201, 1},
      {"skydiver, parachute open", 801, 21.02, 11.15480, 40.157, 40, 1},
      {"baseball", 1.42, 4.19e-3, 33.26589, 119.757, 121, 0.02 * 121},
      {"golf ball", 0.5, 1.40e-3, 34.14939, 122.938, 116, 0.07 * 116},
      {"golf ball, before its weight was rounded", 0.445, 1.40e-3, 32.216469, 115.979288, 116, 0.5},
      {"raindrop", 3.34e-4, 1.29e-5, 9.19476, 33.101, 32, 0.04 * 32},
  };
  for (const Row& row : rows) {
    solver::Setup setup = falling(9.8, 0.01);
    setup.forces.quadratic_drag = true;
    const double mass = row.weight / 9.8;
    const Particle end = Flight(setup, {0, 0, 0}, {0, 0, 0}, mass, 0.5 * row.area).at_time(90);
    EXPECT_NEAR(-end.velocity[1], row.meters_per_second, row.meters_per_second * 1e-6) << row.what;
    EXPECT_NEAR(-end.velocity[1] * 3.6, row.kilometers_per_hour, row.kilometers_per_hour * 1e-5)
        << row.what;
    EXPECT_NEAR(-end.velocity[1] * 3.6, row.printed, row.tolerance) << row.what;
  }
}

// v = vt tanh(g t/vt), s = vt^2/g ln cosh(g t/vt)
TEST(QuadraticDrag, FallFollowsTheClosedForm) {
  solver::Setup setup = falling(9.8, 0.01);
  setup.forces.quadratic_drag = true;
  Flight skydiver(setup, {0, 0, 0}, {0, 0, 0}, 81.734694, 0.5 * 0.84);
  EXPECT_NEAR(skydiver.at_time(1).velocity[1], -9.700469727, 1e-7);
  EXPECT_NEAR(skydiver.at_time(5).velocity[1], -39.366176756, 1e-7);
  EXPECT_NEAR(skydiver.at_time(10).velocity[1], -52.568772733, 1e-7);
  EXPECT_NEAR(skydiver.at_time(10).position[1], -347.112236996, 1e-6);
  EXPECT_NEAR(skydiver.at_time(20).velocity[1], -55.701396804, 1e-7);
  // 95 % of the terminal velocity after 10.430041 s
  solver::Setup thousandth = setup;
  thousandth.dt = 10.430041 / 1000;
  Flight nearly_terminal(thousandth, {0, 0, 0}, {0, 0, 0}, 81.734694, 0.5 * 0.84);
  EXPECT_NEAR(-nearly_terminal.after(1000).velocity[1], 0.95 * 55.80056, 1e-5);
  const double vt = std::sqrt(2 * 81.734694 * 9.8 / (0.5 * 1.225 * 0.84));
  for (const double t : {3.0, 7.0, 33.0}) {
    Flight exact(setup, {0, 0, 0}, {0, 0, 0}, 81.734694, 0.5 * 0.84);
    const Particle p = exact.at_time(t);
    EXPECT_NEAR(p.velocity[1], -vt * std::tanh(9.8 * t / vt), 1e-10);
    EXPECT_NEAR(p.position[1], -vt * vt / 9.8 * std::log(std::cosh(9.8 * t / vt)), 1e-9);
  }
}

TEST(QuadraticDrag, ShortensAndSkewsATrajectory) {  // 6.2, Fig 6-10: 255.10 m, 7.215 s in vacuum
  constexpr double flight_time = 5.319491;
  constexpr int steps = 5000;
  solver::Setup setup = falling(9.8, flight_time / steps);
  setup.forces.quadratic_drag = true;
  const double component = 50 * std::sqrt(0.5);
  Flight flight(setup, {0, 0, 0}, {component, component, 0}, 1, 0.5 * pi * 0.1 * 0.1);
  double apex = 0;
  double apex_range = 0;
  for (int n = 1; n <= steps; ++n) {
    const Particle p = flight.after(n);
    if (p.position[1] > apex) {
      apex = p.position[1];
      apex_range = p.position[0];
    }
  }
  const Particle end = flight.after(steps);
  EXPECT_NEAR(end.position[0], 99.52049, 2e-5);
  EXPECT_NEAR(end.position[1], 0, 2e-5);
  EXPECT_NEAR(apex, 35.277544, 3e-6);
  EXPECT_GT(apex_range, end.position[0] / 2);  // the descent is steeper
}

// ---- 4.2, 6.2: linear drag and wind, the revised cannon
// -----------------------------------------------

namespace {

struct Shot {
  double mass = 100;
  double drag = 30;         // kg/s
  double wind_force = 100;  // Cw Vw, N
  double wind_angle = 90;   // degrees from x towards z; where the wind comes from
};

// The book's force -Cw Vw is that of linear drag in a wind of -Cw Vw/Cd.
solver::Setup setup_of(const Shot& shot, double dt) {
  solver::Setup setup = falling(9.8, dt);
  setup.forces.linear_drag = shot.drag;
  setup.forces.windy = true;
  const double wind = -shot.wind_force / shot.drag;
  setup.forces.wind.velocity = {wind * std::cos(shot.wind_angle * degree), 0,
                                wind * std::sin(shot.wind_angle * degree)};
  return setup;
}

// 50 m/s from a barrel of 12 m at 25 degrees from upright, 10 m up.
Flight cannon(const Shot& shot, double dt = 0.01) {
  const double s = std::sin(25 * degree);
  const double c = std::cos(25 * degree);
  return Flight(setup_of(shot, dt), {12 * s, 10 + 12 * c, 0}, {50 * s, 50 * c, 0}, shot.mass);
}

}  // namespace

TEST(LinearDragAndWind, FollowTheCannonOf4_2) {  // CW1
  Flight flight = cannon({});
  const Particle p1 = flight.at_time(1);
  expect_near(p1.position, {23.327245, 55.580787, -0.453536}, 6e-7, "t = 1");
  expect_near(p1.velocity, {15.654165, 25.103861, -0.863939}, 6e-7, "t = 1");
  const Particle p2 = flight.at_time(2);
  expect_near(p2.position, {36.851493, 72.824348, -1.653463}, 6e-7, "t = 2");
  expect_near(p2.velocity, {11.596891, 10.130793, -1.503961}, 6e-7, "t = 2");
  const Particle p5 = flight.at_time(5);
  expect_near(p5.position, {59.791316, 59.482051, -8.034780}, 6e-7, "t = 5");
  expect_near(p5.velocity, {4.714944, -15.266518, -2.589566}, 6e-7, "t = 5");
  const Particle ground = cannon({}, 7.838750812 / 800).after(800);
  expect_near(ground.position, {68.801246, 0, -16.075995}, 6e-7, "ground");
  const Particle apex = cannon({}, 2.900411864 / 300).after(300);
  EXPECT_NEAR(apex.position[1], 77.180204, 6e-7);
  EXPECT_NEAR(apex.velocity[1], 0, 1e-7);
  const Particle last = flight.at_time(99);  // CW3
  expect_near(last.velocity, {0, -32.666667, -3.333333}, 4e-7, "terminal");
  EXPECT_NEAR(last.position[0], 75.507796, 6e-7);
}

TEST(LinearDragAndWind, WindComesFromItsAngle) {  // CW4
  const auto at5 = [](double angle, double force) {
    Shot shot;
    shot.wind_angle = angle;
    shot.wind_force = force;
    return cannon(shot).at_time(5).position;
  };
  EXPECT_NEAR(at5(0, 100)[0], 51.756536, 6e-7);
  EXPECT_NEAR(at5(180, 100)[0], 67.826096, 6e-7);
  EXPECT_NEAR(at5(90, 100)[2], -8.034780, 6e-7);
  EXPECT_NEAR(at5(270, 100)[2], 8.034780, 6e-7);
  expect_near(at5(0, 0), {59.791316, 59.482051, 0}, 6e-7, "no wind");
}

TEST(LinearDragAndWind, TendToTheVacuumWithTheCoefficient) {  // CW5
  struct Row {
    double drag, difference, tolerance;
  };
  const Row rows[] = {{10, -30.1748, 6e-5},
                      {1, -3.55479, 6e-6},
                      {0.1, -0.361588, 6e-7},
                      {0.01, -0.0362207, 6e-8},
                      {1e-6, -3.62276e-6, 6e-12}};
  for (const Row& row : rows) {
    Shot shot;
    shot.drag = row.drag;
    shot.wind_force = 0;
    const double vacuum =
        10 + 12 * std::cos(25 * degree) + 50 * std::cos(25 * degree) * 5 - 9.8 * 12.5;
    EXPECT_NEAR(vacuum, 124.952640, 6e-7);
    EXPECT_NEAR(cannon(shot).at_time(5).position[1] - vacuum, row.difference, row.tolerance)
        << row.drag;
  }
}

// CW8: the largest error of a coordinate at 5 s.
TEST(LinearDragAndWind, EachIntegratorErrsAsMuchAsItsOrderSays) {
  const auto error = [](IntegratorKind integrator, double dt) {
    solver::Setup setup = setup_of({}, dt);
    setup.integrator = integrator;
    const double s = std::sin(25 * degree);
    const double c = std::cos(25 * degree);
    Flight flight(setup, {12 * s, 10 + 12 * c, 0}, {50 * s, 50 * c, 0}, 100);
    const Particle got = flight.at_time(5);
    const Particle exact = cannon({}, 0.001).at_time(5);
    double largest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      largest = std::max(largest, std::abs(got.position[axis] - exact.position[axis]));
    }
    return largest;
  };
  EXPECT_NEAR(error(IntegratorKind::explicit_euler, 0.05), 0.6554, 6e-5);
  EXPECT_NEAR(error(IntegratorKind::semi_implicit_euler, 0.05), 2.3836, 6e-5);
  EXPECT_NEAR(error(IntegratorKind::runge_kutta_4, 0.05), 3.72e-8, 6e-11);
  EXPECT_NEAR(error(IntegratorKind::explicit_euler, 0.025), 0.3270, 6e-5);
  EXPECT_NEAR(error(IntegratorKind::semi_implicit_euler, 0.025), 1.1900, 6e-5);
  EXPECT_NEAR(error(IntegratorKind::runge_kutta_4, 0.025), 2.31e-9, 1e-11);
  for (const auto kind : {IntegratorKind::improved_euler, IntegratorKind::velocity_verlet}) {
    EXPECT_NEAR(error(kind, 0.05) / error(kind, 0.025), 4, 0.1);
  }
}

TEST(LinearDragAndWind, MatchTheClosedFormPointsOf6_2) {
  Flight flight(setup_of({}, 0.01), {0, 0, 0}, {50, 50, 0}, 100);
  expect_near(flight.at_time(1).position, {43.196963220, 38.752312523, -0.453535785}, 1e-8, "1 s");
  const Particle p5 = flight.at_time(5);
  expect_near(p5.position, {129.478306642, 50.737466981, -8.034779557}, 1e-8, "5 s");
  EXPECT_NEAR(p5.velocity[0], 11.156508007, 1e-8);
  EXPECT_NEAR(p5.velocity[1], -14.221240094, 1e-8);
  expect_near(flight.at_time(10).position, {158.368821939, -64.830214395, -22.775411871}, 1e-8,
              "10 s");
}

TEST(LinearDrag, ReachesTheLimitOfFig6_11) {  // printed -107.25 holds in feet only
  const auto fall = [](double g) {
    solver::Setup setup = falling(g, 0.01);
    setup.forces.linear_drag = 30;
    return Flight(setup, {0, 0, 0}, {0, 0, 0}, 100);
  };
  Flight feet = fall(32.174);
  EXPECT_NEAR(feet.at_time(3).velocity[1], -63.64343, 6e-6);
  EXPECT_NEAR(feet.at_time(6).velocity[1], -89.51891, 6e-6);
  EXPECT_NEAR(feet.at_time(9).velocity[1], -100.03910, 6e-6);
  EXPECT_NEAR(feet.at_time(15).velocity[1], -106.05526, 6e-6);
  EXPECT_NEAR(feet.at_time(30).velocity[1], -107.23343, 6e-6);
  EXPECT_NEAR(feet.at_time(90).velocity[1], -107.2467, 6e-5);
  EXPECT_NEAR(feet.at_time(90).velocity[1], -107.25, 0.005);
  Flight meters = fall(9.8);
  EXPECT_NEAR(meters.at_time(3).velocity[1], -19.38539, 6e-6);
  EXPECT_NEAR(meters.at_time(30).velocity[1], -32.66264, 6e-6);
  EXPECT_NEAR(meters.at_time(90).velocity[1], -32.66667, 6e-6);
}

TEST(LinearDrag, CoastsToRest) {  // 3.4, DR2: v = v1 e^(-C t/m)
  solver::Setup setup = falling(0, 0.01);
  setup.forces.linear_drag = 1000;
  const Particle p = Flight(setup, {0, 0, 0}, {10, 0, 0}, 10000).at_time(10);
  EXPECT_NEAR(p.velocity[0], 3.678794412, 1e-9);
  EXPECT_NEAR(p.position[0], 63.212055883, 1e-8);
}

}  // namespace salvo::tests
