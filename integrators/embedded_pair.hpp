// Explicit Runge-Kutta pairs of order 5 with an embedded method of order 4, whose difference is the
// error of a step:
//
//   k_i = f(t + c_i h, y + h sum_j a_ij k_j),     y' = y + h sum_j b_j k_j,     e = h sum_j e_j k_j
//
// The last stage is taken at the result and is the first of the next step.
//
// Dormand and Prince, "A family of embedded Runge-Kutta formulae", J. Comput. Appl. Math. 6 (1980);
// dense output: Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I", II.6.
// Tsitouras, "Runge-Kutta pairs of order 5(4) satisfying only the first column simplifying
// assumption", Comput. Math. Appl. 62 (2011).
#pragma once

#include <array>
#include <cstddef>
#include <utility>

#include "kernels/array.hpp"

namespace salvo::integrators {

inline constexpr std::size_t pair_stages = 7;

struct EmbeddedPair {
  std::array<double, pair_stages> nodes;                           // c
  std::array<std::array<double, pair_stages>, pair_stages> slope;  // a; its last row is b
  std::array<double, pair_stages> error;                           // e
};

inline constexpr EmbeddedPair dormand_prince_5{
    {0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1, 1},
    {{
        {},
        {1.0 / 5},
        {3.0 / 40, 9.0 / 40},
        {44.0 / 45, -56.0 / 15, 32.0 / 9},
        {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
        {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
        {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84},
    }},
    {71.0 / 57600, 0, -71.0 / 16695, 71.0 / 1920, -17253.0 / 339200, 22.0 / 525, -1.0 / 40}};

inline constexpr EmbeddedPair tsitouras_5{
    {0, 0.161, 0.327, 0.9, 0.9800255409045097, 1, 1},
    {{
        {},
        {0.161},
        {-0.008480655492356989, 0.335480655492357},
        {2.8971530571054935, -6.359448489975075, 4.3622954328695815},
        {5.325864828439257, -11.748883564062828, 7.4955393428898365, -0.09249506636175525},
        {5.86145544294642, -12.92096931784711, 8.159367898576159, -0.071584973281401,
         -0.028269050394068383},
        {0.09646076681806523, 0.01, 0.4798896504144996, 1.379008574103742, -3.290069515436081,
         2.324710524099774},
    }},
    {-0.00178001105222577714, -0.0008164344596567469, 0.007880878010261995, -0.1447110071732629,
     0.5823571654525552, -0.45808210592918697, 0.015151515151515152}};

inline namespace SALVO_ISA {

/// The slopes k of one step of N equations.
template <class V, std::size_t N>
using Slopes = std::array<std::array<V, N>, pair_stages>;

/// sum over j of weights[j] k[j], in ascending j, for component i; zero weights cost nothing.
template <const auto& weights, class V, std::size_t N>
V weighted_sum(const Slopes<V, N>& k, std::size_t i) {
  V sum = k[0][i] * V(weights[0]);
  [&]<std::size_t... J>(std::index_sequence<J...>) {
    const auto add = [&]<std::size_t S>() {
      if constexpr (weights[S] != 0) sum = sum + k[S][i] * V(weights[S]);
    };
    (add.template operator()<J + 1>(), ...);
  }
  (std::make_index_sequence<pair_stages - 1>{});
  return sum;
}

/// y at stage `I` of the step, from the slopes before it.
template <const EmbeddedPair& pair, std::size_t I, class V, std::size_t N>
std::array<V, N> pair_stage(const std::array<V, N>& y, V h, const Slopes<V, N>& k) {
  static constexpr const auto& weights = pair.slope[I];
  return kernels::array_of<N>(
      [&](std::size_t i) { return y[i] + weighted_sum<weights>(k, i) * h; });
}

/// y(t + h), from the slope k[0] = f(t, y); fills in the others but for the last.
template <const EmbeddedPair& pair, class V, std::size_t N, class Rate>
std::array<V, N> pair_result(const std::array<V, N>& y, V t, V h, Slopes<V, N>& k,
                             const Rate& rate) {
  [&]<std::size_t... S>(std::index_sequence<S...>) {
    ((k[S + 1] = rate(t + h * V(pair.nodes[S + 1]), pair_stage<pair, S + 1>(y, h, k))), ...);
  }
  (std::make_index_sequence<pair_stages - 2>{});
  return pair_stage<pair, pair_stages - 1>(y, h, k);
}

/// The same, with the last slope, that at the result.
template <const EmbeddedPair& pair, class V, std::size_t N, class Rate>
std::array<V, N> pair_step(const std::array<V, N>& y, V t, V h, Slopes<V, N>& k, const Rate& rate) {
  const std::array<V, N> result = pair_result<pair>(y, t, h, k, rate);
  k[pair_stages - 1] = rate(t + h, result);
  return result;
}

/// The error of component i of the step.
template <const EmbeddedPair& pair, class V, std::size_t N>
V pair_error(const Slopes<V, N>& k, V h, std::size_t i) {
  return weighted_sum<pair.error>(k, i) * h;
}

}  // namespace SALVO_ISA
}  // namespace salvo::integrators
