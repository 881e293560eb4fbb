// LAMMPS on a granular packing, by its C library on one core: pair style gran/hooke/history, fix
// wall/gran hooke/history on the six walls, fix nve/sphere.
//
// What it computes, of LAMMPS 29 Sep 2021 (src/GRANULAR/pair_gran_hooke_history.cpp and
// fix_wall_gran.cpp): for spheres i and j at the distance r < R_i + R_j, with
//
//   n = (x_i - x_j) / r                   overlap d = R_i + R_j - r
//   m = m_i m_j / (m_i + m_j)             the effective mass
//   u = v_i - v_j                         u_n = u.n
//   w = u - u_n n + n x (R_i omega_i + R_j omega_j)     sliding; arms are radii, not radii less d/2
//
//   N = k_n d - m gamma_n u_n             with limit_damping: N = max(N, 0)
//   s <- s + w dt, then s <- s - (s.n) n  the slide: it is turned by projection, which shortens it
//   T = -(k_t s + m gamma_t w)
//   if |T| > mu |N|:                      Coulomb's limit; of |N|, so that a pull has friction too
//     T <- T mu |N| / |T|, and s <- -(T + m gamma_t w) / k_t, so that the law gives this T
//     (T = 0 where the slide was zero before its projection)
//   F_i += N n + T, F_j -= N n + T
//   tau_i -= R_i n x T, tau_j -= R_j n x T
//
// s starts at zero when a pair touches and is forgotten when it parts; one a pair, as a vector of
// i's, and minus it is j's. A wall is a sphere j at rest with R_j = omega_j = 0 and m = m_i whose
// x_j is x_i's foot on the wall; of two opposite walls the nearer one alone.
//
// fix nve/sphere is velocity Verlet with moment of inertia 2/5 m R^2, and forces see the velocities
// and spins of the half step: v += dt F(x, v) / m, x += dt v of velocities half a step behind. A
// semi-implicit Euler step is the same map; only a run's first and last half steps differ, and the
// first force of a run, which leaves s as it is.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "bench/granular_packing.hpp"

namespace salvo::bench {

struct GranularRun {
  std::int64_t particle_steps;
  double seconds;  // of the loop over the steps, by LAMMPS' clock
  // Parts of it: forces of pairs, building lists, integration with walls and keeping the history
  // across builds, the rest (sorting, binning for exchange, deciding).
  double pair_fraction, neighbour_fraction, modify_fraction, other_fraction;
  std::int64_t neighbour_builds;
  std::int64_t dangerous_builds;   // later than they should have been; -1: not checked
  double neighbours_per_particle;  // pairs of the last list, each once, over particles
  double contacts_per_particle;    // pairs in touch at the end, each once, over particles
  std::array<double, 3> momentum;
  double kinetic_energy;  // of translation, J
  double spin_energy;     // of rotation, J
};

/// One packing in LAMMPS, which ends the process on an error, as Debian builds it.
class LammpsGranular {
 public:
  /// Lists hold pairs whose gap is under `skin` (m); they are built every `rebuild_every` steps, or
  /// when zero whenever a particle has moved half the skin since.
  LammpsGranular(const GranularPacking& packing, const GranularLaw& law, double dt, double skin,
                 int rebuild_every);
  ~LammpsGranular();
  LammpsGranular(const LammpsGranular&) = delete;
  LammpsGranular& operator=(const LammpsGranular&) = delete;

  /// The first one also builds the first lists, outside `seconds`; later ones go on where the last
  /// one ended.
  GranularRun run(std::int64_t steps);

  /// The library's, a date: 20210929.
  int version() const;
  /// Three numbers a particle, in order of id.
  std::vector<double> positions() const { return gathered("x"); }
  std::vector<double> velocities() const { return gathered("v"); }
  std::vector<double> spins() const { return gathered("omega"); }

 private:
  std::vector<double> gathered(const char* property) const;

  void* lammps_;
  int log_;
  std::size_t count_;
  double mass_;
  double radius_;
  bool ready_ = false;
  long long builds_ = 0;
  long long dangerous_ = 0;
};

}  // namespace salvo::bench
