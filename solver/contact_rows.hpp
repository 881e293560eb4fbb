// How the rows of particles that touch are dealt out to tasks.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "soa/array.hpp"
#include "solver/contact_pass.hpp"
#include "solver/parallel.hpp"

namespace salvo::solver {

inline constexpr std::size_t groups_per_task = 64;
inline constexpr std::size_t rows_per_task = groups_per_task * group_rows;

inline std::size_t tasks_of(std::size_t things, std::size_t each) {
  return (things + each - 1) / each;
}

/// Calls task(first row, last row) for all rows.
template <class Task>
void for_rows(const Parallel& parallel, std::size_t rows, const Task& task) {
  parallel.for_each(tasks_of(rows, rows_per_task), [&](std::size_t number) {
    const std::size_t first = number * rows_per_task;
    task(first, std::min(rows, first + rows_per_task));
  });
}

/// Calls task(number, first group, last group) for the groups of all rows.
template <class Task>
void for_groups(const Parallel& parallel, std::size_t rows, const Task& task) {
  const std::size_t groups = rows / group_rows;
  parallel.for_each(tasks_of(groups, groups_per_task), [&](std::size_t number) {
    const std::size_t first = number * groups_per_task;
    task(number, first, std::min(groups, first + groups_per_task));
  });
}

/// Puts a column into the order of new rows. `room` is written to.
template <class Number>
void permute(const Parallel& parallel, std::size_t rows, const soa::Array<std::uint32_t>& source,
             soa::Array<Number>& column, soa::Array<Number>& room) {
  room.resize(rows);
  for_rows(parallel, rows, [&](std::size_t first, std::size_t last) {
    for (std::size_t row = first; row < last; ++row) room[row] = column[source[row]];
  });
  column.swap(room);
}

}  // namespace salvo::solver
