// A tile: a run of rows of constant length whose columns fit in the L2 cache, the unit of
// scheduling.
#pragma once

#include <cstddef>

#include "soa/column.hpp"

namespace salvo::solver {

inline constexpr std::size_t tile_rows = 4096;
static_assert(tile_rows % soa::block_rows == 0);

constexpr std::size_t tiles_of(std::size_t rows) { return (rows + tile_rows - 1) / tile_rows; }

}  // namespace salvo::solver
