#include "solver/wall_lists.hpp"

#include <vector>

namespace salvo::solver {

void find_wall_parts(const NeighborLists& lists, std::size_t rows, const Walls& walls,
                     double margin, const Parallel& parallel, WallParts& found) {
  const std::size_t groups = rows / group_rows;
  const SearchColumns at = lists.sights();
  std::vector<std::vector<std::uint32_t>> parts(tasks_of(rows, rows_per_task));
  std::vector<std::uint32_t> counts(groups);
  for_rows(parallel, rows, [&](std::size_t first, std::size_t last) {
    std::vector<std::uint32_t>& own = parts[first / rows_per_task];
    // Rows stay in the window of their place among the cells, and a task is whole windows.
    std::vector<Bounds> bounds((last - first) / group_rows);
    for (std::size_t i = first; i < last; ++i) {
      if (!(at.radius[i] > 0)) continue;
      bounds[(lists.new_row(i) - first) / group_rows].add({at.x[i], at.y[i], at.z[i]},
                                                          at.radius[i]);
    }
    for (std::size_t n = 0; n < bounds.size(); ++n) {
      if (bounds[n].empty()) continue;
      const std::size_t before = own.size();
      walls.near(bounds[n], margin, own);
      counts[first / group_rows + n] = static_cast<std::uint32_t>(own.size() - before);
    }
  });
  found.first_slot.resize(groups + 1);
  std::uint64_t slots = 0;
  for (std::size_t group = 0; group < groups; ++group) {
    found.first_slot[group] = slots;
    slots += counts[group];
  }
  found.first_slot[groups] = slots;
  found.part.resize(slots);
  std::uint32_t* to = found.part.data();
  for (const auto& own : parts) to = std::copy(own.begin(), own.end(), to);
}

}  // namespace salvo::solver
