// Statistics of a sweep's rows: moments, covariance, quantiles, circular error, dispersion ellipse
// and hits. They are functions of the rows in index order: sums run within parts of
// Sweep::part_rows, and parts are merged in order; quantiles are exact, by further passes over the
// columns, so that memory does not grow with the rows.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace salvo::solver {

/// Columns of the rows that count, a part at a time: calls `visit` with the chosen columns of each
/// part, in order.
using PartVisit = std::function<void(std::span<const std::vector<double>> columns)>;
using ColumnSource =
    std::function<void(std::span<const std::size_t> columns, const PartVisit& visit)>;

/// Count, means and co-moments of several columns, part by part. A NaN is left out, as where an
/// event did not happen: each column has a count of its own, and where that is zero no moments.
class Moments {
 public:
  explicit Moments(std::size_t columns);
  void add_part(std::span<const std::vector<double>> columns);

  std::uint64_t count() const { return rows_; }  ///< of rows
  std::uint64_t count(std::size_t column) const { return count_[column]; }
  double mean(std::size_t column) const { return if_any(column, mean_); }
  /// Of the sample (n - 1); NaN below two rows, and of two columns with NaNs.
  double covariance(std::size_t a, std::size_t b) const;
  double deviation(std::size_t column) const;
  double least(std::size_t column) const { return if_any(column, least_); }
  double greatest(std::size_t column) const { return if_any(column, greatest_); }

 private:
  double if_any(std::size_t column, const std::vector<double>& values) const {
    return count_[column] == 0 ? std::numeric_limits<double>::quiet_NaN() : values[column];
  }

  std::uint64_t rows_ = 0;
  std::vector<std::uint64_t> count_;
  std::vector<double> mean_;
  std::vector<double> moment_;  // of columns a and b: a * columns + b
  std::vector<double> least_;
  std::vector<double> greatest_;
};

/// Half the confidence interval of a column's mean, of independent rows.
double half_width_of_mean(const Moments& moments, std::size_t column, double confidence);

/// The values that parts `p` of a column's `count` values lie below: between the two nearest in
/// order, linearly, as NumPy's default. Four passes.
std::vector<double> exact_quantiles(
    std::uint64_t count, std::span<const double> p,
    const std::function<void(const std::function<void(double)>&)>& for_each_value);

/// Where trajectories come through a plane, such as the y and z at a range.
struct PlaneSettings {
  std::array<std::size_t, 2> columns{};
  std::array<double, 2> aim{};                      ///< point that is aimed at
  std::optional<std::array<double, 2>> half_sizes;  ///< of a target about it
};

struct PlaneStatistics {
  std::uint64_t count = 0;  ///< rows that have both columns
  std::array<double, 2> mean{};
  std::array<double, 2> semi_axes{};  ///< of the ellipse of one standard deviation, longer first
  double angle = 0;                   ///< rad, of the longer from the first column's axis
  /// Radius about the mean point, and about the aim, within which 50, 90 and 95 % come through.
  std::array<double, 3> circular_error{};
  std::array<double, 3> circular_error_of_aim{};
  std::uint64_t hits = 0;
  double hit_probability = 0;
  std::array<double, 2> hit_interval{};  ///< Wilson's, of 95 % confidence
};

struct StatisticsSettings {
  std::vector<std::size_t> columns;
  std::vector<double> quantiles{0.05, 0.5, 0.95};
  std::optional<PlaneSettings> plane;
};

struct Statistics {
  Moments moments{0};                          ///< of the columns
  std::vector<std::vector<double>> quantiles;  ///< by column
  std::optional<PlaneStatistics> plane;        ///< with at least two rows
};

Statistics statistics(const StatisticsSettings& settings, const ColumnSource& source);

}  // namespace salvo::solver
