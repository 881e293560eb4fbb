// The contract on whole worlds: the bits of the state are a function of the set-up and the step,
// and of nothing else.
#include "solver/world.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <memory>
#include <set>

#include "tests/kernels/values.hpp"
#include "tests/solver/foreign_environment.hpp"
#include "tests/solver/particles.hpp"
#include "tests/solver/setups.hpp"

namespace salvo::tests {

namespace {

using solver::BadRow;
using solver::Digest;
using solver::Execution;
using solver::Isa;
using solver::NumericalError;
using solver::World;

// The first steps one by one, then stretches longer than a pass of 64.
const std::vector<std::int64_t> frames = {1, 3, 66, 133};

struct Variation {
  Execution execution;
  std::string name;
};

const Execution reference{Isa::scalar, 1, 1};

// One axis varied at a time, then all together.
std::vector<Variation> variations() {
  std::vector<Variation> runs;
  for (const Isa isa : solver::available_isas()) {
    runs.push_back({{isa, 1, 16}, std::string(name(isa))});
  }
  const Isa widest = solver::widest_isa();
  for (const std::int32_t pass : {1, 7, 64}) {
    runs.push_back({{widest, 1, pass}, "passes of " + std::to_string(pass)});
  }
  for (const int threads : {2, 3, 4, 8, 13}) {
    runs.push_back({{widest, threads, 16}, std::to_string(threads) + " threads"});
  }
  runs.push_back({{Isa::scalar, 3, 7}, "scalar, 3 threads, passes of 7"});
  return runs;
}

std::vector<std::string> hashes(const solver::Setup& setup, const Execution& execution) {
  World world(setup, execution);
  std::vector<std::string> result = {to_string(world.hash().total)};
  for (const std::int64_t step : frames) {
    world.advance_to(step);
    result.push_back(to_string(world.hash().total));
  }
  return result;
}

void expect_same_particle(const Particle& got, const Particle& wanted) {
  EXPECT_EQ(got.id, wanted.id);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_EQ(bits_of(got.position[c]), bits_of(wanted.position[c])) << got.id << " axis " << c;
    EXPECT_EQ(bits_of(got.velocity[c]), bits_of(wanted.velocity[c])) << got.id << " axis " << c;
  }
  EXPECT_EQ(bits_of(got.mass), bits_of(wanted.mass)) << got.id;
  EXPECT_EQ(bits_of(got.radius), bits_of(wanted.radius)) << got.id;
  EXPECT_EQ(bits_of(got.drag_area), bits_of(wanted.drag_area)) << got.id;
  EXPECT_EQ(got.birth, wanted.birth) << got.id;
  EXPECT_EQ(got.death, wanted.death) << got.id;
  EXPECT_EQ(got.group, wanted.group) << got.id;
}

class EveryScene : public testing::TestWithParam<NamedSetup> {};

std::string test_name(const testing::TestParamInfo<NamedSetup>& info) {
  std::string name = info.param.name;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return std::isalnum(c) == 0; }, '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(World, EveryScene, testing::ValuesIn(varied_setups()), test_name);

}  // namespace

TEST_P(EveryScene, GivesTheSameBitsForAnyWidthPassLengthAndThreads) {
  const NamedSetup& scene = GetParam();
  const std::vector<std::string> wanted = hashes(scene.setup, reference);
  for (const Variation& run : variations()) {
    EXPECT_EQ(hashes(scene.setup, run.execution), wanted) << scene.name << ": " << run.name;
  }
}

TEST_P(EveryScene, Moves) {
  const NamedSetup& scene = GetParam();
  if (scene.setup.emitters.empty()) return;
  const std::vector<std::string> all = hashes(scene.setup, {});
  const std::set<std::string> distinct(all.begin(), all.end());
  EXPECT_EQ(distinct.size(), all.size()) << scene.name;
}

TEST(World, GivesTheSameBitsOnEveryRun) {
  const solver::Setup setup = varied_setups().front().setup;
  EXPECT_EQ(hashes(setup, {}), hashes(setup, {}));
}

