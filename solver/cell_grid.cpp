#include "solver/cell_grid.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace salvo::solver {

namespace {

constexpr std::size_t rows_per_task = 16384;
constexpr std::uint64_t most_cells = std::uint64_t{1} << 62;
constexpr double most_growth = 16;
constexpr int most_digit_bits = 11;

std::size_t tasks_of(std::size_t rows) { return (rows + rows_per_task - 1) / rows_per_task; }

// Which class a radius belongs to: 0 the largest.
int class_of(double radius, double largest, int most_classes) {
  int number = 0;
  while (number < most_classes - 1 && radius * 4 < largest) {
    largest /= 4;
    ++number;
  }
  return number;
}

struct Extent {
  std::array<double, 3> lowest;
  std::array<double, 3> highest;
  double largest_radius = 0;
  std::size_t members = 0;

  Extent() {
    lowest.fill(std::numeric_limits<double>::max());
    highest.fill(std::numeric_limits<double>::lowest());
  }
  void add(const std::array<double, 3>& place, double radius) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lowest[axis] = std::min(lowest[axis], place[axis]);
      highest[axis] = std::max(highest[axis], place[axis]);
    }
    largest_radius = std::max(largest_radius, radius);
    ++members;
  }
  void add(const Extent& other) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lowest[axis] = std::min(lowest[axis], other.lowest[axis]);
      highest[axis] = std::max(highest[axis], other.highest[axis]);
    }
    largest_radius = std::max(largest_radius, other.largest_radius);
    members += other.members;
  }
};

// Cells along each axis, their edge doubled until all can be numbered.
void fit(const Extent& extent, CellClass& cells, std::uint64_t room) {
  for (;; cells.cell *= 2) {
    cells.inverse_cell = 1 / cells.cell;
    double total = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      // One more on each side: a search may look there.
      double count =
          std::floor((extent.highest[axis] - extent.lowest[axis]) * cells.inverse_cell) + 3;
      constexpr auto across = static_cast<double>(bar);
      if (axis > 0) count = std::ceil(count / across) * across;
      total *= count;
      if (!(total < static_cast<double>(room))) break;
      cells.counts[axis] = static_cast<std::uint64_t>(count);
      cells.origin[axis] = extent.lowest[axis] - cells.cell;
    }
    if (total < static_cast<double>(room)) return;
  }
}

std::uint64_t key_of(const CellClass& c, double x, double y, double z) {
  const auto along = [&](std::size_t axis, double at) {
    return static_cast<std::uint64_t>((at - c.origin[axis]) * c.inverse_cell);
  };
  return c.key(along(0, x), along(1, y), along(2, z));
}

}  // namespace

void CellGrid::choose_classes(const SearchColumns& columns, std::size_t rows, double margin,
                              double cell_scale, const Parallel& parallel) {
  const std::size_t tasks = tasks_of(rows);
  std::vector<double> largest(tasks, 0);
  parallel.for_each(tasks, [&](std::size_t task) {
    const std::size_t last = std::min(rows, (task + 1) * rows_per_task);
    double radius = 0;
    for (std::size_t row = task * rows_per_task; row < last; ++row) {
      radius = std::max(radius, columns.radius[row]);
    }
    largest[task] = radius;
  });
  double largest_radius = 0;
  for (const double radius : largest) largest_radius = std::max(largest_radius, radius);
  using Extents = std::array<Extent, most_classes>;
  std::vector<Extents> parts(tasks);
  parallel.for_each(tasks, [&](std::size_t task) {
    const std::size_t last = std::min(rows, (task + 1) * rows_per_task);
    // One extent is at hand while rows are of one class.
    std::size_t number = 0;
    Extent extent;
    for (std::size_t row = task * rows_per_task; row < last; ++row) {
      const double radius = columns.radius[row];
      if (radius < 0) continue;
      const auto own = static_cast<std::size_t>(class_of(radius, largest_radius, most_classes));
      if (own != number) {
        parts[task][number].add(std::exchange(extent, {}));
        number = own;
      }
      extent.add({columns.x[row], columns.y[row], columns.z[row]}, radius);
    }
    parts[task][number].add(extent);
  });
  classes_.clear();
  cells_ = 0;
  members_ = 0;
  for (std::size_t number = 0; number < most_classes; ++number) {
    Extent extent;
    for (const Extents& part : parts) extent.add(part[number]);
    CellClass cells;
    cells.largest_radius = extent.largest_radius;
    cells.first_key = cells_;
    cells.members = extent.members;
    if (extent.members > 0) {
      cells.cell = std::max((2 * extent.largest_radius + margin) * cell_scale * growth_[number],
                            std::numeric_limits<double>::min());
      fit(extent, cells, most_cells / most_classes);
      cells_ += cells.cells();
    }
    members_ += extent.members;
    classes_.push_back(cells);
  }
  while (!classes_.empty() && classes_.back().counts[0] == 0) classes_.pop_back();
}

void CellGrid::build(const SearchColumns& columns, std::size_t rows, double margin,
                     double cell_scale, const Parallel& parallel) {
  choose_classes(columns, rows, margin, cell_scale, parallel);
  const double largest_radius = classes_.empty() ? 0 : classes_.front().largest_radius;
  keys_.resize(rows);
  order_.resize(rows);
  parallel.for_each(tasks_of(rows), [&](std::size_t task) {
    const std::size_t last = std::min(rows, (task + 1) * rows_per_task);
    for (std::size_t row = task * rows_per_task; row < last; ++row) {
      const double radius = columns.radius[row];
      order_[row] = static_cast<std::uint32_t>(row);
      keys_[row] = radius < 0 ? cells_
                              : key_of(classes_[static_cast<std::size_t>(
                                           class_of(radius, largest_radius, most_classes))],
                                       columns.x[row], columns.y[row], columns.z[row]);
    }
  });
  sort(rows, static_cast<int>(std::bit_width(cells_)), parallel);

  fill_directory(rows, parallel);
  choose_growth(rows, parallel);
}

