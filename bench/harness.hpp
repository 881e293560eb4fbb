// Shared by the benchmarks: timing, the scene that they step, the names of their rows.
#pragma once

#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "bench/ceiling_kernels.hpp"
#include "solver/world.hpp"

namespace salvo::bench {

/// Seconds on the steady clock.
double now();

double median(std::vector<double> values);

std::string name(soa::Precision precision);

/// Whether bench.sh --quick runs us: smaller and fewer rounds where a round takes seconds.
bool quick();

/// A world of `rows` live particles in free flight: gravity, quadratic drag, uniform wind,
/// semi-implicit Euler, masses and drag areas that differ. Kept between benchmarks, because drawing
/// 2^24 particles takes longer than stepping them.
solver::World& free_world(soa::Precision precision, std::size_t rows);
/// The same particles over a plane, a sphere and a box.
solver::World& obstacle_world(soa::Precision precision, std::size_t rows);
void drop_worlds();

/// One sweep of read-modify-write over the world's columns, widest instruction set.
void stream_once(solver::World& world, const solver::Parallel& parallel);
/// Bytes that one sweep reads and writes.
double stream_bytes(const solver::World& world);

/// The state hash after 64 steps of a small world made by `make`, for a row's label: one bit off
/// and it shows.
std::string proof_hash(solver::World& (*make)(soa::Precision, std::size_t),
                       soa::Precision precision, const solver::Execution& execution);

void register_ceilings();
void register_baseline();
void register_particles();
void register_state_hash();
void register_trajectories();
void register_contact_peer();
void register_recorded();
void register_contacts();

}  // namespace salvo::bench
