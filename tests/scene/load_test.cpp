// Reading scenes: what the keys fill, and the text of every kind of mistake.
#include "scene/load.hpp"

#include <gtest/gtest.h>

#include <cfenv>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "kernels/math.hpp"
#include "scene/units.hpp"

namespace salvo::scene {
namespace {

using S = kernels::ScalarLane<double>;

const std::string minimal = R"([time]
dt = 0.01
duration = 1
[[emitter]]
kind = "burst"
count = 10
)";

std::string mistakes_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    parse(text, "scene.toml", overrides);
  } catch (const SceneError& error) {
    return error.what();
  }
  return "no mistake";
}

// The mistakes of the minimal scene with more text at its end, which belongs to the emitter.
std::string mistakes_with(const std::string& more) { return mistakes_of(minimal + more); }

TEST(Scene, DefaultsAreThoseOfTheStructures) {
  const Scene scene = parse(minimal, "scene.toml");
  EXPECT_EQ(scene.path, "scene.toml");
  EXPECT_EQ(scene.text, minimal);
  EXPECT_EQ(scene.title, "");
  EXPECT_EQ(scene.setup.precision, soa::Precision::float32);
  EXPECT_EQ(scene.setup.seed, 0u);
  EXPECT_EQ(scene.setup.integrator, solver::IntegratorKind::semi_implicit_euler);
  EXPECT_EQ(scene.setup.t0, 0.0);
  EXPECT_EQ(scene.setup.dt, 0.01);
  EXPECT_EQ(scene.steps, 100);
  EXPECT_EQ(scene.setup.forces.gravity, (models::Triple{0, -9.80665, 0}));
  EXPECT_FALSE(scene.setup.forces.windy);
  EXPECT_FALSE(scene.setup.forces.gusty);
  EXPECT_FALSE(scene.setup.domain.bounded);
  EXPECT_EQ(scene.setup.on_bad, solver::BadRowPolicy::stop);
  EXPECT_EQ(scene.frames.every, 1);
  EXPECT_EQ(scene.frames.fraction, 1.0);
  EXPECT_EQ(scene.frame_count(), 101);
  EXPECT_EQ(scene.checkpoint.every, 0);
  EXPECT_TRUE(scene.checkpoint.at_end);
  EXPECT_EQ(scene.verify.rows, 50000u);
  ASSERT_EQ(scene.setup.emitters.size(), 1u);
  const solver::Emitter& emitter = scene.setup.emitters[0];
  EXPECT_EQ(emitter.kind, solver::EmitterKind::burst);
  EXPECT_EQ(emitter.stream, 0u);
  EXPECT_EQ(emitter.count, 10u);
  EXPECT_EQ(emitter.mass.a, 1.0);
  EXPECT_FALSE(emitter.life);
  EXPECT_FALSE(emitter.drag_coefficient);
}

TEST(Scene, KeysFillTheirMembers) {
  const Scene scene = parse(R"(
title = "all"
precision = "double"
seed = 17
integrator = "runge_kutta_4"
[time]
start = 5
steps_per_second = 200
steps = 400
[forces]
gravity = ["1 m/s^2", 0, -2]
up = [0, 0, 3]
air_density = "1 g/cm^3"
quadratic_drag = true
linear_drag = 0.5
buoyancy = true
[forces.wind]
profile = "log_law"
velocity = ["10 kn", 0, 0]
reference_height = "20 ft"
roughness = "1 cm"
ground = -1
[forces.gust]
standard_deviation = [1, 2, 3]
length = 50
speed = 4
direction = [1, 0, 0]
[[forces.point_gravity]]
position = [1, 2, 3]
strength = 9
softening = 0.5
[[forces.blast]]
position = [4, 5, 6]
time = 5.5
impulse = 3
duration = "2 ms"
reference_radius = 2
exponent = 2
[contact]
max_impacts = 7
[[obstacle]]
shape = "box"
position = [1, 0, 0]
half_size = [1, 2, 3]
rotation_axis = [0, 0, 2]
rotation_angle = "90 deg"
restitution = 0.25
friction = 0.75
mass = 5
[[obstacle]]
shape = "plane"
normal = [0, 3, 4]
[domain]
lowest = [-1000, -1000, -1000]
highest = [1000, 1000, 1000]
on_leave = "remove"
[[emitter]]
kind = "cone"
name = "one"
stream = 9
count = 1e3
time = 6
position = [1, 1, 1]
velocity = [0, 1, 0]
source_radius = 0.5
direction = [0, 0, -5]
half_angle = "30 deg"
speed = { uniform = ["10 m/s", 20] }
mass = { normal = ["10 g", "1 g"] }
radius = "1 mm"
drag_area = 0.01
life = 2
group = 3
[[emitter]]
kind = "jet"
rate = 100
time = 6
[[emitter]]
kind = "book_explosion"
count = 50
strength = 75
angle = "45 deg"
longest_life = "4 s"
[[emitter]]
kind = "energy_explosion"
count = 5
energy = "2 kJ"
shares = "book"
drag_coefficient = 0.47
radius = 0.1
[frames]
count = 20
columns = ["position", "group"]
fraction = 0.25
[checkpoint]
every = 100
at_end = false
[verify]
rows = 100
steps = 50
)",
                            "scene.toml");
  const solver::Setup& setup = scene.setup;
  EXPECT_EQ(scene.title, "all");
  EXPECT_EQ(setup.precision, soa::Precision::float64);
  EXPECT_EQ(setup.seed, 17u);
  EXPECT_EQ(setup.integrator, solver::IntegratorKind::runge_kutta_4);
  EXPECT_EQ(setup.t0, 5.0);
  EXPECT_EQ(setup.dt, 0.005);
  EXPECT_EQ(scene.steps, 400);
  EXPECT_EQ(setup.forces.gravity, (models::Triple{1, 0, -2}));
  EXPECT_EQ(setup.forces.up, (models::Triple{0, 0, 1}));
  EXPECT_EQ(setup.forces.air_density, 1000.0);
  EXPECT_TRUE(setup.forces.quadratic_drag);
  EXPECT_EQ(setup.forces.linear_drag, 0.5);
  EXPECT_TRUE(setup.forces.buoyancy);
  EXPECT_TRUE(setup.forces.windy);
  EXPECT_EQ(setup.forces.wind.profile, models::WindProfile::log_law);
  EXPECT_EQ(setup.forces.wind.velocity[0], 18520.0 / 3600);
  EXPECT_EQ(setup.forces.wind.reference_height, 6.096);
  EXPECT_EQ(setup.forces.wind.roughness, 0.01);
  EXPECT_EQ(setup.forces.wind.ground, -1.0);
  EXPECT_TRUE(setup.forces.gusty);
  EXPECT_EQ(setup.forces.gust.standard_deviation, (models::Triple{1, 2, 3}));
  EXPECT_EQ(setup.forces.gust.length, 50.0);
  EXPECT_EQ(setup.forces.gust.speed, 4.0);
  ASSERT_EQ(setup.forces.point_gravity.size(), 1u);
  EXPECT_EQ(setup.forces.point_gravity[0].center, (models::Triple{1, 2, 3}));
  EXPECT_EQ(setup.forces.point_gravity[0].softening, 0.5);
  ASSERT_EQ(setup.forces.blasts.size(), 1u);
  EXPECT_EQ(setup.forces.blasts[0].duration, 0.002);
  EXPECT_EQ(setup.forces.blasts[0].exponent, 2);
  EXPECT_EQ(setup.contact.max_impacts, 7);
  ASSERT_EQ(setup.obstacles.size(), 2u);
  EXPECT_EQ(setup.obstacles[0].half_size, (models::Triple{1, 2, 3}));
  EXPECT_DOUBLE_EQ(setup.obstacles[0].rotation[0], sqrt(S(0.5)).value());
  EXPECT_EQ(setup.obstacles[0].rotation[1], 0.0);
  EXPECT_DOUBLE_EQ(setup.obstacles[0].rotation[3], sqrt(S(0.5)).value());
  EXPECT_EQ(setup.obstacles[0].mass, 5.0);
  EXPECT_DOUBLE_EQ(setup.obstacles[1].axis[1], 0.6);
  EXPECT_DOUBLE_EQ(setup.obstacles[1].axis[2], 0.8);
  EXPECT_TRUE(setup.domain.bounded);
  EXPECT_EQ(setup.on_bad, solver::BadRowPolicy::remove);
  ASSERT_EQ(setup.emitters.size(), 4u);
  const solver::Emitter& cone = setup.emitters[0];
  EXPECT_EQ(cone.stream, 9u);
  EXPECT_EQ(cone.count, 1000u);
  EXPECT_EQ(cone.direction, (models::Triple{0, 0, -1}));
  EXPECT_EQ(cone.half_angle, quantity("30 deg", "rad"));
  EXPECT_EQ(cone.speed.kind, solver::Spread::Kind::uniform);
  EXPECT_EQ(cone.speed.b, 20.0);
  EXPECT_EQ(cone.mass.kind, solver::Spread::Kind::normal);
  EXPECT_EQ(cone.mass.b, 0.001);
  EXPECT_EQ(cone.drag_area.a, 0.01);
  ASSERT_TRUE(cone.life);
  EXPECT_EQ(cone.life->a, 2.0);
  EXPECT_EQ(cone.group, 3u);
  EXPECT_EQ(setup.emitters[1].stream, 1u);
  EXPECT_EQ(setup.emitters[1].duration, 1.0);
  EXPECT_EQ(setup.emitters[2].time, 5.0);
  EXPECT_EQ(setup.emitters[2].angle, 45.0);
  EXPECT_EQ(setup.emitters[2].life_ms, 4000.0);
  EXPECT_EQ(setup.emitters[3].energy, 2000.0);
  EXPECT_EQ(setup.emitters[3].shares, solver::EnergyShares::book);
  EXPECT_EQ(setup.emitters[3].drag_coefficient, 0.47);
  EXPECT_EQ(scene.frames.every, 20);
  EXPECT_EQ(scene.frames.columns,
            (std::vector{soa::ParticleField::position, soa::ParticleField::group}));
  EXPECT_EQ(scene.frames.fraction, 0.25);
  EXPECT_EQ(scene.checkpoint.every, 100);
  EXPECT_FALSE(scene.checkpoint.at_end);
  EXPECT_EQ(scene.verify.rows, 100u);
  EXPECT_EQ(scene.verify.steps, 50);
}

