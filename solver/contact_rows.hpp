// The rows of particles that touch, and their groups: how they are dealt out to tasks, numbered and
// put in order.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

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

/// Replaces how many slots each group has by which is its first; returns how many there are.
inline std::uint64_t number_slots(soa::Array<std::uint64_t>& first_slot, std::size_t groups) {
  std::uint64_t slots = 0;
  for (std::size_t group = 0; group < groups; ++group) {
    slots += std::exchange(first_slot[group], slots);
  }
  first_slot[groups] = slots;
  return slots;
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
