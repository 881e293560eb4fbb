// LAMMPS on the spheres of contact/dense and contact/sparse: particle steps a second on one core.
#include <fmt/format.h>

#include "bench/granular_packing.hpp"
#include "bench/harness.hpp"
#include "bench/lammps_peer.hpp"

namespace salvo::bench {

namespace {

// Beyond the caches, where LAMMPS has half its rate for 32,000.
std::size_t spheres() { return quick() ? 200'000 : 1'000'000; }
// Until they collide as often as they part.
constexpr std::int64_t warm_up = 60;

// A round takes seconds, whatever the least time of a benchmark; bench.sh --quick asks for fewer.
int rounds() { return quick() ? 2 : 5; }

void measure(benchmark::State& state, const GranularScene& scene) {
  LammpsGranular lammps(scene.packing(spheres()), GranularScene::law(), GranularScene::dt(),
                        GranularScene::skin, GranularScene::rebuild_every);
  lammps.run(warm_up);
  std::vector<double> seconds;
  GranularRun run{};
  double total = 0;
  double pair = 0;
  double neighbour = 0;
  double modify = 0;
  for (auto _ : state) {
    // One build of the lists a round.
    for (int round = 0; round < rounds(); ++round) {
      run = lammps.run(GranularScene::rebuild_every);
      seconds.push_back(run.seconds);
      total += run.seconds;
      pair += run.pair_fraction * run.seconds;
      neighbour += run.neighbour_fraction * run.seconds;
      modify += run.modify_fraction * run.seconds;
    }
  }
  state.counters["particle_steps_per_second"] =
      static_cast<double>(run.particle_steps) / median(seconds);
  state.counters["spheres"] = static_cast<double>(spheres());
  state.counters["steps_per_build"] =
      static_cast<double>(GranularScene::rebuild_every) / static_cast<double>(run.neighbour_builds);
  state.counters["neighbours_per_particle"] = run.neighbours_per_particle;
  state.counters["contacts_per_particle"] = run.contacts_per_particle;
  state.counters["pair_fraction"] = pair / total;
  state.counters["neighbour_fraction"] = neighbour / total;
  state.counters["modify_fraction"] = modify / total;
  state.SetLabel(fmt::format("LAMMPS of {}", lammps.version()));
}

}  // namespace

void register_contact_peer() {
  for (const GranularScene& scene : granular_scenes()) {
    benchmark::RegisterBenchmark(
        fmt::format("peer/lammps/granular/{}/real:double/threads:1", scene.name).c_str(),
        [&scene](benchmark::State& state) { measure(state, scene); })
        ->Unit(benchmark::kMillisecond);
  }
}

}  // namespace salvo::bench
