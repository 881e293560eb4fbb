// Reductions: exact on data whose sums are exact, close to long double on the rest, the documented
// shape, and the same bits for any number of threads.
#include "solver/reduction.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "tests/solver/particles.hpp"

namespace salvo::tests {

namespace {

using solver::Diagnostics;
using solver::Parallel;

constexpr std::size_t counts[] = {1, 3, 15, 17, 63, 65, 4095, 4097, 12345, 65537};

// Small whole numbers and halves: every product and sum below is exact, in any order.
std::vector<Particle> whole_number_particles(std::size_t count) {
  std::mt19937_64 random(7);
  const auto draw = [&] { return static_cast<double>(random() % 33) - 16; };
  std::vector<Particle> particles(count);
  for (std::size_t i = 0; i < count; ++i) {
    particles[i].id = i;
    particles[i].position = {draw(), draw(), draw()};
    particles[i].velocity = {draw(), draw(), draw()};
    particles[i].mass = 17 + draw();
  }
  return particles;
}

std::vector<double> random_values(std::size_t count) {
  std::mt19937_64 random(9);
  std::vector<double> values(count);
  for (double& value : values) {
    value = (static_cast<double>(random() >> 11) * 0x1p-53 - 0.3) *
            std::ldexp(1.0, static_cast<int>(random() % 40));
  }
  return values;
}

// Neighbours, neighbours of neighbours, ..: written as the recursion that the sum's definition is.
double pairwise(const std::vector<double>& values, std::size_t first, std::size_t span) {
  if (first >= values.size()) return -0.0;  // adding it changes nothing
  if (span == 1) return values[first];
  return pairwise(values, first, span / 2) + pairwise(values, first + span / 2, span / 2);
}
double pairwise(const std::vector<double>& values) {
  return values.empty() ? 0.0 : pairwise(values, 0, std::bit_ceil(values.size()));
}

double sum_by_definition(const std::vector<double>& values) {
  std::vector<double> leaves;
  for (std::size_t first = 0; first < values.size(); first += 4096) {
    std::vector<double> lanes(16, 0.0);
    for (std::size_t i = first; i < std::min(values.size(), first + 4096); ++i) {
      lanes[i % 16] += values[i];
    }
    leaves.push_back(pairwise(lanes));
  }
  return pairwise(leaves);
}

}  // namespace

TEST(FixedOrderSum, HasTheDocumentedShape) {
  for (const std::size_t count : counts) {
    const std::vector<double> values = random_values(count);
    EXPECT_EQ(solver::fixed_order_sum(values), sum_by_definition(values)) << count;
  }
  EXPECT_EQ(std::bit_cast<std::uint64_t>(solver::fixed_order_sum({})), 0U);  // +0
}

TEST(FixedOrderSum, IsCloseToTheExactSum) {
  const std::vector<double> values = random_values(65537);
  long double exact = 0;
  long double magnitude = 0;
  for (const double value : values) {
    exact += value;
    magnitude += std::abs(value);
  }
  EXPECT_NEAR(solver::fixed_order_sum(values), static_cast<double>(exact),
              static_cast<double>(magnitude) * 0x1p-53 * 30);
}

TEST(Diagnose, IsExactOnWholeNumbers) {
  models::ForceSettings forces;
  forces.gravity = {0.5, -8, 2};
  const Parallel parallel(3);
  for (const soa::Precision precision : {soa::Precision::float32, soa::Precision::float64}) {
    for (const std::size_t count : counts) {
      const std::vector<Particle> particles = whole_number_particles(count);
      Diagnostics wanted;
      wanted.lowest = wanted.highest = particles.front().position;
      std::array<double, 3> first_moment{};
      double fastest = 0;
      for (const Particle& p : particles) {
        double v2 = 0;
        wanted.mass += p.mass;
        for (std::size_t c = 0; c < 3; ++c) {
          wanted.momentum[c] += p.mass * p.velocity[c];
          first_moment[c] += p.mass * p.position[c];
          wanted.lowest[c] = std::min(wanted.lowest[c], p.position[c]);
          wanted.highest[c] = std::max(wanted.highest[c], p.position[c]);
          wanted.potential_energy -= p.mass * forces.gravity[c] * p.position[c];
          v2 += p.velocity[c] * p.velocity[c];
        }
        wanted.kinetic_energy += p.mass * v2 / 2;
        fastest = std::max(fastest, v2);
      }
      const Diagnostics d = diagnose(table_of_particles(precision, particles), forces, parallel);
      EXPECT_EQ(d.count, count);
      EXPECT_EQ(d.mass, wanted.mass) << count;
      EXPECT_EQ(d.momentum, wanted.momentum) << count;
      EXPECT_EQ(d.kinetic_energy, wanted.kinetic_energy) << count;
      EXPECT_EQ(d.potential_energy, wanted.potential_energy) << count;
      EXPECT_EQ(d.lowest, wanted.lowest) << count;
      EXPECT_EQ(d.highest, wanted.highest) << count;
      EXPECT_EQ(d.max_speed, std::sqrt(fastest)) << count;
      for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_EQ(d.center_of_mass[c], first_moment[c] / wanted.mass) << count;
      }
    }
  }
}

