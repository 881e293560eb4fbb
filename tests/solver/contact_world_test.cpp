// The contract on worlds of particles that touch: the bits are a function of the set-up and the
// step, and of nothing that the broad phase does; and where in space a packing lies matters little
// even in float.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "soa/contact_fields.hpp"
#include "tests/physics/spheres.hpp"

namespace salvo::tests {
namespace {

using solver::BadRowPolicy;
using solver::ContactTuning;
using solver::Execution;
using solver::Isa;
using solver::Spread;

// A dense packing of different sizes in a box, shaken and stirred. More falls on it, a jet is
// blown in whose grains live for a short time, and what rises too high is removed.
solver::Setup stirred(ContactLaw law, Precision precision) {
  law.rolling_friction = law.remembers() ? 0.1 : 0;
  solver::Setup setup = touching_setup(law, precision);
  setup.seed = 77;
  setup.t0 = 100.25;                    // the walls have moved by then
  setup.forces.gravity = {0, -100, 0};  // so that little time is enough
  setup.forces.quadratic_drag = true;
  setup.obstacles.push_back(hollow_box({0, 0.12, 0}, {0.06, 0.12, 0.06}, law));
  setup.obstacles[0].motion.amplitude = {0.001, 0.002, 0};
  setup.obstacles[0].motion.frequency = 31;
  Obstacle paddle = ground(law);
  paddle.shape = ObstacleShape::capsule;
  paddle.center = {0.01, 0.05, 0};
  paddle.axis = {1, 0.3, 0};
  paddle.radius = 0.008;
  paddle.half_length = 0.03;
  paddle.motion.angular_velocity = {2, 30, 0};
  setup.obstacles.push_back(paddle);

  const auto sized = [](Emitter emitter, std::uint64_t stream) {
    emitter.stream = stream;
    emitter.radius = {Spread::Kind::uniform, 0.0042, 0.005};
    emitter.mass = {Spread::Kind::uniform, 5e-4, 1e-3};
    emitter.drag_area = {Spread::Kind::uniform, 1e-5, 2e-5};
    return emitter;
  };
  Emitter packing = lattice({0, 0.07, 0}, {0.118, 0.138, 0.118}, 0.0094, 0.005, 1e-3);
  packing.speed.a = 0.3;
  packing.angular_velocity = {20, 0, -10};
  setup.emitters.push_back(sized(packing, 9));
  Emitter above = lattice({0, 0.156, 0}, {0.11, 0.03, 0.11}, 0.01, 0.005, 1e-3);
  above.velocity = {0, -1.5, 0};
  setup.emitters.push_back(sized(above, 2));
  Emitter jet;
  jet.kind = EmitterKind::jet;
  jet.position = {-0.04, 0.2, 0};
  jet.direction = {1, 1, 0};
  jet.half_angle = 0.4;
  jet.speed.a = 4;
  jet.source_radius = 0.002;
  jet.duration = 1;
  setup.emitters.push_back(sized(jet, 5));

  setup.domain = {true, {-1, -1, -1}, {1, 0.21, 1}};
  setup.on_bad = BadRowPolicy::remove;
  setup.dt = solver::contact_time(setup).step;
  const auto at_step = [&](double step) { return setup.t0 + step * setup.dt; };
  setup.emitters[1].time = at_step(60);
  setup.emitters[2].time = at_step(30);
  setup.emitters[2].rate = 0.31 / setup.dt;
  setup.emitters[2].life = Spread{Spread::Kind::uniform, 20 * setup.dt, 90 * setup.dt};
  return setup;
}

struct NamedContacts {
  const char* name;
  solver::Setup setup;
};

// The same with impulses instead of springs.
solver::Setup struck() {
  solver::Setup setup = stirred(linear(2e3, 0.5, 0.4), Precision::float32);
  setup.contact_law = impulse(0.5, 0.4);
  return setup;
}

// Grains of a second size class in between, no rolling friction and no energies.
solver::Setup with_small_grains() {
  solver::Setup setup = stirred(linear(2e3, 0.5, 0.5), Precision::float32);
  setup.contact_law->rolling_friction = 0;
  setup.contact_law->energy_budget = false;
  setup.emitters[1].radius = {Spread::Kind::uniform, 0.0009, 0.0011};
  return setup;
}

std::vector<NamedContacts> packings() {
  return {{"linear, float", stirred(linear(2e3, 0.5, 0.5), Precision::float32)},
          {"Hertz, float", stirred(hertz(2e7, 0.4, 0.5), Precision::float32)},
          {"linear, double", stirred(linear(2e3, 0.5, 0.5), Precision::float64)},
          {"frictionless, float", stirred(linear(2e3, 0.5), Precision::float32)},
          {"impulse, float", struck()},
          {"small grains, float", with_small_grains()}};
}

const std::vector<std::int64_t> frames = {1, 2, 59, 60, 61, 150, 211};

std::vector<std::string> hashes(const solver::Setup& setup, const Execution& execution) {
  World world(setup, execution);
  std::vector<std::string> all;
  for (const std::int64_t step : frames) {
    world.advance_to(step);
    all.push_back(to_string(world.hash().total));
  }
  return all;
}

Execution execution(Isa isa, int threads, ContactTuning tuning = {}) {
  Execution way;
  way.isa = isa;
  way.threads = threads;
  way.contact = tuning;
  return way;
}

// Lists from cells in every step, cells twice as large as need be, one lane at a time.
const Execution reference = execution(Isa::scalar, 1, {1e-3, 2, 1, 1});

struct NamedExecution {
  std::string name;
  Execution execution;
};

std::vector<NamedExecution> executions() {
  std::vector<NamedExecution> all;
  for (const Isa isa : solver::available_isas()) {
    all.push_back({std::string(name(isa)), execution(isa, 1)});
  }
  const Isa widest = solver::widest_isa();
  for (const int threads : {2, 3, 13}) {
    all.push_back({std::to_string(threads) + " threads", execution(widest, threads)});
  }
  for (const double margin : {1e-6, 1e-4, 1e-3, 8e-3}) {
    all.push_back({"margin " + std::to_string(margin), execution(widest, 2, {margin, 1, 0})});
  }
  for (const double cell_scale : {1.3, 4.0, 100.0}) {
    all.push_back(
        {"cell scale " + std::to_string(cell_scale), execution(widest, 2, {0, cell_scale, 0})});
  }
  for (const std::int64_t interval : {1, 3, 7}) {
    all.push_back(
        {"lists every " + std::to_string(interval), execution(widest, 2, {8e-3, 1, interval})});
  }
  for (const double margin : {1e-5, 1e-4, 1e-3}) {
    for (const double outer : {1.0, 2.1, 4.0, 20.0}) {
      all.push_back({"margin " + std::to_string(margin) + " from " + std::to_string(outer),
                     execution(widest, 2, {margin, 1, 0, outer})});
    }
  }
  return all;
}

TEST(ContactWorld, GivesTheSameBitsForAnyWidthThreadsAndLists) {
  for (const NamedContacts& packing : packings()) {
    const std::vector<std::string> wanted = hashes(packing.setup, reference);
    for (const NamedExecution& run : executions()) {
      EXPECT_EQ(hashes(packing.setup, run.execution), wanted) << packing.name << ": " << run.name;
    }
  }
}

// Else the test above would hold for particles that hardly meet.
TEST(ContactWorld, IsTestedOnPackingsThatTouchStirDieAndGo) {
  for (const NamedContacts& packing : packings()) {
    World world(packing.setup, {});
    const std::size_t first = world.particles().rows();
    EXPECT_GT(first, 1500U);
    world.advance_to(frames.back());
    EXPECT_GT(world.removed(), 5U) << packing.name;
    const std::size_t born = solver::World::total_emitted(packing.setup);
    EXPECT_GT(born, world.particles().rows());
    std::size_t touching = 0;
    std::size_t with_walls = 0;
    std::size_t with_paddle = 0;
    std::size_t rows = world.particles().rows();
    for (std::size_t i = 0; i < rows; ++i) {
      for (std::size_t j = i + 1; j < rows; ++j) touching += overlap(world, i, j) > 0 ? 1 : 0;
    }
    EXPECT_GT(touching, 1000U) << packing.name;
    EXPECT_GT(world.contact_profile()->list_builds, 3U);
    if (!packing.setup.contact_law->remembers()) continue;
    const soa::Table& contacts = world.contacts();
    const auto* partner =
        contacts.column<std::uint64_t>(static_cast<std::size_t>(soa::ContactField::partner));
    for (std::size_t row = 0; row < contacts.rows(); ++row) {
      if (soa::stream_of(partner[row]) != soa::max_stream) continue;
      ++(soa::serial_of(partner[row]) == 6 ? with_paddle : with_walls);
    }
    EXPECT_GT(contacts.rows() - with_walls - with_paddle, 1000U) << packing.name;
    EXPECT_GT(with_walls, 70U) << packing.name;
    EXPECT_GT(with_paddle, 3U) << packing.name;
  }
}

TEST(ContactWorld, LookingChangesNothing) {
  for (const NamedContacts& packing : packings()) {
    World looked_at(packing.setup, {});
    World left_alone(packing.setup, {});
    for (std::int64_t step = 0; step <= 100; ++step) {
      looked_at.advance_to(step);
      looked_at.particles();
      if (step % 3 == 0) looked_at.contacts();
    }
    left_alone.advance_to(100);
    EXPECT_EQ(looked_at.hash().total, left_alone.hash().total) << packing.name;
  }
}

TEST(ContactWorld, ContinuesFromACopyOfItsState) {
  for (const NamedContacts& packing : packings()) {
    World whole(packing.setup, {});
    for (const std::int64_t stop : {1, 59, 60, 133}) {
      whole.advance_to(stop);
      World resumed(packing.setup, execution(Isa::scalar, 3, {0, 1, 3}));
      resumed.restore(stop, whole.particles().copy(), whole.tally(), whole.removed(),
                      whole.contacts().copy());
      EXPECT_EQ(resumed.hash().total, whole.hash().total) << packing.name << ", " << stop;
      World ahead(packing.setup, {});
      ahead.restore(stop, whole.particles().copy(), whole.tally(), whole.removed(),
                    whole.contacts().copy());
      for (const std::int64_t step : {stop + 1, stop + 40}) {
        resumed.advance_to(step);
        ahead.advance_to(step);
        EXPECT_EQ(resumed.hash().total, ahead.hash().total) << packing.name << ", " << stop;
        World straight(packing.setup, {});
        straight.advance_to(step);
        EXPECT_EQ(resumed.hash().total, straight.hash().total)
            << packing.name << ", from " << stop << " to " << step;
        EXPECT_EQ(resumed.removed(), straight.removed());
      }
    }
  }
}

// Every third row from the back: no neighbors by id stay neighbors.
soa::Table shuffled(const soa::Table& table) {
  std::vector<std::size_t> order;
  for (std::size_t first : {1, 0, 2}) {
    for (std::size_t row = first; row < table.rows(); row += 3) order.push_back(row);
  }
  std::reverse(order.begin(), order.end());
  soa::Table result = table.copy();
  for (std::size_t f = 0; f < table.fields().size(); ++f) {
    if (!table.stored(f)) continue;
    const std::size_t size = size_of(table.fields()[f].scalar, table.precision());
    for (std::size_t c = 0; c < table.fields()[f].components; ++c) {
      for (std::size_t row = 0; row < order.size(); ++row) {
        std::memcpy(result.bytes(f, c) + row * size, table.bytes(f, c) + order[row] * size, size);
      }
    }
  }
  return result;
}

TEST(ContactWorld, DoesNotDependOnTheOrderOfTheRowsThatItStartsFrom) {
  for (const NamedContacts& packing : packings()) {
    World whole(packing.setup, {});
    for (const std::int64_t start : {0, 133}) {
      whole.advance_to(start);
      World straight(packing.setup, {});
      straight.advance_to(start + 40);
      for (const Execution& way :
           {reference, execution(solver::widest_isa(), 1), execution(solver::widest_isa(), 3)}) {
        soa::Table particles = shuffled(whole.particles());
        ASSERT_FALSE(particles.sorted_by_id());
        World world(packing.setup, way);
        world.restore(start, std::move(particles), whole.tally(), whole.removed(),
                      whole.contacts().copy());
        EXPECT_EQ(world.hash().total, whole.hash().total) << packing.name << ", " << start;
        world.advance_to(start + 40);
        EXPECT_EQ(world.hash().total, straight.hash().total) << packing.name << ", " << start;
        EXPECT_EQ(world.removed(), straight.removed());
      }
    }
  }
}

// Streams name particles, whichever emitter comes first in the scene.
TEST(ContactWorld, DoesNotDependOnTheOrderOfTheEmitters) {
  for (const NamedContacts& packing : packings()) {
    const std::vector<std::string> wanted = hashes(packing.setup, {});
    solver::Setup setup = packing.setup;
    for (std::size_t turn = 1; turn < setup.emitters.size(); ++turn) {
      std::rotate(setup.emitters.begin(), setup.emitters.begin() + 1, setup.emitters.end());
      const Execution way = execution(solver::widest_isa(), turn == 1 ? 1 : 3);
      EXPECT_EQ(hashes(setup, way), wanted)
          << packing.name << ", " << setup.emitters[0].stream << " first";
    }
  }
}

TEST(ContactWorld, RefusesContactsInAnotherOrder) {
  const solver::Setup setup = stirred(linear(2e3, 0.5, 0.5), Precision::float32);
  World whole(setup, {});
  whole.advance_to(50);
  World world(setup, {});
  world.restore(50, whole.particles().copy(), whole.tally(), whole.removed(),
                shuffled(whole.contacts()));
  EXPECT_THROW(world.advance_to(51), std::invalid_argument);
}

TEST(ContactWorld, ChangesItsExecutionInTheMiddleOfContacts) {
  for (const NamedContacts& packing : packings()) {
    const std::vector<std::string> wanted = hashes(packing.setup, reference);
    World world(packing.setup, {});
    std::size_t frame = 0;
    for (const NamedExecution& run : executions()) {
      world.execute_as(run.execution);
      world.advance_to(frames[frame]);
      EXPECT_EQ(to_string(world.hash().total), wanted[frame]) << packing.name << ": " << run.name;
      if (++frame == frames.size()) break;
    }
  }
}

// A contact remembers by ids: what a stopped run forgets shows.
TEST(ContactWorld, WithoutTheContactsARunGoesOnDifferently) {
  const solver::Setup setup = stirred(linear(2e3, 0.5, 0.5), Precision::float64);
  World whole(setup, {});
  whole.advance_to(50);
  World resumed(setup, {});
  resumed.restore(50, whole.particles().copy(), whole.tally(), whole.removed());
  whole.advance_to(51);
  resumed.advance_to(51);
  EXPECT_NE(resumed.hash().total, whole.hash().total);
}

// Two spheres that are each other's reflection through the origin, spins and all, stay so bit for
// bit: each finds the opposite of the other's force.
TEST(ContactWorld, MirroredSpheresStayMirrored) {
  for (const Precision precision : {Precision::float32, Precision::float64}) {
    for (ContactLaw law : {linear(1e4, 0.6, 0.3), hertz(1e7, 0.6, 0.3)}) {
      law.rolling_friction = 0.1;
      law.surface_energy = 0.2;
      const double radius = 0.01;
      solver::Setup setup = touching_setup(law, precision);
      add_sphere(setup, {0.0093, 0.0031, -0.0015}, {-0.7, 0.2, 0.31}, radius, 0.01, {30, -7, 11});
      add_sphere(setup, {-0.0093, -0.0031, 0.0015}, {0.7, -0.2, -0.31}, radius, 0.01, {30, -7, 11});
      setup.dt = solver::contact_time(setup).step;
      World world(setup, {});
      for (std::int64_t step = 1; step < 1000; ++step) {
        world.advance_to(step);
        for (std::size_t c = 0; c < 3; ++c) {
          ASSERT_EQ(position(world, 0)[c], -position(world, 1)[c]) << step;
          ASSERT_EQ(velocity(world, 0)[c], -velocity(world, 1)[c]) << step;
          ASSERT_EQ(spin(world, 0)[c], spin(world, 1)[c]) << step;
        }
      }
      EXPECT_NE(spin(world, 0)[0], 30);
    }
  }
}

// Particles at rest above a plane that moves.
solver::Setup above_a_moving_plane(const models::ObstacleMotion& motion, const Triple& center) {
  const ContactLaw law = linear(1e4, 0.8, 0.3);
  solver::Setup setup = touching_setup(law, Precision::float32);
  Obstacle plane = ground(law);
  plane.motion = motion;
  setup.obstacles.push_back(plane);
  setup.emitters.push_back(lattice(center, {0.1, 0.1, 0.1}, 0.021, 0.01, 0.01));
  setup.dt = solver::contact_time(setup).step;
  return setup;
}

// To the bits of a world that makes its lists anew in every step.
void advance_as_if_anew(World& world, const solver::Setup& setup, std::int64_t last) {
  World anew(setup, reference);
  anew.advance_to(last);
  world.advance_to(last);
  EXPECT_EQ(world.hash().total, anew.hash().total);
}

// Particles at rest move no list to be built anew; the wall that comes for them does.
TEST(ContactWorld, AWallThatComesIsMetByParticlesAtRest) {
  const solver::Setup setup = above_a_moving_plane({.velocity = {0, 2, 0}}, {0, 0.1, 0});
  // The lowest are touched after 0.05 m.
  const auto last = static_cast<std::int64_t>(0.035 / setup.dt);
  for (const ContactTuning tuning : {ContactTuning{}, ContactTuning{1e-3, 1, 0}}) {
    World world(setup, execution(solver::widest_isa(), 2, tuning));
    advance_as_if_anew(world, setup, last);
    EXPECT_GT(velocity(world, 0)[1], 1);
  }
}

// No margin holds a plane that turns off: it is looked at in every step, and lists last.
TEST(ContactWorld, ATurningPlaneIsMetAndLetsListsLast) {
  const solver::Setup setup = above_a_moving_plane({.angular_velocity = {0, 0, 1}}, {1, 0.3, 0});
  // It comes to where the lowest are after a quarter of a second.
  const auto last = static_cast<std::int64_t>(0.3 / setup.dt);
  World world(setup, execution(solver::widest_isa(), 2, {}));
  advance_as_if_anew(world, setup, last);
  double fastest = 0;
  for (std::size_t row = 0; row < world.particles().rows(); ++row) {
    fastest = std::max(fastest, velocity(world, row)[1]);
  }
  EXPECT_GT(fastest, 0.5);
  EXPECT_LT(world.contact_profile()->list_builds, static_cast<std::uint64_t>(last / 3));
}

// Lists are taken from lists for some time, and those are found anew before somebody else comes.
TEST(ContactWorld, OuterListsLastUntilOthersComeNear) {
  for (const Precision precision : {Precision::float32, Precision::float64}) {
    solver::Setup setup = touching_setup(linear(2e3, 0.9, 0.3), precision);
    setup.seed = 5;
    setup.emitters.push_back(lattice({0, 0, 0}, {0.15, 0.15, 0.15}, 0.022, 0.01, 0.01));
    setup.emitters[0].speed = {Spread::Kind::uniform, 0, 2};
    setup.emitters[0].radius = {Spread::Kind::uniform, 0.004, 0.01};
    setup.dt = 4e-5;
    World anew(setup, reference);
    anew.advance_to(800);
    const std::uint64_t wanted = 800;
    EXPECT_EQ(anew.contact_profile()->list_builds, wanted);
    for (const double margin : {4e-4, 2e-3}) {
      World world(setup, execution(solver::widest_isa(), 2, {margin, 1, 0, 6}));
      world.advance_to(800);
      EXPECT_EQ(world.hash().total, anew.hash().total);
      const solver::ContactProfile& profile = *world.contact_profile();
      EXPECT_GT(profile.sorts, 3U);
      EXPECT_GT(profile.list_builds, 2 * profile.sorts);
      EXPECT_LT(profile.list_builds, wanted);
    }
  }
}

// What is where doubles end is far from all else, and nobody's business.
TEST(ContactWorld, SpheresAtTheEndOfSpaceLeaveTheOthersAlone) {
  const auto collided = [](bool with_far) {
    solver::Setup setup = touching_setup(linear(1e3, 0.5, 0.2), Precision::float64);
    add_sphere(setup, {0, 0, 0}, {1, 0, 0}, 0.01, 0.01);
    add_sphere(setup, {0.03, 0.004, 0}, {-1, 0, 0}, 0.01, 0.01);
    if (with_far) {
      add_sphere(setup, {1.6e308, 0, 0}, {0, 0, 0}, 0.01, 0.01);
      add_sphere(setup, {0, -1.6e308, 0}, {0, 0, 0}, 0.01, 0.01);
    }
    setup.dt = 1e-5;
    World world(setup, {});
    world.advance_to(3000);
    return std::array{velocity(world, 0)[0], velocity(world, 1)[1]};
  };
  EXPECT_EQ(collided(true), collided(false));
  EXPECT_LT(collided(true)[0], 0.5);
}

// Far from the origin a slow sphere goes by steps of what its position resolves, nearly twice as
// far as its speed says: the lists have to know.
TEST(ContactWorld, CreepingFarFromTheOriginIsSeen) {
  const double radius = 1e-3;
  const auto creep = [&](Precision precision, double from, double gap, double speed,
                         double margin) {
    solver::Setup setup = touching_setup(linear(1e3, 0.5), precision);
    add_sphere(setup, {from, 0, 0}, {speed, 0, 0}, radius, 1e-3);
    add_sphere(setup, {from + 2 * radius + gap, 0, 0}, {-speed, 0, 0}, radius, 1e-3);
    setup.birth_tolerance.reset();
    setup.dt = 1e-6;
    World world(setup, execution(solver::widest_isa(), 1, {margin, 1, 0}));
    World anew(setup, reference);
    for (std::int64_t step = 10; step <= 400; step += 10) {
      world.advance_to(step);
      anew.advance_to(step);
      ASSERT_EQ(world.hash().total, anew.hash().total) << step;
    }
    EXPECT_LT(velocity(world, 0)[0], 0.95 * speed);  // they have met
  };
  creep(Precision::float32, 0x1p20 + 0.04, 3e-7, 1.9e-3, 2e-7);
  creep(Precision::float64, 0x1p27, 5e-6, 1.6e-2, 4e-6);
}

// Impulses give nothing: momentum stays, and energy only goes, into the losses.
TEST(ContactWorld, ImpulsesNeverAddEnergy) {
  for (const double restitution : {0.0, 0.6, 1.0}) {
    solver::Setup setup = touching_setup(impulse(restitution, 0.4));
    setup.seed = 3;
    setup.emitters.push_back(lattice({0, 0, 0}, {0.1, 0.1, 0.1}, 0.0205, 0.01, 0.01));
    setup.emitters[0].speed = {Spread::Kind::uniform, 0.5, 3};
    setup.emitters[0].radius = {Spread::Kind::uniform, 0.006, 0.01};
    setup.emitters[0].mass = {Spread::Kind::uniform, 0.002, 0.02};
    setup.emitters[0].angular_velocity = {40, -100, 20};
    setup.dt = 1e-3;
    World world(setup, {});
    world.advance_to(0);
    const Totals first = totals(world);
    double before = first.kinetic;
    for (std::int64_t step = 1; step <= 60; ++step) {
      world.advance_to(step);
      const Totals now = totals(world);
      EXPECT_LE(now.kinetic, before * (1 + 1e-13)) << restitution << ", " << step;
      before = now.kinetic;
      EXPECT_NEAR(now.kinetic + now.losses, first.kinetic, 1e-12 * first.kinetic);
      for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(now.momentum[c], first.momentum[c], 1e-13 * first.momenta);
      }
    }
    EXPECT_LT(before, (restitution == 1 ? 0.999 : 0.9) * first.kinetic) << restitution;
  }
}

// Rolling friction needs the friction that makes a sphere roll; without it there is nothing to
// hold.
TEST(ContactWorld, RollingFrictionWithoutFrictionDoesNothing) {
  solver::Setup setup = stirred(linear(2e3, 0.5), Precision::float32);
  const std::vector<std::string> wanted = hashes(setup, {});
  setup.contact_law->rolling_friction = 0.3;
  EXPECT_EQ(hashes(setup, {}), wanted);
}

// ---- far from the origin ------------------------------------------------------------------------

// Some hundred spheres of about 1 cm that collide and settle in a box about `center`.
solver::Setup packing_at(Triple center, Precision precision) {
  ContactLaw law = linear(1e4, 0.5, 0.4);
  law.rolling_friction = 0.05;
  solver::Setup setup = touching_setup(law, precision);
  setup.forces.gravity = {0, -9.81, 0};
  setup.obstacles.push_back(hollow_box(center, {0.0625, 0.0625, 0.0625}, law));
  Emitter emitter = lattice(center, {0.125, 0.125, 0.125}, 0.0203, 0.01, 0.005);
  emitter.jitter = 1e-4;
  emitter.speed.a = 0.1;
  setup.emitters.push_back(emitter);
  setup.dt = 0x1p-14;
  return setup;
}

// Positions at 2^20 m are multiples of 1/8 m in float: the packing lives in what rounding leaves
// out, which is a float of up to 1/16 m and resolves 4e-9 m. That much a step may leave out, and
// impacts multiply it by distance over radius.
TEST(ContactWorld, AFloatPackingAMillionMetresAwayIsTheSamePacking) {
  for (const Triple& shift : {Triple{0x1p20, 0, 0}, Triple{-0x1p20, 0x1p20, -0x1p20}}) {
    World near(packing_at({0, 0, 0}, Precision::float32), {});
    World far(packing_at(shift, Precision::float32), {});
    ASSERT_GT(near.particles().rows(), 200U);
    struct Look {
      std::int64_t step;
      double tolerance;
    };
    for (const Look look : {Look{0, 1e-8}, Look{1, 1e-8}, Look{100, 2e-6}, Look{600, 1e-4}}) {
      near.advance_to(look.step);
      far.advance_to(look.step);
      double worst = 0;
      double deepest = 0;
      for (std::size_t i = 0; i < near.particles().rows(); ++i) {
        for (std::size_t j = i + 1; j < near.particles().rows(); ++j) {
          worst = std::max(worst, std::abs(distance(near, i, j) - distance(far, i, j)));
          deepest = std::max(deepest, overlap(far, i, j));
        }
      }
      EXPECT_LT(worst, look.tolerance) << shift[1] << ", step " << look.step;
      EXPECT_TRUE(look.step < 100 || deepest > 1e-5) << deepest;
    }
  }
}

// A column at rest: the k-th contact from above carries k weights, at the origin and far away.
TEST(ContactWorld, AColumnAMillionMetresAwayRestsOnItsOverlaps) {
  constexpr int spheres = 6;
  constexpr double radius = 0.0078125;
  constexpr double mass = 0.002;
  for (const double height : {0.0, 0x1p20, -0x1p20}) {
    const ContactLaw law = linear(1e3, 0.05);
    solver::Setup setup = touching_setup(law, Precision::float32);
    setup.forces.gravity = {0, -9.81, 0};
    setup.obstacles.push_back(ground(law));
    setup.obstacles[0].center = {height, height, height};
    for (int k = 0; k < spheres; ++k) {
      add_sphere(setup, {height, height + (2 * k + 1) * radius, height}, {0, 0, 0}, radius, mass);
    }
    setup.dt = solver::contact_time(setup).step;
    World world(setup, {});
    world.advance_to(30'000);
    for (std::size_t k = 0; k + 1 < spheres; ++k) {
      const double wanted =
          static_cast<double>(spheres - 1 - k) * mass * 9.81 / law.normal_stiffness;
      EXPECT_NEAR(overlap(world, k, k + 1), wanted, height == 0 ? 3e-8 : 4e-7)
          << height << ", contact " << k;
    }
  }
}

// A step of a millionth of a second moves a slow sphere by less than its float position resolves.
TEST(ContactWorld, ARestingContactDoesNotFreezeInFloat) {
  const double radius = 0.01;
  const double mass = 0.02;
  for (const double height : {0.0, 1000.0}) {
    ContactLaw law = linear(1e4, 0.1);
    solver::Setup setup = touching_setup(law, Precision::float32);
    setup.forces.gravity = {0, -9.81, 0};
    setup.obstacles.push_back(ground(law));
    setup.obstacles[0].center[1] = height;
    // 1000.0078125 is a float.
    const double start = height == 0 ? radius : 0.0078125;
    add_sphere(setup, {0, height + start, 0}, {0, 0, 0}, start, mass);
    setup.dt = 1e-6;
    World world(setup, {});
    world.advance_to(30'000);
    const double sag = height + start - position(world, 0)[1];
    const double wanted = mass * 9.81 / law.normal_stiffness;
    EXPECT_NEAR(sag, wanted, 0.01 * wanted) << height;
    EXPECT_NEAR(velocity(world, 0)[1], 0, 1e-5);
  }
}

}  // namespace
}  // namespace salvo::tests
