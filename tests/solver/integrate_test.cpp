// Rows that are taken to their own ends: against exact solutions, and the same bits whatever they
// run beside.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "integrators/step_doubling.hpp"
#include "kernels/lane.hpp"
#include "solver/models.hpp"

namespace salvo::tests {

namespace {

using soa::Precision;
using solver::Batch;
using solver::Integrated;
using solver::Integration;
using solver::Isa;
using solver::Method;
using solver::Outcome;

Integration fixed(Method method, double step) {
  Integration integration;
  integration.method = method;
  integration.step = step;
  integration.stop_at = 0;
  return integration;
}

Integration adaptive(Method method, double tolerance) {
  Integration integration = fixed(method, 0.01);
  integration.absolute_tolerance = integration.relative_tolerance = tolerance;
  integration.stop_at = std::nullopt;
  return integration;
}

// x(t) of the oscillator released at 1, w = 1.
double error_of_oscillator(const Integration& integration, double end) {
  Batch batch(&harmonic_oscillator_kernels, Precision::float64, 1);
  const Integrated result = batch.integrate(std::vector{end}, integration);
  EXPECT_EQ(result.outcome[0], Outcome::time_limit);
  EXPECT_EQ(result.time[0], end);
  return std::hypot(batch.column<double>("x")[0] - std::cos(end),
                    batch.column<double>("v")[0] + std::sin(end));
}

// Shots whose durations, drag and speeds all differ.
constexpr std::size_t shots = 1000;

Batch make_shots(Precision precision, std::vector<double>& end) {
  Batch batch(&shot_in_air_kernels, precision, shots);
  end.resize(shots);
  const auto fill = [&]<class T>(T) {
    for (std::size_t i = 0; i < shots; ++i) {
      batch.column<T>("y")[i] = 1;
      batch.column<T>("vx")[i] = static_cast<T>(300 + static_cast<double>(i * 7 % 501));
      batch.column<T>("vy")[i] = static_cast<T>(static_cast<double>(i * 13 % 101));
      batch.column<T>("wind_z")[i] = static_cast<T>(static_cast<double>(i % 11) - 5);
      batch.column<T>("drag_factor")[i] = static_cast<T>(1e-4 * static_cast<double>(1 + i % 17));
      batch.column<T>("ground")[i] = static_cast<T>(i % 3 == 0 ? 0 : -1e9);  // a third comes down
      end[i] = 0.1 + static_cast<double>(i * 31 % 97) / 50;
    }
  };
  precision == Precision::float32 ? fill(0.0F) : fill(0.0);
  return batch;
}

struct Finished {
  std::string hash;
  Integrated result;
};

Finished finish(Precision precision, const Integration& integration, Isa isa, int threads) {
  std::vector<double> end;
  Batch batch = make_shots(precision, end);
  Integrated result = batch.integrate(end, integration, isa, threads);
  return {to_string(batch.hash().total), std::move(result)};
}

}  // namespace

TEST(Integrate, ConvergesWithTheOrderOfTheMethod) {
  const struct {
    Method method;
    double order;
    double step;
  } cases[] = {
      {Method::explicit_euler, 1, 1.0 / 512},     {Method::step_doubling_euler, 1, 1.0 / 512},
      {Method::semi_implicit_euler, 1, 1.0 / 64}, {Method::heun, 2, 1.0 / 64},
      {Method::runge_kutta_4, 4, 1.0 / 16},       {Method::tsitouras_5, 5, 1.0 / 16},
      {Method::dormand_prince_5, 5, 1.0 / 16},    {Method::extrapolation_8, 8, 1.0 / 2}};
  for (const auto& [method, order, step] : cases) {
    const double coarse = error_of_oscillator(fixed(method, step), 10);
    const double fine = error_of_oscillator(fixed(method, step / 2), 10);
    EXPECT_NEAR(std::log2(coarse / fine), order, 0.15) << order;
  }
}

TEST(Integrate, AFixedStepThatDoesNotDivideTheTimeIsShortenedAtTheEnd) {
  EXPECT_LT(error_of_oscillator(fixed(Method::dormand_prince_5, 0.03), 1), 1e-9);
  Batch batch(&harmonic_oscillator_kernels, Precision::float64, 3);
  const Integrated result =
      batch.integrate(std::vector{1.0, 0.1, 0.01}, fixed(Method::runge_kutta_4, 0.03));
  EXPECT_EQ(result.steps, (std::vector<std::uint32_t>{34, 4, 1}));
}

TEST(Integrate, ErrorFollowsTheTolerance) {
  for (const Method method :
       {Method::tsitouras_5, Method::dormand_prince_5, Method::extrapolation_8}) {
    for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10}) {
      // Ten periods; the errors of some hundred steps add up.
      const double error = error_of_oscillator(adaptive(method, tolerance), 20 * M_PI);
      EXPECT_LT(error, 100 * tolerance);
      EXPECT_GT(error, tolerance / 1000);
    }
  }
}

