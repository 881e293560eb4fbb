// Worlds to test with.
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "solver/world.hpp"

namespace salvo::tests {

using models::Triple;
using soa::Precision;
using solver::Emitter;
using solver::EmitterKind;
using solver::IntegratorKind;
using solver::Spread;

inline constexpr IntegratorKind all_integrators[] = {
    IntegratorKind::explicit_euler, IntegratorKind::semi_implicit_euler,
    IntegratorKind::improved_euler, IntegratorKind::runge_kutta_4, IntegratorKind::velocity_verlet};

inline Spread constant(double value) { return {Spread::Kind::constant, value, 0}; }
inline Spread uniform(double low, double high) { return {Spread::Kind::uniform, low, high}; }
inline Spread normal(double mean, double width) { return {Spread::Kind::normal, mean, width}; }

/// `count` particles that all start alike; they go their own ways only where forces or draws make
/// them.
inline Emitter particles_from(std::uint64_t stream, Triple position, Triple velocity,
                              std::uint64_t count = 1) {
  Emitter emitter;
  emitter.stream = stream;
  emitter.count = count;
  emitter.position = position;
  emitter.velocity = velocity;
  return emitter;
}

/// A burst in all directions from a ball.
inline Emitter burst(std::uint64_t stream, std::uint64_t count, double time = 0) {
  Emitter emitter;
  emitter.stream = stream;
  emitter.count = count;
  emitter.time = time;
  emitter.position = {1, 30, -2};
  emitter.source_radius = 0.5;
  emitter.speed = uniform(5, 40);
  emitter.mass = constant(0.02);
  emitter.radius = constant(0.0123);
  emitter.drag_coefficient = 0.47;
  return emitter;
}

/// Gravity alone, no particles.
inline solver::Setup plain_setup(Precision precision = Precision::float64) {
  solver::Setup setup;
  setup.precision = precision;
  setup.seed = 33;
  setup.dt = 0.01;
  return setup;
}

/// Every force at once; still far from overflow and fast variation.
inline models::ForceSettings every_force() {
  models::ForceSettings forces;
  forces.point_gravity = {{{10, 5, 3}, 200, 0.5}, {{-20, 0, 9}, -90, 1}};
  forces.quadratic_drag = true;
  forces.linear_drag = 0.003;
  forces.buoyancy = true;
  forces.windy = true;
  forces.wind.velocity = {7, 0, -3};
  forces.wind.profile = models::WindProfile::log_law;
  forces.gusty = true;
  forces.gust.standard_deviation = {2, 0.5, 1.5};
  forces.gust.length = 33;
  forces.blasts = {{{0, 1, 0}, 0.105, 0.4, 0.02, 1, 3}, {{5, 20, 5}, 0.4, 0.2, 0.05, 2, 2}};
  return forces;
}

struct NamedSetup {
  std::string name;
  solver::Setup setup;

