#include "solver/walls.hpp"

#include <algorithm>
#include <cmath>

#include "kernels/math.hpp"
#include "kernels/quat.hpp"
#include "kernels/sphere_contact.hpp"
#include "models/sweep.hpp"
#include "models/triangle_mesh.hpp"

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

// Of a number less the number as a float. Volatile, because gcc 12 takes (double)(float)x for x
// where it vectorizes: n - (double)(float)n of two neighboring numbers becomes 0.
double float_rest(double number) {
  const volatile float rounded = static_cast<float>(number);
  return number - static_cast<double>(rounded);
}

Triple float_rest(const Triple& t) {
  return {float_rest(t[0]), float_rest(t[1]), float_rest(t[2])};
}

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
    case ObstacleShape::mesh: {
      double farthest = 0;
      for (const models::MeshBounds& bounds : obstacle.mesh->bounds) {
        for (const Triple& corner : {bounds.lowest, bounds.highest}) {
          for (const double coordinate : corner)
            farthest = std::max(farthest, std::abs(coordinate));
        }
      }
      return 2 * farthest;  // of the corners of the box about it: less than twice that
    }
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
    case ObstacleShape::mesh:
      break;
  }
  return norm(spin).value() == 0;
}

}  // namespace

double fastest(const Obstacle& obstacle) {
  const models::ObstacleMotion& motion = obstacle.motion;
  const double swing = 2 * kernels::pi * motion.frequency * norm(vector(motion.amplitude)).value();
  double speed = norm(vector(motion.velocity)).value() + swing;
  if (!turned_onto_itself(obstacle)) {
    speed += norm(vector(motion.angular_velocity)).value() * reach_of(obstacle);
  }
  return speed;
}

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
    const std::size_t before = plans_.size();
    add(obstacle);
    const auto number = static_cast<std::size_t>(&obstacle - obstacles.data());
    const double speed = solver::fastest(obstacle);
    const bool everywhere = !(speed < std::numeric_limits<double>::infinity());
    if (!everywhere) fastest_ = std::max(fastest_, speed);
    for (std::size_t p = before; p < plans_.size(); ++p) {
      plans_[p].obstacle = number;
      plans_[p].everywhere = everywhere;
    }
  }
  for (Plan& plan : plans_) {
    const auto wall = static_cast<std::uint32_t>(now_.size());
    plan.first_part = static_cast<std::uint32_t>(parts_.size());
    const bool is_mesh = plan.shape.shape == ObstacleShape::mesh;
    const std::size_t features = is_mesh ? plan.shape.mesh->size() : 1;
    for (std::uint32_t feature = 0; feature < features; ++feature) {
      parts_.push_back({wall, feature});
    }
    if (is_mesh) plan.grid = FeatureGrid(*plan.shape.mesh);
    now_.push_back({plan.shape,
                    {},
                    {},
                    kernels::damping_ratio_of(plan.shape.restitution),
                    float_rest(plan.shape.center)});
  }
}

