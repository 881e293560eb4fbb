// Dual<V>: a value and its rate of change, carried through a formula together (forward automatic
// differentiation). A quantity written once over any lane type gives its exact rate along a
// trajectory when it is given the state with its slope.
#pragma once

#include <type_traits>

#include "kernels/math.hpp"

namespace salvo::kernels {
inline namespace SALVO_ISA {

template <class V>
struct Dual {
  using Real = typename V::Real;

  Dual() = default;
  template <class U>
  requires std::is_arithmetic_v<U> Dual(U constant) : value(constant), rate(0) {}
  Dual(V the_value, V the_rate) : value(the_value), rate(the_rate) {}

  V value;
  V rate;

  friend Dual operator+(Dual a, Dual b) { return {a.value + b.value, a.rate + b.rate}; }
  friend Dual operator-(Dual a, Dual b) { return {a.value - b.value, a.rate - b.rate}; }
  friend Dual operator-(Dual a) { return {-a.value, -a.rate}; }
  friend Dual operator*(Dual a, Dual b) {
    return {a.value * b.value, a.rate * b.value + a.value * b.rate};
  }
  friend Dual operator/(Dual a, Dual b) {
    const V quotient = a.value / b.value;
    return {quotient, (a.rate - quotient * b.rate) / b.value};
  }
  /// The rate at zero is infinite or NaN.
  friend Dual sqrt(Dual a) {
    const V root = sqrt(a.value);
    return {root, a.rate / (root + root)};
  }
  friend Dual sin(Dual a) { return {sin(a.value), a.rate * cos(a.value)}; }
  friend Dual cos(Dual a) { return {cos(a.value), -(a.rate * sin(a.value))}; }
};

}  // namespace SALVO_ISA
}  // namespace salvo::kernels
