// The fields of a particle: the one list behind storage, scene keys, recording, hash and
// documentation.
#pragma once

#include <array>
#include <limits>

#include "soa/field.hpp"

namespace salvo::soa {

/// Index of a field in `particle_fields`.
enum class ParticleField : std::size_t {
  id,
  position,
  velocity,
  mass,
  radius,
  drag_area,
  birth,
  death,
  group,
  angular_velocity,
  residual,
  damping_loss,
  friction_loss,
  contact_impulse,
};

/// A death step that never comes.
inline constexpr std::int32_t never = std::numeric_limits<std::int32_t>::max();

inline constexpr double unbounded = std::numeric_limits<double>::max();

inline constexpr std::array<Field, 14> particle_fields{{
    {"id", Scalar::uint64, 1, "", "stream (high 24 bits) and serial within it (low 40 bits)", 0, 0,
     unbounded},
    {"position", Scalar::real, 3, "m", "centre of the particle", 0, -unbounded, unbounded},
    {"velocity", Scalar::real, 3, "m/s", "velocity of the centre", 0, -unbounded, unbounded},
    {"mass", Scalar::real, 1, "kg", "mass", 1, 1e-30, 1e30},
    {"radius", Scalar::real, 1, "m", "radius, for contact and buoyancy", 0, 0, 1e9},
    {"drag_area", Scalar::real, 1, "m^2", "drag coefficient times frontal area", 0, 0, 1e12},
    {"birth", Scalar::int32, 1, "step", "step at which the particle was emitted", 0, 0, never},
    {"death", Scalar::int32, 1, "step", "first step at which the particle is gone", never, 0,
     never},
    {"group", Scalar::uint32, 1, "", "label of the emitter's choice", 0, 0, 4294967295.0},
    {"angular_velocity", Scalar::real, 3, "rad/s", "of a particle that touches others", 0,
     -unbounded, unbounded},
    {"residual", Scalar::real, 3, "m", "what rounding left out of the position", 0, -unbounded,
     unbounded},
    {"damping_loss", Scalar::real, 1, "J", "heat from the dashpots of its contacts", 0, -unbounded,
     unbounded},
    {"friction_loss", Scalar::real, 1, "J", "work done against friction in its contacts", 0,
     -unbounded, unbounded},
    {"contact_impulse", Scalar::real, 3, "N s", "what its contacts with other particles gave it", 0,
     -unbounded, unbounded},
}};

/// Fields that only particles that touch have; files of other scenes do not mention them.
constexpr bool only_of_contacts(std::size_t field) {
  return field >= static_cast<std::size_t>(ParticleField::angular_velocity);
}

/// Fields in which the contacts of a particle keep their budget, summed over the run.
constexpr bool only_of_budgets(std::size_t field) {
  return field >= static_cast<std::size_t>(ParticleField::damping_loss);
}

constexpr const Field& field(ParticleField which) {
  return particle_fields[static_cast<std::size_t>(which)];
}

}  // namespace salvo::soa
