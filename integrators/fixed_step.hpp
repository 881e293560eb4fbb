// Fixed-step integrators of x' = v, v' = a(x, v, t): Bourg & Bywalec chapter 7 and velocity Verlet.
// `acceleration(position, velocity, instant)` returns a in m/s^2; `dt` is in s.
//
//   explicit Euler       x += v dt;            v += a dt                     order 1
//   semi-implicit Euler  v += a dt;            x += v dt (the new v)         order 1, symplectic
//   improved Euler       the mean of the slopes at both ends (Heun)          order 2
//   Runge-Kutta          four slopes, weights 1 2 2 1                        order 4
//   velocity Verlet      x += v dt + a dt^2/2; v += (a + a') dt/2            order 2
//
// The book's listings of the improved Euler and Runge-Kutta methods advance the position with the
// new velocity, which is of first order; here position and velocity are one state.
#pragma once

#include "kernels/motion.hpp"

namespace salvo::integrators {
inline namespace SALVO_ISA {

using kernels::Instant;
using kernels::Motion;
using kernels::Vec3;

struct ExplicitEuler {
  template <class V, class Acceleration>
  static Motion<V> step(const Motion<V>& s, V dt, const Acceleration& acceleration) {
    const Vec3<V> a = acceleration(s.position, s.velocity, Instant::start);
    return {s.position + s.velocity * dt, s.velocity + a * dt};
  }
};

struct SemiImplicitEuler {
  template <class V, class Acceleration>
  static Motion<V> step(const Motion<V>& s, V dt, const Acceleration& acceleration) {
    const Vec3<V> velocity = s.velocity + acceleration(s.position, s.velocity, Instant::start) * dt;
    return {s.position + velocity * dt, velocity};
  }
};

struct ImprovedEuler {
  template <class V, class Acceleration>
  static Motion<V> step(const Motion<V>& s, V dt, const Acceleration& acceleration) {
    const Vec3<V> a1 = acceleration(s.position, s.velocity, Instant::start);
    const Vec3<V> v2 = s.velocity + a1 * dt;
    const Vec3<V> a2 = acceleration(s.position + s.velocity * dt, v2, Instant::end);
    const V half = dt * V(0.5);
    return {s.position + (s.velocity + v2) * half, s.velocity + (a1 + a2) * half};
  }
};

struct RungeKutta4 {
  template <class V, class Acceleration>
  static Motion<V> step(const Motion<V>& s, V dt, const Acceleration& acceleration) {
    const V half = dt * V(0.5);
    const Vec3<V> a1 = acceleration(s.position, s.velocity, Instant::start);
    const Vec3<V> v2 = s.velocity + a1 * half;
    const Vec3<V> a2 = acceleration(s.position + s.velocity * half, v2, Instant::middle);
    const Vec3<V> v3 = s.velocity + a2 * half;
    const Vec3<V> a3 = acceleration(s.position + v2 * half, v3, Instant::middle);
    const Vec3<V> v4 = s.velocity + a3 * dt;
    const Vec3<V> a4 = acceleration(s.position + v3 * dt, v4, Instant::end);
    const V sixth = dt / V(6);
    return {s.position + (s.velocity + (v2 + v3) * V(2) + v4) * sixth,
            s.velocity + (a1 + (a2 + a3) * V(2) + a4) * sixth};
  }
};

struct VelocityVerlet {
  template <class V, class Acceleration>
  static Motion<V> step(const Motion<V>& s, V dt, const Acceleration& acceleration) {
    const V half = dt * V(0.5);
    const Vec3<V> a1 = acceleration(s.position, s.velocity, Instant::start);
    const Vec3<V> predicted = s.velocity + a1 * dt;
    // The mean velocity times dt: x + v dt + a dt^2/2 rounds twice as often, and energy drifts with
    // it.
    const Vec3<V> position = s.position + (s.velocity + predicted) * half;
    // Forces that depend on velocity are taken at the predicted velocity.
    const Vec3<V> a2 = acceleration(position, predicted, Instant::end);
    return {position, s.velocity + (a1 + a2) * half};
  }
};

}  // namespace SALVO_ISA
}  // namespace salvo::integrators