// The book's boat from rest: v' = 2 - 0.1 v. At dt = 0.5 s the whole step and the two halves differ
// by 0.0125 m/s, from which the book gets the steps for three tolerances.   [Bourg & Bywalec 7.2]
TEST(Integrate, StepDoublingKnowsTheErrorOfTheBooksFirstStep) {
  using V = kernels::ScalarLane<double>;
  const auto rate = [](V, const std::array<V, 1>& v) {
    return std::array<V, 1>{V(2) - V(0.1) * v[0]};
  };
  const std::array<V, 1> rest{V(0)};
  const auto step = [&](double dt) {
    return integrators::step_doubling_euler(rest, rate(V(0), rest), V(0), V(dt), rate);
  };
  const double error = step(0.5).error[0].value();
  EXPECT_NEAR(error, 0.0125, 1e-15);
  const struct {
    double tolerance, dt, speed;
  } book[] = {{0.01, 0.4472135955, 0.8944271910},
              {0.001, 0.1414213562, 0.2828427125},
              {1e-4, 0.0447213595, 0.0894427191}};
  for (const auto& [tolerance, dt, speed] : book) {
    const double shorter = 0.5 * std::sqrt(tolerance / error);
    EXPECT_NEAR(shorter, dt, 5e-11);
    EXPECT_NEAR(step(shorter).result[0].value(), speed, 1e-10);
  }
}

TEST(Integrate, StepDoublingFollowsTheTolerance) {
  double before = 1;
  for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5}) {
    Batch batch(&boat_kernels, Precision::float64, 1);
    Integration integration = fixed(Method::step_doubling_euler, 0.5);
    integration.absolute_tolerance = tolerance;
    batch.integrate(std::vector{20.0}, integration);
    const double error = std::abs(batch.column<double>("v")[0] - 20 * (1 - std::exp(-2.0)));
    EXPECT_LT(error, before);
    EXPECT_LT(error, 20 * std::sqrt(tolerance));
    before = error;
  }
}

TEST(Integrate, NoStepIsLongerThanTheLargest) {
  Batch batch(&boat_kernels, Precision::float64, 1);
  Integration integration = adaptive(Method::dormand_prince_5, 1e-3);
  EXPECT_LT(batch.integrate(std::vector{10.0}, integration).steps[0], 20U);
  Batch limited(&boat_kernels, Precision::float64, 1);
  integration.largest_step = 0.125;
  integration.step = 1;
  EXPECT_EQ(limited.integrate(std::vector{10.0}, integration).steps[0], 80U);
  integration.largest_step = 0;
  EXPECT_THROW(limited.integrate(std::vector{10.0}, integration), std::invalid_argument);
}

TEST(Integrate, AnAccuracyIsThatOfTheEnd) {
  for (const Method method :
       {Method::tsitouras_5, Method::dormand_prince_5, Method::extrapolation_8}) {
    for (const double accuracy : {1e-3, 1e-6, 1e-9}) {
      Integration integration = fixed(method, 0.01);
      integration.accuracy = accuracy;
      EXPECT_LT(error_of_oscillator(integration, 20 * M_PI), accuracy);
    }
  }
}

