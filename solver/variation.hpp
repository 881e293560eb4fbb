// How an input of a sweep varies from row to row.
#pragma once

#include <vector>

namespace salvo::solver {

struct Variation {
  enum class Kind {
    constant,
    uniform,           ///< on [a, b]
    normal,            ///< mean a, standard deviation b
    truncated_normal,  ///< the same, within [lowest, highest]
    grid,              ///< an axis of a grid
    column             ///< of a table: a value a row of it
  };

  Kind kind = Kind::constant;
  double a = 0;
  double b = 0;
  double lowest = 0;
  double highest = 0;
  std::vector<double> values = {};  ///< of a grid or column
  std::vector<double> shifts = {};  ///< added at each point of the grid; none: nothing is

  static Variation of(double value) { return {Kind::constant, value, 0, 0, 0}; }
  bool random() const {
    return kind == Kind::uniform || kind == Kind::normal || kind == Kind::truncated_normal;
  }
  /// What it is where nothing varies: the mean of a distribution, the first of several values.
  double nominal() const;
};

/// The value of a random variation that a part `u` of all values, 0 < u < 1, lie below.
class Quantile {
 public:
  explicit Quantile(const Variation& variation);
  double operator()(double u) const;

 private:
  Variation::Kind kind_;
  double a_;
  double b_;
  double lowest_u_ = 0;
  double highest_u_ = 1;
};

/// Of the standard normal distribution, to about 1e-16.
double normal_quantile(double u);
/// Its reverse, of x within +-38.
double normal_probability(double x);

}  // namespace salvo::solver
