// Unit quaternions over lanes: rotations. q = w + xi + yj + zk turns v by q v q*.
#pragma once

#include "kernels/mat3.hpp"
#include "kernels/math.hpp"

namespace salvo::kernels {
inline namespace SALVO_ISA {

template <class V>
struct Quat {
  V w, x, y, z;

  static Quat identity() { return {V(1), V(0), V(0), V(0)}; }
  /// The right-handed rotation by `angle` radians about the unit vector `axis`.
  static Quat from_axis_angle(Vec3<V> axis, V angle) {
    const V half = angle * V(0.5);
    const V s = sin(half);
    return {cos(half), axis.x * s, axis.y * s, axis.z * s};
  }
  /// Hamilton product: the rotation b followed by a.
  friend Quat operator*(Quat a, Quat b) {
    return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
            a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
            a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
  }
  friend Quat conjugate(Quat q) { return {q.w, -q.x, -q.y, -q.z}; }
  friend Quat normalized(Quat q) {
    const V scale = V(1) / sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    return {q.w * scale, q.x * scale, q.y * scale, q.z * scale};
  }
  friend Vec3<V> rotate(Quat q, Vec3<V> v) {
    const Vec3<V> u{q.x, q.y, q.z};
    const Vec3<V> t = cross(u, v) * V(2);
    return v + t * q.w + cross(u, t);
  }
  friend Mat3<V> to_matrix(Quat q) {
    return transpose(Mat3<V>{rotate(q, {V(1), V(0), V(0)}), rotate(q, {V(0), V(1), V(0)}),
                             rotate(q, {V(0), V(0), V(1)})});
  }
};

}  // namespace SALVO_ISA
}  // namespace salvo::kernels
