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

/// Where the features of a mesh are: in the cells of a grid over it.
class FeatureGrid {
 public:
  FeatureGrid() = default;
  explicit FeatureGrid(const models::MeshFeatures& mesh);

  /// Adds the features whose boxes come within the box of half edge `reach` about `center`, in the
  /// mesh's own frame, ascending.
  void find(const models::Triple& center, double reach, std::vector<std::uint32_t>& found) const;

 private:
  std::array<std::size_t, 3> cells_of(const models::Triple& at) const;

  const models::MeshFeatures* mesh_ = nullptr;
  models::Triple origin_{};
  double inverse_cell_ = 0;
  std::array<std::size_t, 3> counts_{};
  std::vector<std::uint32_t> first_;    // of each cell, and their number
  std::vector<std::uint32_t> feature_;  // cell after cell
};

/// An upper bound of the speed with which an obstacle comes towards a particle, m/s; infinite where
/// it turns and has no end.
double fastest(const models::Obstacle& obstacle);

class Walls {
 public:
  explicit Walls(std::span<const models::Obstacle> obstacles);

  /// Moves them to where they are at a time, s.
  void place(double time);
  std::span<const Wall> now() const { return now_; }
  std::span<const WallPart> parts() const { return parts_; }
  /// Which of the scene's obstacles a part belongs to.
  std::size_t obstacle(std::uint32_t part) const { return plans_[parts_[part].wall].obstacle; }
  /// An upper bound of their speed, m/s; zero when all stand. Those without one are always near.
  double fastest() const { return fastest_; }
  /// Adds the parts that come within `margin` of the bounds, ascending; too many when in doubt.
  void near(const Bounds& bounds, double margin, std::vector<std::uint32_t>& found) const;

 private:
  struct Plan {
    models::Obstacle shape;  // at time 0
    models::Triple pivot;    // the obstacle's center then
    std::uint32_t first_part = 0;
    FeatureGrid grid;  // of a mesh
    std::size_t obstacle = 0;
    bool everywhere = false;  // it turns and has no end
  };
  void add(const models::Obstacle& obstacle);
  bool comes_near(const models::Obstacle& shape, const Bounds& bounds, double margin) const;

  std::vector<Plan> plans_;
  std::vector<Wall> now_;
  std::vector<WallPart> parts_;
  double fastest_ = 0;
};

}  // namespace salvo::solver
