// Particle steps a second, in free flight and over obstacles. Rounds of a row alternate with rounds
// of its ceiling, the stream over the same columns on the same threads, so that the ratio holds
// when the machine's speed drifts.
#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "bench/harness.hpp"

namespace salvo::bench {

namespace {

// Multiplications, additions and square roots of one free step: flow 3, speed 6, drag 5, sum 3,
// velocity 6, position 6.
constexpr double flops_per_step = 29;

struct Row {
  std::string kind;
  solver::World& (*world)(soa::Precision, std::size_t);
  solver::Isa isa;
  soa::Precision precision;
  std::size_t rows;
  int substeps;
  int threads;

  std::string full_name() const {
    return fmt::format("particles/{}/isa:{}/real:{}/n:{}/substeps:{}/threads:{}", kind,
                       solver::name(isa), name(precision), rows, substeps, threads);
  }
};

void measure(benchmark::State& state, const Row& row) {
  const solver::Execution execution{row.isa, row.threads, row.substeps};
  const std::string hash = proof_hash(row.world, row.precision, execution);
  const std::string reference = proof_hash(row.world, row.precision, {solver::Isa::scalar, 1, 1});
  if (hash != reference) {
    state.SkipWithError("the bits differ from those of the scalar reference");
    return;
  }
  solver::World& world = row.world(row.precision, row.rows);
  world.execute_as(execution);
  std::vector<double> step_seconds;
  std::vector<double> stream_seconds;
  const auto stream = [&] {
    const double start = now();
    stream_once(world, world.parallel());
    stream_once(world, world.parallel());
    stream_seconds.push_back((now() - start) / 2);
  };
  stream();
  for (auto _ : state) {
    const double start = now();
    world.advance_to(world.step() + row.substeps);
    step_seconds.push_back(now() - start);
    state.PauseTiming();
    stream();
    state.ResumeTiming();
  }
  const auto rows = static_cast<double>(row.rows);
  const double rate = rows * row.substeps / median(step_seconds);
  const double stream_rate = rows / median(stream_seconds);
  state.counters["particle_steps_per_second"] = rate;
  state.counters["rows_per_second"] = rate / row.substeps;
  state.counters["bytes_per_second"] = stream_bytes(world) / median(step_seconds);
  state.counters["fraction_of_ceiling"] = rate / row.substeps / stream_rate;
  state.counters["steps_over_stream"] = rate / stream_rate;
  if (row.kind == "free") state.counters["flops_per_second"] = rate * flops_per_step;
  state.SetLabel(hash);
}

void add(const Row& row) {
  benchmark::RegisterBenchmark(row.full_name().c_str(), [row](benchmark::State& state) {
    measure(state, row);
  })->Unit(benchmark::kMillisecond);
}

}  // namespace

void register_particles() {
  const std::vector<solver::Isa> isas = solver::available_isas();
  for (const soa::Precision precision : {soa::Precision::float32, soa::Precision::float64}) {
    for (const std::size_t rows : {std::size_t{1} << 20, std::size_t{1} << 24}) {
      for (const solver::Isa isa : isas) {
        for (const int substeps : {1, 4, 16, 64}) {
          for (const int threads : {1, 2}) {
            // A round of the scalar reference takes many seconds, half a minute with 64 substeps.
            const bool slow = isa == solver::Isa::scalar && rows > (1 << 20);
            if (slow && (threads > 1 || substeps > 16)) continue;
            add({"free", &free_world, isa, precision, rows, substeps, threads});
          }
        }
      }
    }
    for (const solver::Isa isa : isas) {
      for (const int threads : {1, 2}) {
        add({"obstacles", &obstacle_world, isa, precision, 1 << 20, 16, threads});
      }
    }
  }
}

}  // namespace salvo::bench
