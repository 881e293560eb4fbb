#include "bench/lammps_peer.hpp"

#include <fmt/format.h>
#include <lammps/library.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace salvo::bench {

namespace {

// Built without exceptions, as by Debian, LAMMPS answers an error by ending the process, its
// message in a log that goes with it.
std::string underway;

void say_underway() {
  if (!underway.empty()) fmt::print(stderr, "LAMMPS ended the process at: {}\n", underway);
}

void command(void* lammps, const std::string& line) {
  underway = line;
  lammps_command(lammps, line.c_str());
  underway.clear();
  if (lammps_has_error(lammps)) throw std::runtime_error("LAMMPS failed at: " + line);
}

std::string read_all(int file) {
  std::string text(static_cast<std::size_t>(lseek(file, 0, SEEK_END)), '\0');
  text.resize(static_cast<std::size_t>(pread(file, text.data(), text.size(), 0)));
  return text;
}

// The number that follows `label` in the summary of a run; `missing` where no number does.
double number_after(const std::string& text, const std::string& label, double missing) {
  const std::size_t at = text.rfind(label);
  if (at == std::string::npos) return missing;
  const char* begin = text.c_str() + at + label.size();
  char* end = nullptr;
  const double number = std::strtod(begin, &end);
  return end == begin ? missing : number;
}

double number_after(const std::string& text, const std::string& label) {
  const double number = number_after(text, label, -1);
  if (number < 0) throw std::runtime_error("LAMMPS' log lacks \"" + label + "\"");
  return number;
}

double squared(const double* v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; }

// Pairs in touch among those of the pair style's list.
std::int64_t contacts(void* lammps, double diameter) {
  constexpr int index_bits = 0x1FFFFFFF;  // NEIGHMASK of LAMMPS' lmptype.h
  const int list = lammps_find_pair_neighlist(lammps, "gran/hooke/history", 1, 0, 0);
  const double* const* x = static_cast<double**>(lammps_extract_atom(lammps, "x"));
  std::int64_t touching = 0;
  for (int element = 0; element < lammps_neighlist_num_elements(lammps, list); ++element) {
    int i = 0;
    int count = 0;
    int* neighbours = nullptr;
    lammps_neighlist_element_neighbors(lammps, list, element, &i, &count, &neighbours);
    for (int k = 0; k < count; ++k) {
      const int j = neighbours[k] & index_bits;
      const double apart[] = {x[i][0] - x[j][0], x[i][1] - x[j][1], x[i][2] - x[j][2]};
      if (squared(apart) < diameter * diameter) ++touching;
    }
  }
  return touching;
}

}  // namespace

