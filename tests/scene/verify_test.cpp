// What `salvo verify` finds: nothing in scenes that keep the contract, and the first step, column
// and id of differences that are planted in one run.
#include "scene/verify.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>

#include "scene/load.hpp"
#include "soa/contact_fields.hpp"

namespace salvo::tests {

namespace {

using scene::Difference;
using scene::first_difference;
using scene::value_text;
using scene::VerifyAxis;
using scene::VerifyOptions;
using scene::VerifyResult;
using scene::VerifyRun;
using solver::World;

constexpr auto velocity = static_cast<std::size_t>(soa::ParticleField::velocity);

// Two bursts and a jet, deaths and a floor: every axis has something to get wrong. A frame every 10
// of 40 steps.
scene::Scene small_scene(const std::string& more = {}) {
  return scene::parse(R"(
seed = 5
[time]
dt = 0.01
steps = 40
[forces]
quadratic_drag = true
[[obstacle]]
shape = "plane"
[[emitter]]
kind = "burst"
name = "first"
count = 301
position = [0, 1, 0]
speed = { uniform = [2, 9] }
radius = 0.01
drag_area = 1e-4
life = { uniform = [0.05, 2] }
[[emitter]]
kind = "jet"
name = "pipe"
rate = 700
duration = 0.3
position = [1, 1, 0]
direction = [0, 1, 0]
speed = 3
drag_area = 1e-4
[[emitter]]
kind = "burst"
name = "last"
count = 97
time = 0.1
position = [0, 2, 0]
speed = 4
drag_area = 2e-4
[frames]
every = 10
)" + more,
                      "small.toml");
}

void flip_bit(World& world, std::size_t component, soa::Id id, std::uint32_t bit) {
  auto& particles = const_cast<soa::Table&>(world.particles());
  auto* column = particles.column<float>(velocity, component);
  for (std::size_t row = 0; row < particles.rows(); ++row) {
    if (particles.ids()[row] == id) {
      column[row] = std::bit_cast<float>(std::bit_cast<std::uint32_t>(column[row]) ^ bit);
    }
  }
}

// Does something to the world of some runs at a step, wherever that lies within an advance.
VerifyOptions planted(std::function<bool(const VerifyRun&)> where, std::int64_t at,
                      std::function<void(World&)> what) {
  VerifyOptions options;
  options.threads = {3};
  options.passes = {7};
  options.advance = [=](const VerifyRun& run, World& world, std::int64_t step) {
    if (where(run) && world.step() < at && at <= step) {
      world.advance_to(at);
      what(world);
    }
    world.advance_to(step);
  };
  return options;
}

std::function<bool(const VerifyRun&)> on(VerifyAxis axis) {
  return [=](const VerifyRun& run) { return run.axis == axis; };
}

solver::Isa widest_but_scalar() { return solver::widest_isa(); }

// The one run that differs; the others have to be equal.
const VerifyRun& differing_run(const VerifyResult& result) {
  const VerifyRun* found = nullptr;
  for (const VerifyRun& run : result.runs) {
    if (!run.difference) continue;
    EXPECT_EQ(found, nullptr) << "a second run differs: " << name(run.axis) << " " << run.value;
    found = &run;
  }
  EXPECT_NE(found, nullptr) << "no run differs";
  static const VerifyRun none;
  return found ? *found : none;
}

TEST(Verify, FindsNoDifferenceInASceneThatKeepsTheContract) {
  const VerifyResult result = scene::verify(small_scene(), {});
  EXPECT_TRUE(result.equal());
  std::map<VerifyAxis, int> runs;
  for (const VerifyRun& run : result.runs) {
    ++runs[run.axis];
    EXPECT_EQ(run.frames, 5U) << name(run.axis) << " " << run.value;
    EXPECT_GT(run.rows, 0U);
    if (run.axis != VerifyAxis::rows && run.axis != VerifyAxis::emitter) {
      EXPECT_EQ(run.hash, result.runs.front().hash);
    }
  }
  EXPECT_EQ(runs[VerifyAxis::reference], 1);
  EXPECT_EQ(runs[VerifyAxis::isa], static_cast<int>(solver::available_isas().size()) - 1);
  EXPECT_EQ(runs[VerifyAxis::threads], 5);
  EXPECT_EQ(runs[VerifyAxis::pass], 2);
  EXPECT_EQ(runs[VerifyAxis::resume], 1);
  EXPECT_EQ(runs[VerifyAxis::rows], 1);
  EXPECT_EQ(runs[VerifyAxis::emitter], 1);
}

TEST(Verify, ComparesDoublesToo) {
  EXPECT_TRUE(
      scene::verify(scene::parse("precision = \"double\"\n" + small_scene().text, "d.toml"), {})
          .equal());
}

TEST(Verify, NamesStepColumnAndIdOfOneFlippedBit) {
  const soa::Id id = soa::make_id(0, 123);
  const VerifyResult result =
      scene::verify(small_scene(), planted(
                                       [](const VerifyRun& run) {
                                         return run.execution.isa == widest_but_scalar() &&
                                                run.axis == VerifyAxis::isa;
                                       },
                                       23, [=](World& world) { flip_bit(world, 1, id, 1); }));
  const VerifyRun& run = differing_run(result);
  EXPECT_EQ(run.value, name(widest_but_scalar()));
  const Difference& difference = run.difference.value();
  EXPECT_EQ(difference.step, 23);
  EXPECT_EQ(difference.equal_step, 22);
  EXPECT_TRUE(difference.exact());
  EXPECT_EQ(difference.column, "velocity.y");
  EXPECT_EQ(difference.id, id);
  EXPECT_EQ(difference.rows, 1U);
  // One bit of the last place apart, in hexadecimal floating point.
  const double reference = std::stod(difference.reference);
  const double varied = std::stod(difference.varied);
  EXPECT_EQ(difference.reference.find("0x"), difference.reference[0] == '-' ? 1U : 0U);
  EXPECT_EQ(static_cast<float>(varied),
            std::bit_cast<float>(std::bit_cast<std::uint32_t>(static_cast<float>(reference)) ^ 1U));
}

TEST(Verify, NamesADifferenceOfEveryAxis) {
  for (const VerifyAxis axis : {VerifyAxis::threads, VerifyAxis::pass, VerifyAxis::resume,
                                VerifyAxis::rows, VerifyAxis::emitter}) {
    // Of the last emitter, because that one is alone; kept among every third row, because it is
    // born later.
    const soa::Id id = soa::make_id(2, 40);
    const VerifyResult result = scene::verify(
        small_scene(), planted(on(axis), 37, [=](World& world) { flip_bit(world, 2, id, 4); }));
    const VerifyRun& run = differing_run(result);
    EXPECT_EQ(run.axis, axis);
    const Difference difference = run.difference.value_or(Difference{});
    EXPECT_EQ(difference.step, 37) << name(axis);
    EXPECT_TRUE(difference.exact()) << name(axis);
    EXPECT_EQ(difference.column, "velocity.z") << name(axis);
    EXPECT_EQ(difference.id, id) << name(axis);
  }
}

TEST(Verify, NamesTheFrameOfADifferenceThatSingleStepsDoNotShow) {
  const soa::Id id = soa::make_id(0, 7);
  VerifyOptions options;
  options.threads = {};
  options.advance = [=](const VerifyRun& run, World& world, std::int64_t step) {
    const bool long_way = step > world.step() + 1;
    world.advance_to(step);
    if (run.axis == VerifyAxis::pass && run.value == "7" && long_way && step == 20) {
      flip_bit(world, 0, id, 1);
    }
  };
  const VerifyResult result = scene::verify(small_scene(), options);
  const Difference difference = differing_run(result).difference.value_or(Difference{});
  EXPECT_FALSE(difference.exact());
  EXPECT_EQ(difference.equal_step, 10);
  EXPECT_EQ(difference.step, 20);
  EXPECT_EQ(difference.column, "velocity.x");
  EXPECT_EQ(difference.id, id);
}

TEST(Verify, NamesARowThatOneRunLacks) {
  const auto lose_first_row = [](World& world) {
    std::vector<std::uint8_t> keep(world.particles().rows(), 1);
    keep[0] = 0;
    const_cast<soa::Table&>(world.particles()).compact(keep);
  };
  const VerifyResult result =
      scene::verify(small_scene(), planted(on(VerifyAxis::threads), 5, lose_first_row));
  const Difference difference = differing_run(result).difference.value_or(Difference{});
  EXPECT_EQ(difference.step, 5);
  EXPECT_EQ(difference.column, "id");
  EXPECT_EQ(difference.varied, "absent");
  EXPECT_EQ(difference.reference, std::to_string(difference.id.value_or(soa::max_serial)));
}

TEST(Verify, ComparesResultsBesidesTheState) {
  const auto count_an_impact = [](World& world) {
    solver::ContactTally tally = world.tally();
    ++tally.impacts;
    soa::Table same = World::empty_table(world.setup());
    std::swap(same, const_cast<soa::Table&>(world.particles()));
    world.restore(world.step(), std::move(same), tally, world.removed());
  };
  const VerifyResult result =
      scene::verify(small_scene(), planted(on(VerifyAxis::threads), 15, count_an_impact));
  const Difference difference = differing_run(result).difference.value_or(Difference{});
  EXPECT_EQ(difference.step, 15);
  EXPECT_EQ(difference.column, "impacts");
  EXPECT_FALSE(difference.id.has_value());
}

// ---- particles that touch -----------------------------------------------------------------------

constexpr auto partner = static_cast<std::size_t>(soa::ContactField::partner);
constexpr auto tangential = static_cast<std::size_t>(soa::ContactField::tangential_displacement);

// Two layers of spheres, squeezed a little, that spin and fall on a floor: contacts of both kinds.
scene::Scene touching_scene() {
  return scene::parse(R"(
[time]
dt = 1e-5
steps = 60
[contact_law]
kind = "linear_spring"
normal_stiffness = 1e4
restitution = 0.5
friction = 0.4
[[obstacle]]
shape = "plane"
restitution = 0.5
friction = 0.4
[[emitter]]
kind = "lattice"
position = [0, 0.019975, 0]
size = [0.06, 0.04, 0.06]
spacing = 0.01995
velocity = [0.2, -0.1, 0]
angular_velocity = [1, 20, -5]
mass = 0.01
radius = 0.01
[frames]
every = 20
)",
                      "touching.toml");
}

