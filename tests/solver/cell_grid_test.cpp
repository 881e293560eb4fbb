// The broad phase against all pairs: a list holds who is within reach, each once, and nobody who is
// clearly out of reach.
#include "solver/cell_grid.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "solver/contact_pass.hpp"
#include "solver/isa.hpp"

namespace salvo::tests {
namespace {

using solver::CellGrid;
using solver::Isa;
using solver::ListPass;
using solver::Parallel;
using solver::SearchColumns;

struct Cloud {
  std::string name;
  std::vector<double> x, y, z, radius;

  std::size_t rows() const { return x.size(); }
  void add(double px, double py, double pz, double r) {
    x.push_back(px);
    y.push_back(py);
    z.push_back(pz);
    radius.push_back(r);
  }
  SearchColumns columns() const { return {x.data(), y.data(), z.data(), radius.data()}; }
};

using Neighbors = std::vector<std::vector<std::uint32_t>>;

// With a reach that is larger by a factor.
Neighbors all_pairs(const Cloud& cloud, double margin, double factor = 1) {
  Neighbors near(cloud.rows());
  for (std::size_t i = 0; i < cloud.rows(); ++i) {
    for (std::size_t j = 0; j < cloud.rows(); ++j) {
      if (i == j || cloud.radius[i] < 0 || cloud.radius[j] < 0) continue;
      const double dx = cloud.x[j] - cloud.x[i];
      const double dy = cloud.y[j] - cloud.y[i];
      const double dz = cloud.z[j] - cloud.z[i];
      const double reach = (cloud.radius[j] + (cloud.radius[i] + margin)) * factor;
      if (dx * dx + dy * dy + dz * dz < reach * reach) {
        near[i].push_back(static_cast<std::uint32_t>(j));
      }
    }
  }
  return near;
}

// By the cells and the kernel of one instruction set, a few rows a pass.
Neighbors listed(const Cloud& cloud, double margin, double cell_scale, Isa isa, int threads) {
  const Parallel parallel(threads);
  CellGrid grid;
  // Cells of later builds may be larger.
  for (int build = 0; build < threads; ++build) {
    grid.build(cloud.columns(), cloud.rows(), margin, cell_scale, parallel);
  }
  Cloud sorted;
  for (const std::uint32_t row : grid.order()) {
    sorted.add(cloud.x[row], cloud.y[row], cloud.z[row], cloud.radius[row]);
  }
  EXPECT_EQ(sorted.rows(), cloud.rows());
  for (std::size_t i = 0; i < cloud.rows(); ++i) {
    EXPECT_EQ(sorted.radius[i] >= 0, i < grid.members());
  }
  // A pack reads on after the last row: what it finds there would be near.
  for (std::size_t i = 0; i < solver::group_rows; ++i) {
    if (cloud.rows() > 0) sorted.add(cloud.x[0], cloud.y[0], cloud.z[0], 1e9);
  }
  Neighbors near(cloud.rows());
  constexpr std::size_t rows_each = 77;
  for (std::size_t first = 0; first < grid.members(); first += rows_each) {
    std::vector<std::uint32_t> entries;
    std::vector<std::uint32_t> counts(rows_each);
    ListPass pass;
    pass.first_row = first;
    pass.last_row = std::min(grid.members(), first + rows_each);
    pass.index = grid.index();
    pass.columns = sorted.columns();
    pass.margin = margin;
    pass.owner = &entries;
    pass.grow = [](void* owner, std::size_t& size) {
      auto& all = *static_cast<std::vector<std::uint32_t>*>(owner);
      if (all.size() < size) all.resize(size);
      return all.data();
    };
    pass.counts = counts.data();
    solver::contact_kernels(isa).list_neighbors(pass);
    std::size_t at = 0;
    for (std::size_t row = first; row < pass.last_row; ++row) {
      std::vector<std::uint32_t>& list = near[grid.order()[row]];
      for (std::uint32_t n = 0; n < counts[row - first]; ++n) {
        list.push_back(grid.order()[entries[at++]]);
      }
      std::sort(list.begin(), list.end());
    }
    EXPECT_EQ(at, pass.entries);
  }
  return near;
}

class Draws {
 public:
  explicit Draws(std::uint64_t seed) : engine_(seed) {}
  double within(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
  }

