// What is made of a scene: its digest, its size for verify; the key reference and the shipped
// scenes.
#include "scene/scene.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "scene/load_sweep.hpp"

namespace salvo::scene {
namespace {

const std::filesystem::path repository =
    std::filesystem::path(__FILE__).parent_path().parent_path().parent_path();

const std::string two_emitters = R"([time]
dt = 0.01
duration = 1
[[emitter]]
kind = "burst"
count = 100
[[emitter]]
kind = "jet"
rate = 100
[[emitter]]
kind = "energy_explosion"
count = 300
energy = 600
[frames]
every = 10
[verify]
rows = 50
)";

TEST(SceneDigest, DependsOnTextAndOverridesAlone) {
  const Scene scene = parse(two_emitters, "a.toml");
  EXPECT_EQ(scene_digest(scene), scene_digest(parse(two_emitters, "b.toml")));
  EXPECT_NE(scene_digest(scene), scene_digest(parse(two_emitters + "\n", "a.toml")));
  const Scene one = parse(two_emitters, "a.toml", {"seed=1"});
  EXPECT_NE(scene_digest(scene), scene_digest(one));
  EXPECT_NE(scene_digest(one), scene_digest(parse(two_emitters, "a.toml", {"seed=1", "seed=1"})));
}

TEST(ScaledForVerify, KeepsProportions) {
  const Scene scene = parse(two_emitters, "a.toml");
  const Scene scaled = scaled_for_verify(scene);
  EXPECT_EQ(scaled.setup.emitters[0].count, 10u);
  EXPECT_EQ(scaled.setup.emitters[1].rate, 10.0);
  EXPECT_EQ(scaled.setup.emitters[2].count, 30u);
  EXPECT_EQ(scaled.setup.emitters[2].energy, 60.0);  // as much a particle as before
  EXPECT_EQ(scaled.steps, 100);
  EXPECT_EQ(scaled.scaling, "50 of 500 particles");
}

TEST(ScaledForVerify, KeepsOneParticleOfEach) {
  Scene scene = parse(two_emitters, "a.toml", {"verify.rows=1"});
  const Scene scaled = scaled_for_verify(scene);
  EXPECT_EQ(scaled.setup.emitters[0].count, 1u);
  EXPECT_EQ(scaled.setup.emitters[2].count, 1u);
  EXPECT_EQ(solver::World::total_emitted(scaled.setup), 3u);
}

TEST(ScaledForVerify, LimitsSteps) {
  const Scene some = scaled_for_verify(parse(two_emitters, "a.toml", {"verify.steps=25"}));
  EXPECT_EQ(some.steps, 20);
  EXPECT_EQ(some.frames.every, 10);
  EXPECT_EQ(some.scaling, "50 of 500 particles, 20 of 100 steps");
  const Scene few = scaled_for_verify(parse(two_emitters, "a.toml", {"verify.steps=3"}));
  EXPECT_EQ(few.steps, 3);
  EXPECT_EQ(few.frames.every, 3);
}

TEST(ScaledForVerify, LeavesSmallScenesAlone) {
  const Scene scaled = scaled_for_verify(parse(two_emitters, "a.toml", {"verify.rows=500"}));
  EXPECT_EQ(scaled.setup.emitters[0].count, 100u);
  EXPECT_EQ(scaled.scaling, "");
}

// A lattice is cut to a smaller one at the same place, not to its first layer.
TEST(ScaledForVerify, KeepsTheShapeOfALattice) {
  const Scene scene = load((repository / "scenes" / "debris.toml").string());
  const Scene scaled = scaled_for_verify(scene);
  const solver::Emitter& hill = scene.setup.emitters[0];
  const solver::Emitter& small = scaled.setup.emitters[0];
  EXPECT_GE(small.count, 5990U);
  EXPECT_LE(small.count, 6000U);
  EXPECT_GE(solver::lattice_sites(small), small.count);
  EXPECT_LE(solver::lattice_sites(small), small.count + small.count / 20);
  EXPECT_NEAR(small.size[0] / small.size[1], hill.size[0] / hill.size[1], 0.1);
  EXPECT_EQ(small.position[0], hill.position[0]);
  EXPECT_NEAR(small.position[1] - small.size[1] / 2, hill.position[1] - hill.size[1] / 2, 1e-9);
}

TEST(KeyReference, OfTheDocumentationIsUpToDate) {
  std::ifstream file(repository / "docs" / "scenes.md");
  std::ostringstream text;
  text << file.rdbuf();
  const std::size_t at = text.str().find("### The scene\n");
  ASSERT_NE(at, std::string::npos);
  EXPECT_EQ(text.str().substr(at), key_reference())
      << "bring docs/scenes.md up to date: scripts/key_reference.sh";
}

TEST(KeyReference, NamesUnitsDefaultsAndBounds) {
  const std::string text = key_reference();
  EXPECT_NE(text.find("| `gravity` | list of 3 numbers | m/s^2 | `[0, -9.80665, 0]` |"),
            std::string::npos);
  EXPECT_NE(text.find("| `mass` | number or spread | kg | `1` | 1e-30 to 1e+30 | mass |"),
            std::string::npos);
  EXPECT_NE(text.find("| `rate` | number | 1/s | required | more than 0 |"), std::string::npos);
}

std::vector<std::string> shipped_scenes() {
  std::vector<std::string> paths;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(repository / "scenes")) {
    if (entry.path().extension() == ".toml") paths.push_back(entry.path());
  }
  std::stable_sort(paths.begin(), paths.end());
  return paths;
}

