// Distances and normals of the solids: against the nearest of many points of the surface, the
// gradient, and the convexity that the swept test of contact stands on.
#include "kernels/shapes.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "kernels/quat.hpp"

namespace salvo::tests {
namespace {

using V = kernels::ScalarLane<double>;
using Vec = kernels::Vec3<V>;
using kernels::Surface;

double number(V x) { return x.value(); }

class Draws {
 public:
  double within(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  Vec point(double size) {
    return {V(within(-size, size)), V(within(-size, size)), V(within(-size, size))};
  }
  Vec direction() {
    for (;;) {
      const Vec d = point(1);
      const double length = number(norm(d));
      if (length > 0.1 && length < 1) return d * V(1 / length);
    }
  }

 private:
  std::mt19937_64 engine_{7};
};

const Vec fallback{V(0), V(1), V(0)};

// A solid with the points of its surface, dense enough to be within `spacing` of any of them.
struct Solid {
  const char* name;
  std::function<Surface<V>(Vec)> surface;
  std::vector<Vec> points;
  double spacing;
};

std::vector<Solid> solids() {
  std::vector<Solid> all;
  constexpr int n = 120;
  const double step = 1.0 / n;

  {
    Solid sphere{"sphere", [](Vec p) { return sphere_surface(p, V(1.5), fallback); }, {}, 0};
    sphere.spacing = 1.5 * kernels::pi * step * 1.5;
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j < 2 * n; ++j) {
        const double a = kernels::pi * i * step;
        const double b = kernels::pi * j * step;
        sphere.points.push_back({V(1.5 * std::sin(a) * std::cos(b)), V(1.5 * std::cos(a)),
                                 V(1.5 * std::sin(a) * std::sin(b))});
      }
    }
    all.push_back(sphere);
  }
  {
    const Vec half{V(0.5), V(1), V(2)};
    Solid box{"box", [half](Vec p) { return box_surface(p, half); }, {}, 2 * step * 2};
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n; ++j) {
        const double u = 2 * i * step - 1;
        const double v = 2 * j * step - 1;
        for (const double side : {-1.0, 1.0}) {
          box.points.push_back({V(0.5 * side), V(u), V(2 * v)});
          box.points.push_back({V(0.5 * u), V(side), V(2 * v)});
          box.points.push_back({V(0.5 * u), V(v), V(2 * side)});
        }
      }
    }
    all.push_back(box);
  }
  {
    const Vec axis{V(0.6), V(0), V(0.8)};
    const Vec across{V(0.8), V(0), V(-0.6)};
    const Vec up{V(0), V(1), V(0)};
    const auto at = [=](double along, double radius, double angle) {
      return axis * V(along) + (across * V(std::cos(angle)) + up * V(std::sin(angle))) * V(radius);
    };
    Solid capsule{"capsule", [=](Vec p) { return capsule_surface(p, axis, V(1), V(0.7)); }, {}, 0};
    Solid cylinder{
        "cylinder", [=](Vec p) { return cylinder_surface(p, axis, V(1), V(0.7)); }, {}, 0};
    capsule.spacing = cylinder.spacing = 0.7 * kernels::pi * step * 1.5;
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j < 2 * n; ++j) {
        const double along = 2 * i * step - 1;
        const double angle = kernels::pi * j * step;
        const double tilt = kernels::pi / 2 * i * step;
        capsule.points.push_back(at(along, 0.7, angle));
        cylinder.points.push_back(at(along, 0.7, angle));
        for (const double end : {-1.0, 1.0}) {
          capsule.points.push_back(
              at(end * (1 + 0.7 * std::sin(tilt)), 0.7 * std::cos(tilt), angle));
          cylinder.points.push_back(at(end, 0.7 * i * step, angle));
        }
      }
    }
    all.push_back(capsule);
    all.push_back(cylinder);
  }
  return all;
}