TEST(Integrate, RowsOfAnAccuracyHaveOneHashAndAreTheSameAlone) {
  Integration integration = fixed(Method::dormand_prince_5, 0.01);
  integration.stop_at = std::nullopt;
  integration.record = 4;
  integration.accuracy = 1e-6;
  integration.samples.levels = {0.05, 0.5, 1.5};
  const Finished reference = finish(Precision::float64, integration, Isa::scalar, 1);
  for (const Isa isa : solver::available_isas()) {
    const Finished same = finish(Precision::float64, integration, isa, 3);
    EXPECT_EQ(same.hash, reference.hash) << name(isa);
    EXPECT_EQ(same.result.steps, reference.result.steps);
  }
  std::vector<double> end;
  const Batch source = make_shots(Precision::float64, end);
  for (const std::size_t row : {0, 7, 999}) {
    Batch alone(&shot_in_air_kernels, Precision::float64, 1);
    for (std::size_t f = 1; f < source.table().fields().size(); ++f) {
      const std::string_view field = source.table().fields()[f].name;
      alone.column<double>(field)[0] = source.table().column<double>(f)[row];
    }
    const Integrated one = alone.integrate(std::vector{end[row]}, integration);
    EXPECT_EQ(one.steps[0], reference.result.steps[row]);
    EXPECT_EQ(one.time[0], reference.result.time[row]);
    for (std::size_t k = 0; k < 3; ++k) {
      const double here = one.samples.state[0][k];
      const double there = reference.result.samples.state[0][row * 3 + k];
      EXPECT_TRUE(here == there || (std::isnan(here) && std::isnan(there)));
    }
  }
}

TEST(Integrate, AnAccuracyThatNoToleranceReachesIsToldOf) {
  // The Lorenz equations lose a digit every 2.5 s: after 60 s nothing is left.
  Batch batch(&lorenz_kernels, Precision::float64, 2);
  batch.column<double>("x")[0] = batch.column<double>("x")[1] = 1;
  Integration integration = fixed(Method::dormand_prince_5, 0.01);
  integration.accuracy = 1e-3;
  const Integrated result = batch.integrate(std::vector{5.0, 100.0}, integration);
  EXPECT_EQ(result.outcome[0], Outcome::time_limit);
  EXPECT_EQ(result.outcome[1], Outcome::not_accurate);
  integration.method = Method::runge_kutta_4;
  EXPECT_THROW(batch.integrate(std::vector{5.0, 5.0}, integration), std::invalid_argument);
}

TEST(Integrate, StiffDampingOnlyCostsSteps) {
  Batch batch(&harmonic_oscillator_kernels, Precision::float64, 1);
  batch.column<double>("frequency")[0] = 10;
  batch.column<double>("damping")[0] = 20;
  batch.integrate(std::vector{5.0}, adaptive(Method::dormand_prince_5, 1e-8));
  // x = (r2 e^(r1 t) - r1 e^(r2 t)) / (r2 - r1), r = w (-d +- sqrt(d^2 - 1))
  const double r1 = 10 * (-20 + std::sqrt(399.0));
  const double r2 = 10 * (-20 - std::sqrt(399.0));
  const double exact = (r2 * std::exp(r1 * 5) - r1 * std::exp(r2 * 5)) / (r2 - r1);
  EXPECT_NEAR(batch.column<double>("x")[0], exact, 1e-7);
}

TEST(Integrate, AShotReachesItsTerminalVelocity) {
  Batch batch(&shot_in_air_kernels, Precision::float64, 1);
  batch.column<double>("drag_factor")[0] = 0.01;
  batch.integrate(std::vector{100.0}, adaptive(Method::dormand_prince_5, 1e-10));
  EXPECT_NEAR(batch.column<double>("vy")[0], -std::sqrt(9.80665 / 0.01), 1e-6);
}

