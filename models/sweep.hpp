// Where the path of a particle first meets an obstacle.
//
// The path is a chord, a straight line, and every obstacle is grown by the particle's radius. Along
// a chord the distance to a convex solid is a convex function, so Newton's iteration from the start
// rises to the first root and cannot step over it. Above a height field the distance is piecewise
// linear; its pieces are visited in turn. The earliest meeting counts; of simultaneous ones the
// obstacle of lower index.
//
// Positions are rounded, so a particle on a surface is a little above or below it, and a path along
// a surface descends or rises a little. Both are named below (`unresolved`, `level`) and count as
// what they are meant to be.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "kernels/quat.hpp"
#include "kernels/shapes.hpp"
#include "models/obstacle.hpp"
#include "models/particle.hpp"

namespace salvo::models {
inline namespace SALVO_ISA {

using kernels::Surface;

/// Part of a step: from `position` along the straight `chord`, the velocity changing to
/// `end_velocity`. `remaining` is the time that the step has left after it.
template <class V>
struct Leg {
  Vec3<V> position, chord;
  Vec3<V> velocity, end_velocity;
  V duration, remaining;
};

template <class V>
struct Hit {
  typename V::Mask found{false};
  V fraction{2};  // of the chord; past its end where nothing is met
  Vec3<V> normal{V(0), V(1), V(0)};
  V restitution{0};
  V friction{0};
  V inverse_mass{0};
};

/// What descends by less than this part of its length runs along a surface: the rounding of a
/// tangential vector.
template <class T>
inline constexpr T grazing = 4 * std::numeric_limits<T>::epsilon();

template <class V>
V extent(Vec3<V> a) {
  return abs(a.x) + abs(a.y) + abs(a.z);
}

/// Lengths this short are not resolved at a position in the scene, given also as seen from an
/// obstacle.
template <class V>
V unresolved_length(Vec3<V> position, Vec3<V> from_obstacle) {
  return V(4 * std::numeric_limits<typename V::Real>::epsilon()) *
         (extent(position) + extent(from_obstacle));
}

/// The surface of a solid obstacle, not of a height field, as seen from its centre.
template <class V>
Surface<V> solid_surface(const Obstacle& obstacle, Vec3<V> p) {
  switch (obstacle.shape) {
    case ObstacleShape::plane:
    case ObstacleShape::height_field:
    case ObstacleShape::mesh:
      break;
    case ObstacleShape::sphere:
      return kernels::sphere_surface(p, V(obstacle.radius), {V(0), V(1), V(0)});
    case ObstacleShape::capsule:
      return kernels::capsule_surface(p, broadcast<V>(obstacle.axis), V(obstacle.half_length),
                                      V(obstacle.radius));
    case ObstacleShape::cylinder:
      return kernels::cylinder_surface(p, broadcast<V>(obstacle.axis), V(obstacle.half_length),
                                       V(obstacle.radius));
    case ObstacleShape::box: {
      const std::array<double, 4>& q = obstacle.rotation;
      const kernels::Quat<V> turn{V(q[0]), V(q[1]), V(q[2]), V(q[3])};
      const Surface<V> own =
          kernels::box_surface(rotate(conjugate(turn), p), broadcast<V>(obstacle.half_size));
      return {own.distance, rotate(turn, own.normal)};
    }
  }
  return kernels::plane_surface(p, broadcast<V>(obstacle.axis));
}

/// The triangle of a height field above or below a point of the grid (x, z), as the plane
/// height = corner + rise_x (x - column) + rise_z (z - row), horizontal lengths in spacings.
template <class V>
struct Facet {
  V column, row;
  V corner, rise_x, rise_z;

  Facet(const HeightSamples& field, V x, V z)
      : column(clamp(floor(x), V(0), V(field.columns - 2))),
        row(clamp(floor(z), V(0), V(field.rows - 2))) {
    const auto x_side = x - column >= z - row;
    corner = sample(field, column, row);
    const V far_corner = sample(field, column + V(1), row + V(1));
    const V side =
        sample(field, column + select(x_side, V(1), V(0)), row + select(x_side, V(0), V(1)));
    rise_x = select(x_side, side - corner, far_corner - side);
    rise_z = select(x_side, far_corner - side, side - corner);
  }

  V above(V x, V y, V z) const { return (y - corner) - rise_x * (x - column) - rise_z * (z - row); }
  /// Normal to the surface, of vertical component 1.
  Vec3<V> upward(V per_spacing) const {
    return {-(rise_x * per_spacing), V(1), -(rise_z * per_spacing)};
  }

 private:
  static V sample(const HeightSamples& field, V column, V row) {
    using T = typename V::Real;
    alignas(64) T columns[V::width];
    alignas(64) T rows[V::width];
    std::int32_t index[V::width];
    column.store(columns);
    row.store(rows);
    for (std::size_t lane = 0; lane < V::width; ++lane) {
      index[lane] =
          static_cast<std::int32_t>(rows[lane]) * static_cast<std::int32_t>(field.columns) +
          static_cast<std::int32_t>(columns[lane]);
    }
    if constexpr (sizeof(T) == sizeof(float)) {
      return V::gather(field.heights_float.data(), index);
    } else {
      return V::gather(field.heights.data(), index);
    }
  }
};

/// Over the triangle above or below p, seen from the field's corner, raised by the radius; at a
/// distance of 1 outside the rectangle.
template <class V>
Surface<V> field_surface(const HeightSamples& field, Vec3<V> p, V radius) {
  const V per_spacing(1 / field.spacing);
  const V x = p.x * per_spacing;
  const V z = p.z * per_spacing;
  const Facet<V> facet(field, x, z);
  const Vec3<V> upward = facet.upward(per_spacing);
  const V per_length = V(1) / norm(upward);
  const auto over =
      (x >= V(0)) & (x <= V(field.columns - 1)) & (z >= V(0)) & (z <= V(field.rows - 1));
  return {select(over, facet.above(x, p.y - radius, z) * per_length, V(1)), upward * per_length};
}

/// One chord and the obstacles.
template <class V>
class Sweep {
 public:
  using T = typename V::Real;
  using Mask = typename V::Mask;

  Sweep(Vec3<V> start, Vec3<V> chord, V radius)
      : start_(start), chord_(chord), radius_(radius), reach_(extent(chord)) {}

  /// False where the chord ends well before every obstacle: a quick test that most steps end with.
  bool may_meet(std::span<const Obstacle> obstacles, Mask active) const {
    for (const Obstacle& obstacle : obstacles) {
      if (any(active & near(obstacle))) return true;
    }
    return false;
  }

  /// `leg` is the one whose chord this is.
  [[gnu::noinline]] Hit<V> first_hit(std::span<const Obstacle> obstacles, const Leg<V>& leg,
                                     Mask active) const {
    const V half = V(0.5) * leg.duration;
    const Heading heading{
        (leg.velocity + leg.end_velocity) * half,
        -(V(grazing<T>) * (reach_ + (extent(leg.velocity) + extent(leg.end_velocity)) * half))};
    Hit<V> hit;
    for (const Obstacle& obstacle : obstacles) {
      const Mask candidates = active & near(obstacle);
      if (!any(candidates)) continue;
      if (obstacle.shape == ObstacleShape::height_field) {
        meet_field(obstacle, heading, candidates, hit);
      } else {
        meet_solid(obstacle, heading, candidates, hit);
      }
    }
    return hit;
  }

 private:
  struct Heading {
    // The chord by the mean velocity. The chord itself may be level where the velocity is not, by
    // the integrator's ways or because the position does not resolve it.
    Vec3<V> mean;
    V level;  // negative: paths that descend less are level
  };

  static constexpr int max_iterations = 16;

  /// Radius of a sphere about the centre that holds the solid.
  static double bound(const Obstacle& obstacle) {
    switch (obstacle.shape) {
      case ObstacleShape::sphere:
        return obstacle.radius;
      case ObstacleShape::capsule:
      case ObstacleShape::cylinder:
        return obstacle.half_length + obstacle.radius;
      case ObstacleShape::box:
        return obstacle.half_size[0] + obstacle.half_size[1] + obstacle.half_size[2];
      case ObstacleShape::plane:
      case ObstacleShape::height_field:
      case ObstacleShape::mesh:
        break;
    }
    return std::numeric_limits<double>::infinity();
  }

  Mask near(const Obstacle& obstacle) const {
    const Vec3<V> start = start_ - broadcast<V>(obstacle.center);
    const V unresolved = unresolved_length(start_, start);
    if (obstacle.shape == ObstacleShape::plane) {
      const Vec3<V> n = broadcast<V>(obstacle.axis);
      return (dot(start, n) - radius_) + min(dot(n, chord_), V(0)) <= unresolved;
    }
    if (obstacle.shape == ObstacleShape::height_field) {
      const HeightSamples& field = *obstacle.samples;
      const V width(field.spacing * static_cast<double>(field.columns - 1));
      const V depth(field.spacing * static_cast<double>(field.rows - 1));
      return (start.y - reach_ - radius_ <= V(field.highest) + unresolved) &
             (start.x - reach_ <= width + unresolved) & (start.x + reach_ >= -unresolved) &
             (start.z - reach_ <= depth + unresolved) & (start.z + reach_ >= -unresolved);
    }
    const V reach = reach_ + radius_ + V(bound(obstacle)) + unresolved;
    return norm_squared(start) <= reach * reach;
  }

  static void take(Mask found, V t, Vec3<V> normal, const Obstacle& obstacle, Hit<V>& hit) {
    const Mask first = found & (t < hit.fraction);
    hit.found = hit.found | first;
    hit.fraction = select(first, t, hit.fraction);
    hit.normal = select(first, normal, hit.normal);
    hit.restitution = select(first, V(obstacle.restitution), hit.restitution);
    hit.friction = select(first, V(obstacle.friction), hit.friction);
    hit.inverse_mass = select(first, V(1 / obstacle.mass), hit.inverse_mass);
  }

  void meet_solid(const Obstacle& obstacle, const Heading& heading, Mask active,
                  Hit<V>& hit) const {
    const Vec3<V> start = start_ - broadcast<V>(obstacle.center);
    Surface<V> at = solid_surface(obstacle, start);
    V gap = at.distance - radius_;
    V slope = dot(at.normal, chord_);  // of the gap along the chord
    const Mask touches = gap <= unresolved_length(start_, start);
    Mask found = active & touches &
                 ((slope < heading.level) | (dot(at.normal, heading.mean) < heading.level));
    Mask going = active & (!touches) & (slope < heading.level) & (gap <= -slope);
    if (!any(found | going)) return;

    V t(0);
    Vec3<V> normal = at.normal;
    for (int i = 0; i < max_iterations && any(going); ++i) {
      t = select(going, t - gap / slope, t);
      going = going & (t <= V(1)) & (t < hit.fraction);
      at = solid_surface(obstacle, start + chord_ * t);
      gap = at.distance - radius_;
      slope = dot(at.normal, chord_);
      normal = select(going, at.normal, normal);
      going = going & (slope < heading.level);
      const Mask arrived = going & (gap <= V(-4 * std::numeric_limits<T>::epsilon()) * slope);
      t = select(arrived & (gap > V(0)), t - gap / slope, t);
      found = found | arrived;
      going = going & !arrived;
    }
    // Still on its way in after all iterations: close enough, and on the safe side.
    take(found | going, t, normal, obstacle, hit);
  }

  // Narrows [enter, leave] to the part of p + t d within [low, high].
  static void clip(V p, V d, V low, V high, V& enter, V& leave) {
    const Mask moves = d != V(0);
    const V divisor = select(moves, d, V(1));
    const V to_low = (low - p) / divisor;
    const V to_high = (high - p) / divisor;
    const Mask outside = (!moves) & ((p < low) | (p > high));
    enter = select(moves, max(enter, min(to_low, to_high)), select(outside, V(2), enter));
    leave = select(moves, min(leave, max(to_low, to_high)), leave);
  }

  // The places along a chord where a coordinate p + t d is a whole number, one after the other.
  struct Lines {
    Lines(V start, V step, V t) : p(start), d(step), moves(step != V(0)) {
      const V now = p + d * t;
      sign = select(d < V(0), V(-1), V(1));
      line = select(d < V(0), ceil(now), floor(now)) + sign;
    }
    V crossing() const { return select(moves, (line - p) / select(moves, d, V(1)), V(2)); }
    void pass(V t) { line = select(moves & (crossing() <= t), line + sign, line); }

    V p, d;
    Mask moves;
    V sign, line;
  };

  // The lowest point of the particle against the triangles, one after the other along the chord. On
  // a slope the sphere's side sinks in by radius (1/cos - 1).
  void meet_field(const Obstacle& obstacle, const Heading& heading, Mask active,
                  Hit<V>& hit) const {
    const HeightSamples& field = *obstacle.samples;
    const Vec3<V> start = start_ - broadcast<V>(obstacle.center);
    const V unresolved = unresolved_length(start_, start);
    const V per_spacing(1 / field.spacing);
    const V x = start.x * per_spacing;
    const V y = start.y - radius_;
    const V z = start.z * per_spacing;
    const V dx = chord_.x * per_spacing;
    const V dy = chord_.y;
    const V dz = chord_.z * per_spacing;

    // The part of the chord over the rectangle and not above the highest sample.
    V enter(0);
    V leave = min(hit.fraction, V(1));
    clip(x, dx, V(0), V(field.columns - 1), enter, leave);
    clip(z, dz, V(0), V(field.rows - 1), enter, leave);
    clip(y, dy, V(-std::numeric_limits<T>::max()), V(field.highest) + unresolved, enter, leave);
    Mask going = active & (enter <= leave);
    if (!any(going)) return;

    // The sides of the triangles are the lines of whole x, whole z and whole x - z.
    Lines across(x, dx, enter);
    Lines along(z, dz, enter);
    Lines diagonal(x - z, dx - dz, enter);
    Mask found(false);
    V found_at(0);
    Vec3<V> normal{V(0), V(1), V(0)};
    V t = enter;
    // No chord crosses more lines than there are.
    const std::size_t most = 2 * (field.columns + field.rows) + 4;
    for (std::size_t k = 0; k < most && any(going); ++k) {
      const V next =
          max(t, min(leave, min(across.crossing(), min(along.crossing(), diagonal.crossing()))));
      const V middle = V(0.5) * (t + next);
      const Facet<V> facet(field, x + dx * middle, z + dz * middle);
      const V gap = facet.above(x + dx * t, y + dy * t, z + dz * t);
      const V slope = dy - facet.rise_x * dx - facet.rise_z * dz;
      const Vec3<V> upward = facet.upward(per_spacing);
      const V length = norm(upward);
      const Mask descends = slope < heading.level * length;
      const Mask touches =
          (gap <= unresolved) &
          (descends | ((t <= V(0)) & (dot(upward, heading.mean) < heading.level * length)));
      const V at = select(touches, t, t + gap / select(descends, -slope, V(1)));
      const Mask meets = going & (touches | (descends & (at <= next)));
      found = found | meets;
      found_at = select(meets, at, found_at);
      normal = select(meets, upward * (V(1) / length), normal);
      t = next;
      going = going & (!meets) & (t < leave);
      across.pass(t);
      along.pass(t);
      diagonal.pass(t);
    }
    take(found, found_at, normal, obstacle, hit);
  }

  Vec3<V> start_, chord_;
  V radius_;
  V reach_;  // at least the length of the chord, without a square root
};

}  // namespace SALVO_ISA
}  // namespace salvo::models