void CellGrid::fill_directory(std::size_t rows, const Parallel& parallel) {
  // About as many entries as rows.
  shift_ = 0;
  while ((cells_ >> shift_) > 2 * rows + 64) ++shift_;
  const std::size_t entries = static_cast<std::size_t>(cells_ >> shift_) + 2;
  directory_.resize(entries);
  parallel.for_each(tasks_of(rows) + 1, [&](std::size_t task) {
    // Each row fills the entries after its predecessor's up to its own.
    const std::size_t first = task * rows_per_task;
    const std::size_t last = std::min(rows, first + rows_per_task);
    const auto entry = [&](std::size_t row) {
      return static_cast<std::size_t>(keys_[row] >> shift_);
    };
    for (std::size_t row = first; row < last; ++row) {
      for (std::size_t e = row == 0 ? 0 : entry(row - 1) + 1; e <= entry(row); ++e) {
        directory_[e] = static_cast<std::uint32_t>(row);
      }
    }
    if (task == tasks_of(rows)) {
      for (std::size_t e = rows == 0 ? 0 : entry(rows - 1) + 1; e < entries; ++e) {
        directory_[e] = static_cast<std::uint32_t>(rows);
      }
    }
  });
}

// Cells that outnumber their particles take more looking up than they save. Room that is mostly
// empty is no reason yet, though: particles may crowd somewhere in it.
void CellGrid::choose_growth(std::size_t rows, const Parallel& parallel) {
  struct Crowd {
    std::uint64_t members = 0;
    std::uint64_t pairs = 0;  // in one cell
  };
  using Crowds = std::array<Crowd, most_classes>;
  std::vector<Crowds> parts(tasks_of(rows));
  parallel.for_each(parts.size(), [&](std::size_t task) {
    const std::size_t last = std::min(members_, (task + 1) * rows_per_task);
    std::size_t row = task * rows_per_task;
    for (std::size_t number = 0; number < classes_.size(); ++number) {
      const std::uint64_t end =
          number + 1 < classes_.size() ? classes_[number + 1].first_key : cells_;
      Crowd crowd;
      std::uint64_t before = 0;  // in the same cell
      std::uint64_t cell = end;
      for (; row < last && keys_[row] < end; ++row) {
        before = keys_[row] == cell ? before + 1 : 0;
        cell = keys_[row];
        ++crowd.members;
        crowd.pairs += before;
      }
      parts[task][number] = crowd;
    }
  });
  for (std::size_t number = 0; number < classes_.size(); ++number) {
    Crowd all;
    for (const Crowds& part : parts) {
      all.members += part[number].members;
      all.pairs += part[number].pairs;
    }
    const CellClass& c = classes_[number];
    const auto members = static_cast<double>(all.members);
    const auto pairs = static_cast<double>(all.pairs);
    const double cells = static_cast<double>(c.counts[0]) * static_cast<double>(c.counts[1]) *
                         static_cast<double>(c.counts[2]);
    double& growth = growth_[number];
    if (pairs > 1.5 * members) {
      growth = std::max(1.0, growth / 1.5);
    } else if (pairs < 0.15 * members && cells > 2 * members) {
      growth = std::min(most_growth, growth * (cells > 8 * members ? 2 : 1.5));
    }
  }
}

// By the digits of the keys, lowest first; each round keeps the order of equal digits.
void CellGrid::sort(std::size_t rows, int bits, const Parallel& parallel) {
  const std::size_t tasks = tasks_of(rows);
  other_keys_.resize(rows);
  other_order_.resize(rows);
  const int rounds = std::max(1, (bits + most_digit_bits - 1) / most_digit_bits);
  const int digit_bits = (bits + rounds - 1) / rounds;
  const std::size_t digits = std::size_t{1} << digit_bits;
  counts_.resize(tasks * digits);
  for (int shift = 0; shift < bits; shift += digit_bits) {
    const auto digit = [&](std::uint64_t key) {
      return static_cast<std::size_t>(key >> shift) & (digits - 1);
    };
    parallel.for_each(tasks, [&](std::size_t task) {
      std::uint32_t* counts = counts_.data() + task * digits;
      std::fill(counts, counts + digits, 0U);
      const std::size_t last = std::min(rows, (task + 1) * rows_per_task);
      for (std::size_t row = task * rows_per_task; row < last; ++row) ++counts[digit(keys_[row])];
    });
    std::uint32_t place = 0;
    for (std::size_t d = 0; d < digits; ++d) {
      for (std::size_t task = 0; task < tasks; ++task) {
        place += std::exchange(counts_[task * digits + d], place);
      }
    }
    parallel.for_each(tasks, [&](std::size_t task) {
      std::uint32_t* places = counts_.data() + task * digits;
      const std::size_t last = std::min(rows, (task + 1) * rows_per_task);
      for (std::size_t row = task * rows_per_task; row < last; ++row) {
        const std::uint32_t to = places[digit(keys_[row])]++;
        other_keys_[to] = keys_[row];
        other_order_[to] = order_[row];
      }
    });
    keys_.swap(other_keys_);
    order_.swap(other_order_);
  }
  other_keys_.release();
  other_order_.release();
}

void CellGrid::release() {
  const auto growth = growth_;
  *this = {};
  growth_ = growth;
}

CellIndex CellGrid::index() const {
  return {classes_.data(), classes_.size(), keys_.data(), directory_.data(), shift_};
}

}  // namespace salvo::solver
