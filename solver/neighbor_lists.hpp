// Who may come to touch whom: for every row the rows within a margin, by ascending id. There are
// two lists of each row. The outer one, of a wide margin, is found by the cells, which also puts
// the rows into an order in which neighbors in space are near in memory:
//
//   look() at the rows  ->  sort() by cells  ->  look() again in that order  ->  build()
//
// New rows are the old ones in the order of their cells, within windows by the length of their
// lists; a list speaks of new rows. As long as nobody else can have come near, prune() takes from
// the outer lists the inner ones, of a narrow margin, which the steps read.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "soa/array.hpp"
#include "solver/cell_grid.hpp"
#include "solver/contact_pass.hpp"
#include "solver/contact_rows.hpp"

namespace salvo::solver {

/// A center and, where the row is to be listed, its radius, m; negative where not.
struct Sight {
  double position[3];
  double radius;
};

/// Lists of rows in groups of 16, which lie side by side.
struct SlotLists {
  soa::Array<std::uint64_t> first_slot;  // of each group and, last, their number
  /// Rows, slot after slot of 16; the number of rows where a list has ended.
  soa::Array<std::int32_t> neighbor;

  std::size_t slots() const {
    return first_slot.size() == 0 ? 0 : first_slot[first_slot.size() - 1];
  }
  /// Takes the slots of each group, in place of its first.
  void allocate(std::size_t groups);
};

class NeighborLists {
 public:
  NeighborLists(const ContactKernels& kernels, const Parallel& parallel)
      : kernels_(kernels), parallel_(parallel) {}

  /// Takes see(row) of whole groups of rows, in the order of the rows.
  template <class See>
  void look(std::size_t rows, const See& see) {
    rows_ = rows;
    outer_ = {};
    inner_ = {};
    for (auto& column : search_) column.resize(rows + group_rows);
    take(see, [](std::size_t i) { return i; });
  }
  /// Of the rows that are listed, m.
  struct Extent {
    double mean_radius = 1;  // where none is listed
    double largest_radius = 0;
    double farthest = 0;  // largest coordinate
  };
  Extent extent() const;
  void sort(double margin, double cell_scale);
  /// The same again, in the order of the cells.
  template <class See>
  void look_in_order(const See& see) {
    take(see, [this](std::size_t i) { return grid_.order()[i]; });
  }
  /// Memory that nobody else needs for a while.
  using Rooms = std::array<std::span<std::byte>, 2>;
  /// The outer lists. `rank` is the place by id of every old row. The rooms are written to.
  void build(double margin, const std::uint32_t* rank, const Rooms& rooms);
  /// Old row of each new row.
  const soa::Array<std::uint32_t>& source() const { return source_; }
  /// Puts the place by id of each new row in place of the old.
  void take_rank(soa::Array<std::uint32_t>& rank) { rank_.swap(rank); }

  /// The inner lists, of rows that are where `places` says.
  template <class T>
  void prune(const SpherePlace<T>* places, double margin);
  /// The outer lists themselves become the inner ones, where one margin is as good as two.
  void take_outer();
  const SlotLists& inner() const { return inner_; }
  std::uint64_t inner_entries() const { return entries_; }

  /// Gives the outer lists back: the next inner ones have to be built from cells.
  void release_outer() {
    outer_ = {};
    near_.release();
  }

 private:
  // Where a row comes to lie, and its place by id.
  struct NewPlace {
    std::uint32_t row;
    std::uint32_t rank;
  };
  // Room for the lists of a task before they are laid out.
  struct RawLists {
    std::span<std::uint32_t> room;
    std::vector<std::uint32_t>* more;
    std::uint32_t* data() const { return more->empty() ? room.data() : more->data(); }
  };

  template <class See, class Order>
  void take(const See& see, const Order& order) {
    for_rows(parallel_, rows_, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        const Sight sight = see(order(i));
        for (std::size_t c = 0; c < 3; ++c) search_[c][i] = sight.position[c];
        search_[3][i] = sight.radius;
      }
    });
  }
  SearchColumns sights() const {
    return {search_[0].data(), search_[1].data(), search_[2].data(), search_[3].data()};
  }
  RawLists raw_lists(std::size_t task);
  void list_rows(double margin);
  void place_rows(const std::uint32_t* rank);
  void lay_out();
  void lay_out_row(const std::uint32_t* raw, std::size_t count, std::int32_t* to, std::size_t slots,
                   std::vector<NewPlace>& list) const;
  void prune_group(std::size_t group);

  const ContactKernels& kernels_;
  const Parallel& parallel_;
  std::size_t rows_ = 0;
  SlotLists outer_;
  SlotLists inner_;
  std::uint64_t outer_entries_ = 0;
  std::uint64_t entries_ = 0;       // of the inner lists
  soa::Array<std::uint16_t> near_;  // of each outer slot, who is within the narrow margin, as bits
  soa::Array<std::uint32_t> source_;
  soa::Array<std::uint32_t> rank_;

  CellGrid grid_;
  soa::Array<double> search_[4];
  soa::Array<NewPlace> place_;  // of each row in the order of the cells
  // Lists as they were found, rows in the order of the cells: in the rooms that are lent, and those
  // of tasks whose lists are too long for that.
  Rooms rooms_;
  std::vector<std::vector<std::uint32_t>> long_lists_;
  soa::Array<std::uint32_t> raw_count_;
  soa::Array<std::uint32_t> raw_first_;  // within its task
};

}  // namespace salvo::solver
