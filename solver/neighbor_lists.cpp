#include "solver/neighbor_lists.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>
#include <utility>

namespace salvo::solver {

namespace {

// Rows of a window are ordered by the length of their lists, so that a group fills up little.
constexpr std::size_t window_rows = 128;
constexpr std::size_t listed_rows = 8 * window_rows;  // of a task
constexpr std::size_t length_classes = 256;

// The longer a list, the lower; from 32 entries on, lists of about the same length have one number.
std::size_t length_class(std::uint32_t entries) {
  constexpr std::size_t exact = 32;
  if (entries < exact) return length_classes - 1 - entries;
  const auto digits = static_cast<std::size_t>(std::bit_width(entries));
  return length_classes - 1 - (exact + (digits - 6) * 8 + (entries >> (digits - 4) & 7));
}

// How many of some slots have the bit of each row of a group.
using RowCounts [[gnu::vector_size(group_rows * sizeof(std::uint32_t))]] = std::uint32_t;

RowCounts count_rows(const std::uint16_t* near, const std::uint16_t* end) {
  RowCounts bit;
  for (std::size_t row = 0; row < group_rows; ++row) bit[row] = 1U << row;
  RowCounts counts{};
  for (; near < end; ++near) counts -= (std::uint32_t{*near} & bit) != 0;
  return counts;
}

}  // namespace

void SlotLists::allocate(std::size_t groups) {
  neighbor.resize(number_slots(first_slot, groups) * group_rows);
}

NeighborLists::Extent NeighborLists::extent() const {
  struct Part {
    double sum = 0;
    std::size_t listed = 0;
    double largest = 0;
    double farthest = 0;
  };
  std::vector<Part> parts(tasks_of(rows_, rows_per_task));
  for_rows(parallel_, rows_, [&](std::size_t first, std::size_t last) {
    Part part;
    for (std::size_t i = first; i < last; ++i) {
      const double radius = search_[3][i];
      if (!(radius > 0)) continue;
      part.sum += radius;
      ++part.listed;
      part.largest = std::max(part.largest, radius);
      for (std::size_t c = 0; c < 3; ++c) {
        part.farthest = std::max(part.farthest, std::abs(search_[c][i]));
      }
    }
    parts[first / rows_per_task] = part;
  });
  Part all;
  for (const Part& part : parts) {
    all.sum += part.sum;
    all.listed += part.listed;
    all.largest = std::max(all.largest, part.largest);
    all.farthest = std::max(all.farthest, part.farthest);
  }
  Extent extent{.largest_radius = all.largest, .farthest = all.farthest};
  if (all.listed > 0) extent.mean_radius = all.sum / static_cast<double>(all.listed);
  return extent;
}

void NeighborLists::sort(double margin, double cell_scale) {
  grid_.build(sights(), rows_, margin, cell_scale, parallel_);
}

void NeighborLists::build(double margin, const std::uint32_t* rank, const Rooms& rooms) {
  // What a stage leaves behind is given back before the next one allocates.
  rooms_ = rooms;
  list_rows(margin);
  for (auto& column : search_) column.release();
  place_rows(rank);
  grid_.release();
  lay_out();
  outer_entries_ = std::accumulate(raw_count_.data(), raw_count_.data() + rows_, std::uint64_t{0});
  long_lists_ = {};
  place_.release();
  raw_count_.release();
  raw_first_.release();
  rooms_ = {};
}

NeighborLists::RawLists NeighborLists::raw_lists(std::size_t task) {
  // All tasks have the same share. The rooms end with what is too small for one.
  const std::size_t share = (rooms_[0].size() + rooms_[1].size()) / rows_ * listed_rows;
  std::size_t before = 0;
  for (const std::span<std::byte> room : rooms_) {
    const std::size_t shares = room.size() / share;
    if (task < before + shares) {
      std::byte* const first = room.data() + (task - before) * share;
      return {{reinterpret_cast<std::uint32_t*>(first), share / sizeof(std::uint32_t)},
              &long_lists_[task]};
    }
    before += shares;
  }
  return {{}, &long_lists_[task]};
}

void NeighborLists::list_rows(double margin) {
  const std::size_t members = grid_.members();
  const std::size_t tasks = tasks_of(rows_, listed_rows);
  long_lists_.clear();
  long_lists_.resize(tasks);
  raw_count_.resize(rows_);
  raw_first_.resize(rows_);
  parallel_.for_each(tasks, [&](std::size_t task) {
    ListPass pass;
    pass.first_row = std::min(members, task * listed_rows);
    pass.last_row = std::min(members, pass.first_row + listed_rows);
    pass.index = grid_.index();
    pass.columns = sights();
    pass.margin = margin;
    RawLists lists = raw_lists(task);
    pass.owner = &lists;
    pass.grow = [](void* owner, std::size_t& entries) {
      const RawLists& own = *static_cast<RawLists*>(owner);
      if (entries <= own.room.size()) {
        entries = own.room.size();
      } else {
        const bool moves = own.more->empty();
        own.more->resize(entries + entries / 4);
        if (moves) std::copy(own.room.begin(), own.room.end(), own.more->begin());
        entries = own.more->size();
      }
      return own.data();
    };
    pass.counts = raw_count_.data() + pass.first_row;
    kernels_.list_neighbors(pass);
    std::uint32_t first = 0;
    for (std::size_t row = task * listed_rows; row < std::min(rows_, (task + 1) * listed_rows);
         ++row) {
      if (row >= members) raw_count_[row] = 0;
      raw_first_[row] = first;
      first += raw_count_[row];
    }
  });
}

// Orders the rows of each window by the length of their lists, the longest first, and counts the
// slots that each group needs.
void NeighborLists::place_rows(const std::uint32_t* rank) {
  const std::size_t groups = rows_ / group_rows;
  outer_.first_slot.resize(groups + 1);
  source_.resize(rows_);
  rank_.resize(rows_);
  place_.resize(rows_);
  parallel_.for_each(tasks_of(rows_, listed_rows), [&](std::size_t task) {
    const std::size_t end = std::min(rows_, (task + 1) * listed_rows);
    for (std::size_t first = task * listed_rows; first < end; first += window_rows) {
      const std::size_t last = std::min(end, first + window_rows);
      std::array<std::uint32_t, length_classes> next{};
      for (std::size_t i = first; i < last; ++i) ++next[length_class(raw_count_[i])];
      auto row = static_cast<std::uint32_t>(first);
      for (std::uint32_t& n : next) row += std::exchange(n, row);
      std::array<std::uint32_t, window_rows / group_rows> longest{};
      for (std::size_t i = first; i < last; ++i) {
        const std::uint32_t count = raw_count_[i];
        const std::uint32_t place = next[length_class(count)]++;
        const std::uint32_t source = grid_.order()[i];
        source_[place] = source;
        rank_[place] = rank[source];
        place_[i] = {place, rank[source]};
        std::uint32_t& most = longest[(place - first) / group_rows];
        most = std::max(most, count);
      }
      for (std::size_t n = 0; n < (last - first) / group_rows; ++n) {
        outer_.first_slot[first / group_rows + n] = longest[n];
      }
    }
  });
  outer_.allocate(groups);
}

void NeighborLists::lay_out() {
  parallel_.for_each(tasks_of(rows_, listed_rows), [&](std::size_t task) {
    std::vector<NewPlace> list;
    const std::uint32_t* raw = raw_lists(task).data();
    const std::size_t end = std::min(rows_, (task + 1) * listed_rows);
    for (std::size_t first = task * listed_rows; first < end; first += window_rows) {
      const std::size_t last = std::min(end, first + window_rows);
      // Rows of like length follow one another.
      std::array<std::uint32_t, window_rows> among_cells;
      for (std::size_t i = first; i < last; ++i) {
        among_cells[place_[i].row - first] = static_cast<std::uint32_t>(i);
      }
      for (std::size_t row = first; row < last; ++row) {
        const std::size_t i = among_cells[row - first];
        const std::size_t group = row / group_rows;
        const std::uint64_t first_slot = outer_.first_slot[group];
        lay_out_row(raw + raw_first_[i], raw_count_[i],
                    outer_.neighbor.data() + first_slot * group_rows + row % group_rows,
                    outer_.first_slot[group + 1] - first_slot, list);
      }
    }
  });
}

// Writes the list of one row by ascending rank. For each of a short list the smaller ones are
// counted, without a branch that would go either way.
void NeighborLists::lay_out_row(const std::uint32_t* raw, std::size_t count, std::int32_t* to,
                                std::size_t slots, std::vector<NewPlace>& list) const {
  constexpr std::size_t few = 24;
  constexpr std::size_t step = 4;  // the widest that every processor has
  using Ranks [[gnu::vector_size(step * sizeof(std::int32_t))]] = std::int32_t;
  if (count <= few) {
    std::array<std::int32_t, few> row;
    alignas(Ranks) std::array<std::int32_t, few> rank;
    for (std::size_t n = 0; n < count; ++n) {
      const NewPlace place = place_[raw[n]];
      row[n] = static_cast<std::int32_t>(place.row);
      rank[n] = static_cast<std::int32_t>(place.rank);
    }
    for (std::size_t first = 0; first < count; first += step) {
      Ranks some;
      std::memcpy(&some, rank.data() + first, sizeof(some));
      Ranks lower{};
      for (std::size_t n = 0; n < count; ++n) lower -= rank[n] < some;
      const std::size_t last = std::min(count, first + step);
      for (std::size_t n = first; n < last; ++n) {
        to[static_cast<std::size_t>(lower[n - first]) * group_rows] = row[n];
      }
    }
  } else {
    list.resize(count);
    for (std::size_t n = 0; n < count; ++n) list[n] = place_[raw[n]];
    std::sort(list.begin(), list.end(),  // exact-set: ranks are unique
              [](const NewPlace& a, const NewPlace& b) { return a.rank < b.rank; });
    for (std::size_t n = 0; n < count; ++n) {
      to[n * group_rows] = static_cast<std::int32_t>(list[n].row);
    }
  }
  for (std::size_t n = count; n < slots; ++n) {
    to[n * group_rows] = static_cast<std::int32_t>(rows_);
  }
}

template <class T>
void NeighborLists::prune(const SpherePlace<T>* places, double margin) {
  const std::size_t groups = rows_ / group_rows;
  near_.resize(outer_.slots());
  inner_.first_slot.resize(groups + 1);
  std::vector<std::uint64_t> entries(tasks_of(groups, groups_per_task));
  for_groups(parallel_, rows_, [&](std::size_t task, std::size_t first, std::size_t last) {
    PrunePass<T> pass;
    pass.first_group = first;
    pass.last_group = last;
    pass.place = places;
    pass.first_slot = outer_.first_slot.data();
    pass.neighbor = outer_.neighbor.data();
    pass.margin = static_cast<T>(margin);
    pass.near = near_.data();
    if constexpr (sizeof(T) == 4) {
      kernels_.prune_float32(pass);
    } else {
      kernels_.prune_float64(pass);
    }
    std::uint64_t sum = 0;
    for (std::size_t group = first; group < last; ++group) {
      const RowCounts counts = count_rows(near_.data() + outer_.first_slot[group],
                                          near_.data() + outer_.first_slot[group + 1]);
      std::uint32_t longest = 0;
      for (std::size_t row = 0; row < group_rows; ++row) {
        longest = std::max(longest, counts[row]);
        sum += counts[row];
      }
      inner_.first_slot[group] = longest;
    }
    entries[task] = sum;
  });
  inner_.allocate(groups);
  entries_ = 0;
  for (const std::uint64_t n : entries) entries_ += n;
  for_groups(parallel_, rows_, [&](std::size_t, std::size_t first, std::size_t last) {
    for (std::size_t group = first; group < last; ++group) prune_group(group);
  });
}

void NeighborLists::prune_group(std::size_t group) {
  std::int32_t* to = inner_.neighbor.data() + inner_.first_slot[group] * group_rows;
  std::int32_t* const end = inner_.neighbor.data() + inner_.first_slot[group + 1] * group_rows;
  std::fill(to, end, static_cast<std::int32_t>(rows_));
  std::array<std::int32_t*, group_rows> next;
  for (std::size_t row = 0; row < group_rows; ++row) next[row] = to + row;
  for (std::size_t slot = outer_.first_slot[group]; slot < outer_.first_slot[group + 1]; ++slot) {
    for (std::uint32_t left = near_[slot]; left != 0; left &= left - 1) {
      const auto row = static_cast<std::size_t>(std::countr_zero(left));
      *next[row] = outer_.neighbor[slot * group_rows + row];
      next[row] += group_rows;
    }
  }
}

void NeighborLists::take_outer() {
  inner_.first_slot.swap(outer_.first_slot);
  inner_.neighbor.swap(outer_.neighbor);
  entries_ = outer_entries_;
}

template void NeighborLists::prune(const SpherePlace<float>*, double);
template void NeighborLists::prune(const SpherePlace<double>*, double);

}  // namespace salvo::solver