class ShippedScene : public testing::TestWithParam<std::string> {};

TEST_P(ShippedScene, Loads) {
  const AnyScene any = load_any(GetParam());
  EXPECT_FALSE(text_of(any).title.empty());
  if (const auto* sweep = std::get_if<SweepScene>(&any)) {
    EXPECT_GT(solver::Sweep(sweep->setup).rows(), 0u);
    return;
  }
  const auto& scene = std::get<Scene>(any);
  EXPECT_GT(scene.steps, 0);
  if (GetParam().find("/features/") != std::string::npos) {
    EXPECT_LE(solver::World::total_emitted(scene.setup), 20'000u);
    EXPECT_LE(scene.steps, 500);
  }
}

// Equal bits of particles that never met would say nothing of contacts.
TEST_P(ShippedScene, TouchesWhenVerified) {
  const AnyScene any = load_any(GetParam());
  const auto* scene = std::get_if<Scene>(&any);
  if (!scene || !scene->setup.contact_law) return;
  const Scene scaled = scaled_for_verify(*scene);
  solver::World world(scaled.setup, {solver::widest_isa(), 2, 1});
  std::uint64_t pairs = 0;
  std::uint64_t walls = 0;
  constexpr std::int64_t looks = 400;  // an impact is short
  for (std::int64_t look = 1; look <= looks; ++look) {
    world.advance_to(scaled.steps * look / looks);
    const solver::Diagnostics seen = world.diagnose();
    pairs += seen.contacts->pair_contacts;
    walls += seen.contacts->wall_contacts;
  }
  EXPECT_GT(pairs, 0U);
  EXPECT_TRUE(walls > 0 || scaled.setup.obstacles.empty());
}

INSTANTIATE_TEST_SUITE_P(All, ShippedScene, testing::ValuesIn(shipped_scenes()),
                         [](const testing::TestParamInfo<std::string>& scene) {
                           return std::filesystem::path(scene.param).stem().string();
                         });

TEST(ShippedScenes, TheMainJobIsAMillionParticles) {
  const Scene scene = load(repository / "scenes" / "explosion.toml");
  EXPECT_EQ(solver::World::total_emitted(scene.setup), 1'000'000u);
  EXPECT_EQ(scene.frame_count(), 121);
  EXPECT_EQ(scene.frames.fraction, 0.05);
  EXPECT_DOUBLE_EQ(static_cast<double>(scene.steps) * scene.setup.dt, 5.0);
  EXPECT_TRUE(scene.checkpoint.at_end);
}

Scene book_scene(const std::string& name) {
  return load(repository / "scenes" / "book" / (name + ".toml"));
}

TEST(BookScenes, KinematicExplosionHasTheDefaultsOf2_6) {
  const solver::Setup setup = book_scene("particle_explosion").setup;
  EXPECT_EQ(setup.dt, 0.01);
  EXPECT_EQ(setup.forces.gravity, (models::Triple{0, -30, 0}));
  ASSERT_EQ(setup.emitters.size(), 1u);
  const solver::Emitter& explosion = setup.emitters[0];
  EXPECT_EQ(explosion.kind, solver::EmitterKind::book_explosion);
  EXPECT_EQ(explosion.count, 50u);
  EXPECT_EQ(explosion.position, (models::Triple{200, 400 - 100, 0}));  // y up in a view of 400
  EXPECT_EQ(explosion.strength, 75);
  EXPECT_EQ(explosion.life_ms, 4000);
  EXPECT_FALSE(explosion.angle.has_value());  // the book's 999
}

TEST(BookScenes, EnergyExplosionHasTheGravelOf18_4_1) {
  const solver::Setup setup = book_scene("kinetic_energy_explosion").setup;
  ASSERT_EQ(setup.emitters.size(), 1u);
  const solver::Emitter& explosion = setup.emitters[0];
  EXPECT_EQ(explosion.count, 50u);
  EXPECT_EQ(explosion.mass.a, 0.25);
  EXPECT_EQ(explosion.energy, 566.5725);
  EXPECT_EQ(explosion.shares, solver::EnergyShares::book);
}

TEST(BookScenes, ParticlesHaveTheConstantsOfChapter8) {
  for (const char* name :
       {"particles_gravity", "particles_wind", "particles_ground", "particles_obstacles"}) {
    SCOPED_TRACE(name);
    const solver::Setup setup = book_scene(name).setup;
    EXPECT_EQ(setup.dt, 0.1);
    EXPECT_EQ(setup.integrator, solver::IntegratorKind::semi_implicit_euler);
    EXPECT_EQ(setup.forces.gravity, (models::Triple{0, -9.8, 0}));
    ASSERT_EQ(setup.emitters.size(), 1u);
    EXPECT_EQ(setup.emitters[0].count, 1000u);
    EXPECT_EQ(setup.emitters[0].mass.a, 1);
    EXPECT_EQ(setup.emitters[0].radius.a, 0.1);
    if (setup.forces.quadratic_drag) {
      EXPECT_EQ(setup.forces.drag_law, models::DragLaw::book_still_air);
      EXPECT_EQ(setup.forces.air_density, 1.23);
      EXPECT_EQ(setup.forces.wind.velocity, (models::Triple{10, 0, 0}));
      EXPECT_EQ(setup.emitters[0].drag_coefficient, 0.6);
    }
    for (const models::Obstacle& obstacle : setup.obstacles) EXPECT_EQ(obstacle.restitution, 0.6);
    if (setup.obstacles.empty()) continue;
    EXPECT_EQ(setup.contact.response, models::ContactResponse::force);
    EXPECT_EQ(setup.obstacles[0].shape, models::ObstacleShape::plane);
    EXPECT_EQ(setup.obstacles[0].center[1], 100);
  }
  EXPECT_FALSE(book_scene("particles_gravity").setup.forces.quadratic_drag);
  EXPECT_TRUE(book_scene("particles_wind").setup.forces.quadratic_drag);
  EXPECT_EQ(book_scene("particles_ground").setup.obstacles.size(), 1u);
}

TEST(BookScenes, ObstaclesStandInTheBandOf8_4) {
  constexpr double width = 1024, height = 768, ground = 100, radius = 20;
  const auto obstacles = book_scene("particles_obstacles").setup.obstacles;
  ASSERT_EQ(obstacles.size(), 1u + 15);
  for (std::size_t i = 1; i < obstacles.size(); ++i) {
    SCOPED_TRACE(i);
    EXPECT_EQ(obstacles[i].shape, models::ObstacleShape::cylinder);
    EXPECT_EQ(obstacles[i].radius, radius);
    EXPECT_EQ(obstacles[i].mass, 100);
    EXPECT_GE(obstacles[i].center[0], width / 2 - 10 * radius);
    EXPECT_LE(obstacles[i].center[0], width / 2 + 10 * radius);
    EXPECT_GE(obstacles[i].center[1], ground + radius);
    EXPECT_LE(obstacles[i].center[1], height / 2 - 4 * radius);
  }
}

TEST(ShippedScenes, TheDocumentedExampleLoads) {
  std::ifstream file(repository / "docs" / "scenes.md");
  std::ostringstream text;
  text << file.rdbuf();
  const std::string fence = "```toml\n";
  const std::size_t begin = text.str().find(fence) + fence.size();
  const std::size_t end = text.str().find("```", begin);
  EXPECT_EQ(parse(text.str().substr(begin, end - begin), "docs/scenes.md").steps, 1500);
}

}  // namespace
}  // namespace salvo::scene
