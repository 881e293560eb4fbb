// Trajectories a second, each by itself to its own end: fixed steps of a shot with drag and of the
// Lorenz equations, and rows whose durations are spread tenfold; beside Boost.odeint and SUNDIALS
// on the same problems, in the same run.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "bench/harness.hpp"
#include "solver/models.hpp"
#ifdef SALVO_BENCH_ODEINT
#include "bench/odeint_peer.hpp"
#endif
#ifdef SALVO_BENCH_SUNDIALS
#include "bench/sundials_peer.hpp"
#endif

namespace salvo::bench {

namespace {

using solver::Batch;
using solver::Integration;
using solver::Isa;
using solver::Method;

constexpr std::size_t rows = 16384;
[[maybe_unused]] constexpr std::size_t peer_rows = rows / 16;
constexpr std::int64_t steps = 1000;
// Keep the worst impact of 16,384 shots within 1 mm of that of a tolerance of 1e-12. An absolute
// one of 0.1 mm, because the relative one says nothing about a drift to the side that begins at
// zero.
constexpr double g7_absolute = 1e-4;
constexpr double g7_relative = 3e-8;

double drag_factor(std::size_t row) { return 1e-4 * (1 + static_cast<double>(row % 64) / 64); }
double speed(std::size_t row) { return 200 + static_cast<double>(row * 37 % rows) / 32; }
double rho(std::size_t row) { return 21 * static_cast<double>(row + 1) / rows; }

Batch drag_shots() {
  Batch batch(&shot_in_air_kernels, soa::Precision::float64, rows);
  for (std::size_t row = 0; row < rows; ++row) {
    batch.column<double>("vx")[row] = speed(row);
    batch.column<double>("vy")[row] = speed(row) / 4;
    batch.column<double>("drag_factor")[row] = drag_factor(row);
  }
  return batch;
}

Batch lorenz_systems() {
  Batch batch(&lorenz_kernels, soa::Precision::float64, rows);
  for (std::size_t row = 0; row < rows; ++row) batch.column<double>("rho")[row] = rho(row);
  return batch;
}

// 2 km, BC 0.22 G7, 800 m/s.
Batch g7_shots() {
  Batch batch(&projectile_kernels, soa::Precision::float64, rows);
  for (std::size_t row = 0; row < rows; ++row) {
    const double elevation = 0.02 + 1e-5 * static_cast<double>(row % 997);
    batch.column<double>("vx")[row] = 800 * std::cos(elevation);
    batch.column<double>("vy")[row] = 800 * std::sin(elevation);
    batch.column<double>("wind_z")[row] = static_cast<double>(row % 11) - 5;
    batch.column<double>("drag_factor")[row] = M_PI / 8 / (0.22 * 703.06957963916);
    batch.column<double>("range")[row] = 2000;
  }
  return batch;
}

struct Problem {
  std::string name;
  Batch (*make)();
  Method method;
  double dt;
  double shortest;  // of the durations over the longest, which takes `steps` steps
  double absolute;  // tolerances; zero: fixed steps
  double relative;
  bool counts_steps;
};

const std::vector<Problem>& problems() {
  static const std::vector<Problem> all = {
      {"rk4_drag", &drag_shots, Method::runge_kutta_4, 1e-2, 1, 0, 0, true},
      {"lorenz_tsit5", &lorenz_systems, Method::tsitouras_5, 1e-3, 1, 0, 0, false},
      {"mixed_durations", &drag_shots, Method::runge_kutta_4, 1e-2, 0.1, 0, 0, true},
      {"shot_g7", &g7_shots, Method::dormand_prince_5, 0.06, 1, g7_absolute, g7_relative, false},
  };
  return all;
}

std::vector<double> ends_of(const Problem& problem) {
  std::vector<double> end(rows);
  const double longest = problem.dt * static_cast<double>(steps);
  for (std::size_t row = 0; row < rows; ++row) {
    const double part = static_cast<double>(row * 7919 % rows) / rows;
    end[row] = longest * (problem.shortest + (1 - problem.shortest) * part);
  }
  return end;
}

using Impact = std::array<double, 3>;

std::vector<Impact> impacts(const Problem& problem, const Integration& integration, Isa isa,
                            int threads) {
  Batch batch = problem.make();
  batch.integrate(ends_of(problem), integration, isa, threads);
  std::vector<Impact> all(rows);
  for (std::size_t row = 0; row < rows; ++row) {
    const auto at = [&](const char* field) { return batch.column<double>(field)[row]; };
    all[row] = {at("x"), at("y"), at("z")};
  }
  return all;
}

// The worst distance of an impact, of the first rows, from that of a tolerance of 1e-12, in mm.
double worst_error_mm(const std::vector<Impact>& reached, const Problem& problem) {
  Integration converged;
  converged.method = problem.method;
  converged.step = problem.dt;
  converged.absolute_tolerance = converged.relative_tolerance = 1e-12;
  // The same bits whatever computes them, so by the fastest.
  const std::vector<Impact> exact =
      impacts(problem, converged, solver::widest_isa(), solver::hardware_threads());
  double worst = 0;
  for (std::size_t row = 0; row < reached.size(); ++row) {
    const auto off = [&](std::size_t i) { return reached[row][i] - exact[row][i]; };
    worst = std::max(worst, std::hypot(off(0), off(1), off(2)));
  }
  return 1e3 * worst;
}

void measure(benchmark::State& state, const Problem& problem, Isa isa, int threads) {
  const std::vector<double> end = ends_of(problem);
  Integration integration;
  integration.method = problem.method;
  integration.step = problem.dt;
  integration.absolute_tolerance = problem.absolute;
  integration.relative_tolerance = problem.relative;
  if (problem.absolute == 0) integration.stop_at = 0;
  double taken = 0;
  double efficiency = 0;
  std::vector<double> seconds;
  for (auto _ : state) {
    state.PauseTiming();
    Batch batch = problem.make();
    state.ResumeTiming();
    const double start = now();
    const solver::Integrated result = batch.integrate(end, integration, isa, threads);
    seconds.push_back(now() - start);
    efficiency = result.simd_efficiency();
    taken = std::accumulate(result.steps.begin(), result.steps.end(), 0.0);
    state.SetLabel(to_string(batch.hash().total));
  }
  const double typical = median(seconds);
  state.counters["items_per_second"] =
      (problem.counts_steps ? taken : static_cast<double>(rows)) / typical;
  state.counters["steps_per_second"] = taken / typical;
  state.counters["simd_efficiency"] = efficiency;
  if (problem.absolute > 0) {
    state.counters["worst_error_mm"] =
        worst_error_mm(impacts(problem, integration, isa, threads), problem);
  }
}

#ifdef SALVO_BENCH_ODEINT
void measure_odeint(benchmark::State& state, const Problem& problem) {
  std::vector<double> seconds;
  double kept = 0;
  for (auto _ : state) {
    double start = 0;
    if (problem.name == "rk4_drag") {
      std::vector<PeerShot> shots(peer_rows);
      for (std::size_t row = 0; row < peer_rows; ++row) {
        shots[row] = {{0, 0, 0, speed(row), speed(row) / 4, 0}, drag_factor(row)};
      }
      start = now();
      odeint_rk4_drag(shots.data(), peer_rows, steps, problem.dt);
      seconds.push_back(now() - start);
      kept = shots[1].state[0];
    } else {
      std::vector<std::array<double, 3>> states(peer_rows, {1, 0, 0});
      std::vector<double> rhos(peer_rows);
      for (std::size_t row = 0; row < peer_rows; ++row) rhos[row] = rho(row);
      start = now();
      odeint_lorenz(states.data(), rhos.data(), peer_rows, steps, problem.dt);
      seconds.push_back(now() - start);
      kept = states[1][0];
    }
    benchmark::DoNotOptimize(kept);
  }
  const double items =
      static_cast<double>(peer_rows) * (problem.counts_steps ? static_cast<double>(steps) : 1);
  state.counters["items_per_second"] = items / median(seconds);
}
#endif

#ifdef SALVO_BENCH_SUNDIALS
void measure_sundials(benchmark::State& state, const Problem& problem) {
  Batch batch = problem.make();
  std::vector<PeerG7Shot> shots(peer_rows);
  std::vector<double> seconds;
  for (auto _ : state) {
    for (std::size_t row = 0; row < peer_rows; ++row) {
      const auto at = [&](const char* field) { return batch.column<double>(field)[row]; };
      shots[row] = {{at("x"), at("y"), at("z"), at("vx"), at("vy"), at("vz")},
                    at("wind_z"),
                    at("drag_factor"),
                    at("range")};
    }
    const double start = now();
    sundials_shot_g7(shots.data(), peer_rows, problem.dt, problem.dt * static_cast<double>(steps));
    seconds.push_back(now() - start);
  }
  std::vector<Impact> reached(peer_rows);
  for (std::size_t row = 0; row < peer_rows; ++row) {
    std::copy_n(shots[row].state.begin(), 3, reached[row].begin());
  }
  state.counters["items_per_second"] = static_cast<double>(peer_rows) / median(seconds);
  state.counters["worst_error_mm"] = worst_error_mm(reached, problem);
}
#endif

}  // namespace

void register_trajectories() {
  for (const Problem& problem : problems()) {
    for (const Isa isa : solver::available_isas()) {
      for (const int threads : {1, 2}) {
        benchmark::RegisterBenchmark(fmt::format("trajectories/{}/isa:{}/threads:{}", problem.name,
                                                 solver::name(isa), threads)
                                         .c_str(),
                                     [&problem, isa, threads](benchmark::State& state) {
                                       measure(state, problem, isa, threads);
                                     })
            ->Unit(benchmark::kMillisecond);
      }
    }
    [[maybe_unused]] const auto beside = [&problem](const char* peer, auto measure_peer) {
      benchmark::RegisterBenchmark(
          fmt::format("peer/{}/{}", peer, problem.name).c_str(),
          [&problem, measure_peer](benchmark::State& state) { measure_peer(state, problem); })
          ->Unit(benchmark::kMillisecond);
    };
#ifdef SALVO_BENCH_ODEINT
    if (problem.shortest == 1 && problem.absolute == 0) beside("odeint", &measure_odeint);
#endif
#ifdef SALVO_BENCH_SUNDIALS
    if (problem.absolute > 0) beside("sundials", &measure_sundials);
#endif
  }
}

}  // namespace salvo::bench
