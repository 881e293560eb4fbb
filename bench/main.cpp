// salvo's benchmarks. Every speed is a ratio taken within one run: the rounds of a row alternate
// with rounds of its ceiling.
#include <cstdlib>

#include "bench/granular_packing.hpp"
#include "bench/harness.hpp"

int main(int argc, char** argv) {
  using namespace salvo::bench;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::AddCustomContext("isa_widest",
                              std::string(salvo::solver::name(salvo::solver::widest_isa())));
  benchmark::AddCustomContext("contact", GranularScene::conditions());
  register_ceilings();
  register_baseline();
  register_particles();
  register_state_hash();
  register_trajectories();
  register_contacts();
#ifdef SALVO_BENCH_LAMMPS
  register_contact_peer();
#endif
#ifdef SALVO_BENCH_RECORDED
  register_recorded();
#endif
  benchmark::RunSpecifiedBenchmarks();
  drop_worlds();
  return EXIT_SUCCESS;
}
