// A data race through solver/parallel, planted: two tasks that run at the same time write one plain
// int. Thread sanitizer must report it, or its silence about everything else says nothing.
#include <atomic>
#include <cstdio>
#include <thread>

#include "solver/parallel.hpp"

int main() {
  const salvo::solver::Parallel parallel(2);
  std::atomic<int> arrived = 0;
  int raced = 0;
  parallel.for_each(2, [&](std::size_t task) {
    // Both tasks are under way before either writes. Relaxed, so that waiting orders nothing.
    arrived.fetch_add(1, std::memory_order_relaxed);
    while (arrived.load(std::memory_order_relaxed) < 2) std::this_thread::yield();
    raced = static_cast<int>(task);
  });
  std::printf("%d\n", raced);
}
