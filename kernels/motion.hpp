// The state of a moving point, and the three instants of a step at which its acceleration is asked
// for.
#pragma once

#include "kernels/vec3.hpp"

namespace salvo::kernels {
inline namespace SALVO_ISA {

template <class V>
struct Motion {
  Vec3<V> position;  // m
  Vec3<V> velocity;  // m/s
};

template <class V>
Motion<V> select(typename V::Mask m, const Motion<V>& a, const Motion<V>& b) {
  return {select(m, a.position, b.position), select(m, a.velocity, b.velocity)};
}

/// Where in the step from t to t + dt a force is evaluated.
enum class Instant { start, middle, end };

}  // namespace SALVO_ISA
}  // namespace salvo::kernels
