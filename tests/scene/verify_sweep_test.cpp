// Verifying scenes of trajectories: equal bits pass, and a planted difference is named.
#include "scene/verify_sweep.hpp"

#include <gtest/gtest.h>

#include <bit>

#include "scene/load_sweep.hpp"

namespace salvo::scene {
namespace {

SweepScene shots() {
  return parse_sweep(R"([shot_in_air]
speed = { normal = [300, 5] }
drag_factor = 1e-3
elevation = { uniform = [0.1, 0.7] }
ground = 0
[sweep]
samples = 3000
[integration]
step = 0.1
absolute_tolerance = 1e-6
time_limit = 100
record = ["apex"]
[samples]
levels = [1, 2]
[verify]
rows = 2500
)",
                     "shots.toml");
}

TEST(VerifySweep, EqualBitsPassOnEveryAxis) {
  const auto runs = verify(shots(), {});
  EXPECT_EQ(runs.size(), 1 + (solver::available_isas().size() - 1) + 5 + 2 + 1);
  for (const SweepVerifyRun& run : runs) {
    EXPECT_FALSE(run.difference) << run.axis << " " << run.value;
    EXPECT_EQ(run.hash, runs.front().hash);
  }
  EXPECT_EQ(runs.front().rows, 2500u);
}

// The last bit of one row's height at the end, in runs of more than one thread or of short pieces.
TEST(VerifySweep, APlantedDifferenceIsNamedByRowAndColumn) {
  SweepVerifyOptions options;
  options.run = [](const solver::Sweep& sweep, std::uint64_t first, std::uint64_t count,
                   const solver::Execution& execution) {
    solver::SweepRows rows = sweep.run(first, count, execution);
    const bool has_row = first <= 1234 && 1234 < first + count;
    if (has_row && (execution.threads == 3 || count == 97)) {
      for (std::size_t f = 0; f < sweep.fields().size(); ++f) {
        if (sweep.fields()[f].name != "end.x") continue;
        double& x = rows.table.column<double>(f)[1234 - first];
        x = std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) ^ 1);
      }
    }
    return rows;
  };
  int found = 0;
  for (const SweepVerifyRun& run : verify(shots(), options)) {
    const bool planted =
        (run.axis == "threads" && run.value == "3") || (run.axis == "chunk" && run.value == "97");
    ASSERT_EQ(run.difference.has_value(), planted) << run.axis << " " << run.value;
    if (!planted) continue;
    ++found;
    EXPECT_EQ(run.difference->index, 1234u);
    EXPECT_EQ(run.difference->column, "end.x");
    EXPECT_NE(run.difference->reference, run.difference->varied);
  }
  EXPECT_EQ(found, 2);
}

TEST(VerifySweep, ASamplesTimeCounts) {
  SweepVerifyOptions options;
  options.run = [](const solver::Sweep& sweep, std::uint64_t first, std::uint64_t count,
                   const solver::Execution& execution) {
    solver::SweepRows rows = sweep.run(first, count, execution);
    if (execution.threads == 13 || (count == 1 && first == 0)) rows.sample_time[1] += 1e-15;
    return rows;
  };
  int found = 0;
  for (const SweepVerifyRun& run : verify(shots(), options)) {
    const bool planted = (run.axis == "threads" && run.value == "13") || run.axis == "alone";
    ASSERT_EQ(run.difference.has_value(), planted) << run.axis << " " << run.value;
    if (!planted) continue;
    ++found;
    EXPECT_EQ(run.difference->index, 0U);
    EXPECT_EQ(run.difference->column, "samples.time[1]");
  }
  EXPECT_EQ(found, 2);
}

}  // namespace
}  // namespace salvo::scene
