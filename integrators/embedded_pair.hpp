// Explicit Runge-Kutta pairs of order 5 with an embedded method of order 4, whose difference is the
// error of a step:
//
//   k_i = f(t + c_i h, y + h sum_j a_ij k_j),     y' = y + h sum_j b_j k_j,     e = h sum_j e_j k_j
//
// The last stage is taken at the result and is the first of the next step. Within the step, at t +
// s h, the solution is y + h sum_j B_j(s) k_j with B_j(s) = d_j1 s + d_j2 s^2 + d_j3 s^3 + d_j4
// s^4, of order 4.
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
  std::array<std::array<double, 4>, pair_stages> dense;            // d
};

namespace detail {

// Hairer's form: s [b + (1 - s) [(p - b) + s [(2 b - p - q) + (1 - s) d]]], where p is 1 for the
// first stage and q for the last.
constexpr std::array<double, 4> hairer(double b, double p, double q, double d) {
  const double u = p - b;
  const double w = 2 * b - p - q;
  return {p, w + d - u, -w - 2 * d, d};
}

// a s^2 (s^2 + p s + q)
constexpr std::array<double, 4> quartic(double a, double p, double q) {
  return {0, a * q, a * p, a};
}

// a s (s - r) (s^2 + p s + q)
constexpr std::array<double, 4> quartic(double a, double r, double p, double q) {
  return {-a * r * q, a * (q - r * p), a * (p - r), a};
}

}  // namespace detail

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
    {71.0 / 57600, 0, -71.0 / 16695, 71.0 / 1920, -17253.0 / 339200, 22.0 / 525, -1.0 / 40},
    {{
        detail::hairer(35.0 / 384, 1, 0, -12715105075.0 / 11282082432.0),
        {},
        detail::hairer(500.0 / 1113, 0, 0, 87487479700.0 / 32700410799.0),
        detail::hairer(125.0 / 192, 0, 0, -10690763975.0 / 1880347072.0),
        detail::hairer(-2187.0 / 6784, 0, 0, 701980252875.0 / 199316789632.0),
        detail::hairer(11.0 / 84, 0, 0, -1453857185.0 / 822651844.0),
        detail::hairer(0, 0, 1, 69997945.0 / 29380423.0),
    }}};

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
     0.5823571654525552, -0.45808210592918697, 0.015151515151515152},
    {{
        detail::quartic(-1.0530884977290216, 1.3299890189751412, -1.4364028541716351,
                        0.7139816917074209),
        detail::quartic(0.1017, -2.1966568338249754, 1.2949852507374631),
        detail::quartic(2.490627285651252793, -2.38535645472061657, 1.57803468208092486),
        detail::quartic(-16.54810288924490272, -1.21712927295533244 - 0.61620406037800089,
                        1.21712927295533244 * 0.61620406037800089),
        detail::quartic(47.37952196281928122, -1.203071208372362603 - 0.658047292653547382,
                        1.203071208372362603 * 0.658047292653547382),
        detail::quartic(-34.87065786149660974, -1.2 - 0.666666666666666667,
                        1.2 * 0.666666666666666667),
        detail::quartic(2.5, -1.6, 0.6),
    }}};

inline namespace SALVO_ISA {

/// The slopes k of one step of N equations.
template <class V, std::size_t N>
using Slopes = std::array<std::array<V, N>, pair_stages>;

/// sum over j of w_j k[j] for component i, in ascending j, where `weights(pair)` are the w; zero
/// weights cost nothing.
template <const EmbeddedPair& pair, auto weights, class V, std::size_t N>
V weighted_sum(const Slopes<V, N>& k, std::size_t i) {
  V sum = k[0][i] * V(weights(pair)[0]);
  [&]<std::size_t... J>(std::index_sequence<J...>) {
    const auto add = [&]<std::size_t S>() {
      if constexpr (weights(pair)[S] != 0) sum = sum + k[S][i] * V(weights(pair)[S]);
    };
    (add.template operator()<J + 1>(), ...);
  }
  (std::make_index_sequence<pair_stages - 1>{});
  return sum;
}

/// y at stage `I` of the step, from the slopes before it.
template <const EmbeddedPair& pair, std::size_t I, class V, std::size_t N>
std::array<V, N> pair_stage(const std::array<V, N>& y, V h, const Slopes<V, N>& k) {
  constexpr auto weights = [](const EmbeddedPair& p) { return p.slope[I]; };
  return kernels::array_of<N>(
      [&](std::size_t i) { return y[i] + weighted_sum<pair, weights>(k, i) * h; });
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

/// y(t + s h), s from 0 to 1, from all slopes of the step.
template <const EmbeddedPair& pair, class V, std::size_t N>
std::array<V, N> pair_dense(const std::array<V, N>& y, V h, V s, const Slopes<V, N>& k) {
  const auto weight = [&](std::size_t j) {
    const std::array<double, 4>& d = pair.dense[j];
    return (((V(d[3]) * s + V(d[2])) * s + V(d[1])) * s + V(d[0])) * s;
  };
  const std::array<V, pair_stages> b = kernels::array_of<pair_stages>(weight);
  return kernels::array_of<N>([&](std::size_t i) {
    V sum = b[0] * k[0][i];
    for (std::size_t j = 1; j < pair_stages; ++j) sum = sum + b[j] * k[j][i];
    return y[i] + sum * h;
  });
}

/// The error of component i of the step.
template <const EmbeddedPair& pair, class V, std::size_t N>
V pair_error(const Slopes<V, N>& k, V h, std::size_t i) {
  constexpr auto weights = [](const EmbeddedPair& p) { return p.error; };
  return weighted_sum<pair, weights>(k, i) * h;
}

}  // namespace SALVO_ISA
}  // namespace salvo::integrators
