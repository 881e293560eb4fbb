// Sweeps: rows that depend on their index alone, grids and tables in their order, and what is told
// of a trajectory on its way, against exact solutions.
#include "solver/sweep.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "solver/models.hpp"

namespace salvo::solver {
namespace {

using Kind = Variation::Kind;

constexpr double g = 9.80665;

std::size_t input(const SweepSetup& setup, std::string_view name) {
  const auto fields = setup.model(Isa::scalar).input_fields;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (fields[i].name == name) return i;
  }
  throw std::invalid_argument(std::string(name));
}

SweepSetup setup_of(BatchModel model) {
  SweepSetup setup;
  setup.model = model;
  setup.seed = 7;
  for (const soa::Field& field : model(Isa::scalar).input_fields) {
    setup.inputs.push_back(Variation::of(field.fallback));
  }
  setup.integration.step = 0.05;
  setup.integration.absolute_tolerance = setup.integration.relative_tolerance = 1e-9;
  setup.time_limit = 100;
  return setup;
}

SweepSetup vacuum_shot() {
  SweepSetup setup = setup_of(&shot_in_air_kernels);
  setup.inputs[input(setup, "speed")] = Variation::of(100);
  setup.inputs[input(setup, "elevation")] = Variation::of(0.5);
  setup.inputs[input(setup, "ground")] = Variation::of(0);
  return setup;
}

const double* column(const Sweep& sweep, const SweepRows& rows, std::string_view name) {
  for (std::size_t f = 0; f < sweep.fields().size(); ++f) {
    if (sweep.fields()[f].name == name) return rows.table.column<double>(f);
  }
  throw std::invalid_argument(std::string(name));
}
const std::uint32_t* whole(const Sweep& sweep, const SweepRows& rows, std::string_view name) {
  for (std::size_t f = 0; f < sweep.fields().size(); ++f) {
    if (sweep.fields()[f].name == name) return rows.table.column<std::uint32_t>(f);
  }
  throw std::invalid_argument(std::string(name));
}

// Random speed, elevation, wind and drag function's coefficient.
SweepSetup random_shots(soa::Precision precision) {
  SweepSetup setup = setup_of(&projectile_kernels);
  setup.precision = precision;
  setup.inputs[input(setup, "speed")] = {Kind::normal, 800, 10, 0, 0, {}};
  setup.inputs[input(setup, "elevation")] = {Kind::truncated_normal, 0.05, 0.01, 0, 0.1, {}};
  setup.inputs[input(setup, "wind_z")] = {Kind::uniform, -5, 5, 0, 0, {}};
  setup.inputs[input(setup, "ballistic_coefficient")] = {Kind::uniform, 100, 200, 0, 0, {}};
  setup.inputs[input(setup, "ground")] = Variation::of(0);
  setup.inputs[input(setup, "range")] = Variation::of(1500);
  const double tolerance = precision == soa::Precision::float32 ? 1e-4 : 1e-8;
  setup.integration.absolute_tolerance = setup.integration.relative_tolerance = tolerance;
  setup.integration.record = 0b1100;
  setup.integration.samples = {0, {100, 500, 1000}};
  setup.samples = 10'000;
  return setup;
}

TEST(Sweep, HasOneHashForEveryInstructionSetThreadCountAndPiece) {
  for (const soa::Precision precision : {soa::Precision::float32, soa::Precision::float64}) {
    const Sweep sweep(random_shots(precision));
    const std::uint64_t rows = 9001;
    const Parallel parallel(2);
    const Digest reference = sweep.run(0, rows, {Isa::scalar, 1, 1}).hash(parallel);
    for (const Isa isa : available_isas()) {
      for (const int threads : {1, 2, 3, 13}) {
        EXPECT_EQ(sweep.run(0, rows, {isa, threads, 1}).hash(parallel), reference) << name(isa);
      }
    }
    for (const std::uint64_t row : {0, 1, 4095, 4096, 9000}) {
      const SweepRows alone = sweep.run(row, 1, {});
      const SweepRows scalar = sweep.run(row, 1, {Isa::scalar, 1, 1});
      const SweepRows among = sweep.run(row / 2, row - row / 2 + 1, {});
      EXPECT_EQ(alone.hash(parallel), scalar.hash(parallel));
      const std::size_t last = row - row / 2;
      EXPECT_EQ(among.table.ids()[last], row);
      for (std::size_t level = 0; level < 3; ++level) {
        EXPECT_EQ(among.samples[1][last * 3 + level], alone.samples[1][level]);
      }
    }
  }
}

TEST(Sweep, MoreSamplesKeepTheFirstOnes) {
  for (const Sampling sampling : {Sampling::random, Sampling::sobol}) {
    SweepSetup setup = random_shots(soa::Precision::float64);
    setup.sampling = sampling;
    setup.samples = 100;
    const Sweep few(setup);
    setup.samples = 1000;
    const Sweep many(setup);
    EXPECT_EQ(few.run(0, 100, {}).hash(Parallel(1)), many.run(0, 100, {}).hash(Parallel(1)));
  }
}

TEST(Sweep, AnotherRandomInputLeavesTheOthersAsTheyAre) {
  SweepSetup setup = random_shots(soa::Precision::float64);
  for (const Sampling sampling : {Sampling::random, Sampling::sobol, Sampling::latin_hypercube}) {
    setup.sampling = sampling;
    const Sweep before(setup);
    SweepSetup more = setup;
    more.inputs[input(setup, "azimuth")] = {Kind::normal, 0, 0.01, 0, 0, {}};
    const Sweep after(more);
    const SweepRows a = before.run(0, 50, {});
    const SweepRows b = after.run(0, 50, {});
    for (std::size_t i = 0; i < 50; ++i) {
      EXPECT_EQ(column(before, a, "input.speed")[i], column(after, b, "input.speed")[i]);
      EXPECT_EQ(column(before, a, "input.wind_z")[i], column(after, b, "input.wind_z")[i]);
    }
  }
}

TEST(Sweep, GridsAreCrossedTheLastInputFastest) {
  SweepSetup setup = vacuum_shot();
  setup.inputs[input(setup, "speed")] = {Kind::grid, 0, 0, 0, 0, {10, 20, 30}};
  setup.inputs[input(setup, "elevation")] = {Kind::grid, 0, 0, 0, 0, {0.1, 0.2}};
  setup.inputs[input(setup, "gravity")] = {Kind::column, 0, 0, 0, 0, {9, 10}};
  setup.inputs[input(setup, "mass")] = {Kind::column, 0, 0, 0, 0, {1, 2}};
  setup.inputs[input(setup, "azimuth")] = {Kind::normal, 0, 1, 0, 0, {}};
  setup.samples = 2;
  const Sweep sweep(setup);
  EXPECT_EQ(sweep.points(), 12u);
  ASSERT_EQ(sweep.rows(), 24u);
  const SweepRows rows = sweep.run(0, 24, {});
  for (std::size_t i = 0; i < 24; ++i) {
    const std::size_t point = i % 12;
    EXPECT_EQ(column(sweep, rows, "input.elevation")[i], point % 2 == 0 ? 0.1 : 0.2);
    EXPECT_EQ(column(sweep, rows, "input.speed")[i], 10 * static_cast<double>(1 + point / 2 % 3));
    EXPECT_EQ(column(sweep, rows, "input.gravity")[i], point < 6 ? 9 : 10);
    EXPECT_EQ(column(sweep, rows, "input.mass")[i], point < 6 ? 1 : 2);
    // One draw a sample: the points of the grid share it.
    EXPECT_EQ(column(sweep, rows, "input.azimuth")[i],
              column(sweep, rows, "input.azimuth")[i < 12 ? 0 : 12]);
  }
  EXPECT_NE(column(sweep, rows, "input.azimuth")[0], column(sweep, rows, "input.azimuth")[12]);
}

TEST(Sweep, JointInputsHaveTheirCovariance) {
  SweepSetup setup = vacuum_shot();
  // Cholesky's factor of [[4, 3], [3, 9]].
  setup.joint.push_back({{input(setup, "wind_x"), input(setup, "wind_z")},
                         {1, -2},
                         {{2, 0}, {1.5, std::sqrt(6.75)}}});
  setup.samples = 40'000;
  const Sweep sweep(setup);
  const SweepRows rows = sweep.run(0, 40'000, {});
  const double* x = column(sweep, rows, "input.wind_x");
  const double* z = column(sweep, rows, "input.wind_z");
  double mx = 0, mz = 0, xx = 0, xz = 0, zz = 0;
  for (std::size_t i = 0; i < 40'000; ++i) {
    mx += x[i] / 40'000;
    mz += z[i] / 40'000;
    xx += (x[i] - 1) * (x[i] - 1) / 40'000;
    xz += (x[i] - 1) * (z[i] + 2) / 40'000;
    zz += (z[i] + 2) * (z[i] + 2) / 40'000;
  }
  EXPECT_NEAR(mx, 1, 0.05);
  EXPECT_NEAR(mz, -2, 0.07);
  EXPECT_NEAR(xx, 4, 0.15);
  EXPECT_NEAR(xz, 3, 0.15);
  EXPECT_NEAR(zz, 9, 0.3);
}

// Without air everything is known: where it comes down, how high it rises, when it is where.
TEST(Sweep, AShotInVacuumIsTheParabola) {
  for (const Method method :
       {Method::runge_kutta_4, Method::heun, Method::tsitouras_5, Method::dormand_prince_5}) {
    for (const bool adaptive : {false, true}) {
      if (adaptive && !knows_error(method)) continue;
      SweepSetup setup = vacuum_shot();
      setup.inputs[input(setup, "mass")] = Variation::of(2);
      setup.integration.method = method;
      if (!adaptive) {
        setup.integration.absolute_tolerance = setup.integration.relative_tolerance = 0;
      }
      setup.integration.record = 0b100;  // the apex
      setup.integration.samples = {Samples::time, {0, 1, 2.5, 9, 50}};
      const Sweep sweep(setup);
      const SweepRows rows = sweep.run(0, 1, {});
      const auto at = [&](const char* name) { return column(sweep, rows, name)[0]; };
      const double vx = 100 * std::cos(0.5);
      const double vy = 100 * std::sin(0.5);
      EXPECT_EQ(sweep.outcomes()[whole(sweep, rows, "outcome")[0]], "ground");
      EXPECT_NEAR(at("time"), 2 * vy / g, 1e-13 * at("time"));
      EXPECT_NEAR(at("end.x"), 2 * vy / g * vx, 1e-12 * at("end.x"));
      EXPECT_NEAR(at("end.y"), 0, 1e-11);
      EXPECT_NEAR(at("end.speed"), 100, 1e-11);
      EXPECT_NEAR(at("end.angle"), -0.5, 1e-13);
      EXPECT_NEAR(at("end.energy"), 10'000, 1e-8);
      EXPECT_NEAR(at("apex.time"), vy / g, 1e-13 * at("time"));
      EXPECT_NEAR(at("apex.y"), vy * vy / (2 * g), 1e-11);
      EXPECT_EQ(whole(sweep, rows, "sampled")[0], 4u);
      const double times[] = {0, 1, 2.5, 9};
      for (std::size_t k = 0; k < 4; ++k) {
        const double t = times[k];
        EXPECT_EQ(rows.sample_time[k], t);
        EXPECT_NEAR(rows.samples[0][k], vx * t, 1e-11 * (1 + t));
        EXPECT_NEAR(rows.samples[1][k], vy * t - g / 2 * t * t, 1e-11 * (1 + t * t));
        EXPECT_NEAR(rows.samples[6][k], std::hypot(vx, vy - g * t), 1e-10);
      }
      EXPECT_TRUE(std::isnan(rows.sample_time[4]));
      EXPECT_TRUE(std::isnan(rows.samples[1][4]));
      EXPECT_TRUE(std::isnan(rows.samples[8][4]));
    }
  }
}

TEST(Sweep, SamplesAtRangesAreWhereThePathIs) {
  SweepSetup setup = vacuum_shot();
  setup.integration.samples = {0, {0, 1, 2, 3, 400, 800, 900}};  // it comes down at 858 m
  const Sweep sweep(setup);
  const SweepRows rows = sweep.run(0, 1, {});
  EXPECT_EQ(whole(sweep, rows, "sampled")[0], 6u);
  for (std::size_t k = 0; k < 6; ++k) {
    const double x = setup.integration.samples.levels[k];
    const double t = x / (100 * std::cos(0.5));
    EXPECT_NEAR(rows.samples[0][k], x, 1e-9);
    EXPECT_NEAR(rows.sample_time[k], t, 1e-10);
    EXPECT_NEAR(rows.samples[1][k], 100 * std::sin(0.5) * t - g / 2 * t * t, 1e-8);
  }
  EXPECT_TRUE(std::isnan(rows.samples[0][6]));
}

TEST(Sweep, AnEventThatDoesNotHappenHasNoTime) {
  SweepSetup setup = vacuum_shot();
  setup.inputs[input(setup, "elevation")] = Variation::of(-0.1);  // only down
  setup.integration.record = 0b100;
  const Sweep sweep(setup);
  const SweepRows rows = sweep.run(0, 1, {});
  EXPECT_TRUE(std::isnan(column(sweep, rows, "apex.time")[0]));
  EXPECT_TRUE(std::isnan(column(sweep, rows, "apex.y")[0]));
}

TEST(Sweep, EventsThatStopAreTheUsers) {
  SweepSetup setup = vacuum_shot();
  setup.integration.stop_at = 0b100;
  const Sweep sweep(setup);
  const SweepRows rows = sweep.run(0, 1, {});
  EXPECT_EQ(sweep.outcomes()[whole(sweep, rows, "outcome")[0]], "apex");
  EXPECT_NEAR(column(sweep, rows, "end.vy")[0], 0, 1e-12);
}

// A shot straight up to the ground of a ledge: y has its greatest value there.
TEST(Sweep, AQuantityThatOnlyTouchesZeroIsAGraze) {
  for (const double off : {0.0, 1e-10, 1e-3}) {
    SweepSetup setup = vacuum_shot();
    setup.inputs[input(setup, "elevation")] = Variation::of(M_PI / 2);
    setup.inputs[input(setup, "ground")] = Variation::of(100 * 100 / (2 * g) + off);
    setup.time_limit = 15;
    const Sweep sweep(setup);
    const SweepRows rows = sweep.run(0, 1, {});
    EXPECT_EQ(whole(sweep, rows, "grazes")[0], off < 1e-4 ? 1u : 0u) << off;
  }
}

TEST(Sweep, CoriolisBendsToTheRightInTheNorth) {
  SweepSetup setup = setup_of(&projectile_kernels);
  setup.inputs[input(setup, "ballistic_coefficient")] = Variation::of(1e9);  // next to no drag
  setup.inputs[input(setup, "speed")] = Variation::of(1000);
  setup.inputs[input(setup, "gravity")] = Variation::of(0);
  setup.inputs[input(setup, "earth_rotation")] = Variation::of(7.292115e-5);
  setup.inputs[input(setup, "latitude")] = {Kind::grid, 0, 0, 0, 0, {-0.8, 0.8}};
  setup.inputs[input(setup, "bearing")] = {Kind::grid, 0, 0, 0, 0, {0, M_PI / 2}};
  setup.time_limit = 1;
  const Sweep sweep(setup);
  const SweepRows rows = sweep.run(0, 4, {});
  for (std::size_t i = 0; i < 4; ++i) {
    const double latitude = i < 2 ? -0.8 : 0.8;
    // Omega sin(latitude) v t^2 to the right; eastward Omega cos(latitude) v t^2 upward.
    EXPECT_NEAR(column(sweep, rows, "end.z")[i], 7.292115e-5 * std::sin(latitude) * 1000, 1e-5);
    const double up = i % 2 == 0 ? 0 : 7.292115e-5 * std::cos(latitude) * 1000;
    EXPECT_NEAR(column(sweep, rows, "end.y")[i], up, 1e-5);
  }
}

TEST(Sweep, GravityFallsOffWithTheSquareOfTheDistance) {
  SweepSetup setup = setup_of(&projectile_kernels);
  setup.inputs[input(setup, "ballistic_coefficient")] = Variation::of(1e9);
  setup.inputs[input(setup, "speed")] = Variation::of(1000);
  setup.inputs[input(setup, "elevation")] = Variation::of(M_PI / 2);
  setup.inputs[input(setup, "gravity_falloff")] = Variation::of(1 / 6.356766e6);
  setup.integration.record = 0b100;
  setup.time_limit = 300;
  const Sweep sweep(setup);
  const SweepRows rows = sweep.run(0, 1, {});
  // v^2 / 2 = g R h / (R + h)
  const double reached = 1e6 / (2 * g);
  EXPECT_NEAR(column(sweep, rows, "apex.y")[0], reached / (1 - reached / 6.356766e6), 0.2);
}

TEST(Sweep, WindGrowsWithHeight) {
  SweepSetup setup = setup_of(&projectile_kernels);
  setup.inputs[input(setup, "speed")] = Variation::of(0);
  setup.inputs[input(setup, "gravity")] = Variation::of(0);
  setup.inputs[input(setup, "wind_z")] = Variation::of(1);
  setup.inputs[input(setup, "wind_exponent")] = {Kind::grid, 0, 0, 0, 0, {0, 0.5}};
  setup.inputs[input(setup, "wind_height")] = Variation::of(10);
  setup.inputs[input(setup, "y")] = {Kind::grid, 0, 0, 0, 0, {-5, 10, 40}};
  setup.time_limit = 0.01;
  const Sweep sweep(setup);
  const SweepRows rows = sweep.run(0, 6, {});
  const double* drift = column(sweep, rows, "end.vz");
  const std::uint64_t y_fast =
      column(sweep, rows, "input.y")[0] == column(sweep, rows, "input.y")[1];
  // By row: the exponent varies fastest when it comes after y in the list.
  ASSERT_TRUE(y_fast);
  EXPECT_NEAR(drift[3] / drift[2], 1, 1e-9);  // at the height of the given wind
  EXPECT_NEAR(drift[5] / drift[4], 4, 0.01);  // twice the wind, four times the drag
  EXPECT_EQ(drift[1], 0);                     // none below the ground
  EXPECT_GT(drift[0], 0);
}

TEST(Sweep, NominalIsOneRowOfMeans) {
  SweepSetup setup = random_shots(soa::Precision::float64);
  setup.joint.push_back({{input(setup, "z")}, {0.5}, {{1}}});
  const Sweep sweep(nominal(setup));
  ASSERT_EQ(sweep.rows(), 1u);
  const SweepRows rows = sweep.run(0, 1, {});
  EXPECT_EQ(rows.table.uniform(1 + input(setup, "speed")), 800);
  EXPECT_EQ(rows.table.uniform(1 + input(setup, "z")), 0.5);
}

}  // namespace
}  // namespace salvo::solver
