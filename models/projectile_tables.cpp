#include "models/projectile_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "models/drag_functions.hpp"
#include "models/standard_atmosphere.hpp"

namespace salvo::models {

namespace {

// A cubic over each interval between two points: slopes at its ends.
struct Piece {
  double left;
  double right;
};

// Pieces of the monotone cubic through points (Fritsch and Carlson 1980, with the three-point ends
// of Fritsch and Butland): no overshoot between the points.
std::vector<Piece> monotone_pieces(std::span<const DragPoint> points) {
  const std::size_t n = points.size();
  std::vector<double> h(n - 1);
  std::vector<double> d(n - 1);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    h[i] = points[i + 1].mach - points[i].mach;
    d[i] = (points[i + 1].cd - points[i].cd) / h[i];
  }
  std::vector<double> slopes(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    if (d[i - 1] * d[i] <= 0) continue;
    const double w1 = 2 * h[i] + h[i - 1];
    const double w2 = h[i] + 2 * h[i - 1];
    slopes[i] = (w1 + w2) / (w1 / d[i - 1] + w2 / d[i]);
  }
  const auto end = [](double h0, double h1, double d0, double d1) {
    const double slope = ((2 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
    if (slope * d0 <= 0) return 0.0;
    if (d0 * d1 <= 0 && std::abs(slope) > 3 * std::abs(d0)) return 3 * d0;
    return slope;
  };
  slopes[0] = end(h[0], h[1], d[0], d[1]);
  slopes[n - 1] = end(h[n - 2], h[n - 3], d[n - 2], d[n - 3]);
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i + 1 < n; ++i) pieces.push_back({slopes[i], slopes[i + 1]});
  return pieces;
}

std::vector<Piece> linear_pieces(std::span<const DragPoint> points) {
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const double slope = (points[i + 1].cd - points[i].cd) / (points[i + 1].mach - points[i].mach);
    pieces.push_back({slope, slope});
  }
  return pieces;
}

constexpr int standard_last_mach = 5;
// A point's Mach number and its multiple of an interval may differ in the last bit.
constexpr double rounding = 1e-9;

// Equal intervals of Mach numbers that every point is an end of.
struct MachIntervals {
  int in_one;
  int last_mach;
  int count() const { return last_mach * in_one; }
};

bool are_multiples(std::span<const DragPoint> points, int intervals) {
  return std::ranges::all_of(points, [&](const DragPoint& point) {
    const double place = point.mach * intervals;
    return std::abs(place - std::round(place)) < rounding * intervals;
  });
}

// The standard functions have multiples of 1/80.
constexpr std::array<int, 4> interval_choices{80, 400, 2000, 10000};

MachIntervals intervals_for(std::span<const DragPoint> own) {
  const auto* const fine = std::ranges::find_if(
      interval_choices, [&](int intervals) { return are_multiples(own, intervals); });
  const double last = own.empty() ? 0 : own.back().mach;
  return {*fine, std::max(standard_last_mach, static_cast<int>(std::ceil(last)))};
}

// The pieces between the points, cut into the intervals.
template <class T>
void append_drag(std::span<const DragPoint> points, DragInterpolation interpolation,
                 const MachIntervals& intervals, soa::CubicTable<T>& table) {
  const std::vector<Piece> pieces = interpolation == DragInterpolation::monotone
                                        ? monotone_pieces(points)
                                        : linear_pieces(points);
  std::size_t left = 0;
  for (int i = 0; i < intervals.count(); ++i) {
    const double from = static_cast<double>(i) / intervals.in_one;
    const double to = static_cast<double>(i + 1) / intervals.in_one;
    while (left + 2 < points.size() && points[left + 1].mach < from + rounding) ++left;
    const double held = from + rounding < points.front().mach ? points.front().cd
                        : from + rounding > points.back().mach
                            ? points.back().cd
                            : std::numeric_limits<double>::quiet_NaN();
    if (!std::isnan(held)) {
      table.append(held, 0, held, 0);
      continue;
    }
    const double h = points[left + 1].mach - points[left].mach;
    const double m0 = pieces[left].left * h;
    const double m1 = pieces[left].right * h;
    const double rise = points[left + 1].cd - points[left].cd;
    const double c2 = 3 * rise - 2 * m0 - m1;
    const double c3 = m0 + m1 - 2 * rise;
    const auto value = [&](double mach) {
      const double u = (mach - points[left].mach) / h;
      return points[left].cd + ((c3 * u + c2) * u + m0) * u;
    };
    const auto slope = [&](double mach) {
      const double u = (mach - points[left].mach) / h;
      return ((3 * c3 * u + 2 * c2) * u + m0) / (h * intervals.in_one);
    };
    table.append(value(from), slope(from), value(to), slope(to));
  }
}

constexpr double height_interval = 200;  // m

// Slopes by differences of the exact formula within the layer: a layer's gradient jumps at its
// ends, which are whole intervals.
template <class T, class Get>
soa::CubicTable<T> over_height(const Get& get) {
  soa::CubicTable<T> table(lowest_geopotential, height_interval);
  constexpr double small = 1;  // m
  for (double left = lowest_geopotential; left + height_interval <= highest_geopotential;
       left += height_interval) {
    const double right = left + height_interval;
    const auto at = [&](double h) { return get(standard_air(h)); };
    // From inside the interval, to the third order.
    const double just_below = right - right * 1e-15 - 1e-9;
    const double v0 = at(left);
    const double v1 = at(just_below);
    const double slope0 =
        (-11 * v0 + 18 * at(left + small) - 9 * at(left + 2 * small) + 2 * at(left + 3 * small)) /
        (6 * small);
    const double slope1 =
        (11 * v1 - 18 * at(right - small) + 9 * at(right - 2 * small) - 2 * at(right - 3 * small)) /
        (6 * small);
    table.append(v0, slope0 * height_interval, v1, slope1 * height_interval);
  }
  return table;
}

template <class T>
ProjectileTables<T> make_tables(std::span<const DragPoint> own, DragInterpolation interpolation) {
  const MachIntervals intervals = intervals_for(own);
  ProjectileTables<T> tables;
  tables.drag = tables.drag_place = soa::CubicTable<T>(0, 1.0 / intervals.in_one);
  for (const DragFunction& function : drag_functions) {
    append_drag(function.points, interpolation, intervals, tables.drag);
  }
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < intervals.count() && own.empty(); ++i) {
    tables.drag.append(none, none, none, none);
  }
  if (!own.empty()) append_drag(own, interpolation, intervals, tables.drag);
  for (int i = 0; i < intervals.count(); ++i) tables.drag_place.append(0, 0, 0, 0);
  tables.drag_stride = 4 * tables.drag_place.intervals();
  tables.density = over_height<T>([](const AirState& air) { return air.density; });
  tables.slowness = over_height<T>([](const AirState& air) { return 1 / air.speed_of_sound; });
  return tables;
}

