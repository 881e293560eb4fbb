// Takes a world to a step in pieces of a fraction of a second, so that the progress is seen to
// move and Ctrl-C is heeded. Pieces are whole passes: they change neither bits nor speed.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>

#include "cli/interruption.hpp"
#include "solver/world.hpp"

namespace salvo::cli {

class Stepper {
 public:
  /// `after_piece` is called after each piece.
  Stepper(solver::World& world, std::function<void()> after_piece)
      : world_(world), after_piece_(std::move(after_piece)), piece_(world.execution().pass_steps) {}

  /// Stops before it when the user interrupts.
  void advance_to(std::int64_t step) {
    using Clock = std::chrono::steady_clock;
    while (world_.step() < step && !interrupted()) {
      const auto start = Clock::now();
      world_.advance_to(std::min(step, world_.step() + piece_));
      const auto taken = Clock::now() - start;
      if (taken < std::chrono::milliseconds(50)) {
        piece_ = std::min(longest, 2 * piece_);
      } else if (taken > std::chrono::milliseconds(200)) {
        piece_ = std::max<std::int64_t>(world_.execution().pass_steps, piece_ / 2);
      }
      after_piece_();
    }
  }

 private:
  static constexpr std::int64_t longest = 1 << 24;  // steps

  solver::World& world_;
  std::function<void()> after_piece_;
  std::int64_t piece_;
};

}  // namespace salvo::cli
