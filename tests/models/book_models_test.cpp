// The book's cannon, boat, spinning balls and rocket: its numbers, and exact solutions.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>

#include "models/ball.hpp"
#include "solver/models.hpp"
#include "solver/sweep.hpp"

namespace salvo::solver {
namespace {

using Kind = Variation::Kind;

class Trajectory {
 public:
  explicit Trajectory(BatchModel model) {
    setup.model = model;
    for (const soa::Field& field : model(Isa::scalar).input_fields) {
      setup.inputs.push_back(Variation::of(field.fallback));
    }
    setup.integration.step = 0.01;
    setup.integration.absolute_tolerance = setup.integration.relative_tolerance = 1e-11;
    setup.time_limit = 1000;
  }
  Variation& input(std::string_view name) {
    const auto fields = setup.model(Isa::scalar).input_fields;
    for (std::size_t i = 0; i < fields.size(); ++i) {
      if (fields[i].name == name) return setup.inputs[i];
    }
    throw std::invalid_argument(std::string(name));
  }
  Trajectory& with(std::string_view name, double value) {
    input(name) = Variation::of(value);
    return *this;
  }
  Trajectory& until(double time) {
    setup.time_limit = time;
    return *this;
  }
  /// The state or result at the end.
  double end(std::string_view name) const { return value(row(), "end." + std::string(name)); }
  double time() const { return value(row(), "time"); }
  std::string outcome() const {
    const Sweep sweep(setup);
    const SweepRows rows = sweep.run(0, 1, {});
    for (std::size_t f = 0; f < sweep.fields().size(); ++f) {
      if (sweep.fields()[f].name == "outcome") {
        return sweep.outcomes()[rows.table.column<std::uint32_t>(f)[0]];
      }
    }
    return {};
  }
  double recorded(std::string_view name) const { return value(row(), std::string(name)); }

  SweepSetup setup;

