// A point in flight, as the models of shots share it: its state, how it is launched, and what is
// told of it.
#pragma once

#include <array>

#include "kernels/math.hpp"
#include "kernels/vec3.hpp"
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

inline constexpr std::array<soa::Field, 6> launch_fields{{
    {"x", soa::Scalar::real, 1, "m", "start downrange", 0, -1e9, 1e9},
    {"y", soa::Scalar::real, 1, "m", "height of the start", 0, -1e9, 1e9},
    {"z", soa::Scalar::real, 1, "m", "start to the right", 0, -1e9, 1e9},
    {"speed", soa::Scalar::real, 1, "m/s", "at the start", 0, 0, 1e9},
    {"elevation", soa::Scalar::real, 1, "rad", "of the start above the horizontal", 0, -7, 7},
    {"azimuth", soa::Scalar::real, 1, "rad", "of the start to the right", 0, -7, 7},
}};

inline constexpr std::array<soa::Field, 3> flight_result_fields{{
    {"speed", soa::Scalar::real, 1, "m/s", "speed", 0, 0, 1e9},
    {"angle", soa::Scalar::real, 1, "rad", "of the path above the horizontal", 0, -2, 2},
    {"energy", soa::Scalar::real, 1, "J", "kinetic energy", 0, 0, 1e30},
}};

/// Two lists of fields, one after the other.
template <std::size_t N, std::size_t M>
constexpr std::array<soa::Field, N + M> operator+(const std::array<soa::Field, N>& first,
                                                  const std::array<soa::Field, M>& second) {
  std::array<soa::Field, N + M> both{};
  for (std::size_t i = 0; i < N + M; ++i) both[i] = i < N ? first[i] : second[i - N];
  return both;
}

inline namespace SALVO_ISA {

/// The velocity of a launch.
template <class V>
kernels::Vec3<V> launch_velocity(V speed, V elevation, V azimuth) {
  const V level = speed * cos(elevation);
  return {level * cos(azimuth), speed * sin(elevation), level * sin(azimuth)};
}

/// The fields of flight_result_fields.
template <class V>
std::array<V, 3> flight_results(V mass, const std::array<V, 6>& s) {
  const V level = s[3] * s[3] + s[5] * s[5];
  const V square = level + s[4] * s[4];
  return {sqrt(square), atan2(s[4], sqrt(level)), V(0.5) * mass * square};
}

}  // namespace SALVO_ISA
}  // namespace salvo::models
