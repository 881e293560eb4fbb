// The book's particle simulator without collisions: free fall, drag in still air and a constant
// push by the wind. [Bourg & Bywalec 8.1-8.3]
#include <gtest/gtest.h>

#include "tests/physics/flight.hpp"

namespace salvo::tests {

namespace {

// The defaults of chapter 8, with its 3.14159: 1 kg, radius 0.1 m, Cd 0.6, air of 1.23 kg/m^3,
// steps of 0.1 s.
constexpr double drag_area = 0.6 * 3.14159 * 0.1 * 0.1;

solver::Setup chapter8(double wind) {
  solver::Setup setup = plain_setup();
  setup.dt = 0.1;
  setup.integrator = IntegratorKind::semi_implicit_euler;
  setup.forces.gravity = {0, -9.8, 0};
  setup.forces.air_density = 1.23;
  setup.forces.quadratic_drag = true;
  setup.forces.drag_law = models::DragLaw::book_still_air;
  setup.forces.windy = wind != 0;
  setup.forces.wind.velocity = {wind, 0, 0};
  return setup;
}

void expect_state(const Particle& p, std::array<double, 2> position,
                  std::array<double, 2> velocity) {
  for (std::size_t c = 0; c < 2; ++c) {
    EXPECT_NEAR(p.position[c], position[c], 6e-10);
    EXPECT_NEAR(p.velocity[c], velocity[c], 6e-10);
  }
  EXPECT_EQ(p.position[2], 0);
}

}  // namespace

TEST(ParticleSimulator, FallsFreely) {  // 8.1: y_n = y0 - g dt^2 n (n + 1)/2
  solver::Setup setup = chapter8(0);
  setup.forces.quadratic_drag = false;
  Flight flight(setup, {0, 400, 0}, {0, 0, 0});
  EXPECT_NEAR(flight.after(10).position[1], 394.61, 1e-10);
  EXPECT_NEAR(400 - 4.9 - flight.after(10).position[1], 0.49, 1e-10);  // too low: g dt t/2
  EXPECT_NEAR(flight.after(33).position[1], 400 - 9.8 * 0.01 * 33 * 34 / 2, 1e-10);
  Flight drop(setup, {0, 120, 0}, {0, 0, 0});  // the drop of 8.4 before its first impact
  EXPECT_NEAR(drop.after(18).position[1], 103.242, 1e-10);
  EXPECT_NEAR(drop.after(18).velocity[1], -17.64, 1e-12);
  EXPECT_NEAR(drop.after(20).position[1], 99.420, 1e-10);
  EXPECT_NEAR(drop.after(20).velocity[1], -19.60, 1e-12);
}

TEST(ParticleSimulator, FallsWithDragAndWind) {  // 8.3, acceptance D
  Flight flight(chapter8(10), {0, 1000, 0}, {0, 0, 0}, 1, drag_area);
  expect_state(flight.after(1), {0.011592467, 999.902}, {0.115924671, -0.98});
  expect_state(flight.after(10), {0.626897120, 994.700358674}, {1.122672462, -9.490809877});
  expect_state(flight.after(50), {10.682884427, 909.689398740}, {3.217432179, -27.199417587});
  expect_state(flight.after(100), {27.534516630, 767.229649521}, {3.420875673, -28.919281205});
  const Particle last = flight.after(400);
  EXPECT_NEAR(last.velocity[0], 3.427411091, 6e-10);
  EXPECT_NEAR(last.velocity[1], -28.974530097, 6e-10);
  EXPECT_NEAR(speed(last), 29.176541, 6e-7);
}

TEST(ParticleSimulator, FallsWithDragAlone) {
  Flight flight(chapter8(0), {0, 1000, 0}, {0, 0, 0}, 1, drag_area);
  EXPECT_NEAR(flight.after(50).velocity[1], -27.272575035, 6e-10);
  EXPECT_NEAR(flight.after(100).velocity[1], -29.018518334, 6e-10);
  const double before = flight.after(899).position[1];
  const Particle last = flight.after(900);
  EXPECT_NEAR(last.velocity[1], -29.07536, 6e-6);        // terminal
  EXPECT_NEAR(before - last.position[1], 2.9075, 5e-5);  // a step's way then
  // The exact solution at 5 s, which half the error of half the step approaches.
  solver::Setup fine = chapter8(0);
  fine.integrator = IntegratorKind::runge_kutta_4;
  fine.dt = 0.01;
  EXPECT_NEAR(Flight(fine, {0, 1000, 0}, {0, 0, 0}, 1, drag_area).after(500).velocity[1],
              -27.143094, 6e-7);
}

TEST(ParticleSimulator, WindForceIsTheBooks) {  // 1.15924671 N on 1 kg at rest
  solver::Setup setup = chapter8(10);
  setup.forces.gravity = {0, 0, 0};
  Flight flight(setup, {0, 0, 0}, {0, 0, 0}, 1, drag_area);
  EXPECT_NEAR(flight.after(1).velocity[0] / 0.1, 1.15924671, 6e-9);
  EXPECT_EQ(flight.after(1).velocity[1], 0);
}

TEST(ParticleSimulator, TheMisprinted2_14159WouldShow) {  // the text's pi: 0.790247 N, 35.2153 m/s
  constexpr double misprinted = drag_area * 2.14159 / 3.14159;
  solver::Setup push = chapter8(10);
  push.forces.gravity = {0, 0, 0};
  EXPECT_NEAR(Flight(push, {0, 0, 0}, {0, 0, 0}, 1, misprinted).after(1).velocity[0] / 0.1,
              0.790247, 6e-7);
  Flight fall(chapter8(0), {0, 1000, 0}, {0, 0, 0}, 1, misprinted);
  EXPECT_NEAR(fall.after(900).velocity[1], -35.2153, 6e-5);
}

TEST(ParticleSimulator, AreaIsTheBooks) {  // A = 0.0314159 m^2 of a sphere of 0.1 m, Cd 0.6
  solver::Setup setup = chapter8(0);
  setup.emitters = {particles_from(1, {0, 0, 0}, {0, 0, 0})};
  setup.emitters[0].radius = constant(0.1);
  setup.emitters[0].drag_coefficient = 0.6;
  const solver::World world(setup, {solver::widest_isa(), 1, 1});
  EXPECT_NEAR(read_particle(world.particles(), 0).drag_area / 0.6, 0.0314159, 5e-8);
}

TEST(ParticleSimulator, ZeroVelocityHasNoDrag) {
  solver::Setup setup = chapter8(0);
  setup.forces.gravity = {0, 0, 0};
  const Particle p = Flight(setup, {3, 3, 3}, {0, 0, 0}, 1, drag_area).after(33);
  EXPECT_EQ(p.position, (std::array<double, 3>{3, 3, 3}));
  EXPECT_EQ(p.velocity, (std::array<double, 3>{0, 0, 0}));
}

// What physics says instead: the flow past the body. Where the book's law pushes on for ever, this
// one stops at the wind's speed.
TEST(ParticleSimulator, RelativeFlowCarriesAParticleAtTheSpeedOfTheWind) {
  solver::Setup setup = chapter8(10);
  setup.forces.drag_law = models::DragLaw::relative_flow;
  Flight flight(setup, {0, 1000, 0}, {0, 0, 0}, 1, drag_area);
  const Particle last = flight.after(9000);
  EXPECT_NEAR(last.velocity[0], 10, 1e-9);
  EXPECT_NEAR(last.velocity[1], -29.07536, 6e-6);
}

}  // namespace salvo::tests
