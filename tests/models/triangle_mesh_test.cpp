// Features of triangle meshes: against the nearest point of every triangle, on the borders between
// them, and what is said about meshes that have none.
#include "models/triangle_mesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "tests/models/meshes.hpp"

namespace salvo::tests {
namespace {

using models::make_features;
using models::MeshFeatures;
using models::mistakes_in;
using models::TriangleMesh;

struct Named {
  const char* name;
  TriangleMesh mesh;
};

std::vector<Named> meshes() {
  return {{"icosphere", icosphere_mesh(2)}, {"box", box_mesh(1)},
          {"box of cells", box_mesh(3)},    {"groove", groove_mesh()},
          {"saddle", saddle_mesh()},        {"strip", strip_mesh()},
          {"crumpled", crumpled_mesh()},    {"tilted plane", tilted_plane_mesh(4, 5)}};
}

Triple plus(const Triple& a, double s, const Triple& b) {
  return {a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]};
}
double inner(const Triple& a, const Triple& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double distance(const Triple& a, const Triple& b) {
  const Triple d = plus(a, -1, b);
  return std::sqrt(inner(d, d));
}

// The point of a triangle that is nearest to p, region by region.   [Ericson, Real-Time Collision
// Detection, 5.1.5]
Triple nearest_of_triangle(const Triple& p, const Triple& a, const Triple& b, const Triple& c) {
  const Triple ab = plus(b, -1, a);
  const Triple ac = plus(c, -1, a);
  const Triple ap = plus(p, -1, a);
  const double d1 = inner(ab, ap);
  const double d2 = inner(ac, ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Triple bp = plus(p, -1, b);
  const double d3 = inner(ab, bp);
  const double d4 = inner(ac, bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return plus(a, d1 / (d1 - d3), ab);
  const Triple cp = plus(p, -1, c);
  const double d5 = inner(ab, cp);
  const double d6 = inner(ac, cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return plus(a, d2 / (d2 - d6), ac);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    return plus(b, (d4 - d3) / ((d4 - d3) + (d5 - d6)), plus(c, -1, b));
  }
  const double sum = va + vb + vc;
  return plus(plus(a, vb / sum, ab), vc / sum, ac);
}

double nearest_distance(const TriangleMesh& mesh, const Triple& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& t : mesh.triangles) {
    const Triple& a = mesh.vertices[t[0]];
    const Triple& b = mesh.vertices[t[1]];
    const Triple& c = mesh.vertices[t[2]];
    least = std::min(least, distance(p, nearest_of_triangle(p, a, b, c)));
  }
  return least;
}

struct Answer {
  std::size_t feature;
  double distance;
  Triple normal;
};

// The features that own p, as one lane of T sees them.
template <class T = double>
std::vector<Answer> owners(const MeshFeatures& features, const Triple& p) {
  using V = kernels::ScalarLane<T>;
  std::vector<Answer> answers;
  for (std::size_t i = 0; i < features.size(); ++i) {
    const auto at = feature_surface<V>(features, i, models::broadcast<V>(p));
    EXPECT_TRUE(std::isfinite(at.distance.value()) && all(is_finite(at.normal)));
    if (!at.owns.value()) continue;
    answers.push_back({i,
                       double(at.distance.value()),
                       {at.normal.x.value(), at.normal.y.value(), at.normal.z.value()}});
  }
  return answers;
}

// Those before which p lies: a face has two sides, and the far wall of a solid sees p through it.
template <class T = double>
std::vector<Answer> owners_in_front(const MeshFeatures& features, const Triple& p) {
  std::vector<Answer> answers = owners<T>(features, p);
  std::erase_if(answers, [&](const Answer& answer) {
    return answer.feature < features.faces.size() &&
           inner(answer.normal, features.faces[answer.feature].normal) < 0;
  });
  return answers;
}

Triple normal_of(const TriangleMesh& mesh, std::size_t triangle) {
  const auto& t = mesh.triangles[triangle];
  const Triple u = plus(mesh.vertices[t[1]], -1, mesh.vertices[t[0]]);
  const Triple v = plus(mesh.vertices[t[2]], -1, mesh.vertices[t[0]]);
  const Triple n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  return plus({0, 0, 0}, 1 / std::sqrt(inner(n, n)), n);
}

// ---- nearest ------------------------------------------------------------------------------------

TEST(TriangleMesh, NearestOwnerIsTheNearestOfAllTriangles) {
  for (const auto& [name, mesh] : meshes()) {
    const MeshFeatures features = make_features(mesh);
    MeshDraws draws(1);
    for (int k = 0; k < 2000; ++k) {
      const Triple p = draws.point(2);
      const std::vector<Answer> answers = owners(features, p);
      ASSERT_FALSE(answers.empty()) << name << ", point " << k;
      double least = answers[0].distance;
      for (const Answer& answer : answers) {
        least = std::min(least, answer.distance);
        // Each of them, not only the nearest: its foot is on the surface and within its bounds.
        const Triple foot = plus(p, -answer.distance, answer.normal);
        ASSERT_NEAR(inner(answer.normal, answer.normal), 1, 1e-14) << name << ", point " << k;
        ASSERT_NEAR(nearest_distance(mesh, foot), 0, 1e-12) << name << ", point " << k;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          ASSERT_GE(foot[axis], features.bounds[answer.feature].lowest[axis] - 1e-12);
          ASSERT_LE(foot[axis], features.bounds[answer.feature].highest[axis] + 1e-12);
        }
      }
      ASSERT_NEAR(least, nearest_distance(mesh, p), 1e-12) << name << ", point " << k;
    }
  }
}

TEST(TriangleMesh, FromOutsideAConvexSolidHasOneNearestFeature) {
  for (const TriangleMesh& mesh :
       {icosphere_mesh(1), icosphere_mesh(2), box_mesh(1), box_mesh(3)}) {
    const MeshFeatures features = make_features(mesh);
    MeshDraws draws(2);
    int outside = 0;
    for (int k = 0; k < 5000; ++k) {
      const Triple p = draws.point(1.6);
      double highest = -1;
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Triple& a = mesh.vertices[mesh.triangles[t][0]];
        highest = std::max(highest, inner(plus(p, -1, a), normal_of(mesh, t)));
      }
      if (highest <= 0) continue;
      ++outside;
      ASSERT_EQ(owners_in_front(features, p).size(), 1u) << "point " << k;
    }
    EXPECT_GT(outside, 2000);
  }
}

TEST(TriangleMesh, HasTwoSides) {
  const TriangleMesh mesh = tilted_plane_mesh(1, 1);
  const MeshFeatures features = make_features(mesh);
  const Triple normal = normal_of(mesh, 0);
  const Triple& a = mesh.vertices[mesh.triangles[0][0]];
  const Triple& b = mesh.vertices[mesh.triangles[0][1]];
  const Triple& c = mesh.vertices[mesh.triangles[0][2]];
  const Triple middle = plus(plus(a, 0.25, plus(b, -1, a)), 0.25, plus(c, -1, a));
  for (const double side : {-1.0, 1.0}) {
    const std::vector<Answer> answers = owners(features, plus(middle, side * 0.125, normal));
    ASSERT_EQ(answers.size(), 1u);
    EXPECT_EQ(answers[0].feature, 0u);
    EXPECT_NEAR(answers[0].distance, 0.125, 1e-15);
    EXPECT_NEAR(side * inner(answers[0].normal, normal), 1, 1e-15);
  }
}

TEST(TriangleMesh, GrooveIsMetTwiceAndItsBackOnce) {
  const MeshFeatures features = make_features(groove_mesh());
  const double root = std::sqrt(0.5);
  MeshDraws draws(3);
  for (int k = 0; k < 1000; ++k) {
    const double height = draws.within(0.05, 0.9);
    const double along = draws.within(-0.9, 0.9);
    const double across = draws.within(-0.5, 0.5) * height;
    const std::vector<Answer> inside = owners(features, {across, height, along});
    ASSERT_EQ(inside.size(), 2u);
    double nearer = std::min(inside[0].distance, inside[1].distance);
    EXPECT_NEAR(nearer, root * (height - std::abs(across)), 1e-15);
    EXPECT_NEAR(inside[0].distance + inside[1].distance, 2 * root * height, 1e-14);
    EXPECT_NEAR(inner(inside[0].normal, inside[1].normal), 0, 1e-15);
    EXPECT_NEAR(inside[0].normal[1], root, 1e-15);

    const std::vector<Answer> below = owners(features, {across, -height, along});
    ASSERT_EQ(below.size(), 1u);
    EXPECT_NEAR(below[0].distance, std::hypot(across, height), 1e-15);
  }
}

// ---- borders ------------------------------------------------------------------------------------

// Points of a plane above the edges and the inner vertices of its triangles, as exact as they can
// be computed, and beside them by the least that can be told apart.
template <class T>
void expect_one_owner_above_every_seam(const TriangleMesh& mesh) {
  const MeshFeatures features = make_features(mesh);
  const Triple normal = normal_of(mesh, 0);
  MeshDraws draws(4);
  int points = 0;
  const auto is_on_rim = [&](const Triple& p) {
    return std::ranges::find(features.corners, p, &models::MeshCorner::position) !=
           features.corners.end();
  };
  const auto expect_one = [&](Triple p, const char* where) {
    for (int nudge = 0; nudge < 3; ++nudge) {
      ASSERT_EQ(owners<T>(features, p).size(), 1u) << where << ", point " << points;
      ++points;
      for (double& x : p) {
        const T coordinate = static_cast<T>(x);
        x = std::nextafter(coordinate, draws.below(2) ? T(9) : T(-9));
      }
    }
  };
  const auto height = [&](int k) { return k % 8 == 0 ? 0 : draws.within(-1, 1); };
  for (const auto& t : mesh.triangles) {
    for (std::size_t side = 0; side < 3; ++side) {
      const Triple& a = mesh.vertices[t[side]];
      const Triple& b = mesh.vertices[t[(side + 1) % 3]];
      for (int k = 0; k < 16; ++k) {
        const Triple on_edge = plus(a, draws.within(0, 1), plus(b, -1, a));
        expect_one(plus(on_edge, height(k), normal), "above an edge");
        if (!is_on_rim(a)) expect_one(plus(a, height(k), normal), "above a vertex");
      }
    }
  }
  EXPECT_GT(points, 5000);
}

template <class T>
class MeshBorders : public ::testing::Test {};
using Reals = ::testing::Types<float, double>;
TYPED_TEST_SUITE(MeshBorders, Reals);

TYPED_TEST(MeshBorders, OfOnePlaneLeaveNoGapAndNoOverlap) {
  expect_one_owner_above_every_seam<TypeParam>(tilted_plane_mesh(6, 7));
}

TYPED_TEST(MeshBorders, OfOneLevelPlaneLeaveNoGapAndNoOverlap) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    expect_one_owner_above_every_seam<TypeParam>(
        grid_mesh(4, 5, [&](std::uint32_t i, std::uint32_t j) {
          Triple p{};
          p[axis] = 0.25;
          p[(axis + 1) % 3] = 0.25 * i - 0.5;
          p[(axis + 2) % 3] = 0.125 * j;
          return p;
        }));
  }
}