// Puts the world back with its contacts changed: what rests in a table is not what it steps.
void change_contacts(World& world, const std::function<void(soa::Table&)>& change) {
  soa::Table particles = world.particles().copy();
  soa::Table contacts = world.contacts().copy();
  change(contacts);
  world.restore(world.step(), std::move(particles), world.tally(), world.removed(),
                std::move(contacts));
}

struct Pair {
  soa::Id id = 0;
  soa::Id other = 0;
};

Pair pair_at(const World& world, std::size_t row) {
  return {world.contacts().ids()[row], world.contacts().column<std::uint64_t>(partner)[row]};
}

TEST(Verify, FindsNoDifferenceInParticlesThatTouch) {
  const scene::Scene scene = touching_scene();
  EXPECT_TRUE(scene::verify(scene, {}).equal());
  World world(scene.setup, {});
  world.advance_to(20);
  EXPECT_GT(world.contacts().rows(), 20U);
}

TEST(Verify, NamesThePairAndColumnOfADifferenceInWhatContactsRemember) {
  constexpr std::int64_t step = 39;
  const scene::Scene scene = touching_scene();
  World straight(scene.setup, {});
  straight.advance_to(step);
  // The last contact of two particles, and the first of one with the floor.
  const auto is_wall = [&](std::size_t row) {
    return soa::stream_of(pair_at(straight, row).other) == soa::max_stream;
  };
  std::size_t wall = 0;
  while (!is_wall(wall)) ++wall;
  std::size_t last = straight.contacts().rows() - 1;
  while (is_wall(last)) --last;
  for (const std::size_t row : {wall, last}) {
    for (const VerifyAxis axis : {VerifyAxis::threads, VerifyAxis::resume, VerifyAxis::lists}) {
      // So much that it lasts until the next frame.
      const auto stretch = [=](World& world) {
        change_contacts(world, [=](soa::Table& contacts) {
          contacts.column<float>(tangential, 2)[row] += 1e-6F;
        });
      };
      const auto one = [=](const VerifyRun& run) {
        return run.axis == axis && (axis != VerifyAxis::lists || run.value == "large cells");
      };
      const VerifyResult result = scene::verify(scene, planted(one, step, stretch));
      const Difference difference = differing_run(result).difference.value_or(Difference{});
      EXPECT_EQ(difference.step, step) << name(axis);
      EXPECT_TRUE(difference.exact()) << name(axis);
      EXPECT_EQ(difference.column, "tangential_displacement.z") << name(axis);
      EXPECT_EQ(difference.id, pair_at(straight, row).id) << name(axis);
      EXPECT_EQ(difference.partner, pair_at(straight, row).other) << name(axis);
      EXPECT_EQ(difference.rows, 1U) << name(axis);
    }
  }
}