TEST(Shapes, DistanceIsThatToTheNearestPointOfTheSurface) {
  Draws draws;
  for (const Solid& solid : solids()) {
    for (int k = 0; k < 200; ++k) {
      const Vec p = draws.point(3);
      double nearest = 1e9;
      for (const Vec& q : solid.points) nearest = std::min(nearest, number(norm(p - q)));
      const double distance = number(solid.surface(p).distance);
      // The nearest sample is at most `spacing` from the nearest point.
      EXPECT_LE(std::abs(distance), nearest + 1e-12) << solid.name;
      EXPECT_GE(std::hypot(distance, solid.spacing), nearest - 1e-12) << solid.name;
    }
  }
}

TEST(Shapes, DistanceIsNegativeInside) {
  for (const Solid& solid : solids()) {
    EXPECT_LT(number(solid.surface({V(0.01), V(-0.02), V(0.03)}).distance), 0) << solid.name;
    EXPECT_GT(number(solid.surface({V(4), V(4), V(4)}).distance), 0) << solid.name;
  }
}

TEST(Shapes, NormalIsTheUnitGradient) {
  Draws draws;
  constexpr double h = 1e-5;
  for (const Solid& solid : solids()) {
    int smooth = 0;
    for (int k = 0; k < 2000; ++k) {
      const Vec p = draws.point(3);
      const Vec n = solid.surface(p).normal;
      EXPECT_NEAR(number(norm(n)), 1, 1e-14) << solid.name;
      const auto along = [&](double x, double y, double z) {
        const Vec d{V(x), V(y), V(z)};
        return number(solid.surface(p + d).distance - solid.surface(p - d).distance) / (2 * h);
      };
      const Vec gradient{V(along(h, 0, 0)), V(along(0, h, 0)), V(along(0, 0, h))};
      // Inside, the nearest face may change between the samples.
      if (std::abs(number(norm(gradient)) - 1) > 1e-6) continue;
      ++smooth;
      EXPECT_NEAR(number(norm(n - gradient)), 0, 1e-5) << solid.name;
    }
    EXPECT_GT(smooth, 1900) << solid.name;
  }
}

TEST(Shapes, DistanceIsConvexAlongAnyLine) {
  Draws draws;
  for (const Solid& solid : solids()) {
    for (int k = 0; k < 5000; ++k) {
      const Vec a = draws.point(3);
      const Vec b = draws.point(3);
      const double t = draws.within(0, 1);
      const double between = number(solid.surface(a + (b - a) * V(t)).distance);
      const double chord =
          (1 - t) * number(solid.surface(a).distance) + t * number(solid.surface(b).distance);
      EXPECT_LE(between, chord + 1e-13) << solid.name;
    }
  }
}

TEST(Shapes, PlaneMeasuresAlongItsNormal) {
  const Vec n{V(0.6), V(0.8), V(0)};
  const Surface<V> at = kernels::plane_surface(Vec{V(1), V(2), V(3)}, n);
  EXPECT_DOUBLE_EQ(number(at.distance), 2.2);
  EXPECT_DOUBLE_EQ(number(at.normal.y), 0.8);
}

TEST(Shapes, CoincidentCentresHaveANormal) {
  const Vec zero{V(0), V(0), V(0)};
  const Vec axis{V(0), V(0), V(1)};
  const Surface<V> sphere = sphere_surface(zero, V(2), fallback);
  EXPECT_EQ(number(sphere.distance), -2);
  EXPECT_EQ(number(sphere.normal.y), 1);
  for (const Surface<V>& at :
       {capsule_surface(zero, axis, V(3), V(1)), cylinder_surface(zero, axis, V(3), V(1))}) {
    EXPECT_EQ(number(at.distance), -1);
    EXPECT_NEAR(number(norm(at.normal)), 1, 1e-15);
    EXPECT_NEAR(number(dot(at.normal, axis)), 0, 1e-15);
  }
}

TEST(Shapes, PerpendicularOfAnyAxis) {
  Draws draws;
  for (int k = 0; k < 1000; ++k) {
    const Vec a = draws.direction();
    const Vec b = kernels::any_perpendicular(a);
    EXPECT_NEAR(number(norm(b)), 1, 1e-14);
    EXPECT_NEAR(number(dot(a, b)), 0, 1e-14);
  }
}

}  // namespace
}  // namespace salvo::tests
