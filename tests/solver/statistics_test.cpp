// Statistics against straightforward ones over all values, and against exact distributions.
#include "solver/statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "solver/sampling.hpp"
#include "solver/variation.hpp"

namespace salvo::solver {
namespace {

using Columns = std::vector<std::vector<double>>;

// Columns in parts of a given length.
ColumnSource in_parts(const Columns& all, std::size_t length) {
  return [&all, length](std::span<const std::size_t> columns, const PartVisit& visit) {
    for (std::size_t first = 0; first < all[0].size(); first += length) {
      Columns part;
      for (const std::size_t column : columns) {
        const auto begin = all[column].begin() + static_cast<std::ptrdiff_t>(first);
        const auto end = all[column].begin() +
                         static_cast<std::ptrdiff_t>(std::min(first + length, all[column].size()));
        part.emplace_back(begin, end);
      }
      visit(part);
    }
  };
}

std::vector<double> normal_numbers(const char* name, std::size_t count, double mean, double width) {
  const SampleLine line(Sampling::random, 3, name, 0, 1);
  std::vector<double> numbers;
  for (std::size_t i = 0; i < count; ++i) {
    numbers.push_back(mean + width * normal_quantile(line(i)));
  }
  return numbers;
}

TEST(Statistics, MomentsAreThoseOfAllValues) {
  // A small spread on a large mean: sums of squares would lose it.
  const Columns all{normal_numbers("a", 10'007, 1e9, 1), normal_numbers("b", 10'007, -3, 0.1)};
  for (const std::size_t length : {1, 100, 4096, 20'000}) {
    const Statistics told = statistics({{0, 1}, {}, std::nullopt}, in_parts(all, length));
    for (std::size_t a = 0; a < 2; ++a) {
      long double sum = 0;
      for (const double x : all[a]) sum += x;
      const long double mean = sum / all[a].size();
      EXPECT_NEAR(told.moments.mean(a), static_cast<double>(mean), 1e-5);
      for (std::size_t b = 0; b < 2; ++b) {
        long double sum_b = 0;
        for (const double x : all[b]) sum_b += x;
        const long double mean_b = sum_b / all[b].size();
        long double moment = 0;
        for (std::size_t i = 0; i < all[a].size(); ++i) {
          moment += (all[a][i] - mean) * (all[b][i] - mean_b);
        }
        const auto exact = static_cast<double>(moment / (all[a].size() - 1));
        EXPECT_NEAR(told.moments.covariance(a, b), exact, 1e-7) << length;
      }
      EXPECT_EQ(told.moments.least(a), *std::min_element(all[a].begin(), all[a].end()));
      EXPECT_EQ(told.moments.greatest(a), *std::max_element(all[a].begin(), all[a].end()));
    }
  }
}

TEST(Statistics, QuantilesAreThoseOfTheSortedValues) {
  std::mt19937_64 random(4);
  const std::vector<double> parts{0, 0.01, 0.25, 0.5, 0.731, 0.99, 1};
  for (const std::size_t n : {1, 2, 3, 100, 5001}) {
    std::vector<double> values;
    for (std::size_t i = 0; i < n; ++i) {
      // Both signs, many sizes, many equal ones, zeros of both signs.
      const double size = std::exp2(static_cast<double>(random() % 600) - 300);
      const double value = i % 3 == 0 ? static_cast<double>(random() % 5) : size;
      values.push_back(random() % 2 == 0 ? value : -value);
    }
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    const std::vector<double> found =
        exact_quantiles(n, parts, [&](const std::function<void(double)>& visit) {
          for (const double value : values) visit(value);
        });
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const double place = parts[i] * static_cast<double>(n - 1);
      const auto below = static_cast<std::size_t>(place);
      const double low = sorted[below];
      const double high = sorted[std::min(below + 1, n - 1)];
      EXPECT_EQ(found[i], low + (high - low) * (place - static_cast<double>(below))) << n;
    }
  }
}

TEST(Statistics, CircularErrorOfARoundSpreadIsRayleighs) {
  constexpr std::size_t n = 200'000;
  const Columns all{normal_numbers("y", n, 0.3, 2), normal_numbers("z", n, -0.4, 2)};
  const Statistics told =
      statistics({{0}, {}, PlaneSettings{{0, 1}, {0, 0}, {{1.0, 1.0}}}}, in_parts(all, 65536));
  ASSERT_TRUE(told.plane);
  const std::array<double, 3> parts{0.5, 0.9, 0.95};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(told.plane->circular_error[i], 2 * std::sqrt(-2 * std::log(1 - parts[i])), 0.02);
    EXPECT_GT(told.plane->circular_error_of_aim[i], told.plane->circular_error[i]);
  }
  EXPECT_NEAR(told.plane->semi_axes[0], 2, 0.02);
  EXPECT_NEAR(told.plane->semi_axes[1], 2, 0.02);
  const auto side = [](double mean) {
    const auto probability = [](double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); };
    return probability((1 - mean) / 2) - probability((-1 - mean) / 2);
  };
  const double exact = side(0.3) * side(-0.4);
  EXPECT_NEAR(told.plane->hit_probability, exact, 4 * std::sqrt(exact / n));
  EXPECT_LT(told.plane->hit_interval[0], exact);
  EXPECT_GT(told.plane->hit_interval[1], exact);
}