// A fan of very unequal triangles, in the order of no walk around the vertex in its middle.
TYPED_TEST(MeshBorders, AroundOneVertexLeaveNoGapAndNoOverlap) {
  TriangleMesh mesh;
  mesh.vertices.push_back({0.1, 0.2, 0.3});
  const double angles[] = {0, 0.01, 1.5, 3, 3.15, 4, 4.001, 5.5};
  for (const double angle : angles) {
    const double u = std::cos(angle);
    const double v = std::sin(angle);
    mesh.vertices.push_back(
        {0.1 + (2 * u + v) / 3, 0.2 + (2 * u - 2 * v) / 3, 0.3 + (u + 2 * v) / 3});
  }
  for (const std::uint32_t i : {3u, 1u, 6u, 2u, 0u, 7u, 4u, 5u}) {
    mesh.triangles.push_back({0, i + 1, (i + 1) % 8 + 1});
  }
  ASSERT_TRUE(mistakes_in(mesh).empty());
  const MeshFeatures features = make_features(mesh);
  EXPECT_EQ(features.patches.size(), 1u);
  const Triple normal = normal_of(mesh, 0);
  MeshDraws draws(6);
  for (int k = 0; k < 20000; ++k) {
    const Triple p = plus(mesh.vertices[0], draws.within(-1, 1), normal);
    ASSERT_EQ(owners<TypeParam>(features, p).size(), 1u) << "point " << k;
  }
}

