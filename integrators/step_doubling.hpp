// Euler's method beside itself with two steps of half the length: what they differ by is the error.
// The result is that of the whole step, as in the book.   [Bourg & Bywalec 7.2]
#pragma once

#include <array>
#include <cstddef>

#include "integrators/step_with_error.hpp"
#include "kernels/array.hpp"

namespace salvo::integrators {
inline namespace SALVO_ISA {

/// y(t + h), from the slope f(t, y).
template <class V, std::size_t N, class Rate>
StepWithError<V, N> step_doubling_euler(const std::array<V, N>& y, const std::array<V, N>& slope,
                                        V t, V h, const Rate& rate) {
  const auto moved = [](const std::array<V, N>& from, const std::array<V, N>& by, V step) {
    return kernels::array_of<N>([&](std::size_t i) { return from[i] + by[i] * step; });
  };
  const V half = h * V(0.5);
  const std::array<V, N> whole_step = moved(y, slope, h);
  const std::array<V, N> middle = moved(y, slope, half);
  const std::array<V, N> two_steps = moved(middle, rate(t + half, middle), half);
  return {whole_step,
          kernels::array_of<N>([&](std::size_t i) { return whole_step[i] - two_steps[i]; })};
}

}  // namespace SALVO_ISA
}  // namespace salvo::integrators
