#include "solver/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "solver/floating_point_environment.hpp"

#ifdef SALVO_PARALLEL_TBB
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace salvo::solver {

namespace {

// Keeps the exception of the lowest task number, whatever the schedule.
class FirstFailure {
 public:
  void run(TaskRef task, std::size_t index) {
    const FloatingPointEnvironment environment;
    try {
      task(index);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!failure_ || index < index_) {
        failure_ = std::current_exception();
        index_ = index;
      }
    }
  }
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  std::mutex mutex_;
  std::exception_ptr failure_;
  std::size_t index_ = 0;
};

}  // namespace

int hardware_threads() {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

#ifdef SALVO_PARALLEL_TBB

namespace {

// More threads than cores must be allowed: results may not depend on the count, and users test it.
// One limit for the whole process and for ever: of several, TBB takes the lowest, so that a world
// of one thread would leave every other world without workers.
void allow_threads(int threads) {
  if (threads <= hardware_threads()) return;
  static const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 1024);
}

}  // namespace

struct Parallel::Arena {
  explicit Arena(int threads) : arena((allow_threads(threads), threads)) {}
  tbb::task_arena arena;
};

void Parallel::for_each(std::size_t tasks, TaskRef task) const {
  FirstFailure failure;
  if (threads_ == 1 || tasks <= 1) {
    for (std::size_t i = 0; i < tasks; ++i) failure.run(task, i);
  } else {
    arena_->arena.execute([&] {
      tbb::parallel_for(
          std::size_t{0}, tasks, [&](std::size_t i) { failure.run(task, i); },
          tbb::simple_partitioner{});
    });
  }
  failure.rethrow();
}

#else

struct Parallel::Arena {
  explicit Arena(int) {}
};

void Parallel::for_each(std::size_t tasks, TaskRef task) const {
  FirstFailure failure;
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next.fetch_add(1); i < tasks; i = next.fetch_add(1)) failure.run(task, i);
  };
  std::vector<std::thread> others;
  for (std::size_t t = 1; t < static_cast<std::size_t>(threads_) && t < tasks; ++t) {
    others.emplace_back(work);
  }
  work();
  for (std::thread& other : others) other.join();
  failure.rethrow();
}

#endif

Parallel::Parallel(int threads)
    : threads_(std::max(1, threads)), arena_(std::make_unique<Arena>(threads_)) {}

Parallel::~Parallel() = default;

}  // namespace salvo::solver