TEST(Diagnose, TakesTheUniformMassWhenNoneIsStored) {
  std::vector<bool> stored(soa::particle_fields.size(), true);
  stored[at(soa::ParticleField::mass)] = false;
  soa::Table table(soa::particle_fields, soa::Precision::float64, stored);
  table.set_uniform(at(soa::ParticleField::mass), 0.125);
  table.append(33);
  EXPECT_EQ(diagnose(table, {}, Parallel(1)).mass, 33 * 0.125);
}

TEST(Diagnose, CountsThePotentialOfPointGravity) {
  models::ForceSettings forces;
  forces.gravity = {0, 0, 0};
  forces.point_gravity = {{{1, 2, 3}, 12, 0}, {{0, 0, 0}, 5, 4}};
  Particle p;
  p.position = {1, 2, 0};
  p.mass = 2;
  const Diagnostics d =
      diagnose(table_of_particles(soa::Precision::float64, {p}), forces, Parallel(1));
  // -m (GM/r + GM/sqrt(r^2 + softening^2)), r = 3 and sqrt 5
  EXPECT_NEAR(d.potential_energy, -2 * (12 / 3.0 + 5 / std::sqrt(5.0 + 16.0)), 1e-14);
}

TEST(Diagnose, OfNoParticlesHasNoBoundsAndNoCentre) {
  const Diagnostics d = diagnose(table_of_particles(soa::Precision::float32, {}), {}, Parallel(3));
  EXPECT_EQ(d.count, 0U);
  EXPECT_EQ(d.mass, 0);
  EXPECT_EQ(d.kinetic_energy, 0);
  EXPECT_EQ(d.max_speed, 0);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_TRUE(std::isnan(d.lowest[c]));
    EXPECT_TRUE(std::isnan(d.highest[c]));
    EXPECT_TRUE(std::isnan(d.center_of_mass[c]));
  }
}

TEST(Diagnose, GivesTheSameBitsForAnyNumberOfThreads) {
  std::vector<Particle> particles = whole_number_particles(65537);
  std::mt19937_64 random(11);
  for (Particle& p : particles) {  // no sum of these is exact
    p.mass *= 0.1 + static_cast<double>(random() >> 11) * 0x1p-53;
    p.velocity[1] /= 3;
  }
  const soa::Table table = table_of_particles(soa::Precision::float64, particles);
  const Diagnostics one = diagnose(table, {}, Parallel(1));
  for (const int threads : {2, 3, 4, 8, 13}) {
    const Diagnostics d = diagnose(table, {}, Parallel(threads));
    EXPECT_EQ(d.mass, one.mass) << threads;
    EXPECT_EQ(d.momentum, one.momentum) << threads;
    EXPECT_EQ(d.center_of_mass, one.center_of_mass) << threads;
    EXPECT_EQ(d.kinetic_energy, one.kinetic_energy) << threads;
    EXPECT_EQ(d.potential_energy, one.potential_energy) << threads;
    EXPECT_EQ(d.max_speed, one.max_speed) << threads;
  }
}

}  // namespace salvo::tests