TEST(Scene, HeightFieldsComeFromRowsOrHills) {
  const Scene rows = parse(minimal + R"([[obstacle]]
shape = "height_field"
spacing = 2
heights = [[0, 1, 2], [3, "40 cm", 5]]
)",
                           "scene.toml");
  const models::HeightSamples& samples = *rows.setup.obstacles.at(0).samples;
  EXPECT_EQ(samples.columns, 3u);
  EXPECT_EQ(samples.rows, 2u);
  EXPECT_EQ(samples.spacing, 2.0);
  EXPECT_EQ(samples.heights, (std::vector<double>{0, 1, 2, 3, 0.4, 5}));
  const std::string hills = R"([[obstacle]]
shape = "height_field"
spacing = 0.5
hills = { columns = 200, rows = 300, deviation = 2, length = 20, seed = SEED }
)";
  const auto heights = [&](const char* seed) {
    std::string text = hills;
    text.replace(text.find("SEED"), 4, seed);
    return parse(minimal + text, "scene.toml").setup.obstacles.at(0).samples->heights;
  };
  const std::vector<double> first = heights("1");
  EXPECT_EQ(first, heights("1"));
  EXPECT_NE(first, heights("2"));
  ASSERT_EQ(first.size(), 60000u);
  double squares = 0;
  for (const double height : first) squares += height * height;
  EXPECT_NEAR(squares / 60000, 4, 1.5);
}

TEST(Scene, TheRoundingModeOfTheCallerDoesNotMatter) {
  const std::string text = minimal + "speed = 0.1\nmass = \"0.1 g\"\ndirection = [1, 1, 1]\n";
  std::string cone = text;
  cone.replace(cone.find("burst"), 5, "cone");
  const Scene expected = parse(cone, "scene.toml");
  std::fesetround(FE_UPWARD);
  const Scene found = parse(cone, "scene.toml");
  std::fesetround(FE_TONEAREST);
  EXPECT_EQ(found.setup.emitters[0].speed.a, 0.1);
  EXPECT_EQ(found.setup.emitters[0].mass.a, expected.setup.emitters[0].mass.a);
  EXPECT_EQ(found.setup.emitters[0].direction, expected.setup.emitters[0].direction);
}

TEST(SceneMistakes, UnknownKeyInTheDesignsForm) {
  EXPECT_EQ(mistakes_of("[time]\ndt = 0.01\nduration = 1\n[[emitter]]\nsped = 120\nkind = "
                        "\"burst\"\ncount = 1\n"),
            "scene.toml:5:1: error: unknown key \"sped\" in [[emitter]]\n"
            "  5 | sped = 120\n"
            "    | ^^^^ did you mean \"speed\"?");
}

TEST(SceneMistakes, UnknownKeys) {
  EXPECT_EQ(mistakes_with("[frames]\nevry = 2\n"),
            "scene.toml:8:1: error: unknown key \"evry\" in [frames]\n"
            "  8 | evry = 2\n"
            "    | ^^^^ did you mean \"every\"?");
  EXPECT_EQ(mistakes_of("gravity = [0, 0, 0]\n" + minimal),
            "scene.toml:1:1: error: unknown key \"gravity\" in the scene\n"
            "  1 | gravity = [0, 0, 0]\n"
            "    | ^^^^^^^ it belongs to [forces]");
  EXPECT_EQ(mistakes_with("[verify]\nxyzzy = 1\n"),
            "scene.toml:8:1: error: unknown key \"xyzzy\" in [verify]\n"
            "  8 | xyzzy = 1\n"
            "    | ^^^^^ expected rows or steps");
  EXPECT_EQ(mistakes_with("[forces]\n\"wind\" = { velocty = [0, 0, 0], velocity = [1, 0, 0] }\n"),
            "scene.toml:8:12: error: unknown key \"velocty\" in [forces.wind]\n"
            "  8 | \"wind\" = { velocty = [0, 0, 0], velocity = [1, 0, 0] }\n"
            "    |            ^^^^^^^ did you mean \"velocity\"?");
}

TEST(SceneMistakes, WrongTypes) {
  EXPECT_EQ(mistakes_with("radius = true\n"),
            "scene.toml:7:10: error: \"radius\" in [[emitter]] is true or false\n"
            "  7 | radius = true\n"
            "    |          ^^^^ expected a number, { uniform = [low, high] } or { normal = [mean, "
            "deviation] }");
  EXPECT_EQ(mistakes_with("source_radius = []\n"),
            "scene.toml:7:17: error: \"source_radius\" in [[emitter]] is a list\n"
            "  7 | source_radius = []\n"
            "    |                 ^^ expected a length in m");
  EXPECT_EQ(mistakes_with("group = \"7\"\n"),
            "scene.toml:7:9: error: \"group\" in [[emitter]] is a string\n"
            "  7 | group = \"7\"\n"
            "    |         ^^^ expected a whole number");
  EXPECT_EQ(mistakes_with("group = 1.5\n"),
            "scene.toml:7:9: error: \"group\" in [[emitter]] is a number\n"
            "  7 | group = 1.5\n"
            "    |         ^^^ expected a whole number");
  EXPECT_EQ(mistakes_with("name = 3\n"),
            "scene.toml:7:8: error: \"name\" in [[emitter]] is a whole number\n"
            "  7 | name = 3\n"
            "    |        ^ expected a string");
  EXPECT_EQ(mistakes_with("position = 3\n"),
            "scene.toml:7:12: error: \"position\" in [[emitter]] is a whole number\n"
            "  7 | position = 3\n"
            "    |            ^ expected a list of 3 numbers");
  EXPECT_EQ(mistakes_with("position = [1, 2]\n"),
            "scene.toml:7:12: error: \"position\" in [[emitter]] has length 2\n"
            "  7 | position = [1, 2]\n"
            "    |            ^^^^^^ expected 3 numbers");
  EXPECT_EQ(mistakes_with("[forces]\nbuoyancy = 1979-05-27\n"),
            "scene.toml:8:12: error: \"buoyancy\" in [forces] is a date\n"
            "  8 | buoyancy = 1979-05-27\n"
            "    |            ^^^^^^^^^^ expected true or false");
  EXPECT_EQ(mistakes_of("forces = 3\n" + minimal),
            "scene.toml:1:10: error: \"forces\" is a whole number\n"
            "  1 | forces = 3\n"
            "    |          ^ expected the table [forces]");
  EXPECT_EQ(mistakes_of("[time]\ndt = 1\nduration = 1\n[emitter]\nkind = \"burst\"\n"),
            "scene.toml:4:1: error: \"emitter\" is a table\n"
            "  4 | [emitter]\n"
            "    | ^^^^^^^^^ expected tables [[emitter]]");
}

