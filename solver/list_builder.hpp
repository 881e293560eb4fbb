// Looks for the neighbors of rows that lie close together: those in the cells around such a block
// are fetched once, as seen from the middle of the block in units of how far it reaches, and then
// compared with each of its rows, many at a time. In single precision: a list may hold too much,
// never too little.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "kernels/lane.hpp"
#include "solver/contact_pass.hpp"

namespace salvo::solver {
inline namespace SALVO_ISA {

// First of the rows of a range whose key is at least `key`.
inline std::uint32_t first_at_least(const CellIndex& index, std::uint64_t key) {
  std::uint32_t low = index.directory[key >> index.shift];
  if (index.shift == 0) return low;
  std::uint32_t high = index.directory[(key >> index.shift) + 1];
  while (low < high) {
    const std::uint32_t middle = low + (high - low) / 2;
    if (index.keys[middle] < key) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

struct CellRange {
  std::uint64_t first;
  std::uint64_t last;
};

inline std::uint64_t cell_along(const CellClass& c, std::size_t axis, double at) {
  const double number = (at - c.origin[axis]) * c.inverse_cell;
  return static_cast<std::uint64_t>(
      std::clamp(number, 0.0, static_cast<double>(c.counts[axis] - 1)));
}

class ListBuilder {
 public:
  using V = kernels::NativeLane<float>;

  explicit ListBuilder(ListPass& pass) : pass_(pass) {}

  void build() {
    for (std::size_t row = pass_.first_row; row < pass_.last_row;) {
      const std::size_t end = end_of_block(row);
      list(row, end);
      row = end;
    }
    pass_.entries = size_;
  }

 private:
  static constexpr std::size_t axes = 3;
  static constexpr std::size_t most_rows = 32;  // of a block
  static constexpr std::uint64_t block_cells = 2 * bar;
  static constexpr std::size_t most_candidates = 4096;  // fetched at a time
  static constexpr std::size_t run_step = 8;            // candidates are fetched in steps of these
  using Doubles [[gnu::vector_size(64)]] = double;
  using Floats [[gnu::vector_size(32)]] = float;
  using Numbers [[gnu::vector_size(32)]] = std::uint32_t;
  static constexpr std::size_t widest = 16;  // lanes
  static constexpr std::size_t at_once = 4;  // entries
  // In units of the reach of a block, which no coordinate of those within reach exceeds. Rounding
  // moves a coordinate by 2^-24 at most: a distance and the radii are off by less than ten of that.
  static constexpr float slack = 0x1p-20F;
  static constexpr double far_away = 4;

  struct Box {
    double lowest[axes];
    double highest[axes];
    double radius = -1;  // of the largest

    void start(const SearchColumns& from, std::size_t row) {
      const double at[axes] = {from.x[row], from.y[row], from.z[row]};
      for (std::size_t axis = 0; axis < axes; ++axis) lowest[axis] = highest[axis] = at[axis];
      radius = from.radius[row];
    }
    void add(const SearchColumns& from, std::size_t row) {
      const double at[axes] = {from.x[row], from.y[row], from.z[row]};
      for (std::size_t axis = 0; axis < axes; ++axis) {
        lowest[axis] = std::min(lowest[axis], at[axis]);
        highest[axis] = std::max(highest[axis], at[axis]);
      }
      radius = std::max(radius, from.radius[row]);
    }
    double edge() const {
      return std::max(std::max(highest[0] - lowest[0], highest[1] - lowest[1]),
                      highest[2] - lowest[2]);
    }
  };

  // Candidates of one class of cells, and how they are seen.
  struct Segment {
    std::size_t first;
    std::size_t last;
    double scale;
  };

  // Rows of two bars side by side. Where cells are much larger than particles, single precision
  // sees a block only if it is small.
  std::size_t end_of_block(std::size_t row) const {
    const SearchColumns& from = pass_.columns;
    const std::uint64_t* keys = pass_.index.keys;
    const double widest_edge = 256 * (from.radius[row] + pass_.margin);
    Box box;
    box.start(from, row);
    std::size_t end = row + 1;
    for (; end < pass_.last_row && end - row < most_rows; ++end) {
      if (keys[end] / block_cells != keys[row] / block_cells) break;
      box.add(from, end);
      if (box.edge() > widest_edge) break;
    }
    return end;
  }

  void list(std::size_t first, std::size_t last) {
    const std::size_t before = size_;
    if (gather(first, last)) {
      compare(first, last);
      if (last - first == 1) pass_.counts[first - pass_.first_row] = count_since(before);
      return;
    }
    // Too many candidates: with fewer rows there are fewer of them.
    const std::size_t middle = first + (last - first) / 2;
    list(first, middle);
    list(middle, last);
  }
  std::uint32_t count_since(std::size_t before) const {
    return static_cast<std::uint32_t>(size_ - before);
  }

  // Fetches the candidates of a block; false where there are too many. One row alone takes any
  // number, as it can compare some and go on.
  bool gather(std::size_t first, std::size_t last) {
    Box box;
    box.start(pass_.columns, first);
    for (std::size_t row = first + 1; row < last; ++row) box.add(pass_.columns, row);
    for (std::size_t axis = 0; axis < axes; ++axis) {
      middle_[axis] = box.lowest[axis] + 0.5 * (box.highest[axis] - box.lowest[axis]);
    }
    first_row_ = first;
    last_row_ = last;
    segments_ = 0;
    candidates_ = 0;
    own_place_[0] = nowhere;
    for (std::size_t number = 0; number < pass_.index.class_count; ++number) {
      const CellClass& c = pass_.index.classes[number];
      if (c.counts[0] == 0) continue;
      const double reach = box.radius + pass_.margin + c.largest_radius;
      scale_ = 1 / std::max(0.5 * box.edge() + reach, 0x1p-1022);
      first_ = candidates_;
      CellRange along[axes];
      for (std::size_t axis = 0; axis < axes; ++axis) {
        along[axis] = {cell_along(c, axis, box.lowest[axis] - reach),
                       cell_along(c, axis, box.highest[axis] + reach)};
      }
      // Cells that outnumber what is in them take longer to visit.
      const auto across = [&](std::size_t axis) {
        return static_cast<double>(along[axis].last - along[axis].first + 1);
      };
      const bool few = across(0) * across(1) * across(2) > 64 + static_cast<double>(c.members);
      if (!(few ? fetch(c.first_key, c.first_key + c.cells()) : fetch_cells(c, along))) {
        return false;
      }
      end_segment();
    }
    return true;
  }

  bool fetch_cells(const CellClass& c, const CellRange (&along)[axes]) {
    // Cells whose keys follow one another are one run.
    std::uint64_t run = 0;
    std::uint64_t run_end = 0;
    for (std::uint64_t i = along[0].first; i <= along[0].last; ++i) {
      for (std::uint64_t j = along[1].first, end = 0; j <= along[1].last; j = end) {
        end = std::min(along[1].last + 1, (j / bar + 1) * bar);
        for (std::uint64_t k = along[2].first; k <= along[2].last; ++k) {
          const std::uint64_t key = c.key(i, j, k);
          if (key != run_end) {
            if (!fetch(run, run_end)) return false;
            run = key;
          }
          run_end = key + (end - j);
        }
      }
    }
    return fetch(run, run_end);
  }

  bool fetch(std::uint64_t run, std::uint64_t run_end) {
    if (run == run_end) return true;
    std::size_t row = first_at_least(pass_.index, run);
    const std::size_t last = first_at_least(pass_.index, run_end);
    const SearchColumns& from = pass_.columns;
    while (row < last) {
      const std::size_t room = most_candidates - candidates_;
      if (room < last - row) {
        if (last_row_ - first_row_ > 1) return false;
        if (room == 0) {
          end_segment();
          compare(first_row_, last_row_);
          segments_ = first_ = candidates_ = 0;
          own_place_[0] = nowhere;
          continue;
        }
      }
      const std::size_t end = std::min(last, row + room);
      for (std::size_t to = candidates_, at = row; at < end; at += run_step, to += run_step) {
        see(from.x + at, middle_[0], place_[0] + to);
        see(from.y + at, middle_[1], place_[1] + to);
        see(from.z + at, middle_[2], place_[2] + to);
        see(from.radius + at, 0, radius_ + to);
        const Numbers rows = Numbers{0, 1, 2, 3, 4, 5, 6, 7} + static_cast<std::uint32_t>(at);
        __builtin_memcpy(row_ + to, &rows, sizeof(rows));
      }
      for (std::size_t own = std::max(row, first_row_); own < std::min(end, last_row_); ++own) {
        own_place_[own - first_row_] = candidates_ + (own - row);
      }
      candidates_ += end - row;
      row = end;
    }
    return true;
  }
  void see(const double* from, double middle, float* to) const {
    Doubles at;
    __builtin_memcpy(&at, from, sizeof(at));
    const Floats seen = __builtin_convertvector((at - middle) * scale_, Floats);
    __builtin_memcpy(to, &seen, sizeof(seen));
  }

  // What fills up the last pack is out of reach.
  void end_segment() {
    if (candidates_ == first_) return;
    for (std::size_t n = candidates_; n < candidates_ + widest; ++n) {
      place_[0][n] = place_[1][n] = place_[2][n] = static_cast<float>(far_away);
      radius_[n] = 0;
    }
    candidates_ = (candidates_ + widest - 1) / widest * widest;
    segment_[segments_++] = {first_, candidates_, scale_};
  }

  void compare(std::size_t first, std::size_t last) {
    for (std::size_t row = first; row < last; ++row) {
      const std::size_t before = size_;
      const std::size_t needed = size_ + candidates_ + at_once;
      if (needed > room_) {
        room_ = needed;
        entries_ = pass_.grow(pass_.owner, room_);
      }
      for (std::size_t s = 0; s < segments_; ++s) {
        compare(row, own_place_[row - first_row_], segment_[s]);
      }
      pass_.counts[row - pass_.first_row] = count_since(before);
    }
  }
  void compare(std::size_t row, std::size_t self, const Segment& segment) {
    const SearchColumns& from = pass_.columns;
    const auto seen = [&](double at, std::size_t axis) {
      return V(static_cast<float>((at - middle_[axis]) * segment.scale));
    };
    const V x = seen(from.x[row], 0);
    const V y = seen(from.y[row], 1);
    const V z = seen(from.z[row], 2);
    const V radius =
        V(static_cast<float>((from.radius[row] + pass_.margin) * segment.scale) + slack);
    // Some packs in one go: then one loop over all that is near, however it lies among them.
    for (std::size_t n = segment.first; n < segment.last; n += 64) {
      const std::size_t count = std::min<std::size_t>(64, segment.last - n);
      std::uint64_t near = 0;
      for (std::size_t m = 0; m < count; m += V::width) {
        const V dx = V::load(place_[0] + n + m) - x;
        const V dy = V::load(place_[1] + n + m) - y;
        const V dz = V::load(place_[2] + n + m) - z;
        const V reach = V::load(radius_ + n + m) + radius;
        near |= std::uint64_t{bits(dx * dx + dy * dy + dz * dz < reach * reach)} << m;
      }
      if (self - n < 64) near &= ~(std::uint64_t{1} << (self - n));
      keep(near, row_ + n);
    }
  }
  // A few at a time: a loop from one to the next ends where no processor foresees it. What is
  // written after the last is written over.
  void keep(std::uint64_t near, const std::uint32_t* from) {
    const std::size_t end = size_ + static_cast<std::size_t>(std::popcount(near));
    while (near != 0) {
      for (std::size_t once = 0; once < at_once; ++once, near &= near - 1) {
        entries_[size_++] = from[std::countr_zero(near)];
      }
    }
    size_ = end;
  }

  ListPass& pass_;
  std::uint32_t* entries_ = nullptr;
  std::size_t size_ = 0;
  std::size_t room_ = 0;

  // Of the block.
  double middle_[axes];
  std::size_t first_row_ = 0;
  std::size_t last_row_ = 0;
  static constexpr std::size_t nowhere = ~std::size_t{0} / 2;
  std::size_t own_place_[most_rows];  // among the candidates
  static constexpr std::size_t most_segments = 16;
  static_assert(most_segments >= most_classes, "one of each class, and no more");
  Segment segment_[most_segments];
  std::size_t segments_ = 0;

  // Of the segment that is being fetched.
  double scale_ = 1;
  std::size_t first_ = 0;

  static constexpr std::size_t buffer = most_candidates + 128;  // with room to read and write on
  alignas(64) float place_[axes][buffer];
  alignas(64) float radius_[buffer];
  std::uint32_t row_[buffer];
  std::size_t candidates_ = 0;
};

}  // namespace SALVO_ISA
}  // namespace salvo::solver
