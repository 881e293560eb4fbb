// Zero crossings of a quantity within a step, on the cubic through the values and the exact rates
// at both ends:
//
//   g(s) = g0 + m0 s + c2 s^2 + c3 s^3,     s from 0 to 1,     m = h g'
//
// Between the extrema of the cubic it is monotone, so two crossings within one step are two
// intervals, however close they are.
#pragma once

#include <array>

#include "kernels/lane.hpp"

namespace salvo::integrators {
inline namespace SALVO_ISA {

/// A quantity's values and rates (over the whole step) at both ends of a step.
template <class V>
struct QuantityOverStep {
  V g0;
  V m0;
  V g1;
  V m1;

  V c2() const { return V(3) * (g1 - g0) - V(2) * m0 - m1; }
  V c3() const { return V(2) * (g0 - g1) + m0 + m1; }
  V value(V s) const { return ((c3() * s + c2()) * s + m0) * s + g0; }
  V slope(V s) const { return (V(3) * c3() * s + V(2) * c2()) * s + m0; }
  /// What its values are measured against.
  V scale() const { return max(max(abs(g0), abs(g1)), max(abs(m0), abs(m1))); }
};

/// An extremum as near zero as this part of the scale is a graze.
inline constexpr double graze_depth = 1e-9;

/// Whether the cubic may come near zero: it lies within its control points (Bernstein), and those
/// may all be on one side.
template <class V>
typename V::Mask may_cross(const QuantityOverStep<V>& q) {
  const V third(1.0 / 3);
  const V b1 = q.g0 + q.m0 * third;
  const V b2 = q.g1 - q.m1 * third;
  const V least = min(min(q.g0, q.g1), min(b1, b2));
  const V most = max(max(q.g0, q.g1), max(b1, b2));
  const V margin = q.scale() * V(2 * graze_depth);
  return !((least > margin) | (most < -margin));
}

/// The first interval on which the cubic goes through zero, and whether it grazes zero.
template <class V>
struct Bracket {
  using Mask = typename V::Mask;
  Mask found{false};
  V low{0};  // the interval, monotone
  V high{1};
  V sign{1};  // of g before the crossing
  Mask graze{false};
  V graze_place{1};
};

/// Looks for zeros from above (`falling`), from below, or either way. A zero at s = 0 is not one:
/// the step has begun there.
template <class V>
Bracket<V> first_bracket(const QuantityOverStep<V>& q, bool falling, bool rising) {
  // Extrema, where 3 c3 s^2 + 2 c2 s + m0 = 0; those that are not within the step are put at its
  // end.
  const V c2 = q.c2();
  const V c3 = q.c3();
  const V root = sqrt(c2 * c2 - V(3) * c3 * q.m0);
  const V sum = -(c2 + copysign(root, c2));
  const auto within = [](V s) { return select((s > V(0)) & (s < V(1)), s, V(1)); };
  const V one = within(sum / (V(3) * c3));
  const V other = within(q.m0 / sum);
  const std::array<V, 4> ends{V(0), min(one, other), max(one, other), V(1)};

  Bracket<V> first;
  const V shallow = q.scale() * V(graze_depth);
  V before = q.g0;
  for (int i = 0; i < 3; ++i) {
    const V after = i == 2 ? q.g1 : q.value(ends[i + 1]);
    typename V::Mask here(false);
    if (falling) here = here | ((before > V(0)) & (after <= V(0)));
    if (rising) here = here | ((before < V(0)) & (after >= V(0)));
    const auto take = here & !first.found;
    first.low = select(take, ends[i], first.low);
    first.high = select(take, ends[i + 1], first.high);
    first.sign = select(take, copysign(V(1), before), first.sign);
    first.found = first.found | here;
    if (i < 2) {
      const auto grazes = (ends[i + 1] < V(1)) & (abs(after) <= shallow) & !first.graze;
      first.graze_place = select(grazes, ends[i + 1], first.graze_place);
      first.graze = first.graze | grazes;
    }
    before = after;
  }
  return first;
}

/// The zero of the cubic in a bracket, to the last bits of s.
template <class V>
V zero_in(const QuantityOverStep<V>& q, const Bracket<V>& bracket) {
  V low = bracket.low;
  V high = bracket.high;
  // Bisection: the interval is monotone, and a double has 53 bits.
  for (int i = 0; i < 53; ++i) {
    const V middle = (low + high) * V(0.5);
    const auto not_yet = q.value(middle) * bracket.sign > V(0);
    low = select(not_yet, middle, low);
    high = select(not_yet, high, middle);
  }
  return high;
}

}  // namespace SALVO_ISA
}  // namespace salvo::integrators