// All points of a lattice, in which the planes, edges and vertices of the box lie.
TYPED_TEST(MeshBorders, OfABoxBelongToOneFeature) {
  for (const std::uint32_t cells : {1u, 2u, 4u}) {
    const MeshFeatures features = make_features(box_mesh(cells));
    for (int i = -6; i <= 6; ++i) {
      for (int j = -6; j <= 6; ++j) {
        for (int k = -6; k <= 6; ++k) {
          const Triple p{0.25 * i, 0.25 * j, 0.25 * k};
          const double out = std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])});
          if (out < 1) continue;
          double squares = 0;
          for (const double x : p) squares += std::pow(std::max(std::abs(x) - 1, 0.0), 2);
          const std::vector<Answer> answers = owners_in_front<TypeParam>(features, p);
          if (out > 1) {
            ASSERT_EQ(answers.size(), 1u) << cells << ": " << i << " " << j << " " << k;
            ASSERT_NEAR(answers[0].distance, std::sqrt(squares), 1e-6);
          } else {
            ASSERT_GE(owners<TypeParam>(features, p).size(), 1u)
                << cells << ": " << i << " " << j << " " << k;
          }
        }
      }
    }
  }
}

TEST(TriangleMesh, OnEdgesAndCornersThemselvesTheNormalIsBetweenTheFaces) {
  const MeshFeatures features = make_features(box_mesh(1));
  for (std::size_t i = features.faces.size(); i < features.size(); ++i) {
    const models::MeshBounds& bounds = features.bounds[i];
    const Triple middle = plus(plus({0, 0, 0}, 0.5, bounds.lowest), 0.5, bounds.highest);
    using V = kernels::ScalarLane<double>;
    const auto at = feature_surface<V>(features, i, models::broadcast<V>(middle));
    const Triple normal{at.normal.x.value(), at.normal.y.value(), at.normal.z.value()};
    EXPECT_EQ(at.distance.value(), 0);
    EXPECT_NEAR(inner(normal, normal), 1, 1e-15);
    EXPECT_GT(inner(normal, middle), 1);
  }
}

