// The counter-based random numbers: known answers, the key's layout, bounds, and distributions by
// moments and chi-square at a fixed seed. Bounds on statistics are five standard errors or more:
// with this seed they hold, and a wrong formula breaks them.
#include "kernels/random.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include "soa/id.hpp"

namespace salvo::tests {

namespace {

using kernels::Draws;
using kernels::Vec3;

constexpr std::uint64_t seed = 0x1234'5678'9ABC'DEF0;
constexpr int samples = 200'001;

struct Moments {
  double mean = 0;
  double variance = 0;
};

Moments moments(const std::function<double(soa::Id)>& draw) {
  long double sum = 0;
  long double squares = 0;
  for (int i = 0; i < samples; ++i) {
    const double x = draw(soa::make_id(3, static_cast<std::uint64_t>(i)));
    sum += x;
    squares += static_cast<long double>(x) * x;
  }
  const long double mean = sum / samples;
  return {static_cast<double>(mean), static_cast<double>(squares / samples - mean * mean)};
}

// Chi-square of draws on [0, 1) over equal cells, over its degrees of freedom; 1 on average,
// standard error sqrt(2/cells).
double chi_square(int cells, const std::function<double(soa::Id)>& unit) {
  std::vector<int> counts(static_cast<std::size_t>(cells));
  for (int i = 0; i < samples; ++i) {
    const double x = unit(soa::make_id(5, static_cast<std::uint64_t>(i)));
    ++counts.at(static_cast<std::size_t>(x * cells));
  }
  const double expected = static_cast<double>(samples) / cells;
  double sum = 0;
  for (const int count : counts) sum += (count - expected) * (count - expected) / expected;
  return sum / (cells - 1);
}

void expect_uniform(const char* what, const std::function<double(soa::Id)>& unit) {
  constexpr int cells = 101;
  EXPECT_NEAR(chi_square(cells, unit), 1, 5 * std::sqrt(2.0 / cells)) << what;
}

double length(Vec3<double> v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

}  // namespace

// Random123's kat_vectors, philox4x32 with 10 rounds.
TEST(Philox, GivesTheKnownAnswers) {
  using R = r123::Philox4x32;
  struct Vector {
    R::ctr_type counter;
    R::key_type key;
    R::ctr_type answer;
  };
  const Vector vectors[] = {
      {{{0, 0, 0, 0}}, {{0, 0}}, {{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}}},
      {{{0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}},
       {{0xffffffff, 0xffffffff}},
       {{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}}},
      {{{0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}},
       {{0xa4093822, 0x299f31d0}},
       {{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}}},
  };
  for (const Vector& vector : vectors) {
    const R::ctr_type answer = R()(vector.counter, vector.key);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(answer[i], vector.answer[i]);
  }
  const Draws::Block zero = Draws(0, 0).block(0);
  EXPECT_EQ(zero.first, 0xe169c58d6627e8d5);
  EXPECT_EQ(zero.second, 0x9b00dbd8bc57ac4c);
}

// Counter: id low, id high, draw, 0; key: seed low, seed high. Changing this changes every bit of
// every scene.
TEST(Philox, IsKeyedBySeedIdAndDraw) {
  const soa::Id id = soa::make_id(0xABCDE, 0x12'3456'7890);
  const Draws::Block block = Draws(seed, id).block(7);
  const auto answer = r123::Philox4x32()(
      {{static_cast<std::uint32_t>(id), static_cast<std::uint32_t>(id >> 32), 7, 0}},
      {{0x9ABCDEF0, 0x12345678}});
  EXPECT_EQ(block.first, answer[0] | std::uint64_t{answer[1]} << 32);
  EXPECT_EQ(block.second, answer[2] | std::uint64_t{answer[3]} << 32);
}

TEST(Uniform, FillsItsInterval) {
  expect_uniform("one draw of many ids", [](soa::Id id) { return Draws(seed, id).uniform(1); });
  expect_uniform("many draws of one id", [](soa::Id id) {
    return Draws(seed, 11).uniform(static_cast<std::uint32_t>(soa::serial_of(id)));
  });
  expect_uniform("many seeds", [](soa::Id id) { return Draws(soa::serial_of(id), 11).uniform(0); });
  const Moments m = moments([](soa::Id id) { return Draws(seed, id).uniform(2, -3, 9); });
  EXPECT_NEAR(m.mean, 3, 5 * std::sqrt(12.0 / samples));
  EXPECT_NEAR(m.variance, 12, 0.1);
}

TEST(Uniform, IsAMultipleOfTwoToTheMinus53BelowOne) {
  for (std::uint64_t serial = 0; serial < 999; ++serial) {
    const double x = Draws(seed, serial).uniform(0);
    ASSERT_GE(x, 0);
    ASSERT_LT(x, 1);
    ASSERT_EQ(std::ldexp(x, 53), std::floor(std::ldexp(x, 53)));
  }
}

TEST(Integer, IncludesBothEndsAndSharesEqually) {
  struct Range {
    std::int64_t low, high;
  };
  for (const Range range : {Range{37, 75}, Range{0, 1}, Range{-3, 3}, Range{5, 5}}) {
    std::map<std::int64_t, int> counts;
    for (int i = 0; i < samples; ++i) {
      ++counts[Draws(seed, static_cast<soa::Id>(i)).integer(3, range.low, range.high)];
    }
    const auto values = static_cast<std::size_t>(range.high - range.low + 1);
    EXPECT_EQ(counts.size(), values);
    EXPECT_EQ(counts.begin()->first, range.low);
    EXPECT_EQ(counts.rbegin()->first, range.high);
    const double expected = static_cast<double>(samples) / static_cast<double>(values);
    for (const auto& [value, count] : counts) {
      EXPECT_NEAR(count, expected, 5 * std::sqrt(expected)) << value;
    }
  }
}

TEST(Normal, HasMeanZeroVarianceOneAndTheRightTails) {
  const auto draw = [](soa::Id id) { return Draws(seed, id).normal(4); };
  const Moments m = moments(draw);
  EXPECT_NEAR(m.mean, 0, 5 / std::sqrt(static_cast<double>(samples)));
  EXPECT_NEAR(m.variance, 1, 5 * std::sqrt(2.0 / samples));
  expect_uniform("the normal's own distribution function", [&](soa::Id id) {
    return std::min(0.5 * std::erfc(-draw(id) / std::sqrt(2.0)), 1 - 1e-12);
  });
}

TEST(TruncatedNormal, StaysWithinItsBoundsAndKeepsItsShape) {
  constexpr double mean = 3;
  constexpr double width = 2;
  constexpr double low = 2;
  constexpr double high = 6;
  const auto cdf = [](double x) { return 0.5 * std::erfc(-(x - mean) / width / std::sqrt(2.0)); };
  expect_uniform("the truncated distribution function", [&](soa::Id id) {
    const double x = Draws(seed, id).truncated_normal(0, 16, mean, width, low, high);
    EXPECT_GE(x, low);
    EXPECT_LE(x, high);
    return std::min((cdf(x) - cdf(low)) / (cdf(high) - cdf(low)), 1 - 1e-12);
  });
}

TEST(TruncatedNormal, FallsBackToUniformFarFromTheMean) {
  for (std::uint64_t serial = 0; serial < 33; ++serial) {
    const Draws draws(seed, serial);
    const double x = draws.truncated_normal(0, 16, 0, 1, 20, 21);
    EXPECT_EQ(x, draws.uniform(0, 20, 21));
    EXPECT_GE(x, 20);
    EXPECT_LE(x, 21);
  }
}

// Archimedes: on the unit sphere every coordinate is uniform on [-1, 1], and so is the azimuth on
// its circle.
TEST(OnSphere, IsUniform) {
  const auto direction = [](soa::Id id) { return Draws(seed, id).on_sphere(0); };
  const auto unit = [](double cosine) { return std::min((cosine + 1) / 2, 1 - 1e-12); };
  expect_uniform("x", [&](soa::Id id) { return unit(direction(id).x); });
  expect_uniform("y", [&](soa::Id id) { return unit(direction(id).y); });
  expect_uniform("z", [&](soa::Id id) { return unit(direction(id).z); });
  for (soa::Id id = 0; id < 999; ++id) ASSERT_NEAR(length(direction(id)), 1, 1e-15);
}

TEST(InCone, IsUniformOnTheCapAboutAnyAxis) {
  const double s = std::sqrt(1.0 / 3.0);
  const Vec3<double> axes[] = {{0, 1, 0},       {0, -1, 0},    {1, 0, 0},
                               {0, 0, -1},      {s, -s, s},    {0.6, 0, 0.8},
                               {0, -0.8, -0.6}, {1e-9, -1, 0}, {1e-5, -std::sqrt(1 - 1e-10), 0}};
  for (const Vec3<double> axis : axes) {
    for (const double half_angle : {0.1, 1.0, 3.0}) {
      const double cap = 1 - std::cos(half_angle);
      // Two directions at right angles to the axis, to measure the azimuth in.
      Vec3<double> across =
          cross(axis, std::abs(axis.x) < 0.9 ? Vec3<double>{1, 0, 0} : Vec3<double>{0, 1, 0});
      across = across * (1 / length(across));
      const Vec3<double> third = cross(axis, across);
      const auto what = testing::Message() << "axis " << axis.x << " " << axis.y << " " << axis.z
                                           << ", half angle " << half_angle;
      SCOPED_TRACE(what);
      expect_uniform("height within the cap", [&](soa::Id id) {
        const Vec3<double> d = Draws(seed, id).in_cone(0, axis, half_angle);
        EXPECT_NEAR(length(d), 1, 1e-14);
        const double height = (1 - dot(d, axis)) / cap;
        EXPECT_LE(height, 1 + 1e-9);
        return std::clamp(height, 0.0, 1 - 1e-12);
      });
      expect_uniform("azimuth", [&](soa::Id id) {
        const Vec3<double> d = Draws(seed, id).in_cone(0, axis, half_angle);
        const double azimuth = std::atan2(dot(d, third), dot(d, across));
        return std::clamp(azimuth / (2 * kernels::pi) + 0.5, 0.0, 1 - 1e-12);
      });
    }
  }
}

TEST(InCone, OfNoAngleIsTheAxis) {
  const Vec3<double> axis{0.6, 0, 0.8};
  const Vec3<double> d = Draws(seed, 3).in_cone(0, axis, 0);
  EXPECT_NEAR(d.x, axis.x, 1e-15);
  EXPECT_NEAR(d.y, axis.y, 1e-15);
  EXPECT_NEAR(d.z, axis.z, 1e-15);
}

}  // namespace salvo::tests
