// Obstacles as particles that touch meet them: where they stand at a time, in smooth parts each of
// which a sphere touches at one point. A hollow box is six planes, a hollow cylinder its side and
// two planes.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "solver/contact_pass.hpp"

namespace salvo::solver {

/// The box about a group of spheres.
class Bounds {
 public:
  void add(const std::array<double, 3>& center, double radius) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lowest_[axis] = center[axis] - radius < lowest_[axis] ? center[axis] - radius : lowest_[axis];
      highest_[axis] =
          center[axis] + radius > highest_[axis] ? center[axis] + radius : highest_[axis];
    }
  }
  bool empty() const { return lowest_[0] > highest_[0]; }
  models::Triple center() const;
  /// Of the sphere about it, m.
  double radius() const;

 private:
  static constexpr double most = std::numeric_limits<double>::max();
  std::array<double, 3> lowest_{most, most, most};
  std::array<double, 3> highest_{-most, -most, -most};
};

class Walls {
 public:
  explicit Walls(std::span<const models::Obstacle> obstacles);

  /// Moves them to where they are at a time, s.
  void place(double time);
  std::span<const Wall> now() const { return now_; }
  /// An upper bound of their speed where they meet particles, m/s; zero when all stand.
  double fastest() const { return fastest_; }
  /// Whether wall w comes within `margin` of the bounds; true when in doubt.
  bool may_reach(std::size_t w, const Bounds& bounds, double margin) const;

 private:
  struct Part {
    models::Obstacle shape;  // at time 0
    models::Triple pivot;    // the obstacle's center then
  };
  void add(const models::Obstacle& obstacle);

  std::vector<Part> parts_;
  std::vector<Wall> now_;
  double fastest_ = 0;
};

}  // namespace salvo::solver
