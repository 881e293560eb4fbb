// What the state hash costs: bytes of state hashed a second, and frames of a million particles.
#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "bench/harness.hpp"

namespace salvo::bench {

void register_state_hash() {
  for (const soa::Precision precision : {soa::Precision::float32, soa::Precision::float64}) {
    for (const int threads : {1, 2}) {
      constexpr std::size_t rows = 1 << 20;
      benchmark::RegisterBenchmark(
          fmt::format("hash/state/real:{}/n:{}/threads:{}", name(precision), rows, threads).c_str(),
          [=](benchmark::State& state) {
            solver::World& world = free_world(precision, rows);
            world.execute_as({solver::widest_isa(), threads, 16});
            std::vector<double> seconds;
            for (auto _ : state) {
              const double start = now();
              benchmark::DoNotOptimize(world.hash());
              seconds.push_back(now() - start);
            }
            std::sort(seconds.begin(), seconds.end());
            const double median = seconds[seconds.size() / 2];
            state.counters["rows_per_second"] = static_cast<double>(rows) / median;
            state.counters["bytes_per_second"] =
                static_cast<double>(solver::World::state_bytes(world.setup())) / median;
          })
          ->Unit(benchmark::kMillisecond);
    }
  }
}

}  // namespace salvo::bench
