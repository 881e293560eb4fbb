// The ceilings, `stream/rmw` and `peak/muladd`, and what the other benchmarks share.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <map>
#include <memory>
#include <stdexcept>

#include "bench/harness.hpp"

namespace salvo::bench {

namespace scalar {
extern const CeilingKernels ceiling_kernel_table;
}
#if defined(__x86_64__)
namespace sse2 {
extern const CeilingKernels ceiling_kernel_table;
}
namespace avx2 {
extern const CeilingKernels ceiling_kernel_table;
}
#ifndef SALVO_NO_AVX512
namespace avx512 {
extern const CeilingKernels ceiling_kernel_table;
}
#endif
#elif defined(__aarch64__)
namespace neon {
extern const CeilingKernels ceiling_kernel_table;
}
#endif

const CeilingKernels& ceiling_kernels(solver::Isa isa) {
  switch (isa) {
    case solver::Isa::scalar:
      return scalar::ceiling_kernel_table;
#if defined(__x86_64__)
    case solver::Isa::sse2:
      return sse2::ceiling_kernel_table;
    case solver::Isa::avx2:
      return avx2::ceiling_kernel_table;
#ifndef SALVO_NO_AVX512
    case solver::Isa::avx512:
      return avx512::ceiling_kernel_table;
#endif
#elif defined(__aarch64__)
    case solver::Isa::neon:
      return neon::ceiling_kernel_table;
#endif
    default:
      throw std::invalid_argument("no ceiling kernels for this instruction set");
  }
}

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

bool quick() { return std::getenv("SALVO_BENCH_QUICK") != nullptr; }

std::string name(soa::Precision precision) {
  return precision == soa::Precision::float32 ? "float" : "double";
}

namespace {

constexpr std::size_t tile = 4096;

solver::Setup free_flight(soa::Precision precision, std::size_t rows) {
  solver::Setup setup;
  setup.precision = precision;
  setup.seed = 2026;
  setup.dt = 1e-3;
  setup.forces.quadratic_drag = true;
  setup.forces.windy = true;
  setup.forces.wind.velocity = {3, 0, 1};
  solver::Emitter burst;
  burst.count = rows;
  burst.position = {0, 100, 0};
  burst.source_radius = 5;
  burst.speed = {solver::Spread::Kind::uniform, 10, 60};
  burst.mass = {solver::Spread::Kind::uniform, 0.01, 0.1};
  burst.drag_area = {solver::Spread::Kind::uniform, 1e-4, 1e-3};
  burst.radius = {solver::Spread::Kind::constant, 0.02, 0};
  setup.emitters.push_back(burst);
  return setup;
}

solver::Setup over_obstacles(soa::Precision precision, std::size_t rows) {
  solver::Setup setup = free_flight(precision, rows);
  models::Obstacle ground;
  ground.friction = 0.3;
  models::Obstacle sphere;
  sphere.shape = models::ObstacleShape::sphere;
  sphere.center = {4, 2, 0};
  sphere.radius = 2;
  models::Obstacle box;
  box.shape = models::ObstacleShape::box;
  box.center = {-4, 1, 2};
  box.half_size = {1, 1, 2};
  // Close by: half of the particles have met something after 64 steps.
  setup.emitters.front().position = {0, 2, 0};
  setup.emitters.front().source_radius = 1;
  setup.obstacles = {ground, sphere, box};
  return setup;
}

// At most one world at a time: 2^24 particles of doubles take over a gigabyte.
struct Kept {
  std::string key;
  std::unique_ptr<solver::World> world;
};
Kept kept;

solver::World& keep(const std::string& key, const solver::Setup& setup) {
  if (kept.key != key) {
    kept.world.reset();
    kept.world = std::make_unique<solver::World>(setup, solver::Execution{});
    kept.key = key;
  }
  return *kept.world;
}

template <class T>
StreamColumns<T> columns_of(solver::World& world) {
  auto& table = const_cast<soa::Table&>(world.particles());
  using soa::ParticleField;
  const auto at = [](ParticleField field) { return static_cast<std::size_t>(field); };
  StreamColumns<T> columns;
  for (std::size_t c = 0; c < 3; ++c) {
    columns.written[c] = table.column<T>(at(ParticleField::position), c);
    columns.written[3 + c] = table.column<T>(at(ParticleField::velocity), c);
  }
  columns.read[0] = table.column<T>(at(ParticleField::mass));
  columns.read[1] = table.column<T>(at(ParticleField::drag_area));
  return columns;
}

}  // namespace

solver::World& free_world(soa::Precision precision, std::size_t rows) {
  return keep(fmt::format("free {} {}", name(precision), rows), free_flight(precision, rows));
}

solver::World& obstacle_world(soa::Precision precision, std::size_t rows) {
  return keep(fmt::format("obstacles {} {}", name(precision), rows),
              over_obstacles(precision, rows));
}

void drop_worlds() { kept = {}; }

// Two sweeps restore the state: each flips the signs.
void stream_once(solver::World& world, const solver::Parallel& parallel) {
  const CeilingKernels& kernels = ceiling_kernels(solver::widest_isa());
  const std::size_t rows = world.particles().padded_rows();
  const std::size_t tiles = (rows + tile - 1) / tile;
  parallel.for_each(tiles, [&](std::size_t t) {
    const std::size_t last = std::min(rows, (t + 1) * tile);
    if (world.particles().precision() == soa::Precision::float32) {
      kernels.stream_float32(columns_of<float>(world), t * tile, last);
    } else {
      kernels.stream_float64(columns_of<double>(world), t * tile, last);
    }
  });
}

double stream_bytes(const solver::World& world) {
  const double real = world.particles().precision() == soa::Precision::float32 ? 4 : 8;
  return static_cast<double>(world.particles().rows()) * (6 * 2 + 2) * real;
}

std::string proof_hash(solver::World& (*make)(soa::Precision, std::size_t),
                       soa::Precision precision, const solver::Execution& execution) {
  constexpr std::size_t proof_rows = 20011;  // a multiple of nothing
  solver::World world(make(precision, proof_rows).setup(), execution);
  world.advance_to(64);
  return to_string(world.hash().total);
}

void register_ceilings() {
  for (const soa::Precision precision : {soa::Precision::float32, soa::Precision::float64}) {
    for (const std::size_t rows : {std::size_t{1} << 20, std::size_t{1} << 24}) {
      for (const int threads : {1, 2}) {
        benchmark::RegisterBenchmark(
            fmt::format("stream/rmw/real:{}/n:{}/threads:{}", name(precision), rows, threads)
                .c_str(),
            [=](benchmark::State& state) {
              solver::World& world = free_world(precision, rows);
              const solver::Parallel parallel(threads);
              std::vector<double> seconds;
              for (auto _ : state) {
                const double start = now();
                stream_once(world, parallel);
                stream_once(world, parallel);
                seconds.push_back((now() - start) / 2);
              }
              std::sort(seconds.begin(), seconds.end());
              const double median = seconds[seconds.size() / 2];
              state.counters["rows_per_second"] = static_cast<double>(rows) / median;
              state.counters["bytes_per_second"] = stream_bytes(world) / median;
            })
            ->Unit(benchmark::kMillisecond);
      }
    }
  }
  for (const soa::Precision precision : {soa::Precision::float32, soa::Precision::float64}) {
    for (const solver::Isa isa : solver::available_isas()) {
      benchmark::RegisterBenchmark(
          fmt::format("peak/muladd/isa:{}/real:{}", solver::name(isa), name(precision)).c_str(),
          [=](benchmark::State& state) {
            constexpr std::size_t rounds = 1 << 20;
            const CeilingKernels& kernels = ceiling_kernels(isa);
            const bool single = precision == soa::Precision::float32;
            double best = 1e9;
            for (auto _ : state) {
              const double start = now();
              benchmark::DoNotOptimize(single ? kernels.multiply_add_float32(rounds)
                                              : kernels.multiply_add_float64(rounds));
              best = std::min(best, now() - start);
            }
            const std::size_t width = single ? kernels.width_float32 : kernels.width_float64;
            state.counters["flops_per_second"] =
                static_cast<double>(rounds * width * peak_packs * 2) / best;
          })
          ->Unit(benchmark::kMillisecond);
    }
  }
}

}  // namespace salvo::bench
