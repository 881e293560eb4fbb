// Contact with fixed obstacles: the book's numbers for its two responses, and for the swept one
// impacts, tunnelling, energy, sliding and rest.
#include "models/contact.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "integrators/fixed_step.hpp"
#include "models/particle.hpp"

namespace salvo::tests {
namespace {

using kernels::Motion;
using kernels::ScalarLane;
using kernels::Vec3;
using models::Contact;
using models::ContactCount;
using models::ContactResponse;
using models::ContactSettings;
using models::Obstacle;
using models::ObstacleShape;
using models::ParticleRow;
using models::Triple;

template <class T>
using Lane = ScalarLane<T>;

template <class T>
double number(Lane<T> x) {
  return static_cast<double>(x.value());
}

template <class T>
Triple triple(Vec3<Lane<T>> a) {
  return {number(a.x), number(a.y), number(a.z)};
}

double dot(const Triple& a, const Triple& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length(const Triple& a) { return std::sqrt(dot(a, a)); }
Triple operator-(const Triple& a, const Triple& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Triple operator+(const Triple& a, const Triple& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
Triple operator*(double s, const Triple& a) { return {s * a[0], s * a[1], s * a[2]}; }

template <class T>
Motion<Lane<T>> motion(const Triple& position, const Triple& velocity) {
  using V = Lane<T>;
  return {models::broadcast<V>(position), models::broadcast<V>(velocity)};
}

template <class T>
bool same_bits(const Motion<Lane<T>>& a, const Motion<Lane<T>>& b) {
  const auto same = [](Lane<T> x, Lane<T> y) {
    return std::bit_cast<typename Lane<T>::Bits>(x.value()) ==
           std::bit_cast<typename Lane<T>::Bits>(y.value());
  };
  return same(a.position.x, b.position.x) && same(a.position.y, b.position.y) &&
         same(a.position.z, b.position.z) && same(a.velocity.x, b.velocity.x) &&
         same(a.velocity.y, b.velocity.y) && same(a.velocity.z, b.velocity.z);
}

Obstacle plane(const Triple& point, const Triple& normal, double restitution, double friction = 0) {
  Obstacle o;
  o.center = point;
  o.axis = normal;
  o.restitution = restitution;
  o.friction = friction;
  return models::normalized(o);
}

Obstacle sphere(const Triple& center, double radius, double restitution) {
  Obstacle o;
  o.shape = ObstacleShape::sphere;
  o.center = center;
  o.radius = radius;
  o.restitution = restitution;
  return o;
}

Obstacle field(const Triple& corner, std::size_t columns, std::size_t rows, double spacing,
               const std::vector<double>& heights, double restitution, double friction = 0) {
  Obstacle o;
  o.shape = ObstacleShape::height_field;
  o.center = corner;
  o.samples = models::make_height_samples(columns, rows, spacing, heights);
  o.restitution = restitution;
  o.friction = friction;
  return o;
}

class Draws {
 public:
  explicit Draws(std::uint64_t seed) : engine_(seed) {}
  double within(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  Triple direction() {
    for (;;) {
      const Triple d{within(-1, 1), within(-1, 1), within(-1, 1)};
      const double size = length(d);
      if (size > 0.1 && size < 1) return 1 / size * d;
    }
  }
  Triple vector(double shortest, double longest) {
    const double size = within(shortest, longest);
    return size * direction();
  }

 private:
  std::mt19937_64 engine_;
};

// The number of type T nearest to x. Stored in between: gcc 12 at -O2 vectorizes neighbouring
// conversions from double to float and back to nothing.
template <class T>
double representable(double x) {
  volatile T stored = static_cast<T>(x);
  return static_cast<double>(stored);
}

// ---- independent of the code under test: distances in double ------------------------------------

Triple turned_back(const std::array<double, 4>& q, const Triple& v) {
  const auto [w, x, y, z] = q;
  const double m[3][3] = {
      {1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
      {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
      {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)},
  };
  Triple r{};
  for (std::size_t i = 0; i < 3; ++i) r[i] = m[0][i] * v[0] + m[1][i] * v[1] + m[2][i] * v[2];
  return r;
}

double ground_height(const models::HeightSamples& f, double x, double z) {
  x /= f.spacing;
  z /= f.spacing;
  const double i = std::clamp(std::floor(x), 0.0, static_cast<double>(f.columns - 2));
  const double j = std::clamp(std::floor(z), 0.0, static_cast<double>(f.rows - 2));
  const auto h = [&](double column, double row) {
    return f.heights[static_cast<std::size_t>(row) * f.columns + static_cast<std::size_t>(column)];
  };
  const double u = x - i;
  const double v = z - j;
  const double near = h(i, j);
  const double far = h(i + 1, j + 1);
  return u >= v ? near + u * (h(i + 1, j) - near) + v * (far - h(i + 1, j))
                : near + v * (h(i, j + 1) - near) + u * (far - h(i, j + 1));
}

double gap(const Obstacle& o, const Triple& position, double radius) {
  const Triple p = position - o.center;
  switch (o.shape) {
    case ObstacleShape::plane:
      return dot(p, o.axis) - radius;
    case ObstacleShape::sphere:
      return length(p) - o.radius - radius;
    case ObstacleShape::capsule: {
      const double along = std::clamp(dot(p, o.axis), -o.half_length, o.half_length);
      return length(p - along * o.axis) - o.radius - radius;
    }
    case ObstacleShape::cylinder: {
      const double along = dot(p, o.axis);
      const double side = length(p - along * o.axis) - o.radius;
      const double end = std::abs(along) - o.half_length;
      const double deepest = std::max(side, end);
      return (deepest <= 0 ? deepest : std::hypot(std::max(side, 0.0), std::max(end, 0.0))) -
             radius;
    }
    case ObstacleShape::box: {
      const Triple q = turned_back(o.rotation, p);
      double deepest = -std::numeric_limits<double>::infinity();
      double squares = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        const double beyond = std::abs(q[i]) - o.half_size[i];
        deepest = std::max(deepest, beyond);
        squares += std::max(beyond, 0.0) * std::max(beyond, 0.0);
      }
      return (deepest <= 0 ? deepest : std::sqrt(squares)) - radius;
    }
    case ObstacleShape::height_field: {
      const double width = o.samples->spacing * static_cast<double>(o.samples->columns - 1);
      const double depth = o.samples->spacing * static_cast<double>(o.samples->rows - 1);
      if (p[0] < 0 || p[2] < 0 || p[0] > width || p[2] > depth) return 1;
      return p[1] - radius - ground_height(*o.samples, p[0], p[2]);
    }
    case ObstacleShape::mesh:
      break;  // only of particles that touch
  }
  return 0;
}

Obstacle any_solid(Draws& draws, ObstacleShape shape, double thickness) {
  Obstacle o;
  o.shape = shape;
  o.center = {draws.within(-3, 3), draws.within(-3, 3), draws.within(-3, 3)};
  o.axis = draws.direction();
  o.radius = thickness * draws.within(0.5, 1);
  o.half_length = draws.within(0.1, 3);
  o.half_size = {0.5 * thickness, draws.within(0.1, 2), draws.within(0.1, 2)};
  const Triple d = draws.direction();
  o.rotation = {draws.within(-1, 1), d[0], d[1], d[2]};
  return models::normalized(o);
}

std::vector<double> rough_heights(Draws& draws, std::size_t count) {
  std::vector<double> heights(count);
  for (double& h : heights) h = representable<float>(draws.within(-1, 1));
  return heights;
}

// ---- one particle -------------------------------------------------------------------------------

// Uniform gravity along -y. Written with the mean velocity: of the ways to round velocity Verlet
// the one that keeps the energy best.
template <class T>
Motion<Lane<T>> fall(const Motion<Lane<T>>& m, double gravity, double dt) {
  using V = Lane<T>;
  const Vec3<V> end{m.velocity.x, m.velocity.y - V(gravity) * V(dt), m.velocity.z};
  return {m.position + (m.velocity + end) * (V(dt) * V(0.5)), end};
}

template <class T>
struct World {
  using V = Lane<T>;

  explicit World(std::vector<Obstacle> those = {}) : obstacles(std::move(those)) {}

  std::vector<Obstacle> obstacles;
  double gravity = 9.8;
  double dt = 0.01;
  double radius = 0.1;
  double mass = 1;
  ContactSettings settings;
  ContactCount<V> count;

  ParticleRow<V> row() const { return {V(mass), V(radius), V(0)}; }
  Motion<V> resolve(const Motion<V>& before, const Motion<V>& after) {
    return Contact<V>(obstacles, settings)
        .resolve(before, after, row(), V(dt), typename V::Mask(true), count);
  }
  Motion<V> step(const Motion<V>& m) { return resolve(m, fall(m, gravity, dt)); }
  template <class Integrator>
  Motion<V> step_with(const Motion<V>& m) {
    return resolve(m, Integrator::step(m, V(dt), [&](auto, auto, auto) {
                     return Vec3<V>{V(0), V(-gravity), V(0)};
                   }));
  }
  double kinetic(const Motion<V>& m) const {
    return 0.5 * dot(triple(m.velocity), triple(m.velocity));
  }
  // Per kg, over the level y = 0.
  double energy(const Motion<V>& m) const {
    return kinetic(m) + representable<T>(gravity) * number(m.position.y);
  }
};

// ---- impulses, chapter 5 ------------------------------------------------------------------------

using D = Lane<double>;

TEST(Impact, BulletInABarrel) {  // 5.1: 150 g, from rest to 756 m/s within 0.8 ms
  // The impulse that would stop it is the one that it was given.
  const double impulse = number(kernels::normal_impulse(D(-756), D(0), D(1 / 0.15), D(0)));
  EXPECT_NEAR(impulse, 113.4, 1e-12);
  EXPECT_NEAR(impulse / 0.0008, 141750, 1e-9);  // N on average
  EXPECT_NEAR(number(kernels::sticking_impulse_of_particle(D(0.15), D(756))), 113.4, 1e-12);
}

TEST(Impact, BilliardBalls) {  // 5.2
  const double m = 0.156;
  const Triple n{std::sqrt(3) / 2, -0.5, 0};  // from ball 1 to ball 2
  const double vrn = dot({6, 0, 0}, n);
  const double j = number(kernels::normal_impulse(D(vrn), D(0.9), D(1 / m), D(1 / m)));
  EXPECT_NEAR(vrn, 5.196152, 1e-6);
  EXPECT_NEAR(-j, 0.7700698, 1e-7);
  const Triple v1 = Triple{6, 0, 0} + j / m * n;
  const Triple v2 = -j / m * n;
  EXPECT_NEAR(v1[0], 1.725, 1e-12);
  EXPECT_NEAR(v1[1], 2.468172401, 1e-9);
  EXPECT_NEAR(v2[0], 4.275, 1e-12);
  EXPECT_NEAR(v2[1], -2.468172401, 1e-9);
  EXPECT_NEAR((dot(v2, n) - dot(v1, n)) / vrn, 0.9, 1e-14);
  EXPECT_NEAR(m * (v1[0] + v2[0]), 0.936, 1e-14);
  EXPECT_NEAR(m * (v1[1] + v2[1]), 0, 1e-15);
  const double kinetic = 0.5 * m * (dot(v1, v1) + dot(v2, v2));
  EXPECT_NEAR(kinetic, 2.60793, 1e-9);
  // Of 2.808 J before; lost is 1/2 (m/2) (1 - e^2) vrn^2.
  EXPECT_NEAR(2.808 - kinetic, 0.20007, 1e-9);
  EXPECT_NEAR(2.808 - kinetic, 0.25 * m * (1 - 0.9 * 0.9) * vrn * vrn, 1e-14);
  // Along the line of action and across it, where nothing changes and ball 2 gets nothing.
  EXPECT_NEAR(dot(v1, n), 0.259808, 1e-6);
  EXPECT_NEAR(dot(v2, n), 4.936345, 1e-6);
  const Triple across{0.5, std::sqrt(3) / 2, 0};
  EXPECT_NEAR(dot(v1, across), 3, 1e-14);
  EXPECT_NEAR(dot(v2, across), 0, 1e-15);
  // Printed, with 0.864 for the cosine of 30 degrees.
  EXPECT_NEAR(vrn, 5.18, 0.02);
  EXPECT_NEAR(dot(v2, n), 4.92, 0.02);
  EXPECT_NEAR(dot(v1, n), 0.26, 0.02);
  EXPECT_NEAR(v1[0], 1.72, 0.02);
  EXPECT_NEAR(v1[1], 2.47, 0.02);
}

TEST(Impact, BaseballAndBat) {  // 5.2
  const auto impulse = [](double vrn) {
    return number(kernels::normal_impulse(D(vrn), D(0.46), D(1 / 1.02), D(1 / 0.15)));
  };
  const auto after = [&](const Triple& n) {
    const double j = impulse(dot(Triple{31, 0, 0} - Triple{-40, 0, 0}, n));
    return std::pair{Triple{31, 0, 0} + j / 1.02 * n, Triple{-40, 0, 0} - j / 0.15 * n};
  };
  const Triple exact{std::sqrt(1 - 35.0 * 35 / (72.0 * 72)), 35.0 / 72, 0};
  EXPECT_NEAR(-impulse(71 * exact[0]), 11.846145, 1e-6);
  const auto [bat, ball] = after(exact);
  EXPECT_NEAR(dot(bat, exact), 15.476940, 1e-6);
  EXPECT_NEAR(dot(ball, exact), 44.018417, 1e-6);
  EXPECT_NEAR(bat[0], 20.850676, 1e-6);
  EXPECT_NEAR(bat[1], -5.645630, 1e-6);
  EXPECT_NEAR(ball[0], 29.015402, 1e-6);
  EXPECT_NEAR(ball[1], 38.390283, 1e-6);
  EXPECT_NEAR(1.02 * bat[0] + 0.15 * ball[0], 25.62, 1e-12);
  EXPECT_NEAR(1.02 * bat[1] + 0.15 * ball[1], 0, 1e-14);
  // The printed normal, not quite of unit length.
  const Triple printed{0.875, 0.484, 0};
  const auto along = [&](double speed) {
    return number(dot(models::broadcast<D>({speed, 0, 0}), models::broadcast<D>(printed)));
  };
  EXPECT_NEAR(along(31), 27.125, 1e-14);
  EXPECT_NEAR(along(-40), -35, 1e-14);
  EXPECT_NEAR(along(71), 62.125, 1e-14);
  const auto [rough_bat, rough_ball] = after(printed);
  EXPECT_NEAR(rough_bat[0], 20.8250, 6e-5);
  EXPECT_NEAR(rough_bat[1], -5.6282, 6e-5);
  EXPECT_NEAR(rough_ball[0], 29.1897, 6e-5);
  EXPECT_NEAR(rough_ball[1], 38.2718, 6e-5);
  EXPECT_NEAR(dot(rough_bat, printed), 15.497858, 1e-6);
  EXPECT_NEAR(dot(rough_ball, printed), 44.064565, 1e-6);
  const Triple across{0.484, -0.875, 0};
  EXPECT_NEAR(dot(rough_bat, across), 15.004, 1e-12);
  EXPECT_NEAR(dot(rough_ball, across), -19.36, 1e-12);
  // From the printed 62.1 = 27.1 + 35.0 m/s, and the printed results within their errors.
  EXPECT_NEAR(27.1 + impulse(62.1) / 1.02, 15.4762, 6e-5);
  EXPECT_NEAR(-35 - impulse(62.1) / 0.15, 44.0422, 6e-5);
  EXPECT_NEAR(dot(rough_bat, printed), 15.7, 0.015 * 15.7);
  EXPECT_NEAR(dot(rough_ball, printed), 44.4, 0.01 * 44.4);
}

TEST(Impact, CornerDropAndRodsWithRotation) {  // 5.3
  // Box 2 x 1 m, 2 kg, on its corner r = (1, -0.5); n.[((r x n)/I) x r] = (r x n)_z^2/I.
  const double inertia = 2 * (2.0 * 2 + 1) / 12;
  const double j = number(kernels::normal_impulse(D(-3), D(0.5), D(0.5), D(0), D(1 / inertia)));
  EXPECT_NEAR(j, 2.647058823529, 1e-12);
  EXPECT_NEAR(-3 + j / 2, -1.676470588235, 1e-12);
  EXPECT_NEAR(j / inertia, 3.176470588235, 1e-12);
  // Impulse for a change of 1 m/s where they touch: the inverse of 1/m + 1/I = 1.7/kg.
  const double unit = number(kernels::normal_impulse(D(-1), D(0), D(0.5), D(0), D(1 / inertia)));
  EXPECT_NEAR(1 / unit, 1.7, 1e-14);
  EXPECT_NEAR(-3 + j / 2 + j / inertia, 1.5, 1e-14);  // the corner's velocity
  const double velocity = -3 + j / 2;
  const double spin = j / inertia;
  const double kinetic = 0.5 * 2 * velocity * velocity + 0.5 * inertia * spin * spin;
  EXPECT_NEAR(kinetic, 7.014705882353, 1e-12);
  EXPECT_NEAR(9 - kinetic, 1.985294117647, 1e-12);
  // Two rods; n from body 1 to body 2, so J is negative.
  const double i1 = 1 * 2 * 2 / 12.0;
  const double i2 = 3 * 2 * 2 / 12.0;
  const double rods = number(
      kernels::normal_impulse(D(2), D(0.7), D(1), D(1 / 3.0), D(0.8 * 0.8 / i1 + 0.6 * 0.6 / i2)));
  EXPECT_NEAR(rods, -0.940959409594, 1e-12);
  const double unit_of_rods = number(
      kernels::normal_impulse(D(-1), D(0), D(1), D(1 / 3.0), D(0.8 * 0.8 / i1 + 0.6 * 0.6 / i2)));
  EXPECT_NEAR(1 / unit_of_rods, 3.613333333, 5e-10);
  const double v1 = 1 + rods;
  const double v2 = -1 - rods / 3;
  const double w1 = -0.8 * rods / i1;
  const double w2 = -0.6 * rods / i2;
  EXPECT_NEAR(v1, 0.059040590406, 1e-12);
  EXPECT_NEAR(v2, -0.686346863469, 1e-12);
  EXPECT_NEAR(w1, 2.258302583026, 1e-12);
  EXPECT_NEAR(w2, 0.564575645756, 1e-12);
  EXPECT_NEAR(v1 + 3 * v2, -2, 1e-14);                               // momentum
  EXPECT_NEAR(0.8 * v1 + i1 * w1 - 1.8 * v2 + i2 * w2, 2.6, 1e-14);  // about the contact
  EXPECT_NEAR(0.5 * (v1 * v1 + 3 * v2 * v2 + i1 * w1 * w1 + i2 * w2 * w2), 1.717712177122, 1e-12);
}

TEST(Impact, FrictionOfAGolfBallIsCappedWhereItSticks) {  // 5.4
  const double m = 0.0459;
  const double r = 0.0214;
  const double inertia = 0.4 * m * r * r;
  const double normal = m * 60;
  const auto impulse = [&](double mu, double slip) {
    return number(kernels::friction_impulse(D(normal), D(mu),
                                            kernels::sticking_impulse_of_sphere(D(m), D(slip))));
  };
  const auto spin = [&](double mu, double slip) { return impulse(mu, slip) * r / inertia; };
  const double never_sticks = 1e6;
  EXPECT_NEAR(impulse(0.1, never_sticks), 0.2754, 1e-14);
  EXPECT_NEAR(impulse(0.4, never_sticks), 1.1016, 1e-14);
  // tan phi = mu: how far the impulse leans from the normal, in degrees.
  const auto lean = [&](double mu) {
    return std::atan(impulse(mu, never_sticks) / normal) * 180 / kernels::pi;
  };
  EXPECT_NEAR(lean(0.1), 5.710593, 6e-7);
  EXPECT_NEAR(lean(0.3), 16.699244, 6e-7);
  EXPECT_NEAR(lean(0.4), 21.801409, 6e-7);
  EXPECT_NEAR(spin(0.1, never_sticks), 700.93458, 1e-5);
  EXPECT_NEAR(spin(0.3, never_sticks), 2102.80374, 1e-5);
  EXPECT_NEAR(spin(0.4, never_sticks), 2803.73832, 1e-5);
  EXPECT_NEAR(number(kernels::sticking_impulse_of_sphere(D(m), D(20))), 0.262286, 1e-6);
  EXPECT_NEAR(spin(0.1, 20), 667.5567, 1e-4);
  EXPECT_NEAR(spin(0.4, 20), 667.5567, 1e-4);
}

TEST(Impact, FrictionBetweenBilliardBallsIsEqualAndOpposite) {  // 5.4
  const double m = 0.156;
  const Triple n{-std::sqrt(3) / 2, 0.5, 0};  // from ball 2 to ball 1
  const double vrn = dot({6, 0, 0}, n);
  const double j = number(kernels::normal_impulse(D(vrn), D(0.9), D(1 / m), D(1 / m)));
  const Triple slip = Triple{6, 0, 0} - vrn * n;
  const Triple t = 1 / length(slip) * slip;
  const double f =
      number(kernels::friction_impulse(D(j), D(0.1), D(std::numeric_limits<double>::max())));
  const Triple v1 = Triple{6, 0, 0} + j / m * n - f / m * t;
  const Triple v2 = f / m * t - j / m * n;
  EXPECT_NEAR(v1[0], 1.478182760, 1e-9);
  EXPECT_NEAR(v1[1], 2.040672401, 1e-9);
  EXPECT_NEAR(v2[0], 4.521817240, 1e-9);
  EXPECT_NEAR(v2[1], -2.040672401, 1e-9);
  // The listing, with the same sign on both balls, has a momentum of (0.8590, -0.1334).
  EXPECT_NEAR(m * (v1[0] + v2[0]), 0.936, 1e-14);
  EXPECT_NEAR(m * (v1[1] + v2[1]), 0, 1e-15);
  // Both turn the same way: the lever changes its sign with the friction.
  const double r = 0.0285;
  const auto spin = [&](const Triple& lever, const Triple& friction) {
    const auto moment = cross(models::broadcast<D>(lever), models::broadcast<D>(friction));
    return number(moment.z) / (0.4 * m * r * r);
  };
  EXPECT_NEAR(spin(-r * n, -f * t), -43.301270, 1e-6);
  EXPECT_NEAR(spin(r * n, f * t), -43.301270, 1e-6);
}

TEST(Impact, ParticleSticksWhenFrictionWouldTurnItAround) {
  EXPECT_EQ(number(kernels::friction_factor(D(2), D(4), D(0.5))), 0);
  EXPECT_EQ(number(kernels::friction_factor(D(2), D(4), D(0.25))), 0.5);
  EXPECT_EQ(number(kernels::friction_factor(D(0), D(4), D(0.25))), 0);
  EXPECT_EQ(number(kernels::friction_factor(D(2), D(4), D(0))), 1);
  EXPECT_EQ(number(kernels::sticking_impulse_of_particle(D(2), D(3))), 6);
}

TEST(Impact, ObstacleOfFiniteMassTakesPartOfTheRestitution) {
  EXPECT_NEAR(number(kernels::effective_restitution(D(0.6), D(1), D(0.01))), 0.584158416, 1e-9);
  EXPECT_EQ(number(kernels::effective_restitution(D(0.6), D(1), D(0))), 0.6);
}

// ---- the book's responses, chapter 8 ------------------------------------------------------------

struct BookWorld {
  explicit BookWorld(std::vector<Obstacle> those, double g = 9.8)
      : obstacles(std::move(those)), gravity(g) {}

  std::vector<Obstacle> obstacles;
  double gravity;
  double dt = 0.1;
  ContactSettings settings{ContactResponse::force, 4, false};  // as the listing has it
  ContactCount<D> count;

  ParticleRow<D> row() const { return {D(1), D(0.1), D(0)}; }
  bool step(Motion<D>& m) {
    const auto hit =
        Contact<D>(obstacles, settings).book_force(m, row(), D(dt), D::Mask(true), count);
    m = select(hit.mask, hit.motion,
               integrators::SemiImplicitEuler::step(m, D(dt), [&](auto, auto, auto) {
                 return Vec3<D>{D(0), D(-gravity), D(0)};
               }));
    return hit.mask.value();
  }
};

const Obstacle book_ground = plane({0, 100, 0}, {0, 1, 0}, 0.6);

Obstacle book_obstacle(const Triple& center, double radius) {
  Obstacle o = sphere(center, radius, 0.6);
  o.mass = 100;
  return o;
}

TEST(BookForce, OneImpactStep) {
  BookWorld world{{book_ground}};
  auto m = motion<double>({5, 99, 0}, {3, -20, 0});
  EXPECT_TRUE(world.step(m));
  EXPECT_NEAR(number(m.velocity.x), 3, 1e-12);
  EXPECT_NEAR(number(m.velocity.y), 12, 1e-12);
  EXPECT_NEAR(1 * (number(m.velocity.y) + 20) / world.dt, 320, 1e-10);  // N on 1 kg
  EXPECT_NEAR(number(kernels::normal_impulse(D(-20), D(0.6), D(1), D(0))), 32, 1e-13);
  EXPECT_NEAR(number(m.position.x), 5.3, 1e-12);
  EXPECT_NEAR(number(m.position.y), 101.3, 1e-12);
  EXPECT_EQ(number(world.count.impacts), 1);
}

TEST(BookForce, BacksUpToTheHeightOfContact) {
  // The text's version: the path of the last step, (4.7, 101) to (5, 99), meets y = 100.1 at
  // x = 4.835.
  BookWorld world{{book_ground}};
  world.settings.interpolate_at_plane = true;
  auto m = motion<double>({5, 99, 0}, {3, -20, 0});
  EXPECT_TRUE(world.step(m));
  EXPECT_NEAR(number(m.position.x), 5.135, 1e-12);
  EXPECT_NEAR(number(m.position.y), 101.3, 1e-12);
  // The case in which the listing divides zero by zero: a repeated contact at the height itself.
  m = motion<double>({5, 100.1, 0}, {3, -1e-9, 0});
  world.obstacles[0].restitution = 0;
  for (int i = 0; i < 10; ++i) world.step(m);
  EXPECT_TRUE(is_finite(m.position).value());
}

TEST(BookForce, DropUntilItNeverRests) {
  BookWorld world{{book_ground}};
  auto m = motion<double>({0, 120, 0}, {0, 0, 0});
  std::vector<int> impacts;
  std::vector<double> apexes;
  double highest = 0;
  for (int n = 1; n <= 300; ++n) {
    const double before = number(m.velocity.y);
    if (world.step(m)) {
      EXPECT_NEAR(number(m.velocity.y), -0.6 * before, 1e-13);
      if (impacts.size() < 6) impacts.push_back(n);
      if (highest > 0) apexes.push_back(highest);
      highest = 0;
    }
    if (!impacts.empty()) highest = std::max(highest, number(m.position.y));
    const auto expect = [&](double y, double v) {
      EXPECT_NEAR(number(m.position.y), y, 1e-9) << n;
      EXPECT_NEAR(number(m.velocity.y), v, 1e-9) << n;
    };
    if (n == 18) expect(103.242, -17.64);
    if (n == 19) expect(101.380, -18.62);
    if (n == 20) expect(99.420, -19.60);
    if (n == 21) expect(101.276, 11.76);
    if (n == 22) expect(102.354, 10.78);
    if (n > 250) {
      // A cycle of three steps.
      const int phase = std::abs(number(m.velocity.y) - 0.735) < 1e-9   ? 0
                        : std::abs(number(m.velocity.y) + 0.245) < 1e-9 ? 1
                                                                        : 2;
      const double velocities[] = {0.735, -0.245, -1.225};
      const double heights[] = {100.1735, 100.149, 100.0265};
      expect(heights[phase], velocities[phase]);
    }
  }
  EXPECT_EQ(impacts, (std::vector<int>{21, 47, 64, 75, 83, 89}));
  const double expected[] = {107.744, 103.4712, 101.5308, 100.7068};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(apexes.at(i), expected[i], 5e-5);
}

// Still-air drag and a constant push, with the book's values and its pi.
models::ForceSettings book_forces(bool windy) {
  models::ForceSettings forces;
  forces.gravity = {0, -9.8, 0};
  forces.air_density = 1.23;
  forces.quadratic_drag = true;
  forces.drag_law = models::DragLaw::book_still_air;
  forces.windy = windy;
  forces.wind.velocity = {10, 0, 0};
  return forces;
}

template <class T>
struct BookParticle {
  using V = Lane<T>;

  models::ForceSettings settings;
  std::vector<Obstacle> obstacles;
  Motion<V> m;

  static ParticleRow<V> row() { return {V(1), V(0.1), V(3.14159 * 0.1 * 0.1 * 0.6)}; }
  void run(int steps) {
    const models::ParticleForces<V> forces(settings);
    const auto coefficients = forces.coefficients(row());
    const std::array<T, models::gust_coefficients> still{};
    const Contact<V> contact(obstacles, {ContactResponse::force, 4, false});
    ContactCount<V> count;
    for (int n = 0; n < steps; ++n) {
      const auto hit = contact.book_force(m, row(), V(0.1), typename V::Mask(true), count);
      m = select(
          hit.mask, hit.motion,
          integrators::SemiImplicitEuler::step(m, V(0.1), [&](auto position, auto velocity, auto) {
            return forces.acceleration(position, velocity, coefficients, still.data());
          }));
    }
  }
  void expect(double x, double y, double vx, double vy) const {
    EXPECT_NEAR(number(m.position.x), x, 2e-9 * std::max(1.0, x));
    EXPECT_NEAR(number(m.position.y), y, 2e-9 * std::max(1.0, std::abs(y)));
    EXPECT_NEAR(number(m.velocity.x), vx, 2e-9);
    EXPECT_NEAR(number(m.velocity.y), vy, 2e-9);
  }
};

TEST(BookForce, FallWithWindAndDrag) {
  const models::ForceSettings settings = book_forces(true);
  EXPECT_NEAR(number(models::ParticleForces<D>(settings)
                         .coefficients(BookParticle<double>::row())
                         .drag_factor),
              0.0115924671, 6e-11);
  BookParticle<double> p{settings, {}, motion<double>({0, 1000, 0}, {0, 0, 0})};
  p.run(1);
  p.expect(0.011592467, 999.902, 0.115924671, -0.98);
  p.run(9);
  p.expect(0.626897120, 994.700358674, 1.122672462, -9.490809877);
  p.run(40);
  p.expect(10.682884427, 909.689398740, 3.217432179, -27.199417587);
  p.run(50);
  p.expect(27.534516630, 767.229649521, 3.420875673, -28.919281205);
  p.run(300);
  EXPECT_NEAR(number(p.m.velocity.x), 3.427411091, 1e-9);
  EXPECT_NEAR(number(p.m.velocity.y), -28.974530097, 1e-9);
  BookParticle<double> still{book_forces(false), {}, motion<double>({0, 1000, 0}, {0, 0, 0})};
  still.run(50);
  EXPECT_NEAR(number(still.m.velocity.y), -27.272575035, 1e-9);
  still.run(50);
  EXPECT_NEAR(number(still.m.velocity.y), -29.018518334, 1e-9);
}

TEST(BookForce, DropWithWindAndDrag) {
  BookParticle<double> p{book_forces(true), {book_ground}, motion<double>({0, 200, 0}, {0, 0, 0})};
  p.run(55);
  p.expect(12.309521817, 101.757339349, 3.267457802, 16.573393490);
  p.run(45);
  p.expect(34.207910087, 103.663027493, 6.240776502, -3.217886492);
  p.run(100);
  EXPECT_NEAR(number(p.m.position.x), 115.254112463, 1e-8);
  EXPECT_NEAR(number(p.m.position.y), 100.148600809, 1e-8);
  p.run(100);
  p.expect(211.002774696, 100.025728538, 9.816544558, -1.228466478);
  BookParticle<float> single{
      book_forces(true), {book_ground}, motion<float>({0, 200, 0}, {0, 0, 0})};
  single.run(300);
  EXPECT_NEAR(number(single.m.position.x), 211.0027313, 1e-5);
  EXPECT_NEAR(number(single.m.position.y), 100.0257263, 1e-5);
}

TEST(BookForce, ObstacleHeadOn) {
  EXPECT_NEAR(number(kernels::normal_impulse(D(-10), D(0.6), D(1), D(0.01))), 15.841584158, 1e-9);
  BookWorld world{{book_obstacle({0, 200, 0}, 20)}, 0};
  auto m = motion<double>({0, 220, 0}, {0, -10, 0});
  EXPECT_TRUE(world.step(m));
  EXPECT_NEAR(number(m.velocity.y), 5.841584158, 1e-9);
  EXPECT_NEAR(number(m.position.y), 220.684158416, 1e-9);
}

TEST(BookForce, ObstacleAtAnAngle) {
  BookWorld world{{book_obstacle({0, 200, 0}, 20)}, 0};
  const double at = 20.05 / std::sqrt(2);
  auto m = motion<double>({at, 200 + at, 0}, {0, -10, 0});
  EXPECT_TRUE(world.step(m));
  EXPECT_NEAR(number(m.velocity.x), 7.920792079, 1e-9);
  EXPECT_NEAR(number(m.velocity.y), -2.079207921, 1e-9);
  EXPECT_NEAR(number(m.position.x), 15.004925510, 1e-8);
  EXPECT_NEAR(number(m.position.y), 214.004925510, 1e-8);
}

TEST(BookForce, NotchDependsOnTheOrderOfObstacles) {
  BookWorld world{{book_obstacle({-15, -13, 0}, 20), book_obstacle({15, -13, 0}, 20)}, 0};
  auto m = motion<double>({0, 0, 0}, {0, -10, 0});
  EXPECT_TRUE(world.step(m));
  EXPECT_NEAR(number(m.velocity.x), -0.025723659, 1e-9);
  EXPECT_NEAR(number(m.velocity.y), 3.786597030, 1e-9);
  EXPECT_NEAR(number(m.position.x), -0.025961993, 1e-9);
  EXPECT_EQ(number(world.count.impacts), 2);
}

TEST(BookForce, TunnelsWhereTheSweptResponseHits) {
  const Obstacle small = book_obstacle({0, 98.55, 0}, 0.5);
  BookWorld world{{small}, 9.8};
  auto m = motion<double>({0, 100, 0}, {0, -29, 0});
  EXPECT_FALSE(world.step(m));
  EXPECT_NEAR(number(m.position.y), 97.002, 1e-9);
  EXPECT_FALSE(world.step(m));

  World<double> swept({small});
  swept.dt = 0.1;
  const auto end =
      swept.step_with<integrators::SemiImplicitEuler>(motion<double>({0, 100, 0}, {0, -29, 0}));
  EXPECT_EQ(number(swept.count.impacts), 1);
  EXPECT_GT(number(end.velocity.y), 0);
  EXPECT_GT(number(end.position.y), 98.55 + 0.6);
}

TEST(BookForce, ElasticBouncesGainEnergy) {
  BookWorld world{{plane({0, 100, 0}, {0, 1, 0}, 1)}};
  auto m = motion<double>({0, 120, 0}, {0, 0, 0});
  std::vector<double> apexes;
  double highest = 0;
  while (apexes.size() < 5) {
    if (world.step(m)) {
      apexes.push_back(highest);
      highest = 0;
    }
    highest = std::max(highest, number(m.position.y));
  }
  for (std::size_t i = 1; i < 3; ++i) EXPECT_NEAR(apexes[i], 120.68, 1e-9);
  for (std::size_t i = 3; i < 5; ++i) EXPECT_NEAR(apexes[i], 122.738, 1e-9);
}

TEST(BookForce, AlmostElasticBouncesNeverDecay) {
  BookWorld world({plane({0, 100, 0}, {0, 1, 0}, 0.9)});
  auto m = motion<double>({0, 120, 0}, {0, 0, 0});
  double apex = 0;
  double highest = 0;
  for (int n = 0; n < 20000; ++n) {
    if (world.step(m)) {
      apex = highest;
      highest = 0;
    }
    highest = std::max(highest, number(m.position.y));
  }
  EXPECT_NEAR(apex, 102.5913, 1e-4);
}

TEST(BookImpulse, TurnsTheVelocityAndPushesOut) {
  const std::vector<Obstacle> obstacles{plane({0, 100, 0}, {0, 1, 0}, 0.6, 0.1)};
  const Contact<D> contact(obstacles, {ContactResponse::impulse, 4, true});
  ContactCount<D> count;
  const ParticleRow<D> row{D(1), D(0.1), D(0)};
  auto m = contact.respond(motion<double>({5, 99, 0}, {10, -20, 0}), row, D::Mask(true), count);
  EXPECT_NEAR(number(m.velocity.y), 12, 1e-12);
  EXPECT_NEAR(number(m.velocity.x), 10 - 0.1 * 32, 1e-12);
  EXPECT_NEAR(number(m.position.y), 100.1, 1e-12);
  EXPECT_EQ(number(count.impacts), 1);
  // On its way out it is left alone, and so is a lane that is not active.
  const auto leaving = motion<double>({5, 99, 0}, {10, 20, 0});
  EXPECT_TRUE(same_bits(contact.respond(leaving, row, D::Mask(true), count), leaving));
  const auto dead = motion<double>({5, 99, 0}, {10, -20, 0});
  EXPECT_TRUE(same_bits(contact.respond(dead, row, D::Mask(false), count), dead));
  EXPECT_EQ(number(count.impacts), 1);
}

TEST(BookImpulse, StandsOnAHeightField) {
  // A slope of 3 in 4 along x.
  const std::vector<Obstacle> obstacles{field({0, 0, 0}, 3, 3, 4, {0, 3, 6, 0, 3, 6, 0, 3, 6}, 1)};
  const Contact<D> contact(obstacles, {ContactResponse::impulse, 4, true});
  ContactCount<D> count;
  const ParticleRow<D> row{D(1), D(0), D(0)};
  const auto m = contact.respond(motion<double>({2, 1, 3}, {0, -5, 0}), row, D::Mask(true), count);
  // n = (-3, 4, 0)/5: 0.4 m below the plane; v' = v - 2 (v.n) n.
  EXPECT_NEAR(number(m.velocity.x), -4.8, 1e-12);
  EXPECT_NEAR(number(m.velocity.y), 1.4, 1e-12);
  EXPECT_NEAR(number(m.position.x), 2 - 0.4 * 0.6, 1e-12);
  EXPECT_NEAR(number(m.position.y), 1 + 0.4 * 0.8, 1e-12);
  const auto outside = motion<double>({-1, -1, 3}, {0, -5, 0});
  EXPECT_TRUE(same_bits(contact.respond(outside, row, D::Mask(true), count), outside));
}

// ---- swept: where -------------------------------------------------------------------------------

template <class T>
class Swept : public ::testing::Test {};
using Reals = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Swept, Reals);

// Where a chord from `start` to `end` stops when the first contact rests the particle.
template <class T>
Triple stop(const std::vector<Obstacle>& obstacles, const Triple& start, const Triple& end,
            double radius) {
  World<T> world{obstacles};
  world.radius = radius;
  world.settings.max_impacts = 0;
  return triple(world.resolve(motion<T>(start, {0, 0, 0}), motion<T>(end, {0, 0, 0})).position);
}

TYPED_TEST(Swept, NothingTunnelsThroughThinSolids) {
  using T = TypeParam;
  Draws draws(1);
  // 1000 m/s for up to 1/50 s, against solids of 1 mm: of 10^5 chords all that must meet the solid
  // do, at the place, and none that must not.
  const double coarse = std::numeric_limits<T>::epsilon() * 1000;
  int met = 0;
  for (int k = 0; k < 100000; ++k) {
    const auto shape = static_cast<ObstacleShape>(k % 5);
    const Obstacle o = any_solid(draws, shape, k % 3 == 0 ? 1.0 : 0.001);
    const double radius = representable<T>(k % 2 ? 0.001 : 0);
    const Triple through =
        o.center + draws.vector(0, shape == ObstacleShape::sphere ? o.radius : 1.0);
    const Triple d = draws.vector(1, 20);
    const double part = draws.within(0.02, 0.98);
    Triple start = through - part * d;
    Triple end = through + (1 - part) * d;
    for (std::size_t i = 0; i < 3; ++i) {
      start[i] = representable<T>(start[i]);
      end[i] = representable<T>(end[i]);
    }
    if (gap(o, start, radius) < 1e-4) continue;
    // The gap is convex along the chord: its least value by thirds, then the first zero by halves.
    const auto at = [&](double t) { return gap(o, start + t * (end - start), radius); };
    double low = 0;
    double high = 1;
    for (int i = 0; i < 100; ++i) {
      const double a = low + (high - low) / 3;
      const double b = high - (high - low) / 3;
      (at(a) < at(b) ? high : low) = at(a) < at(b) ? b : a;
    }
    const double least = at(0.5 * (low + high));
    const Triple stopped = stop<T>({o}, start, end, radius);
    const bool hit = stopped != end;
    if (least < -coarse) {
      ASSERT_TRUE(hit) << "chord " << k << " shape " << k % 5 << " deepest " << least;
      ++met;
      double before = 0;
      double inside = 0.5 * (low + high);
      for (int i = 0; i < 60; ++i) {
        const double t = 0.5 * (before + inside);
        (at(t) > 0 ? before : inside) = t;
      }
      EXPECT_NEAR(gap(o, stopped, radius), 0, 0.25 * coarse) << "chord " << k << " shape " << k % 5;
      // A grazing root is as uncertain as the square root of the gap.
      EXPECT_NEAR(length(stopped - start), before * length(end - start), 20 * std::sqrt(coarse));
    } else if (least > coarse) {
      ASSERT_FALSE(hit) << "chord " << k << " shape " << k % 5 << " nearest " << least;
    }
  }
  EXPECT_GT(met, 50000);
}

TYPED_TEST(Swept, NothingTunnelsThroughAHeightField) {
  using T = TypeParam;
  Draws draws(2);
  const double coarse = std::numeric_limits<T>::epsilon() * 1000;
  int met = 0;
  for (int k = 0; k < 1500; ++k) {
    const Obstacle o = field({-4, 0.5, -3}, 17, 13, 0.5, rough_heights(draws, 17 * 13), 0);
    const double radius = k % 2 ? 0.125 : 0;
    Triple start{draws.within(-6, 6), draws.within(-1, 4), draws.within(-6, 6)};
    Triple end{draws.within(-6, 6), draws.within(-3, 3), draws.within(-6, 6)};
    if (k % 5 == 0) end = {start[0], end[1], end[2]};
    if (k % 7 == 0) end = {end[0], end[1], start[2]};
    if (k % 11 == 0) end = {start[0], -3, start[2]};
    for (std::size_t i = 0; i < 3; ++i) {
      start[i] = representable<T>(start[i]);
      end[i] = representable<T>(end[i]);
    }
    if (gap(o, start, radius) < 1e-4) continue;
    // The first crossing from above to below among many samples over the rectangle.
    constexpr int samples = 20000;
    const auto at = [&](double t) { return gap(o, start + t * (end - start), radius); };
    double deepest = 1;
    double first = -1;
    double last_gap = at(0);
    bool below_at_the_border = false;
    for (int i = 1; i <= samples; ++i) {
      const double g = at(static_cast<double>(i) / samples);
      // A jump is the border of the rectangle: the gap outside it is set to 1.
      if (g < 0 && last_gap == 1) below_at_the_border = true;
      if (g < 0 && first < 0) first = static_cast<double>(i - 1) / samples;
      deepest = std::min(deepest, g);
      last_gap = g;
    }
    if (below_at_the_border) continue;
    const Triple stopped = stop<T>({o}, start, end, radius);
    const bool hit = stopped != end;
    if (deepest < -coarse) {
      ASSERT_TRUE(hit) << "chord " << k << " deepest " << deepest;
      ++met;
      double before = first;
      double inside = first + 1.0 / samples;
      for (int i = 0; i < 60; ++i) {
        const double t = 0.5 * (before + inside);
        (at(t) > 0 ? before : inside) = t;
      }
      EXPECT_NEAR(gap(o, stopped, radius), 0, 2 * coarse) << "chord " << k;
      EXPECT_LE(length(stopped - start), before * length(end - start) + 20 * std::sqrt(coarse));
    } else if (deepest > 0.01) {
      ASSERT_FALSE(hit) << "chord " << k << " nearest " << deepest;
    }
  }
  EXPECT_GT(met, 300);
}

TYPED_TEST(Swept, TheEarliestImpactCountsAndTiesGoToTheLowerIndex) {
  using T = TypeParam;
  const Obstacle far = sphere({0, 0, 0}, 1, 0);
  const Obstacle near = sphere({0, 3, 0}, 1, 0);
  for (const auto& order : {std::vector<Obstacle>{far, near}, std::vector<Obstacle>{near, far}}) {
    EXPECT_NEAR(stop<T>(order, {0, 10, 0}, {0, -10, 0}, 0.5)[1], 4.5, 1e-5);
  }
  // The same place twice: restitution tells which one acted.
  World<T> world({plane({0, 0, 0}, {0, 1, 0}, 0.25), plane({0, 0, 0}, {0, 1, 0}, 0.75)});
  world.gravity = 0;
  world.dt = 1;
  world.radius = 0;
  EXPECT_EQ(number(world.step(motion<T>({0, 1, 0}, {0, -2, 0})).velocity.y), 0.5);
  std::swap(world.obstacles[0], world.obstacles[1]);
  EXPECT_EQ(number(world.step(motion<T>({0, 1, 0}, {0, -2, 0})).velocity.y), 1.5);
}

TYPED_TEST(Swept, WithoutContactTheStepIsUntouched) {
  using T = TypeParam;
  World<T> world({plane({0, 0, 0}, {0, 1, 0}, 0.5), sphere({5, 5, 5}, 1, 1)});
  const auto start = motion<T>({0.1, 3.7, 0.3}, {1.3, -2.9, 0.7});
  EXPECT_TRUE(same_bits(world.step(start), fall(start, world.gravity, world.dt)));
  // A lane that is not active passes through everything.
  const auto below = motion<T>({0.1, 0.05, 0.3}, {1.3, -2.9, 0.7});
  const auto after = fall(below, world.gravity, world.dt);
  using V = Lane<T>;
  const auto resolved =
      Contact<V>(world.obstacles, world.settings)
          .resolve(below, after, world.row(), V(world.dt), typename V::Mask(false), world.count);
  EXPECT_TRUE(same_bits(resolved, after));
  EXPECT_EQ(number(world.count.impacts), 0);
}

// ---- swept: what --------------------------------------------------------------------------------

TYPED_TEST(Swept, RemainingTimeGoesOnAfterTheImpact) {
  using T = TypeParam;
  World<T> world({plane({0, 0, 0}, {0, 1, 0}, 0.5, 0.25)});
  world.gravity = 0;
  world.dt = 1;
  world.radius = 0.5;
  // Meets the plane after 3/4 s at (3, -4); leaves at (3 - 0.25 (4 + 2), 2).
  const auto m = world.step(motion<T>({0, 3.5, 0}, {3, -4, 0}));
  EXPECT_EQ(number(m.velocity.x), 1.5);
  EXPECT_EQ(number(m.velocity.y), 2);
  EXPECT_EQ(number(m.position.x), 2.25 + 0.25 * 1.5);
  EXPECT_EQ(number(m.position.y), 1);
  EXPECT_EQ(number(world.count.impacts), 1);
  EXPECT_EQ(number(world.count.rests), 0);
}

TYPED_TEST(Swept, FourImpactsAStepAndTheFifthRests) {
  using T = TypeParam;
  // Two walls 1 m apart, 10 m of way in a step.
  World<T> world({plane({0, 0, 0}, {1, 0, 0}, 1), plane({1, 0, 0}, {-1, 0, 0}, 1)});
  world.gravity = 0;
  world.dt = 1;
  world.radius = 0;
  auto m = world.step(motion<T>({0.5, 0, 0}, {4, 1, 0}));
  EXPECT_EQ(number(world.count.impacts), 4);
  EXPECT_EQ(number(world.count.rests), 0);
  EXPECT_NEAR(number(m.position.x), 0.5, 1e-6);
  EXPECT_NEAR(number(m.position.y), 1, 1e-6);
  EXPECT_EQ(number(m.velocity.x), 4);
  m = world.step(motion<T>({0.5, 0, 0}, {10, 1, 0}));
  EXPECT_EQ(number(world.count.rests), 1);
  EXPECT_EQ(number(world.count.impacts), 9);
  EXPECT_NEAR(number(m.position.x), 1, 1e-6);
  EXPECT_NEAR(number(m.position.y), 0.45, 1e-6);
  EXPECT_EQ(number(m.velocity.x), 0);
  EXPECT_EQ(number(m.velocity.y), 1);
}

TYPED_TEST(Swept, AParticleThatFallsBackWithinTheStepHops) {
  using T = TypeParam;
  // From 1 m at g = 8: 4 m/s down, 2 up, 1/2 s later 2 down, 1 up. The chord to y = -2.61 meets the
  // ground after 0.2632 s, which leaves 0.1868 s for the second flight.
  World<T> world({plane({0, 0, 0}, {0, 1, 0}, 0.5)});
  world.gravity = 8;
  world.radius = 0;
  world.dt = 0.95;
  const auto m = world.step(motion<T>({0, 1, 0}, {0, 0, 0}));
  const double left = 0.95 - 0.95 / 3.61 - 0.5;
  EXPECT_EQ(number(world.count.impacts), 2);
  EXPECT_EQ(number(world.count.rests), 0);
  EXPECT_NEAR(number(m.velocity.y), 1 - 8 * left, 1e-5);
  EXPECT_NEAR(number(m.position.y), left - 4 * left * left, 1e-6);
  EXPECT_NEAR(world.energy(m), 0.5, 1e-6);
  // Twice the step would take more impacts than there are: the particle is laid down.
  world.dt = 1.9;
  const auto rested = world.step(motion<T>({0, 1, 0}, {0, 0, 0}));
  EXPECT_EQ(number(world.count.rests), 1);
  EXPECT_EQ(number(rested.velocity.y), 0);
  EXPECT_NEAR(number(rested.position.y), 0, 1e-6);
}

TYPED_TEST(Swept, EffectiveRestitutionOfALightObstacle) {
  using T = TypeParam;
  World<T> world({sphere({0, 200, 0}, 20, 0.6)});
  world.obstacles[0].mass = 100;
  world.gravity = 0;
  world.dt = 0.1;
  const auto m = world.step(motion<T>({0, 220.5, 0}, {0, -10, 0}));
  EXPECT_NEAR(number(m.velocity.y), 5.841584158, 1e-5);
  // An obstacle too light to turn the particle back is still not entered.
  world.obstacles[0].mass = 0.5;
  const auto stopped = world.step(motion<T>({0, 220.5, 0}, {0, -10, 0}));
  EXPECT_NEAR(number(stopped.velocity.y), 0, 1e-5);
  EXPECT_NEAR(number(stopped.position.y), 220.1, 1e-4);
}

TYPED_TEST(Swept, AContactNeverAddsKineticEnergy) {
  using T = TypeParam;
  Draws draws(3);
  // Up to four impacts, two roundings each.
  const double rounding = 8 * static_cast<double>(std::numeric_limits<T>::epsilon());
  for (int k = 0; k < 20000; ++k) {
    World<T> world;
    world.gravity = 0;
    world.dt = 0.05;
    const double e = k % 3 == 0 ? 1.0 : draws.within(0, 1);
    for (int i = 0; i < 3; ++i) {
      Obstacle o = any_solid(draws, static_cast<ObstacleShape>((k + i) % 5), 1);
      o.restitution = e;
      o.friction = k % 2 ? draws.within(0, 1) : 0;
      if (k % 5 == 0) o.mass = draws.within(0.1, 10);
      world.obstacles.push_back(o);
    }
    const Triple at{draws.within(-4, 4), draws.within(-4, 4), draws.within(-4, 4)};
    const auto before = motion<T>(at, draws.vector(1, 200));
    const auto after = world.step(before);
    ASSERT_LE(world.kinetic(after), world.kinetic(before) * (1 + rounding)) << k;
  }
}

// Total energy and penetration among many obstacles, in closed rooms.
template <class T>
void check_room(bool rough_ground, double dt, double e, double mu, std::uint64_t seed) {
  Draws draws(seed);
  World<T> world;
  world.dt = dt;
  world.obstacles.push_back(rough_ground
                                ? field({-10, -4, -10}, 21, 21, 1, rough_heights(draws, 21 * 21), e)
                                : plane({0, -4, 0}, {0, 1, 0}, e));
  for (const double side : {-1.0, 1.0}) {
    world.obstacles.push_back(plane({5 * side, 0, 0}, {-side, 0, 0}, e));
    world.obstacles.push_back(plane({0, 0, 5 * side}, {0, 0, -side}, e));
  }
  for (int i = 0; i < 6; ++i) {
    world.obstacles.push_back(any_solid(draws, static_cast<ObstacleShape>(1 + i % 4), 1));
  }
  for (Obstacle& o : world.obstacles) {
    o.restitution = e;
    o.friction = mu;
  }
  const double epsilon = static_cast<double>(std::numeric_limits<T>::epsilon());
  for (int particle = 0; particle < 5; ++particle) {
    Triple at{};
    bool free = false;
    while (!free) {
      at = {draws.within(-4, 4), draws.within(-2, 4), draws.within(-4, 4)};
      free = true;
      for (const Obstacle& o : world.obstacles) free = free && gap(o, at, world.radius) > 0.01;
    }
    auto m = motion<T>(at, draws.vector(0, 20));
    const double budget = world.energy(m) + world.gravity * 10;
    for (int n = 0; n < 500; ++n) {
      const auto next = world.step(m);
      ASSERT_LE(world.energy(next) - world.energy(m), 8 * epsilon * budget)
          << "step " << n << " of particle " << particle;
      for (const Obstacle& o : world.obstacles) {
        ASSERT_GE(gap(o, triple(next.position), world.radius), -1e4 * epsilon)
            << "step " << n << " shape " << static_cast<int>(o.shape);
      }
      m = next;
    }
  }
}

TYPED_TEST(Swept, EnergyNeverGrowsAndNothingIsEntered) {
  std::uint64_t seed = 10;
  for (const bool rough : {false, true}) {
    for (const double dt : {0.001, 0.01, 0.1}) {
      for (const double e : {0.0, 0.5, 1.0}) {
        for (const double mu : {0.0, 0.3}) {
          SCOPED_TRACE("rough " + std::to_string(rough) + " dt " + std::to_string(dt) + " e " +
                       std::to_string(e) + " mu " + std::to_string(mu));
          check_room<TypeParam>(rough, dt, e, mu, ++seed);
          if (this->HasFatalFailure()) return;
        }
      }
    }
  }
}

// The largest relative deviation of the energy over 10^4 elastic bounces.
template <class T, class Step>
double energy_drift(World<T> world, Motion<Lane<T>> m, const Step& step) {
  const double start = world.energy(m);
  double worst = 0;
  while (number(world.count.impacts) < 1e4) {
    m = step(world, m);
    worst = std::max(worst, std::abs(world.energy(m) / start - 1));
  }
  EXPECT_EQ(number(world.count.rests), 0);
  return worst;
}

TYPED_TEST(Swept, ElasticBouncesKeepTheEnergy) {
  using T = TypeParam;
  const double allowed = sizeof(T) == 4 ? 1e-5 : 1e-12;
  const auto verlet = [](World<T>& world, const Motion<Lane<T>>& m) {
    return world.template step_with<integrators::VelocityVerlet>(m);
  };
  World<T> world({plane({0, 0, 0}, {0, 1, 0}, 1)});
  world.radius = 0;
  // g dt is a short number, as the velocity adds it up: the error is that of the bounces.
  for (const auto& [gravity, dt, height] :
       {std::array{8.0, 0.015625, 1.0}, std::array{10.0, 0.5, 4.0}, std::array{9.75, 0.5, 10.0},
        std::array{9.75, 0.75, 7.0}}) {
    world.gravity = gravity;
    world.dt = dt;
    const double drift = energy_drift(world, motion<T>({0, height, 0}, {0, 0, 0}), verlet);
    EXPECT_LT(drift, allowed) << "g " << gravity << " dt " << dt;
    this->RecordProperty("drift at g " + std::to_string(gravity), std::to_string(drift));
  }
}

TEST(SweptDouble, ElasticBouncesKeepTheEnergyAtAnyStep) {
  const auto step = [](World<double>& world, const Motion<D>& m) { return world.step(m); };
  for (const double dt : {0.1, 0.05, 0.01, 0.004}) {
    for (const Triple& n : {Triple{0, 1, 0}, Triple{0.6, 0.8, 0}, Triple{-0.3, 0.7, 0.2}}) {
      // The plane and its mirror image: a valley.
      World<double> world({plane({0, 0, 0}, n, 1), plane({0, 0, 0}, {-n[0], n[1], -n[2]}, 1)});
      world.gravity = 9.80665;
      world.dt = dt;
      EXPECT_LT(energy_drift(world, motion<double>({0.4, 3, 0.1}, {0, 0, 0}), step), 1e-12)
          << "dt " << dt << " normal " << n[0];
    }
  }
}

// ---- swept: sliding and rest --------------------------------------------------------------------

template <class Integrator, class T>
void expect_rest(World<T> world, Motion<Lane<T>> m, int settle, const std::string& what) {
  for (int n = 0; n < settle; ++n) m = world.template step_with<Integrator>(m);
  const auto settled = m;
  world.count = {};
  for (int n = 0; n < 1000; ++n) {
    m = world.template step_with<Integrator>(m);
    ASSERT_TRUE(same_bits(m, settled)) << what << ", step " << n;
  }
  EXPECT_EQ(number(world.count.impacts), 0) << what;
  EXPECT_EQ(number(world.count.rests), 0) << what;
}

template <class Integrator, class T>
void expect_rest_everywhere(const std::string& integrator) {
  for (const double dt : {0.1, 0.01, 0.001, 1e-5}) {
    for (const double level : {0.0, 0.1, 100.0, -37.3}) {
      const auto rests = [&, dt, level](std::vector<Obstacle> obstacles, const Triple& at,
                                        const std::string& where) {
        World<T> world(std::move(obstacles));
        world.dt = dt;
        expect_rest<Integrator>(world, motion<T>({at[0], level + at[1], at[2]}, {0, 0, 0}), 6000,
                                integrator + ", dt " + std::to_string(dt) + ", level " +
                                    std::to_string(level) + ", " + where);
      };
      const double drop = dt < 1e-4 ? 1e-4 : 0.01;
      rests({plane({0, level, 0}, {0, 1, 0}, 0.5, 0.3)}, {0.3, 0.1 + drop, 0.7}, "ground");
      // Friction holds it: tan = 0.25 < 0.3.
      rests({plane({0, level, 0}, {-0.25, 1, 0.05}, 0.3, 0.3)}, {0.01, 0.105 + drop, 0}, "slope");
      Obstacle box;
      box.shape = ObstacleShape::box;
      box.center = {0, level, 0};
      box.restitution = 0.4;
      box.friction = 0.2;
      rests({box}, {0.3, 1.1 + drop, 0.7}, "box");
      if (dt > 1e-4) {
        rests({plane({0, level, 0}, {-0.6, 0.8, 0}, 0.2, 0.1),
               plane({0, level, 0}, {0.6, 0.8, 0}, 0.2, 0.1)},
              {0, 0.125 + drop, 0}, "valley");
        rests({field({-1, level, -1}, 3, 3, 1, {1, 1, 1, 1, 0, 1, 1, 1, 1}, 0.2, 0.3)},
              {0.01, 0.12 + drop, 0.03}, "pit");
      }
      if (::testing::Test::HasFatalFailure()) return;
    }
  }
}

TYPED_TEST(Swept, AParticleAtRestStaysBitForBit) {
  expect_rest_everywhere<integrators::ExplicitEuler, TypeParam>("explicit Euler");
  expect_rest_everywhere<integrators::SemiImplicitEuler, TypeParam>("semi-implicit Euler");
  expect_rest_everywhere<integrators::ImprovedEuler, TypeParam>("improved Euler");
  expect_rest_everywhere<integrators::RungeKutta4, TypeParam>("Runge-Kutta");
  expect_rest_everywhere<integrators::VelocityVerlet, TypeParam>("velocity Verlet");
}

TYPED_TEST(Swept, FrictionStopsASlidingParticle) {
  using T = TypeParam;
  World<T> world({plane({0, 0, 0}, {0, 1, 0}, 0.5, 0.25)});
  auto m = motion<T>({0, 0.1, 0}, {4, 0, 3});
  // v^2/(2 mu g) = 25/4.9 m after v/(mu g) = 2.04 s.
  for (int n = 0; n < 200; ++n) m = world.step(m);
  EXPECT_NEAR(length(triple(m.velocity)), 5 - 0.25 * 9.8 * 2, 1e-3);
  for (int n = 0; n < 10; ++n) m = world.step(m);
  EXPECT_EQ(length(triple(m.velocity)), 0);
  EXPECT_NEAR(std::hypot(number(m.position.x), number(m.position.z)), 25 / 4.9, 1e-3);
  EXPECT_NEAR(number(m.position.z) / number(m.position.x), 0.75, 1e-4);
  EXPECT_NEAR(number(m.position.y), 0.1, 1e-6);
}

TYPED_TEST(Swept, SlidesDownASlope) {
  using T = TypeParam;
  for (const double mu : {0.0, 0.5}) {
    World<T> world({plane({0, 0, 0}, {0.6, 0.8, 0}, 0, mu)});
    auto m = motion<T>({0.6 * 0.1, 0.8 * 0.1, 0}, {0, 0, 0});
    for (int n = 0; n < 100; ++n) m = world.step(m);
    // a = g (sin - mu cos), down the slope.
    const double a = 9.8 * (0.6 - mu * 0.8);
    EXPECT_NEAR(length(triple(m.velocity)), a, 2e-4 * a);
    EXPECT_NEAR(number(m.position.x), 0.06 + 0.8 * a / 2, 2e-4 * a);
    EXPECT_NEAR(gap(world.obstacles[0], triple(m.position), 0.1), 0, 1e-5);
  }
}

TYPED_TEST(Swept, SlidesAlongAValley) {
  using T = TypeParam;
  // A gutter of two planes, falling 1 in 10 along x: along it the particle is free.
  World<T> world({plane({0, 0, 0}, {0.1, 1, 0.5}, 0), plane({0, 0, 0}, {0.1, 1, -0.5}, 0)});
  std::vector<double> heights;
  for (int j = 0; j < 21; ++j) {
    for (int i = 0; i < 61; ++i) heights.push_back(0.5 * std::abs(j - 10) - 0.1 * i);
  }
  World<T> terrain({field({0, 0, -10}, 61, 21, 1, heights, 0)});
  for (World<T>* w : {&world, &terrain}) {
    auto m = motion<T>({1, -0.1 + 0.3, 0.1}, {0, 0, 0});
    for (int n = 0; n < 800; ++n) m = w->step(m);
    const double slope = 9.8 * 0.1 / std::sqrt(1.01);
    EXPECT_NEAR(length(triple(m.velocity)), slope * 8, 0.05 * slope * 8);
    EXPECT_NEAR(number(m.position.z), 0, 1e-4);
    EXPECT_GT(number(m.position.x), 28);
  }
}

TYPED_TEST(Swept, BounceOnAHeightFieldIsTheMirrorImage) {
  using T = TypeParam;
  World<T> world({field({0, 0, 0}, 3, 3, 4, {0, 3, 6, 0, 3, 6, 0, 3, 6}, 1)});
  world.gravity = 0;
  world.dt = 1;
  world.radius = 0.5;
  // Over x = 4 the raised surface is at 3.5; n = (-3, 4, 0)/5 sends -y to (-0.96, 0.28).
  const auto m = world.step(motion<T>({4, 5.5, 2}, {0, -4, 0}));
  EXPECT_NEAR(number(m.velocity.x), -3.84, 1e-5);
  EXPECT_NEAR(number(m.velocity.y), 1.12, 1e-5);
  EXPECT_NEAR(number(m.position.x), 4 - 0.5 * 3.84, 1e-5);
  EXPECT_NEAR(number(m.position.y), 3.5 + 0.5 * 1.12, 1e-5);
}

TYPED_TEST(Swept, NonFiniteLanesComeToAnEnd) {
  using T = TypeParam;
  Draws draws(5);
  World<T> world({plane({0, 0, 0}, {0, 1, 0}, 0.5), sphere({0, 0, 0}, 1, 1),
                  field({-1, 0, -1}, 3, 3, 1, rough_heights(draws, 9), 1)});
  const double inf = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {inf, -inf, nan}) {
    for (std::size_t i = 0; i < 3; ++i) {
      Triple p{0.1, 0.2, 0.3};
      Triple v{1, -1, 1};
      p[i] = bad;
      world.step(motion<T>(p, v));
      v[i] = bad;
      world.step(motion<T>({0.1, 0.2, 0.3}, v));
    }
  }
}

}  // namespace
}  // namespace salvo::tests