  friend std::ostream& operator<<(std::ostream& out, const NamedSetup& scene) {
    return out << scene.name;
  }
};

/// All forces, integrators, emitters, precisions, lifetimes, removals and responses to obstacles
/// between them.
inline std::vector<NamedSetup> varied_setups() {
  std::vector<NamedSetup> setups;

  solver::Setup everything = plain_setup();
  everything.integrator = IntegratorKind::runge_kutta_4;
  everything.forces = every_force();
  everything.emitters = {burst(1, 4097), burst(4, 333, 0.333), burst(9, 65, 0.67)};
  everything.emitters[0].mass = uniform(0.01, 0.05);
  everything.emitters[0].life = uniform(0.1, 2);
  everything.emitters[1].radius = normal(0.0123, 0.002);
  everything.emitters[2].group = 7;
  everything.domain = {true, {-40, -1, -40}, {40, 55, 40}};
  everything.on_bad = solver::BadRowPolicy::remove;
  setups.push_back({"every force, removals and deaths", everything});

  constexpr const char* names[] = {"explicit Euler", "semi-implicit Euler", "improved Euler",
                                   "Runge-Kutta", "velocity Verlet"};
  for (const IntegratorKind integrator : all_integrators) {
    solver::Setup setup = plain_setup(Precision::float32);
    setup.integrator = integrator;
    setup.forces = every_force();
    setup.forces.wind.profile = models::WindProfile::power_law;
    setup.emitters = {burst(3, 1031)};
    setups.push_back({std::string("float, ") + names[static_cast<int>(integrator)], setup});
  }

  solver::Setup sources = plain_setup(Precision::float32);
  sources.forces.quadratic_drag = true;
  sources.forces.windy = true;
  sources.forces.wind.velocity = {3, 0, 1};
  sources.emitters.assign(5, burst(0, 333));
  for (std::size_t i = 0; i < 5; ++i) sources.emitters[i].stream = 20 + i;
  sources.emitters[0].mass = uniform(0.01, 0.03);
  sources.emitters[0].drag_coefficient.reset();
  sources.emitters[0].drag_area = uniform(1e-4, 3e-4);
  sources.emitters[1].kind = EmitterKind::shell;
  sources.emitters[1].life = constant(0.5);
  sources.emitters[2].kind = EmitterKind::cone;
  sources.emitters[2].half_angle = 0.3;
  sources.emitters[2].time = 0.1;
  sources.emitters[3].kind = EmitterKind::jet;
  sources.emitters[3].half_angle = 0.1;
  sources.emitters[3].rate = 233.3;  // 2.333 a step
  sources.emitters[3].duration = 0.9;
  sources.emitters[3].life = uniform(0.2, 0.4);
  sources.emitters[4].kind = EmitterKind::jet;
  sources.emitters[4].rate = 17;  // one in six steps
  sources.emitters[4].duration = 9;
  sources.emitters[4].time = 0.055;
  setups.push_back({"bursts, a shell, a cone and jets", sources});

  solver::Setup explosions = plain_setup();
  explosions.forces.gravity = {0, -30, 0};
  explosions.integrator = IntegratorKind::velocity_verlet;
  for (const auto shares : {solver::EnergyShares::equal, solver::EnergyShares::uniform,
                            solver::EnergyShares::normal, solver::EnergyShares::book}) {
    Emitter emitter = burst(30 + static_cast<std::uint64_t>(shares), 99);
    emitter.kind = EmitterKind::energy_explosion;
    emitter.shares = shares;
    emitter.energy = 566.5725;
    emitter.time = 0.1 * static_cast<double>(shares);
    emitter.mass = uniform(0.001, 0.01);
    explosions.emitters.push_back(emitter);
  }
  Emitter book;
  book.kind = EmitterKind::book_explosion;
  book.stream = 40;
  book.count = 50;
  book.strength = 75;
  book.life_ms = 1000;
  explosions.emitters.push_back(book);
  setups.push_back({"the book's explosions", explosions});

  solver::Setup bouncing = plain_setup(Precision::float32);
  bouncing.forces.quadratic_drag = true;
  bouncing.emitters = {burst(50, 1033)};
  bouncing.emitters[0].position = {0, 3, 0};
  bouncing.emitters[0].life = uniform(0.5, 2);
  models::Obstacle ground;
  ground.friction = 0.3;
  models::Obstacle ball;
  ball.shape = models::ObstacleShape::sphere;
  ball.center = {2, 1, 0};
  bouncing.obstacles = {ground, ball};
  constexpr const char* responses[] = {"swept", "impulse", "force"};
  for (const auto response : {models::ContactResponse::swept, models::ContactResponse::impulse,
                              models::ContactResponse::force}) {
    bouncing.contact.response = response;
    setups.push_back(
        {std::string("obstacles, ") + responses[static_cast<int>(response)], bouncing});
  }

  solver::Setup large = plain_setup(Precision::float32);  // 16 tiles, so that 13 threads all work
  large.forces.quadratic_drag = true;
  large.forces.windy = true;
  large.forces.wind.velocity = {5, 0, 0};
  large.emitters = {burst(60, 61'441)};
  setups.push_back({"more rows than 15 tiles", large});

  for (const std::uint64_t count : {1, 3, 63, 65, 4097, 12345}) {
    solver::Setup setup = plain_setup(count % 3 == 0 ? Precision::float64 : Precision::float32);
    setup.forces.linear_drag = 0.01;
    setup.emitters = {burst(70, count)};
    setups.push_back({std::to_string(count) + " particles", setup});
  }

  setups.push_back({"no emitters", plain_setup()});
  return setups;
}

}  // namespace salvo::tests