TEST(World, GivesOtherBitsForAnotherSeed) {
  solver::Setup setup = varied_setups().front().setup;
  const std::vector<std::string> wanted = hashes(setup, {});
  setup.seed += 1;
  EXPECT_NE(hashes(setup, {}), wanted);
}

TEST_P(EveryScene, EmitsEachBurstAsIfAlone) {
  const NamedSetup& scene = GetParam();
  if (scene.setup.emitters.size() < 2) return;
  World together(scene.setup, {});
  together.advance_to(frames.back());
  std::map<soa::Id, Particle> all;
  for (const Particle& p : read_particles(together.particles())) all[p.id] = p;
  std::size_t seen = 0;
  for (const Emitter& emitter : scene.setup.emitters) {
    solver::Setup alone = scene.setup;
    alone.emitters = {emitter};
    World world(alone, {});
    world.advance_to(frames.back());
    for (const Particle& p : read_particles(world.particles())) {
      ASSERT_TRUE(all.contains(p.id)) << scene.name << ": " << p.id;
      expect_same_particle(p, all[p.id]);
      ++seen;
    }
  }
  EXPECT_EQ(seen, all.size()) << scene.name;
}

TEST_P(EveryScene, KeepsParticlesInTheOrderOfIds) {
  const NamedSetup& scene = GetParam();
  World world(scene.setup, {});
  for (const std::int64_t step : frames) {
    world.advance_to(step);
    EXPECT_TRUE(world.particles().sorted_by_id()) << scene.name << " at step " << step;
  }
}

TEST_P(EveryScene, ContinuesFromACopyOfItsState) {
  const NamedSetup& scene = GetParam();
  World whole(scene.setup, {});
  whole.advance_to(37);
  soa::Table saved = copy_of(whole.particles());
  const solver::ContactTally tally = whole.tally();
  const std::uint64_t removed = whole.removed();

  World resumed(scene.setup, {Isa::scalar, 3, 7});
  resumed.restore(37, std::move(saved), tally, removed);
  for (const std::int64_t step : {37, 38, 66, 133}) {
    whole.advance_to(step);
    resumed.advance_to(step);
    EXPECT_EQ(resumed.hash().total, whole.hash().total) << scene.name << " at step " << step;
  }
  EXPECT_EQ(resumed.step(), whole.step());
  EXPECT_EQ(resumed.time(), whole.time());
  EXPECT_EQ(resumed.removed(), whole.removed()) << scene.name;
  EXPECT_EQ(resumed.tally().impacts, whole.tally().impacts) << scene.name;
  EXPECT_EQ(resumed.tally().rests, whole.tally().rests) << scene.name;
}

TEST(World, ChangesItsExecutionBetweenFrames) {
  const solver::Setup setup = varied_setups().front().setup;
  const std::vector<std::string> wanted = hashes(setup, reference);
  World world(setup, {});
  std::size_t frame = 0;
  for (const Variation& run : variations()) {
    world.execute_as(run.execution);
    world.advance_to(frames[frame]);
    EXPECT_EQ(to_string(world.hash().total), wanted[frame + 1]) << run.name;
    if (++frame == frames.size()) break;
  }
  EXPECT_THROW(world.execute_as({Isa::scalar, 1, 0}), std::invalid_argument);
}

TEST(World, CountsTheSameImpactsForAnyWidthPassLengthAndThreads) {
  for (const NamedSetup& scene : varied_setups()) {
    if (scene.setup.obstacles.empty()) continue;
    World wanted(scene.setup, reference);
    wanted.advance_to(frames.back());
    for (const Variation& run : variations()) {
      World world(scene.setup, run.execution);
      world.advance_to(frames.back());
      EXPECT_EQ(world.tally().impacts, wanted.tally().impacts) << scene.name << ": " << run.name;
      EXPECT_EQ(world.tally().rests, wanted.tally().rests) << scene.name << ": " << run.name;
    }
  }
}

