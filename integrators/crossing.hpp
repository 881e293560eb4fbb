// Zero crossings of a quantity within a step, bracketed on the cubic through the values and the
// exact rates at both ends:
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

template <class V>
struct Crossing {
  typename V::Mask found{false};
  V place{0};  // s on the cubic, 0 to 1
  V slope{0};  // dg/ds there
};

/// The first place at which g goes through zero from above (`falling`), from below, or either way.
/// A zero at s = 0 is not one: that step has begun there.
template <class V>
Crossing<V> first_crossing(V g0, V m0, V g1, V m1, bool falling, bool rising) {
  const V c2 = V(3) * (g1 - g0) - V(2) * m0 - m1;
  const V c3 = V(2) * (g0 - g1) + m0 + m1;
  const auto value = [&](V s) { return ((c3 * s + c2) * s + m0) * s + g0; };

  // Extrema, where 3 c3 s^2 + 2 c2 s + m0 = 0; those that are not within the step are put at its
  // end.
  const V root = sqrt(c2 * c2 - V(3) * c3 * m0);
  const V q = -(c2 + copysign(root, c2));
  const auto within = [](V s) { return select((s > V(0)) & (s < V(1)), s, V(1)); };
  const V one = within(q / (V(3) * c3));
  const V other = within(m0 / q);
  const std::array<V, 4> ends{V(0), min(one, other), max(one, other), V(1)};

  Crossing<V> first;
  V low(0);
  V high(1);
  V sign(1);  // of g before the crossing
  V before = g0;
  for (int i = 0; i < 3; ++i) {
    const V after = i == 2 ? g1 : value(ends[i + 1]);
    typename V::Mask here(false);
    if (falling) here = here | ((before > V(0)) & (after <= V(0)));
    if (rising) here = here | ((before < V(0)) & (after >= V(0)));
    const auto take = here & !first.found;
    low = select(take, ends[i], low);
    high = select(take, ends[i + 1], high);
    sign = select(take, copysign(V(1), before), sign);
    first.found = first.found | here;
    before = after;
  }
  if (!any(first.found)) return first;
  // Bisection: the interval is monotone, and a double has 53 bits.
  for (int i = 0; i < 53; ++i) {
    const V middle = (low + high) * V(0.5);
    const auto not_yet = value(middle) * sign > V(0);
    low = select(not_yet, middle, low);
    high = select(not_yet, high, middle);
  }
  first.place = high;
  first.slope = (V(3) * c3 * high + V(2) * c2) * high + m0;
  return first;
}

}  // namespace SALVO_ISA
}  // namespace salvo::integrators
