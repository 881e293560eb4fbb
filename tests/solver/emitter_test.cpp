// Emitters: where and how fast particles start, who they are, and when they come.
#include "solver/emitter.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/solver/particles.hpp"
#include "tests/solver/setups.hpp"

namespace salvo::tests {

namespace {

using solver::EmissionSchedule;
using solver::World;

constexpr std::uint64_t count = 9999;
constexpr Triple centre{1, 30, -2};

std::vector<Particle> emitted(const Emitter& emitter) {
  solver::Setup setup = plain_setup();
  setup.emitters = {emitter};
  return read_particles(World(setup, {}).particles());
}

double length(const std::array<double, 3>& v) { return std::hypot(v[0], v[1], v[2]); }

std::array<double, 3> from_centre(const Particle& p) {
  return {p.position[0] - centre[0], p.position[1] - centre[1], p.position[2] - centre[2]};
}

double dot(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

double mean(const std::vector<Particle>& particles, double (*value)(const Particle&)) {
  double sum = 0;
  for (const Particle& p : particles) sum += value(p);
  return sum / static_cast<double>(particles.size());
}

}  // namespace

TEST(Emitter, NumbersItsParticlesWithinItsStream) {
  const std::vector<Particle> particles = emitted(burst(0xABCDEF, 33));
  ASSERT_EQ(particles.size(), 33U);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    EXPECT_EQ(particles[i].id, soa::make_id(0xABCDEF, i));
  }
}

TEST(Emitter, BurstFillsItsBallEvenlyInAllDirections) {
  const std::vector<Particle> particles = emitted(burst(1, count));
  const double error = 5 / std::sqrt(static_cast<double>(count));
  for (const Particle& p : particles) EXPECT_LE(length(from_centre(p)), 0.5 * (1 + 1e-12));
  // The cube of the radius is uniform.
  EXPECT_NEAR(
      mean(particles, [](const Particle& p) { return std::pow(length(from_centre(p)) / 0.5, 3); }),
      0.5, error * std::sqrt(1 / 12.0));
  EXPECT_NEAR(mean(particles, [](const Particle& p) { return p.velocity[1] / length(p.velocity); }),
              0, error * std::sqrt(1 / 3.0));
  // Place and direction have nothing to do with each other.
  EXPECT_NEAR(mean(particles,
                   [](const Particle& p) {
                     const auto x = from_centre(p);
                     return dot(x, p.velocity) / length(x) / length(p.velocity);
                   }),
              0, error * std::sqrt(1 / 3.0));
}

TEST(Emitter, ShellFliesOutwardFromItsSphere) {
  Emitter shell = burst(1, 333);
  shell.kind = EmitterKind::shell;
  for (const Particle& p : emitted(shell)) {
    const auto x = from_centre(p);
    EXPECT_NEAR(length(x), 0.5, 1e-14);
    EXPECT_NEAR(dot(x, p.velocity), 0.5 * length(p.velocity), 1e-12);
  }
}

TEST(Emitter, ConeKeepsWithinItsAngleOfItsDirection) {
  Emitter cone = burst(1, count);
  cone.kind = EmitterKind::cone;
  cone.direction = {0.6, 0, -0.8};
  cone.half_angle = 0.3;
  double widest = 0;
  for (const Particle& p : emitted(cone)) {
    const double angle = std::acos(dot(p.velocity, cone.direction) / length(p.velocity));
    EXPECT_LE(angle, 0.3 + 1e-9);
    widest = std::max(widest, angle);
  }
  EXPECT_GT(widest, 0.299);
}

TEST(Emitter, AddsItsOwnVelocity) {
  Emitter still = burst(1, 33);
  Emitter moving = still;
  moving.velocity = {100, -7, 3};
  const std::vector<Particle> a = emitted(still);
  const std::vector<Particle> b = emitted(moving);
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].position, b[i].position);
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(b[i].velocity[c], a[i].velocity[c] + moving.velocity[c]);
    }
  }
}

TEST(Emitter, DrawsItsSpreads) {
  Emitter emitter = burst(1, count);
  emitter.speed = normal(20, 3);
  emitter.mass = uniform(0.5, 1.5);
  emitter.radius = normal(0.1, 0.2);  // cut at zero
  emitter.drag_coefficient.reset();
  emitter.drag_area = constant(0.25);
  const std::vector<Particle> particles = emitted(emitter);
  const double error = 5 / std::sqrt(static_cast<double>(count));
  for (const Particle& p : particles) {
    EXPECT_GE(p.mass, 0.5);
    EXPECT_LT(p.mass, 1.5);
    EXPECT_GT(p.radius, 0);
    EXPECT_LE(p.radius, 0.9);
    EXPECT_EQ(p.drag_area, 0.25);
    EXPECT_GE(length(p.velocity), 8 - 1e-12);  // within four standard deviations
    EXPECT_LE(length(p.velocity), 32 + 1e-12);
  }
  EXPECT_NEAR(mean(particles, [](const Particle& p) { return p.mass; }), 1, error * 0.29);
  EXPECT_NEAR(mean(particles, [](const Particle& p) { return length(p.velocity); }), 20, error * 3);
  // Each quantity has draws of its own.
  EXPECT_NEAR(
      mean(particles, [](const Particle& p) { return (p.mass - 1) * (length(p.velocity) - 20); }),
      0, error * 3 * 0.29);
}