TEST(SceneMistakes, Bounds) {
  EXPECT_EQ(mistakes_with("[[obstacle]]\nshape = \"plane\"\nrestitution = 1.5\nfriction = -1\n"),
            "scene.toml:9:15: error: \"restitution\" in [[obstacle]] is out of bounds\n"
            "  9 | restitution = 1.5\n"
            "    |               ^^^ expected 0 to 1\n"
            "scene.toml:10:12: error: \"friction\" in [[obstacle]] is out of bounds\n"
            " 10 | friction = -1\n"
            "    |            ^^ expected at least 0");
  EXPECT_EQ(mistakes_of("[time]\ndt = 0\nduration = 1\n[[emitter]]\nkind = \"burst\"\ncount = 0\n"),
            "scene.toml:2:6: error: \"dt\" in [time] is out of bounds\n"
            "  2 | dt = 0\n"
            "    |      ^ expected more than 0 s\n"
            "scene.toml:6:9: error: \"count\" in [[emitter]] is out of bounds\n"
            "  6 | count = 0\n"
            "    |         ^ expected 1 to 1099511627776");
  EXPECT_EQ(mistakes_with("mass = 0\n"),
            "scene.toml:7:8: error: \"mass\" in [[emitter]] is out of bounds\n"
            "  7 | mass = 0\n"
            "    |        ^ expected 1e-30 to 1e+30 kg");
  EXPECT_EQ(mistakes_with("[frames]\nfraction = 0\n"),
            "scene.toml:8:12: error: \"fraction\" in [frames] is out of bounds\n"
            "  8 | fraction = 0\n"
            "    |            ^ expected more than 0 and at most 1");
  EXPECT_EQ(mistakes_with("stream = 16777215\n"),
            "scene.toml:7:10: error: \"stream\" in [[emitter]] is out of bounds\n"
            "  7 | stream = 16777215\n"
            "    |          ^^^^^^^^ expected 0 to 16777214");
  EXPECT_EQ(mistakes_with("source_radius = inf\n"),
            "scene.toml:7:17: error: \"source_radius\" in [[emitter]]: inf is not a finite number\n"
            "  7 | source_radius = inf\n"
            "    |                 ^^^ expected a length in m");
}

TEST(SceneMistakes, MissingKeysAndSections) {
  EXPECT_EQ(mistakes_of(""),
            "scene.toml: error: missing [time]\n"
            "  the steps: one of dt and steps_per_second, one of duration and steps\n"
            "scene.toml: error: missing [[emitter]]\n"
            "  a source of particles");
  EXPECT_EQ(mistakes_of("emitter = []\n[time]\ndt = 1\nduration = 1\n"),
            "scene.toml:1:11: error: there is no [[emitter]]\n"
            "  1 | emitter = []\n"
            "    |           ^^ expected at least one");
  EXPECT_EQ(mistakes_of("[time]\nduration = 1\n[[emitter]]\nkind = \"jet\"\n"),
            "scene.toml:1:1: error: missing key \"dt\" in [time]\n"
            "  1 | [time]\n"
            "    | ^^^^^^ give it, or \"steps_per_second\"\n"
            "scene.toml:3:1: error: missing key \"rate\" in [[emitter]]\n"
            "  3 | [[emitter]]\n"
            "    | ^^^^^^^^^^^ particles a second: number in 1/s");
  EXPECT_EQ(mistakes_of("[time]\ndt = 1\nduration = 1\n[[emitter]]\ncount = 1\n"),
            "scene.toml:4:1: error: missing key \"kind\" in [[emitter]]\n"
            "  4 | [[emitter]]\n"
            "    | ^^^^^^^^^^^ what it is: \"burst\", \"shell\", \"cone\", \"jet\", "
            "\"book_explosion\", \"energy_explosion\" or \"lattice\"");
  EXPECT_EQ(mistakes_with("[domain]\nlowest = [0, 0, 0]\n"),
            "scene.toml:7:1: error: missing key \"highest\" in [domain]\n"
            "  7 | [domain]\n"
            "    | ^^^^^^^^ a domain has two corners");
  EXPECT_EQ(mistakes_with("[[obstacle]]\nshape = \"height_field\"\nspacing = 1\n"),
            "scene.toml:7:1: error: missing key \"heights\" in [[obstacle]]\n"
            "  7 | [[obstacle]]\n"
            "    | ^^^^^^^^^^^^ give it, or \"hills\"");
}

TEST(SceneMistakes, MoreParticlesThanAWorldHolds) {
  const auto scene = [](const std::string& more) {
    return mistakes_of(
        "[[emitter]]\nkind = \"burst\"\ncount = 200_000_000\nradius = 1\nmass = 1\n"
        "[[emitter]]\nkind = \"burst\"\ncount = 4_200_000_000\nradius = 1\nmass = 1\n"
        "[time]\ndt = 1e-3\nduration = 1\n" +
        more);
  };
  EXPECT_EQ(scene(""),
            "scene.toml:6:1: error: 4200000000 particles are 105032705 too many\n"
            "  6 | [[emitter]]\n"
            "    | ^^^^^^^^^^^ expected at most 4294967295 in all");
  EXPECT_EQ(scene("[contact_law]\nkind = \"impulse\"\n"),
            "scene.toml:6:1: error: 4200000000 particles are 4131564544 too many\n"
            "  6 | [[emitter]]\n"
            "    | ^^^^^^^^^^^ expected at most 268435456 in all, as they touch each other");
}

TEST(SceneMistakes, KeysOfAnotherKind) {
  EXPECT_EQ(mistakes_with("rate = 5\n"),
            "scene.toml:7:1: error: \"rate\" does not belong in [[emitter]] with kind = \"burst\"\n"
            "  7 | rate = 5\n"
            "    | ^^^^ only with kind = \"jet\"");
  EXPECT_EQ(mistakes_with("[forces.wind]\nvelocity = [1, 0, 0]\nroughness = 0.1\n"),
            "scene.toml:9:1: error: \"roughness\" does not belong in [forces.wind] with profile = "
            "\"uniform\"\n"
            "  9 | roughness = 0.1\n"
            "    | ^^^^^^^^^ only with profile = \"log_law\"");
  EXPECT_EQ(mistakes_with("[contact]\nresponse = \"force\"\nmax_impacts = 3\n"),
            "scene.toml:9:1: error: \"max_impacts\" does not belong in [contact] with response = "
            "\"force\"\n"
            "  9 | max_impacts = 3\n"
            "    | ^^^^^^^^^^^ only with response = \"swept\"");
}

TEST(SceneMistakes, WrongUnits) {
  EXPECT_EQ(mistakes_with("speed = \"5 kg\"\n"),
            "scene.toml:7:9: error: \"speed\" in [[emitter]]: \"5 kg\" is a mass\n"
            "  7 | speed = \"5 kg\"\n"
            "    |         ^^^^^^ expected a speed in m/s");
  EXPECT_EQ(mistakes_with("speed = { uniform = [1, \"2 fsp\"] }\n"),
            "scene.toml:7:25: error: \"speed\" in [[emitter]]: unknown unit \"fsp\"\n"
            "  7 | speed = { uniform = [1, \"2 fsp\"] }\n"
            "    |                         ^^^^^^^ did you mean \"fps\"?");
}