// ---- which features -----------------------------------------------------------------------------

TEST(TriangleMesh, HasNoFeaturesWithinAPlane) {
  const MeshFeatures box = make_features(box_mesh(3));
  EXPECT_EQ(box.patches.size(), 6u);
  EXPECT_EQ(box.faces.size(), 108u);
  EXPECT_EQ(box.edges.size(), 36u);
  EXPECT_EQ(box.corners.size(), 32u);
  EXPECT_EQ(box.bounds.size(), box.size());

  const MeshFeatures plane = make_features(tilted_plane_mesh(6, 7));
  EXPECT_EQ(plane.patches.size(), 1u);
  EXPECT_EQ(plane.edges.size(), 26u);
  EXPECT_EQ(plane.corners.size(), 26u);

  const MeshFeatures ball = make_features(icosphere_mesh(1));
  EXPECT_EQ(ball.patches.size(), 80u);
  EXPECT_EQ(ball.edges.size(), 120u);
  EXPECT_EQ(ball.corners.size(), 42u);
}

// Each of the facets is within the angle of the next, none within that of all.
TEST(TriangleMesh, PatchesDoNotFollowABend) {
  const TriangleMesh bent = grid_mesh(50, 1, [](std::uint32_t i, std::uint32_t j) {
    return Triple{double(i), 2e-5 * i * i, -double(j)};
  });
  const MeshFeatures features = make_features(bent);
  EXPECT_GT(features.patches.size(), 12u);
  EXPECT_LT(features.patches.size(), 50u);
  for (const models::MeshFace& face : features.faces) {
    const models::MeshPatch& patch = features.patches[face.patch];
    EXPECT_LT(std::abs(inner(face.normal, patch.across)), 1.1e-4);
    EXPECT_LT(std::abs(inner(face.normal, patch.along)), 1.1e-4);
  }
}

