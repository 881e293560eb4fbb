// The state hash against a second implementation, written here from the definition in
// solver/state_hash.hpp, and what it must and must not depend on.
#include "solver/state_hash.hpp"

#include <gtest/gtest.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <random>

#include "tests/solver/particles.hpp"

namespace salvo::tests {

namespace {

using solver::Digest;
using solver::Parallel;
using solver::state_hash;
using solver::StateHash;

using Bytes = std::vector<unsigned char>;

template <class Value>
void put(Bytes& bytes, Value value) {
  if constexpr (std::is_floating_point_v<Value>) {
    if (std::isnan(value)) value = std::numeric_limits<Value>::quiet_NaN();
  }
  unsigned char raw[sizeof(Value)];
  std::memcpy(raw, &value, sizeof value);
  bytes.insert(bytes.end(), raw, raw + sizeof value);
}

Digest digest(const Bytes& bytes) {
  const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
  return {hash.high64, hash.low64};
}

void put(Bytes& bytes, const Digest& digest) {
  put(bytes, digest.high);
  put(bytes, digest.low);
}

template <class T>
void put_field(Bytes& bytes, soa::ParticleField field, const Particle& p) {
  using F = soa::ParticleField;
  put(bytes, p.id);
  switch (field) {
    case F::id:
      return;
    case F::position:
      for (const double x : p.position) put(bytes, static_cast<T>(x));
      return;
    case F::velocity:
      for (const double v : p.velocity) put(bytes, static_cast<T>(v));
      return;
    case F::mass:
      return put(bytes, static_cast<T>(p.mass));
    case F::radius:
      return put(bytes, static_cast<T>(p.radius));
    case F::drag_area:
      return put(bytes, static_cast<T>(p.drag_area));
    case F::birth:
      return put(bytes, p.birth);
    case F::death:
      return put(bytes, p.death);
    case F::group:
      return put(bytes, p.group);
    case F::angular_velocity:
      for (const double w : p.angular_velocity) put(bytes, static_cast<T>(w));
      return;
    case F::residual:
      for (const double x : p.residual) put(bytes, static_cast<T>(x));
      return;
    case F::damping_loss:
      return put(bytes, static_cast<T>(p.damping_loss));
    case F::friction_loss:
      return put(bytes, static_cast<T>(p.friction_loss));
    case F::contact_impulse:
      for (const double i : p.contact_impulse) put(bytes, static_cast<T>(i));
      return;
  }
}

// For each field: leaves of 4096 consecutive serials of a stream; a digest of (stream, leaf,
// digest) over them; the total.
template <class T>
Digest total_by_definition(std::vector<Particle> particles) {
  std::sort(particles.begin(), particles.end(),
            [](const Particle& a, const Particle& b) { return a.id < b.id; });
  Bytes total;
  for (std::size_t f = 0; f < soa::particle_fields.size(); ++f) {
    std::map<std::pair<std::uint64_t, std::uint64_t>, Bytes> leaves;
    for (const Particle& p : particles) {
      put_field<T>(leaves[{p.id >> 40, (p.id & 0xFF'FFFF'FFFF) / 4096}],
                   static_cast<soa::ParticleField>(f), p);
    }
    Bytes column;
    for (const auto& [key, bytes] : leaves) {
      put(column, key.first);
      put(column, key.second);
      put(column, digest(bytes));
    }
    for (const char c : soa::particle_fields[f].name) put(total, c);
    put(total, '\0');
    put(total, digest(column));
  }
  return digest(total);
}

// Several streams with gaps, over the borders of leaves.
std::vector<Particle> scattered_particles(std::size_t count) {
  std::mt19937_64 random(5);
  const auto draw = [&] { return static_cast<double>(random() >> 11) * 0x1p-50 - 4; };
  std::vector<Particle> particles(count);
  for (std::size_t i = 0; i < count; ++i) {
    Particle& p = particles[i];
    p.id = soa::make_id(i % 3 == 0 ? 7 : 300 + i % 2, 5 * i + (i > count / 2 ? 1'000'000 : 0));
    p.position = {draw(), draw(), draw()};
    p.velocity = {draw(), draw(), draw()};
    p.mass = draw();
    p.radius = draw();
    p.drag_area = draw();
    p.birth = static_cast<std::int32_t>(i);
    p.death = static_cast<std::int32_t>(2 * i + 1);
    p.group = static_cast<std::uint32_t>(i % 5);
    p.angular_velocity = {draw(), draw(), draw()};
    p.residual = {draw(), draw(), draw()};
    p.damping_loss = draw();
    p.friction_loss = draw();
    p.contact_impulse = {draw(), draw(), draw()};
  }
  std::sort(particles.begin(), particles.end(),
            [](const Particle& a, const Particle& b) { return a.id < b.id; });
  return particles;
}

Digest total(const std::vector<Particle>& particles, int threads = 1,
             soa::Precision precision = soa::Precision::float64) {
  return state_hash(table_of_particles(precision, particles), Parallel(threads)).total;
}

double nan_with(std::uint64_t payload) {
  return std::bit_cast<double>(0x7FF8'0000'0000'0000 | payload);
}

}  // namespace

TEST(StateHash, IsTheDefinition) {
  for (const std::size_t count : {0, 1, 3, 65, 4097, 12345}) {
    const std::vector<Particle> particles = scattered_particles(count);
    EXPECT_EQ(total(particles), total_by_definition<double>(particles)) << count;
    EXPECT_EQ(total(particles, 1, soa::Precision::float32), total_by_definition<float>(particles))
        << count;
  }
}

TEST(StateHash, LeavesHoldConsecutiveSerialsNotRows) {
  // 4096 and 4097 lie on both sides of a border whatever rows they have.
  std::vector<Particle> particles(3);
  particles[0].id = 4095;
  particles[1].id = 4096;
  particles[2].id = 8191;
  EXPECT_EQ(total(particles), total_by_definition<double>(particles));
}

TEST(StateHash, DoesNotDependOnThreads) {
  const std::vector<Particle> particles = scattered_particles(12345);
  for (const int threads : {2, 3, 4, 8, 13}) {
    EXPECT_EQ(total(particles, threads), total(particles)) << threads;
  }
}

TEST(StateHash, DoesNotDependOnTheOrderInWhichRowsCame) {
  std::vector<Particle> particles = scattered_particles(4097);
  const Digest wanted = total(particles);
  std::mt19937_64 random(13);
  for (std::size_t i = particles.size(); i > 1; --i) {
    std::swap(particles[i - 1], particles[random() % i]);
  }
  soa::Table table = table_of_particles(soa::Precision::float64, particles);
  ASSERT_FALSE(table.sorted_by_id());
  table.sort_by_id();
  EXPECT_EQ(state_hash(table, Parallel(3)).total, wanted);
}

TEST(StateHash, SeesEveryFieldAndNamesIt) {
  const std::vector<Particle> particles = scattered_particles(65);
  const StateHash wanted =
      state_hash(table_of_particles(soa::Precision::float64, particles), Parallel(1));
  ASSERT_EQ(wanted.fields.size(), soa::particle_fields.size());
  const std::function<void(Particle&)> changes[] = {
      [](Particle& p) { p.id += 1; },
      [](Particle& p) { p.position[2] = std::nextafter(p.position[2], 9); },
      [](Particle& p) { p.velocity[0] = std::nextafter(p.velocity[0], 9); },
      [](Particle& p) { p.mass = std::nextafter(p.mass, 9); },
      [](Particle& p) { p.radius = std::nextafter(p.radius, 9); },
      [](Particle& p) { p.drag_area = std::nextafter(p.drag_area, 9); },
      [](Particle& p) { p.birth += 1; },
      [](Particle& p) { p.death += 1; },
      [](Particle& p) { p.group += 1; },
      [](Particle& p) { p.angular_velocity[1] += 1e-9; },
      [](Particle& p) { p.residual[2] += 1e-9; },
      [](Particle& p) { p.damping_loss += 1e-9; },
      [](Particle& p) { p.friction_loss += 1e-9; },
      [](Particle& p) { p.contact_impulse[2] += 1e-9; },
  };
  for (std::size_t f = 1; f < std::size(changes); ++f) {
    std::vector<Particle> changed = particles;
    changes[f](changed[33]);
    const StateHash hash =
        state_hash(table_of_particles(soa::Precision::float64, changed), Parallel(1));
    EXPECT_NE(hash.total, wanted.total) << soa::particle_fields[f].name;
    for (std::size_t g = 0; g < hash.fields.size(); ++g) {
      EXPECT_EQ(hash.fields[g].field, soa::particle_fields[g].name);
      EXPECT_EQ(hash.fields[g].digest == wanted.fields[g].digest, f != g)
          << soa::particle_fields[f].name << " against " << soa::particle_fields[g].name;
    }
  }
  std::vector<Particle> changed = particles;
  changes[0](changed[33]);
  EXPECT_NE(total(changed), wanted.total);
}

TEST(StateHash, KnowsOneNanAndTwoZeros) {
  std::vector<Particle> particles = scattered_particles(3);
  particles[1].velocity[1] = nan_with(0);
  const Digest wanted = total(particles);
  for (const std::uint64_t payload : {std::uint64_t{1}, std::uint64_t{0x8000'0000'0000'0123}}) {
    particles[1].velocity[1] = nan_with(payload);
    EXPECT_EQ(total(particles), wanted) << payload;
  }
  particles[1].velocity[1] = 0.0;
  const Digest zero = total(particles);
  particles[1].velocity[1] = -0.0;
  EXPECT_NE(total(particles), zero);
}

TEST(StateHash, IgnoresPadding) {
  const std::vector<Particle> particles = scattered_particles(65);
  soa::Table table = table_of_particles(soa::Precision::float64, particles);
  table.column<double>(at(soa::ParticleField::mass))[65] = 3;
  EXPECT_EQ(state_hash(table, Parallel(1)).total, total(particles));
}

TEST(Digest, TextGoesBothWays) {
  const Digest digest{0x0123'4567'89AB'CDEF, 0xFEDC'BA98'7654'3210};
  EXPECT_EQ(to_string(digest), "0123456789abcdeffedcba9876543210");
  EXPECT_EQ(solver::digest_from(to_string(digest)), digest);
  EXPECT_THROW(solver::digest_from("0123"), std::invalid_argument);
  EXPECT_THROW(solver::digest_from("0123456789abcdeffedcba987654321g"), std::invalid_argument);
}

// The first of XXH3's own test values: the digest of nothing with seed 0.
TEST(Digest, IsXxh3) {
  EXPECT_EQ(to_string(solver::digest_of(nullptr, 0)), "99aa06d3014798d86001c324468d497f");
}

}  // namespace salvo::tests
