// The baseline: the book's array of particle objects, same forces, g++ -O3 without -march.
#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "bench/aos_particles.hpp"
#include "bench/harness.hpp"

namespace salvo::bench {

void register_baseline() {
  for (const std::size_t rows : {std::size_t{1} << 20, std::size_t{1} << 24}) {
    const std::string row_name = rows == (1 << 24)
                                     ? "baseline/aos_particles"
                                     : fmt::format("baseline/aos_particles/n:{}", rows);
    benchmark::RegisterBenchmark(row_name.c_str(), [=](benchmark::State& state) {
      drop_worlds();
      book::air.wind = {3, 0, 1};
      std::vector<book::Particle> particles(rows);
      for (std::size_t i = 0; i < rows; ++i) {
        book::Particle& particle = particles[i];
        const auto spread = static_cast<float>(i % 1021);
        particle.fMass = 0.01F + 1e-4F * spread;
        particle.vPosition = {0, 100, 0};
        particle.vVelocity = {spread * 0.05F, 20, -spread * 0.03F};
        particle.vGravity = {0, -9.80665F * particle.fMass, 0};
        particle.fRadius = 0.02F;
      }
      std::vector<double> seconds;
      for (auto _ : state) {
        const double start = now();
        book::step(particles.data(), static_cast<long>(rows), 1e-3);
        seconds.push_back(now() - start);
      }
      benchmark::DoNotOptimize(particles.data());
      std::sort(seconds.begin(), seconds.end());
      const double rate = static_cast<double>(rows) / seconds[seconds.size() / 2];
      state.counters["particle_steps_per_second"] = rate;
      state.counters["bytes_per_particle"] = sizeof(book::Particle);
      state.SetLabel(fmt::format("{} bytes a particle", sizeof(book::Particle)));
    })->Unit(benchmark::kMillisecond);
  }
}

}  // namespace salvo::bench