TEST(Integrate, HasOneHashForEveryInstructionSetAndThreadCount) {
  for (const Precision precision : {Precision::float32, Precision::float64}) {
    const double tolerance = precision == Precision::float32 ? 1e-4 : 1e-9;
    for (const Integration& integration :
         {fixed(Method::runge_kutta_4, 0.01), fixed(Method::tsitouras_5, 0.01),
          fixed(Method::heun, 0.01), adaptive(Method::tsitouras_5, tolerance),
          adaptive(Method::dormand_prince_5, tolerance),
          adaptive(Method::extrapolation_8, tolerance),
          adaptive(Method::step_doubling_euler, 1e-3)}) {
      const Finished reference = finish(precision, integration, Isa::scalar, 1);
      for (const Isa isa : solver::available_isas()) {
        for (const int threads : {1, 2, 3, 13}) {
          const Finished same = finish(precision, integration, isa, threads);
          EXPECT_EQ(same.hash, reference.hash) << name(isa) << ", " << threads << " threads";
          EXPECT_EQ(same.result.steps, reference.result.steps);
          EXPECT_EQ(same.result.time, reference.result.time);
          EXPECT_EQ(same.result.outcome, reference.result.outcome);
        }
      }
    }
  }
}

TEST(Integrate, ARowAloneHasTheBitsThatItHasAmongOthers) {
  const Integration integration = adaptive(Method::dormand_prince_5, 1e-9);
  std::vector<double> end;
  Batch all = make_shots(Precision::float64, end);
  all.integrate(end, integration);
  for (const std::size_t row : {0, 1, 500, 998, 999}) {
    Batch source = make_shots(Precision::float64, end);
    Batch alone(&shot_in_air_kernels, Precision::float64, 1);
    for (const auto* field : {"x", "y", "z", "vx", "vy", "vz", "drag_factor", "wind_z", "ground"}) {
      alone.column<double>(field)[0] = source.column<double>(field)[row];
    }
    alone.integrate(std::vector{end[row]}, integration);
    for (const auto* field : {"x", "y", "z", "vx", "vy", "vz"}) {
      EXPECT_EQ(alone.column<double>(field)[0], all.column<double>(field)[row]) << field;
    }
  }
}

TEST(Integrate, LanesAreRefilled) {
  // Durations from 0.1 to 2 s: without refilling, four packs would wait for their longest row.
  std::vector<double> end;
  Batch batch = make_shots(Precision::float64, end);
  const Integrated result = batch.integrate(end, fixed(Method::runge_kutta_4, 1e-3));
  EXPECT_GT(result.simd_efficiency(), 0.9);
  EXPECT_LE(result.simd_efficiency(), 1);
}

TEST(Integrate, TellsWhyARowEnded) {
  Batch batch(&lorenz_kernels, Precision::float64, 3);
  batch.column<double>("sigma")[1] = 1e8;  // explodes at this step
  batch.column<double>("x")[1] = 1e8;
  Integration integration = fixed(Method::runge_kutta_4, 0.01);
  integration.most_steps = 500;
  const Integrated result = batch.integrate(std::vector{1.0, 1.0, 10.0}, integration);
  EXPECT_EQ(result.outcome[0], Outcome::time_limit);
  EXPECT_EQ(result.outcome[1], Outcome::not_finite);
  EXPECT_EQ(result.outcome[2], Outcome::step_limit);
  EXPECT_EQ(result.steps[2], 500U);
  EXPECT_NEAR(result.time[2], 5, 1e-12);
  EXPECT_LT(result.time[1], 1);
}

TEST(Integrate, AStepBelowTheSmallestEndsTheRowAtItsLastGoodState) {
  Batch batch(&lorenz_kernels, Precision::float64, 1);
  Integration integration = adaptive(Method::tsitouras_5, 1e-12);
  integration.smallest_step = 0.005;
  const Integrated result = batch.integrate(std::vector{10.0}, integration);
  EXPECT_EQ(result.outcome[0], Outcome::smallest_step);
  EXPECT_TRUE(std::isfinite(batch.column<double>("x")[0]));
}

