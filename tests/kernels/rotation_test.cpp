// Rotations by unit quaternions, by matrices and by both alike.   [Bourg & Bywalec 1.3, 2.8, 11.1,
// 11.2, B, C]
#include <gtest/gtest.h>

#include <array>

#include "kernels/quat.hpp"

namespace salvo::tests {
namespace {

using V = kernels::ScalarLane<double>;
using Vec = kernels::Vec3<V>;
using Mat = kernels::Mat3<V>;
using Quat = kernels::Quat<V>;

constexpr double degree = kernels::pi / 180;

Vec vec(double x, double y, double z) { return {V(x), V(y), V(z)}; }

void expect_near(Vec got, std::array<double, 3> wanted, double tolerance) {
  EXPECT_NEAR(got.x.value(), wanted[0], tolerance);
  EXPECT_NEAR(got.y.value(), wanted[1], tolerance);
  EXPECT_NEAR(got.z.value(), wanted[2], tolerance);
}

void expect_near(Quat got, std::array<double, 4> wanted, double tolerance) {
  EXPECT_NEAR(got.w.value(), wanted[0], tolerance);
  expect_near(Vec{got.x, got.y, got.z}, {wanted[1], wanted[2], wanted[3]}, tolerance);
}

void expect_rows(const Mat& got, std::array<double, 3> row0, std::array<double, 3> row1,
                 std::array<double, 3> row2) {
  expect_near(got.row0, row0, 0);
  expect_near(got.row1, row1, 0);
  expect_near(got.row2, row2, 0);
}

const Vec x = vec(1, 0, 0);
const Vec y = vec(0, 1, 0);
const Vec z = vec(0, 0, 1);

Quat turn(Vec axis, double degrees) { return Quat::from_axis_angle(axis, V(degrees * degree)); }

// Turned by the quaternion, by its matrix, and back.
void expect_turned(Quat q, Vec v, std::array<double, 3> wanted, double tolerance) {
  expect_near(rotate(q, v), wanted, tolerance);
  expect_near(to_matrix(q) * v, wanted, tolerance);
  expect_near(rotate(conjugate(q), rotate(q, v)), {v.x.value(), v.y.value(), v.z.value()},
              2 * tolerance);
}

TEST(Rotation, QuarterTurnsGoFromAxisToAxis) {  // 1.3, C1
  expect_turned(turn(z, 90), x, {0, 1, 0}, 1e-15);
  expect_turned(turn(y, 90), z, {1, 0, 0}, 1e-15);
  expect_turned(turn(x, 90), y, {0, 0, 1}, 1e-15);
}

TEST(Rotation, OfLocalAxes) {  // 2.8, L1
  expect_turned(turn(z, 30), vec(2, 1, 0), {1.2320508076, 1.8660254038, 0}, 6e-11);
}

TEST(Rotation, AboutEachAxis) {  // 11.1
  const Vec v = vec(1, 2, 3);
  expect_turned(turn(x, 30), v, {1, 0.232050807569, 3.598076211353}, 1e-12);
  expect_turned(turn(y, 30), v, {2.366025403784, 2, 2.098076211353}, 1e-12);
  expect_turned(turn(z, 30), v, {-0.133974596216, 2.232050807569, 3}, 1e-12);
}

TEST(Rotation, OfTwoTheRightOneComesFirst) {  // 11.1: about fixed z, then about fixed x
  expect_turned(turn(x, 90) * turn(z, 90), x, {0, 0, 1}, 1e-15);
  expect_turned(turn(z, 90) * turn(x, 90), x, {0, 1, 0}, 1e-15);
  expect_near(to_matrix(turn(x, 90)) * to_matrix(turn(z, 90)) * x, {0, 0, 1}, 1e-15);
}

TEST(Quat, FiftyDegreesAboutAnAxis) {  // 11.2
  const Quat q = turn(normalized_or(vec(1, 2, 3), x), 50);
  expect_near(q, {0.9063077870366, 0.1129494814877, 0.2258989629754, 0.3388484444631}, 1e-13);
  expect_turned(q, vec(0.3, -1.2, 2.5), {2.0913305122456, -0.8233556704327, 1.6517936095399},
                1e-12);
  const Quat turned = q * Quat{V(1), V(2), V(3), V(4)} * conjugate(q);
  expect_near(turned, {1, 1.591144644879, 3.358437636983, 3.897326693719}, 1e-12);
}

TEST(Quat, ProductsDoNotCommute) {  // 11.2, C
  const Quat q{V(1), V(2), V(3), V(4)};
  const Quat p{V(-2), V(0.5), V(1.5), V(-1)};
  expect_near(q * p, {-3.5, -12.5, -0.5, -7.5}, 0);
  expect_near(p * q, {-3.5, 5.5, -8.5, -10.5}, 0);
  const Quat v{V(0), V(0.3), V(-1.2), V(2.5)};
  expect_near(q * v, {-7, 12.6, -5, -0.8}, 2e-15);
  expect_near(v * q, {-7, -12, 2.6, 5.8}, 2e-15);
  expect_near(conjugate(q * p), {-3.5, 12.5, 0.5, 7.5}, 0);
  expect_near(conjugate(p) * conjugate(q), {-3.5, 12.5, 0.5, 7.5}, 0);
}

TEST(Mat3, ProductsAndDeterminants) {  // B
  const Mat m{vec(2, -1, 0), vec(1, 3, 5), vec(4, 0, -2)};
  const Mat n{vec(1, 0, 2), vec(0, -1, 1), vec(3, 1, 0)};
  EXPECT_EQ(determinant(m).value(), -34);
  EXPECT_EQ(determinant(m * n).value(), -170);
  expect_rows(m * n, {2, 1, 3}, {16, 2, 5}, {-2, -2, 8});
  expect_rows(n * m, {10, -1, -4}, {3, -3, -7}, {7, 0, 5});
  expect_rows(transpose(n) * transpose(m), {2, 16, -2}, {1, 2, -2}, {3, 5, 8});
  expect_near(m * vec(1, 2, 3), {0, 22, -2}, 0);
  expect_near(transpose(m) * vec(1, 2, 3), {16, 5, 4}, 0);  // u M
}

}  // namespace
}  // namespace salvo::tests
