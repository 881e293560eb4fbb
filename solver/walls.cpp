#include "solver/walls.hpp"

#include <algorithm>

#include "kernels/math.hpp"
#include "kernels/quat.hpp"
#include "kernels/sphere_contact.hpp"
#include "models/sweep.hpp"

namespace salvo::solver {

namespace {

using models::Obstacle;
using models::ObstacleShape;
using models::Triple;
using S = kernels::ScalarLane<double>;
using Vec = kernels::Vec3<S>;
using Quat = kernels::Quat<S>;

Vec vector(const Triple& t) { return {S(t[0]), S(t[1]), S(t[2])}; }
Triple triple(const Vec& v) { return {v.x.value(), v.y.value(), v.z.value()}; }
Quat quaternion(const std::array<double, 4>& q) { return {S(q[0]), S(q[1]), S(q[2]), S(q[3])}; }

// How far from its center an obstacle reaches; a plane or a height field that turns, anywhere.
double reach_of(const Obstacle& obstacle) {
  switch (obstacle.shape) {
    case ObstacleShape::sphere:
      return obstacle.radius;
    case ObstacleShape::capsule:
    case ObstacleShape::cylinder:
      return obstacle.radius + obstacle.half_length;
    case ObstacleShape::box:
      return norm(vector(obstacle.half_size)).value();
    case ObstacleShape::plane:
    case ObstacleShape::height_field:
      break;
  }
  return std::numeric_limits<double>::infinity();
}

bool turned_onto_itself(const Obstacle& obstacle) {
  const Vec spin = vector(obstacle.motion.angular_velocity);
  switch (obstacle.shape) {
    case ObstacleShape::sphere:
      return true;
    case ObstacleShape::plane:
    case ObstacleShape::capsule:
    case ObstacleShape::cylinder:
      return norm(cross(spin, vector(obstacle.axis))).value() == 0;
    case ObstacleShape::box:
    case ObstacleShape::height_field:
      break;
  }
  return norm(spin).value() == 0;
}

// How fast the surface comes towards a particle at most.
double fastest_of(const Obstacle& obstacle) {
  const models::ObstacleMotion& motion = obstacle.motion;
  const double swing = 2 * kernels::pi * motion.frequency * norm(vector(motion.amplitude)).value();
  double speed = norm(vector(motion.velocity)).value() + swing;
  if (!turned_onto_itself(obstacle)) {
    speed += norm(vector(motion.angular_velocity)).value() * reach_of(obstacle);
  }
  return speed;
}

}  // namespace

Triple Bounds::center() const {
  Triple middle;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    middle[axis] = 0.5 * (lowest_[axis] + highest_[axis]);
  }
  return middle;
}

double Bounds::radius() const {
  const Triple middle = center();
  return norm(Vec{S(highest_[0] - middle[0]), S(highest_[1] - middle[1]),
                  S(highest_[2] - middle[2])})
      .value();
}

Walls::Walls(std::span<const Obstacle> obstacles) {
  for (const Obstacle& obstacle : obstacles) {
    add(obstacle);
    fastest_ = std::max(fastest_, fastest_of(obstacle));
  }
  for (const Part& part : parts_) {
    now_.push_back({part.shape, {}, {}, kernels::damping_ratio_of(part.shape.restitution)});
  }
}

void Walls::add(const Obstacle& obstacle) {
  if (!obstacle.hollow ||
      (obstacle.shape != ObstacleShape::box && obstacle.shape != ObstacleShape::cylinder)) {
    parts_.push_back({obstacle, obstacle.center});
    return;
  }
  const auto add_plane = [&](const Vec& outward, double distance) {
    Obstacle plane = obstacle;
    plane.shape = ObstacleShape::plane;
    plane.hollow = false;
    plane.center = triple(vector(obstacle.center) + outward * S(distance));
    plane.axis = triple(-outward);
    parts_.push_back({plane, obstacle.center});
  };
  if (obstacle.shape == ObstacleShape::cylinder) {
    // A capsule whose round ends lie beyond the flat ones.
    Obstacle side = obstacle;
    side.shape = ObstacleShape::capsule;
    side.half_length += obstacle.radius;
    parts_.push_back({side, obstacle.center});
    add_plane(vector(obstacle.axis), obstacle.half_length);
    add_plane(-vector(obstacle.axis), obstacle.half_length);
    return;
  }
  const Quat turn = quaternion(obstacle.rotation);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Vec along{S(0), S(0), S(0)};
    (axis == 0 ? along.x : axis == 1 ? along.y : along.z) = S(1);
    const Vec outward = rotate(turn, along);
    add_plane(outward, obstacle.half_size[axis]);
    add_plane(-outward, obstacle.half_size[axis]);
  }
}

void Walls::place(double time) {
  for (std::size_t w = 0; w < parts_.size(); ++w) {
    const Part& part = parts_[w];
    const models::ObstacleMotion& motion = part.shape.motion;
    if (motion == models::ObstacleMotion{}) continue;
    Wall& wall = now_[w];
    const S t(time);
    const Vec spin = vector(motion.angular_velocity);
    const S rate = norm(spin);
    Quat turn{S(1), S(0), S(0), S(0)};
    if (rate.value() > 0) {
      const S half = S(0.5) * rate * t;
      const Vec axis = spin * (S(1) / rate);
      const S sine = sin(half);
      turn = {cos(half), axis.x * sine, axis.y * sine, axis.z * sine};
    }
    const S phase = S(2 * kernels::pi * motion.frequency) * t;
    const Vec arm = rotate(turn, vector(part.shape.center) - vector(part.pivot));
    const Vec shift = vector(motion.velocity) * t + vector(motion.amplitude) * sin(phase);
    const Vec swing =
        vector(motion.amplitude) * (S(2 * kernels::pi * motion.frequency) * cos(phase));
    wall.shape.center = triple(vector(part.pivot) + shift + arm);
    wall.shape.axis = triple(rotate(turn, vector(part.shape.axis)));
    const Quat whole = turn * quaternion(part.shape.rotation);
    wall.shape.rotation = {whole.w.value(), whole.x.value(), whole.y.value(), whole.z.value()};
    wall.velocity = triple(vector(motion.velocity) + swing + cross(spin, arm));
    wall.angular_velocity = motion.angular_velocity;
  }
}

bool Walls::may_reach(std::size_t w, const Bounds& bounds, double margin) const {
  const Obstacle& shape = now_[w].shape;
  const Triple center = bounds.center();
  const double reach = bounds.radius() + margin;
  const Vec p = vector(center) - vector(shape.center);
  if (shape.shape == ObstacleShape::height_field) {
    const models::HeightSamples& field = *shape.samples;
    const double width = field.spacing * static_cast<double>(field.columns - 1);
    const double depth = field.spacing * static_cast<double>(field.rows - 1);
    return p.y.value() - reach <= field.highest && p.x.value() + reach >= 0 &&
           p.x.value() - reach <= width && p.z.value() + reach >= 0 && p.z.value() - reach <= depth;
  }
  // A distance changes by no more than the way.
  const double distance = models::solid_surface<S>(shape, p).distance.value();
  return (shape.hollow ? -distance : distance) <= reach;
}

}  // namespace salvo::solver
