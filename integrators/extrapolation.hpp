// Extrapolation of the modified midpoint rule to no step at all (Gragg, Bulirsch, Stoer): the
// rule's results with 2, 4, 6 and 8 substeps have errors in even powers of the substep, of which
// Neville's scheme takes away three. Order 8; the result of order 6 beside it tells the error.
// [Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I", II.9]
#pragma once

#include <array>
#include <cstddef>

#include "integrators/step_with_error.hpp"
#include "kernels/array.hpp"

namespace salvo::integrators {
inline namespace SALVO_ISA {

inline constexpr std::array<int, 4> midpoint_substeps{2, 4, 6, 8};

/// y(t + h) by `substeps` of the modified midpoint rule, smoothed. Out of line: with all of its
/// stages written out a model would take a minute to compile.
template <class V, std::size_t N, class Rate>
[[gnu::noinline]] std::array<V, N> modified_midpoint(const std::array<V, N>& y,
                                                     const std::array<V, N>& slope, V t, V h,
                                                     int substeps, const Rate& rate) {
  const V part = h / V(static_cast<double>(substeps));
  const auto moved = [](const std::array<V, N>& from, const std::array<V, N>& by, V step) {
    return kernels::array_of<N>([&](std::size_t i) { return from[i] + by[i] * step; });
  };
  std::array<V, N> before = y;
  std::array<V, N> now = moved(y, slope, part);
  for (int k = 1; k < substeps; ++k) {
    const std::array<V, N> next =
        moved(before, rate(t + part * V(static_cast<double>(k)), now), part + part);
    before = now;
    now = next;
  }
  const std::array<V, N> last = rate(t + h, now);
  return kernels::array_of<N>(
      [&](std::size_t i) { return (now[i] + before[i] + last[i] * part) * V(0.5); });
}

/// y(t + h), from the slope f(t, y).
template <class V, std::size_t N, class Rate>
StepWithError<V, N> extrapolation_8(const std::array<V, N>& y, const std::array<V, N>& slope, V t,
                                    V h, const Rate& rate) {
  constexpr std::size_t columns = midpoint_substeps.size();
  std::array<std::array<V, N>, columns> row;  // of Neville's scheme, the newest first
  StepWithError<V, N> extrapolated;
  for (std::size_t j = 0; j < columns; ++j) {
    std::array<V, N> value = modified_midpoint(y, slope, t, h, midpoint_substeps[j], rate);
    for (std::size_t k = 1; k <= j; ++k) {
      const double ratio = static_cast<double>(midpoint_substeps[j]) / midpoint_substeps[j - k];
      const V weight(1 / (ratio * ratio - 1));
      const std::array<V, N> better = kernels::array_of<N>(
          [&](std::size_t i) { return value[i] + (value[i] - row[k - 1][i]) * weight; });
      if (j == columns - 1 && k == j) {
        extrapolated.error =
            kernels::array_of<N>([&](std::size_t i) { return better[i] - value[i]; });
      }
      row[k - 1] = value;
      value = better;
    }
    row[j] = value;
  }
  extrapolated.result = row[columns - 1];
  return extrapolated;
}

}  // namespace SALVO_ISA
}  // namespace salvo::integrators