TEST(Statistics, TheEllipseLiesAlongTheSpread) {
  // Three to one, turned by 30 degrees.
  constexpr std::size_t n = 100'000;
  const std::vector<double> u = normal_numbers("u", n, 0, 3);
  const std::vector<double> v = normal_numbers("v", n, 0, 1);
  Columns all(2);
  const double angle = M_PI / 6;
  for (std::size_t i = 0; i < n; ++i) {
    all[0].push_back(u[i] * std::cos(angle) - v[i] * std::sin(angle));
    all[1].push_back(u[i] * std::sin(angle) + v[i] * std::cos(angle));
  }
  const Statistics told =
      statistics({{0}, {}, PlaneSettings{{0, 1}, {0, 0}, {}}}, in_parts(all, 1000));
  EXPECT_NEAR(told.plane->semi_axes[0], 3, 0.03);
  EXPECT_NEAR(told.plane->semi_axes[1], 1, 0.01);
  EXPECT_NEAR(told.plane->angle, angle, 0.01);
}

TEST(Statistics, NothingCountsAndOneRowCounts) {
  const Columns none{{}, {}};
  const Statistics empty = statistics({{0}, {0.5}, PlaneSettings{}}, in_parts(none, 10));
  EXPECT_EQ(empty.moments.count(), 0u);
  EXPECT_TRUE(std::isnan(empty.quantiles[0][0]));
  EXPECT_FALSE(empty.plane);
  const Columns one{{2.5}, {1}};
  const Statistics single = statistics({{0}, {0.5}, PlaneSettings{}}, in_parts(one, 10));
  EXPECT_EQ(single.moments.mean(0), 2.5);
  EXPECT_TRUE(std::isnan(single.moments.deviation(0)));
  EXPECT_EQ(single.quantiles[0][0], 2.5);
  EXPECT_FALSE(single.plane);
}

TEST(Statistics, ANaNIsLeftOutOfItsColumnAlone) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::vector<double>> first{{1, 2, 3}, {none, 10, none}, {none, none, none}};
  const std::vector<std::vector<double>> second{{4, 6}, {14, 18}, {none, none}};
  Moments moments(3);
  moments.add_part(first);
  moments.add_part(second);
  EXPECT_EQ(moments.count(), 5U);
  EXPECT_EQ(moments.count(0), 5U);
  EXPECT_EQ(moments.count(1), 3U);
  EXPECT_EQ(moments.count(2), 0U);
  EXPECT_NEAR(moments.mean(0), 3.2, 1e-15);
  EXPECT_NEAR(moments.mean(1), 14, 1e-14);
  EXPECT_NEAR(moments.deviation(1), 4, 1e-14);
  EXPECT_EQ(moments.least(1), 10);
  EXPECT_TRUE(std::isnan(moments.covariance(0, 1)));
  EXPECT_TRUE(std::isnan(moments.mean(2)));
  EXPECT_TRUE(std::isnan(moments.greatest(2)));

  StatisticsSettings settings;
  settings.columns = {0, 1};
  settings.quantiles = {0.5};
  settings.plane = PlaneSettings{{0, 1}, {2, 10}, std::array<double, 2>{0.5, 0.5}};
  const Statistics all = statistics(settings, [&](auto columns, const PartVisit& visit) {
    for (const auto& part : {first, second}) {
      std::vector<std::vector<double>> chosen;
      for (const std::size_t column : columns) chosen.push_back(part[column]);
      visit(chosen);
    }
  });
  EXPECT_EQ(all.quantiles[1][0], 14);
  EXPECT_EQ(all.plane->count, 3U);
  EXPECT_EQ(all.plane->hits, 1U);
  EXPECT_EQ(all.plane->hit_probability, 1.0 / 3);
  EXPECT_NEAR(all.plane->mean[0], 4, 1e-15);
}

TEST(Statistics, HalfWidthIsThatOfTheNormalInterval) {
  const Columns all{normal_numbers("a", 10'000, 0, 2)};
  Moments moments(1);
  moments.add_part(all);
  EXPECT_NEAR(half_width_of_mean(moments, 0, 0.95), 1.959963984540054 * moments.deviation(0) / 100,
              1e-12);
}

}  // namespace
}  // namespace salvo::solver