#ifdef SALVO_TEST_FOREIGN_ENVIRONMENT
TEST_P(EveryScene, KeepsItsBitsInAForeignFloatingPointEnvironment) {
  const NamedSetup& scene = GetParam();
  for (const int threads : {1, 3}) {
    const Execution execution{solver::widest_isa(), threads, 16};
    World wanted(scene.setup, execution);
    wanted.advance_to(66);
    const solver::Diagnostics wanted_sums = wanted.diagnose();
    const std::vector<Particle> wanted_particles = read_particles(wanted.particles());

    const auto foreign = std::make_unique<ForeignEnvironment>();
    World world(scene.setup, execution);
    world.advance_to(66);
    const Digest digest = world.hash().total;
    const solver::Diagnostics sums = world.diagnose();
    ASSERT_TRUE(foreign->untouched()) << scene.name;

    EXPECT_EQ(digest, wanted.hash().total) << scene.name << ", " << threads << " threads";
    EXPECT_EQ(sums.kinetic_energy, wanted_sums.kinetic_energy) << scene.name;
    EXPECT_EQ(sums.potential_energy, wanted_sums.potential_energy) << scene.name;
    // Fields with one value for all particles are not hashed.
    const std::vector<Particle> particles = read_particles(world.particles());
    ASSERT_EQ(particles.size(), wanted_particles.size());
    if (!particles.empty()) expect_same_particle(particles.front(), wanted_particles.front());
  }
}
#endif

TEST(World, OfNoParticlesStepsOn) {
  World world(plain_setup(), {});
  world.advance_to(33);
  EXPECT_EQ(world.step(), 33);
  EXPECT_EQ(world.particles().rows(), 0U);
  EXPECT_EQ(world.diagnose().count, 0U);
}

TEST(World, StepsOnAfterTheLastParticleHasDied) {
  solver::Setup setup = plain_setup(Precision::float32);
  setup.emitters = {burst(1, 65), burst(2, 3, 0.5)};
  setup.emitters[0].life = uniform(0.05, 0.2);
  setup.emitters[1].life = constant(0.03);
  for (const std::int32_t pass : {1, 7, 64}) {
    World world(setup, {solver::widest_isa(), 2, pass});
    EXPECT_EQ(world.particles().rows(), 65U);
    world.advance_to(4);
    EXPECT_EQ(world.particles().rows(), 65U);
    world.advance_to(20);
    EXPECT_EQ(world.particles().rows(), 0U);
    world.advance_to(49);
    EXPECT_EQ(world.particles().rows(), 0U);
    world.advance_to(50);
    EXPECT_EQ(world.particles().rows(), 3U);
    world.advance_to(52);
    EXPECT_EQ(world.particles().rows(), 3U);
    world.advance_to(53);
    EXPECT_EQ(world.particles().rows(), 0U);
    world.advance_to(99);
    EXPECT_EQ(world.particles().rows(), 0U);
  }
}

TEST(World, EmitsAtTheFirstStepAtOrAfterTheTime) {
  struct Case {
    double time;
    std::int64_t step;
  };
  for (const Case c : {Case{0, 0}, Case{0.03, 3}, Case{0.0301, 4}, Case{0.07, 7}, Case{-5, 0}}) {
    solver::Setup setup = plain_setup();
    setup.emitters = {burst(1, 3, c.time)};
    World world(setup, {});
    for (std::int64_t step = 0; step < 9; ++step) {
      world.advance_to(step);
      EXPECT_EQ(world.particles().rows(), step >= c.step ? 3U : 0U) << c.time << " at " << step;
    }
    EXPECT_EQ(read_particle(world.particles(), 0).birth, c.step);
  }
}