LammpsGranular::LammpsGranular(const GranularPacking& packing, const GranularLaw& law, double dt,
                               double skin, int rebuild_every)
    : log_(memfd_create("lammps", 0)),
      count_(packing.count()),
      mass_(packing.mass()),
      radius_(packing.radius) {
  // MPI leaves folders behind where nobody ends it.
  static const bool told =
      std::atexit(&lammps_mpi_finalize) == 0 && std::atexit(&say_underway) == 0;
  if (log_ < 0 || !told) throw std::runtime_error("no log for LAMMPS");

  std::string arguments[] = {"lammps", "-log", "none", "-screen", "none", "-nocite"};
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  lammps_ = lammps_open_no_mpi(static_cast<int>(argv.size()), argv.data(), nullptr);

  // The fastest of the ways to say it, together a fifth faster than LAMMPS' examples of this style:
  // bins as wide as the lists reach, not half, for building them; every pair of neighbours looked
  // for from one side (newton on); spheres sorted into blocks that the L2 cache holds, by eight
  // times that width, not half.
  const double reach = 2 * packing.radius + skin;
  for (const char* line :
       {"units si", "atom_style sphere", "boundary f f f", "newton on", "comm_modify vel yes"}) {
    command(lammps_, line);
  }
  command(lammps_, fmt::format("atom_modify map array sort 1000 {}", 8 * reach));
  command(lammps_, fmt::format("region box block 0 {0} 0 {0} 0 {0}", packing.edge));
  command(lammps_, "create_box 1 box");

  std::vector<int> id(count_);
  std::iota(id.begin(), id.end(), 1);
  const std::vector<int> type(count_, 1);
  const int created =
      lammps_create_atoms(lammps_, static_cast<int>(count_), id.data(), type.data(),
                          packing.position.data(), packing.velocity.data(), nullptr, 0);
  if (created != static_cast<int>(count_)) throw std::runtime_error("spheres outside the box");
  command(lammps_,
          fmt::format("set type 1 diameter {} density {}", 2 * packing.radius, packing.density));
  std::vector<double> spin = packing.spin;  // not written, but the interface says so nowhere
  std::string omega = "omega";
  lammps_scatter_atoms(lammps_, omega.data(), 1, 3, spin.data());

  const std::string with =
      fmt::format("hooke/history {} {} {} {} {} 1{}", law.normal_stiffness,
                  law.tangential_stiffness, law.normal_damping, law.tangential_damping,
                  law.friction, law.limit_damping ? " limit_damping" : "");
  command(lammps_, "pair_style gran/" + with);
  command(lammps_, "pair_coeff * *");
  command(lammps_, fmt::format("neighbor {} bin", skin));
  command(lammps_, fmt::format("neigh_modify delay 0 every {} check {} binsize {}",
                               rebuild_every > 0 ? rebuild_every : 1,
                               rebuild_every > 0 ? "no" : "yes", reach));
  command(lammps_, fmt::format("timestep {}", dt));
  command(lammps_, "fix motion all nve/sphere");
  for (const char axis : {'x', 'y', 'z'}) {
    command(lammps_,
            fmt::format("fix {0}walls all wall/gran {1} {0}plane 0 {2}", axis, with, packing.edge));
  }
  // The summary of energies at the end of a run: nothing that has to be computed.
  command(lammps_, "thermo_style custom step");
}

LammpsGranular::~LammpsGranular() {
  lammps_close(lammps_);
  close(log_);
}

GranularRun LammpsGranular::run(std::int64_t steps) {
  if (!ready_) command(lammps_, "run 0 post no");
  ready_ = true;
  command(lammps_, fmt::format("log /proc/self/fd/{}", log_));
  command(lammps_, fmt::format("run {} pre no", steps));
  command(lammps_, "log none");
  const std::string log = read_all(log_);

  GranularRun run{};
  run.particle_steps = steps * static_cast<std::int64_t>(count_);
  run.seconds = number_after(log, "Loop time of");
  run.pair_fraction = number_after(log, "\nPair    |") / run.seconds;
  run.neighbour_fraction = number_after(log, "\nNeigh   |") / run.seconds;
  run.modify_fraction = number_after(log, "\nModify  |") / run.seconds;
  run.other_fraction = 1 - run.pair_fraction - run.neighbour_fraction - run.modify_fraction;
  // Both count on where a run goes on.
  const auto builds = std::llround(number_after(log, "Neighbor list builds ="));
  const auto dangerous = std::llround(number_after(log, "Dangerous builds =", -1));
  run.neighbour_builds = builds - std::exchange(builds_, builds);
  run.dangerous_builds = dangerous < 0 ? -1 : dangerous - std::exchange(dangerous_, dangerous);
  run.neighbours_per_particle = number_after(log, "Ave neighs/atom =");
  run.contacts_per_particle =
      static_cast<double>(contacts(lammps_, 2 * radius_)) / static_cast<double>(count_);
  const std::vector<double> velocity = velocities();
  const std::vector<double> spin = spins();
  for (std::size_t i = 0; i < velocity.size(); i += 3) {
    for (std::size_t axis = 0; axis < 3; ++axis) run.momentum[axis] += mass_ * velocity[i + axis];
    run.kinetic_energy += mass_ / 2 * squared(&velocity[i]);
    run.spin_energy += mass_ * radius_ * radius_ / 5 * squared(&spin[i]);
  }
  return run;
}

int LammpsGranular::version() const { return lammps_version(lammps_); }

std::vector<double> LammpsGranular::gathered(const char* property) const {
  std::vector<double> values(3 * count_);
  std::string name = property;
  lammps_gather_atoms(lammps_, name.data(), 1, 3, values.data());
  return values;
}

}  // namespace salvo::bench
