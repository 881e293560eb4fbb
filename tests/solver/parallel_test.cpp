// The seam through which threads are used: every task once, whatever the number of threads; the
// exception of the lowest task; the contract's floating-point environment inside, the caller's
// afterwards.
#include "solver/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "solver/floating_point_environment.hpp"
#include "tests/solver/foreign_environment.hpp"

namespace salvo::tests {

namespace {

using solver::FloatingPointEnvironment;
using solver::Parallel;

}  // namespace

TEST(Parallel, RunsEveryTaskOnce) {
  for (int threads = 1; threads <= 13; ++threads) {
    const Parallel parallel(threads);
    EXPECT_EQ(parallel.threads(), threads);
    for (const std::size_t tasks : {0, 1, 2, 3, 33, 1001}) {
      std::vector<std::atomic<int>> calls(tasks);
      parallel.for_each(tasks, [&](std::size_t i) { calls[i].fetch_add(1); });
      for (std::size_t i = 0; i < tasks; ++i) {
        ASSERT_EQ(calls[i], 1) << threads << " threads, " << tasks << " tasks, task " << i;
      }
    }
  }
}

// Tasks that wait for each other: they end only if as many run at once. On fewer cores too, and
// beside a seam of one thread.
TEST(Parallel, RunsAsManyTasksAtOnceAsItHasThreads) {
  const Parallel other(1);
  for (const int threads : {2, 3, 13}) {
    const Parallel parallel(threads);
    std::atomic<int> arrived = 0;
    std::atomic<int> late = 0;
    parallel.for_each(static_cast<std::size_t>(threads), [&](std::size_t) {
      const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
      arrived.fetch_add(1);
      while (arrived < threads && std::chrono::steady_clock::now() < deadline) {
        std::this_thread::yield();
      }
      if (arrived < threads) late.fetch_add(1);
    });
    EXPECT_EQ(late, 0) << threads << " threads";
  }
}

TEST(Parallel, TakesAtLeastOneThread) {
  EXPECT_EQ(Parallel(0).threads(), 1);
  EXPECT_EQ(Parallel(-3).threads(), 1);
  EXPECT_GE(solver::hardware_threads(), 1);
}

TEST(Parallel, RethrowsTheExceptionOfTheLowestTask) {
  for (const int threads : {1, 2, 3, 8, 13}) {
    const Parallel parallel(threads);
    for (int repeat = 0; repeat < 33; ++repeat) {
      std::atomic<int> ran = 0;
      try {
        parallel.for_each(99, [&](std::size_t i) {
          ran.fetch_add(1);
          if (i % 10 == 7) throw std::runtime_error(std::to_string(i));
        });
        FAIL() << "no exception with " << threads << " threads";
      } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(), "7") << threads;
      }
      EXPECT_EQ(ran, 99);  // the others still run: which ones would depend on the schedule
    }
    parallel.for_each(3, [](std::size_t) {});  // and the seam is of use afterwards
  }
}

#ifdef SALVO_TEST_FOREIGN_ENVIRONMENT

TEST(FloatingPoint, IsTheContractsInsideATaskAndTheCallersAfterwards) {
  for (const int threads : {1, 3, 13}) {
    const Parallel parallel(threads);
    const ForeignEnvironment foreign;
    EXPECT_FALSE(FloatingPointEnvironment::in_force());
    std::atomic<int> wrong = 0;
    volatile double one = 1;
    volatile double third_power = 1e-300;
    parallel.for_each(99, [&](std::size_t) {
      const double third = one / 3;
      const double denormal = third_power * 1e-20;
      if (!FloatingPointEnvironment::in_force()) wrong.fetch_add(1);
      if (third != 0x1.5555555555555p-2 || denormal == 0) wrong.fetch_add(1);
    });
    EXPECT_EQ(wrong, 0) << threads;
    EXPECT_TRUE(foreign.untouched()) << threads;
  }
}

TEST(FloatingPoint, IsRestoredWhenATaskThrows) {
  const Parallel parallel(3);
  const ForeignEnvironment foreign;
  EXPECT_THROW(parallel.for_each(9, [](std::size_t) { throw std::runtime_error("task"); }),
               std::runtime_error);
  EXPECT_TRUE(foreign.untouched());
}

#endif

}  // namespace salvo::tests
