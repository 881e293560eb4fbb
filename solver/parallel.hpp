// The one seam through which threads are used: oneTBB in production, std::thread under the thread
// sanitizer (through Debian's TBB it reports false races and misses real ones). Tasks are numbered;
// which thread runs a task changes nothing.
#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>

namespace salvo::solver {

/// Threads that the machine offers.
int hardware_threads();

/// A borrowed callable void(std::size_t): unlike std::function it never allocates, so a steady step
/// does not either.
class TaskRef {
 public:
  template <class Callable>
  requires(!std::is_same_v<std::remove_cvref_t<Callable>, TaskRef>)
      TaskRef(const Callable& callable)
      : object_(&callable), call_([](const void* object, std::size_t index) {
          (*static_cast<const Callable*>(object))(index);
        }) {}
  void operator()(std::size_t index) const { call_(object_, index); }

 private:
  const void* object_;
  void (*call_)(const void*, std::size_t);
};

class Parallel {
 public:
  explicit Parallel(int threads);
  ~Parallel();
  Parallel(const Parallel&) = delete;
  Parallel& operator=(const Parallel&) = delete;

  int threads() const { return threads_; }

  /// Calls task(0) .. task(tasks - 1), each once, and returns when all are done. Each task runs in
  /// the contract's floating-point environment. An exception of a task is rethrown here: the one of
  /// the lowest task number.
  void for_each(std::size_t tasks, TaskRef task) const;

 private:
  struct Arena;
  int threads_;
  std::unique_ptr<Arena> arena_;
};

}  // namespace salvo::solver