TEST(SceneMistakes, UnknownWords) {
  EXPECT_EQ(mistakes_of("precision = \"duoble\"\n" + minimal),
            "scene.toml:1:13: error: \"precision\" in the scene is unknown: \"duoble\"\n"
            "  1 | precision = \"duoble\"\n"
            "    |             ^^^^^^^^ did you mean \"double\"?");
  EXPECT_EQ(mistakes_of("precision = \"half\"\n" + minimal),
            "scene.toml:1:13: error: \"precision\" in the scene is unknown: \"half\"\n"
            "  1 | precision = \"half\"\n"
            "    |             ^^^^^^ expected \"float\" or \"double\"");
  // What else an emitter must and may hold depends on its kind: nothing more is said.
  EXPECT_EQ(mistakes_of("[time]\ndt = 1\nduration = 1\n[[emitter]]\nkind = \"brust\"\nrate = 1\n"),
            "scene.toml:5:8: error: \"kind\" in [[emitter]] is unknown: \"brust\"\n"
            "  5 | kind = \"brust\"\n"
            "    |        ^^^^^^^ did you mean \"burst\"?");
  EXPECT_EQ(mistakes_with("[frames]\ncolumns = [\"position\", \"velocty\"]\n"),
            "scene.toml:8:24: error: \"columns\" in [frames] is unknown: \"velocty\"\n"
            "  8 | columns = [\"position\", \"velocty\"]\n"
            "    |                        ^^^^^^^^^ did you mean \"velocity\"?");
}

TEST(SceneMistakes, Spreads) {
  EXPECT_EQ(mistakes_with("speed = { uniform = [2, 1] }\n"),
            "scene.toml:7:21: error: \"speed\" in [[emitter]] has no width\n"
            "  7 | speed = { uniform = [2, 1] }\n"
            "    |                     ^^^^^^ expected [low, high], low below high");
  EXPECT_EQ(
      mistakes_with("speed = { normal = [2, 0] }\n"),
      "scene.toml:7:20: error: \"speed\" in [[emitter]] has no width\n"
      "  7 | speed = { normal = [2, 0] }\n"
      "    |                    ^^^^^^ expected [mean, deviation], a deviation of more than 0");
  EXPECT_EQ(mistakes_with("speed = { norml = [2, 1] }\n"),
            "scene.toml:7:11: error: unknown distribution \"norml\" of \"speed\" in [[emitter]]\n"
            "  7 | speed = { norml = [2, 1] }\n"
            "    |           ^^^^^ did you mean \"normal\"?");
  EXPECT_EQ(mistakes_with("speed = {}\n"),
            "scene.toml:7:9: error: \"speed\" in [[emitter]] has 0 keys\n"
            "  7 | speed = {}\n"
            "    |         ^^ expected a number, { uniform = [low, high] } or { normal = [mean, "
            "deviation] }");
}

TEST(SceneMistakes, Syntax) {
  EXPECT_EQ(mistakes_of("seed = 1\n[time\ndt = 1\n"),
            "scene.toml:2:6: error: not TOML: in table header: expected ']', saw '\\n'\n"
            "  2 | [time\n"
            "    |      ^");
  EXPECT_EQ(mistakes_of("seed = 1\nseed = 2\n"),
            "scene.toml:2:8: error: not TOML: in key-value pair: cannot redefine existing integer "
            "'seed'\n"
            "  2 | seed = 2\n"
            "    |        ^");
}

TEST(SceneMistakes, AllAtOnceInTheOrderOfTheFile) {
  EXPECT_EQ(mistakes_of("sede = 1\n[time]\ndt = \"5 m\"\nduration = 1\n\n[[emitter]]\n\tkind = "
                        "\"burst\"\n\tcuont = 3\n"),
            "scene.toml:1:1: error: unknown key \"sede\" in the scene\n"
            "  1 | sede = 1\n"
            "    | ^^^^ did you mean \"seed\"?\n"
            "scene.toml:3:6: error: \"dt\" in [time]: \"5 m\" is a length\n"
            "  3 | dt = \"5 m\"\n"
            "    |      ^^^^^ expected a time in s\n"
            "scene.toml:6:1: error: missing key \"count\" in [[emitter]]\n"
            "  6 | [[emitter]]\n"
            "    | ^^^^^^^^^^^ particles: whole number\n"
            "scene.toml:8:2: error: unknown key \"cuont\" in [[emitter]]\n"
            "  8 |  cuont = 3\n"
            "    |  ^^^^^ did you mean \"count\"?");
}

TEST(SceneMistakes, CountColumnsInCharacters) {
  EXPECT_EQ(mistakes_with("name = \"Glühwürmchen\" # ä\nspeed = { uniform = [1.5, \"µ\"] }\n"),
            "scene.toml:8:27: error: \"speed\" in [[emitter]]: \"µ\" does not start with a number\n"
            "  8 | speed = { uniform = [1.5, \"µ\"] }\n"
            "    |                           ^^^ expected a speed in m/s");
  EXPECT_EQ(parse(minimal + "\"name\" = \"ä\"\nvelocity = [ 1.5, 2.25,\n  0.1 ]\n", "scene.toml")
                .setup.emitters[0]
                .velocity,
            (models::Triple{1.5, 2.25, 0.1}));
}

TEST(SceneMistakes, Times) {
  EXPECT_EQ(
      mistakes_of("[time]\ndt = 0.3\nduration = 1\n[[emitter]]\nkind = \"burst\"\ncount = 1\n"),
      "scene.toml:3:12: error: \"duration\" in [time] is 3.33333333 steps\n"
      "  3 | duration = 1\n"
      "    |            ^ expected a whole number of steps, such as 0.9 s");
  EXPECT_EQ(mistakes_of("[time]\ndt = 1e-6\nduration = 2148\n[[emitter]]\nkind = \"burst\"\n"
                        "count = 1\n"),
            "scene.toml:3:12: error: \"duration\" in [time] is 2148000000 steps\n"
            "  3 | duration = 2148\n"
            "    |            ^^^^ expected at most 2147483646");
  EXPECT_EQ(mistakes_of("[time]\ndt = 1\nsteps_per_second = 1\nsteps = 1\n[[emitter]]\nkind = "
                        "\"burst\"\ncount = 1\n"),
            "scene.toml:3:20: error: \"dt\" and \"steps_per_second\" say the same\n"
            "  3 | steps_per_second = 1\n"
            "    |                    ^ keep one of them");
  EXPECT_EQ(mistakes_with("time = 1.5\n"),
            "scene.toml:7:8: error: \"time\" in [[emitter]] is after the end\n"
            "  7 | time = 1.5\n"
            "    |        ^^^ the run ends at 1 s");
  EXPECT_EQ(mistakes_with("time = -1\n"),
            "scene.toml:7:8: error: \"time\" in [[emitter]] is before the start\n"
            "  7 | time = -1\n"
            "    |        ^^ the run starts at 0 s");
  EXPECT_EQ(mistakes_with("[[forces.blast]]\nposition = [0, 0, 0]\nimpulse = 1\ntime = 2\n"),
            "scene.toml:10:8: error: \"time\" in [[forces.blast]] is after the end\n"
            " 10 | time = 2\n"
            "    |        ^ the run ends at 1 s");
}

