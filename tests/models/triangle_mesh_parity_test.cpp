// Features of meshes give the scalar lane's bits on every instruction set: points anywhere, on the
// borders between features, and on the surface.
#include "tests/models/triangle_mesh_parity.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "tests/models/meshes.hpp"
#include "tests/per_isa.hpp"

namespace salvo::tests {

namespace triangle_mesh_parity {
SALVO_TEST_TABLES
}

namespace {

using triangle_mesh_parity::Look;

constexpr std::size_t rows = 1024;

template <class T>
struct alignas(64) Column {
  T value[rows];
};

// Vertices, points of a coarse lattice, points of edges, and points anywhere.
template <class T>
std::vector<Column<T>> points_about(const models::TriangleMesh& mesh) {
  std::vector<Column<T>> columns(3);
  MeshDraws draws(9);
  for (std::size_t i = 0; i < rows; ++i) {
    const auto& t = mesh.triangles[draws.below(mesh.triangles.size())];
    const Triple& a = mesh.vertices[t[0]];
    const Triple& b = mesh.vertices[t[1]];
    const double share = i % 4 == 1 ? 0 : draws.within(0, 1);
    const Triple anywhere = draws.point(1.5);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double x = a[axis] + share * (b[axis] - a[axis]);
      if (i % 4 == 2) x = 0.25 * static_cast<double>(draws.below(13)) - 1.5;
      if (i % 4 == 3) x = anywhere[axis];
      columns[axis].value[i] = static_cast<T>(x);
    }
  }
  return columns;
}

template <class T>
std::vector<Column<T>> seen(solver::Isa isa, const models::MeshFeatures& mesh, std::size_t feature,
                            const std::vector<Column<T>>& points) {
  std::vector<Column<T>> results(5);
  Look<T> look;
  look.mesh = &mesh;
  look.feature = feature;
  look.rows = rows;
  for (std::size_t i = 0; i < 3; ++i) look.point[i] = points[i].value;
  for (std::size_t i = 0; i < 5; ++i) look.result[i] = results[i].value;
  const triangle_mesh_parity::Table& table = triangle_mesh_parity::table_of(isa);
  if constexpr (sizeof(T) == sizeof(float)) {
    table.single(look);
  } else {
    table.twice(look);
  }
  return results;
}

template <class T>
class TriangleMeshParity : public ::testing::Test {};
using Reals = ::testing::Types<float, double>;
TYPED_TEST_SUITE(TriangleMeshParity, Reals);

TYPED_TEST(TriangleMeshParity, EveryFeature) {
  static const char* const names[] = {"distance", "normal x", "normal y", "normal z", "owns"};
  for (const models::TriangleMesh& mesh :
       {box_mesh(2), groove_mesh(), crumpled_mesh(), tilted_plane_mesh(3, 3), strip_mesh()}) {
    const models::MeshFeatures features = models::make_features(mesh);
    const auto points = points_about<TypeParam>(mesh);
    double owned = 0;
    for (std::size_t feature = 0; feature < features.size(); ++feature) {
      const auto expected = seen(solver::Isa::scalar, features, feature, points);
      for (const TypeParam owns : expected[4].value) owned += static_cast<double>(owns);
      for (const solver::Isa isa : solver::available_isas()) {
        const auto got = seen(isa, features, feature, points);
        for (std::size_t c = 0; c < 5; ++c) {
          for (std::size_t i = 0; i < rows; ++i) {
            ASSERT_EQ(std::memcmp(&got[c].value[i], &expected[c].value[i], sizeof(TypeParam)), 0)
                << name(isa) << ", feature " << feature << ", row " << i << ", " << names[c] << ": "
                << got[c].value[i] << " instead of " << expected[c].value[i];
          }
        }
      }
    }
    EXPECT_GE(owned, rows);
  }
}

}  // namespace
}  // namespace salvo::tests
