// Particles that touch: steps a second of equal spheres that collide in a closed box, the same as
// LAMMPS gets (see contact_peer.cpp), and where the time goes. Lists are made as often as there.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "bench/granular_packing.hpp"
#include "bench/harness.hpp"
#include "kernels/sphere_contact.hpp"
#include "scene/load.hpp"
#include "soa/particle_fields.hpp"

namespace salvo::bench {

namespace {

// Nearly all sites of a dense lattice.
constexpr std::size_t proof_spheres = 2916;

struct Row {
  const GranularScene* scene;
  models::ContactLawKind law;
  soa::Precision precision;
  solver::Isa isa;
  int threads;
};

// The peer's law term by term, but for a dashpot that never pulls and arms that end at the point of
// contact: its damping, not its restitution, because the dashpot's pull is part of that.
models::ContactLaw law_of(models::ContactLawKind kind) {
  const GranularLaw peer = GranularScene::law();
  const GranularScene& any = granular_scenes().front();
  const double mass = any.packing(proof_spheres).mass() / 2;
  models::ContactLaw law;
  law.kind = kind;
  law.normal_stiffness = peer.normal_stiffness;
  law.tangential_ratio = peer.tangential_stiffness / peer.normal_stiffness;
  law.tangential_damping = peer.tangential_damping / peer.normal_damping;
  law.friction = peer.friction;
  law.restitution = kernels::restitution_of(
      peer.normal_damping * mass / 2 /
      sqrt(kernels::ScalarLane<double>(peer.normal_stiffness * mass)).value());
  law.energy_budget = false;
  return law;
}

solver::Setup setup_of(const GranularPacking& packing, models::ContactLawKind kind,
                       soa::Precision precision) {
  solver::Setup setup;
  setup.precision = precision;
  setup.dt = GranularScene::dt();
  setup.forces.gravity = {0, 0, 0};
  setup.contact_law = law_of(kind);
  solver::Emitter emitter;
  emitter.count = packing.count();
  emitter.radius.a = packing.radius;
  emitter.mass.a = packing.mass();
  setup.emitters.push_back(emitter);
  models::Obstacle box;
  box.shape = models::ObstacleShape::box;
  box.hollow = true;
  const double half = packing.edge / 2;
  box.center = box.half_size = {half, half, half};
  box.restitution = setup.contact_law->restitution;
  box.friction = setup.contact_law->friction;
  setup.obstacles.push_back(box);
  return setup;
}

template <class T>
void fill(soa::Table& table, const GranularPacking& packing) {
  const auto set = [&](soa::ParticleField field, const std::vector<double>& values) {
    for (std::size_t c = 0; c < 3; ++c) {
      T* column = table.column<T>(static_cast<std::size_t>(field), c);
      for (std::size_t row = 0; row < packing.count(); ++row) {
        column[row] = static_cast<T>(values[3 * row + c]);
      }
    }
  };
  set(soa::ParticleField::position, packing.position);
  set(soa::ParticleField::velocity, packing.velocity);
  set(soa::ParticleField::angular_velocity, packing.spin);
}

solver::Execution execution_of(const Row& row) {
  solver::Execution execution{row.isa, row.threads, 1};
  execution.contact = {GranularScene::skin, 1, GranularScene::rebuild_every};
  return execution;
}

// Spheres after as many steps as the peer's: until they collide as often as they part.
class Collided {
 public:
  Collided(const Row& row, std::size_t spheres)
      : world_(setup_of(row.scene->packing(spheres), row.law, row.precision),
               execution_of({row.scene, row.law, row.precision, solver::widest_isa(), 2})) {
    soa::Table table = world_.particles().copy();
    const GranularPacking packing = row.scene->packing(spheres);
    row.precision == soa::Precision::float32 ? fill<float>(table, packing)
                                             : fill<double>(table, packing);
    world_.restore(0, std::move(table), {}, 0);
    constexpr std::int64_t warm_up = 60;
    world_.advance_to(warm_up);
    particles_ = world_.particles().copy();
    contacts_ = world_.contacts().copy();
  }
  // As it was, to be stepped in another way.
  solver::World& again(const solver::Execution& execution) {
    world_.execute_as(execution);
    world_.restore(60, particles_->copy(), {}, 0, contacts_->copy());
    return world_;
  }

