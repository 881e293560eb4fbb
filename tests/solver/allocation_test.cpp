// A steady step allocates nothing of ours, and a particle holds at most 80 bytes. Counted by
// replacing operator new, on every thread, in a program of its own: TBB's own memory comes from
// malloc and is not counted.
#include <gtest/gtest.h>
#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <new>

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