TEST(TriangleMesh, WithRepeatedVerticesHasTheSameFeatures) {
  const TriangleMesh mesh = saddle_mesh();
  TriangleMesh soup;
  for (const auto& t : mesh.triangles) {
    for (const std::uint32_t v : t) {
      Triple p = mesh.vertices[v];
      for (double& x : p) {
        if (x == 0 && soup.vertices.size() % 2) x = -0.0;
      }
      soup.vertices.push_back(p);
    }
    const auto last = static_cast<std::uint32_t>(soup.vertices.size());
    soup.triangles.push_back({last - 3, last - 2, last - 1});
  }
  ASSERT_TRUE(mistakes_in(soup).empty());
  const MeshFeatures one = make_features(mesh);
  const MeshFeatures other = make_features(soup);
  EXPECT_EQ(one.edges.size(), other.edges.size());
  EXPECT_EQ(one.corners.size(), other.corners.size());
  MeshDraws draws(7);
  for (int k = 0; k < 500; ++k) {
    const Triple p = draws.point(1);
    EXPECT_EQ(owners(one, p).size(), owners(other, p).size());
  }
}

// ---- mistakes -----------------------------------------------------------------------------------

std::string text_of(const TriangleMesh& mesh) {
  std::string text;
  for (const models::MeshMistake& mistake : mistakes_in(mesh)) {
    text += mistake.triangle ? "[" + std::to_string(*mistake.triangle) + "] " : "[] ";
    text += mistake.problem + "; " + mistake.hint + "\n";
  }
  return text;
}

const std::vector<Triple> square{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};

TEST(MeshMistakes, NoneInTheMeshesOfTheTests) {
  for (const auto& [name, mesh] : meshes()) EXPECT_EQ(text_of(mesh), "") << name;
}

TEST(MeshMistakes, NoTriangles) {
  EXPECT_EQ(text_of({}), "[] the mesh has no triangles; expected at least one\n");
}

