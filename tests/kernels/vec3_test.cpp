// Three-vectors: right-handed axes, products, and the motion of a point of a turning body.   [Bourg
// & Bywalec 1.3, 1.4, 2.9, 3.8, A]
#include "kernels/vec3.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "kernels/shapes.hpp"

namespace salvo::tests {
namespace {

using V = kernels::ScalarLane<double>;
using Vec = kernels::Vec3<V>;

Vec vec(double x, double y, double z) { return {V(x), V(y), V(z)}; }

void expect_near(Vec got, std::array<double, 3> wanted, double tolerance) {
  EXPECT_NEAR(got.x.value(), wanted[0], tolerance);
  EXPECT_NEAR(got.y.value(), wanted[1], tolerance);
  EXPECT_NEAR(got.z.value(), wanted[2], tolerance);
}

const Vec x = vec(1, 0, 0);
const Vec y = vec(0, 1, 0);
const Vec z = vec(0, 0, 1);

TEST(Vec3, AxesAreRightHanded) {  // 1.3, C1
  expect_near(cross(x, y), {0, 0, 1}, 0);
  expect_near(cross(y, z), {1, 0, 0}, 0);
  expect_near(cross(z, x), {0, 1, 0}, 0);
  expect_near(cross(y, x), {0, 0, -1}, 0);
}

TEST(Vec3, HasTheProductsOfAppendixA) {  // 1.4, A
  const Vec u = vec(1, 2, 3);
  const Vec v = vec(4, -5, 6);
  const Vec w = vec(-2, 0.5, 7);
  EXPECT_NEAR(norm(u).value(), 3.7416573867739413, 1e-15);
  expect_near(normalized_or(u, x), {0.267261241912, 0.534522483825, 0.801783725737}, 6e-13);
  expect_near(normalized_or(vec(0, 0, 0), x), {1, 0, 0}, 0);
  EXPECT_EQ(dot(u, v).value(), 12);
  expect_near(cross(u, v), {27, 6, -13}, 0);
  EXPECT_EQ(dot(u, cross(v, w)).value(), -142);
  const double cosine = (dot(u, v) / (norm(u) * norm(v))).value();
  EXPECT_NEAR(std::acos(cosine) * 180 / std::acos(-1), 68.562446966, 6e-10);
}

TEST(Vec3, DistanceOfAPointFromAPlane) {  // A: (7, 1, 2) from the plane through (1, 1, 1)
  const Vec n = normalized_or(vec(2, -1, 2), x);
  EXPECT_NEAR(plane_surface(vec(7, 1, 2) - vec(1, 1, 1), n).distance.value(), 4.666666667, 6e-10);
}

// v = v_cg + w x r,   a = a_cg + w x (w x r) + alpha x r
TEST(Vec3, PointOfATurningBody) {  // 2.9, A3 and A4
  {
    const Vec w = vec(0, 0, 2);
    const Vec alpha = vec(0, 0, 1.5);
    const Vec r = vec(0.5, 0.25, 0);
    expect_near(vec(3, 1, 0) + cross(w, r), {2.5, 2, 0}, 1e-15);
    const Vec normal = cross(w, cross(w, r));
    const Vec tangential = cross(alpha, r);
    expect_near(normal, {-2, -1, 0}, 1e-15);
    expect_near(tangential, {-0.375, 0.75, 0}, 1e-15);
    expect_near(vec(0.5, -9.81, 0) + normal + tangential, {-1.875, -10.06, 0}, 2e-15);
  }
  {
    const Vec w = vec(1, 2, 3);
    const Vec alpha = vec(-1, 0.5, 2);
    const Vec r = vec(0.2, -0.4, 0.6);
    expect_near(cross(w, r), {2.4, 0, -0.8}, 1e-15);
    expect_near(vec(1, 0, -2) + cross(w, r), {3.4, 0, -2.8}, 1e-15);
    const Vec normal = cross(w, cross(w, r));
    const Vec tangential = cross(alpha, r);
    expect_near(normal, {-1.6, 8, -4.8}, 4e-15);
    expect_near(tangential, {1.1, 1, 0.3}, 1e-15);
    expect_near(vec(0, -9.81, 0) + normal + tangential, {-0.5, -0.81, -4.5}, 4e-15);
    EXPECT_NEAR(dot(cross(w, r), r).value(), 0, 1e-15);  // released, it leaves along the tangent
  }
}

TEST(Vec3, MomentOfAForce) {  // 3.8, MO1 to MO3, in ft and lb
  const Vec r = vec(0.66, 0.525, 0);
  const Vec force = vec(-90, 156, 0);
  expect_near(cross(r, force), {0, 0, 150.21}, 1e-13);
  EXPECT_NEAR(cross(r, force).z.value(), 150.2, 0.05);  // printed
  EXPECT_NEAR(norm(force).value(), 180.099972, 6e-7);
  const Vec along = normalized_or(force, x);
  EXPECT_NEAR(std::acos(dot(along, x).value()) * 180 / std::acos(-1), 119.981639, 6e-7);
  expect_near(cross(along * V(3), along), {0, 0, 0}, 1e-15);  // through the centre of mass
  const Vec more = vec(5, 7, -11);
  const Vec both = cross(r, force + more) - (cross(r, force) + cross(r, more));
  expect_near(both, {0, 0, 0}, 1e-13);
}

}  // namespace
}  // namespace salvo::tests