// Without air the way up and down is 2 v / g, from a height h (v + sqrt(v^2 + 2 g h)) / g.
TEST(Integrate, AShotInVacuumEndsOnTheGroundToTheLastBits) {
  constexpr std::size_t rows = 100;
  for (const Method method : {Method::tsitouras_5, Method::dormand_prince_5}) {
    Batch batch(&shot_in_air_kernels, Precision::float64, rows);
    for (std::size_t i = 0; i < rows; ++i) {
      batch.column<double>("vx")[i] = 100;
      batch.column<double>("vy")[i] = 1 + static_cast<double>(i);
      batch.column<double>("ground")[i] = -static_cast<double>(i % 7);
    }
    const Integrated result = batch.integrate(std::vector(rows, 1e3), adaptive(method, 1e-9));
    for (std::size_t i = 0; i < rows; ++i) {
      const double g = 9.80665;
      const double v = 1 + static_cast<double>(i);
      const double h = static_cast<double>(i % 7);
      const double exact = (v + std::sqrt(v * v + 2 * g * h)) / g;
      EXPECT_EQ(result.outcome[i], Outcome::event);
      EXPECT_EQ(result.event[i], 0);
      EXPECT_NEAR(result.time[i], exact, 1e-14 * exact);
      EXPECT_NEAR(batch.column<double>("x")[i], 100 * exact, 1e-12 * exact * 100);
      EXPECT_NEAR(batch.column<double>("y")[i], -h, 1e-13 * v * v);
    }
  }
}

TEST(Integrate, AnImpactWithDragIsThatOfAFinerTolerance) {
  const auto impact = [](Method method, double tolerance) {
    std::vector<double> end;
    Batch batch = make_shots(Precision::float64, end);
    const Integrated result = batch.integrate(std::vector(shots, 1e3), adaptive(method, tolerance));
    std::vector<double> places;
    for (std::size_t i = 0; i < shots; i += 3) {
      EXPECT_EQ(result.outcome[i], Outcome::event);
      places.push_back(batch.column<double>("x")[i]);
    }
    return places;
  };
  const std::vector<double> exact = impact(Method::tsitouras_5, 1e-13);
  for (const Method method : {Method::tsitouras_5, Method::dormand_prince_5}) {
    double worst = 0;
    const std::vector<double> places = impact(method, 1e-8);
    for (std::size_t i = 0; i < places.size(); ++i) {
      worst = std::max(worst, std::abs(places[i] - exact[i]) / std::max(exact[i], 1.0));
    }
    EXPECT_LT(worst, 1e-6);
  }
}

TEST(Integrate, RefusesWhatCannotBe) {
  Batch batch(&lorenz_kernels, Precision::float64, 2);
  const std::vector<double> end{1.0, 1.0};
  const Integration good = fixed(Method::runge_kutta_4, 0.01);
  EXPECT_THROW(batch.integrate(std::vector{1.0}, good), std::invalid_argument);
  EXPECT_THROW(batch.integrate(std::vector{1.0, -1.0}, good), std::invalid_argument);
  EXPECT_THROW(batch.integrate(std::vector{1.0, std::nan("")}, good), std::invalid_argument);
  EXPECT_THROW(batch.integrate(end, fixed(Method::runge_kutta_4, 0)), std::invalid_argument);
  EXPECT_THROW(batch.integrate(end, adaptive(Method::runge_kutta_4, 1e-6)), std::invalid_argument);
  EXPECT_THROW(batch.integrate(end, adaptive(Method::tsitouras_5, -1)), std::invalid_argument);
  EXPECT_THROW(batch.integrate(end, fixed(Method::semi_implicit_euler, 0.01)),
               std::invalid_argument);
  Integration sampled = good;
  sampled.samples.levels = {2, 1};
  EXPECT_THROW(batch.integrate(end, sampled), std::invalid_argument);
}

}  // namespace salvo::tests
