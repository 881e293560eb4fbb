// Takes rows of a model to their own ends in the lanes of one task: each lane has its row, its time
// and its step, and takes up the next row of the queue when its row ends, so that short rows do not
// leave lanes idle. What a row computes depends on nothing but the row.
//
// The step is controlled by the error of the last two steps (PI control, Hairer, Norsett, Wanner,
// II.4 and IV.2; exponents 1/8 and 1/16 instead of the usual 0.14 and 0.08, because four square
// roots take less time than one power).
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "integrators/crossing.hpp"
#include "integrators/embedded_pair.hpp"
#include "integrators/runge_kutta.hpp"
#include "kernels/dual.hpp"
#include "kernels/pair.hpp"
#include "soa/aligned_bytes.hpp"
#include "solver/batch.hpp"

namespace salvo::solver {
inline namespace SALVO_ISA {

using integrators::EmbeddedPair;

template <class W, std::size_t N>
typename W::Mask all_finite(const std::array<W, N>& y) {
  // x - x is zero, or NaN where x is not finite: one comparison for all.
  W sum = y[0] - y[0];
  for (std::size_t i = 1; i < N; ++i) sum = sum + (y[i] - y[i]);
  return sum == W(0);
}

/// The model's events; none when it lists none.
template <class M>
inline constexpr std::span<const models::Event> events_of = [] {
  if constexpr (requires { M::events; }) {
    return std::span<const models::Event>(M::events);
  } else {
    return std::span<const models::Event>();
  }
}();

/// Which lanes' rows have ended, and why; where neither of the others says so, at the end or the
/// step limit.
template <class W>
struct Ending {
  using Mask = typename W::Mask;
  Mask ended{false};
  Mask lost{false};
  Mask shortened{false};
  Mask event{false};
  W number{0};  // of the event
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
    alignas(soa::alignment) Column ended;
    alignas(soa::alignment) Column lost;
    alignas(soa::alignment) Column shortened;
    alignas(soa::alignment) Column event;
    alignas(soa::alignment) Column number;
    const auto ones = [](Mask mask) { return select(mask, W(1), W(0)); };
    ones(ending.ended).store(ended);
    ones(ending.lost).store(lost);
    ones(ending.shortened).store(shortened);
    ones(ending.event).store(event);
    ending.number.store(number);
    save();
    for (std::size_t lane = 0; lane < W::width; ++lane) {
      if (ended[lane] == T(0)) continue;
      const Outcome outcome = lost[lane] != T(0)          ? Outcome::not_finite
                              : event[lane] != T(0)       ? Outcome::event
                              : time_[lane] >= end_[lane] ? Outcome::time_limit
                              : shortened[lane] != T(0)   ? Outcome::smallest_step
                                                          : Outcome::step_limit;
      hand_in(lane, outcome);
      if (outcome == Outcome::event) {
        pass_.event[row_[lane]] = static_cast<std::uint8_t>(number[lane]);
      }
      take_next(lane);
    }
    load();
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
  W last_error;    // of the last step, to the power of 1/16
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
    for (std::size_t i = 0; i < states; ++i) pass_.state[i][row] = state_[i][lane];
    pass_.time[row] = outcome == Outcome::time_limit ? pass_.end[row]
                                                     : pass_.t0 + static_cast<double>(time_[lane]);
    pass_.steps[row] = static_cast<std::uint32_t>(steps_[lane]);
    pass_.outcome[row] = outcome;
    --busy_;
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
  alignas(soa::alignment) Column fresh_;
};

// What the loops below step is copied out of LaneRows, whose address is taken: the compiler keeps
// only what is local in registers.

/// Fixed steps of `step(y, t, h, p)`. Time is n steps, never a sum; the last step ends at the end.
template <class W, class M, class Step>
SALVO_FLATTEN void integrate_fixed(IntegratePass<typename W::Real>& pass, const Step& step) {
  LaneRows<W, M> rows(pass);
  const W whole(pass.integration.step);
  const W t0(pass.t0);
  const W most(static_cast<typename W::Real>(pass.integration.most_steps));
  while (rows.any_left()) {
    auto y = rows.y;
    const auto p = rows.p;
    W steps = rows.steps;
    W time = rows.time;
    const W end = rows.end;
    const W total = rows.total;
    const auto working = rows.working;
    Ending<W> ending;
    std::uint64_t taken = 0;
    do {
      ++taken;
      const auto last = steps + W(1) >= total;
      y = step(y, t0 + time, select(last, end - time, whole), p);
      steps = steps + W(1);
      time = select(last, end, steps * whole);
      ending.lost = !all_finite(y);
      ending.ended = working & (last | ending.lost | (steps >= most));
    } while (!any(ending.ended));
    pass.useful_steps += taken * rows.busy();
    pass.lane_steps += taken * W::width;
    rows.y = y;
    rows.steps = steps;
    rows.time = time;
    rows.replace(ending);
  }
}

/// The earliest event within a step, for each lane.
template <class W>
struct EventInStep {
  typename W::Mask found{false};
  W place{1};  // part of the step
  W number{0};
};

/// Brackets the model's events on the cubics through the quantities' values and rates at both ends
/// of the step, then locates them on the step's own dense output.
template <const EmbeddedPair& pair, class W, class M>
[[gnu::noinline]] EventInStep<W> find_event(const M& model,
                                            const std::array<W, M::state_fields.size()>& y0,
                                            const std::array<W, M::state_fields.size()>& y1,
                                            const integrators::Slopes<W, M::state_fields.size()>& k,
                                            const std::array<W, M::parameter_fields.size()>& p, W t,
                                            W h) {
  using D = kernels::Dual<W>;
  constexpr std::size_t states = M::state_fields.size();
  constexpr std::size_t parameters = M::parameter_fields.size();
  const auto constants =
      kernels::array_of<parameters>([&](std::size_t i) { return D(p[i], W(0)); });
  const auto at = [&](W time, const std::array<W, states>& y, const std::array<W, states>& slope) {
    return model.quantities(
        D(time, W(1)), kernels::array_of<states>([&](std::size_t i) { return D(y[i], slope[i]); }),
        constants);
  };
  const auto start = at(t, y0, k[0]);
  const auto end = at(t + h, y1, k[integrators::pair_stages - 1]);
  EventInStep<W> first;
  for (std::size_t e = 0; e < M::events.size(); ++e) {
    const models::Direction way = M::events[e].direction;
    auto crossing = integrators::first_crossing(start[e].value, start[e].rate * h, end[e].value,
                                                end[e].rate * h, way != models::Direction::rising,
                                                way != models::Direction::falling);
    if (!any(crossing.found)) continue;
    // The cubic is off by the fourth power of the step, so Newton's method with its slope starts
    // close and needs few rounds.
    W s = crossing.place;
    for (int round = 0; round < 5; ++round) {
      const auto y = integrators::pair_dense<pair>(y0, h, s, k);
      const W value = model.quantities(t + h * s, y, p)[e];
      const W next = clamp(s - value / crossing.slope, W(0), W(1));
      s = select(crossing.slope == W(0), s, next);
    }
    const auto earlier = crossing.found & ((s < first.place) | !first.found);
    first.found = first.found | crossing.found;
    first.place = select(earlier, s, first.place);
    first.number = select(earlier, W(static_cast<double>(e)), first.number);
  }
  return first;
}

/// Steps of an embedded pair, each as long as the row's own error allows.
template <class W, class M, const EmbeddedPair& pair>
SALVO_FLATTEN void integrate_adaptive(IntegratePass<typename W::Real>& pass, const M& model) {
  using T = typename W::Real;
  using Mask = typename W::Mask;
  constexpr std::size_t states = M::state_fields.size();
  using State = std::array<W, states>;
  LaneRows<W, M> rows(pass);
  const W t0(pass.t0);
  const W absolute(pass.integration.absolute_tolerance);
  const W relative(pass.integration.relative_tolerance);
  const W most(static_cast<T>(pass.integration.most_steps));
  const W smallest(pass.integration.smallest_step);
  const Mask stop(pass.integration.stop_at_events);
  while (rows.any_left()) {
    State y = rows.y;
    const auto p = rows.p;
    const auto rate = [&](W t, const State& s) { return model.rate(t, s, p); };
    const State fresh = rate(t0 + rows.time, y);
    State slope = kernels::array_of<states>(
        [&](std::size_t i) { return select(rows.fresh, fresh[i], rows.slope[i]); });
    W steps = rows.steps;
    W time = rows.time;
    W compensation = rows.compensation;
    W step = rows.step;
    W last_error = rows.last_error;
    const W end = rows.end;
    const Mask working = rows.working;
    Ending<W> ending;
    std::uint64_t taken = 0;
    do {
      ++taken;
      integrators::Slopes<W, states> k;
      k[0] = slope;
      const W remaining = end - time;
      Mask last = step >= remaining;
      W h = select(last, remaining, step);
      State next = integrators::pair_step<pair>(y, t0 + time, h, k, rate);

      // One where the error is all that is tolerated; NaN, from a state that overflowed, fails.
      W error(0);
      for (std::size_t i = 0; i < states; ++i) {
        const W scale = absolute + relative * max(abs(y[i]), abs(next[i]));
        const W part = abs(integrators::pair_error<pair>(k, h, i)) / scale;
        error = select((part <= error) | (error != error), error, part);
      }
      const Mask accepted = error <= W(1);

      // A step that needs no error at all grows fivefold, one that fails shrinks at most as much.
      const W eighth = sqrt(sqrt(sqrt(error)));
      const W usual = clamp(W(0.9) * last_error / eighth, W(0.2), W(5));
      const W after_failure = clamp(W(0.9) / (eighth * sqrt(eighth)), W(0.2), W(0.9));
      const W wanted = h * select(accepted, usual, after_failure);
      last_error = select(accepted, max(sqrt(eighth), W(0.1)), last_error);

      ending = {};
      if constexpr (!events_of<M>.empty()) {
        const EventInStep<W> event = find_event<pair>(model, y, next, k, p, t0 + time, h);
        ending.event = accepted & event.found & stop;
        ending.number = event.number;
        if (any(working & ending.event)) {
          // The state there by a step of its own, which is of the method's order.
          const W part = select(ending.event, h * event.place, h);
          const State there = integrators::pair_step<pair>(y, t0 + time, part, k, rate);
          for (std::size_t i = 0; i < states; ++i) {
            next[i] = select(ending.event, there[i], next[i]);
          }
          h = part;
          last = last & !ending.event;
        }
      }
      step = select(accepted & last, step, wanted);
      for (std::size_t i = 0; i < states; ++i) {
        y[i] = select(accepted, next[i], y[i]);
        slope[i] = select(accepted, k[integrators::pair_stages - 1][i], slope[i]);
      }
      // The sum of many steps loses none of their last bits (Kahan).
      const W added = h - compensation;
      const W sum = time + added;
      compensation = select(accepted, select(last, W(0), (sum - time) - added), compensation);
      time = select(accepted, select(last, end, sum), time);
      steps = steps + W(1);

      const Mask too_short = (step <= smallest) | (time + step == time);
      ending.shortened = (!accepted) & too_short;
      ending.lost = ending.shortened & !all_finite(next);
      ending.ended =
          working & ((accepted & last) | ending.event | ending.shortened | (steps >= most));
    } while (!any(ending.ended));
    pass.useful_steps += taken * rows.busy();
    pass.lane_steps += taken * W::width;
    rows.y = y;
    rows.slope = slope;
    rows.steps = steps;
    rows.time = time;
    rows.compensation = compensation;
    rows.step = step;
    rows.last_error = last_error;
    rows.replace(ending);
  }
}

template <template <class> class Model, class T>
void integrate_batch(IntegratePass<T>& pass) {
  using W = kernels::Pair<kernels::NativeLane<T>>;
  using M = Model<W>;
  using State = std::array<W, M::state_fields.size()>;
  using Parameters = std::array<W, M::parameter_fields.size()>;
  const M model{};
  const auto rate = [&](W t, const State& y, const Parameters& p) { return model.rate(t, y, p); };
  const bool adaptive =
      pass.integration.absolute_tolerance > 0 || pass.integration.relative_tolerance > 0;
  const auto fixed = [&]<const EmbeddedPair & pair>() {
    integrate_fixed<W, M>(pass, [&](const State& y, W t, W h, const Parameters& p) {
      integrators::Slopes<W, M::state_fields.size()> k;
      const auto f = [&](W at, const State& s) { return rate(at, s, p); };
      k[0] = f(t, y);
      return integrators::pair_result<pair>(y, t, h, k, f);
    });
  };
  switch (pass.integration.method) {
    case Method::runge_kutta_4:
      return integrate_fixed<W, M>(pass, [&](const State& y, W t, W h, const Parameters& p) {
        return integrators::runge_kutta_4(y, t, h,
                                          [&](W at, const State& s) { return rate(at, s, p); });
      });
    case Method::tsitouras_5:
      if (adaptive) return integrate_adaptive<W, M, integrators::tsitouras_5>(pass, model);
      return fixed.template operator()<integrators::tsitouras_5>();
    case Method::dormand_prince_5:
      if (adaptive) return integrate_adaptive<W, M, integrators::dormand_prince_5>(pass, model);
      return fixed.template operator()<integrators::dormand_prince_5>();
  }
}

}  // namespace SALVO_ISA
}  // namespace salvo::solver
