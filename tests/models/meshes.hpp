// Meshes that the tests of triangle meshes share.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "models/triangle_mesh.hpp"

namespace salvo::tests {

using models::Triple;

class MeshDraws {
 public:
  explicit MeshDraws(std::uint64_t seed) : engine_(seed) {}
  double within(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  Triple point(double size) {
    const double x = within(-size, size);
    const double y = within(-size, size);
    const double z = within(-size, size);
    return {x, y, z};
  }
  std::size_t below(std::size_t count) { return engine_() % count; }

 private:
  std::mt19937_64 engine_;
};

/// Two triangles for each cell of a grid of (columns + 1)(rows + 1) points; the diagonals
/// alternate.
template <class Point>
models::TriangleMesh grid_mesh(std::uint32_t columns, std::uint32_t rows, Point point) {
  models::TriangleMesh mesh;
  for (std::uint32_t j = 0; j <= rows; ++j) {
    for (std::uint32_t i = 0; i <= columns; ++i) mesh.vertices.push_back(point(i, j));
  }
  for (std::uint32_t j = 0; j < rows; ++j) {
    for (std::uint32_t i = 0; i < columns; ++i) {
      const std::uint32_t a = j * (columns + 1) + i;
      const std::uint32_t b = a + 1;
      const std::uint32_t c = b + columns + 1;
      const std::uint32_t d = c - 1;
      if ((i + j) % 2 == 0) {
        mesh.triangles.insert(mesh.triangles.end(), {{a, b, c}, {a, c, d}});
      } else {
        mesh.triangles.insert(mesh.triangles.end(), {{a, b, d}, {b, c, d}});
      }
    }
  }
  return mesh;
}

/// The box |x| <= 1, |y| <= 1, |z| <= 1, n by n cells a face; vertices are repeated where faces
/// meet.
inline models::TriangleMesh box_mesh(std::uint32_t n) {
  models::TriangleMesh box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const models::TriangleMesh face = grid_mesh(n, n, [&](std::uint32_t i, std::uint32_t j) {
        Triple p{};
        p[axis] = side;
        p[(axis + 1) % 3] = side * (2.0 * i - n) / n;
        p[(axis + 2) % 3] = (2.0 * j - n) / n;
        return p;
      });
      const auto shift = static_cast<std::uint32_t>(box.vertices.size());
      box.vertices.insert(box.vertices.end(), face.vertices.begin(), face.vertices.end());
      for (const auto& t : face.triangles) {
        box.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
      }
    }
  }
  return box;
}

/// An icosahedron on the unit sphere, each triangle split into four so many times.
inline models::TriangleMesh icosphere_mesh(int splits) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  models::TriangleMesh mesh;
  const auto add = [&](Triple p) {
    const double length = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    mesh.vertices.push_back({p[0] / length, p[1] / length, p[2] / length});
    return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  };
  for (const Triple& p : std::vector<Triple>{{-1, g, 0},
                                             {1, g, 0},
                                             {-1, -g, 0},
                                             {1, -g, 0},
                                             {0, -1, g},
                                             {0, 1, g},
                                             {0, -1, -g},
                                             {0, 1, -g},
                                             {g, 0, -1},
                                             {g, 0, 1},
                                             {-g, 0, -1},
                                             {-g, 0, 1}}) {
    add(p);
  }
  mesh.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                    {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                    {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                    {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int split = 0; split < splits; ++split) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [place, is_new] = middles.try_emplace(std::minmax(a, b), 0);
      if (is_new) {
        const Triple p = mesh.vertices[a];
        const Triple q = mesh.vertices[b];
        place->second = add({p[0] + q[0], p[1] + q[1], p[2] + q[2]});
      }
      return place->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::uint32_t ab = middle(a, b);
      const std::uint32_t bc = middle(b, c);
      const std::uint32_t ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = finer;
  }
  return mesh;
}

/// Two walls that rise by 45 degrees from the line along z through the origin, 1 m wide each.
inline models::TriangleMesh groove_mesh() {
  return grid_mesh(4, 2, [](std::uint32_t i, std::uint32_t j) {
    const double x = 0.5 * i - 1;
    return Triple{x, std::abs(x), 1 - double(j)};
  });
}

/// y = x^2/2 - z^2/2 over a square, an open surface that bends both ways.
inline models::TriangleMesh saddle_mesh() {
  return grid_mesh(7, 6, [](std::uint32_t i, std::uint32_t j) {
    const double x = 2.0 * i / 7 - 1;
    const double z = 1 - 2.0 * j / 6;
    return Triple{x, (x * x - z * z) / 2, z};
  });
}

/// A ribbon, one cell wide, with steps.
inline models::TriangleMesh strip_mesh() {
  return grid_mesh(9, 1, [](std::uint32_t i, std::uint32_t j) {
    return Triple{0.2 * i - 1, i % 3 == 1 ? 0.3 : 0.0, 0.4 * j + (i % 2 ? 0.1 : 0.0)};
  });
}

/// Vertices of a sphere moved at random: a closed surface, nowhere flat, neither convex nor
/// concave.
inline models::TriangleMesh crumpled_mesh() {
  models::TriangleMesh mesh = icosphere_mesh(2);
  MeshDraws draws(5);
  for (Triple& p : mesh.vertices) {
    const double scale = draws.within(0.8, 1.2);
    for (double& x : p) x *= scale;
  }
  return mesh;
}

/// Columns by rows points in one plane, at no two angles the same, turned out of all axes.
inline models::TriangleMesh tilted_plane_mesh(std::uint32_t columns, std::uint32_t rows) {
  MeshDraws draws(11);
  return grid_mesh(columns, rows, [&](std::uint32_t i, std::uint32_t j) {
    const double u = (i + draws.within(-0.2, 0.2)) / columns - 0.5;
    const double v = (j + draws.within(-0.2, 0.2)) / rows - 0.5;
    // Orthonormal: (2, 2, 1)/3, (1, -2, 2)/3.
    return Triple{(2 * u + v) / 3, (2 * u - 2 * v) / 3, (u + 2 * v) / 3};
  });
}

}  // namespace salvo::tests
