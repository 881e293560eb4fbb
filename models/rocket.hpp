// A rocket of up to three stages: thrust m' u against gravity and drag in the standard atmosphere,
// along its velocity and, as long as it is slow, its launch: along v + 1 m/s in the direction of
// the launch, which turns without a jump.   [Bourg & Bywalec 6.4]
//
//   m v' = m' u - 1/2 rho (Cd A) |v| v - m g,     m' = (propellant/burn time) (1 + a (1 - 2 s))
//
// s from 0 to 1 over the burn; the thrust falls by the part a (its taper) to the burn's end. A
// stage ignites when the one before has burnt out and is dropped then. The mass follows from the
// time, so that no step can miss a drop of it; tolerances keep the error of a step across one.
#pragma once

#include <array>
#include <string_view>

#include "kernels/forces.hpp"
#include "models/cubic_place.hpp"
#include "models/event.hpp"
#include "models/flight.hpp"
#include "models/projectile_tables.hpp"
#include "models/standard_atmosphere.hpp"
#include "soa/field.hpp"

namespace salvo::models {

/// The fields of one stage.
constexpr std::array<soa::Field, 5> stage_fields(std::string_view propellant,
                                                 std::string_view structure, std::string_view burn,
                                                 std::string_view exhaust, std::string_view taper) {
  using soa::Scalar;
  return {{
      {propellant, Scalar::real, 1, "kg", "of the stage", 0, 0, 1e12},
      {structure, Scalar::real, 1, "kg", "what is dropped with it", 0, 0, 1e12},
      {burn, Scalar::real, 1, "s", "how long it burns", 0, 0, 1e9},
      {exhaust, Scalar::real, 1, "m/s", "u", 0, 0, 1e9},
      {taper, Scalar::real, 1, "", "a", 0, -1, 1},
  }};
}

inline namespace SALVO_ISA {

template <class V>
struct Rocket {
  using T = typename V::Real;
  static constexpr std::size_t stages = 3;

  static constexpr auto state_fields = flight_fields;
  static constexpr bool of_positions = true;
  static constexpr std::array<soa::Field, 7> body_fields{{
      {"payload", soa::Scalar::real, 1, "kg", "what stays when all stages are dropped", 1, 1e-30,
       1e12},
      {"drag_area", soa::Scalar::real, 1, "m^2", "Cd A", 0, 0, 1e9},
      {"gravity", soa::Scalar::real, 1, "m/s^2", "downward, at y = 0", 9.80665, -1e9, 1e9},
      {"gravity_falloff", soa::Scalar::real, 1, "1/m", "f of gravity/(1 + f y)^2", 0, 0, 1},
      {"altitude", soa::Scalar::real, 1, "m", "of y = 0 above the sea", 0, -5000, 80000},
      {"ground", soa::Scalar::real, 1, "m", "y at which it comes down", -1e9, -1e9, 1e9},
      {"range", soa::Scalar::real, 1, "m", "distance downrange at which it ends", 1e9, -1e9, 1e9},
  }};
  static constexpr auto shared_fields =
      body_fields + stage_fields("propellant_1", "structure_1", "burn_1", "exhaust_1", "taper_1") +
      stage_fields("propellant_2", "structure_2", "burn_2", "exhaust_2", "taper_2") +
      stage_fields("propellant_3", "structure_3", "burn_3", "exhaust_3", "taper_3");
  static constexpr std::array<soa::Field, 3> direction_fields{{
      {"direction_x", soa::Scalar::real, 1, "", "of the launch", 0, -1, 1},
      {"direction_y", soa::Scalar::real, 1, "", "of the launch", 1, -1, 1},
      {"direction_z", soa::Scalar::real, 1, "", "of the launch", 0, -1, 1},
  }};
  static constexpr auto parameter_fields = shared_fields + direction_fields;
  static constexpr auto input_fields = launch_fields + shared_fields;
  static constexpr auto result_fields = flight_result_fields;

  std::array<V, 31> start(const std::array<V, 28>& in) const {
    const kernels::Vec3<V> direction = launch_velocity(V(1), in[4], in[5]);
    std::array<V, 31> out{
        in[0], in[1], in[2], in[3] * direction.x, in[3] * direction.y, in[3] * direction.z};
    for (std::size_t i = 0; i < 22; ++i) out[6 + i] = in[6 + i];
    out[28] = direction.x;
    out[29] = direction.y;
    out[30] = direction.z;
    return out;
  }
  std::array<V, 3> results(const std::array<V, 28>& in, V t, const std::array<V, 6>& s) const {
    std::array<V, 25> p;
    for (std::size_t i = 0; i < 22; ++i) p[i] = in[6 + i];
    return flight_results(burning(t, p).mass, s);
  }

  [[gnu::noinline]] std::array<V, 6> rate(V t, const std::array<V, 6>& s,
                                          const std::array<V, 25>& p) const {
    using Vec = kernels::Vec3<V>;
    const Vec velocity{s[3], s[4], s[5]};
    const V speed = norm(velocity);
    const Vec forward = velocity + Vec{p[22], p[23], p[24]};
    const V length = norm(forward);
    // One that falls back at the speed of the launch's direction points nowhere: it has no thrust.
    const Vec direction = forward * select(length > V(0), V(1) / length, V(0));
    const V radius(atmosphere_radius);
    const V height = s[1] + p[4];
    const CubicPlace<V> place(tables.density, radius * height / (radius + height));
    const V density = place.value(tables.density.coefficients());
    const Burning now = burning(t, p);
    const V drag = V(0.5) * density * p[1] * speed;
    const Vec a = (direction * now.thrust - velocity * drag) * (V(1) / now.mass);
    const V nearer = V(1) + p[3] * s[1];
    return {s[3], s[4], s[5], a.x, a.y - p[2] / (nearer * nearer), a.z};
  }

  static constexpr std::array<Event, 4> events{{
      {"ground", "it comes down to the ground", Direction::falling, true},
      {"range", "it reaches the range", Direction::rising, true},
      {"apex", "it is at its highest", Direction::falling, false},
      {"burnout", "the last stage has burnt out", Direction::rising, false},
  }};
  template <class X>
  X quantity(std::size_t event, X t, const std::array<X, 6>& s, const std::array<X, 25>& p) const {
    switch (event) {
      case 0:
        return s[1] - p[5];
      case 1:
        return s[0] - p[6];
      case 2:
        return s[4];
      default:
        return t - p[9] - p[14] - p[19];
    }
  }

 private:
  struct Burning {
    V mass;
    V thrust;
  };
  static Burning burning(V t, const std::array<V, 25>& p) {
    Burning now{p[0], V(0)};
    V ignition(0);
    for (std::size_t stage = 0; stage < stages; ++stage) {
      const V propellant = p[7 + 5 * stage];
      const V structure = p[8 + 5 * stage];
      const V burn = p[9 + 5 * stage];
      const V taper = p[11 + 5 * stage];
      const V end = ignition + burn;
      const auto burns = (t >= ignition) & (t < end);
      const V part = clamp((t - ignition) / select(burn > V(0), burn, V(1)), V(0), V(1));
      const V left = propellant * (V(1) - part) * (V(1) - taper * part);
      now.mass = now.mass + select(t < end, structure + left, V(0));
      const V flow =
          propellant / select(burn > V(0), burn, V(1)) * (V(1) + taper * (V(1) - V(2) * part));
      now.thrust = now.thrust + select(burns, flow * p[10 + 5 * stage], V(0));
      ignition = end;
    }
    return now;
  }

  const ProjectileTables<T>& tables = projectile_tables<T>();
};

}  // namespace SALVO_ISA
}  // namespace salvo::models