void Walls::add(const Obstacle& obstacle) {
  if (!obstacle.hollow ||
      (obstacle.shape != ObstacleShape::box && obstacle.shape != ObstacleShape::cylinder)) {
    plans_.push_back({obstacle, obstacle.center, 0, {}});
    return;
  }
  const auto add_plane = [&](const Vec& outward, double distance) {
    Obstacle plane = obstacle;
    plane.shape = ObstacleShape::plane;
    plane.hollow = false;
    plane.center = triple(vector(obstacle.center) + outward * S(distance));
    plane.axis = triple(-outward);
    plans_.push_back({plane, obstacle.center, 0, {}});
  };
  if (obstacle.shape == ObstacleShape::cylinder) {
    // A capsule whose round ends lie beyond the flat ones.
    Obstacle side = obstacle;
    side.shape = ObstacleShape::capsule;
    side.half_length += obstacle.radius;
    plans_.push_back({side, obstacle.center, 0, {}});
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
  for (std::size_t w = 0; w < plans_.size(); ++w) {
    const Plan& plan = plans_[w];
    const models::ObstacleMotion& motion = plan.shape.motion;
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
    const Vec arm = rotate(turn, vector(plan.shape.center) - vector(plan.pivot));
    const Vec shift = vector(motion.velocity) * t + vector(motion.amplitude) * sin(phase);
    const Vec swing =
        vector(motion.amplitude) * (S(2 * kernels::pi * motion.frequency) * cos(phase));
    wall.shape.center = triple(vector(plan.pivot) + shift + arm);
    wall.center_rest = float_rest(wall.shape.center);
    wall.shape.axis = triple(rotate(turn, vector(plan.shape.axis)));
    const Quat whole = turn * quaternion(plan.shape.rotation);
    wall.shape.rotation = {whole.w.value(), whole.x.value(), whole.y.value(), whole.z.value()};
    wall.velocity = triple(vector(motion.velocity) + swing + cross(spin, arm));
    wall.angular_velocity = motion.angular_velocity;
  }
}

void Walls::near(const Bounds& bounds, double margin, std::vector<std::uint32_t>& found) const {
  for (std::size_t w = 0; w < now_.size(); ++w) {
    const Obstacle& shape = now_[w].shape;
    if (shape.shape == ObstacleShape::mesh) {
      const Vec p = vector(bounds.center()) - vector(shape.center);
      const std::size_t before = found.size();
      plans_[w].grid.find(triple(rotate(conjugate(quaternion(shape.rotation)), p)),
                          bounds.radius() + margin, found);
      for (std::size_t i = before; i < found.size(); ++i) found[i] += plans_[w].first_part;
    } else if (plans_[w].everywhere || comes_near(shape, bounds, margin)) {
      found.push_back(plans_[w].first_part);
    }
  }
}

bool Walls::comes_near(const Obstacle& shape, const Bounds& bounds, double margin) const {
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

FeatureGrid::FeatureGrid(const models::MeshFeatures& mesh) : mesh_(&mesh) {
  Triple highest = mesh.bounds.front().highest;
  origin_ = mesh.bounds.front().lowest;
  for (const models::MeshBounds& bounds : mesh.bounds) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      origin_[axis] = std::min(origin_[axis], bounds.lowest[axis]);
      highest[axis] = std::max(highest[axis], bounds.highest[axis]);
    }
  }
  double longest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    longest = std::max(longest, highest[axis] - origin_[axis]);
  }
  // Fine cells hold few that are far, but a large triangle is in many of them.
  constexpr double finest = 64;  // along the longest edge of the box about the mesh
  constexpr std::size_t cells_of_a_feature = 8;
  for (double along = finest; along >= 1; along /= 2) {
    inverse_cell_ = along / longest;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      counts_[axis] = 1 + static_cast<std::size_t>((highest[axis] - origin_[axis]) * inverse_cell_);
    }
    std::size_t entries = 0;
    for (const models::MeshBounds& bounds : mesh.bounds) {
      const auto low = cells_of(bounds.lowest);
      const auto high = cells_of(bounds.highest);
      entries += (high[0] - low[0] + 1) * (high[1] - low[1] + 1) * (high[2] - low[2] + 1);
    }
    if (entries <= cells_of_a_feature * mesh.bounds.size()) break;
  }
  const auto for_each_cell = [&](const models::MeshBounds& bounds, const auto& visit) {
    const auto low = cells_of(bounds.lowest);
    const auto high = cells_of(bounds.highest);
    for (std::size_t k = low[2]; k <= high[2]; ++k) {
      for (std::size_t j = low[1]; j <= high[1]; ++j) {
        for (std::size_t i = low[0]; i <= high[0]; ++i) {
          visit((k * counts_[1] + j) * counts_[0] + i);
        }
      }
    }
  };
  first_.assign(counts_[0] * counts_[1] * counts_[2] + 1, 0);
  for (const models::MeshBounds& bounds : mesh.bounds) {
    for_each_cell(bounds, [&](std::size_t cell) { ++first_[cell + 1]; });
  }
  for (std::size_t cell = 1; cell < first_.size(); ++cell) first_[cell] += first_[cell - 1];
  feature_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t f = 0; f < mesh.bounds.size(); ++f) {
    for_each_cell(mesh.bounds[f], [&](std::size_t cell) { feature_[next[cell]++] = f; });
  }
}

std::array<std::size_t, 3> FeatureGrid::cells_of(const Triple& at) const {
  std::array<std::size_t, 3> cells;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double number = (at[axis] - origin_[axis]) * inverse_cell_;
    cells[axis] =
        static_cast<std::size_t>(std::clamp(number, 0.0, static_cast<double>(counts_[axis] - 1)));
  }
  return cells;
}

void FeatureGrid::find(const Triple& center, double reach,
                       std::vector<std::uint32_t>& found) const {
  // Bounds, the frame's rotation and the point are rounded.
  const double grown = reach * (1 + 1e-8) +
                       1e-12 * (std::abs(center[0]) + std::abs(center[1]) + std::abs(center[2]));
  Triple lowest = center;
  Triple highest = center;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    lowest[axis] -= grown;
    highest[axis] += grown;
  }
  const std::size_t before = found.size();
  const auto low = cells_of(lowest);
  const auto high = cells_of(highest);
  for (std::size_t k = low[2]; k <= high[2]; ++k) {
    for (std::size_t j = low[1]; j <= high[1]; ++j) {
      for (std::size_t i = low[0]; i <= high[0]; ++i) {
        const std::size_t cell = (k * counts_[1] + j) * counts_[0] + i;
        for (std::size_t n = first_[cell]; n < first_[cell + 1]; ++n) {
          const models::MeshBounds& bounds = mesh_->bounds[feature_[n]];
          bool apart = false;
          for (std::size_t axis = 0; axis < 3; ++axis) {
            apart =
                apart || bounds.lowest[axis] > highest[axis] || bounds.highest[axis] < lowest[axis];
          }
          if (apart) continue;
          // A feature is in every cell that its box meets: it counts in the first one seen here.
          const auto own = cells_of(bounds.lowest);
          if (i == std::max(low[0], own[0]) && j == std::max(low[1], own[1]) &&
              k == std::max(low[2], own[2])) {
            found.push_back(feature_[n]);
          }
        }
      }
    }
  }
  const auto start = found.begin() + static_cast<std::ptrdiff_t>(before);
  std::sort(start, found.end());  // exact-set: whole numbers
}

}  // namespace salvo::solver
