// Takes rows of a model to their own ends in the lanes of one task: each lane has its row, its time
// and its step, and takes up the next row of the queue when its row ends, so that short rows do not
// leave lanes idle. What a row computes depends on nothing but the row.
//
// The step is controlled by the error of the last two steps (PI control, Hairer, Norsett, Wanner,
// II.4 and IV.2; exponents 1/8 and 1/16 instead of the usual 0.14 and 0.08, because square roots
// are ten times as fast as a power).
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "integrators/embedded_pair.hpp"
#include "integrators/runge_kutta.hpp"
#include "kernels/pair.hpp"
#include "soa/aligned_bytes.hpp"
#include "solver/batch.hpp"

namespace salvo::solver {
inline namespace SALVO_ISA {

using integrators::EmbeddedPair;

template <class W, std::size_t N>
typename W::Mask all_finite(const std::array<W, N>& y) {
  typename W::Mask finite(true);
  for (const W& component : y) finite = finite & is_finite(component);
  return finite;
}

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

  /// Hands in the rows of the lanes marked, whose state is `y`, and takes up others. `lost` and
  /// `shortened` say which outcome it is where the end is not reached.
  [[gnu::noinline]] void replace(Mask ended, Mask lost, Mask shortened) {
    T marked[3][W::width];
    alignas(soa::alignment) T values[W::width];
    const auto keep = [&](Mask mask, T* to) {
      select(mask, W(1), W(0)).store(values);
      for (std::size_t lane = 0; lane < W::width; ++lane) to[lane] = values[lane];
    };
    keep(ended, marked[0]);
    keep(lost, marked[1]);
    keep(shortened, marked[2]);
    save();
    for (std::size_t lane = 0; lane < W::width; ++lane) {
      if (marked[0][lane] == T(0)) continue;
      hand_in(lane, marked[1][lane] != T(0), marked[2][lane] != T(0));
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
  Mask fresh{false};  // taken up since the last step

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

  void hand_in(std::size_t lane, bool lost, bool shortened) {
    const std::size_t row = row_[lane];
    for (std::size_t i = 0; i < states; ++i) pass_.state[i][row] = state_[i][lane];
    const bool arrived = time_[lane] >= end_[lane];
    pass_.time[row] = arrived ? pass_.end[row] : pass_.t0 + static_cast<double>(time_[lane]);
    pass_.steps[row] = static_cast<std::uint32_t>(steps_[lane]);
    pass_.outcome[row] = lost        ? Outcome::not_finite
                         : arrived   ? Outcome::time_limit
                         : shortened ? Outcome::smallest_step
                                     : Outcome::step_limit;
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
[[gnu::flatten]] void integrate_fixed(IntegratePass<typename W::Real>& pass, const Step& step) {
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
    auto lost = typename W::Mask(false);
    auto ended = typename W::Mask(false);
    std::uint64_t taken = 0;
    do {
      ++taken;
      const auto last = steps + W(1) >= total;
      y = step(y, t0 + time, select(last, end - time, whole), p);
      steps = steps + W(1);
      time = select(last, end, steps * whole);
      lost = !all_finite(y);
      ended = working & (last | lost | (steps >= most));
    } while (!any(ended));
    pass.useful_steps += taken * rows.busy();
    pass.lane_steps += taken * W::width;
    rows.y = y;
    rows.steps = steps;
    rows.time = time;
    rows.replace(ended, lost, typename W::Mask(false));
  }
}

/// Steps of an embedded pair, each as long as the row's own error allows.
template <class W, class M, const EmbeddedPair& pair, class Rate>
void integrate_adaptive(IntegratePass<typename W::Real>& pass, const Rate& rate) {
  using T = typename W::Real;
  constexpr std::size_t states = M::state_fields.size();
  LaneRows<W, M> rows(pass);
  const W t0(pass.t0);
  const W absolute(pass.integration.absolute_tolerance);
  const W relative(pass.integration.relative_tolerance);
  const W most(static_cast<T>(pass.integration.most_steps));
  const W smallest(pass.integration.smallest_step);
  integrators::Slopes<W, states> k;
  while (rows.any_left()) {
    pass.useful_steps += rows.busy();
    pass.lane_steps += W::width;
    const auto f = [&](W t, const std::array<W, states>& y) { return rate(t, y, rows.p); };
    k[0] = rows.slope;
    if (any(rows.fresh)) {
      const std::array<W, states> first = f(t0 + rows.time, rows.y);
      for (std::size_t i = 0; i < states; ++i) k[0][i] = select(rows.fresh, first[i], k[0][i]);
      rows.fresh = typename W::Mask(false);
    }
    const W remaining = rows.end - rows.time;
    const auto last = rows.step >= remaining;
    const W h = select(last, remaining, rows.step);
    const std::array<W, states> y = integrators::pair_step<pair>(rows.y, t0 + rows.time, h, k, f);

    // One where the error is all that is tolerated; NaN, from a state that overflowed, fails.
    W error(0);
    for (std::size_t i = 0; i < states; ++i) {
      const W scale = absolute + relative * max(abs(rows.y[i]), abs(y[i]));
      const W part = abs(integrators::pair_error<pair>(k, h, i)) / scale;
      error = select((part <= error) | (error != error), error, part);
    }
    const auto accepted = error <= W(1);

    // A step that needs no error at all grows fivefold, one that fails shrinks at most as much.
    const W eighth = sqrt(sqrt(sqrt(error)));
    const W usual = clamp(W(0.9) * rows.last_error / eighth, W(0.2), W(5));
    const W after_failure = clamp(W(0.9) / (eighth * sqrt(eighth)), W(0.2), W(0.9));
    const W factor = select(accepted, usual, after_failure);
    rows.step = select(accepted & last, rows.step, h * factor);
    rows.last_error = select(accepted, max(sqrt(eighth), W(0.1)), rows.last_error);

    for (std::size_t i = 0; i < states; ++i) {
      rows.y[i] = select(accepted, y[i], rows.y[i]);
      rows.slope[i] = select(accepted, k[integrators::pair_stages - 1][i], k[0][i]);
    }
    // The sum of many steps loses none of their last bits (Kahan).
    const W added = h - rows.compensation;
    const W time = rows.time + added;
    rows.compensation =
        select(accepted, select(last, W(0), (time - rows.time) - added), rows.compensation);
    rows.time = select(accepted, select(last, rows.end, time), rows.time);
    rows.steps = rows.steps + W(1);

    const auto too_short = (rows.step <= smallest) | (rows.time + rows.step == rows.time);
    const auto shortened = (!accepted) & too_short;
    const auto ended = rows.working & ((accepted & last) | shortened | (rows.steps >= most));
    if (any(ended)) rows.replace(ended, shortened & !all_finite(y), shortened);
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
      if (adaptive) return integrate_adaptive<W, M, integrators::tsitouras_5>(pass, rate);
      return fixed.template operator()<integrators::tsitouras_5>();
    case Method::dormand_prince_5:
      if (adaptive) return integrate_adaptive<W, M, integrators::dormand_prince_5>(pass, rate);
      return fixed.template operator()<integrators::dormand_prince_5>();
  }
}

}  // namespace SALVO_ISA
}  // namespace salvo::solver