 private:
  std::mt19937_64 engine_;
};

Cloud random_cloud(const std::string& name, std::size_t rows, double center, double extent,
                   double smallest, double largest) {
  Cloud cloud{name + ", " + std::to_string(rows), {}, {}, {}, {}};
  Draws draws(rows + 1);
  for (std::size_t row = 0; row < rows; ++row) {
    const double x = center + draws.within(-extent, extent);
    const double y = -center + draws.within(-extent, extent);
    const double z = center + draws.within(-extent, extent);
    // Even on a scale of factors.
    cloud.add(x, y, z, smallest * std::pow(largest / smallest, draws.within(0, 1)));
  }
  return cloud;
}

std::vector<Cloud> clouds() {
  std::vector<Cloud> all;
  for (const std::size_t rows : {0, 1, 2, 15, 16, 17, 63, 1000, 5000}) {
    // An extent for about ten neighbors each.
    const double extent = 0.01 * std::cbrt(static_cast<double>(rows) + 1);
    all.push_back(random_cloud("loose", rows, 0, extent, 0.01, 0.01));
    all.push_back(random_cloud("of many sizes", rows, 0, 3 * extent, 0.001, 0.15));
  }
  all.push_back(random_cloud("dense", 1000, 0, 0.03, 0.01, 0.012));
  all.push_back(random_cloud("all in reach of all", 300, 0, 0.001, 0.01, 0.01));
  all.push_back(random_cloud("at 1e6", 1000, 1e6, 0.08, 0.005, 0.01));
  all.push_back(random_cloud("at -1e6", 1000, -1e6, 0.08, 0.0001, 0.01));
  all.push_back(random_cloud("sparse", 1000, 0, 1e9, 0.001, 0.01));
  // A tenth of a micrometer is what a double resolves there.
  all.push_back(random_cloud("tiny at 1e9", 1000, 1e9, 2e-5, 1e-6, 2e-6));
  all.push_back(random_cloud("of 1 to 100 in radius", 3000, 0, 0.4, 0.001, 0.1));

  // Pairs that are far from all others: more empty cells than can be numbered.
  Cloud pairs{"pairs over 1e9 m", {}, {}, {}, {}};
  Draws draws(3);
  for (int i = 0; i < 200; ++i) {
    const double x = draws.within(-1e9, 1e9);
    const double y = draws.within(-1e9, 1e9);
    const double z = draws.within(-1e9, 1e9);
    pairs.add(x, y, z, 0.01);
    pairs.add(x + draws.within(-0.02, 0.02), y, z + draws.within(-0.02, 0.02), 0.01);
  }
  all.push_back(pairs);

  // A crowd and a few far away: cells are so large that they hold it all.
  Cloud lost = random_cloud("with some lost at 1e16 m", 500, 3, 0.05, 0.001, 0.01);
  for (std::size_t row = 0; row < lost.rows(); row += 50) lost.x[row] = draws.within(-1e16, 1e16);
  all.push_back(lost);

  Cloud edge = random_cloud("with some where coordinates end", 500, 3, 0.05, 0.001, 0.01);
  for (std::size_t row = 0; row < edge.rows(); row += 20) {
    edge.y[row] = solver::seen_by_cells(row % 40 == 0 ? 1.7e308 : -1.7e308);
  }
  all.push_back(edge);

  Cloud large = random_cloud("of many small about a few large", 5000, 0, 0.3, 0.005, 0.005);
  for (std::size_t row = 0; row < large.rows(); row += 1000) large.radius[row] = 0.5;
  all.push_back(large);

  // More candidates than are fetched at a time, for one row even.
  Cloud stacked{"thousands in one place", {}, {}, {}, {}};
  for (int i = 0; i < 4200; ++i) stacked.add(1, 2, 3, 0.01);
  for (int i = 0; i < 100; ++i) stacked.add(1, 2, 3.001, 0.001);  // of another class of cells
  all.push_back(stacked);

  Cloud coincident{"coincident", {}, {}, {}, {}};
  for (int i = 0; i < 100; ++i) coincident.add(i % 3, 0, -1, 0.01 * (1 + i % 2));
  all.push_back(coincident);

  Cloud line{"on a line", {}, {}, {}, {}};
  for (int i = 0; i < 500; ++i) line.add(draws.within(-1, 1), 2, 2, 0.005);
  all.push_back(line);

  // On the borders of cells, whose edge is 2 r + margin: reached and just out of reach.
  Cloud lattice{"on a lattice", {}, {}, {}, {}};
  for (int i = 0; i < 1000; ++i) lattice.add(i % 10, i / 10 % 10, i / 100, 0.375);
  all.push_back(lattice);

  // Those that are gone have a negative radius.
  Cloud holes = random_cloud("with the dead among them", 1000, 0, 0.08, 0.001, 0.02);
  for (std::size_t row = 0; row < holes.rows(); row += 3) holes.radius[row] = -1;
  all.push_back(holes);
  Cloud dead = random_cloud("of the dead", 33, 0, 0.08, 0.01, 0.02);
  for (double& radius : dead.radius) radius = -1;
  all.push_back(dead);

  Cloud points = random_cloud("of points", 300, 0, 0.05, 0.01, 0.01);
  for (double& radius : points.radius) radius = 0;
  all.push_back(points);
  return all;
}

// Both ascend.
bool includes(const std::vector<std::uint32_t>& all, const std::vector<std::uint32_t>& some) {
  return std::includes(all.begin(), all.end(), some.begin(), some.end());
}

TEST(CellGrid, ListsWhoIsWithinReachAndNobodyElse) {
  constexpr double rounding = 1.001;
  for (const Cloud& cloud : clouds()) {
    for (const double margin : {0.0, 0.002, 0.25}) {
      if (margin > 0.1 && cloud.rows() > 1000) continue;
      const Neighbors wanted = all_pairs(cloud, margin);
      const Neighbors allowed = all_pairs(cloud, margin, rounding);
      for (const Isa isa : solver::available_isas()) {
        for (const double cell_scale : {1.0, 1.37, 5.0}) {
          const int threads = cell_scale == 1 ? 1 : 3;
          const Neighbors got = listed(cloud, margin, cell_scale, isa, threads);
          for (std::size_t row = 0; row < cloud.rows(); ++row) {
            const std::vector<std::uint32_t>& list = got[row];
            ASSERT_TRUE(includes(list, wanted[row]) && includes(allowed[row], list) &&
                        std::adjacent_find(list.begin(), list.end()) == list.end())
                << cloud.name << ", row " << row << ", margin " << margin << ", cells "
                << cell_scale << ", " << name(isa);
          }
        }
      }
    }
  }
}

// Cells grow from build to build where they are empty, not where particles crowd.
TEST(CellGrid, GrowsCellsThatAreEmpty) {
  Cloud crowd = random_cloud("a crowd in an empty room", 2000, 0, 0.05, 0.005, 0.005);
  const Cloud dense = crowd;
  Draws draws(7);
  for (int i = 0; i < 500; ++i) {
    crowd.add(draws.within(-2, 2), draws.within(-2, 2), draws.within(-2, 2), 0.005);
  }
  Cloud gas{"gas", {}, {}, {}, {}};
  for (int i = 0; i < 2000; ++i) {
    gas.add(draws.within(-2, 2), draws.within(-2, 2), draws.within(-2, 2), 0.005);
  }
  const auto growth = [](const Cloud& cloud) {
    CellGrid grid;
    std::vector<double> cells;
    for (int build = 0; build < 20; ++build) {
      grid.build(cloud.columns(), cloud.rows(), 0.001, 1, Parallel(2));
      cells.push_back(grid.index().classes->cell);
    }
    EXPECT_EQ(cells[18], cells[19]);
    return cells.back() / cells.front();
  };
  EXPECT_EQ(growth(dense), 1);
  EXPECT_LE(growth(crowd), 2);
  EXPECT_GE(growth(gas), 8);
}

// The clouds above are the cases that they are named for.
TEST(CellGrid, IsTestedOnListsOfAllLengths) {
  const auto mean = [](const Cloud& cloud) {
    std::size_t sum = 0;
    for (const auto& list : all_pairs(cloud, 0.002)) sum += list.size();
    return static_cast<double>(sum) / static_cast<double>(cloud.rows());
  };
  EXPECT_EQ(mean(random_cloud("sparse", 1000, 0, 1e9, 0.001, 0.01)), 0);
  const double loose = mean(random_cloud("loose", 5000, 0, 0.171, 0.01, 0.01));
  EXPECT_GT(loose, 2);
  EXPECT_LT(loose, 20);
  EXPECT_GT(mean(random_cloud("dense", 1000, 0, 0.03, 0.01, 0.012)), 100);
  EXPECT_EQ(mean(random_cloud("all", 300, 0, 0.001, 0.01, 0.01)), 299);
}

// Rows that are more than one task sorts, in the order of their cells.
TEST(CellGrid, SortsTheSameForAnyThreads) {
  const Cloud cloud = random_cloud("large", 50'000, 5, 1, 0.001, 0.05);
  CellGrid wanted;
  wanted.build(cloud.columns(), cloud.rows(), 0.001, 1, Parallel(1));
  for (const int threads : {2, 3, 13}) {
    CellGrid grid;
    grid.build(cloud.columns(), cloud.rows(), 0.001, 1, Parallel(threads));
    EXPECT_TRUE(std::ranges::equal(grid.order(), wanted.order()));
  }
  const solver::CellIndex index = wanted.index();
  for (std::size_t row = 1; row < cloud.rows(); ++row) {
    ASSERT_LE(index.keys[row - 1], index.keys[row]);
    // Equal cells keep the order of the rows.
    if (index.keys[row - 1] == index.keys[row]) {
      ASSERT_LT(wanted.order()[row - 1], wanted.order()[row]);
    }
  }
}

}  // namespace
}  // namespace salvo::tests
