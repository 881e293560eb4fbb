// The projectile with a standard drag function: its tables against the published atmosphere and
// drag functions, its flight against a finer integration
// in the exact atmosphere, with the same drag table.
#include "models/projectile.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <vector>

#include "models/drag_functions.hpp"
#include "solver/models.hpp"

namespace salvo::tests {

namespace {

using V = kernels::ScalarLane<double>;
using models::CubicPlace;
using soa::Precision;
using solver::Batch;
using solver::Integrated;
using solver::Integration;
using solver::Isa;
using solver::Outcome;

double geopotential(double z) {
  return models::atmosphere_radius * z / (models::atmosphere_radius + z);
}

double drag(std::size_t function, double mach) {
  const auto& tables = models::projectile_tables<double>();
  CubicPlace<V> place(tables.drag_place, V(mach));
  place.shift(V(static_cast<double>(function * tables.drag_stride)));
  return place.value(tables.drag.coefficients()).value();
}

constexpr double pounds_per_square_inch = 703.06957963916;  // in kg/m^2
constexpr std::size_t g7 = 4;

// Shots at 2 km with a G7 coefficient of 0.22 lb/in^2 and 800 m/s, elevations and winds that
// differ.
Batch rifle_shots(Precision precision, std::size_t rows) {
  Batch batch(&projectile_kernels, precision, rows);
  const auto fill = [&]<class T>(T) {
    for (std::size_t i = 0; i < rows; ++i) {
      const double elevation = 0.02 + 1e-4 * static_cast<double>(i % 97);
      batch.column<T>("vx")[i] = static_cast<T>(800 * std::cos(elevation));
      batch.column<T>("vy")[i] = static_cast<T>(800 * std::sin(elevation));
      batch.column<T>("wind_z")[i] = static_cast<T>(static_cast<double>(i % 11) - 5);
      batch.column<T>("altitude")[i] = static_cast<T>(37.0 * static_cast<double>(i % 53));
      batch.column<T>("drag_factor")[i] =
          static_cast<T>(M_PI / 8 / (0.22 * pounds_per_square_inch));
      batch.column<T>("range")[i] = 2000;
    }
  };
  precision == Precision::float32 ? fill(0.0F) : fill(0.0);
  return batch;
}

Integration to(double tolerance) {
  Integration integration;
  integration.step = 0.01;
  integration.absolute_tolerance = integration.relative_tolerance = tolerance;
  return integration;
}

// The same shot with the exact atmosphere and a short step of the classical Runge-Kutta method, to
// the plane x = 2000.
std::array<double, 3> fine_shot(std::array<double, 6> s, double wind_z, double altitude) {
  const auto rate = [&](const std::array<double, 6>& y) {
    const models::AirState air = models::standard_air(geopotential(y[1] + altitude));
    const double u[3] = {y[3], y[4], y[5] - wind_z};
    const double speed = std::sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    const double k = M_PI / 8 * air.density * drag(g7, speed / air.speed_of_sound) * speed /
                     (0.22 * pounds_per_square_inch);
    return std::array<double, 6>{y[3], y[4], y[5], -k * u[0], -k * u[1] - 9.80665, -k * u[2]};
  };
  const auto step = [&](const std::array<double, 6>& y, double h) {
    const auto moved = [&](const std::array<double, 6>& k, double by) {
      std::array<double, 6> at = y;
      for (std::size_t i = 0; i < 6; ++i) at[i] += by * k[i];
      return at;
    };
    const auto k1 = rate(y);
    const auto k2 = rate(moved(k1, h / 2));
    const auto k3 = rate(moved(k2, h / 2));
    const auto k4 = rate(moved(k3, h));
    std::array<double, 6> at = y;
    for (std::size_t i = 0; i < 6; ++i) at[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
    return at;
  };
  double t = 0;
  constexpr double dt = 5e-4;
  for (;;) {
    const std::array<double, 6> next = step(s, dt);
    if (next[0] >= 2000) break;
    s = next;
    t += dt;
  }
  double h = (2000 - s[0]) / s[3];
  for (int i = 0; i < 20; ++i) h -= (step(s, h)[0] - 2000) / step(s, h)[3];
  const std::array<double, 6> end = step(s, h);
  return {t + h, end[1], end[2]};
}

}  // namespace

TEST(StandardAtmosphere, IsThePublishedOne) {
  const struct {
    double z, temperature, pressure, density, sound;
  } rows[] = {
      {-5000, 320.67558343616563, 177761.50048145938, 1.9311215702612277, 358.98645642721761},
      {0, 288.15, 101325, 1.2249991558877121, 340.29410778693533},
      {5000, 255.67554322180351, 54048.286145761401, 0.73642842077977401, 320.54551967040354},
      {17000, 216.65, 8849.731383589265, 0.14230140769780353, 295.06959735390426},
      {27000, 223.53580408492417, 1879.975079352064, 0.029298325431887408, 299.72202952923493},
      {47000, 269.68413085362582, 115.85111376529349, 0.0014965203349559878, 329.20984423529351},
      {67000, 227.80667152259282, 8.175711770994082, 1.2502502055583572e-4, 302.57172182926739},
      {85000, 188.89317368870586, 0.44568076300793076, 8.2195005043526283e-6, 275.52007570136863}};
  for (const auto& row : rows) {
    const models::AirState air = models::standard_air(geopotential(row.z));
    EXPECT_NEAR(air.temperature / row.temperature, 1, 1e-13) << row.z;
    EXPECT_NEAR(air.pressure / row.pressure, 1, 1e-12) << row.z;
    EXPECT_NEAR(air.density / row.density, 1, 1e-12) << row.z;
    EXPECT_NEAR(air.speed_of_sound / row.sound, 1, 1e-13) << row.z;
  }
}

TEST(ProjectileTables, AreTheAtmosphereToEightDigits) {
  const auto& tables = models::projectile_tables<double>();
  double worst = 0;
  for (double h = -4999; h < 84800; h += 17.3) {
    const CubicPlace<V> place(tables.density, V(h));
    const models::AirState air = models::standard_air(h);
    worst = std::max(
        worst, std::abs(place.value(tables.density.coefficients()).value() / air.density - 1));
    worst = std::max(
        worst,
        std::abs(place.value(tables.slowness.coefficients()).value() * air.speed_of_sound - 1));
  }
  EXPECT_LT(worst, 6e-9);
}

TEST(ProjectileTables, GoThroughEveryPublishedPointWithoutOvershoot) {
  for (std::size_t f = 0; f < models::drag_functions.size(); ++f) {
    const auto points = models::drag_functions[f].points;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      EXPECT_NEAR(drag(f, points[i].mach), points[i].cd, 1e-14);
      for (const double part : {0.1, 0.3, 0.5, 0.8}) {
        const double cd = drag(f, points[i].mach + part * (points[i + 1].mach - points[i].mach));
        EXPECT_GE(cd, std::min(points[i].cd, points[i + 1].cd) - 1e-14);
        EXPECT_LE(cd, std::max(points[i].cd, points[i + 1].cd) + 1e-14);
      }
    }
    EXPECT_EQ(drag(f, 6), points.back().cd);
  }
}

TEST(Projectile, FliesAsAFinerIntegrationInTheExactAtmosphere) {
  constexpr std::size_t rows = 20;
  Batch batch = rifle_shots(Precision::float64, rows);
  const Integrated result = batch.integrate(std::vector(rows, 60.0), to(1e-8));
  Batch given = rifle_shots(Precision::float64, rows);
  for (std::size_t i = 0; i < rows; ++i) {
    EXPECT_EQ(result.outcome[i], Outcome::event);
    EXPECT_EQ(result.event[i], 1);
    const auto value = [&](const char* field) { return given.column<double>(field)[i]; };
    const auto [t, y, z] =
        fine_shot({0, 0, 0, value("vx"), value("vy"), 0}, value("wind_z"), value("altitude"));
    EXPECT_NEAR(result.time[i], t, 4e-6);  // 1 mm at 240 m/s
    EXPECT_NEAR(batch.column<double>("x")[i], 2000, 1e-5);
    EXPECT_NEAR(batch.column<double>("y")[i], y, 1e-3) << "the table, the tolerance or the method";
    EXPECT_NEAR(batch.column<double>("z")[i], z, 1e-3);
  }
}

// How far the impact of 10,000 random shots is from that of a tolerance of 1e-12 by another method,
// as a multiple of what a step's error may be there: errors of some forty steps add up, and what a
// kink of a drag function does to a step across it is only partly seen.
TEST(Projectile, TheImpactsErrorIsAFewTimesThatOfAStep) {
  constexpr std::size_t rows = 10'000;
  const auto draw = [](std::size_t row, unsigned n) {
    return static_cast<double>((row * 2654435761U + n * 40503U * (row + 7)) % 10007) / 10007;
  };
  const auto shots = [&] {
    Batch batch(&projectile_kernels, Precision::float64, rows);
    for (std::size_t i = 0; i < rows; ++i) {
      const double speed = 600 + 400 * draw(i, 1);
      const double elevation = 0.01 + 0.03 * draw(i, 2);
      batch.column<double>("vx")[i] = speed * std::cos(elevation);
      batch.column<double>("vy")[i] = speed * std::sin(elevation);
      batch.column<double>("wind_z")[i] = 10 * draw(i, 3) - 5;
      batch.column<double>("altitude")[i] = 2000 * draw(i, 4);
      batch.column<double>("drag_factor")[i] = M_PI / 8 / (100 + 150 * draw(i, 5));
      batch.column<double>("drag_function")[i] = static_cast<double>(i % 7);
      batch.column<double>("range")[i] = 1000;
    }
    return batch;
  };
  Integration fine = to(1e-12);
  fine.method = solver::Method::extrapolation_8;
  Batch exact = shots();
  exact.integrate(std::vector(rows, 60.0), fine);
  for (const double tolerance : {1e-6, 1e-7, 1e-8}) {
    Batch batch = shots();
    const Integrated result = batch.integrate(std::vector(rows, 60.0), to(tolerance));
    double worst = 0;
    for (std::size_t i = 0; i < rows; ++i) {
      ASSERT_EQ(result.outcome[i], Outcome::event);
      const auto off = [&](const char* field) {
        return batch.column<double>(field)[i] - exact.column<double>(field)[i];
      };
      worst = std::max(worst, std::hypot(off("x"), off("y"), off("z")));
    }
    const double times = worst / (tolerance * (1 + 1000));
    std::printf("tolerance %g: worst impact %.3g m, %.2g times that of a step\n", tolerance, worst,
                times);
    EXPECT_LT(times, 20) << tolerance;
  }
}

TEST(Projectile, HasOneHashForEveryInstructionSetAndThreadCount) {
  for (const Precision precision : {Precision::float32, Precision::float64}) {
    std::string reference;
    for (const Isa isa : solver::available_isas()) {
      for (const int threads : {1, 3}) {
        Batch batch = rifle_shots(precision, 333);
        batch.integrate(std::vector(333, 60.0), to(precision == Precision::float32 ? 1e-4 : 1e-8),
                        isa, threads);
        const std::string hash = to_string(batch.hash().total);
        if (reference.empty()) reference = hash;
        EXPECT_EQ(hash, reference) << name(isa);
      }
    }
  }
}

}  // namespace salvo::tests
