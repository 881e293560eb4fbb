// The five integrators: orders of convergence against exact solutions, Table 7-1 of the book to
// every printed digit, and the stability that chapter 7 describes.   [Bourg &
// Bywalec 1.5, 4.1, 7.1-7.3]
#include "integrators/fixed_step.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "integrators/fixed_step.hpp"

namespace salvo::tests {

namespace {

using integrators::ExplicitEuler;
using integrators::ImprovedEuler;
using integrators::RungeKutta4;
using integrators::SemiImplicitEuler;
using integrators::VelocityVerlet;
using kernels::Instant;
using kernels::Motion;
using kernels::Vec3;

template <class T>
using Lane = kernels::ScalarLane<T>;

// One dimension: position and velocity along x.
struct Line {
  double position = 0;
  double velocity = 0;
};

// Takes `steps` steps of v' = acceleration(x, v).
template <class Integrator, class T = double, class Acceleration>
Line advance(Line start, double dt, int steps, const Acceleration& acceleration) {
  using V = Lane<T>;
  const V zero(0);
  Motion<V> state{{V(start.position), zero, zero}, {V(start.velocity), zero, zero}};
  for (int i = 0; i < steps; ++i) {
    state = Integrator::step(state, V(dt), [&](Vec3<V> x, Vec3<V> v, Instant) {
      return Vec3<V>{V(acceleration(x.x.value(), v.x.value())), zero, zero};
    });
  }
  return {static_cast<double>(state.position.x.value()),
          static_cast<double>(state.velocity.x.value())};
}

// Calls test.operator()<Integrator>(name, order) for each of the five.
template <class Test>
void for_each_integrator(Test&& test) {
  test.template operator()<ExplicitEuler>("explicit Euler", 1);
  test.template operator()<SemiImplicitEuler>("semi-implicit Euler", 1);
  test.template operator()<ImprovedEuler>("improved Euler", 2);
  test.template operator()<VelocityVerlet>("velocity Verlet", 2);
  test.template operator()<RungeKutta4>("Runge-Kutta", 4);
}

// The order observed between dt = 1/steps and half of it, over one second.
template <class Integrator, class Acceleration>
double observed_order(Line start, Line exact, int steps, const Acceleration& acceleration) {
  const auto error = [&](int count) {
    const Line end = advance<Integrator>(start, 1.0 / count, count, acceleration);
    return std::hypot(end.position - exact.position, end.velocity - exact.velocity);
  };
  return std::log2(error(steps) / error(2 * steps));
}

}  // namespace

TEST(Order, OnAnOscillator) {
  constexpr double w = 3;
  const Line exact{std::cos(w), -w * std::sin(w)};
  for_each_integrator([&]<class Integrator>(const char* name, int order) {
    EXPECT_NEAR(
        observed_order<Integrator>({1, 0}, exact, 200, [](double x, double) { return -w * w * x; }),
        order, 0.05)
        << name;
  });
}

TEST(Order, OnLinearDragAndAForce) {
  constexpr double k = 1.5;
  constexpr double f = -9.8;
  const double e = std::exp(-k);
  const Line exact{f / k + (4 - f / k) * (1 - e) / k, f / k + (4 - f / k) * e};
  for_each_integrator([&]<class Integrator>(const char* name, int order) {
    EXPECT_NEAR(
        observed_order<Integrator>({0, 4}, exact, 200, [](double, double v) { return f - k * v; }),
        order, 0.05)
        << name;
  });
}

TEST(Order, OnQuadraticDragFall) {
  constexpr double g = 9.8;
  constexpr double vt = 5;
  const Line exact{vt * vt / g * std::log(std::cosh(g / vt)), vt * std::tanh(g / vt)};
  for_each_integrator([&]<class Integrator>(const char* name, int order) {
    EXPECT_NEAR(observed_order<Integrator>(
                    {0, 0}, exact, 200,
                    [](double, double v) { return g - g / (vt * vt) * v * std::abs(v); }),
                order, 0.06)
        << name;
  });
}

// The force is asked for at the instants that it is for: x'' = t, x = t^3/6, needs them right.
TEST(Order, OnAForceThatDependsOnTimeAlone) {
  for_each_integrator([]<class Integrator>(const char* name, int order) {
    const auto velocity_error = [](int steps) {
      using V = Lane<double>;
      const double dt = 1.0 / steps;
      const V zero(0);
      Motion<V> state{{zero, zero, zero}, {zero, zero, zero}};
      for (int n = 0; n < steps; ++n) {
        state = Integrator::step(state, V(dt), [&](Vec3<V>, Vec3<V>, Instant instant) {
          const double t = (n + 0.5 * static_cast<int>(instant)) * dt;
          return Vec3<V>{zero, V(std::exp(t)), zero};
        });
      }
      return std::abs(state.velocity.y.value() - (std::exp(1.0) - 1));
    };
    EXPECT_NEAR(std::log2(velocity_error(50) / velocity_error(100)), order, 0.05) << name;
  });
}

TEST(ConstantAcceleration, IsExactForTheMethodsOfHigherOrder) {
  const auto fall = [](double, double) { return -9.75; };  // every intermediate value is exact
  for (const Line end : {advance<ImprovedEuler>({2, 3}, 0.125, 33, fall),
                         advance<RungeKutta4>({2, 3}, 0.125, 33, fall),
                         advance<VelocityVerlet>({2, 3}, 0.125, 33, fall)}) {
    constexpr double t = 33 * 0.125;
    EXPECT_NEAR(end.position, 2 + 3 * t - 9.75 * t * t / 2, 1e-12);
    EXPECT_NEAR(end.velocity, 3 - 9.75 * t, 1e-12);
  }
}

// 1.5: the distance that v = 2t covers in 4 s, 16 m, as a sum over n steps
TEST(FiniteSum, ErrsBy16OverN) {
  const auto distance = []<class Integrator>(int n, Integrator) {
    return advance<Integrator>({0, 0}, 4.0 / n, n, [](double, double) { return 2.0; }).position;
  };
  EXPECT_EQ(distance(4, ExplicitEuler{}), 12);
  EXPECT_NEAR(distance(40, ExplicitEuler{}), 15.6, 1e-12);
  EXPECT_NEAR(distance(400, ExplicitEuler{}), 15.96, 1e-12);
  // With the speed in the middle of each step, here the mean of its ends, none is left.
  EXPECT_EQ(distance(4, VelocityVerlet{}), 16);
  EXPECT_EQ(distance(4, ImprovedEuler{}), 16);
}

// ---- 7.2: the boat, T - C v = m a
// -----------------------------------------------------------------

namespace {

constexpr double thrust = 20000;
constexpr double drag = 1000;
constexpr double mass = 10000;
constexpr double boat_dt = 0.5;

template <class T>
T boat(T, T v) {
  return static_cast<T>((T(thrust) - T(drag) * v) / T(mass));
}

double exact_speed(double t) { return 20 * (1 - std::exp(-t / 10)); }
double exact_distance(double t) { return 20 * t + 200 * std::exp(-t / 10) - 200; }

template <class Integrator, class T = double>
Line sail(double t, double dt = boat_dt) {
  return advance<Integrator, T>({0, 0}, dt, static_cast<int>(std::lround(t / dt)), boat<T>);
}

std::string seven_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.7g", value);
  return text;
}

std::string percent(double value, const char* format) {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

double error_percent(double value, double t) { return 100 * (value / exact_speed(t) - 1); }

// The mean of the errors at 6.5, 7, .. 8.5 s.
template <class Integrator, class T = double>
double average_error() {
  double sum = 0;
  for (double t = 6.5; t <= 8.5; t += 0.5) {
    sum += std::abs(error_percent(sail<Integrator, T>(t).velocity, t));
  }
  return sum / 5;
}

}  // namespace

TEST(Table7_1, EveryPrintedDigit) {
  struct Row {
    double t;
    const char* exact;
    const char* euler;
    const char* error;
  };
  const Row rows[] = {{6.5, "9.559084", "9.733158", "1.82"},
                      {7, "10.06829", "10.2465", "1.77"},
                      {7.5, "10.55267", "10.73418", "1.72"},
                      {8, "11.01342", "11.19747", "1.67"},
                      {8.5, "11.4517", "11.63759", "1.62"}};
  for (const Row& row : rows) {
    const double euler = sail<ExplicitEuler>(row.t).velocity;
    EXPECT_EQ(seven_digits(exact_speed(row.t)), row.exact);
    EXPECT_EQ(seven_digits(euler), row.euler);
    EXPECT_EQ(percent(error_percent(euler, row.t), "%.2f"), row.error);
    // The speed does not depend on the position, so both Euler methods have the same.
    EXPECT_EQ(sail<SemiImplicitEuler>(row.t).velocity, euler);
  }
}

TEST(Table7_1, EveryMethodToTenDigits) {
  struct Row {
    double t, exact, euler, improved, runge_kutta;
  };
  const Row rows[] = {{6.5, 9.559084464780, 9.7331583344, 9.5561481446, 9.5590840963},
                      {7, 10.068293924172, 10.2465004177, 10.0652859226, 10.0682935467},
                      {7.5, 10.552668945180, 10.7341753968, 10.5496032338, 10.5526685604},
                      {8, 11.013420717656, 11.1974666270, 11.0103100762, 11.0134203273},
                      {8.5, 11.451701361025, 11.6375932956, 11.4485574600, 11.4517009665}};
  for (const Row& row : rows) {
    EXPECT_NEAR(exact_speed(row.t), row.exact, 6e-13);
    EXPECT_NEAR(sail<RungeKutta4>(row.t, 0.01).velocity, row.exact, 1e-12);
    EXPECT_NEAR(sail<ExplicitEuler>(row.t).velocity, row.euler, 5.1e-11);
    EXPECT_NEAR(sail<ImprovedEuler>(row.t).velocity, row.improved, 5.1e-11);
    EXPECT_NEAR(sail<RungeKutta4>(row.t).velocity, row.runge_kutta, 5.1e-11);
  }
}

TEST(Table7_1, ErrorsInPercent) {
  struct Row {
    double t, euler, improved, runge_kutta;
  };
  const Row rows[] = {{6.5, 1.821, -0.03072, -3.855e-6},
                      {7, 1.770, -0.02988, -3.749e-6},
                      {7.5, 1.720, -0.02905, -3.646e-6},
                      {8, 1.671, -0.02824, -3.545e-6},
                      {8.5, 1.623, -0.02745, -3.445e-6}};
  for (const Row& row : rows) {
    const auto error = [&](Line end) { return error_percent(end.velocity, row.t); };
    EXPECT_NEAR(error(sail<ExplicitEuler>(row.t)), row.euler, 5.1e-4);
    EXPECT_NEAR(error(sail<ImprovedEuler>(row.t)), row.improved, 5.1e-6);
    EXPECT_NEAR(error(sail<RungeKutta4>(row.t)), row.runge_kutta, 5.1e-10);
  }
}

TEST(Table7_1, AverageErrors) {
  EXPECT_EQ(percent(average_error<ExplicitEuler>(), "%.2f"), "1.72");
  EXPECT_EQ(percent(average_error<ImprovedEuler>(), "%.2f"), "0.03");
  EXPECT_EQ(percent(average_error<RungeKutta4>(), "%.1e"), "3.6e-06");
  EXPECT_NEAR(average_error<ExplicitEuler>(), 1.721078, 5e-7);
  EXPECT_NEAR(average_error<ImprovedEuler>(), 0.0290686, 5e-8);
  EXPECT_NEAR(average_error<RungeKutta4>(), 3.648110e-6, 5e-12);
  // float cannot resolve the last.
  EXPECT_NEAR((average_error<ExplicitEuler, float>()), 1.72107, 1e-4);
  EXPECT_NEAR((average_error<ImprovedEuler, float>()), 0.029065, 2e-5);
  EXPECT_LT((average_error<RungeKutta4, float>()), 1e-4);
  EXPECT_NEAR((average_error<RungeKutta4, float>()), 1.306e-5, 5e-9);
}

TEST(Boat, FollowsTheClosedFormOfEachMethod) {
  constexpr double q =
      1 - 0.05 + 0.05 * 0.05 / 2 - 0.05 * 0.05 * 0.05 / 6 + 0.05 * 0.05 * 0.05 * 0.05 / 24;
  for (const int n : {1, 3, 17, 99}) {
    EXPECT_NEAR(sail<ExplicitEuler>(n * boat_dt).velocity, 20 * (1 - std::pow(0.95, n)), 1e-12);
    EXPECT_NEAR(sail<ImprovedEuler>(n * boat_dt).velocity, 20 * (1 - std::pow(0.95125, n)), 1e-12);
    EXPECT_NEAR(sail<RungeKutta4>(n * boat_dt).velocity, 20 * (1 - std::pow(q, n)), 1e-12);
  }
}

TEST(Boat, OrderOfTheSpeedAt8Seconds) {  // with steps of 0.5, 0.25 and 0.125 s and half of them
  const auto expect = []<class Integrator>(Integrator, std::array<double, 3> orders) {
    const auto error = [](double dt) {
      return std::abs(sail<Integrator>(8, dt).velocity - exact_speed(8));
    };
    double dt = 0.5;
    for (const double order : orders) {
      EXPECT_NEAR(std::log2(error(dt) / error(dt / 2)), order, 0.006) << dt;
      dt /= 2;
    }
  };
  expect(ExplicitEuler{}, {1.02, 1.01, 1.00});
  expect(ImprovedEuler{}, {2.03, 2.01, 2.01});
  expect(RungeKutta4{}, {4.03, 4.02, 4.01});
}

// Position and velocity are one state. The book's listings advance the position with the new
// velocity, which is of first order whatever the method: 5.1 % too far.
TEST(Boat, DistanceIsOfTheMethodsOrderToo) {
  const auto of_the_listing = []<class Integrator>(Integrator) {
    double distance = 0;
    for (int n = 1; n <= 17; ++n) distance += sail<Integrator>(n * boat_dt).velocity * boat_dt;
    return distance;
  };
  EXPECT_NEAR(of_the_listing(ImprovedEuler{}), 58.303177, 5.1e-7);
  EXPECT_NEAR(of_the_listing(RungeKutta4{}), 58.322053, 5.1e-7);
  EXPECT_NEAR(of_the_listing(RungeKutta4{}) / sail<RungeKutta4>(8.5).position, 1.051, 5e-4);
  EXPECT_NEAR(exact_distance(8.5), 55.482986390, 5e-10);
  EXPECT_NEAR(sail<ExplicitEuler>(8.5).position, 53.624067, 5e-7);
  EXPECT_NEAR(sail<SemiImplicitEuler>(8.5).position, 59.442864, 5e-7);  // the book's Euler listing
  EXPECT_NEAR(sail<ImprovedEuler>(8.5).position, 55.514425400, 5e-10);
  EXPECT_NEAR(sail<RungeKutta4>(8.5).position, 55.482990335, 5e-10);
}

// SH1 and SH3: the exact solution, which Runge-Kutta follows at small steps.
TEST(Boat, MatchesTheTableOf4_1) {
  struct Row {
    double t, v, s;
  };
  const Row rows[] = {{1, 1.903251639, 0.967483607},     {5, 7.869386806, 21.306131943},
                      {10, 12.642411177, 73.575888234},  {20, 17.293294335, 227.067056647},
                      {30, 19.004258633, 409.957413674}, {40, 19.633687222, 603.663127778},
                      {50, 19.865241060, 801.347589400}, {60, 19.950424956, 1000.495750435}};
  for (const Row& row : rows) {
    const Line end = sail<RungeKutta4>(row.t, 0.01);
    EXPECT_NEAR(end.velocity, row.v, 1e-8) << row.t;
    EXPECT_NEAR(end.position, row.s, 1e-8) << row.t;
  }
  const Line coasting = advance<RungeKutta4>({100, 25}, 0.01, 1000, boat<double>);
  EXPECT_NEAR(coasting.velocity, 21.839397206, 1e-8);
  EXPECT_NEAR(coasting.position, 331.606027941, 1e-8);
}

TEST(Boat, ErrorsAt30SecondsFallWithTheStep) {  // SH4
  struct Row {
    double dt, euler, improved, runge_kutta;
  };
  const Row rows[] = {{1, 0.147918, 5.3815e-3, 2.7060e-6},
                      {0.5, 0.074345, 1.2931e-3, 1.6221e-7},
                      {0.25, 0.037260, 3.1711e-4, 9.929e-9}};
  const auto error = [](Line end) { return std::abs(end.velocity - exact_speed(30)); };
  for (const Row& row : rows) {
    EXPECT_NEAR(error(sail<ExplicitEuler>(30, row.dt)), row.euler, 1e-6);
    EXPECT_NEAR(error(sail<ImprovedEuler>(30, row.dt)), row.improved, 1e-7);
    EXPECT_NEAR(error(sail<RungeKutta4>(30, row.dt)), row.runge_kutta, row.runge_kutta * 1e-3);
  }
  const auto off = [](Line end) { return std::abs(end.position - exact_distance(30)); };
  EXPECT_NEAR(off(sail<ExplicitEuler>(30, 1)), 1.4792, 5e-5);
  EXPECT_NEAR(off(sail<SemiImplicitEuler>(30, 1)), 17.673, 5e-4);
}

TEST(Boat, IsStableUpToTheMethodsLimit) {  // SH5 and 7.2
  const auto speed = []<class Integrator>(double dt, int steps, Integrator) {
    return advance<Integrator>({0, 0}, dt, steps, boat<double>).velocity;
  };
  EXPECT_NEAR(speed(10, 1, ExplicitEuler{}), 20, 1e-12);
  EXPECT_NEAR(speed(19, 999, ExplicitEuler{}), 20, 1e-9);
  EXPECT_NEAR(speed(19, 999, ImprovedEuler{}), 20, 1e-9);
  for (int n = 0; n < 9; ++n) {
    EXPECT_EQ(speed(20, n, ExplicitEuler{}), n % 2 == 0 ? 0 : 40);
    // Each step multiplies 20 - v by 1 - 2 + 2 = 1: neither closer nor away.
    EXPECT_EQ(speed(20, n, ImprovedEuler{}), 0);
  }
  EXPECT_GT(std::abs(speed(21, 333, ExplicitEuler{})), 1e12);
  EXPECT_GT(std::abs(speed(21, 333, ImprovedEuler{})), 1e12);
  EXPECT_GT(std::abs(speed(25, 99, ExplicitEuler{})), 1e12);
  EXPECT_NEAR(speed(27, 999, RungeKutta4{}), 20, 1e-9);
  EXPECT_GT(std::abs(speed(28, 9999, RungeKutta4{})), 1e12);
  // At 2.785294 m/C a step leaves 20 - v as it is.
  EXPECT_NEAR(1 - speed(27.85294, 1, RungeKutta4{}) / 20, 1, 1e-6);
  EXPECT_NEAR(speed(27.85, 99'999, RungeKutta4{}), 20, 1e-9);
  EXPECT_GT(std::abs(speed(27.86, 99'999, RungeKutta4{})), 1e12);
}

TEST(Boat, OfQuadraticDragHasTheSameTerminalSpeed) {  // SH6
  struct Row {
    double t, v, s;
  };
  const Row rows[] = {{5, 9.242343145, 24.022901392},
                      {10, 15.231883119, 86.756166097},
                      {30, 19.901095074, 461.865700916}};
  for (const Row& row : rows) {
    const Line end = advance<RungeKutta4>(
        {0, 0}, 0.01, static_cast<int>(std::lround(row.t * 100)),
        [](double, double v) { return (20000 - 50 * v * std::abs(v)) / 10000; });
    EXPECT_NEAR(end.velocity, row.v, 1e-8) << row.t;
    EXPECT_NEAR(end.position, row.s, 1e-8) << row.t;
  }
}

// ---- 7.2-7.3: the oscillator x'' = -w^2 x, x = 1, v = 0, z = w dt
// -----------------------------------

namespace {

struct Swing {
  double amplitude;
  double position;
};

template <class Integrator>
Swing swing(double z, int steps) {  // w = 1, so dt = z
  const Line end = advance<Integrator>({1, 0}, z, steps, [](double x, double) { return -x; });
  return {std::hypot(end.position, end.velocity), end.position};
}

}  // namespace

TEST(Oscillator, AmplitudesAreThoseOfTheBook) {
  struct Row {
    double z;
    int steps;
    double euler, semi_implicit, improved, runge_kutta;
    double exact_position;
  };
  const Row rows[] = {
      {0.1, 100, 1.6446318, 0.9775630, 1.0012508, 0.9999993, -0.8390715},
      {0.1, 1000, 144.77277, 1.0210985, 1.0125783, 0.99999306, 0.8623189},
      {0.5, 100, 7.0064923e4, 0.9362286, 2.1710465, 0.9895424, 0.9649660},
      {2 * 3.14159265358979323846 * 0.02, 500, 50.249227, 0.9973990, 1.0157070, 0.9999864, 1},
  };
  for (const Row& row : rows) {
    const auto near = [&](double value, double wanted) {
      EXPECT_NEAR(value, wanted, std::abs(wanted) * 5.1e-8) << row.z << ", " << row.steps;
    };
    near(swing<ExplicitEuler>(row.z, row.steps).amplitude, row.euler);
    near(swing<SemiImplicitEuler>(row.z, row.steps).amplitude, row.semi_implicit);
    near(swing<ImprovedEuler>(row.z, row.steps).amplitude, row.improved);
    near(swing<RungeKutta4>(row.z, row.steps).amplitude, row.runge_kutta);
    EXPECT_NEAR(std::cos(row.z * row.steps), row.exact_position, 5.1e-8);
    const double n = row.steps;
    near(swing<ExplicitEuler>(row.z, row.steps).amplitude, std::pow(1 + row.z * row.z, n / 2));
    near(swing<ImprovedEuler>(row.z, row.steps).amplitude,
         std::pow(1 + std::pow(row.z, 4) / 4, n / 2));
  }
  EXPECT_NEAR(swing<ExplicitEuler>(0.1, 100).amplitude, 1.644631822, 5e-10);
  EXPECT_NEAR(swing<ImprovedEuler>(0.1, 100).amplitude, 1.001250766, 5e-10);
  EXPECT_NEAR(swing<RungeKutta4>(0.1, 100).amplitude, 0.999999306, 5e-10);
  EXPECT_NEAR(swing<ImprovedEuler>(0.3, 100).amplitude, 1.10644, 5.1e-6);  // 10.6 % in 100 steps
}

TEST(Oscillator, PositionsAreThoseOfTheBook) {
  EXPECT_NEAR(swing<ExplicitEuler>(0.1, 100).position, -1.4088470, 5.1e-8);
  EXPECT_NEAR(swing<SemiImplicitEuler>(0.1, 100).position, -0.8093848, 5.1e-8);
  EXPECT_NEAR(swing<ImprovedEuler>(0.1, 100).position, -0.8309544, 5.1e-8);
  EXPECT_NEAR(swing<RungeKutta4>(0.1, 100).position, -0.8390755, 5.1e-8);
  EXPECT_NEAR(swing<ExplicitEuler>(0.1, 1000).position, 94.20122, 5.1e-6);
  EXPECT_NEAR(swing<ImprovedEuler>(0.1, 1000).position, 0.9459457, 5.1e-8);
  EXPECT_NEAR(swing<RungeKutta4>(0.1, 1000).position, 0.8622708, 5.1e-8);
  EXPECT_NEAR(swing<RungeKutta4>(0.5, 100).position, 0.9484380, 5.1e-8);
  constexpr double fiftieth = 2 * 3.14159265358979323846 * 0.02;  // ten periods
  EXPECT_NEAR(swing<ImprovedEuler>(fiftieth, 500).position, 1.0019822, 5.1e-8);
  EXPECT_NEAR(swing<RungeKutta4>(fiftieth, 500).position, 0.9999863, 5.1e-8);
}

// Below w dt = 2 they stay bounded for ever, above they blow up: the book's Fig 7-5 shows explicit
// Euler.
TEST(Oscillator, SymplecticMethodsStayBounded) {
  EXPECT_LT(swing<SemiImplicitEuler>(1.9, 99'999).amplitude, 10);
  EXPECT_LT(swing<VelocityVerlet>(1.9, 99'999).amplitude, 10);
  EXPECT_GT(swing<SemiImplicitEuler>(2.1, 999).amplitude, 1e12);
  EXPECT_GT(swing<VelocityVerlet>(2.1, 999).amplitude, 1e12);
  EXPECT_LT(swing<RungeKutta4>(2.82, 99'999).amplitude, 1);
  EXPECT_GT(swing<RungeKutta4>(2.83, 99'999).amplitude, 1e12);
}

}  // namespace salvo::tests
