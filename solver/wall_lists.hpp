// The parts of walls that each group of rows may reach before its lists are built again, and what
// the contacts with them remember.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "models/contact_law.hpp"
#include "soa/array.hpp"
#include "solver/contact_pass.hpp"
#include "solver/contact_rows.hpp"
#include "solver/neighbor_lists.hpp"
#include "solver/walls.hpp"

namespace salvo::solver {

/// Part numbers, slot after slot: one for all rows of a group.
struct WallParts {
  soa::Array<std::uint64_t> first_slot;  // of each group, and their number
  soa::Array<std::uint32_t> part;
};

/// Which parts come within `margin` of rows that are where see(row) says.
template <class See>
void find_wall_parts(const See& see, std::size_t rows, const Walls& walls, double margin,
                     const Parallel& parallel, WallParts& found) {
  const std::size_t groups = rows / group_rows;
  found.first_slot.resize(groups + 1);
  std::vector<std::vector<std::uint32_t>> parts(tasks_of(groups, groups_per_task));
  for_groups(parallel, rows, [&](std::size_t task, std::size_t first, std::size_t last) {
    std::vector<std::uint32_t>& own = parts[task];
    for (std::size_t group = first; group < last; ++group) {
      Bounds bounds;
      for (std::size_t row = group * group_rows; row < (group + 1) * group_rows; ++row) {
        const Sight sight = see(row);
        if (sight.radius > 0) {
          bounds.add({sight.position[0], sight.position[1], sight.position[2]}, sight.radius);
        }
      }
      const std::size_t before = own.size();
      if (!bounds.empty()) walls.near(bounds, margin, own);
      found.first_slot[group] = own.size() - before;
    }
  });
  found.part.resize(number_slots(found.first_slot, groups));
  std::uint32_t* to = found.part.data();
  for (const auto& own : parts) to = std::copy(own.begin(), own.end(), to);
}

template <class T>
struct WallLists : WallParts {
  soa::Array<std::uint16_t> touching;
  soa::Array<T> tangential;
  soa::Array<T> rolling;

  /// Room for the parts, which nothing touches at first.
  void make_room(const models::ContactLaw& law) {
    const std::size_t slots = part.size();
    touching.resize(slots);
    std::fill_n(touching.data(), slots, std::uint16_t{0});
    const std::size_t numbers = slots * 3 * group_rows;
    if (law.remembers()) tangential.resize(numbers);
    if (law.rolls()) rolling.resize(numbers);
  }
  /// The kernel reads the slot of all lanes when one of them touched.
  void clear_slot(std::size_t slot, const models::ContactLaw& law) {
    constexpr std::size_t numbers = 3 * group_rows;
    const auto clear = [&](soa::Array<T>& column) {
      std::fill_n(column.data() + slot * numbers, numbers, T(0));
    };
    if (law.remembers()) clear(tangential);
    if (law.rolls()) clear(rolling);
  }
  WallMemory<T> memory() { return {touching.data(), tangential.data(), rolling.data()}; }
};

}  // namespace salvo::solver