TEST(MeshMistakes, NumbersThatAreNone) {
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(text_of({{{0, 0, 0}, {1, infinity, 0}, {1, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}}),
            "[] vertex 2 is at (1, inf, 0); expected finite coordinates of at most 1e+30\n"
            "[1] triangle 2 refers to vertex 4; there are 3\n");
}

TEST(MeshMistakes, NumbersThatCannotBeSquared) {
  EXPECT_EQ(text_of({{{0, 0, 0}, {1e200, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}}),
            "[] vertex 2 is at (1e+200, 0, 0); expected finite coordinates of at most 1e+30\n");
  EXPECT_EQ(text_of({{{0, 0, 0}, {1e-200, 0, 0}, {0, 1e-200, 0}}, {{0, 1, 2}}}),
            "[] the mesh reaches 1e-200; expected a coordinate of at least 1e-30\n");
  EXPECT_EQ(text_of({{{0, 0, 0}, {1e-31, 0, 0}, {0, 1e-31, 0}, {1, 0, 0}, {0, 0, 1}},
                     {{0, 1, 2}, {0, 3, 4}}}),
            "[0] triangle 1 at (0, 0, 0) is degenerate: its longest side is 1.41e-31; remove it\n");
  for (const double size : {1e-30, 1e30}) {
    EXPECT_EQ(text_of({{{0, 0, 0}, {size, 0, 0}, {0, size, 0}}, {{0, 1, 2}}}), "");
  }
}

TEST(MeshMistakes, DegenerateTriangles) {
  EXPECT_EQ(text_of({{{0, 0, 0}, {1, 0, 0}, {0.5, 1e-9, 0}, {0, 1, 0}, {0, 0, -0.0}},
                     {{0, 1, 3}, {0, 1, 2}, {0, 3, 4}, {1, 1, 2}}}),
            "[1] triangle 2 at (0, 0, 0) is degenerate: its height is 1e-09 of its longest side; "
            "remove it, or make it no thinner than 1e-06\n"
            "[2] triangle 3 has two corners at (0, 0, 0); remove it, or give it three corners\n"
            "[3] triangle 4 has two corners at (1, 0, 0); remove it, or give it three corners\n");
  EXPECT_EQ(text_of({{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}}),
            "[0] triangle 1 at (0, 0, 0) is degenerate: its height is 0 of its longest side; "
            "remove it, or make it no thinner than 1e-06\n");
  EXPECT_EQ(text_of({{{0, 0, 0}, {1, 0, 0}, {0.3, 2e-6, 0}}, {{0, 1, 2}}}), "");
}

TEST(MeshMistakes, DuplicateTriangles) {
  EXPECT_EQ(text_of({square, {{0, 1, 2}, {0, 2, 3}, {1, 2, 0}, {2, 1, 0}}}),
            "[2] triangle 3 has the corners of triangle 1; remove one of them: a surface has two "
            "sides\n"
            "[3] triangle 4 has the corners of triangle 3; remove one of them: a surface has two "
            "sides\n");
}

TEST(MeshMistakes, EdgesOfThreeTriangles) {
  EXPECT_EQ(text_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}},
                     {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}}),
            "[2] triangles 1, 2, 3 share the edge from (0, 0, 0) to (1, 0, 0); expected two at "
            "most: move apart the surfaces that meet there\n");
}

TEST(MeshMistakes, TrianglesThatFaceOppositeSides) {
  EXPECT_EQ(text_of({square, {{0, 1, 2}, {0, 3, 2}}}),
            "[1] triangles 1 and 2 run along their edge from (0, 0, 0) to (1, 1, 0) in the same "
            "direction; reverse the order of the vertices of one of them\n");
}

TEST(MeshMistakes, SurfacesThatMeetAtAVertex) {
  EXPECT_EQ(text_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {1, 0, 1}},
                     {{0, 1, 2}, {0, 3, 4}, {1, 0, 5}}}),
            "[1] triangles 1 and 2 meet at (0, 0, 0) only, without a common edge there; move apart "
            "the surfaces that touch there\n");
  // Two closed solids.
  TriangleMesh twins = box_mesh(1);
  const TriangleMesh other = twins;
  for (const Triple& p : other.vertices) twins.vertices.push_back({p[0] + 2, p[1] + 2, p[2] + 2});
  for (const auto& t : other.triangles)
    twins.triangles.push_back({t[0] + 24, t[1] + 24, t[2] + 24});
  EXPECT_EQ(mistakes_in(twins).size(), 1u);
}

}  // namespace
}  // namespace salvo::tests
