// Distributions and samplings: quantiles against the error function, strata, the Sobol sequence
// against numbers of Boost's.
#include "solver/variation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "solver/sampling.hpp"

namespace salvo::solver {
namespace {

double probability(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

TEST(Variation, NormalQuantileIsTheReverseOfTheErrorFunction) {
  for (const double x : {-37.0, -20.0, -8.0, -5.5, -3.0, -1.5, -0.7, -1e-3, 0.0}) {
    const double u = probability(x);
    // The slope of the distribution decides what the last bit of u means for x.
    EXPECT_NEAR(normal_quantile(u), x, 1e-14 + 4e-15 * std::abs(x)) << x;
    EXPECT_NEAR(normal_probability(x) / u, 1, 1e-15 + 1e-15 * x * x) << x;
  }
  for (const double x : {0.3, 1.0, 2.0, 5.0}) {
    EXPECT_NEAR(normal_quantile(probability(x)), x, 1e-16 / (1 - probability(x)) + 1e-14);
    EXPECT_NEAR(normal_probability(x), probability(x), 1e-15);
  }
}

TEST(Variation, ATruncatedNormalStaysWithinAndKeepsItsShape) {
  const Quantile quantile({Variation::Kind::truncated_normal, 10, 2, 9, 15, {}});
  const double low = probability(-0.5);
  const double high = probability(2.5);
  for (const double u : {1e-12, 0.1, 0.5, 0.9, 1 - 1e-12}) {
    const double value = quantile(u);
    EXPECT_GE(value, 9);
    EXPECT_LE(value, 15);
    EXPECT_NEAR(probability((value - 10) / 2), low + (high - low) * u, 1e-13);
  }
}

TEST(Variation, ATruncatedNormalAboveTheMeanIsTheMirrorOfThatBelow) {
  const Quantile above({Variation::Kind::truncated_normal, 800, 5, 838, 842});
  const Quantile below({Variation::Kind::truncated_normal, 800, 5, 758, 762});
  double last = 0;
  for (double u = 0x1p-20; u < 1; u += 0x1p-10) {
    const double value = above(u);
    EXPECT_NEAR(value, 1600 - below(1 - u), 1e-11);
    EXPECT_GE(value, 838 - 1e-9);
    EXPECT_LE(value, 842 + 1e-9);
    EXPECT_GT(value, last);
    last = value;
  }
}

TEST(Variation, NominalIsTheMeanOrTheFirst) {
  using Kind = Variation::Kind;
  EXPECT_EQ(Variation::of(3).nominal(), 3);
  EXPECT_EQ((Variation{Kind::uniform, 2, 6, 0, 0, {}}).nominal(), 4);
  EXPECT_EQ((Variation{Kind::normal, 5, 1, 0, 0, {}}).nominal(), 5);
  EXPECT_EQ((Variation{Kind::grid, 0, 0, 0, 0, {7, 8}}).nominal(), 7);
}

TEST(Sampling, LatinHypercubeHasOneValueInEveryPart) {
  for (const std::uint64_t n : {1, 2, 3, 7, 64, 1000, 4097}) {
    const SampleLine line(Sampling::latin_hypercube, 5, "speed", 3, n);
    std::vector<int> taken(n, 0);
    for (std::uint64_t i = 0; i < n; ++i) {
      const double u = line(i);
      ASSERT_GT(u, 0);
      ASSERT_LT(u, 1);
      ++taken[static_cast<std::size_t>(u * static_cast<double>(n))];
    }
    EXPECT_EQ(std::count(taken.begin(), taken.end(), 1), static_cast<std::ptrdiff_t>(n)) << n;
  }
}

TEST(Sampling, LatinHypercubeInputsAreInDifferentOrders) {
  const SampleLine a(Sampling::latin_hypercube, 5, "speed", 3, 1000);
  const SampleLine b(Sampling::latin_hypercube, 5, "elevation", 4, 1000);
  double sum = 0;
  for (std::uint64_t i = 0; i < 1000; ++i) sum += (a(i) - 0.5) * (b(i) - 0.5);
  EXPECT_LT(std::abs(sum / 1000 * 12), 0.15);  // the correlation; 3 deviations are 0.095
}

// From boost::random::sobol_engine<std::uint64_t, 53>, whose first point is our second.
TEST(Sampling, SobolPointsAreThoseOfJoeAndKuo) {
  const double second[] = {0.75, 0.25, 0.25, 0.25, 0.75};
  const double fourth[] = {0.375, 0.375, 0.625, 0.875, 0.375};
  const double far[] = {0.64093017578125, 0.81341552734375, 0.16033935546875, 0.52679443359375,
                        0.88848876953125};
  for (std::size_t d = 0; d < 5; ++d) {
    EXPECT_EQ(sobol_point(d, 0), 0u);
    EXPECT_EQ(static_cast<double>(sobol_point(d, 1)) * 0x1p-53, 0.5);
    EXPECT_EQ(static_cast<double>(sobol_point(d, 2)) * 0x1p-53, second[d]);
    EXPECT_EQ(static_cast<double>(sobol_point(d, 4)) * 0x1p-53, fourth[d]);
    EXPECT_EQ(static_cast<double>(sobol_point(d, 12345)) * 0x1p-53, far[d]);
  }
  EXPECT_EQ(static_cast<double>(sobol_point(39, 12345)) * 0x1p-53, 0.94818115234375);
  EXPECT_EQ(static_cast<double>(sobol_point(31, 12345)) * 0x1p-53, 0.66204833984375);
}

TEST(Sampling, SobolFillsEveryDyadicPartOfAllDimensions) {
  for (std::size_t d = 0; d < SampleLine::most_dimensions; ++d) {
    const SampleLine line(Sampling::sobol, 9, "x", d, 1);
    std::vector<int> taken(256, 0);
    for (std::uint64_t i = 0; i < 256; ++i) ++taken[static_cast<std::size_t>(line(i) * 256)];
    EXPECT_EQ(std::count(taken.begin(), taken.end(), 1), 256) << d;
  }
}

TEST(Sampling, RandomNumbersAreUniform) {
  const SampleLine line(Sampling::random, 1, "speed", 3, 1);
  constexpr int n = 100'000;
  double sum = 0;
  double squares = 0;
  for (std::uint64_t i = 0; i < n; ++i) {
    const double u = line(i);
    sum += u;
    squares += u * u;
  }
  EXPECT_NEAR(sum / n, 0.5, 4 * std::sqrt(1.0 / 12 / n));
  EXPECT_NEAR(squares / n, 1.0 / 3, 4 * std::sqrt(4.0 / 45 / n));
}

TEST(Sampling, AnInputsNumbersAreItsOwn) {
  const SampleLine speed(Sampling::random, 1, "speed", 3, 10);
  const SampleLine same(Sampling::random, 1, "speed", 7, 99);
  const SampleLine other(Sampling::random, 1, "elevation", 3, 10);
  const SampleLine reseeded(Sampling::random, 2, "speed", 3, 10);
  EXPECT_EQ(speed(5), same(5));
  EXPECT_NE(speed(5), other(5));
  EXPECT_NE(speed(5), reseeded(5));
}

}  // namespace
}  // namespace salvo::solver
