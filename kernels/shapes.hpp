// Signed distance of a point to a solid, in m, negative inside, with the outward unit normal at the
// nearest point of its surface. Points are relative to the middle of the solid. Every solid here is
// convex, so the distance is a convex function along any straight line.
#pragma once

#include "kernels/vec3.hpp"

namespace salvo::kernels {
inline namespace SALVO_ISA {

template <class V>
struct Surface {
  V distance;      // m
  Vec3<V> normal;  // unit, outward
};

/// A half-space behind the plane through the origin with unit normal n: d = n.p
template <class V>
Surface<V> plane_surface(Vec3<V> p, Vec3<V> normal) {
  return {dot(p, normal), normal};
}

/// d = |p| - R. In the very middle the normal is `fallback`.
template <class V>
Surface<V> sphere_surface(Vec3<V> p, V radius, Vec3<V> fallback) {
  return {norm(p) - radius, normalized_or(p, fallback)};
}

/// A unit vector at right angles to the unit vector a: along the axis of the scene least aligned
/// with it.
template <class V>
Vec3<V> any_perpendicular(Vec3<V> a) {
  const auto x_least = (abs(a.x) <= abs(a.y)) & (abs(a.x) <= abs(a.z));
  const auto y_least = abs(a.y) <= abs(a.z);
  const Vec3<V> least{select(x_least, V(1), V(0)), select((!x_least) & y_least, V(1), V(0)),
                      select((!x_least) & !y_least, V(1), V(0))};
  return normalized_or(cross(a, least), {V(1), V(0), V(0)});
}

/// All points within `radius` of a segment of the given half length along the unit vector `axis`: a
/// sphere about the nearest point of the segment.
template <class V>
Surface<V> capsule_surface(Vec3<V> p, Vec3<V> axis, V half_length, V radius) {
  const V along = clamp(dot(p, axis), -half_length, half_length);
  return sphere_surface(p - axis * along, radius, any_perpendicular(axis));
}

/// A box about the origin, axes aligned. Outside, the nearest point is p clamped to the box;
/// inside, the nearest face counts.
template <class V>
Surface<V> box_surface(Vec3<V> p, Vec3<V> half_size) {
  const Vec3<V> beyond{abs(p.x) - half_size.x, abs(p.y) - half_size.y, abs(p.z) - half_size.z};
  const V deepest = max(beyond.x, max(beyond.y, beyond.z));
  const Vec3<V> outside{max(beyond.x, V(0)), max(beyond.y, V(0)), max(beyond.z, V(0))};
  const auto x_face = beyond.x == deepest;
  const auto y_face = (!x_face) & (beyond.y == deepest);
  const Vec3<V> face{select(x_face, V(1), V(0)), select(y_face, V(1), V(0)),
                     select(x_face | y_face, V(0), V(1))};
  const auto is_outside = deepest > V(0);
  const V distance = norm(outside);
  const Vec3<V> n = select(is_outside, outside * (V(1) / select(is_outside, distance, V(1))), face);
  return {select(is_outside, distance, deepest),
          {copysign(n.x, p.x), copysign(n.y, p.y), copysign(n.z, p.z)}};
}

/// A cylinder with flat ends along the unit vector `axis`: a box in the plane of the axis and the
/// point.
template <class V>
Surface<V> cylinder_surface(Vec3<V> p, Vec3<V> axis, V half_length, V radius) {
  const V along = dot(p, axis);
  const Vec3<V> off_axis = p - axis * along;
  const V beyond_side = norm(off_axis) - radius;
  const V beyond_end = abs(along) - half_length;
  const V deepest = max(beyond_side, beyond_end);
  const V outside_side = max(beyond_side, V(0));
  const V outside_end = max(beyond_end, V(0));
  const auto is_outside = deepest > V(0);
  const V distance = sqrt(outside_side * outside_side + outside_end * outside_end);
  const V scale = V(1) / select(is_outside, distance, V(1));
  const auto side_nearer = beyond_side >= beyond_end;
  const V side = select(is_outside, outside_side * scale, select(side_nearer, V(1), V(0)));
  const V end = select(is_outside, outside_end * scale, select(side_nearer, V(0), V(1)));
  return {select(is_outside, distance, deepest),
          normalized_or(off_axis, any_perpendicular(axis)) * side + axis * copysign(end, along)};
}

}  // namespace SALVO_ISA
}  // namespace salvo::kernels
