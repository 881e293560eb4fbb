// The tables behind models/projectile.hpp: standard drag functions by monotone cubics, and the
// standard atmosphere by cubics over 200 m of geopotential height.
#pragma once

#include <cstddef>

#include "soa/cubic_table.hpp"

namespace salvo::models {

template <class T>
struct ProjectileTables {
  /// All drag functions, one after another on the same Mach numbers, 0 to 5; beyond its last number
  /// a function holds its last value.
  soa::CubicTable<T> drag;
  soa::CubicTable<T> drag_place;  // the intervals of one function
  std::size_t drag_stride = 0;    // coefficients of one function
  soa::CubicTable<T> density;     // kg/m^3, against geopotential height
  soa::CubicTable<T> slowness;    // one over the speed of sound, s/m, on the same heights
};

/// Made once, at the first call.
template <class T>
const ProjectileTables<T>& projectile_tables();

extern template const ProjectileTables<float>& projectile_tables();
extern template const ProjectileTables<double>& projectile_tables();

}  // namespace salvo::models
