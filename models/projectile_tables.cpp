#include "models/projectile_tables.hpp"

#include <cmath>
#include <vector>

#include "models/drag_functions.hpp"
#include "models/standard_atmosphere.hpp"

namespace salvo::models {

namespace {

// Slopes of the monotone cubic through points (Fritsch and Carlson 1980, with the three-point ends
// of Fritsch and Butland): no overshoot between the points.
std::vector<double> monotone_slopes(std::span<const DragPoint> points) {
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
  return slopes;
}

constexpr int mach_intervals = 80;  // to a Mach number
constexpr int last_mach = 5;

// The cubics between the points, cut at every eightieth of a Mach number.
template <class T>
void append_drag(const DragFunction& function, soa::CubicTable<T>& table) {
  const std::span<const DragPoint> points = function.points;
  const std::vector<double> slopes = monotone_slopes(points);
  std::size_t left = 0;
  for (int i = 0; i < last_mach * mach_intervals; ++i) {
    const double from = static_cast<double>(i) / mach_intervals;
    const double to = static_cast<double>(i + 1) / mach_intervals;
    // A point's Mach number and its multiple of 1/80 may differ in the last bit.
    constexpr double rounding = 1e-9;
    while (left + 2 < points.size() && points[left + 1].mach < from + rounding) ++left;
    if (from + rounding > points.back().mach) {
      table.append(points.back().cd, 0, points.back().cd, 0);
      continue;
    }
    const double h = points[left + 1].mach - points[left].mach;
    const double m0 = slopes[left] * h;
    const double m1 = slopes[left + 1] * h;
    const double rise = points[left + 1].cd - points[left].cd;
    const double c2 = 3 * rise - 2 * m0 - m1;
    const double c3 = m0 + m1 - 2 * rise;
    const auto value = [&](double mach) {
      const double u = (mach - points[left].mach) / h;
      return points[left].cd + ((c3 * u + c2) * u + m0) * u;
    };
    const auto slope = [&](double mach) {
      const double u = (mach - points[left].mach) / h;
      return ((3 * c3 * u + 2 * c2) * u + m0) / (h * mach_intervals);
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
ProjectileTables<T> make_tables() {
  ProjectileTables<T> tables;
  tables.drag = tables.drag_place = soa::CubicTable<T>(0, 1.0 / mach_intervals);
  for (const DragFunction& function : drag_functions) append_drag(function, tables.drag);
  append_drag(drag_functions.front(), tables.drag_place);
  tables.drag_stride = 4 * tables.drag_place.intervals();
  tables.density = over_height<T>([](const AirState& air) { return air.density; });
  tables.slowness = over_height<T>([](const AirState& air) { return 1 / air.speed_of_sound; });
  return tables;
}

}  // namespace

template <class T>
const ProjectileTables<T>& projectile_tables() {
  static const ProjectileTables<T> tables = make_tables<T>();
  return tables;
}

template const ProjectileTables<float>& projectile_tables();
template const ProjectileTables<double>& projectile_tables();

}  // namespace salvo::models
