// What particles bounce off, as plain numbers: SI units, double precision.
//
// Obstacles are fixed. They are met in the order of their list: of two impacts at the same instant
// the lower index comes first, and the book's responses test one obstacle after the other.
// [Bourg & Bywalec 5.2-5.4, 8.4]
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "kernels/lane.hpp"
#include "models/force_settings.hpp"

namespace salvo::models {

enum class ObstacleShape { plane, sphere, box, capsule, cylinder, height_field, mesh };

struct MeshFeatures;

/// Heights over a regular grid in x and z: sample (i, j) stands at (x + i spacing, z + j spacing)
/// and is `heights[j * columns + i]`, in m along +y. Each cell is two triangles that share the
/// diagonal from (i, j) to (i + 1, j + 1). Below the surface is ground; outside the rectangle there
/// is nothing.
struct HeightSamples {
  std::size_t columns = 0;  // along x, at least 2
  std::size_t rows = 0;     // along z, at least 2
  double spacing = 1;       // m
  std::vector<double> heights;
  std::vector<float> heights_float;  // the same, rounded once
  double highest = 0;                // m
};

inline std::shared_ptr<const HeightSamples> make_height_samples(std::size_t columns,
                                                                std::size_t rows, double spacing,
                                                                std::vector<double> heights) {
  auto samples = std::make_shared<HeightSamples>();
  samples->columns = columns;
  samples->rows = rows;
  samples->spacing = spacing;
  samples->heights = std::move(heights);
  samples->highest = samples->heights.at(0);
  for (const double height : samples->heights) {
    samples->heights_float.push_back(static_cast<float>(height));
    if (height > samples->highest) samples->highest = height;
  }
  return samples;
}

/// A given motion: at time t the obstacle has moved by velocity t + amplitude sin(2 pi frequency t)
/// and turned by angular_velocity t about its center.
struct ObstacleMotion {
  Triple velocity{};          // m/s
  Triple amplitude{};         // m
  double frequency = 0;       // 1/s
  Triple angular_velocity{};  // rad/s

  friend bool operator==(const ObstacleMotion&, const ObstacleMotion&) = default;
};

struct Obstacle {
  ObstacleShape shape = ObstacleShape::plane;
  /// A point of the plane; the middle of a sphere, box, capsule or cylinder; the corner of least x
  /// and z of a height field, whose samples are heights above center[1]. m
  Triple center{0, 0, 0};
  /// Unit vector: the outward normal of a plane, the axis of a capsule or a cylinder.
  Triple axis{0, 1, 0};
  double radius = 1;          // sphere, capsule, cylinder; m
  double half_length = 1;     // of a capsule's segment, of a cylinder; m
  Triple half_size{1, 1, 1};  // of a box along its own axes; m
  /// Unit quaternion w, x, y, z that turns the axes of a box or a mesh into those of the scene.
  std::array<double, 4> rotation{1, 0, 0, 0};
  std::shared_ptr<const HeightSamples> samples;  // height field
  std::shared_ptr<const MeshFeatures> mesh;      // about its center; only of particles that touch
  double restitution = 0.5;
  double friction = 0;  // Coulomb coefficient
  /// Takes part in the impulse only: the obstacle stays where it is. The book's 100 kg obstacles
  /// thus have the effective restitution (1 + e) M/(M + m) - 1. kg
  double mass = std::numeric_limits<double>::infinity();
  /// Particles are inside a sphere, box, capsule or cylinder. Only for particles that touch.
  bool hollow = false;
  ObstacleMotion motion;  // likewise
};

/// How a particle that meets an obstacle is turned back.
enum class ContactResponse {
  swept,    // the chord of the step is tested, the remaining time continued; nothing tunnels
  impulse,  // discrete: the velocity of a penetrating particle is changed before the step   [5.2]
  force,    // discrete: the impact force is the only force of a whole step   [8.4]
};

struct ContactSettings {
  ContactResponse response = ContactResponse::swept;
  /// Impacts a step after which the next one rests the particle on the surface; swept response.
  int max_impacts = 4;
  /// Force response, planes: move the particle back along its path to the contact height, as the
  /// book's text wants; its listing resets the height alone.
  bool interpolate_at_plane = true;
};

// Tagged with the instruction set, like everything that a kernel calls.
inline namespace SALVO_ISA {

/// The obstacle with its axis and rotation brought to unit length, as contact needs them.
inline Obstacle normalized(Obstacle obstacle) {
  const auto scale = [](double squares) {
    return 1 / sqrt(kernels::ScalarLane<double>(squares)).value();
  };
  const Triple& a = obstacle.axis;
  const double shorten = scale(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
  for (double& component : obstacle.axis) component *= shorten;
  const std::array<double, 4>& q = obstacle.rotation;
  const double turn = scale(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double& component : obstacle.rotation) component *= turn;
  return obstacle;
}

inline bool is_normalized(const Obstacle& obstacle) {
  const auto is_one = [](double squares) { return squares > 1 - 1e-9 && squares < 1 + 1e-9; };
  const Triple& a = obstacle.axis;
  const std::array<double, 4>& q = obstacle.rotation;
  return is_one(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]) &&
         is_one(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
}

}  // namespace SALVO_ISA

}  // namespace salvo::models
