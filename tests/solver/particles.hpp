// Tables of particles written by hand, for tests that need a state and no physics.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "soa/particle_fields.hpp"
#include "soa/table.hpp"

namespace salvo::tests {

struct Particle {
  soa::Id id = 0;
  std::array<double, 3> position{};
  std::array<double, 3> velocity{};
  double mass = 1;
  double radius = 0;
  double drag_area = 0;
  std::int32_t birth = 0;
  std::int32_t death = soa::never;
  std::uint32_t group = 0;
  std::array<double, 3> angular_velocity{};
  std::array<double, 3> residual{};
  double damping_loss = 0;
  double friction_loss = 0;
  std::array<double, 3> contact_impulse{};
};

constexpr std::size_t at(soa::ParticleField field) { return static_cast<std::size_t>(field); }

/// Every field of a particle, whether the table stores it or holds one value for all.
template <class T>
Particle read_particle(const soa::Table& table, std::size_t row) {
  using soa::ParticleField;
  const auto real = [&](ParticleField field, std::size_t component = 0) {
    const T* column = table.column<T>(at(field), component);
    return column ? static_cast<double>(column[row]) : table.uniform(at(field));
  };
  const auto integer = [&]<class I>(ParticleField field, I) {
    const I* column = table.column<I>(at(field));
    return column ? column[row] : static_cast<I>(table.uniform(at(field)));
  };
  Particle p;
  p.id = table.ids()[row];
  for (std::size_t c = 0; c < 3; ++c) {
    p.position[c] = real(ParticleField::position, c);
    p.velocity[c] = real(ParticleField::velocity, c);
    p.angular_velocity[c] = real(ParticleField::angular_velocity, c);
    p.residual[c] = real(ParticleField::residual, c);
    p.contact_impulse[c] = real(ParticleField::contact_impulse, c);
  }
  p.mass = real(ParticleField::mass);
  p.radius = real(ParticleField::radius);
  p.drag_area = real(ParticleField::drag_area);
  p.damping_loss = real(ParticleField::damping_loss);
  p.friction_loss = real(ParticleField::friction_loss);
  p.birth = integer(ParticleField::birth, std::int32_t{});
  p.death = integer(ParticleField::death, std::int32_t{});
  p.group = integer(ParticleField::group, std::uint32_t{});
  return p;
}

inline Particle read_particle(const soa::Table& table, std::size_t row) {
  return table.precision() == soa::Precision::float32 ? read_particle<float>(table, row)
                                                      : read_particle<double>(table, row);
}

inline std::vector<Particle> read_particles(const soa::Table& table) {
  std::vector<Particle> particles;
  particles.reserve(table.rows());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    particles.push_back(read_particle(table, row));
  }
  return particles;
}

template <class T>
void write_particle(soa::Table& table, std::size_t row, const Particle& p) {
  using soa::ParticleField;
  const auto set = [&]<class I>(ParticleField field, I value, std::size_t component = 0) {
    I* column = table.column<I>(at(field), component);
    if (column) column[row] = value;
  };
  table.ids()[row] = p.id;
  for (std::size_t c = 0; c < 3; ++c) {
    set(ParticleField::position, static_cast<T>(p.position[c]), c);
    set(ParticleField::velocity, static_cast<T>(p.velocity[c]), c);
    set(ParticleField::angular_velocity, static_cast<T>(p.angular_velocity[c]), c);
    set(ParticleField::residual, static_cast<T>(p.residual[c]), c);
    set(ParticleField::contact_impulse, static_cast<T>(p.contact_impulse[c]), c);
  }
  set(ParticleField::mass, static_cast<T>(p.mass));
  set(ParticleField::radius, static_cast<T>(p.radius));
  set(ParticleField::drag_area, static_cast<T>(p.drag_area));
  set(ParticleField::damping_loss, static_cast<T>(p.damping_loss));
  set(ParticleField::friction_loss, static_cast<T>(p.friction_loss));
  set(ParticleField::birth, p.birth);
  set(ParticleField::death, p.death);
  set(ParticleField::group, p.group);
}

/// A table of all fields.
inline soa::Table table_of_particles(soa::Precision precision,
                                     const std::vector<Particle>& particles) {
  soa::Table table(soa::particle_fields, precision,
                   std::vector<bool>(soa::particle_fields.size(), true));
  table.append(particles.size());
  for (std::size_t row = 0; row < particles.size(); ++row) {
    if (precision == soa::Precision::float32) {
      write_particle<float>(table, row, particles[row]);
    } else {
      write_particle<double>(table, row, particles[row]);
    }
  }
  return table;
}

/// A copy of the columns and uniform values: tables move and do not copy.
inline soa::Table copy_of(const soa::Table& table) {
  std::vector<bool> stored;
  for (std::size_t f = 0; f < table.fields().size(); ++f) stored.push_back(table.stored(f));
  soa::Table copy(table.fields(), table.precision(), stored);
  copy.append(table.rows());
  for (std::size_t f = 0; f < table.fields().size(); ++f) {
    copy.set_uniform(f, table.uniform(f));
    if (!table.stored(f)) continue;
    const std::size_t size = size_of(table.fields()[f].scalar, table.precision());
    for (std::size_t c = 0; c < table.fields()[f].components; ++c) {
      if (table.rows() != 0) {
        std::memcpy(copy.bytes(f, c), table.bytes(f, c), table.rows() * size);
      }
    }
  }
  return copy;
}

}  // namespace salvo::tests