void require_right(std::span<const DragPoint> own) {
  if (own.empty()) return;
  if (const auto mistake = DragTables::mistake_in(own)) {
    throw std::invalid_argument(fmt::format("point {} of the drag function: {}: {}", mistake->point,
                                            mistake->problem, mistake->hint));
  }
}

}  // namespace

DragTables::DragTables(std::span<const DragPoint> own, DragInterpolation interpolation)
    : numbers_{static_cast<double>(interpolation)} {
  require_right(own);
  for (const DragPoint& point : own) {
    numbers_.push_back(point.mach);
    numbers_.push_back(point.cd);
  }
  float32_ = make_tables<float>(own, interpolation);
  float64_ = make_tables<double>(own, interpolation);
}

DragTables::~DragTables() = default;

template <>
const ProjectileTables<float>& DragTables::of() const {
  return float32_;
}
template <>
const ProjectileTables<double>& DragTables::of() const {
  return float64_;
}

std::optional<DragTables::Mistake> DragTables::mistake_in(std::span<const DragPoint> own) {
  if (own.size() < 3) {
    return Mistake{0, fmt::format("there are {} points", own.size()), "expected at least 3"};
  }
  for (std::size_t i = 0; i < own.size(); ++i) {
    const auto [mach, cd] = own[i];
    if (!(mach >= 0 && mach <= most_mach)) {
      return Mistake{i, fmt::format("Mach {} is out of bounds", mach),
                     fmt::format("expected 0 to {}", most_mach)};
    }
    if (!(cd > 0 && cd <= 1e3)) {
      return Mistake{i, fmt::format("a drag coefficient of {}", cd), "expected a positive number"};
    }
    if (i > 0 && !(mach > own[i - 1].mach)) {
      return Mistake{i, fmt::format("Mach {} comes after {}", mach, own[i - 1].mach),
                     "expected Mach numbers that increase"};
    }
    if (!are_multiples(own.subspan(i, 1), interval_choices.back())) {
      return Mistake{i, fmt::format("Mach {} has more than four decimals", mach),
                     "expected a multiple of 0.0001"};
    }
  }
  return std::nullopt;
}

template <class T>
const ProjectileTables<T>& projectile_tables() {
  static const DragTables tables({}, DragInterpolation::monotone);
  return tables.of<T>();
}

template const ProjectileTables<float>& projectile_tables();
template const ProjectileTables<double>& projectile_tables();

}  // namespace salvo::models
