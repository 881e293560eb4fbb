// The state of a point in flight, shared by the models of shots.
#pragma once

#include <array>

#include "soa/field.hpp"

namespace salvo::models {

inline constexpr std::array<soa::Field, 6> flight_fields{{
    {"x", soa::Scalar::real, 1, "m", "downrange", 0, -1e9, 1e9},
    {"y", soa::Scalar::real, 1, "m", "up", 0, -1e9, 1e9},
    {"z", soa::Scalar::real, 1, "m", "to the right", 0, -1e9, 1e9},
    {"vx", soa::Scalar::real, 1, "m/s", "velocity downrange", 0, -1e9, 1e9},
    {"vy", soa::Scalar::real, 1, "m/s", "velocity up", 0, -1e9, 1e9},
    {"vz", soa::Scalar::real, 1, "m/s", "velocity to the right", 0, -1e9, 1e9},
}};

}  // namespace salvo::models