 private:
  struct Row {
    Sweep sweep;
    SweepRows rows;
  };
  std::unique_ptr<Row> row() const {
    Sweep sweep(setup);
    SweepRows rows = sweep.run(0, 1, {});
    return std::make_unique<Row>(Row{std::move(sweep), std::move(rows)});
  }
  static double value(const std::unique_ptr<Row>& row, const std::string& name) {
    const auto fields = row->sweep.fields();
    for (std::size_t f = 0; f < fields.size(); ++f) {
      if (fields[f].name == name) return row->rows.table.column<double>(f)[0];
    }
    throw std::invalid_argument(name);
  }
};

constexpr double degree = M_PI / 180;

Trajectory cannon() {
  Trajectory cannon(&cannon_kernels);
  // The book's angle is from the vertical: 25 degrees.
  return cannon.with("y", 10)
      .with("barrel", 12)
      .with("speed", 50)
      .with("elevation", 65 * degree)
      .with("gravity", 9.8)
      .with("ground", 0)
      .with("target_x", 400)
      .with("target_y", 35)
      .with("target_z", 45)
      .with("half_x", 5)
      .with("half_y", 10)
      .with("half_z", 7.5);
}

TEST(Cannon, IsWhereTheBookHasIt) {
  const struct {
    double t, x, y;
  } rows[] = {{1, 26.202332, 61.291083}, {2, 47.333245, 91.906472}, {5, 110.725985, 124.952640}};
  for (const auto& [t, x, y] : rows) {
    EXPECT_NEAR(cannon().until(t).end("x"), x, 1e-6);
    EXPECT_NEAR(cannon().until(t).end("y"), y, 1e-6);
    EXPECT_EQ(cannon().until(t).end("z"), 0);
  }
  Trajectory whole = cannon();
  whole.setup.integration.record = 0b10000000;
  EXPECT_NEAR(whole.recorded("apex.time"), 4.624019322, 1e-9);
  EXPECT_NEAR(whole.recorded("apex.y"), 125.645311, 1e-6);
  EXPECT_EQ(whole.outcome(), "ground");
  EXPECT_NEAR(whole.time(), 9.687802521, 1e-9);
  EXPECT_NEAR(whole.end("x"), 209.783532, 1e-6);
}

// However long the step: a test of points would fly through.
TEST(Cannon, HitsTheFaceOfTheBoxAtTheSameTimeWithAnyStep) {
  for (const double step : {0.05, 0.25, 0.3, 0.5, 1.0}) {
    Trajectory shot =
        cannon().with("speed", 70).with("elevation", 30 * degree).with("azimuth", 6.4 * degree);
    shot.setup.integration.method = Method::runge_kutta_4;
    shot.setup.integration.step = step;
    shot.setup.integration.absolute_tolerance = shot.setup.integration.relative_tolerance = 0;
    EXPECT_EQ(shot.outcome(), "target_front");
    EXPECT_NEAR(shot.time(), 6.385243, 5e-7);
    EXPECT_NEAR(shot.end("x"), 395, 1e-9);
    EXPECT_NEAR(shot.end("z"), 44.306349, 1e-6);
  }
}

TEST(Cannon, TheSweepOf1430ShotsHitsFourTimes) {
  Trajectory shots = cannon();
  const auto grid = [](double from, double every, int count, double scale, double offset) {
    Variation axis;
    axis.kind = Kind::grid;
    for (int i = 0; i < count; ++i) axis.values.push_back((offset + from + i * every) * scale);
    return axis;
  };
  shots.input("speed") = grid(60, 10, 11, 1, 0);
  shots.input("elevation") = grid(65, -5, 10, degree, 0);  // alpha 25 .. 70
  shots.input("azimuth") = grid(0, 1, 13, degree, 0);
  const Sweep sweep(shots.setup);
  ASSERT_EQ(sweep.rows(), 1430u);
  const SweepRows rows = sweep.run(0, 1430, {});
  std::size_t outcome = 0;
  while (sweep.fields()[outcome].name != "outcome") ++outcome;
  std::vector<std::array<int, 3>> hits;
  for (std::size_t i = 0; i < 1430; ++i) {
    const std::string how = sweep.outcomes()[rows.table.column<std::uint32_t>(outcome)[i]];
    if (how == "ground") continue;
    EXPECT_TRUE(how.starts_with("target")) << how;
    const int speed = 60 + 10 * static_cast<int>(i / 130);
    const int alpha = 25 + 5 * static_cast<int>(i / 13 % 10);
    hits.push_back({speed, alpha, static_cast<int>(i % 13)});
  }
  EXPECT_EQ(hits,
            (std::vector<std::array<int, 3>>{{70, 60, 6}, {70, 60, 7}, {80, 70, 6}, {80, 70, 7}}));
}

// m = 100, c = 30, a wind from the right of 10 with c_w = 10.
TEST(Cannon, WithDragAndWindIsTheClosedForm) {
  Trajectory shot(&cannon_kernels);
  shot.with("speed", std::sqrt(5000.0))
      .with("elevation", 45 * degree)
      .with("mass", 100)
      .with("linear_drag", 30)
      .with("wind_drag", 10)
      .with("wind_z", -10)
      .with("gravity", 9.8);
  const struct {
    double t, x, y, z;
  } rows[] = {{1, 43.196963220, 38.752312523, -0.453535785},
              {5, 129.478306642, 50.737466981, -8.034779557},
              {10, 158.368821939, -64.830214395, -22.775411871}};
  for (const Method method : {Method::runge_kutta_4, Method::dormand_prince_5}) {
    shot.setup.integration.method = method;
    const double tolerance = method == Method::runge_kutta_4 ? 0 : 1e-12;
    shot.setup.integration.step = 1e-3;
    shot.setup.integration.absolute_tolerance = shot.setup.integration.relative_tolerance =
        tolerance;
    for (const auto& [t, x, y, z] : rows) {
      EXPECT_NEAR(shot.until(t).end("x"), x, 1e-8);
      EXPECT_NEAR(shot.until(t).end("y"), y, 1e-8);
      EXPECT_NEAR(shot.until(t).end("z"), z, 1e-8);
    }
    EXPECT_NEAR(shot.until(5).end("vx"), 11.156508007, 1e-8);
    EXPECT_NEAR(shot.until(5).end("vy"), -14.221240094, 1e-8);
  }
}

// In feet: m g/c with g = 32.174.
TEST(Cannon, LinearDragHasTheBooksTerminalVelocity) {
  Trajectory fall(&cannon_kernels);
  fall.with("mass", 100).with("linear_drag", 30).with("gravity", 32.174);
  const struct {
    double t, v;
  } rows[] = {{3, -63.64343}, {6, -89.51891}, {9, -100.03910}, {15, -106.05526}, {30, -107.23343}};
  for (const auto& [t, v] : rows) EXPECT_NEAR(fall.until(t).end("vy"), v, 5e-6);
  EXPECT_NEAR(fall.until(200).end("vy"), -107.25, 0.005);
}

TEST(Boat, RunsAsTheExactSolution) {
  const struct {
    double t, v, x, a;
  } rows[] = {{1, 1.903251639, 0.967483607, 1.809674836},
              {5, 7.869386806, 21.306131943, 1.213061319},
              {10, 12.642411177, 73.575888234, 0.735758882},
              {30, 19.004258633, 409.957413674, 0.099574137},
              {60, 19.950424956, 1000.495750435, 0.004957504}};
  for (const auto& [t, v, x, a] : rows) {
    Trajectory boat(&boat_kernels);
    EXPECT_NEAR(boat.until(t).end("v"), v, 2e-9);
    EXPECT_NEAR(boat.until(t).end("x"), x, 2e-8);
    EXPECT_NEAR(boat.until(t).end("acceleration"), a, 1e-9);
  }
}

TEST(Boat, FixedStepsErrAsTheBookPrints) {
  const auto after = [](Method method, double t) {
    Trajectory boat(&boat_kernels);
    boat.setup.integration.method = method;
    boat.setup.integration.step = 0.5;
    boat.setup.integration.absolute_tolerance = boat.setup.integration.relative_tolerance = 0;
    return boat.until(t).end("v");
  };
  // Table 7-1, Euler's method, and the mean errors of the three over its rows.
  EXPECT_NEAR(after(Method::explicit_euler, 6.5), 9.733158, 5e-7);
  EXPECT_NEAR(after(Method::explicit_euler, 8.5), 11.63759, 5e-6);
  EXPECT_NEAR(after(Method::semi_implicit_euler, 8.5), 11.63759, 5e-6);
  const struct {
    Method method;
    double printed, unit;
  } methods[] = {{Method::explicit_euler, 1.72, 0.01},
                 {Method::heun, 0.03, 0.01},
                 {Method::runge_kutta_4, 3.6e-6, 1e-7}};
  for (const auto& [method, printed, unit] : methods) {
    double mean = 0;
    for (const double t : {6.5, 7.0, 7.5, 8.0, 8.5}) {
      const double exact = 20 * (1 - std::exp(-t / 10));
      mean += std::abs(after(method, t) / exact - 1) * 100 / 5;
    }
    EXPECT_NEAR(mean, printed, 0.5 * unit);
  }
}

Trajectory golf() {
  Trajectory ball(&ball_kernels);
  return ball.with("speed", 58)
      .with("elevation", 10 * degree)
      .with("mass", 0.5 / 9.81)
      .with("radius", 0.020955)
      .with("gravity", 9.81)
      .with("drag_coefficient", 0)
      .with("ground", 0);
}

// Magnus force k rho r^3 w x v alone: a trochoid.
TEST(Ball, SpinWithoutDragIsATrochoid) {
  EXPECT_NEAR(golf().end("x"), 117.283972, 1e-6);
  EXPECT_NEAR(golf().time(), 2.053332, 1e-6);
  const auto range = [](double turns) {
    return golf().with("magnus_factor", M_PI).with("spin", 2 * M_PI * turns).end("x");
  };
  EXPECT_NEAR(range(10), 156.511579, 1e-6);
  EXPECT_NEAR(range(20), 233.456528, 1e-6);
  EXPECT_NEAR(range(-30), 66.711483, 1e-6);
  Trajectory fast = golf().with("magnus_factor", M_PI).with("spin", 120 * M_PI).until(2);
  EXPECT_NEAR(fast.end("x"), 107.30686268, 1e-8);
  EXPECT_NEAR(fast.end("y"), 29.30287281, 1e-8);
  EXPECT_NEAR(fast.end("vx"), 49.44365714, 1e-8);
  EXPECT_NEAR(fast.end("vy"), 18.55808191, 1e-8);
  // The force is across the motion: it does no work.
  const double v = fast.end("speed");
  EXPECT_NEAR(0.5 * v * v + 9.81 * fast.end("y"), 1682, 1e-8);
}

TEST(Ball, TheBooksProgramHasPiSquared) {
  Trajectory ball(&ball_kernels);
  ball.with("speed", 45)
      .with("elevation", 30 * degree)
      .with("mass", 0.145)
      .with("radius", 0.0366)
      .with("gravity", 9.8)
      .with("drag_coefficient", 0)
      .with("magnus_factor", M_PI * M_PI)
      .with("ground", 0);
  const struct {
    double rpm, range, flight;
  } rows[] = {{0, 178.949, 4.5918},
              {100, 209.788, 5.5083},
              {200, 248.916, 6.7665},
              {-100, 155.020, 3.9147},
              {-200, 136.272, 3.4013}};
  for (const auto& [rpm, range, flight] : rows) {
    ball.with("spin", rpm * 2 * M_PI / 60);
    EXPECT_NEAR(ball.end("x"), range, 5e-4);
    EXPECT_NEAR(ball.time(), flight, 5e-5);
  }
}

// "Up to 59 m": with drag and lift coefficients that are constant.
TEST(Ball, BackspinCarriesAGolfBallAsFarAsTheBookSays) {
  Trajectory ball(&ball_kernels);
  ball.with("speed", 58)
      .with("elevation", 10 * degree)
      .with("mass", 0.0459)
      .with("radius", 0.020955)
      .with("gravity", 9.8)
      .with("drag_coefficient", 0.25)
      .with("ground", 0);
  const double plain = ball.end("x");
  EXPECT_NEAR(plain, 87.83, 0.01);
  EXPECT_NEAR(ball.with("lift_coefficient", 0.1).end("x"), 125.45, 0.01);
  EXPECT_NEAR(ball.with("lift_coefficient", 0.2).end("x"), 170.02, 0.01);
  EXPECT_NEAR(ball.with("lift_coefficient", 0.147).end("x") - plain, 59, 1);
}

TEST(Ball, ASidewaysAxisHooksAndSlices) {
  Trajectory ball = golf().with("lift_coefficient", 0.15).with("drag_coefficient", 0.25);
  EXPECT_EQ(ball.end("z"), 0);
  const double tilt = 20 * degree;
  ball.with("axis_z", std::cos(tilt)).with("axis_y", -std::sin(tilt));
  const double slice = ball.end("z");
  EXPECT_GT(slice, 5);
  EXPECT_DOUBLE_EQ(ball.with("axis_y", std::sin(tilt)).end("z"), -slice);
}

TEST(Ball, SpinDecaysExponentially) {
  Trajectory ball = golf().with("spin", 300).with("spin_decay", 0.5).until(2);
  EXPECT_NEAR(ball.end("spin"), 300 * std::exp(-1.0), 1e-8);
}

// Morrison's correlation at the reference's Reynolds numbers, through the deceleration of the ball.
TEST(Ball, DragFollowsTheReynoldsNumberThroughTheCrisis) {
  const struct {
    double re, cd;
  } rows[] = {{0.1, 240.22},    {1, 24.673},    {10, 3.9676},    {100, 1.0381},
              {1e3, 0.48376},   {1e4, 0.39260}, {1e5, 0.42571},  {2e5, 0.41594},
              {2.5e5, 0.30532}, {3e5, 0.17344}, {4e5, 0.093047}, {1e6, 0.12959}};
  using V = kernels::ScalarLane<double>;
  for (const auto& [re, cd] : rows) {
    const double speed = 20;
    EXPECT_NEAR(models::sphere_drag_speed(V(speed), V(re / speed)).value() / speed / cd, 1, 5e-5)
        << re;
  }
  // At rest the drag is Stokes', and finite.
  EXPECT_NEAR(models::sphere_drag_speed(V(0.0), V(100.0)).value(), 0.24, 1e-12);
}

TEST(Ball, AFallingSphereReachesTheSpeedAtWhichDragIsItsWeight) {
  Trajectory ball(&ball_kernels);
  ball.with("mass", 0.1).with("radius", 0.05).with("viscosity", 1.48e-5);
  const double v = -ball.until(60).end("vy");
  using V = kernels::ScalarLane<double>;
  const double cd_v = models::sphere_drag_speed(V(v), V(2 * 0.05 / 1.48e-5)).value();
  EXPECT_NEAR(0.5 * 1.225 * M_PI * 0.05 * 0.05 * cd_v * v, 0.1 * 9.80665, 1e-9);
}

Trajectory rocket() {
  Trajectory rocket(&rocket_kernels);
  return rocket.with("elevation", 90 * degree)
      .with("payload", 400)
      .with("propellant_1", 600)
      .with("burn_1", 60)
      .with("exhaust_1", 2500)
      .with("gravity", 9.8);
}

TEST(Rocket, BurnsAsTheRocketEquationSays) {
  const struct {
    double t, v, h, tolerance;
  } rows[] = {{10, 165.401289145, 803.883976989, 1e-7},
              {30, 597.687359847, 8171.884810722, 1e-6},
              {60, 1702.726829685, 40730.926812584, 1e-4}};
  for (const auto& [t, v, h, tolerance] : rows) {
    EXPECT_NEAR(rocket().until(t).end("vy"), v, tolerance);
    EXPECT_NEAR(rocket().until(t).end("y"), h, tolerance);
  }
  Trajectory coast = rocket();
  coast.setup.integration.record = 0b1100;
  EXPECT_NEAR(coast.recorded("burnout.time"), 60, 1e-9);
  EXPECT_NEAR(coast.recorded("apex.time"), 233.748, 5e-4);
  EXPECT_NEAR(coast.recorded("apex.y"), 188653.307, 0.01);
}

// Each stage adds u ln(mass before/mass after), less g t.
TEST(Rocket, StagesAddTheirVelocities) {
  Trajectory three = rocket()
                         .with("payload", 100)
                         .with("structure_1", 200)
                         .with("propellant_2", 300)
                         .with("structure_2", 50)
                         .with("burn_2", 40)
                         .with("exhaust_2", 2800)
                         .with("taper_2", 0.4)
                         .with("propellant_3", 80)
                         .with("structure_3", 20)
                         .with("burn_3", 30)
                         .with("exhaust_3", 3000)
                         .with("gravity", 1)
                         .until(130);
  const double exact = 2500 * std::log(1350.0 / 750) + 2800 * std::log(550.0 / 250) +
                       3000 * std::log(200.0 / 120) - 130;
  EXPECT_NEAR(three.end("vy"), exact, 1e-5);
  // The energy knows what is left of the mass: payload.
  EXPECT_NEAR(three.end("energy"), 0.5 * 100 * exact * exact, 5);
}

// Thrust turns from the launch to the velocity without a jump, which no step could follow.
TEST(Rocket, FromRestAnAccuracyIsReached) {
  Trajectory from_rest = rocket().with("elevation", 1.4).with("drag_area", 0.3).until(60);
  const double x = from_rest.end("x");
  const double y = from_rest.end("y");
  from_rest.setup.integration.absolute_tolerance = 0;
  from_rest.setup.integration.relative_tolerance = 0;
  from_rest.setup.integration.accuracy = 1e-3;
  EXPECT_EQ(from_rest.outcome(), "time limit");
  EXPECT_NEAR(from_rest.end("x"), x, 1e-3);
  EXPECT_NEAR(from_rest.end("y"), y, 1e-3);
}

TEST(Rocket, DragInTheAtmosphereCostsHeight) {
  Trajectory high = rocket().with("drag_area", 0.3);
  high.setup.integration.absolute_tolerance = high.setup.integration.relative_tolerance = 1e-9;
  EXPECT_LT(high.until(60).end("y"), rocket().until(60).end("y") - 100);
}

}  // namespace
}  // namespace salvo::solver
