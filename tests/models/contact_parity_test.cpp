// Contact gives the scalar lane's bits on every instruction set: chords through all shapes, and
// runs that bounce, slide, wedge and come to rest among them.
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "tests/models/contact_parity.hpp"
#include "tests/per_isa.hpp"

namespace salvo::tests {

namespace contact_parity {
SALVO_TEST_TABLES
}

namespace {

using contact_parity::Columns;
using contact_parity::Run;
using models::ContactResponse;
using models::Obstacle;
using models::ObstacleShape;

constexpr std::size_t rows = 10240;

// Whole numbers over powers of two: float holds them, so both precisions see the same scenes.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : engine_(seed) {}
  double within(int low, int high) {
    const auto steps = static_cast<std::uint64_t>(high - low) * 4096;
    return low + static_cast<double>(engine_() % steps) / 4096;
  }

 private:
  std::mt19937_64 engine_;
};

std::vector<Obstacle> scene() {
  Draws draws(20);
  std::vector<Obstacle> obstacles;
  Obstacle o;
  o.shape = ObstacleShape::height_field;
  o.center = {-6, -5, -6};
  std::vector<double> heights(13 * 13);
  for (double& h : heights) h = draws.within(-1, 1);
  o.samples = models::make_height_samples(13, 13, 1, heights);
  o.friction = 0.25;
  obstacles.push_back(o);
  o = Obstacle();
  o.center = {0, -8, 0};
  o.axis = {0.1, 1, -0.3};
  obstacles.push_back(models::normalized(o));
  for (int i = 0; i < 12; ++i) {
    o = Obstacle();
    o.shape = static_cast<ObstacleShape>(1 + i % 4);
    o.center = {draws.within(-5, 5), draws.within(-4, 4), draws.within(-5, 5)};
    o.axis = {draws.within(-2, 2), draws.within(1, 2), draws.within(-2, 2)};
    o.radius = draws.within(0, 2) + 0.001;
    o.half_length = draws.within(0, 2) + 0.001;
    o.half_size = {draws.within(0, 2) + 0.001, draws.within(0, 2) + 0.001, draws.within(0, 2)};
    o.rotation = {draws.within(1, 2), draws.within(-1, 1), draws.within(-1, 1),
                  draws.within(-1, 1)};
    o.restitution = i % 3 == 0 ? 1 : draws.within(0, 1);
    o.friction = i % 2 ? draws.within(0, 1) : 0;
    if (i % 5 == 0) o.mass = draws.within(1, 100);
    obstacles.push_back(models::normalized(o));
  }
  return obstacles;
}

template <class T>
struct alignas(64) Column {
  T value[rows];
};

template <class T>
Columns<T> columns(std::vector<Column<T>>& storage) {
  Columns<T> all;
  for (std::size_t i = 0; i < 6; ++i) all.state[i] = storage[i].value;
  return all;
}

// Results of one run: six columns of state, impacts, rests.
template <class T>
using Results = std::vector<Column<T>>;

template <class T>
struct Inputs {
  std::vector<Obstacle> obstacles = scene();
  std::vector<Column<T>> before = std::vector<Column<T>>(6);
  std::vector<Column<T>> after = std::vector<Column<T>>(6);
  std::vector<Column<T>> row = std::vector<Column<T>>(3);

  Inputs() {
    Draws draws(21);
    for (std::size_t i = 0; i < rows; ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        before[c].value[i] = static_cast<T>(draws.within(-6, 6));
        before[c + 3].value[i] = static_cast<T>(draws.within(-20, 20));
        after[c].value[i] = static_cast<T>(draws.within(-6, 6));
        after[c + 3].value[i] = static_cast<T>(draws.within(-20, 20));
      }
      row[0].value[i] = static_cast<T>(draws.within(1, 10));
      row[1].value[i] = static_cast<T>(i % 3 ? draws.within(0, 1) / 8 : 0);
      row[2].value[i] = static_cast<T>(i % 17 ? 1 : 0);
    }
  }

  Results<T> run(solver::Isa isa, ContactResponse response, int steps, double dt) {
    Results<T> results(8);
    Run<T> run;
    run.obstacles = obstacles;
    run.settings.response = response;
    run.dt = static_cast<T>(dt);
    run.gravity = static_cast<T>(9.8);
    run.steps = steps;
    run.rows = rows;
    run.mass = row[0].value;
    run.radius = row[1].value;
    run.active = row[2].value;
    run.before = columns<T>(before);
    const Columns<T> ends = columns<T>(after);
    if (steps == 1 && response == ContactResponse::swept) run.after = &ends;
    run.result = columns<T>(results);
    run.impacts = results[6].value;
    run.rests = results[7].value;
    const contact_parity::Table& table = contact_parity::table_of(isa);
    if constexpr (sizeof(T) == sizeof(float)) {
      table.single(run);
    } else {
      table.twice(run);
    }
    return results;
  }
};

template <class T>
void expect_parity(ContactResponse response, int steps, double dt) {
  Inputs<T> inputs;
  const Results<T> expected = inputs.run(solver::Isa::scalar, response, steps, dt);
  double impacts = 0;
  for (const T count : expected[6].value) impacts += static_cast<double>(count);
  EXPECT_GT(impacts, rows / 20);
  static const char* const names[] = {"x", "y", "z", "vx", "vy", "vz", "impacts", "rests"};
  for (const solver::Isa isa : solver::available_isas()) {
    const Results<T> got = inputs.run(isa, response, steps, dt);
    for (std::size_t c = 0; c < 8; ++c) {
      for (std::size_t i = 0; i < rows; ++i) {
        ASSERT_EQ(std::memcmp(&got[c].value[i], &expected[c].value[i], sizeof(T)), 0)
            << name(isa) << ", row " << i << ", " << names[c] << ": " << got[c].value[i]
            << " instead of " << expected[c].value[i];
      }
    }
  }
}

template <class T>
class ContactParity : public ::testing::Test {};
using Reals = ::testing::Types<float, double>;
TYPED_TEST_SUITE(ContactParity, Reals);

TYPED_TEST(ContactParity, RandomChords) {
  expect_parity<TypeParam>(ContactResponse::swept, 1, 0.5);
}

TYPED_TEST(ContactParity, Runs) {
  expect_parity<TypeParam>(ContactResponse::swept, 200, 0.0078125);
  expect_parity<TypeParam>(ContactResponse::swept, 60, 0.1);
}

TYPED_TEST(ContactParity, BookResponses) {
  expect_parity<TypeParam>(ContactResponse::impulse, 50, 0.0625);
  expect_parity<TypeParam>(ContactResponse::force, 50, 0.0625);
}

}  // namespace
}  // namespace salvo::tests