TEST(SceneMistakes, Frames) {
  EXPECT_EQ(mistakes_with("[frames]\nevery = 7\n"),
            "scene.toml:8:9: error: a frame every 7 steps does not divide the run of 100 steps\n"
            "  8 | every = 7\n"
            "    |         ^ such as 5 steps");
  EXPECT_EQ(mistakes_with("[frames]\ncount = 48\n"),
            "scene.toml:8:9: error: 48 frames do not divide the run of 100 steps\n"
            "  8 | count = 48\n"
            "    |         ^^ such as 50");
  EXPECT_EQ(mistakes_with("[frames]\nper_second = 30\n"),
            "scene.toml:8:14: error: a frame every 3.33333333 steps is no whole number of steps\n"
            "  8 | per_second = 30\n"
            "    |              ^^ expected a divisor of 100 steps a second");
  EXPECT_EQ(mistakes_with("[frames]\nevery = 5\ncount = 20\n"),
            "scene.toml:9:9: error: \"every\" and \"count\" say the same\n"
            "  9 | count = 20\n"
            "    |         ^^ keep one of them");
  EXPECT_EQ(mistakes_with("[frames]\ncolumns = [\"id\", \"mass\", \"id\"]\n"),
            "scene.toml:8:26: error: \"id\" is in \"columns\" twice\n"
            "  8 | columns = [\"id\", \"mass\", \"id\"]\n"
            "    |                          ^^^^ keep one of them");
  EXPECT_EQ(mistakes_with("[frames]\ncolumns = []\n"),
            "scene.toml:8:11: error: \"columns\" in [frames] is empty\n"
            "  8 | columns = []\n"
            "    |           ^^ expected at least one field");
}

TEST(SceneMistakes, TheNearestDivisorOfAnyNumberIsFoundAtOnce) {
  EXPECT_NE(mistakes_with("[frames]\ncount = 2147483646\n").find("such as 100"), std::string::npos);
  EXPECT_NE(mistakes_of(minimal, {"time.steps=2147483629", "frames.every=1000000000"})
                .find("such as 1 steps"),
            std::string::npos);
}

TEST(SceneMistakes, Streams) {
  EXPECT_EQ(mistakes_with("stream = 1\n[[emitter]]\nkind = \"burst\"\ncount = 1\n"),
            "scene.toml:8:1: error: stream 1 is that of emitter 0 too\n"
            "  8 | [[emitter]]\n"
            "    | ^^^^^^^^^^^ without a stream an emitter takes its place in the list");
  EXPECT_EQ(mistakes_with("[[emitter]]\nkind = \"burst\"\ncount = 1\nstream = 0\n"),
            "scene.toml:10:10: error: stream 0 is that of emitter 0 too\n"
            " 10 | stream = 0\n"
            "    |          ^ a stream belongs to one emitter");
}

TEST(SceneMistakes, Emitters) {
  EXPECT_EQ(mistakes_with("[domain]\nlowest = [-1, -1, 1]\nhighest = [1, 1, 2]\n"),
            "scene.toml:4:1: error: \"position\" in [[emitter]] is outside the domain in z\n"
            "  4 | [[emitter]]\n"
            "    | ^^^^^^^^^^^ expected 1 to 2 m");
  EXPECT_EQ(mistakes_with("drag_area = 1\ndrag_coefficient = 1\nradius = 1\n[forces]\n"
                          "quadratic_drag = true\n"),
            "scene.toml:8:20: error: \"drag_area\" and \"drag_coefficient\" say the same\n"
            "  8 | drag_coefficient = 1\n"
            "    |                    ^ keep one of them");
  EXPECT_EQ(mistakes_with("drag_coefficient = 1\n[forces]\nquadratic_drag = true\n"),
            "scene.toml:7:20: error: \"drag_coefficient\" in [[emitter]] needs a radius\n"
            "  7 | drag_coefficient = 1\n"
            "    |                    ^ give radius, or drag_area instead");
  EXPECT_EQ(mistakes_with("[[emitter]]\nkind = \"book_explosion\"\ncount = 1\nstrength = 7.5\n"),
            "scene.toml:10:12: error: \"strength\" in [[emitter]] is not whole\n"
            " 10 | strength = 7.5\n"
            "    |            ^^^ expected whole metres a second: the book draws whole speeds");
  EXPECT_EQ(mistakes_with("[[emitter]]\nkind = \"jet\"\nrate = 0.5\n"),
            "scene.toml:9:8: error: the jet emits 0.5 particles\n"
            "  9 | rate = 0.5\n"
            "    |        ^^^ expected at least 1 within its duration");
  EXPECT_EQ(mistakes_with("[[emitter]]\nkind = \"jet\"\nrate = 1e13\n"),
            "scene.toml:9:8: error: the jet emits 1e+13 particles\n"
            "  9 | rate = 1e13\n"
            "    |        ^^^^ expected at most 2^40 within its duration");
  EXPECT_EQ(mistakes_with("[[emitter]]\nkind = \"cone\"\ncount = 1\ndirection = [0, 0, 0]\n"),
            "scene.toml:10:13: error: \"direction\" is zero\n"
            " 10 | direction = [0, 0, 0]\n"
            "    |             ^^^^^^^^^ a direction has some length");
}

TEST(SceneMistakes, Forces) {
  EXPECT_EQ(
      mistakes_with("[forces.wind]\nprofile = \"log_law\"\nvelocity = [1, 0, 0]\nroughness = 10\n"
                    "[forces]\nlinear_drag = 1\n"),
      "scene.toml:10:13: error: \"roughness\" in [forces.wind] is not below the reference "
      "height\n"
      " 10 | roughness = 10\n"
      "    |             ^^ expected less than 10 m");
  EXPECT_EQ(mistakes_with("[forces]\ndrag_law = \"book_still_air\"\nlinear_drag = 1\n"
                          "[forces.gust]\nstandard_deviation = [1, 1, 1]\n"),
            "scene.toml:8:12: error: \"drag_law\" in [forces] is given, but there is no quadratic "
            "drag\n"
            "  8 | drag_law = \"book_still_air\"\n"
            "    |            ^^^^^^^^^^^^^^^^ set quadratic_drag = true\n"
            "scene.toml:9:15: error: \"linear_drag\" in [forces] does not go with drag_law = "
            "\"book_still_air\"\n"
            "  9 | linear_drag = 1\n"
            "    |               ^ remove one\n"
            "scene.toml:10:1: error: [forces.gust] does not go with drag_law = \"book_still_air\"\n"
            " 10 | [forces.gust]\n"
            "    | ^^^^^^^^^^^^^ remove one");
}

TEST(SceneMistakes, WhatWouldDoNothing) {
  EXPECT_EQ(mistakes_with("drag_area = 1\n[forces]\nbuoyancy = true\n[forces.wind]\nvelocity = "
                          "[1, 0, 0]\n[forces.gust]\nstandard_deviation = [1, 1, 1]\n[contact]\n"
                          "max_impacts = 3\n"),
            "scene.toml:7:13: error: \"drag_area\" in [[emitter]] is given, but there is no "
            "quadratic drag\n"
            "  7 | drag_area = 1\n"
            "    |             ^ set quadratic_drag = true in [forces]\n"
            "scene.toml:9:12: error: \"buoyancy\" in [forces] lifts no particle: all have radius "
            "0\n"
            "  9 | buoyancy = true\n"
            "    |            ^^^^ give an emitter a radius\n"
            "scene.toml:10:1: error: [forces.wind] acts through drag, and there is none\n"
            " 10 | [forces.wind]\n"
            "    | ^^^^^^^^^^^^^ set quadratic_drag = true, or a linear_drag\n"
            "scene.toml:12:1: error: [forces.gust] acts through drag, and there is none\n"
            " 12 | [forces.gust]\n"
            "    | ^^^^^^^^^^^^^ set quadratic_drag = true, or a linear_drag\n"
            "scene.toml:14:1: error: [contact] is given, but there is no [[obstacle]]\n"
            " 14 | [contact]\n"
            "    | ^^^^^^^^^ add one, or remove [contact]");
  // Linear drag carries wind; a recorded drag area is of use.
  EXPECT_EQ(mistakes_with("drag_area = 1\nradius = 1\n[forces]\nlinear_drag = 1\nbuoyancy = true\n"
                          "[forces.wind]\nvelocity = [1, 0, 0]\n[frames]\ncolumns = "
                          "[\"drag_area\"]\n"),
            "no mistake");
}

