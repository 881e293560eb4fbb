// The transcendental functions over their whole range: the same bits on every instruction set, and
// errors against MPFR.
#include <gtest/gtest.h>
#include <mpfr.h>

#include <cmath>
#include <functional>
#include <ios>

#include "kernels/math.hpp"
#include "tests/kernels/math_functions.hpp"
#include "tests/kernels/values.hpp"
#include "tests/per_isa.hpp"

namespace salvo::tests {

namespace math_functions {
SALVO_TEST_TABLES
}

namespace {

using math_functions::Function;

using Unary = int (*)(mpfr_ptr, mpfr_srcptr, mpfr_rnd_t);
using Binary = int (*)(mpfr_ptr, mpfr_srcptr, mpfr_srcptr, mpfr_rnd_t);

// Where a function is tried besides random bit patterns: x in [low, high], y in [y_low, y_high].
// The exponential ones reach 8 times as far in double.
struct Case {
  Function function;
  const char* name;
  Unary unary;
  Binary binary;
  double low, high;
  double y_low = 0, y_high = 0;
  bool exponential = false;
  /// The largest |x| that SLEEF keeps finite where it overflows before it must; kernels/math.hpp
  /// lists them.
  double last_single = std::numeric_limits<double>::infinity();
  double last_double = std::numeric_limits<double>::infinity();
};

const Case cases[] = {
    {Function::sin, "sin", mpfr_sin, nullptr, -20, 20},
    {Function::cos, "cos", mpfr_cos, nullptr, -20, 20},
    {Function::tan, "tan", mpfr_tan, nullptr, -20, 20},
    {Function::asin, "asin", mpfr_asin, nullptr, -1, 1},
    {Function::acos, "acos", mpfr_acos, nullptr, -1, 1},
    {Function::atan, "atan", mpfr_atan, nullptr, -9, 9},
    {Function::sinh, "sinh", mpfr_sinh, nullptr, -90, 90, 0, 0, true, 88.72283, 709.782712893383},
    {Function::cosh, "cosh", mpfr_cosh, nullptr, -90, 90, 0, 0, true, 88.72283, 709.782712893383},
    {Function::tanh, "tanh", mpfr_tanh, nullptr, -25, 25},
    {Function::exp, "exp", mpfr_exp, nullptr, -94, 90, 0, 0, true,
     std::numeric_limits<double>::infinity(), 709.782711149557},
    {Function::expm1, "expm1", mpfr_expm1, nullptr, -30, 90, 0, 0, true},
    {Function::log, "log", mpfr_log, nullptr, 0, 5},
    {Function::log1p, "log1p", mpfr_log1p, nullptr, -1, 5, 0, 0, false, 1e38, 1e307},
    {Function::log10, "log10", mpfr_log10, nullptr, 0, 5},
    {Function::cbrt, "cbrt", mpfr_cbrt, nullptr, -30, 30},
    {Function::pow, "pow", nullptr, mpfr_pow, 0, 100, -15, 15},
    {Function::atan2, "atan2", nullptr, mpfr_atan2, -9, 9, -9, 9},
};

constexpr std::size_t arguments = 100'032;  // a multiple of 64

template <class T>
struct Arguments {
  AlignedVector<T> x, y;

  // Three in a row: any bit pattern, one of the case's interval, one of ordinary size; special
  // values first.
  explicit Arguments(const Case& c) {
    std::mt19937_64 random(3);
    const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    const auto any = [&] { return std::bit_cast<T>(static_cast<BitsOf<T>>(random())); };
    const auto within = [&](double low, double high) {
      return static_cast<T>(low + (high - low) * unit());
    };
    const double scale = c.exponential && sizeof(T) == 8 ? 8 : 1;
    const std::vector<T> special = special_values<T>();
    for (std::size_t i = 0; i < special.size(); ++i) {
      x.push_back(special[i]);
      y.push_back(special[37 * i % special.size()]);
    }
    while (x.size() < arguments) {
      x.push_back(any());
      y.push_back(any());
      x.push_back(within(scale * c.low, scale * c.high));
      y.push_back(within(c.y_low, c.y_high));
      x.push_back(within(0, 1) * within(0, 1) * within(-2, 2));
      y.push_back(within(0, 1) * within(-2, 2));
    }
    x.resize(arguments);
    y.resize(arguments);
  }
};

template <class T>
void apply(solver::Isa isa, Function function, const Arguments<T>& in, AlignedVector<T>& out) {
  out.resize(in.x.size());
  const math_functions::Table& table = math_functions::table_of(isa);
  if constexpr (sizeof(T) == 4) {
    table.single.apply(function, in.x.data(), in.y.data(), out.data(), out.size());
  } else {
    table.twice.apply(function, in.x.data(), in.y.data(), out.data(), out.size());
  }
}

// The distance of a result from the exact value in units of the last place of the exact value's
// binade.
template <class T>
class UlpMeter {
 public:
  UlpMeter() {
    for (auto* number : {&x_, &y_, &exact_, &error_}) mpfr_init2(*number, 100);
  }
  ~UlpMeter() {
    for (auto* number : {&x_, &y_, &exact_, &error_}) mpfr_clear(*number);
  }
  UlpMeter(const UlpMeter&) = delete;
  UlpMeter& operator=(const UlpMeter&) = delete;

