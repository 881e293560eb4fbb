// Looks lanes up in a soa::CubicTable. Through memory, a lane at a time, as a hardware gather
// exists on few instruction sets.
#pragma once

#include <cstddef>

#include "kernels/pair.hpp"
#include "soa/cubic_table.hpp"

namespace salvo::models {
inline namespace SALVO_ISA {

/// Where x is in a table: four coefficients, and how far into the interval. x outside the table is
/// held at its ends.
template <class V>
struct CubicPlace {
  using T = typename V::Real;

  CubicPlace(const soa::CubicTable<T>& table, V x) {
    const V last(static_cast<T>(table.intervals()));
    const V scaled = clamp((x - V(table.first())) * V(table.per_interval()), V(0), last);
    const V interval = min(trunc(scaled), last - V(1));
    fraction = scaled - interval;
    alignas(64) T whole[V::width];
    interval.store(whole);
    for (std::size_t lane = 0; lane < V::width; ++lane) {
      index[lane] = 4 * static_cast<std::size_t>(whole[lane]);
    }
  }

  /// The value in a table of the same intervals; `offset` is that of each lane's table in
  /// coefficients, or null.
  V value(const T* coefficients, const std::size_t* offset = nullptr) const {
    alignas(64) T c[4][V::width];
    for (std::size_t lane = 0; lane < V::width; ++lane) {
      const T* from = coefficients + index[lane] + (offset ? offset[lane] : 0);
      for (std::size_t k = 0; k < 4; ++k) c[k][lane] = from[k];
    }
    return ((V::load(c[3]) * fraction + V::load(c[2])) * fraction + V::load(c[1])) * fraction +
           V::load(c[0]);
  }

  /// Its rate of change with x. (Of the held ends it is that inside.)
  V slope(const soa::CubicTable<T>& table) const {
    alignas(64) T c[4][V::width];
    for (std::size_t lane = 0; lane < V::width; ++lane) {
      for (std::size_t k = 1; k < 4; ++k) c[k][lane] = table.coefficients()[index[lane] + k];
    }
    return ((V(3) * V::load(c[3]) * fraction + V(2) * V::load(c[2])) * fraction + V::load(c[1])) *
           V(table.per_interval());
  }

  V fraction;
  std::size_t index[V::width];
};

}  // namespace SALVO_ISA
}  // namespace salvo::models
