// A projectile with a standard drag function in the standard atmosphere: a point mass whose drag
// follows the Mach number at every stage of a step.
//
//   v' = -(pi/8) rho(h) Cd(|u|/c(h)) |u| u / BC - g,     u = v - wind
#pragma once

#include <array>

#include "kernels/forces.hpp"
#include "models/cubic_place.hpp"
#include "models/event.hpp"
#include "models/flight_fields.hpp"
#include "models/projectile_tables.hpp"
#include "models/standard_atmosphere.hpp"
#include "soa/field.hpp"

namespace salvo::models {
inline namespace SALVO_ISA {

template <class V>
struct Projectile {
  using T = typename V::Real;

  static constexpr auto state_fields = flight_fields;
  static constexpr std::array<soa::Field, 9> parameter_fields{{
      {"ballistic_coefficient", soa::Scalar::real, 1, "kg/m^2", "m/(i d^2)", 150, 1e-9, 1e9},
      {"drag_function", soa::Scalar::real, 1, "", "index in models::drag_functions", 4, 0, 6},
      {"wind_x", soa::Scalar::real, 1, "m/s", "wind downrange", 0, -1e9, 1e9},
      {"wind_y", soa::Scalar::real, 1, "m/s", "wind up", 0, -1e9, 1e9},
      {"wind_z", soa::Scalar::real, 1, "m/s", "wind to the right", 0, -1e9, 1e9},
      {"gravity", soa::Scalar::real, 1, "m/s^2", "downward", 9.80665, -1e9, 1e9},
      {"altitude", soa::Scalar::real, 1, "m", "of the muzzle above the sea", 0, -5000, 80000},
      {"ground", soa::Scalar::real, 1, "m", "height at which it comes down", -1e9, -1e9, 1e9},
      {"range", soa::Scalar::real, 1, "m", "distance downrange at which it ends", 1e9, -1e9, 1e9},
  }};

  // Out of line: as a part of every stage of every method it would take minutes to compile.
  [[gnu::noinline]] std::array<V, 6> rate(V, const std::array<V, 6>& s,
                                          const std::array<V, 9>& p) const {
    const kernels::Vec3<V> velocity{s[3], s[4], s[5]};
    const kernels::Vec3<V> flow = velocity - kernels::Vec3<V>{p[2], p[3], p[4]};
    const V height = s[1] + p[6];
    const V radius(atmosphere_radius);
    const CubicPlace<V> place(tables.density, radius * height / (radius + height));
    const V density = place.value(tables.density.coefficients());
    const V sound = place.value(tables.speed_of_sound.coefficients());

    const V speed = norm(flow);
    const CubicPlace<V> mach(tables.drag_place, speed / sound);
    alignas(64) T function[V::width];
    p[1].store(function);
    std::size_t offset[V::width];
    for (std::size_t lane = 0; lane < V::width; ++lane) {
      offset[lane] = tables.drag_stride * static_cast<std::size_t>(function[lane]);
    }
    const V cd = mach.value(tables.drag.coefficients(), offset);
    const kernels::Vec3<V> drag = flow * -(V(kernels::pi / 8) * density * cd * speed / p[0]);
    return {s[3], s[4], s[5], drag.x, drag.y - p[5], drag.z};
  }

  static constexpr std::array<Event, 2> events{{
      {"ground", "it comes down to the ground", Direction::falling},
      {"range", "it reaches the range", Direction::rising},
  }};
  template <class X>
  std::array<X, 2> quantities(X, const std::array<X, 6>& s, const std::array<X, 9>& p) const {
    return {s[1] - p[7], s[0] - p[8]};
  }

  const ProjectileTables<T>& tables = projectile_tables<T>();
};

}  // namespace SALVO_ISA
}  // namespace salvo::models
