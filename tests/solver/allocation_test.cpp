// A steady step allocates nothing of ours, and a particle holds at most 80 bytes. Counted by
// replacing operator new, on every thread, in a program of its own: TBB's own memory comes from
// malloc and is not counted.
#include <gtest/gtest.h>
#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "tests/physics/spheres.hpp"
#include "tests/solver/setups.hpp"

namespace {

std::atomic<std::uint64_t> allocations = 0;
std::atomic<std::int64_t> bytes_held = 0;

void* counted(void* memory) {
  if (memory == nullptr) throw std::bad_alloc();
  allocations.fetch_add(1);
  bytes_held.fetch_add(static_cast<std::int64_t>(malloc_usable_size(memory)));
  return memory;
}

void release(void* memory) {
  bytes_held.fetch_sub(static_cast<std::int64_t>(malloc_usable_size(memory)));
  std::free(memory);
}

}  // namespace

// The other forms call these.
void* operator new(std::size_t size) { return counted(std::malloc(size)); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  const auto step = static_cast<std::size_t>(alignment);
  return counted(std::aligned_alloc(step, (size + step - 1) / step * step));
}
void operator delete(void* memory) noexcept { release(memory); }
void operator delete(void* memory, std::size_t) noexcept { release(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { release(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { release(memory); }

namespace salvo::tests {

namespace {

using solver::World;

std::vector<NamedSetup> steady_setups() {
  solver::Setup free = plain_setup(Precision::float32);
  free.forces = every_force();
  free.emitters = {burst(1, 12'345)};
  solver::Setup obstacles = plain_setup(Precision::float32);
  obstacles.forces.quadratic_drag = true;
  obstacles.emitters = {burst(1, 12'345)};
  obstacles.emitters[0].position = {0, 2, 0};
  models::Obstacle ball;
  ball.shape = models::ObstacleShape::sphere;
  ball.center = {2, 1, 0};
  obstacles.obstacles = {models::Obstacle{}, ball};
  return {{"free", free}, {"obstacles", obstacles}};
}

}  // namespace

TEST(Allocation, ASteadyStepMakesNone) {
  for (const NamedSetup& scene : steady_setups()) {
    for (const int threads : {1, 2}) {
      World world(scene.setup, {solver::widest_isa(), threads, 16});
      world.advance_to(16);  // the first pass makes its room
      const std::uint64_t before = allocations;
      world.advance_to(160);
      EXPECT_EQ(allocations - before, 0U) << scene.name << ", " << threads << " threads";
    }
  }
}

// Spheres that fly about in a box; some of them touch at any time, and lists last for some steps.
solver::Setup flying_spheres(const ContactLaw& law, Precision precision) {
  solver::Setup setup = touching_setup(law, precision);
  setup.seed = 4;
  setup.obstacles.push_back(hollow_box({0, 0, 0}, {0.088, 0.088, 0.088}, law));
  setup.emitters.push_back(lattice({0, 0, 0}, {0.176, 0.176, 0.176}, 0.011, 0.005, 1e-3));
  setup.emitters[0].speed = uniform(0.1, 0.5);
  setup.dt = solver::contact_time(setup).step;
  return setup;
}

// Lists take what room they need, and so does a contact where there were never so many. On one
// thread: each other makes its room at the first task that it gets.
TEST(Allocation, AStepOfParticlesThatTouchMakesNoneBetweenLists) {
  ContactLaw rough = linear(1e4, 0.9, 0.5);
  rough.rolling_friction = 0.1;
  for (const ContactLaw& law : {linear(1e4, 0.9), rough, hertz(1e7, 0.9, 0.5), impulse(0.9, 0.5)}) {
    for (const Precision precision : {Precision::float32, Precision::float64}) {
      solver::Setup setup = flying_spheres(law, precision);
      // Impulses are at once, and set no step.
      if (law.kind == models::ContactLawKind::impulse) setup.dt = 1e-4;
      World world(setup, {solver::widest_isa(), 1});
      const std::int64_t settled = 1000;
      world.advance_to(settled);
      const auto lists = [&] { return world.contact_profile()->list_builds; };
      int steps = 0;
      for (std::int64_t step = settled + 1; step <= settled + 300; ++step) {
        const std::uint64_t lists_before = lists();
        const std::uint64_t before = allocations;
        world.advance_to(step);
        if (lists() != lists_before) continue;
        ++steps;
        ASSERT_EQ(allocations - before, 0U) << static_cast<int>(law.kind) << ", step " << step;
      }
      EXPECT_GT(steps, 200);
      EXPECT_LT(steps, 300);
      EXPECT_GT(world.diagnose().contacts->pair_contacts, 10U);
    }
  }
}

TEST(Allocation, IsCounted) {
  const std::uint64_t before = allocations;
  const World world(plain_setup(), {});
  EXPECT_GT(allocations, before);
}

TEST(Allocation, AWorldOfAllColumnsHoldsAtMost80BytesAParticle) {
  solver::Setup setup = plain_setup(Precision::float32);
  setup.emitters = {burst(1, 61'441), burst(2, 3, 0.1)};
  setup.emitters[0].mass = uniform(1, 2);
  setup.emitters[0].radius = uniform(1, 2);
  setup.emitters[0].life = uniform(1, 2);
  setup.emitters[1].group = 3;
  const std::int64_t before = bytes_held;
  World world(setup, {solver::widest_isa(), 2, 16});
  world.advance_to(33);
  for (std::size_t f = 0; f < soa::particle_fields.size(); ++f) {
    if (soa::only_of_contacts(f)) continue;
    EXPECT_TRUE(world.particles().stored(f)) << soa::particle_fields[f].name;
  }
  EXPECT_LE(bytes_held - before, static_cast<std::int64_t>(80 * world.particles().rows()));
}

}  // namespace salvo::tests