  double operator()(const Case& c, T x, T y, T got) {
    using Limits = std::numeric_limits<T>;
    mpfr_set_d(x_, static_cast<double>(x), MPFR_RNDN);
    mpfr_set_d(y_, static_cast<double>(y), MPFR_RNDN);
    if (c.unary) {
      c.unary(exact_, x_, MPFR_RNDN);
    } else {
      c.binary(exact_, x_, y_, MPFR_RNDN);
    }
    constexpr double infinity = std::numeric_limits<double>::infinity();
    if (mpfr_nan_p(exact_) != 0) return std::isnan(got) ? 0 : infinity;
    if (std::isnan(got)) return infinity;
    if (mpfr_zero_p(exact_) != 0) return got == 0 ? 0 : infinity;
    if (mpfr_inf_p(exact_) != 0) {
      return std::isinf(got) && std::signbit(got) == (mpfr_sgn(exact_) < 0) ? 0 : infinity;
    }
    // A value past the end of the range stands at the first number that is not in the format, so
    // that overflowing a little early counts what it is; far beyond, infinity is the right answer.
    long exponent = mpfr_get_exp(exact_);
    if (exponent > Limits::max_exponent) {
      if (std::isinf(got)) return std::signbit(got) == (mpfr_sgn(exact_) < 0) ? 0 : infinity;
      exponent = Limits::max_exponent;
    }
    const long lowest = Limits::min_exponent - 1;
    const long last_place = std::max(exponent - 1, lowest) - (Limits::digits - 1);
    if (std::isinf(got)) {
      mpfr_set_si_2exp(error_, std::signbit(got) ? -1 : 1, Limits::max_exponent, MPFR_RNDN);
    } else {
      mpfr_set_d(error_, static_cast<double>(got), MPFR_RNDN);
    }
    mpfr_sub(error_, error_, exact_, MPFR_RNDN);
    mpfr_mul_2si(error_, error_, -last_place, MPFR_RNDN);
    return std::abs(mpfr_get_d(error_, MPFR_RNDN));
  }

 private:
  mpfr_t x_, y_, exact_, error_;
};

template <class T>
class Math : public testing::Test {};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(Math, Reals);

}  // namespace

TYPED_TEST(Math, EveryInstructionSetIsScalar) {
  using T = TypeParam;
  AlignedVector<T> wanted;
  AlignedVector<T> got;
  for (const Case& c : cases) {
    const Arguments<T> in(c);
    apply(solver::Isa::scalar, c.function, in, wanted);
    for (const solver::Isa isa : solver::available_isas()) {
      apply(isa, c.function, in, got);
      for (std::size_t i = 0; i < got.size(); ++i) {
        ASSERT_EQ(canonical_bits(got[i]), canonical_bits(wanted[i]))
            << c.name << "(" << in.x[i] << ", " << in.y[i] << ") on " << name(isa);
      }
    }
  }
}

// Two exceptions: tanh of a tiny argument is its neighbour, which is x^2/3 ulp more than one away;
// and results of atan2 near the smallest normal number lose their tail to the denormals.
TYPED_TEST(Math, ErrorsStayWithinOneUlp) {
  using T = TypeParam;
  UlpMeter<T> ulps;
  AlignedVector<T> got;
  for (const Case& c : cases) {
    const Arguments<T> in(c);
    apply(solver::Isa::scalar, c.function, in, got);
    double worst = 0;
    std::size_t where = 0;
    using Limits = std::numeric_limits<T>;
    constexpr T near_denormal = Limits::min() / Limits::epsilon();
    const double last = sizeof(T) == 4 ? c.last_single : c.last_double;
    for (std::size_t i = 0; i < got.size(); ++i) {
      if (std::isinf(got[i]) && std::abs(static_cast<double>(in.x[i])) > last) continue;
      if (c.function == Function::atan2 && std::abs(got[i]) < near_denormal) {
        ASSERT_LE(ulps(c, in.x[i], in.y[i], got[i]), 1.5) << in.x[i] << ", " << in.y[i];
        continue;
      }
      const double error = ulps(c, in.x[i], in.y[i], got[i]);
      if (error > worst) {
        worst = error;
        where = i;
      }
    }
    testing::Test::RecordProperty(c.name, std::to_string(worst));
    EXPECT_LE(worst, 1.0000001) << c.name << "(" << std::hexfloat << in.x[where] << ", "
                                << in.y[where] << ") = " << got[where];
  }
}

TEST(Power, IsRepeatedMultiplicationInOrder) {
  using S = kernels::ScalarLane<float>;
  for (const float x : {0.0F, -1.5F, 0.1F, 3.7F}) {
    float product = 1;
    for (int n = 0; n < 9; ++n) {
      EXPECT_EQ(kernels::power(S(x), n).value(), product) << x << "^" << n;
      product *= x;
    }
  }
}

}  // namespace salvo::tests
