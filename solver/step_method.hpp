// A step of each method in one form: the result, its error where the method knows it, the slopes at
// both ends, and the solution within: to order 4 for the embedded pairs, by a step of its own for
// the others.
#pragma once

#include <array>
#include <cstddef>

#include "integrators/embedded_pair.hpp"
#include "integrators/extrapolation.hpp"
#include "integrators/runge_kutta.hpp"
#include "integrators/step_doubling.hpp"
#include "kernels/array.hpp"
#include "solver/batch.hpp"

namespace salvo::solver {
inline namespace SALVO_ISA {

using integrators::EmbeddedPair;

/// The cubic through values and slopes (over the whole step) at both ends, at a part s of the step.
template <class W>
W hermite(W start, W start_slope, W end, W end_slope, W s) {
  const W rest = W(1) - s;
  const W chord = end - start;
  return start + s * (chord + rest * (rest * (start_slope - chord) - s * (end_slope - chord)));
}

template <const EmbeddedPair& pair>
struct PairMethod {
  /// The root of the error that controls the step: exponents 1/8 and, with its square root, 1/16
  /// instead of the usual 0.14 and 0.08, because square roots take less time than a power.
  template <class W>
  static W control_root(W error) {
    return sqrt(sqrt(sqrt(error)));
  }

  template <class W, std::size_t N, class Rate>
  std::array<W, N> result(const std::array<W, N>& y, W t, W h, const Rate& rate) const {
    integrators::Slopes<W, N> k;
    k[0] = rate(t, y);
    return integrators::pair_result<pair>(y, t, h, k, rate);
  }

  template <class W, std::size_t N, class Rate>
  struct Step {
    Step(const PairMethod&, const std::array<W, N>& y, const std::array<W, N>& slope, W t, W step,
         const Rate& rate)
        : start(y), h(step) {
      k[0] = slope;
      end = integrators::pair_step<pair>(y, t, h, k, rate);
    }
    W error(std::size_t i) const { return integrators::pair_error<pair>(k, h, i); }
    const std::array<W, N>& start_slope() const { return k[0]; }
    const std::array<W, N>& end_slope() const { return k[integrators::pair_stages - 1]; }
    std::array<W, N> at(W s) const { return integrators::pair_dense<pair>(start, h, s, k); }

    std::array<W, N> start;
    std::array<W, N> end;
    W h;
    integrators::Slopes<W, N> k;
  };
};

struct RungeKutta4 {
  template <class W, std::size_t N, class Rate>
  std::array<W, N> result(const std::array<W, N>& y, W t, W h, const Rate& rate) const {
    return integrators::runge_kutta_4(y, t, h, rate);
  }
};

/// The method is chosen when it runs: compiled once for all of them.
struct AnyFixedMethod {
  Method method;

  template <class W, std::size_t N, class Rate>
  [[gnu::noinline]] std::array<W, N> result(const std::array<W, N>& y, W t, W h,
                                            const Rate& rate) const {
    const auto moved = [&](const std::array<W, N>& slope) {
      return kernels::array_of<N>([&](std::size_t i) { return y[i] + slope[i] * h; });
    };
    switch (method) {
      case Method::explicit_euler:
      case Method::step_doubling_euler:
        return moved(rate(t, y));
      case Method::semi_implicit_euler: {
        // The positions move with the new velocities.
        constexpr std::size_t half = N / 2;
        const std::array<W, N> end = moved(rate(t, y));
        return kernels::array_of<N>(
            [&](std::size_t i) { return i < half ? y[i] + end[(i + half) % N] * h : end[i]; });
      }
      case Method::heun: {
        const std::array<W, N> first = rate(t, y);
        const std::array<W, N> second = rate(t + h, moved(first));
        const W half = h * W(0.5);
        return kernels::array_of<N>(
            [&](std::size_t i) { return y[i] + (first[i] + second[i]) * half; });
      }
      case Method::extrapolation_8:
        return integrators::extrapolation_8(y, rate(t, y), t, h, rate).result;
      case Method::runge_kutta_4:
        break;
      case Method::tsitouras_5:
        return PairMethod<integrators::tsitouras_5>().result(y, t, h, rate);
      case Method::dormand_prince_5:
        return PairMethod<integrators::dormand_prince_5>().result(y, t, h, rate);
    }
    return RungeKutta4().result(y, t, h, rate);
  }

  template <class W, std::size_t N, class Rate>
  struct Step;
};

/// A method whose solution within a step is a shorter step.
template <class Method, class W, std::size_t N, class Rate>
class PlainStep {
 public:
  PlainStep(const Method& method, const std::array<W, N>& y, const std::array<W, N>& slope, W t,
            W step, const Rate& rate)
      : start(y), h(step), method_(method), rate_(rate), t_(t), start_slope_(slope) {}
  const std::array<W, N>& start_slope() const { return start_slope_; }
  const std::array<W, N>& end_slope() const { return end_slope_; }
  std::array<W, N> at(W s) const { return method_.result(start, t_, h * s, rate_); }

  std::array<W, N> start;
  std::array<W, N> end;
  W h;

 protected:
  void end_at(const std::array<W, N>& result) {
    end = result;
    end_slope_ = rate_(t_ + h, end);
  }

 private:
  const Method& method_;
  const Rate& rate_;
  W t_;
  std::array<W, N> start_slope_;
  std::array<W, N> end_slope_;
};

template <class W, std::size_t N, class Rate>
struct AnyFixedMethod::Step : PlainStep<AnyFixedMethod, W, N, Rate> {
  Step(const AnyFixedMethod& method, const std::array<W, N>& y, const std::array<W, N>& slope, W t,
       W step, const Rate& rate)
      : PlainStep<AnyFixedMethod, W, N, Rate>(method, y, slope, t, step, rate) {
    this->end_at(method.result(y, t, step, rate));
  }
};

/// The methods that know their error but are not embedded pairs.
struct AnyAdaptiveMethod : AnyFixedMethod {
  template <class W>
  W control_root(W error) const {
    const W fourth = sqrt(sqrt(error));
    return method == Method::step_doubling_euler ? fourth : sqrt(fourth);
  }

  template <class W, std::size_t N, class Rate>
  struct Step;
};

template <class W, std::size_t N, class Rate>
struct AnyAdaptiveMethod::Step : PlainStep<AnyFixedMethod, W, N, Rate> {
  Step(const AnyAdaptiveMethod& method, const std::array<W, N>& y, const std::array<W, N>& slope,
       W t, W step, const Rate& rate)
      : PlainStep<AnyFixedMethod, W, N, Rate>(method, y, slope, t, step, rate) {
    if (method.method == Method::step_doubling_euler) {
      const integrators::StepWithError<W, N> doubled =
          integrators::step_doubling_euler(y, slope, t, step, rate);
      error_ = doubled.error;
      this->end_at(doubled.result);
    } else {
      const integrators::StepWithError<W, N> extrapolated =
          integrators::extrapolation_8(y, slope, t, step, rate);
      error_ = extrapolated.error;
      this->end_at(extrapolated.result);
    }
  }
  W error(std::size_t i) const { return error_[i]; }

 private:
  std::array<W, N> error_;
};

}  // namespace SALVO_ISA
}  // namespace salvo::solver