TEST(SceneMistakes, GustsThatWouldSilentlyTakeTheWinds) {
  EXPECT_EQ(mistakes_with("[forces.gust]\nstandard_deviation = [1, 1, 1]\nspeed = 0\n"
                          "direction = [0, 0, 0]\n"),
            "scene.toml:9:9: error: \"speed\" in [forces.gust] is out of bounds\n"
            "  9 | speed = 0\n"
            "    |         ^ expected more than 0 m/s\n"
            "scene.toml:10:13: error: \"direction\" is zero\n"
            " 10 | direction = [0, 0, 0]\n"
            "    |             ^^^^^^^^^ a direction has some length");
}

TEST(SceneMistakes, Domain) {
  EXPECT_EQ(mistakes_with("[domain]\nlowest = [-1, 2, -1]\nhighest = [1, 2, 1]\n"),
            "scene.toml:9:11: error: \"highest\" in [domain] is not above \"lowest\" in y\n"
            "  9 | highest = [1, 2, 1]\n"
            "    |           ^^^^^^^^^ expected more than 2 m");
}

TEST(SceneMistakes, HeightFields) {
  const std::string field = "[[obstacle]]\nshape = \"height_field\"\nspacing = 1\n";
  EXPECT_EQ(mistakes_with(field + "heights = [[1, 2]]\n"),
            "scene.toml:10:11: error: \"heights\" in [[obstacle]] are too few\n"
            " 10 | heights = [[1, 2]]\n"
            "    |           ^^^^^^^^ expected at least two rows of at least two samples");
  EXPECT_EQ(mistakes_with(field + "heights = [[1, 2], [3]]\n"),
            "scene.toml:10:20: error: row 1 of \"heights\" in [[obstacle]] has 1 samples\n"
            " 10 | heights = [[1, 2], [3]]\n"
            "    |                    ^^^ expected 2, as in row 0");
  EXPECT_EQ(
      mistakes_with(field + "hills = { columns = 5000, rows = 5000, deviation = 1, length = 9 }\n"),
      "scene.toml:10:34: error: the height field has too many samples\n"
      " 10 | hills = { columns = 5000, rows = 5000, deviation = 1, length = 9 }\n"
      "    |                                  ^^^^ expected at most 16777216");
}

// The minimal scene with particles that touch.
std::string touching(const std::string& law,
                     const std::string& emitter = "mass = 1\nradius = 0.1\n",
                     const std::string& more = {}) {
  return "precision = \"float\"\n[time]\ndt = 1e-4\nsteps = 10\n[[emitter]]\nkind = \"burst\"\n"
         "count = 1\n" +
         emitter + "[contact_law]\n" + law + more;
}

TEST(SceneMistakes, ContactLaws) {
  const std::string spring = "kind = \"linear_spring\"\nnormal_stiffness = 1e3\n";
  const auto says = [](const std::string& text, const std::string& what) {
    EXPECT_NE(mistakes_of(text).find(what), std::string::npos) << text << mistakes_of(text);
  };
  EXPECT_EQ(mistakes_of(touching(spring)), "no mistake");
  says(touching(spring, "mass = 1\n"), "particles that touch need a radius");
  says(touching(spring, "mass = 1\nradius = 0\n"), "particles that touch need a radius");
  says(touching(spring, "mass = 1\nradius = -1\n"), "radius");
  says(touching(spring, "mass = 0\nradius = 0.1\n"), "mass");
  says(touching("kind = \"linear_spring\"\nnormal_stiffness = 1e12\n"), "cannot follow the impact");
  says(touching(spring + "rolling_friction = 0.1\n"), "there is no friction");
  says(touching(spring, "mass = 1\nradius = 0.1\n",
                "[[obstacle]]\nshape = \"plane\"\nfriction = 0.5\n"),
       "give a friction in [contact_law]");
  says(touching(spring, "mass = 1\nradius = 0.1\n", "[contact]\n[[obstacle]]\nshape = \"plane\"\n"),
       "remove one of the two");
  says("integrator = \"explicit_euler\"\n" + touching(spring), "semi_implicit_euler alone");
  says(
      "precision = \"float\"\n[time]\nsteps = 10\n[[emitter]]\nkind = \"burst\"\ncount = 1\n"
      "mass = 1\nradius = 0.1\n[contact_law]\nkind = \"impulse\"\n",
      "dt");
  says(touching(spring, "mass = 1\nradius = 0.1\n",
                "[[obstacle]]\nshape = \"mesh\"\nfile = \"nowhere.obj\"\n"),
       "nowhere.obj");
  EXPECT_EQ(mistakes_of(touching(spring, "mass = 1\nradius = 0.1\n",
                                 "[[obstacle]]\nshape = \"mesh\"\nfile = \"\"\n")),
            "scene.toml:15:8: error: \"file\" in [[obstacle]] is empty\n"
            " 15 | file = \"\"\n"
            "    |        ^^ expected an .obj or .ply file");
  says(touching(spring + "restitution = 0\n"), "expected at least 0.01");
  says(touching(spring, "mass = 1\nradius = 0.1\n",
                "[[obstacle]]\nshape = \"plane\"\nrestitution = 0.001\n"),
       "obstacle");
  EXPECT_EQ(mistakes_of(touching("kind = \"impulse\"\nrestitution = 0\n")), "no mistake");
  says(touching(spring, "mass = { normal = [1, 0.3] }\nradius = 0.1\n"), "no step follows that");
  says(touching("kind = \"linear_spring\"\nnormal_stiffness = 1e6\nfriction = 0.5\n"
                "tangential_ratio = 1000\n"),
       "cannot follow the slip spring (tangential_ratio)");
}

// What would change nothing.
TEST(SceneMistakes, WhatNeedsContactsOfAnotherKind) {
  const std::string smooth = "kind = \"linear_spring\"\nnormal_stiffness = 1e3\n";
  const std::string rough = smooth + "friction = 0.5\n";
  const std::string sphere = "mass = 1\nradius = 0.1\n";
  const std::string column = "[frames]\ncolumns = ";
  struct Case {
    std::string law;  // with which it is a mistake
    std::string law_with_more;
    std::string emitter;
    std::string more;
    std::string says;
  };
  for (const Case& c : std::vector<Case>{
           {smooth + "tangential_damping = 0.5\n", rough + "tangential_damping = 0.5\n", "", "",
            "\"tangential_damping\" in [contact_law] is given, but there is no friction"},
           {smooth, rough, "angular_velocity = [0, 1, 0]\n", "",
            "\"angular_velocity\" in [[emitter]] is given, but there is no friction"},
           {smooth, rough, "", column + "[\"angular_velocity\"]\n",
            "\"angular_velocity\" is of particles that turn"},
           {smooth + "energy_budget = false\n", smooth, "", column + "[\"damping_loss\"]\n",
            "\"damping_loss\" is of the energy budget"}}) {
    const std::string said = mistakes_of(touching(c.law, sphere + c.emitter, c.more));
    EXPECT_NE(said.find(c.says), std::string::npos) << said;
    EXPECT_EQ(mistakes_of(touching(c.law_with_more, sphere + c.emitter, c.more)), "no mistake");
  }
  EXPECT_NE(mistakes_of(touching(smooth, sphere, "[[obstacle]]\nshape = \"plane\"\nmass = 3\n"))
                .find("\"mass\" in [[obstacle]] is for the impulse of [contact]"),
            std::string::npos);
}

TEST(SceneMistakes, StartsThatFlyThroughOthers) {
  const auto said = [](const std::string& start) {
    return mistakes_of(touching("kind = \"impulse\"\n", "radius = 0.1\n" + start));
  };
  // Steps take 0.1 ms: a radius in a step is 1 km/s.
  EXPECT_EQ(said("velocity = [0, 0, -999]\n"), "no mistake");
  EXPECT_EQ(said("velocity = [0, 0, -2000]\n"),
            "scene.toml:9:12: error: particles of [[emitter]] start with up to 2e+03 m/s: 0.2 m in "
            "a step, farther than the smallest radius, 0.1 m\n"
            "  9 | velocity = [0, 0, -2000]\n"
            "    |            ^^^^^^^^^^^^^ expected at most 1e+03 m/s, or steps of 5e-05 s");
  EXPECT_NE(said("velocity = [0, 0, 600]\nspeed = { uniform = [0, 500] }\n").find("1.1e+03 m/s"),
            std::string::npos);
}

