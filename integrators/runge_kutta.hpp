// The classical Runge-Kutta method for any system y' = f(t, y) of a fixed number of equations;
// order 4.   [Bourg & Bywalec 7.3]
#pragma once

#include <array>
#include <cstddef>

#include "kernels/array.hpp"

namespace salvo::integrators {
inline namespace SALVO_ISA {

/// y(t + dt); `rate(t, y)` returns y'.
template <class V, std::size_t N, class Rate>
std::array<V, N> runge_kutta_4(const std::array<V, N>& y, V t, V dt, const Rate& rate) {
  const auto moved = [&](const std::array<V, N>& slope, V by) {
    return kernels::array_of<N>([&](std::size_t i) { return y[i] + slope[i] * by; });
  };
  const V half = dt * V(0.5);
  const std::array<V, N> k1 = rate(t, y);
  const std::array<V, N> k2 = rate(t + half, moved(k1, half));
  const std::array<V, N> k3 = rate(t + half, moved(k2, half));
  const std::array<V, N> k4 = rate(t + dt, moved(k3, dt));
  const V sixth = dt / V(6);
  return kernels::array_of<N>(
      [&](std::size_t i) { return y[i] + (k1[i] + (k2[i] + k3[i]) * V(2) + k4[i]) * sixth; });
}

}  // namespace SALVO_ISA
}  // namespace salvo::integrators