TEST(Verify, NamesAContactThatOneRunForgot) {
  constexpr std::int64_t step = 33;
  const scene::Scene scene = touching_scene();
  World straight(scene.setup, {});
  straight.advance_to(step);
  const auto forget = [](World& world) {
    change_contacts(world, [](soa::Table& contacts) {
      std::vector<std::uint8_t> keep(contacts.rows(), 1);
      keep[2] = 0;
      contacts.compact(keep);
    });
  };
  const VerifyResult result = scene::verify(scene, planted(on(VerifyAxis::threads), step, forget));
  const Difference difference = differing_run(result).difference.value_or(Difference{});
  EXPECT_EQ(difference.step, step);
  EXPECT_EQ(difference.column, "contact");
  EXPECT_EQ(difference.id, pair_at(straight, 2).id);
  EXPECT_EQ(difference.partner, pair_at(straight, 2).other);
  EXPECT_EQ(difference.reference, "there");
  EXPECT_EQ(difference.varied, "absent");
}

// ---- runs that stop -----------------------------------------------------------------------------

// A domain that the fastest particles leave.
constexpr const char* narrow = R"(
[domain]
lowest = [-0.5, -10, -10]
highest = [10, 10, 10]
)";

TEST(Verify, AgreesWhereASceneStops) {
  const VerifyResult result = scene::verify(small_scene(narrow), {});
  EXPECT_TRUE(result.equal());
  ASSERT_TRUE(result.runs.front().stopped.has_value());
  const solver::BadRow& first = *result.runs.front().stopped;
  EXPECT_TRUE(first.left_domain);
  EXPECT_EQ(first.column, "position.x");
  for (const VerifyRun& run : result.runs) {
    if (run.axis == VerifyAxis::rows || run.axis == VerifyAxis::emitter) continue;
    ASSERT_TRUE(run.stopped.has_value()) << run.value;
    EXPECT_EQ(run.stopped->step, first.step) << run.value;
    EXPECT_EQ(run.stopped->id, first.id) << run.value;
  }
}