TEST(World, AJetKeepsItsRateOnAverageAndItsTotalExactly) {
  solver::Setup setup = plain_setup();
  Emitter jet = burst(1, 0, 0.055);
  jet.kind = EmitterKind::jet;
  jet.rate = 233.3;
  jet.duration = 0.5;  // 116.65: 116 particles
  setup.emitters = {jet};
  EXPECT_EQ(World::total_emitted(setup), 116U);
  World world(setup, {});
  for (std::int64_t step = 0; step < 66; ++step) {
    world.advance_to(step);
    const double due = step < 6 ? 0 : std::min(116.0, 2.333 * static_cast<double>(step - 5));
    EXPECT_NEAR(static_cast<double>(world.particles().rows()), due, 1.0) << step;
  }
  EXPECT_EQ(world.particles().rows(), 116U);
}

TEST(World, StoresOnlyTheFieldsThatDiffer) {
  solver::Setup setup = plain_setup(Precision::float32);
  setup.emitters = {burst(1, 65)};
  World same(setup, {});
  EXPECT_EQ(same.particles().resident_bytes(), 128U * (8 + 6 * 4));
  EXPECT_EQ(World::state_bytes(setup), 128U * (8 + 6 * 4));
  setup.emitters.push_back(burst(2, 1, 0.1));
  setup.emitters[1].mass = uniform(1, 2);
  World varied(setup, {});
  EXPECT_EQ(varied.particles().resident_bytes(), 128U * (8 + 7 * 4 + 4));  // mass and birth
  EXPECT_EQ(World::state_bytes(setup), 128U * (8 + 7 * 4 + 4));
}

TEST(World, RefusesWhatItCannotRun) {
  solver::Setup setup = plain_setup();
  const auto construct = [&](const Execution& execution) { World world(setup, execution); };
  EXPECT_THROW(construct({Isa::scalar, 1, 0}), std::invalid_argument);
#if defined(__x86_64__)
  EXPECT_THROW(construct({Isa::neon, 1, 16}), std::invalid_argument);
#endif
  setup.dt = 0;
  EXPECT_THROW(construct({}), std::invalid_argument);
}

// ---- rows that go bad --------------------------------------------------------------------------

namespace {

// A cube of 8 m; steps of 1/8 s, so that every position below is exact in float.
solver::Setup bounded_setup(Precision precision) {
  solver::Setup setup = plain_setup(precision);
  setup.dt = 0.125;
  setup.forces.gravity = {0, 0, 0};
  setup.domain = {true, {-4, -4, -4}, {4, 4, 4}};
  return setup;
}

BadRow failure(const solver::Setup& setup, const Execution& execution, std::int64_t last = 99) {
  World world(setup, execution);
  try {
    world.advance_to(last);
  } catch (const NumericalError& error) {
    return error.row();
  }
  ADD_FAILURE() << "nothing went bad";
  return {};
}

void expect_failure(const solver::Setup& setup, const BadRow& wanted, const char* what) {
  std::vector<Variation> runs = variations();
  runs.push_back({reference, "the reference"});
  for (const Variation& run : runs) {
    const BadRow row = failure(setup, run.execution);
    EXPECT_EQ(row.id, wanted.id) << what << ": " << run.name;
    EXPECT_EQ(row.step, wanted.step) << what << ": " << run.name;
    EXPECT_EQ(row.column, wanted.column) << what << ": " << run.name;
    EXPECT_EQ(canonical_bits(row.value), canonical_bits(wanted.value)) << what << ": " << run.name;
    EXPECT_EQ(row.left_domain, wanted.left_domain) << what << ": " << run.name;
  }
}

}  // namespace

TEST(BadRows, LeavingTheDomainIsNamedOnEveryFace) {
  constexpr const char* columns[] = {"position.x", "position.y", "position.z"};
  for (const Precision precision : {Precision::float32, Precision::float64}) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const double side : {-1.0, 1.0}) {
        solver::Setup setup = bounded_setup(precision);
        setup.emitters = {particles_from(1, {0, 0, 0}, {0, 0, 0}, 33)};
        Triple velocity{};
        velocity[axis] = side * 0.75;
        setup.emitters.push_back(particles_from(7, {0, 0, 0}, velocity));
        setup.emitters.push_back(particles_from(8, {0, 0, 0}, {0.25, 0.25, 0.25}, 3));
        // 0.09375 m a step: 42 steps end at 3.9375, 43 at 4.03125
        expect_failure(setup, {soa::make_id(7, 0), 43, columns[axis], side * 4.03125, true},
                       columns[axis]);
      }
    }
  }
}

