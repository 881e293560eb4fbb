#include "solver/statistics.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "kernels/math.hpp"
#include "solver/floating_point_environment.hpp"
#include "solver/variation.hpp"

namespace salvo::solver {

namespace {

using S = kernels::ScalarLane<double>;

double root(double x) { return sqrt(S(x)).value(); }

// Whole numbers in the order of the doubles.
std::uint64_t key_of(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  constexpr std::uint64_t sign = std::uint64_t{1} << 63;
  return (bits & sign) != 0 ? ~bits : bits | sign;
}
double value_of(std::uint64_t key) {
  constexpr std::uint64_t sign = std::uint64_t{1} << 63;
  return std::bit_cast<double>((key & sign) != 0 ? key & ~sign : ~key);
}

}  // namespace

Moments::Moments(std::size_t columns)
    : count_(columns, 0),
      mean_(columns, 0),
      moment_(columns * columns, 0),
      least_(columns, std::numeric_limits<double>::infinity()),
      greatest_(columns, -std::numeric_limits<double>::infinity()) {}

void Moments::add_part(std::span<const std::vector<double>> columns) {
  const std::size_t n = mean_.size();
  const std::size_t rows = n == 0 ? 0 : columns[0].size();
  if (rows == 0) return;
  std::vector<double> mean(n, 0);
  std::vector<std::uint64_t> there(n, 0);
  for (std::size_t a = 0; a < n; ++a) {
    // About the first value, so that a small spread on a large value keeps its digits.
    double first = 0;
    double sum = 0;
    for (const double value : columns[a]) {
      if (std::isnan(value)) continue;
      if (there[a]++ == 0) first = value;
      sum += value - first;
      least_[a] = std::min(least_[a], value);
      greatest_[a] = std::max(greatest_[a], value);
    }
    if (there[a] != 0) mean[a] = first + sum / static_cast<double>(there[a]);
  }
  // Merged as T. F. Chan, G. H. Golub and R. J. LeVeque do (Amer. Statist. 37, 1983).
  for (std::size_t a = 0; a < n; ++a) {
    if (there[a] == 0) continue;
    const auto before = static_cast<double>(count_[a]);
    const auto added = static_cast<double>(there[a]);
    const double weight = before * added / (before + added);
    for (std::size_t b = a; b < n; ++b) {
      double sum = 0;
      for (std::size_t row = 0; row < rows; ++row) {
        const double product = (columns[a][row] - mean[a]) * (columns[b][row] - mean[b]);
        if (a != b || !std::isnan(product)) sum += product;
      }
      moment_[a * n + b] += sum + (mean[a] - mean_[a]) * (mean[b] - mean_[b]) * weight;
    }
  }
  for (std::size_t a = 0; a < n; ++a) {
    if (there[a] == 0) continue;
    const auto before = static_cast<double>(count_[a]);
    const auto added = static_cast<double>(there[a]);
    mean_[a] += (mean[a] - mean_[a]) * (added / (before + added));
    count_[a] += there[a];
  }
  rows_ += rows;
}

double Moments::covariance(std::size_t a, std::size_t b) const {
  const std::size_t n = mean_.size();
  const double moment = moment_[std::min(a, b) * n + std::max(a, b)];
  const bool together = a == b || (count_[a] == rows_ && count_[b] == rows_);
  return count_[a] < 2 || !together ? std::numeric_limits<double>::quiet_NaN()
                                    : moment / static_cast<double>(count_[a] - 1);
}

double Moments::deviation(std::size_t column) const { return root(covariance(column, column)); }

double half_width_of_mean(const Moments& moments, std::size_t column, double confidence) {
  const double z = normal_quantile(0.5 + 0.5 * confidence);
  return z * moments.deviation(column) / root(static_cast<double>(moments.count(column)));
}

std::vector<double> exact_quantiles(
    std::uint64_t count, std::span<const double> p,
    const std::function<void(const std::function<void(double)>&)>& for_each_value) {
  if (count == 0) return std::vector<double>(p.size(), std::numeric_limits<double>::quiet_NaN());
  // The values of two ranks for each quantile, found 16 bits of their keys at a time.
  struct Rank {
    std::uint64_t rank;
    std::uint64_t prefix = 0;
  };
  std::vector<Rank> ranks;
  std::vector<double> parts;
  for (const double part : p) {
    const double place = part * static_cast<double>(count - 1);
    const double below = std::floor(place);
    const auto rank = std::min(static_cast<std::uint64_t>(below), count - 1);
    ranks.push_back({rank});
    ranks.push_back({std::min(rank + 1, count - 1)});
    parts.push_back(place - below);
  }
  for (int shift = 48; shift >= 0; shift -= 16) {
    std::vector<std::uint64_t> prefixes;
    prefixes.reserve(ranks.size());
    for (const Rank& rank : ranks) prefixes.push_back(rank.prefix);
    std::stable_sort(prefixes.begin(), prefixes.end());
    prefixes.erase(std::unique(prefixes.begin(), prefixes.end()), prefixes.end());
    std::vector<std::vector<std::uint64_t>> counts(prefixes.size(),
                                                   std::vector<std::uint64_t>(65536));
    for_each_value([&](double value) {
      const std::uint64_t key = key_of(value);
      const std::uint64_t prefix = shift == 48 ? 0 : key >> (shift + 16);
      const auto at = std::lower_bound(prefixes.begin(), prefixes.end(), prefix);
      if (at == prefixes.end() || *at != prefix) return;
      ++counts[static_cast<std::size_t>(at - prefixes.begin())][key >> shift & 0xffff];
    });
    for (Rank& rank : ranks) {
      const auto at = std::lower_bound(prefixes.begin(), prefixes.end(), rank.prefix);
      const auto& histogram = counts[static_cast<std::size_t>(at - prefixes.begin())];
      std::uint64_t digit = 0;
      while (rank.rank >= histogram[digit]) rank.rank -= histogram[digit++];
      rank.prefix = rank.prefix << 16 | digit;
    }
  }
  std::vector<double> values;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double low = value_of(ranks[2 * i].prefix);
    const double high = value_of(ranks[2 * i + 1].prefix);
    values.push_back(low + (high - low) * parts[i]);
  }
  return values;
}

