// A function of one variable as cubics on equal intervals: interval i is c0 + c1 u + c2 u^2 + c3
// u^3, u from 0 to 1 across it.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace salvo::soa {

template <class T>
class CubicTable {
 public:
  CubicTable() = default;
  CubicTable(double first, double interval)
      : first_(static_cast<T>(first)), per_interval_(static_cast<T>(1 / interval)) {}

  /// Appends an interval: values and slopes (over the whole interval) at both ends.
  void append(double left, double left_slope, double right, double right_slope) {
    const double coefficients[4] = {left, left_slope,
                                    3 * (right - left) - 2 * left_slope - right_slope,
                                    2 * (left - right) + left_slope + right_slope};
    for (const double c : coefficients) coefficients_.push_back(static_cast<T>(c));
  }

  T first() const { return first_; }
  T per_interval() const { return per_interval_; }
  std::size_t intervals() const { return coefficients_.size() / 4; }
  /// 4 an interval.
  const T* coefficients() const { return coefficients_.data(); }

 private:
  T first_ = 0;
  T per_interval_ = 1;
  std::vector<T> coefficients_;
};

}  // namespace salvo::soa
