// Crossings of cubics with known roots, which the bracketing must find however close they are, and
// the dense output of the pairs.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "integrators/crossing.hpp"
#include "integrators/embedded_pair.hpp"
#include "kernels/dual.hpp"

namespace salvo::tests {

namespace {

using V = kernels::ScalarLane<double>;

struct Found {
  bool found;
  double place;
};

Found crossing(const integrators::QuantityOverStep<V>& q, bool falling, bool rising) {
  const auto bracket = first_bracket(q, falling, rising);
  // A crossing is never ruled out beforehand.
  EXPECT_TRUE(!bracket.found.value() || may_cross(q).value());
  return {bracket.found.value(), zero_in(q, bracket).value()};
}

// g(s) = a (s - r1) (s - r2) (s - r3), through its values and slopes at 0 and 1.
Found crossing(double a, double r1, double r2, double r3, bool falling, bool rising) {
  const auto g = [&](double s) { return a * (s - r1) * (s - r2) * (s - r3); };
  const auto slope = [&](double s) {
    return a * ((s - r2) * (s - r3) + (s - r1) * (s - r3) + (s - r1) * (s - r2));
  };
  return crossing({V(g(0)), V(slope(0)), V(g(1)), V(slope(1))}, falling, rising);
}

}  // namespace

TEST(Crossing, TwoWithinOneStepAreBothFound) {
  std::mt19937_64 random(7);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  for (int i = 0; i < 100000; ++i) {
    const double apart = std::exp(uniform(std::log(1e-3), std::log(0.5)));
    const double r1 = uniform(1e-3, 0.999 - apart);
    const double r2 = r1 + apart;
    const double r3 = uniform(0, 1) < 0.5 ? uniform(-9, -0.01) : uniform(1.01, 9);
    const double a = (r3 > 1 ? -1 : 1) * uniform(0.1, 100);  // falls at r1, rises at r2
    const Found down = crossing(a, r1, r2, r3, true, false);
    const Found up = crossing(a, r1, r2, r3, false, true);
    const Found first = crossing(a, r1, r2, r3, true, true);
    ASSERT_TRUE(down.found && up.found && first.found) << r1 << " " << r2 << " " << r3;
    ASSERT_NEAR(down.place, r1, 1e-9) << r1 << " " << r2 << " " << r3;
    ASSERT_NEAR(up.place, r2, 1e-9) << r1 << " " << r2 << " " << r3;
    ASSERT_EQ(first.place, down.place);
  }
}

TEST(Crossing, OfAStraightLineOrAParabolaIsFound) {
  const Found line = crossing({V(1), V(-4), V(-3), V(-4)}, true, false);
  EXPECT_TRUE(line.found);
  EXPECT_NEAR(line.place, 0.25, 1e-15);
  // g = (s - 1/4) (s - 1/2)
  const Found parabola = crossing({V(0.125), V(-0.75), V(0.375), V(1.25)}, false, true);
  EXPECT_TRUE(parabola.found);
  EXPECT_NEAR(parabola.place, 0.5, 1e-15);
}

TEST(Crossing, ThatAStepBeginsWithIsNotOne) {
  EXPECT_FALSE(crossing({V(0), V(1), V(1), V(1)}, true, true).found);
  EXPECT_FALSE(crossing({V(2), V(-1), V(1), V(-1)}, true, true).found);
}

// g = a ((s - r)^2 + d): touches zero at r when d is small enough, and only then.
TEST(Crossing, AnExtremumNearZeroIsAGraze) {
  std::mt19937_64 random(8);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  int grazes = 0;
  for (int i = 0; i < 100000; ++i) {
    const double r = uniform(0.01, 0.99);
    const double a = std::exp(uniform(-20, 20)) * (i % 2 == 0 ? 1 : -1);
    const double d = std::exp(uniform(std::log(1e-12), std::log(1e-6)));
    const integrators::QuantityOverStep<V> q{V(a * (r * r + d)), V(-2 * a * r),
                                             V(a * ((1 - r) * (1 - r) + d)), V(2 * a * (1 - r))};
    const double depth = std::abs(a) * d / q.scale().value();
    if (std::abs(depth - 1e-9) < 1e-14) continue;  // rounding may tell either
    const auto bracket = first_bracket(q, true, true);
    ASSERT_EQ(bracket.graze.value(), depth < 1e-9) << r << " " << a << " " << d;
    if (!bracket.graze.value()) continue;
    ++grazes;
    ASSERT_TRUE(may_cross(q).value());
    ASSERT_NEAR(bracket.graze_place.value(), r, 1e-6);
  }
  EXPECT_GT(grazes, 10000);
}

TEST(Dual, CarriesExactRates) {
  using D = kernels::Dual<V>;
  const double t = 0.7;
  const D x(V(t), V(1));
  EXPECT_NEAR((x * x * x).rate.value(), 3 * t * t, 1e-15);
  EXPECT_NEAR((D(1) / x).rate.value(), -1 / (t * t), 1e-15);
  EXPECT_NEAR(sqrt(x).rate.value(), 0.5 / std::sqrt(t), 1e-15);
  EXPECT_NEAR((sin(x) * cos(x)).rate.value(), std::cos(2 * t), 1e-15);
  EXPECT_NEAR((-(x - D(2) * x)).rate.value(), 1, 1e-15);
}

namespace {

template <const integrators::EmbeddedPair& pair>
double dense_error(double h) {
  const auto rate = [](V, const std::array<V, 2>& s) { return std::array<V, 2>{s[1], -s[0]}; };
  const std::array<V, 2> y{V(1), V(0)};
  integrators::Slopes<V, 2> k;
  k[0] = rate(V(0), y);
  integrators::pair_step<pair>(y, V(0), V(h), k, rate);
  double worst = 0;
  for (const double s : {0.1, 0.25, 0.5, 0.75, 0.9}) {
    const auto there = integrators::pair_dense<pair>(y, V(h), V(s), k);
    worst = std::max(
        worst, std::hypot(there[0].value() - std::cos(s * h), there[1].value() + std::sin(s * h)));
  }
  return worst;
}

template <const integrators::EmbeddedPair& pair>
void expect_dense_output() {
  EXPECT_NEAR(std::log2(dense_error<pair>(0.2) / dense_error<pair>(0.1)), 5, 0.3);  // order 4
  // It ends where the step does.
  const auto rate = [](V, const std::array<V, 1>& s) { return std::array<V, 1>{s[0]}; };
  integrators::Slopes<V, 1> k;
  const std::array<V, 1> y{V(1)};
  k[0] = rate(V(0), y);
  const auto end = integrators::pair_step<pair>(y, V(0), V(0.5), k, rate);
  EXPECT_NEAR(integrators::pair_dense<pair>(y, V(0.5), V(1), k)[0].value(), end[0].value(), 1e-14);
}

}  // namespace

TEST(EmbeddedPair, DenseOutputIsOfOrderFour) {
  expect_dense_output<integrators::dormand_prince_5>();
  expect_dense_output<integrators::tsitouras_5>();
}

}  // namespace salvo::tests
