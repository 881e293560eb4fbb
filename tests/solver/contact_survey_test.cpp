// Particles that are emitted where others or obstacles are: who is found, and how they are moved
// apart.
#include "solver/contact_survey.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/random.hpp"
#include "tests/physics/spheres.hpp"
#include "tests/solver/particles.hpp"

namespace salvo::tests {
namespace {

using solver::BirthOverlaps;
using solver::Parallel;

constexpr double radius = 0.01;
constexpr double tolerance = 0.01;

// Where single precision is too coarse, the rest lies in the residual.
Particle sphere(soa::Id id, const Triple& at, Precision precision, double size = radius) {
  Particle particle;
  particle.id = id;
  particle.radius = size;
  particle.position = at;
  if (precision == Precision::float64) return particle;
  for (std::size_t c = 0; c < 3; ++c) {
    particle.position[c] = static_cast<double>(static_cast<float>(at[c]));
    particle.residual[c] = at[c] - particle.position[c];
  }
  return particle;
}

Triple center(const Particle& particle) {
  Triple x = particle.position;
  for (std::size_t c = 0; c < 3; ++c) x[c] += particle.residual[c];
  return x;
}

double overlap(const Particle& a, const Particle& b) {
  const Triple p = center(a);
  const Triple q = center(b);
  return a.radius + b.radius - std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}

struct Way {
  solver::Isa isa = solver::widest_isa();
  int threads = 1;
};

std::vector<Way> ways() {
  std::vector<Way> all;
  for (const solver::Isa isa : solver::available_isas()) {
    all.push_back({isa, 1});
    all.push_back({isa, 3});
  }
  return all;
}

BirthOverlaps overlaps(const solver::Setup& setup, const std::vector<Particle>& particles,
                       std::size_t first_row = 0, const Way& way = {}) {
  const Parallel parallel(way.threads);
  return solver::find_birth_overlaps(setup, 0, table_of_particles(setup.precision, particles),
                                     first_row, tolerance, way.isa, parallel);
}

// Moves those from first_row on; false if they find no room.
bool part(const solver::Setup& setup, std::vector<Particle>& particles, std::size_t first_row = 0,
          const Way& way = {}) {
  const Parallel parallel(way.threads);
  soa::Table table = table_of_particles(setup.precision, particles);
  const bool parted = solver::move_apart(setup, 0, table, first_row, tolerance, way.isa, parallel);
  particles = read_particles(table);
  return parted;
}

// ---- who is found -------------------------------------------------------------------------------

TEST(BirthOverlaps, AreThoseBeyondTheTolerance) {
  for (const Precision precision : {Precision::float32, Precision::float64}) {
    const solver::Setup setup = touching_setup(linear(1e4, 0.5), precision);
    const std::vector<Particle> row = {
        sphere(5, {0, 0, 0}, precision), sphere(9, {0.0195, 0, 0}, precision),  // by 5 %
        sphere(2, {0.03945, 0, 0}, precision),                                  // by 0.5 %
        sphere(7, {0.0515, 0, 0}, precision, 0.004)};                           // 48.75 % of 4 mm
    for (const Way& way : ways()) {
      const BirthOverlaps found = overlaps(setup, row, 0, way);
      EXPECT_EQ(found.pairs, 2U);
      EXPECT_NEAR(found.worst, 0.4875, 1e-6);
      EXPECT_EQ(found.particle, 2U);
      EXPECT_EQ(found.partner, 7U);
      EXPECT_FALSE(found.obstacle.has_value());
    }
    // Of the last row alone: the others have been there.
    EXPECT_EQ(overlaps(setup, row, 3).pairs, 1U);
    EXPECT_EQ(overlaps(setup, {row[0], row[1], row[2]}, 2).pairs, 0U);
  }
}

TEST(BirthOverlaps, OfEqualsTheFirstByIdIsNamed) {
  const solver::Setup setup = touching_setup(linear(1e4, 0.5));
  for (const std::vector<soa::Id>& ids : {std::vector<soa::Id>{8, 6, 7, 4}, {4, 7, 6, 8}}) {
    std::vector<Particle> row;
    for (std::size_t k = 0; k < ids.size(); ++k) {
      row.push_back(sphere(ids[k], {static_cast<double>(k) * 0.015625, 0, 0}, Precision::float64));
    }
    const BirthOverlaps found = overlaps(setup, row);
    EXPECT_EQ(found.pairs, 3U);
    EXPECT_EQ(found.particle, 4U);
    EXPECT_EQ(found.partner, 7U);
  }
}

TEST(BirthOverlaps, BeyondWhatCellsTellApartAreStillOfThoseThatTouch) {
  const solver::Setup setup = touching_setup(linear(1e4, 0.5));
  const auto at = [](soa::Id id, double x) { return sphere(id, {x, 0, 0}, Precision::float64); };
  for (const Way& way : ways()) {
    EXPECT_EQ(overlaps(setup, {at(3, 1e305), at(4, 2e305), at(5, 3)}, 0, way).pairs, 0U);
    const BirthOverlaps found = overlaps(setup, {at(3, 1e305), at(4, 2e305), at(5, 2e305)}, 0, way);
    EXPECT_EQ(found.pairs, 1U);
    EXPECT_EQ(found.particle, 4U);
    EXPECT_EQ(found.partner, 5U);
  }
}

TEST(BirthOverlaps, NameTheObstacle) {
  solver::Setup setup = touching_setup(linear(1e4, 0.5));
  setup.obstacles = {hollow_box({0, 0.5, 0}, {0.5, 0.5, 0.5}, *setup.contact_law),
                     ground(*setup.contact_law)};
  setup.obstacles[1].center = {0, 0.1, 0};
  const BirthOverlaps found = overlaps(setup, {sphere(3, {0, 0.105, 0}, Precision::float64)});
  EXPECT_EQ(found.pairs, 1U);
  EXPECT_NEAR(found.worst, 0.5, 1e-12);
  EXPECT_EQ(found.particle, 3U);
  EXPECT_EQ(found.obstacle, 1U);
}

// ---- moved apart --------------------------------------------------------------------------------

TEST(MoveApart, TwoAtOnePlacePartAlongY) {
  for (const Precision precision : {Precision::float32, Precision::float64}) {
    for (const double far : {0.0, 0x1p20}) {
      const solver::Setup setup = touching_setup(linear(1e4, 0.5), precision);
      const Triple at{far + 0.25, far, far - 0.5};
      std::vector<Particle> two = {sphere(8, at, precision), sphere(3, at, precision)};
      ASSERT_TRUE(part(setup, two));
      EXPECT_NEAR(overlap(two[0], two[1]), 0, 1e-8);
      EXPECT_NEAR(center(two[0])[1], far + radius, 1e-8);
      EXPECT_NEAR(center(two[1])[1], far - radius, 1e-8);
      for (const Particle& particle : two) {
        EXPECT_EQ(center(particle)[0], at[0]);
        EXPECT_EQ(center(particle)[2], at[2]);
      }
    }
  }
}

TEST(MoveApart, WhoIsThereAlreadyStays) {
  const solver::Setup setup = touching_setup(linear(1e4, 0.5));
  std::vector<Particle> particles = {sphere(1, {0, 0, 0}, Precision::float64),
                                     sphere(4, {0.012, 0, 0}, Precision::float64),
                                     sphere(2, {0.03, 0, 0}, Precision::float64)};
  const std::vector<Particle> before = particles;
  ASSERT_TRUE(part(setup, particles, 2));
  EXPECT_EQ(particles[0].position, before[0].position);
  EXPECT_EQ(particles[1].position, before[1].position);
  EXPECT_NEAR(particles[2].position[0], 0.032, 1e-12);
}

TEST(MoveApart, WithoutRoomItSaysSo) {
  solver::Setup setup = touching_setup(linear(1e4, 0.5));
  setup.obstacles = {hollow_box({0, 0, 0}, {0.015, 0.015, 0.015}, *setup.contact_law)};
  std::vector<Particle> two;
  for (soa::Id id = 0; id < 3; ++id) two.push_back(sphere(id, {0, 0, 0}, Precision::float64));
  EXPECT_FALSE(part(setup, two));
}

// A cloud on the floor of a box, many times overlapped, some of it at one place; the first
// thirty stood there before, apart from each other.
constexpr std::size_t standing = 30;
constexpr double half = 0.12;

solver::Setup box_at(const Triple& at, Precision precision) {
  solver::Setup setup = touching_setup(linear(1e4, 0.5), precision);
  setup.obstacles = {hollow_box(at, {half, half, half}, *setup.contact_law)};
  return setup;
}

std::vector<Particle> cloud_at(const Triple& at, Precision precision) {
  std::vector<Particle> cloud;
  const auto add = [&](double x, double y, double z) {
    const double size = radius * (cloud.size() % 3 == 0 ? 0.5 : 1);
    // Ids in another order than the rows.
    cloud.push_back(
        sphere((cloud.size() * 37) % 1009, {at[0] + x, at[1] + y, at[2] + z}, precision, size));
  };
  for (std::size_t k = 0; k < standing; ++k) {
    add(-0.0625 + 0.03125 * static_cast<double>(k % 5), -0.109375,
        -0.078125 + 0.03125 * static_cast<double>(k / 5));
  }
  for (std::uint64_t k = 0; k < 400; ++k) {
    const kernels::Draws draws(3, k / 50 * 50 + std::max<std::uint64_t>(k % 50, 3));  // some twice
    add(draws.uniform(0, -0.1, 0.1), draws.uniform(1, -0.1, 0.05), draws.uniform(2, -0.1, 0.1));
  }
  return cloud;
}

TEST(MoveApart, ACloudPartsToTheSamePlacesHoweverItIsDone) {
  for (const Precision precision : {Precision::float32, Precision::float64}) {
    for (const double far : {0.0, 0x1p20}) {
      const Triple at{far, -far, far};
      const solver::Setup setup = box_at(at, precision);
      const std::vector<Particle> before = cloud_at(at, precision);
      ASSERT_GT(overlaps(setup, before, standing).pairs, 300U);
      std::vector<Particle> wanted = before;
      ASSERT_TRUE(part(setup, wanted, standing, {solver::Isa::scalar, 1}));
      EXPECT_EQ(overlaps(setup, wanted, standing).pairs, 0U);
      for (std::size_t i = 0; i < wanted.size(); ++i) {
        for (std::size_t j = std::max(i + 1, standing); j < wanted.size(); ++j) {
          EXPECT_LE(overlap(wanted[i], wanted[j]),
                    tolerance * std::min(wanted[i].radius, wanted[j].radius));
        }
        EXPECT_TRUE(i >= standing || center(wanted[i]) == center(before[i])) << i;
        for (std::size_t c = 0; c < 3; ++c) {
          const double room = half - std::abs(center(wanted[i])[c] - at[c]);
          EXPECT_GE(room, (1 - tolerance) * wanted[i].radius);
        }
      }
      for (const Way& way : ways()) {
        std::vector<Particle> parted = before;
        ASSERT_TRUE(part(setup, parted, standing, way));
        for (std::size_t i = 0; i < parted.size(); ++i) {
          ASSERT_EQ(parted[i].position, wanted[i].position) << name(way.isa) << way.threads;
          ASSERT_EQ(parted[i].residual, wanted[i].residual) << name(way.isa) << way.threads;
        }
      }
      // Rows in another order: the same ids at the same places.
      std::vector<Particle> reversed = before;
      std::reverse(reversed.begin() + standing, reversed.end());
      ASSERT_TRUE(part(setup, reversed, standing));
      std::reverse(reversed.begin() + standing, reversed.end());
      for (std::size_t i = 0; i < wanted.size(); ++i) {
        ASSERT_EQ(center(reversed[i]), center(wanted[i]));
      }
    }
  }
}

}  // namespace
}  // namespace salvo::tests
