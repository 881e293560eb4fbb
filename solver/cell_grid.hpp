// The uniform grid of the broad phase: which particles may touch. Particles are sorted by cell, so
// a row of neighboring cells along x is one run of particles; cells that hold nothing take no room,
// and the grid reaches as far as the particles do.
//
// Particles of very different size have grids of their own, a class each for every factor of 4 in
// the radius, or the cells of the largest would hold thousands of the smallest. A search looks into
// every class's grid.
//
// Nothing here can change a bit of a result: lists are supersets, and are put in order of the ids.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "soa/array.hpp"
#include "solver/parallel.hpp"

namespace salvo::solver {

/// Columns of particles that the grid is built over; a negative radius is left out.
struct SearchColumns {
  const double* x = nullptr;  // m
  const double* y = nullptr;
  const double* z = nullptr;
  const double* radius = nullptr;
};

/// The coordinate that cells are told: the same but for what is so far away that differences may
/// overflow, which seems to be nearer. Those that are near each other stay so.
inline constexpr double farthest_cell = 1e300;
inline double seen_by_cells(double coordinate) {
  return std::clamp(coordinate, -farthest_cell, farthest_cell);
}

/// Cells across a bar.
inline constexpr std::uint64_t bar = 8;
inline constexpr int most_classes = 12;  ///< 4^12 in radius

/// Cells of one size class. The counts along y and z are whole bars.
struct CellClass {
  double cell = 0;  ///< edge, m
  double inverse_cell = 0;
  double origin[3] = {};
  std::uint64_t counts[3] = {};
  std::uint64_t first_key = 0;
  double largest_radius = 0;
  std::uint64_t members = 0;

  /// All of its cells.
  std::uint64_t cells() const { return counts[0] * counts[1] * counts[2]; }
  /// Of the cell (i, j, k). Keys follow one another along j within a bar.
  std::uint64_t key(std::uint64_t i, std::uint64_t j, std::uint64_t k) const {
    const std::uint64_t number = k / bar * (counts[1] / bar) + j / bar;
    return first_key + ((number * counts[0] + i) * bar + k % bar) * bar + j % bar;
  }
};

/// What a search needs; plain data, for the kernels.
struct CellIndex {
  const CellClass* classes = nullptr;
  std::size_t class_count = 0;
  /// Keys in sorted order. The rows whose keys have the upper bits b start at directory[b].
  const std::uint64_t* keys = nullptr;
  const std::uint32_t* directory = nullptr;
  int shift = 0;  ///< a directory entry covers 2^shift keys
};

class CellGrid {
 public:
  CellGrid() { growth_.fill(1); }

  /// Finds the cells of `rows` particles: those within `margin` of touching are in cells that a
  /// search for margin visits. `cell_scale` >= 1 makes cells larger than they need be; they also
  /// grow from one build to the next while hardly any holds two particles.
  void build(const SearchColumns& columns, std::size_t rows, double margin, double cell_scale,
             const Parallel& parallel);

  /// Rows by cell, those left out last.
  std::span<const std::uint32_t> order() const { return {order_.data(), order_.size()}; }
  /// Rows that were not left out.
  std::size_t members() const { return members_; }
  CellIndex index() const;
  /// Gives the memory back.
  void release();

 private:
  void choose_classes(const SearchColumns& columns, std::size_t rows, double margin,
                      double cell_scale, const Parallel& parallel);
  void sort(std::size_t rows, int bits, const Parallel& parallel);
  void fill_directory(std::size_t rows, const Parallel& parallel);
  void choose_growth(std::size_t rows, const Parallel& parallel);

  std::vector<CellClass> classes_;
  std::array<double, most_classes> growth_;  // of the cells of each class, for the next build
  std::uint64_t cells_ = 0;
  soa::Array<std::uint64_t> keys_, other_keys_;
  soa::Array<std::uint32_t> order_, other_order_;
  soa::Array<std::uint32_t> counts_;
  soa::Array<std::uint32_t> directory_;
  int shift_ = 0;
  std::size_t members_ = 0;
};

}  // namespace salvo::solver