TEST(Verify, NamesTheParticleAtWhichOneRunAloneStops) {
  const soa::Id id = soa::make_id(0, 11);
  const auto blow_up = [=](World& world) {
    auto& particles = const_cast<soa::Table&>(world.particles());
    for (std::size_t row = 0; row < particles.rows(); ++row) {
      if (particles.ids()[row] == id) {
        particles.column<float>(velocity, 0)[row] = std::numeric_limits<float>::infinity();
      }
    }
  };
  const VerifyResult result =
      scene::verify(small_scene(), planted(on(VerifyAxis::threads), 13, blow_up));
  const VerifyRun& run = differing_run(result);
  ASSERT_TRUE(run.stopped.has_value());
  const Difference difference = run.difference.value_or(Difference{});
  EXPECT_EQ(difference.step, 13);
  EXPECT_EQ(difference.id, id);
  EXPECT_EQ(difference.column, "velocity.x");
  EXPECT_EQ(difference.varied, "inf");
}

TEST(Verify, ReportsEveryFrame) {
  std::size_t calls = 0;
  VerifyOptions options;
  options.isas = {solver::Isa::scalar};
  options.threads = {};
  options.passes = {2};
  options.on_progress = [&](const scene::VerifyProgress& at) {
    EXPECT_LT(at.run, at.runs);
    EXPECT_EQ(at.steps, 40);
    ++calls;
  };
  const VerifyResult result = scene::verify(small_scene(), options);
  EXPECT_EQ(result.runs.size(), 5U);  // reference, pass, resume, rows, emitter
  EXPECT_EQ(calls, 5U * result.runs.size());
}

