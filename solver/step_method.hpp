// A step of each method in one form: the result, the slopes at both ends, and the solution within.
// The embedded pairs know it to order 4; for the others it is the cubic through both ends.
#pragma once

#include <array>
#include <cstddef>

#include "integrators/embedded_pair.hpp"
#include "integrators/runge_kutta.hpp"
#include "kernels/array.hpp"

namespace salvo::solver {
inline namespace SALVO_ISA {

using integrators::EmbeddedPair;

template <const EmbeddedPair& pair>
struct PairMethod {
  template <class W, std::size_t N, class Rate>
  static std::array<W, N> result(const std::array<W, N>& y, W t, W h, const Rate& rate) {
    integrators::Slopes<W, N> k;
    k[0] = rate(t, y);
    return integrators::pair_result<pair>(y, t, h, k, rate);
  }

  template <class W, std::size_t N>
  struct Step {
    template <class Rate>
    Step(const std::array<W, N>& y, const std::array<W, N>& slope, W t, W step, const Rate& rate)
        : start(y), h(step) {
      k[0] = slope;
      end = integrators::pair_step<pair>(y, t, h, k, rate);
    }
    const std::array<W, N>& start_slope() const { return k[0]; }
    const std::array<W, N>& end_slope() const { return k[integrators::pair_stages - 1]; }
    std::array<W, N> at(W s) const { return integrators::pair_dense<pair>(start, h, s, k); }

    std::array<W, N> start;
    std::array<W, N> end;
    W h;
    integrators::Slopes<W, N> k;
  };
};

/// `Formula::result(y, t, h, rate)` is the method.
template <class Formula>
struct PlainMethod : Formula {
  template <class W, std::size_t N>
  struct Step {
    template <class Rate>
    Step(const std::array<W, N>& y, const std::array<W, N>& slope, W t, W step, const Rate& rate)
        : start(y), h(step), start_slope_(slope), end(Formula::result(y, t, step, rate)) {
      end_slope_ = rate(t + h, end);
    }
    const std::array<W, N>& start_slope() const { return start_slope_; }
    const std::array<W, N>& end_slope() const { return end_slope_; }
    std::array<W, N> at(W s) const {
      const W rest = W(1) - s;
      return kernels::array_of<N>([&](std::size_t i) {
        const W chord = end[i] - start[i];
        const W bow = rest * (h * start_slope_[i] - chord) - s * (h * end_slope_[i] - chord);
        return start[i] + s * (chord + rest * bow);
      });
    }

    std::array<W, N> start;
    W h;
    std::array<W, N> start_slope_;
    std::array<W, N> end;
    std::array<W, N> end_slope_;
  };
};

template <class W, std::size_t N>
std::array<W, N> moved(const std::array<W, N>& y, const std::array<W, N>& slope, W by) {
  return kernels::array_of<N>([&](std::size_t i) { return y[i] + slope[i] * by; });
}

struct ExplicitEulerFormula {
  template <class W, std::size_t N, class Rate>
  static std::array<W, N> result(const std::array<W, N>& y, W t, W h, const Rate& rate) {
    return moved(y, rate(t, y), h);
  }
};

/// Of positions and then their velocities: the positions move with the new velocities.
struct SemiImplicitEulerFormula {
  template <class W, std::size_t N, class Rate>
  static std::array<W, N> result(const std::array<W, N>& y, W t, W h, const Rate& rate) {
    constexpr std::size_t half = N / 2;
    const std::array<W, N> end = moved(y, rate(t, y), h);
    return kernels::array_of<N>(
        [&](std::size_t i) { return i < half ? y[i] + end[(i + half) % N] * h : end[i]; });
  }
};

/// The improved Euler method: the mean of the slopes at both ends.
struct HeunFormula {
  template <class W, std::size_t N, class Rate>
  static std::array<W, N> result(const std::array<W, N>& y, W t, W h, const Rate& rate) {
    const std::array<W, N> first = rate(t, y);
    const std::array<W, N> second = rate(t + h, moved(y, first, h));
    const W half = h * W(0.5);
    return kernels::array_of<N>(
        [&](std::size_t i) { return y[i] + (first[i] + second[i]) * half; });
  }
};

struct RungeKutta4Formula {
  template <class W, std::size_t N, class Rate>
  static std::array<W, N> result(const std::array<W, N>& y, W t, W h, const Rate& rate) {
    return integrators::runge_kutta_4(y, t, h, rate);
  }
};

}  // namespace SALVO_ISA
}  // namespace salvo::solver