TEST(SceneMistakes, SizesOfParticlesThatTouch) {
  const std::string law = "kind = \"impulse\"\nfriction = 0.5\n";
  const auto said = [&](const std::string& emitter) { return mistakes_of(touching(law, emitter)); };
  const auto mistakes_in = [](const std::string& text) {
    std::size_t count = 0;
    for (std::size_t at = 0; (at = text.find("error: ", at)) != std::string::npos; ++at) ++count;
    return count;
  };
  EXPECT_EQ(said("mass = 1\nradius = 1e-46\n"),
            "scene.toml:9:10: error: \"radius\" in [[emitter]] comes to 1e-46 m: the square is out "
            "of range\n"
            "  9 | radius = 1e-46\n"
            "    |          ^^^^^ expected 1.1e-19 to 9.2e+18 m, or precision = \"double\"");
  for (const std::string emitter :
       {"mass = 1e-20\nradius = 1\n", "mass = 1e19\nradius = 1\n", "mass = 1e-15\nradius = 1e-15\n",
        "mass = 1\nradius = { uniform = [1e-30, 1] }\n"}) {
    EXPECT_NE(said(emitter).find("out of range"), std::string::npos) << emitter << said(emitter);
    EXPECT_EQ(mistakes_in(said(emitter)), 1u) << said(emitter);
    EXPECT_EQ(mistakes_of("precision = \"double\"" + touching(law, emitter).substr(19)),
              "no mistake");
  }
  for (const std::string emitter : {"radius = { uniform = [0, 1] }\n", "radius = 0\n"}) {
    EXPECT_NE(said(emitter).find("expected more than 0 m"), std::string::npos) << said(emitter);
    EXPECT_EQ(mistakes_in(said(emitter)), 1u) << said(emitter);
  }
  // What is out of bounds is not missing as well.
  for (const std::string radius : {"-1", "nan", "{ uniform = [-1, 1] }"}) {
    EXPECT_EQ(mistakes_in(said("radius = " + radius + "\n")), 1u) << said("radius = " + radius);
  }
  const std::string slippery =
      mistakes_of(touching("kind = \"impulse\"\nfriction = -0.1\n", "radius = 1\n",
                           "[[obstacle]]\nshape = \"plane\"\nfriction = 0.5\n"));
  EXPECT_EQ(mistakes_in(slippery), 1u) << slippery;
  EXPECT_NE(slippery.find("\"friction\" in [contact_law] is out of bounds"), std::string::npos);
}

TEST(SceneMistakes, StartsThatCannotBeSquared) {
  EXPECT_EQ(mistakes_with("position = [0, 1e30, 0]\n"),
            "scene.toml:7:12: error: \"position\" in [[emitter]] is 1e+30 m: the square is out of "
            "range\n"
            "  7 | position = [0, 1e30, 0]\n"
            "    |            ^^^^^^^^^^^^ expected at most 9.2e+18 m, or precision = \"double\"");
  for (const std::string key : {"velocity = [-1e20, 0, 0]", "speed = { uniform = [0, 1e20] }",
                                "source_radius = 1e20", "angular_velocity = [0, 0, 1e20]"}) {
    const std::string said = mistakes_with(key + "\n");
    EXPECT_NE(said.find("the square is out of range"), std::string::npos) << key << said;
    EXPECT_EQ(mistakes_of("precision = \"double\"\n" + minimal + key + "\n"), "no mistake");
  }
}

TEST(SceneMistakes, NumbersThatSinglePrecisionDoesNotHold) {
  EXPECT_EQ(mistakes_with("drag_area = 1e39\n"),
            "scene.toml:7:13: error: \"drag_area\" in [[emitter]] is out of bounds\n"
            "  7 | drag_area = 1e39\n"
            "    |             ^^^^ expected at most 3.4e+38: no key takes a larger number");
  for (const std::string settings :
       {"[forces]\nair_density = 1e39\n", "[forces]\ngravity = [0, -1e39, 0]\n",
        "[[obstacle]]\nshape = \"plane\"\nfriction = 1e39\n"}) {
    const std::string said = mistakes_of(minimal + settings);
    EXPECT_NE(said.find("no key takes a larger number"), std::string::npos) << settings << said;
  }
  for (const std::string key : {"rolling_friction", "surface_energy"}) {
    const std::string said = mistakes_of(touching(
        "kind = \"linear_spring\"\nnormal_stiffness = 1e4\nfriction = 0.5\n" + key + " = 1e39\n"));
    EXPECT_NE(said.find("\"" + key + "\" in [contact_law] is out of bounds"), std::string::npos)
        << said;
  }
}

TEST(SceneMistakes, MeshesThatAreTooLargeOrTooSmall) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / "salvo_meshes_out_of_range";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "a.obj") << "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n";
  const auto said = [&](const std::string& scale) {
    return mistakes_of(touching("kind = \"impulse\"\n", "radius = 0.1\n",
                                "[[obstacle]]\nshape = \"mesh\"\nfile = \"" +
                                    (folder / "a.obj").string() + "\"\nscale = " + scale + "\n"));
  };
  EXPECT_EQ(said("1e-15"), "no mistake");
  EXPECT_EQ(said("1e15"), "no mistake");
  EXPECT_EQ(said("1e-320"),
            "scene.toml:14:9: error: the mesh reaches 1e-320 m from its origin\n"
            " 14 | scale = 1e-320\n"
            "    |         ^^^^^^ expected 1e-15 to 1e+15 m: choose another \"scale\"");
  EXPECT_NE(said("1e30").find("reaches 1e+30 m"), std::string::npos) << said("1e30");
}

TEST(SceneMistakes, MotionOfObstacles) {
  const auto said = [](const std::string& motion,
                       const std::string& shape = "\"box\"\nhalf_size = [1, 2, 2]") {
    return mistakes_of(
        touching("kind = \"impulse\"\n", "radius = 0.1\n",
                 "[[obstacle]]\nshape = " + shape + "\n[obstacle.motion]\n" + motion));
  };
  const auto says = [&](const std::string& text, const std::string& what) {
    EXPECT_NE(text.find(what), std::string::npos) << text;
  };
  EXPECT_EQ(said("amplitude = [1, 0, 0]\n"),
            "scene.toml:15:13: error: \"amplitude\" in [obstacle.motion] is given, but there is no "
            "frequency\n"
            " 15 | amplitude = [1, 0, 0]\n"
            "    |             ^^^^^^^^^ give the frequency, or remove it");
  says(said("frequency = 5\n"), "is given, but there is no amplitude");
  // Steps take 0.1 ms: a radius in a step is 1 km/s.
  const std::string far = "farther than the smallest radius, 0.1 m";
  EXPECT_EQ(said("velocity = [999, 0, 0]\n"), "no mistake");
  says(said("velocity = [0, 1001, 0]\n"), far);
  says(said("velocity = [0, 1001, 0]\n"), "expected at most 1e+03 m/s, or steps of 9.99e-05 s");
  EXPECT_EQ(said("amplitude = [3, 0, 0]\nfrequency = 50\n"), "no mistake");
  says(said("amplitude = [3, 0, 0]\nfrequency = 60\n"), far);
  EXPECT_EQ(said("angular_velocity = [0, 330, 0]\n"), "no mistake");
  says(said("angular_velocity = [0, 340, 0]\n"), far);
  EXPECT_EQ(said("amplitude = [1e-3, 0, 0]\nfrequency = 1250\n"), "no mistake");
  says(said("amplitude = [1e-3, 0, 0]\nfrequency = 1260\n"), "takes 7.94 steps");
  // A plane has no end, but turns by an angle.
  EXPECT_EQ(said("angular_velocity = [7000, 0, 0]\n", "\"plane\""), "no mistake");
  says(said("angular_velocity = [8000, 0, 0]\n", "\"plane\""), "takes 7.85 steps");
  says(said("velocity = [0, 1001, 0]\nangular_velocity = [7, 0, 0]\n", "\"plane\""), far);
  EXPECT_EQ(said("angular_velocity = [0, 1e5, 0]\n", "\"plane\""), "no mistake");
  says(said("angular_velocity = [0, 1, 0]\n",
            "\"height_field\"\nspacing = 1\nheights = [[0, 0], [0, 0]]"),
       "a height field does not turn");
}

