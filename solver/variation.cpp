// The normal quantile is Wichura's PPND16: M. J. Wichura, "Algorithm AS 241: The percentage points
// of the normal distribution", Applied Statistics 37 (1988).
#include "solver/variation.hpp"

#include <array>
#include <cmath>

#include "kernels/math.hpp"

namespace salvo::solver {

namespace {

using S = kernels::ScalarLane<double>;
using Coefficients = std::array<double, 8>;  // of ascending powers

double polynomial(const Coefficients& c, double x) {
  double sum = c[7];
  for (std::size_t i = 7; i-- > 0;) sum = sum * x + c[i];
  return sum;
}

constexpr Coefficients a{3.3871328727963666080e0,  1.3314166789178437745e+2,
                         1.9715909503065514427e+3, 1.3731693765509461125e+4,
                         4.5921953931549871457e+4, 6.7265770927008700853e+4,
                         3.3430575583588128105e+4, 2.5090809287301226727e+3};
constexpr Coefficients b{1,
                         4.2313330701600911252e+1,
                         6.8718700749205790830e+2,
                         5.3941960214247511077e+3,
                         2.1213794301586595867e+4,
                         3.9307895800092710610e+4,
                         2.8729085735721942674e+4,
                         5.2264952788528545610e+3};
constexpr Coefficients c{1.42343711074968357734e0,  4.63033784615654529590e0,
                         5.76949722146069140550e0,  3.64784832476320460504e0,
                         1.27045825245236838258e0,  2.41780725177450611770e-1,
                         2.27238449892691845833e-2, 7.74545014278341407640e-4};
constexpr Coefficients d{1,
                         2.05319162663775882187e0,
                         1.67638483018380384940e0,
                         6.89767334985100004550e-1,
                         1.48103976427480074590e-1,
                         1.51986665636164571966e-2,
                         5.47593808499534494600e-4,
                         1.05075007164441684324e-9};
constexpr Coefficients e{6.65790464350110377720e0,  5.46378491116411436990e0,
                         1.78482653991729133580e0,  2.96560571828504891230e-1,
                         2.65321895265761230930e-2, 1.24266094738807843860e-3,
                         2.71155556874348757815e-5, 2.01033439929228813265e-7};
constexpr Coefficients f{1,
                         5.99832206555887937690e-1,
                         1.36929880922735805310e-1,
                         1.48753612908506148525e-2,
                         7.86869131145613259100e-4,
                         1.84631831751005468180e-5,
                         1.42151175831644588870e-7,
                         2.04426310338993978564e-15};

}  // namespace

double normal_quantile(double u) {
  const double q = u - 0.5;
  if (std::abs(q) <= 0.425) {
    const double r = 0.180625 - q * q;
    return q * polynomial(a, r) / polynomial(b, r);
  }
  const double tail = q < 0 ? u : 1 - u;
  const double r = sqrt(-log(S(tail))).value();
  const double x = r <= 5 ? polynomial(c, r - 1.6) / polynomial(d, r - 1.6)
                          : polynomial(e, r - 5) / polynomial(f, r - 5);
  return q < 0 ? -x : x;
}

double normal_probability(double x) {
  if (x > 0) return 1 - normal_probability(-x);
  // By bisection of the exponent and the digits: the quantile rises.
  double low = 1e-300;
  double high = 0.5;
  for (int i = 0; i < 1100 && low < high; ++i) {
    const double middle =
        high > 4 * low ? (sqrt(S(low)) * sqrt(S(high))).value() : 0.5 * (low + high);
    if (middle <= low || middle >= high) break;
    (normal_quantile(middle) < x ? low : high) = middle;
  }
  return high;
}

double Variation::nominal() const {
  switch (kind) {
    case Kind::uniform:
      return 0.5 * (a + b);
    case Kind::grid:
    case Kind::column:
      return values.front();
    case Kind::constant:
    case Kind::normal:
    case Kind::truncated_normal:
      break;
  }
  return a;
}

Quantile::Quantile(const Variation& variation)
    : kind_(variation.kind), a_(variation.a), b_(variation.b) {
  if (kind_ != Variation::Kind::truncated_normal) return;
  // Parts near one have no digits left: an interval above the mean is that below it, mirrored.
  const double side = variation.lowest > a_ ? -1 : 1;
  lowest_u_ = normal_probability(side * (variation.lowest - a_) / b_);
  highest_u_ = normal_probability(side * (variation.highest - a_) / b_);
}

double Quantile::operator()(double u) const {
  if (kind_ == Variation::Kind::uniform) return a_ + (b_ - a_) * u;
  const double part = lowest_u_ + (highest_u_ - lowest_u_) * u;
  const double deviations = normal_quantile(part);
  return lowest_u_ > highest_u_ ? a_ - b_ * deviations : a_ + b_ * deviations;
}

}  // namespace salvo::solver