TEST(Emitter, TakesTheDragAreaFromTheRadiusWhenGivenACoefficient) {
  Emitter emitter = burst(1, 333);
  emitter.radius = uniform(0.1, 0.2);
  for (const Particle& p : emitted(emitter)) {
    const double wanted = 0.47 * 3.14159265358979323846 * p.radius * p.radius;
    EXPECT_NEAR(p.drag_area, wanted, wanted * 1e-15);
  }
}

TEST(Emitter, DrawsDependOnSeedAndStream) {
  const std::vector<Particle> a = emitted(burst(1, 33));
  const std::vector<Particle> b = emitted(burst(2, 33));
  solver::Setup setup = plain_setup();
  setup.seed += 1;
  setup.emitters = {burst(1, 33)};
  const std::vector<Particle> c = read_particles(World(setup, {}).particles());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_NE(a[i].velocity, b[i].velocity);
    EXPECT_NE(a[i].velocity, c[i].velocity);
  }
}

TEST(Emitter, LivesAreAtLeastOneStep) {
  Emitter emitter = burst(1, 3);
  emitter.life = constant(1e-9);
  EXPECT_EQ(emitted(emitter).front().death, 1);
  emitter.life = constant(1e12);  // past the last step that a column holds
  EXPECT_EQ(emitted(emitter).front().death, soa::never);
}

// The schedule against the plainest count of its steps.
RC_GTEST_PROP(EmissionSchedule, NamesEveryStepAtWhichParticlesAreDue, ()) {
  Emitter jet;
  jet.kind = EmitterKind::jet;
  jet.rate = *rc::gen::inRange(0, 5000) / 7.0;
  jet.duration = *rc::gen::inRange(0, 300) / 100.0;
  jet.time = *rc::gen::inRange(-50, 100) / 30.0;
  const double dt = *rc::gen::inRange(1, 30) / 1000.0;
  const EmissionSchedule schedule(jet, 0, dt);

  const auto total = static_cast<std::uint64_t>(std::floor(jet.rate * jet.duration + 1e-9));
  RC_ASSERT(schedule.total() == total);
  const auto first = static_cast<std::int64_t>(std::max(0.0, std::ceil(jet.time / dt - 1e-9)));
  const auto last = first + std::llround(std::ceil(jet.duration / dt)) + 2;
  RC_ASSERT(schedule.emitted_before(first) == 0U);
  RC_ASSERT(schedule.emitted_before(last) == total);
  std::int64_t next = schedule.next(0);
  for (std::int64_t step = 0; step < last; ++step) {
    const std::uint64_t before = schedule.emitted_before(step);
    const std::uint64_t after = schedule.emitted_before(step + 1);
    RC_ASSERT(before <= after);
    RC_ASSERT((step == next) == (after > before));
    if (step == next) next = schedule.next(step + 1);
  }
  RC_ASSERT(next == -1);
}

TEST(EmissionSchedule, OfABurstIsOneStep) {
  const EmissionSchedule schedule(burst(1, 33, 0.5), 0.1, 0.01);
  EXPECT_EQ(schedule.next(0), 40);
  EXPECT_EQ(schedule.next(40), 40);
  EXPECT_EQ(schedule.next(41), -1);
  EXPECT_EQ(schedule.emitted_before(40), 0U);
  EXPECT_EQ(schedule.emitted_before(41), 33U);
  EXPECT_EQ(EmissionSchedule(burst(1, 0), 0, 0.01).next(0), -1);
}

TEST(StepAt, IsTheFirstAtOrAfterATime) {
  EXPECT_EQ(solver::step_at(0.3, 0, 0.1), 3);  // 0.3/0.1 is a little under 3
  EXPECT_EQ(solver::step_at(0.7, 0, 0.1), 7);  // and 0.7/0.1 under 7
  EXPECT_EQ(solver::step_at(0.31, 0, 0.1), 4);
  EXPECT_EQ(solver::step_at(-1, 0, 0.1), 0);
  EXPECT_EQ(solver::step_at(-1, -2, 0.1), 10);
}

}  // namespace salvo::tests