TEST(SceneMistakes, WhatNeedsAContactLaw) {
  for (const std::string key : {"hollow = true", "motion.velocity = [1, 0, 0]"}) {
    const std::string said =
        mistakes_with("[[obstacle]]\nshape = \"box\"\nhalf_size = [1, 1, 1]\n" + key + "\n");
    EXPECT_NE(said.find("give a [contact_law]"), std::string::npos) << said;
  }
}

TEST(SceneOverrides, ReplaceAndAddKeys) {
  const Scene scene = parse(minimal, "scene.toml",
                            {"emitter.0.count=20", "time.dt=5 ms", "precision=double",
                             "title=\"a = b\"", "forces.wind.velocity=[1, 2, \"3 kn\"]",
                             "forces.linear_drag=1", "seed=0x10", "verify.rows=1e3"});
  EXPECT_EQ(scene.setup.emitters[0].count, 20u);
  EXPECT_EQ(scene.setup.dt, 0.005);
  EXPECT_EQ(scene.setup.precision, soa::Precision::float64);
  EXPECT_EQ(scene.title, "a = b");
  EXPECT_TRUE(scene.setup.forces.windy);
  EXPECT_EQ(scene.setup.forces.wind.velocity[1], 2.0);
  EXPECT_EQ(scene.setup.seed, 16u);
  EXPECT_EQ(scene.verify.rows, 1000u);
  EXPECT_EQ(scene.overrides.size(), 8u);
  EXPECT_EQ(scene.text, minimal);
}

TEST(SceneOverrides, TheLastOneWins) {
  EXPECT_EQ(parse(minimal, "scene.toml", {"seed=1", "seed=2"}).setup.seed, 2u);
}

TEST(SceneOverrides, TakeThePlaceOfKeysThatSayTheSame) {
  const std::string text = minimal + R"(drag_area = 1
radius = 0.5
[forces]
quadratic_drag = true
[[obstacle]]
shape = "height_field"
spacing = 1
heights = [[0, 1], [2, 3]]
[frames]
count = 10
)";
  const Scene scene = parse(
      text, "scene.toml",
      {"time.steps_per_second=50", "time.steps=100", "frames.every=50",
       "emitter.0.drag_coefficient=0.5", "obstacle.0.hills.columns=3", "obstacle.0.hills.rows=4",
       "obstacle.0.hills.deviation=1", "obstacle.0.hills.length=2"});
  EXPECT_EQ(scene.setup.dt, 0.02);
  EXPECT_EQ(scene.steps, 100);
  EXPECT_EQ(scene.frames.every, 50);
  EXPECT_EQ(scene.setup.emitters[0].drag_coefficient, 0.5);
  EXPECT_EQ(scene.setup.obstacles[0].samples->heights.size(), 12u);
  EXPECT_EQ(parse(text, "scene.toml", {"frames.per_second=50"}).frames.every, 2);
}

TEST(SceneOverrides, ThatClashAreAMistakeOfTheLaterOne) {
  EXPECT_EQ(mistakes_of(minimal, {"time.steps=100", "time.duration=2"}),
            "--set time.duration=2: error: \"steps\" and \"duration\" say the same\n"
            "    | time.duration=2\n"
            "    |               ^ keep one of them");
}

TEST(SceneOverrides, GiveStringsThatLookLikeSomethingElse) {
  const Scene scene = parse(minimal, "scene.toml", {"emitter.0.name=5", "title=1979-05-27"});
  EXPECT_EQ(scene.setup.emitters[0].name, "5");
  EXPECT_EQ(scene.title, "1979-05-27");
  EXPECT_EQ(parse(minimal, "scene.toml", {"title=\"5\""}).title, "5");
}

TEST(SceneOverrides, MistakesNameTheArgument) {
  EXPECT_EQ(mistakes_of(minimal, {"emitter.0.cuont=20"}),
            "--set emitter.0.cuont=20: error: unknown key \"cuont\" in [[emitter]]\n"
            "    | emitter.0.cuont=20\n"
            "    |           ^^^^^ did you mean \"count\"?");
  EXPECT_EQ(mistakes_of(minimal, {"seed=1", "time.dt=5 kg"}),
            "--set time.dt=5 kg: error: \"dt\" in [time]: \"5 kg\" is a mass\n"
            "    | time.dt=5 kg\n"
            "    |         ^^^^ expected a time in s");
  EXPECT_EQ(
      mistakes_of(minimal, {"emitter.0.position=[1, 2, \"x\"]"}),
      "--set emitter.0.position=[1, 2, \"x\"]: error: \"position\" in [[emitter]]: \"x\" does "
      "not start with a number\n"
      "    | emitter.0.position=[1, 2, \"x\"]\n"
      "    |                           ^^^ expected a length in m");
  EXPECT_EQ(mistakes_of(minimal, {"emitter.3.count=1"}),
            "--set emitter.3.count=1: error: \"emitter\" has no entry 3\n"
            "    | emitter.3.count=1\n"
            "    |         ^ it has 0 to 0");
  EXPECT_EQ(mistakes_of(minimal, {"time.dt.x=1"}),
            "--set time.dt.x=1: error: \"time.dt\" is a number: it has no keys\n"
            "    | time.dt.x=1\n"
            "    |         ^");
  EXPECT_EQ(mistakes_of(minimal, {"count"}),
            "--set count: error: an override is a key, = and a value\n"
            "    | count\n"
            "    | ^^^^^ such as time.duration=2 or emitter.0.count=10");
  EXPECT_EQ(mistakes_of(minimal, {"time..dt=1"}),
            "--set time..dt=1: error: a key is missing\n"
            "    | time..dt=1\n"
            "    |      ^ keys are joined by single dots");
}

TEST(SceneFile, IsRead) {
  const std::filesystem::path path =
      std::filesystem::path(testing::TempDir()) / "salvo_load_test.toml";
  {
    std::FILE* file = std::fopen(path.c_str(), "w");
    ASSERT_NE(file, nullptr);
    std::fputs(minimal.c_str(), file);
    std::fclose(file);
  }
  EXPECT_EQ(load(path).text, minimal);
  EXPECT_EQ(load(path, {"seed=3"}).setup.seed, 3u);
  std::filesystem::remove(path);
}

TEST(SceneFile, MayBeginWithAByteOrderMark) {
  const std::string mark = "\xEF\xBB\xBF";
  const Scene scene =
      parse(mark + "time = { dt = 0.25, steps = 4 }\n" + minimal.substr(minimal.find("[[")),
            "scene.toml");
  EXPECT_EQ(scene.setup.dt, 0.25);
  EXPECT_EQ(scene.text.substr(0, 3), mark);
  EXPECT_EQ(mistakes_of(mark + "sede = 1\n" + minimal),
            "scene.toml:1:1: error: unknown key \"sede\" in the scene\n"
            "  1 | sede = 1\n"
            "    | ^^^^ did you mean \"seed\"?");
}

TEST(SceneFile, ThatCannotBeReadIsNamed) {
  try {
    load("no/such/scene.toml");
    FAIL();
  } catch (const std::system_error& error) {
    EXPECT_EQ(error.code().value(), ENOENT);
    EXPECT_TRUE(std::string(error.what()).starts_with("cannot read no/such/scene.toml"));
  }
  EXPECT_THROW(load(testing::TempDir()), std::system_error);
}

TEST(SceneError, HoldsEveryMistake) {
  try {
    parse("a = 1\nb = 2\n", "scene.toml");
    FAIL();
  } catch (const SceneError& error) {
    EXPECT_EQ(error.mistakes().size(), 4u);
  }
}

}  // namespace
}  // namespace salvo::scene
