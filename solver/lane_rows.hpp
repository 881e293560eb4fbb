// The rows that the lanes of one task hold: each lane has its row, its time and its step, and takes
// up the next row of the queue when its row ends, so that short rows do not leave lanes idle.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "kernels/lane.hpp"
#include "soa/aligned_bytes.hpp"
#include "solver/batch.hpp"

namespace salvo::solver {
inline namespace SALVO_ISA {

template <class W, std::size_t N>
typename W::Mask all_finite(const std::array<W, N>& y) {
  // x - x is zero, or NaN where x is not finite: one comparison for all.
  W sum = y[0] - y[0];
  for (std::size_t i = 1; i < N; ++i) sum = sum + (y[i] - y[i]);
  return sum == W(0);
}

/// Which lanes' rows have ended, and why; where none of the others says so, at the end or the step
/// limit.
template <class W>
struct Ending {
  using Mask = typename W::Mask;
  Mask ended{false};
  Mask lost{false};
  Mask shortened{false};
  Mask event{false};  // of which the queue of remarkable steps makes the end
};

/// A mask, lane by lane.
template <class W>
class Flags {
 public:
  explicit Flags(typename W::Mask mask) { select(mask, W(1), W(0)).store(ones_); }
  bool operator[](std::size_t lane) const { return ones_[lane] != 0; }

 private:
  alignas(soa::alignment) typename W::Real ones_[W::width];
};

/// What the lanes know of their rows. W is a lane type, M the model over it.
template <class W, class M>
class LaneRows {
 public:
  using T = typename W::Real;
  using Mask = typename W::Mask;
  static constexpr std::size_t states = M::state_fields.size();
  static constexpr std::size_t parameters = M::parameter_fields.size();
  using State = std::array<W, states>;

  explicit LaneRows(IntegratePass<T>& pass) : pass_(pass), next_(pass.first_row) {
    for (std::size_t lane = 0; lane < W::width; ++lane) {
      for (auto& column : state_) column[lane] = 0;
      for (auto& column : parameter_) column[lane] = 1;
      clear(lane);
    }
    for (std::size_t lane = 0; lane < W::width; ++lane) take_next(lane);
    load();
  }

  /// Hands in the rows that have ended and takes up others.
  [[gnu::noinline]] void replace(const Ending<W>& ending) {
    const Flags<W> ended(ending.ended);
    const Flags<W> lost(ending.lost);
    const Flags<W> shortened(ending.shortened);
    const Flags<W> event(ending.event);
    save();
    for (std::size_t lane = 0; lane < W::width; ++lane) {
      if (!ended[lane]) continue;
      hand_in(lane, event[lane]                 ? Outcome::event
                    : lost[lane]                ? Outcome::not_finite
                    : time_[lane] >= end_[lane] ? Outcome::time_limit
                    : shortened[lane]           ? Outcome::smallest_step
                                                : Outcome::step_limit);
      take_next(lane);
    }
    load();
  }

  std::size_t row(std::size_t lane) const { return row_[lane]; }

  /// The samples' quantity has come to `reached`: the next level of each lane is the first above.
  void pass_levels(W reached) {
    alignas(soa::alignment) Column to;
    reached.store(to);
    for (std::size_t lane = 0; lane < W::width; ++lane) {
      while (next_level_[lane] <= to[lane]) set_level(lane, level_[lane] + 1);
    }
    next_level = W::load(next_level_);
  }

  bool any_left() const { return busy_ != 0; }
  std::size_t busy() const { return busy_; }

  // Of each lane's row; between replacements they live in registers.
  State y;
  std::array<W, parameters> p;
  State slope;     // f(t, y), where not fresh
  W steps;         // tried
  W time;          // since t0, s
  W compensation;  // what rounding took from `time`
  W end;           // since t0, s
  W total;         // fixed steps to the end
  W step;          // to try, s
  W last_error;    // of the last step: a root of it, as its method controls it
  W next_level;    // at which a sample is taken
  Mask working{false};
  Mask fresh{false};  // taken up since the last replacement

 private:
  using Column = T[W::width];

  void clear(std::size_t lane) {
    row_[lane] = none;
    steps_[lane] = time_[lane] = compensation_[lane] = end_[lane] = total_[lane] = 0;
    step_[lane] = static_cast<T>(pass_.integration.step);
    last_error_[lane] = 1;
    fresh_[lane] = 1;
    set_level(lane, 0);
  }

  void set_level(std::size_t lane, std::size_t level) {
    level_[lane] = level;
    next_level_[lane] = level < pass_.samples.count ? static_cast<T>(pass_.samples.levels[level])
                                                    : std::numeric_limits<T>::infinity();
  }

  void take_next(std::size_t lane) {
    clear(lane);
    if (next_ == pass_.last_row) return;
    const std::size_t row = next_++;
    for (std::size_t i = 0; i < states; ++i) state_[i][lane] = pass_.state[i][row];
    for (std::size_t i = 0; i < parameters; ++i) parameter_[i][lane] = pass_.parameters[i][row];
    end_[lane] = static_cast<T>(pass_.end[row] - pass_.t0);
    // A last step of a millionth is a whole one and rounding.
    total_[lane] =
        static_cast<T>(std::ceil((pass_.end[row] - pass_.t0) / pass_.integration.step - 1e-6));
    row_[lane] = row;
    ++busy_;
  }

  void hand_in(std::size_t lane, Outcome outcome) {
    const std::size_t row = row_[lane];
    --busy_;
    pass_.steps[row] = static_cast<std::uint32_t>(steps_[lane]);
    if (outcome == Outcome::event) return;
    for (std::size_t i = 0; i < states; ++i) pass_.state[i][row] = state_[i][lane];
    pass_.time[row] = outcome == Outcome::time_limit ? pass_.end[row]
                                                     : pass_.t0 + static_cast<double>(time_[lane]);
    pass_.outcome[row] = outcome;
  }

  void save() {
    for (std::size_t i = 0; i < states; ++i) y[i].store(state_[i]);
    for (std::size_t i = 0; i < states; ++i) slope[i].store(slope_[i]);
    steps.store(steps_);
    time.store(time_);
    compensation.store(compensation_);
    step.store(step_);
    last_error.store(last_error_);
    for (std::size_t lane = 0; lane < W::width; ++lane) fresh_[lane] = 0;
  }

  void load() {
    for (std::size_t i = 0; i < states; ++i) y[i] = W::load(state_[i]);
    for (std::size_t i = 0; i < states; ++i) slope[i] = W::load(slope_[i]);
    for (std::size_t i = 0; i < parameters; ++i) p[i] = W::load(parameter_[i]);
    steps = W::load(steps_);
    time = W::load(time_);
    compensation = W::load(compensation_);
    end = W::load(end_);
    total = W::load(total_);
    step = W::load(step_);
    last_error = W::load(last_error_);
    next_level = W::load(next_level_);
    alignas(soa::alignment) Column has_row;
    for (std::size_t lane = 0; lane < W::width; ++lane) has_row[lane] = row_[lane] != none ? 1 : 0;
    working = W::load(has_row) > W(0);
    fresh = W::load(fresh_) > W(0);
  }

  static constexpr std::size_t none = ~std::size_t{0};
  IntegratePass<T>& pass_;
  std::size_t next_;
  std::size_t busy_ = 0;
  std::size_t row_[W::width];
  std::size_t level_[W::width];
  alignas(soa::alignment) Column state_[states];
  alignas(soa::alignment) Column slope_[states] = {};
  alignas(soa::alignment) Column parameter_[parameters == 0 ? 1 : parameters];
  alignas(soa::alignment) Column steps_;
  alignas(soa::alignment) Column time_;
  alignas(soa::alignment) Column compensation_;
  alignas(soa::alignment) Column end_;
  alignas(soa::alignment) Column total_;
  alignas(soa::alignment) Column step_;
  alignas(soa::alignment) Column last_error_;
  alignas(soa::alignment) Column next_level_;
  alignas(soa::alignment) Column fresh_;
};

}  // namespace SALVO_ISA
}  // namespace salvo::solver
