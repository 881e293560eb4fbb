// The fields of a contact between two particles, or a particle and an obstacle, while they overlap:
// the one list behind checkpoints and hash. The contacts of a particle are rows in a run, by
// ascending partner; the pair is listed once, under its lower id.
#pragma once

#include <array>

#include "soa/field.hpp"
#include "soa/id.hpp"
#include "soa/particle_fields.hpp"

namespace salvo::soa {

/// Index of a field in `contact_fields`.
enum class ContactField : std::size_t {
  id,
  partner,
  tangential_displacement,
  rolling_displacement
};

inline constexpr std::array<Field, 4> contact_fields{{
    {"contact", Scalar::uint64, 1, "", "id of the particle, the lower of the two", 0, 0, unbounded},
    {"partner", Scalar::uint64, 1, "",
     "id of the other particle, or the largest stream and the number of an obstacle's smooth part",
     0, 0, unbounded},
    {"tangential_displacement", Scalar::real, 3, "m", "of the spring in the plane of contact", 0,
     -unbounded, unbounded},
    {"rolling_displacement", Scalar::real, 3, "m", "of the spring against rolling", 0, -unbounded,
     unbounded},
}};

/// The partner that stands for a smooth part of an obstacle, counted through the scene: one of most
/// obstacles, six of a hollow box, the features of a mesh.
constexpr Id obstacle_partner(std::uint64_t part) { return make_id(max_stream, part); }

}  // namespace salvo::soa