TEST(BadRows, TheFaceOfTheDomainIsInside) {
  solver::Setup setup = bounded_setup(Precision::float32);
  setup.emitters = {particles_from(1, {4, -4, 4}, {0, 0, 0}, 3),
                    particles_from(2, {-4, 0, 0}, {1, 0, 0})};
  World world(setup, {});
  world.advance_to(64);  // across to the other face, 8 m in 64 steps
  EXPECT_EQ(world.particles().rows(), 4U);
  EXPECT_EQ(read_particle(world.particles(), 3).position[0], 4);
}

TEST(BadRows, TheEarliestStepIsNamedAndThenTheLowestId) {
  solver::Setup setup = bounded_setup(Precision::float32);
  setup.emitters = {particles_from(1, {0, 0, 0}, {0, 0, 0}, 12'345),  // across tiles
                    particles_from(3, {3, 0, 0}, {1, 0, 0}),          // out at step 9
                    particles_from(5, {0, 0, 0}, {0, 0, 0}, 77),
                    particles_from(6, {0, 3.5, 0}, {0, 1, 0}, 3),      // out at step 5
                    particles_from(9, {0, 0, -3.5}, {0, 0, -1}, 65)};  // out at step 5
  expect_failure(setup, {soa::make_id(6, 0), 5, "position.y", 4.125, true}, "three emitters");
}

TEST(BadRows, AParticleThatLeavesAndComesBackWithinAPassIsSeen) {
  solver::Setup setup = bounded_setup(Precision::float64);
  setup.forces.gravity = {0, -4, 0};
  setup.integrator = IntegratorKind::velocity_verlet;
  setup.emitters = {particles_from(1, {0, 0, 0}, {0, 0, 0}, 3)};
  setup.emitters[0].life = constant(0.5);
  setup.emitters.push_back(particles_from(2, {0, 2.5, 0}, {0, 4, 0}));
  // y = 2.5 + 4 t - 2 t^2: above 4 from t = 0.5 on, back below at 1.5.
  expect_failure(setup, {soa::make_id(2, 0), 5, "position.y", 2.5 + 2.5 - 0.78125, true}, "an arc");
}

TEST(BadRows, NonFiniteIsNamedWithTheColumnThatWentFirst) {
  struct Case {
    const char* what;
    IntegratorKind integrator;
    bool drag;
    double speed;  // float
    std::int64_t step;
    const char* column;
    double value;
  };
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const Case cases[] = {
      // 1e38 m a step: the fourth is past the range of float.
      {"overflowing position", IntegratorKind::semi_implicit_euler, false, 1e38, 4, "position.x",
       infinity},
      // The square of the speed overflows: a = -inf. The explicit method moves on with the old
      // velocity.
      {"overflowing drag, explicit", IntegratorKind::explicit_euler, true, 1e30, 1, "velocity.x",
       -infinity},
      {"overflowing drag, semi-implicit", IntegratorKind::semi_implicit_euler, true, 1e30, 1,
       "position.x", -infinity},
  };
  models::Obstacle ball;
  ball.shape = models::ObstacleShape::sphere;
  ball.center = {3, 9, 0};
  for (const Case& c : cases) {
    solver::Setup setup = plain_setup(Precision::float32);
    setup.dt = 1;
    setup.forces.gravity = {0, 0, 0};
    setup.forces.quadratic_drag = c.drag;
    setup.integrator = c.integrator;
    setup.emitters = {particles_from(1, {0, 1, 0}, {1, 2, 3}, 77),
                      particles_from(2, {0, 1, 0}, {c.speed, 1, 1})};
    for (Emitter& emitter : setup.emitters) emitter.drag_area = constant(0.01);
    const BadRow wanted{soa::make_id(2, 0), c.step, c.column, c.value, false};
    expect_failure(setup, wanted, c.what);
    // Contact must not turn what is broken into something that looks whole.
    setup.obstacles = {models::Obstacle{}, ball};
    expect_failure(setup, wanted, c.what);
  }
}

TEST(BadRows, ADeathBeforeTheEdgeIsNoFailure) {
  solver::Setup setup = bounded_setup(Precision::float32);
  setup.emitters = {particles_from(1, {3, 0, 0}, {1, 0, 0}, 3)};  // out at step 9
  setup.emitters[0].life = constant(8 * 0.125);
  for (const std::int32_t pass : {1, 7, 64}) {
    World world(setup, {solver::widest_isa(), 1, pass});
    world.advance_to(33);
    EXPECT_EQ(world.particles().rows(), 0U);
    EXPECT_EQ(world.removed(), 0U);
  }
  setup.emitters[0].life = constant(9 * 0.125);
  expect_failure(setup, {soa::make_id(1, 0), 9, "position.x", 4.125, true}, "a life too long");
}

TEST(BadRows, AreRemovedWithoutATraceOnTheOthers) {
  solver::Setup setup = plain_setup(Precision::float32);
  setup.forces.quadratic_drag = true;
  setup.emitters = {burst(1, 4097), burst(2, 333, 0.2)};
  solver::Setup free = setup;
  setup.domain = {true, {-8, 25, -9}, {8, 36, 7}};
  setup.on_bad = solver::BadRowPolicy::remove;

  World unbounded(free, {});
  unbounded.advance_to(66);
  std::map<soa::Id, Particle> all;
  for (const Particle& p : read_particles(unbounded.particles())) all[p.id] = p;

  World wanted(setup, reference);
  wanted.advance_to(66);
  EXPECT_GT(wanted.removed(), 1000U);
  EXPECT_EQ(wanted.removed() + wanted.particles().rows(), 4430U);
  for (const Particle& p : read_particles(wanted.particles())) expect_same_particle(p, all[p.id]);

  const std::vector<BadRow>& rows = wanted.removed_rows();
  EXPECT_EQ(rows.size(), 100U);
  EXPECT_TRUE(std::is_sorted(rows.begin(), rows.end(), [](const BadRow& a, const BadRow& b) {
    return std::pair(a.step, a.id) < std::pair(b.step, b.id);
  }));
  for (const Variation& run : variations()) {
    World world(setup, run.execution);
    world.advance_to(66);
    EXPECT_EQ(world.hash().total, wanted.hash().total) << run.name;
    EXPECT_EQ(world.removed(), wanted.removed()) << run.name;
    ASSERT_EQ(world.removed_rows().size(), rows.size()) << run.name;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      EXPECT_EQ(world.removed_rows()[i].id, rows[i].id) << run.name;
      EXPECT_EQ(world.removed_rows()[i].step, rows[i].step) << run.name;
      EXPECT_EQ(world.removed_rows()[i].column, rows[i].column) << run.name;
      EXPECT_EQ(world.removed_rows()[i].value, rows[i].value) << run.name;
    }
  }
}

TEST(BadRows, TheMessageSaysWhoWhenAndWhat) {
  const NumericalError left({soa::make_id(7, 33), 43, "position.z", -4.5, true});
  EXPECT_STREQ(left.what(),
               "particle 7696581394465 (stream 7, serial 33) left the domain at step 43: "
               "position.z = -4.5");
  const NumericalError broken({3, 9, "velocity.x", std::numeric_limits<double>::infinity(), false});
  EXPECT_STREQ(broken.what(),
               "particle 3 (stream 0, serial 3) became non-finite at step 9: velocity.x = inf");
}

}  // namespace salvo::tests