namespace {

constexpr std::array<double, 3> circular_parts{0.5, 0.9, 0.95};

PlaneStatistics plane_statistics(const PlaneSettings& settings, const ColumnSource& all) {
  // Rows that have both columns.
  const ColumnSource source = [&](std::span<const std::size_t> chosen, const PartVisit& visit) {
    all(chosen, [&](std::span<const std::vector<double>> columns) {
      std::array<std::vector<double>, 2> there;
      for (std::size_t row = 0; row < columns[0].size(); ++row) {
        if (std::isnan(columns[0][row]) || std::isnan(columns[1][row])) continue;
        for (std::size_t c = 0; c < 2; ++c) there[c].push_back(columns[c][row]);
      }
      visit(there);
    });
  };
  const auto for_each = [&](auto&& visit) {
    source(settings.columns, [&](std::span<const std::vector<double>> columns) {
      for (std::size_t row = 0; row < columns[0].size(); ++row) {
        visit(columns[0][row], columns[1][row]);
      }
    });
  };
  Moments moments(2);
  source(settings.columns, [&](auto columns) { moments.add_part(columns); });
  PlaneStatistics result;
  result.count = moments.count();
  if (result.count < 2) return result;
  result.mean = {moments.mean(0), moments.mean(1)};

  const double aa = moments.covariance(0, 0);
  const double ab = moments.covariance(0, 1);
  const double bb = moments.covariance(1, 1);
  const double half = 0.5 * (aa - bb);
  const double radius = root(half * half + ab * ab);
  const double larger = 0.5 * (aa + bb) + radius;
  const double smaller = larger > 0 ? (aa * bb - ab * ab) / larger : 0;
  result.semi_axes = {root(larger), root(std::max(smaller, 0.0))};
  result.angle = 0.5 * atan2(S(ab), S(half)).value();

  const auto circular_error = [&](const std::array<double, 2>& center) {
    const std::vector<double> radii = exact_quantiles(
        moments.count(), circular_parts, [&](const std::function<void(double)>& visit) {
          for_each([&](double a, double b) {
            const double da = a - center[0];
            const double db = b - center[1];
            visit(root(da * da + db * db));
          });
        });
    return std::array<double, 3>{radii[0], radii[1], radii[2]};
  };
  result.circular_error = circular_error(result.mean);
  result.circular_error_of_aim = circular_error(settings.aim);

  if (settings.half_sizes) {
    for_each([&](double a, double b) {
      const bool hit = std::abs(a - settings.aim[0]) <= (*settings.half_sizes)[0] &&
                       std::abs(b - settings.aim[1]) <= (*settings.half_sizes)[1];
      result.hits += hit ? 1 : 0;
    });
    constexpr double z = 1.959963984540054;
    const auto n = static_cast<double>(result.count);
    const double p = static_cast<double>(result.hits) / n;
    const double center = (p + z * z / (2 * n)) / (1 + z * z / n);
    const double width = z / (1 + z * z / n) * root(p * (1 - p) / n + z * z / (4 * n * n));
    result.hit_probability = p;
    result.hit_interval = {std::max(0.0, center - width), std::min(1.0, center + width)};
  }
  return result;
}

}  // namespace

Statistics statistics(const StatisticsSettings& settings, const ColumnSource& source) {
  const FloatingPointEnvironment environment;
  Statistics result;
  result.moments = Moments(settings.columns.size());
  source(settings.columns, [&](auto columns) { result.moments.add_part(columns); });
  for (const std::size_t column : settings.columns) {
    const std::uint64_t count = result.moments.count(result.quantiles.size());
    result.quantiles.push_back(
        exact_quantiles(count, settings.quantiles, [&](const std::function<void(double)>& visit) {
          source(std::span(&column, 1), [&](std::span<const std::vector<double>> columns) {
            for (const double value : columns[0]) {
              if (!std::isnan(value)) visit(value);
            }
          });
        }));
  }
  if (settings.plane) {
    const PlaneStatistics plane = plane_statistics(*settings.plane, source);
    if (plane.count >= 2) result.plane = plane;
  }
  return result;
}

}  // namespace salvo::solver
