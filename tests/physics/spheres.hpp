// Worlds of spheres that touch, sphere by sphere, and what they hold: momenta and energies.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "kernels/sphere_contact.hpp"
#include "solver/contact_time.hpp"
#include "solver/world.hpp"

namespace salvo::tests {

using models::ContactLaw;
using models::ContactLawKind;
using models::Obstacle;
using models::ObstacleShape;
using models::Triple;
using soa::ParticleField;
using soa::Precision;
using solver::Emitter;
using solver::EmitterKind;
using solver::World;

inline ContactLaw linear(double stiffness, double restitution, double friction = 0) {
  ContactLaw law;
  law.normal_stiffness = stiffness;
  law.restitution = restitution;
  law.friction = friction;
  return law;
}

inline ContactLaw hertz(double young, double restitution, double friction = 0) {
  ContactLaw law;
  law.kind = ContactLawKind::hertz_mindlin;
  law.young_modulus = young;
  law.restitution = restitution;
  law.friction = friction;
  return law;
}

inline ContactLaw impulse(double restitution, double friction = 0) {
  ContactLaw law;
  law.kind = ContactLawKind::impulse;
  law.restitution = restitution;
  law.friction = friction;
  return law;
}

/// No particles and no gravity.
inline solver::Setup touching_setup(const ContactLaw& law,
                                    Precision precision = Precision::float64) {
  solver::Setup setup;
  setup.precision = precision;
  setup.forces.gravity = {0, 0, 0};
  setup.contact_law = law;
  return setup;
}

/// Spheres are rows in the order in which they are added.
inline void add_sphere(solver::Setup& setup, Triple position, Triple velocity, double radius,
                       double mass, Triple spin = {}) {
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

/// Spheres on a cubic lattice that fills a box about `position`.
inline Emitter lattice(Triple position, Triple size, double spacing, double radius, double mass) {
  Emitter emitter;
  emitter.kind = EmitterKind::lattice;
  emitter.position = position;
  emitter.size = size;
  emitter.spacing = spacing;
  emitter.radius.a = radius;
  emitter.mass.a = mass;
  emitter.count = solver::lattice_sites(emitter);
  return emitter;
}

/// The plane y = 0, of the law's material.
inline Obstacle ground(const ContactLaw& law) {
  Obstacle plane;
  plane.restitution = law.restitution;
  plane.friction = law.friction;
  return plane;
}

inline Obstacle hollow_box(Triple center, Triple half_size, const ContactLaw& law) {
  Obstacle box = ground(law);
  box.shape = ObstacleShape::box;
  box.hollow = true;
  box.center = center;
  box.half_size = half_size;
  return box;
}

inline double value(const World& world, ParticleField field, std::size_t row, std::size_t c = 0) {
  const auto f = static_cast<std::size_t>(field);
  const soa::Table& table = world.particles();
  if (!table.stored(f)) return table.uniform(f);
  return table.precision() == Precision::float32
             ? static_cast<double>(table.column<float>(f, c)[row])
             : table.column<double>(f, c)[row];
}

inline Triple triple(const World& world, ParticleField field, std::size_t row) {
  return {value(world, field, row, 0), value(world, field, row, 1), value(world, field, row, 2)};
}

inline Triple velocity(const World& world, std::size_t row) {
  return triple(world, ParticleField::velocity, row);
}
inline Triple spin(const World& world, std::size_t row) {
  return triple(world, ParticleField::angular_velocity, row);
}
/// With what rounding left out.
inline Triple position(const World& world, std::size_t row) {
  Triple x = triple(world, ParticleField::position, row);
  for (std::size_t c = 0; c < 3; ++c) x[c] += value(world, ParticleField::residual, row, c);
  return x;
}

inline double distance(const World& world, std::size_t i, std::size_t j) {
  const Triple a = position(world, i);
  const Triple b = position(world, j);
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// How far two spheres overlap; negative apart.
inline double overlap(const World& world, std::size_t i, std::size_t j) {
  return value(world, ParticleField::radius, i) + value(world, ParticleField::radius, j) -
         distance(world, i, j);
}

struct Totals {
  Triple momentum{};          // kg m/s
  Triple angular_momentum{};  // about the origin, kg m^2/s
  double kinetic = 0;         // with rotation, J
  double losses = 0;          // J
  double momenta = 0;         // sum of the magnitudes of momenta, kg m/s
  double impulses = 0;        // likewise of what contacts with other particles gave, N s
};

inline Totals totals(const World& world) {
  Totals sum;
  for (std::size_t row = 0; row < world.particles().rows(); ++row) {
    const double mass = value(world, ParticleField::mass, row);
    const double radius = value(world, ParticleField::radius, row);
    const double inertia = 0.4 * mass * radius * radius;
    const Triple x = position(world, row);
    const Triple v = velocity(world, row);
    const Triple w = spin(world, row);
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t a = (c + 1) % 3;
      const std::size_t b = (c + 2) % 3;
      sum.momentum[c] += mass * v[c];
      sum.angular_momentum[c] += mass * (x[a] * v[b] - x[b] * v[a]) + inertia * w[c];
      sum.kinetic += 0.5 * mass * v[c] * v[c] + 0.5 * inertia * w[c] * w[c];
      sum.momenta += mass * std::abs(v[c]);
      sum.impulses += std::abs(value(world, ParticleField::contact_impulse, row, c));
    }
    sum.losses += value(world, ParticleField::damping_loss, row) +
                  value(world, ParticleField::friction_loss, row);
  }
  return sum;
}

}  // namespace salvo::tests
