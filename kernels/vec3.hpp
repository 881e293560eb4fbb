// Three-vectors over lanes (or plain numbers): right-handed Cartesian axes.
#pragma once

#include "kernels/lane.hpp"

namespace salvo::kernels {
inline namespace SALVO_ISA {

template <class V>
struct Vec3 {
  V x, y, z;

  friend Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
  friend Vec3 operator*(Vec3 a, V s) { return {a.x * s, a.y * s, a.z * s}; }
  friend Vec3 operator*(V s, Vec3 a) { return a * s; }
  Vec3& operator+=(Vec3 b) { return *this = *this + b; }
  Vec3& operator-=(Vec3 b) { return *this = *this - b; }

  /// The scalar product.
  friend V dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
  /// The vector product, right-handed: cross(x, y) = z.
  friend Vec3 cross(Vec3 a, Vec3 b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  }
  friend V norm_squared(Vec3 a) { return dot(a, a); }
  friend V norm(Vec3 a) { return sqrt(dot(a, a)); }
};

/// a where the mask is true, b elsewhere.
template <class V>
Vec3<V> select(typename V::Mask m, Vec3<V> a, Vec3<V> b) {
  return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}

/// a / |a|, or `fallback` where a is zero.
template <class V>
Vec3<V> normalized_or(Vec3<V> a, Vec3<V> fallback) {
  const V length = norm(a);
  const auto usable = length > V(0);
  return select(usable, a * (V(1) / select(usable, length, V(1))), fallback);
}

/// True where every component is finite.
template <class V>
typename V::Mask is_finite(Vec3<V> a) {
  return is_finite(a.x) & is_finite(a.y) & is_finite(a.z);
}

}  // namespace SALVO_ISA
}  // namespace salvo::kernels