 private:
  solver::World world_;
  std::optional<soa::Table> particles_;
  std::optional<soa::Table> contacts_;
};

std::size_t spheres() { return quick() ? 200'000 : 1'000'000; }

// One at a time: a million spheres take half a gigabyte.
Collided& collided(const Row& row) {
  static std::string kept;
  static std::unique_ptr<Collided> state;
  const std::string key =
      fmt::format("{} {} {}", row.scene->name, static_cast<int>(row.law), name(row.precision));
  if (kept != key) {
    state.reset();
    state = std::make_unique<Collided>(row, spheres());
    kept = key;
  }
  return *state;
}

// The state hash of a small world after some lists: one bit off and it shows.
std::string proof(const Row& row, const solver::Execution& execution) {
  Collided small(row, proof_spheres);
  solver::World& world = small.again(execution);
  world.advance_to(world.step() + 40);
  return to_string(world.hash().total);
}

void measure(benchmark::State& state, const Row& row) {
  const std::string hash = proof(row, execution_of(row));
  if (hash != proof(row, {solver::Isa::scalar, 1, 1})) {
    state.SkipWithError("the bits differ from those of the scalar reference");
    return;
  }
  solver::World& world = collided(row).again(execution_of(row));
  const auto rows = static_cast<double>(world.particles().rows());
  // Some lists are found by cells and some taken from wider ones: all from one sort of the rows to
  // a later one are measured, so that each has its share. The first sort touches fresh memory.
  const solver::ContactProfile& after = *world.contact_profile();
  const auto sort = [&](std::uint64_t times) {
    for (const std::uint64_t last = after.sorts + times; after.sorts < last;) {
      world.advance_to(world.step() + GranularScene::rebuild_every);
    }
  };
  sort(2);
  const solver::ContactProfile before = after;
  double seconds = 0;
  for (auto _ : state) {
    const double start = now();
    sort(quick() ? 1 : 3);
    seconds += now() - start;
  }
  const double sorted = after.sort_seconds - before.sort_seconds;
  const double listed = after.list_seconds - before.list_seconds;
  const double stepped = after.step_seconds - before.step_seconds;
  const auto builds = static_cast<double>(after.list_builds - before.list_builds);
  const auto steps = static_cast<double>(after.steps - before.steps);
  state.counters["particle_steps_per_second"] = rows * steps / seconds;
  state.counters["spheres"] = rows;
  state.counters["steps_per_build"] = steps / builds;
  state.counters["steps_per_sort"] = steps / static_cast<double>(after.sorts - before.sorts);
  state.counters["sort_fraction"] = sorted / (sorted + listed + stepped);
  state.counters["list_fraction"] = listed / (sorted + listed + stepped);
  state.counters["neighbors_per_particle"] =
      static_cast<double>(after.list_entries - before.list_entries) / builds / rows;
  state.counters["slots_per_particle"] =
      static_cast<double>(after.list_slots - before.list_slots) / builds / rows;
  state.SetLabel(hash);
}

enum class Stage { build, list };

// Cells and order of the rows, or lists: each built anew every step.
void measure_stage(benchmark::State& state, const Row& row, Stage stage) {
  solver::Execution execution = execution_of(row);
  execution.contact.list_interval = 1;
  execution.contact.outer_margins = 1;
  solver::World& world = collided(row).again(execution);
  world.advance_to(world.step() + 1);
  const auto seconds_of = [&] {
    const solver::ContactProfile& profile = *world.contact_profile();
    return stage == Stage::build ? profile.sort_seconds : profile.list_seconds;
  };
  std::vector<double> seconds;
  for (auto _ : state) {
    const double before = seconds_of();
    world.advance_to(world.step() + 1);
    seconds.push_back(seconds_of() - before);
    state.SetIterationTime(seconds.back());
  }
  const auto rows = static_cast<double>(world.particles().rows());
  state.counters["particle_steps_per_second"] = rows / median(seconds);
  state.counters["spheres"] = rows;
}

// The flagship scene as a run steps it, without recording. The full measurement is of the whole
// scene: its steps are of very different kinds, from a packing at rest to a cloud of stones.
void measure_debris(benchmark::State& state, int threads) {
  const scene::Scene scene = scene::load(SALVO_SOURCE_DIR "/scenes/debris.toml");
  solver::World world(scene.setup, {solver::widest_isa(), threads, 1});
  world.advance_to(1);  // the first lists
  const std::int64_t steps = quick() ? 100 : scene.steps;
  for (auto _ : state) world.advance_to(steps);
  const solver::ContactProfile& profile = *world.contact_profile();
  const double lists = profile.sort_seconds + profile.list_seconds;
  const auto rows = static_cast<double>(world.particles().rows());
  state.counters["particle_steps_per_second"] =
      benchmark::Counter(rows * static_cast<double>(steps - 1), benchmark::Counter::kIsRate);
  state.counters["spheres"] = rows;
  state.counters["steps"] = static_cast<double>(steps);
  state.counters["lists_fraction"] = lists / (lists + profile.step_seconds);
}

std::string ending(const Row& row) {
  return fmt::format("real:{}/isa:{}/threads:{}", name(row.precision), solver::name(row.isa),
                     row.threads);
}

}  // namespace

void register_contacts() {
  using Kind = models::ContactLawKind;
  for (const int threads : {1, 2}) {
    if (threads == 1 && !quick()) continue;  // it would take minutes more
    benchmark::RegisterBenchmark(
        fmt::format("scene/debris/real:float/isa:{}/threads:{}", solver::name(solver::widest_isa()),
                    threads)
            .c_str(),
        [threads](benchmark::State& state) { measure_debris(state, threads); })
        ->Unit(benchmark::kSecond)
        ->UseRealTime()
        ->Iterations(1);
  }
  for (const soa::Precision precision : {soa::Precision::float32, soa::Precision::float64}) {
    const auto add = [&](const std::string& kind, const GranularScene& scene, Kind law) {
      std::vector<solver::Isa> isas = solver::available_isas();
      for (const solver::Isa isa : isas) {
        for (const int threads : {1, 2}) {
          if (threads > 1 && isa != solver::widest_isa()) continue;
          const Row row{&scene, law, precision, isa, threads};
          benchmark::RegisterBenchmark(fmt::format("contact/{}/{}", kind, ending(row)).c_str(),
                                       [row](benchmark::State& state) { measure(state, row); })
              ->Unit(benchmark::kMillisecond)
              ->Iterations(1);
        }
      }
    };
    for (const GranularScene& scene : granular_scenes()) {
      add(scene.name, scene, Kind::linear_spring);
      if (scene.name != "dense") continue;
      for (const int threads : {1, 2}) {
        const Row row{&scene, Kind::linear_spring, precision, solver::widest_isa(), threads};
        for (const auto& [stage_name, stage] :
             {std::pair{"build", Stage::build}, std::pair{"list", Stage::list}}) {
          benchmark::RegisterBenchmark(
              fmt::format("broadphase/{}/{}", stage_name, ending(row)).c_str(),
              [row, stage = stage](benchmark::State& state) { measure_stage(state, row, stage); })
              ->Unit(benchmark::kMillisecond)
              ->UseManualTime()
              ->Iterations(5);
        }
      }
      add("impulse", scene, Kind::impulse);
    }
  }
}

}  // namespace salvo::bench
