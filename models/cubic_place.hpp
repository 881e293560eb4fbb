// Looks lanes up in a soa::CubicTable, a lane at a time: a hardware gather exists on few
// instruction sets, and is slow on some of those.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "kernels/fours.hpp"
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
    (interval * V(4)).store(whole);
    for (std::size_t lane = 0; lane < V::width; ++lane) {
      index[lane] = static_cast<std::int32_t>(whole[lane]);
    }
  }

  /// Adds to the index of each lane: lane i looks at the i-th of several tables, in coefficients.
  void shift(V by) {
    by.store(whole);
    for (std::size_t lane = 0; lane < V::width; ++lane) {
      index[lane] += static_cast<std::int32_t>(whole[lane]);
    }
  }

  /// The value in a table of the same intervals.
  V value(const T* coefficients) const {
    const auto c = load_fours(coefficients, index, static_cast<const V*>(nullptr));
    return ((c[3] * fraction + c[2]) * fraction + c[1]) * fraction + c[0];
  }

  /// Its rate of change with x. (Of the held ends it is that inside.)
  V slope(const soa::CubicTable<T>& table) const {
    const auto c = load_fours(table.coefficients(), index, static_cast<const V*>(nullptr));
    return ((V(3) * c[3] * fraction + V(2) * c[2]) * fraction + c[1]) * V(table.per_interval());
  }

  V fraction;
  alignas(64) T whole[V::width];
  alignas(64) std::int32_t index[V::width];
};

}  // namespace SALVO_ISA
}  // namespace salvo::models