soa::Table three_rows() {
  std::vector<bool> stored(soa::particle_fields.size(), false);
  std::fill_n(stored.begin(), 3, true);
  soa::Table table(soa::particle_fields, soa::Precision::float64, stored);
  table.append(3);
  for (soa::Id id = 0; id < 3; ++id) table.ids()[id] = 10 + id;
  return table;
}

TEST(FirstDifference, ComparesBitsExceptOfNaN) {
  soa::Table a = three_rows();
  soa::Table b = three_rows();
  EXPECT_FALSE(first_difference(a, b).has_value());
  a.column<double>(1, 2)[1] = std::numeric_limits<double>::quiet_NaN();
  b.column<double>(1, 2)[1] = -std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(first_difference(a, b).has_value());
  b.column<double>(2, 0)[2] = -0.0;
  const auto difference = first_difference(a, b);
  ASSERT_TRUE(difference.has_value());
  EXPECT_EQ(difference->column, "velocity.x");
  EXPECT_EQ(difference->id, 12U);
  EXPECT_EQ(difference->reference, "0x0p+0");
  EXPECT_EQ(difference->varied, "-0x0p+0");
}

TEST(FirstDifference, TakesTheLowestIdThenTheFirstColumn) {
  soa::Table a = three_rows();
  soa::Table b = three_rows();
  b.column<double>(2, 1)[0] = 1;
  b.column<double>(1, 0)[2] = 1;
  const auto difference = first_difference(a, b);
  ASSERT_TRUE(difference.has_value());
  EXPECT_EQ(difference->id, 10U);
  EXPECT_EQ(difference->column, "velocity.y");
  EXPECT_EQ(difference->rows, 2U);
  EXPECT_EQ(value_text(b, 12, "position.x"), "0x1p+0");
  EXPECT_EQ(value_text(b, 13, "position.x"), "absent");
}

// Of one particle: contacts are told apart by their partners.
TEST(FirstDifference, TellsContactsOfOneParticleApart) {
  const auto three_contacts = [] {
    soa::Table table(soa::contact_fields, soa::Precision::float64, {true, true, true, false});
    table.append(3);
    for (std::size_t row = 0; row < 3; ++row) {
      table.ids()[row] = 7;
      table.column<std::uint64_t>(partner)[row] = 10 + row;
    }
    return table;
  };
  soa::Table a = three_contacts();
  soa::Table b = three_contacts();
  EXPECT_FALSE(first_difference(a, b).has_value());
  b.column<double>(tangential, 0)[2] = 1;
  auto difference = first_difference(a, b).value_or(Difference{});
  EXPECT_EQ(difference.id, 7U);
  EXPECT_EQ(difference.partner, 12U);
  EXPECT_EQ(difference.column, "tangential_displacement.x");
  EXPECT_EQ(difference.rows, 1U);
  const std::vector<std::uint8_t> keep{1, 0, 1};
  a.compact(keep);
  difference = first_difference(a, b).value_or(Difference{});
  EXPECT_EQ(difference.partner, 11U);
  EXPECT_EQ(difference.column, "contact");
  EXPECT_EQ(difference.reference, "absent");
  EXPECT_EQ(difference.rows, 2U);
}

}  // namespace
}  // namespace salvo::tests
