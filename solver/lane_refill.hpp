// Takes rows of a model to their own ends in the lanes of one task. What a row computes depends on
// nothing but the row.
//
// The step is controlled by the error of the last two steps (PI control, Hairer, Norsett, Wanner,
// II.4 and IV.2).
#pragma once

#include "kernels/pair.hpp"
#include "solver/lane_rows.hpp"
#include "solver/remarkable_steps.hpp"
#include "solver/step_method.hpp"

namespace salvo::solver {
inline namespace SALVO_ISA {

template <class M>
M make_model(const models::ModelData* data) {
  if constexpr (requires { typename M::Data; }) {
    if (data) return M(static_cast<const typename M::Data&>(*data));
  }
  return M{};
}

/// What the samples of a pass are levels of.
template <class W, std::size_t N, class T>
W level_quantity(const IntegratePass<T>& pass, W time, const std::array<W, N>& y) {
  return pass.samples.quantity == Samples::time ? time : y[pass.samples.quantity];
}

template <class T>
bool is_adaptive(const IntegratePass<T>& pass) {
  return pass.integration.absolute_tolerance > 0 || pass.integration.relative_tolerance > 0;
}

template <class T>
bool is_watched(const IntegratePass<T>& pass) {
  return (pass.stop_at | pass.record) != 0 || pass.samples.count != 0;
}

// What the loops below step is copied out of LaneRows, whose address is taken: the compiler keeps
// only what is local in registers.

/// Fixed steps. Time is n steps, never a sum; the last step ends at the end. `watched`: there are
/// events or samples to look for.
template <class W, class M, bool watched, class Method>
SALVO_FLATTEN void integrate_fixed(IntegratePass<typename W::Real>& pass, const M& model,
                                   Method method) {
  LaneRows<W, M> rows(pass);
  RemarkableSteps<W, M, AnyFixedMethod> remarkable(pass, model, {pass.integration.method});
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
    const auto rate = [&](W t, const auto& s) { return model.rate(t, s, p); };
    Ending<W> ending;
    std::uint64_t taken = 0;
    do {
      ++taken;
      const auto last = steps + W(1) >= total;
      const W h = select(last, end - time, whole);
      const auto next = method.result(y, t0 + time, h, rate);
      const W arrival = select(last, end, (steps + W(1)) * whole);
      ending.lost = !all_finite(next);
      if constexpr (watched) {
        const W t = t0 + time;
        const auto slope = rate(t, y);
        const W reached = level_quantity(pass, arrival, next);
        const Remarks<W> remarks =
            remarks_on<W>(pass, model, y, slope, next, rate(t + h, next), p, t, h, reached,
                          rows.next_level, working & !ending.lost);
        if (any(remarks.any)) {
          remarkable.put_aside(rows, remarks, y, slope, time, h, reached);
          rows.pass_levels(reached);
        }
        ending.event = remarks.stops;
      }
      y = next;
      steps = steps + W(1);
      time = arrival;
      ending.ended = working & (last | ending.lost | ending.event | (steps >= most));
    } while (!any(ending.ended));
    pass.useful_steps += taken * rows.busy();
    pass.lane_steps += taken * W::width;
    rows.y = y;
    rows.steps = steps;
    rows.time = time;
    rows.replace(ending);
  }
  remarkable.work_off();
}

/// Steps of a method that knows its error, each as long as the row's own error allows.
template <class W, class M, class Method>
SALVO_FLATTEN void integrate_adaptive(IntegratePass<typename W::Real>& pass, const M& model,
                                      Method method) {
  using T = typename W::Real;
  using Mask = typename W::Mask;
  constexpr std::size_t states = M::state_fields.size();
  using State = std::array<W, states>;
  LaneRows<W, M> rows(pass);
  RemarkableSteps<W, M, Method> remarkable(pass, model, method);
  const W t0(pass.t0);
  const W absolute(pass.integration.absolute_tolerance);
  const W relative(pass.integration.relative_tolerance);
  const W most(static_cast<T>(pass.integration.most_steps));
  const W smallest(pass.integration.smallest_step);
  const W largest(pass.integration.largest_step);
  const bool watched = is_watched(pass);
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
      const W remaining = end - time;
      const Mask last = step >= remaining;
      const W h = select(last, remaining, step);
      const typename Method::template Step<W, states, decltype(rate)> trial(method, y, slope,
                                                                            t0 + time, h, rate);
      const State& next = trial.end;

      // One where the error is all that is tolerated; NaN, from a state that overflowed, fails.
      W error(0);
      for (std::size_t i = 0; i < states; ++i) {
        const W scale = absolute + relative * max(abs(y[i]), abs(next[i]));
        const W part = abs(trial.error(i)) / scale;
        error = select((part <= error) | (error != error), error, part);
      }
      const Mask accepted = error <= W(1);

      // A step that needs no error at all grows fivefold, one that fails shrinks at most as much.
      const W root = method.control_root(error);
      const W usual = clamp(W(0.9) * last_error / root, W(0.2), W(5));
      const W after_failure = clamp(W(0.9) / (root * sqrt(root)), W(0.2), W(0.9));
      const W wanted = min(h * select(accepted, usual, after_failure), largest);
      last_error = select(accepted, max(sqrt(root), W(0.1)), last_error);

      ending = {};
      if (watched) {
        const W reached = level_quantity(pass, select(last, end, time + h), next);
        const Remarks<W> remarks =
            remarks_on<W>(pass, model, y, slope, next, trial.end_slope(), p, t0 + time, h, reached,
                          rows.next_level, working & accepted);
        if (any(remarks.any)) {
          remarkable.put_aside(rows, remarks, y, slope, time, h, reached);
          rows.pass_levels(select(accepted, reached, W(-std::numeric_limits<T>::infinity())));
        }
        ending.event = remarks.stops;
      }
      step = select(accepted & last, step, wanted);
      for (std::size_t i = 0; i < states; ++i) {
        y[i] = select(accepted, next[i], y[i]);
        slope[i] = select(accepted, trial.end_slope()[i], slope[i]);
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
  remarkable.work_off();
}

template <class W, class M, class Method>
void integrate_fixed_by(IntegratePass<typename W::Real>& pass, const M& model, Method method) {
  if (is_watched(pass)) {
    integrate_fixed<W, M, true>(pass, model, AnyFixedMethod{pass.integration.method});
  } else {
    integrate_fixed<W, M, false>(pass, model, method);
  }
}

template <class W, class M, const EmbeddedPair& pair>
void integrate_by_pair(IntegratePass<typename W::Real>& pass, const M& model) {
  if (is_adaptive(pass)) {
    integrate_adaptive<W, M>(pass, model, PairMethod<pair>());
  } else {
    integrate_fixed_by<W, M>(pass, model, PairMethod<pair>());
  }
}

/// The model says that its state is positions and then their velocities.
template <class M>
constexpr bool of_positions() {
  if constexpr (requires { M::of_positions; }) {
    return M::of_positions && M::state_fields.size() % 2 == 0;
  } else {
    return false;
  }
}

template <template <class> class Model, class T>
void integrate_batch(IntegratePass<T>& pass) {
  using W = kernels::Pair<kernels::NativeLane<T>>;
  using M = Model<W>;
  const M model = make_model<M>(pass.data);
  switch (pass.integration.method) {
    case Method::explicit_euler:
    case Method::heun:
      return integrate_fixed_by<W, M>(pass, model, AnyFixedMethod{pass.integration.method});
    case Method::semi_implicit_euler:
      if constexpr (of_positions<M>()) {
        integrate_fixed_by<W, M>(pass, model, AnyFixedMethod{pass.integration.method});
      }
      return;
    case Method::runge_kutta_4:
      return integrate_fixed_by<W, M>(pass, model, RungeKutta4());
    case Method::tsitouras_5:
      return integrate_by_pair<W, M, integrators::tsitouras_5>(pass, model);
    case Method::dormand_prince_5:
      return integrate_by_pair<W, M, integrators::dormand_prince_5>(pass, model);
    case Method::step_doubling_euler:
    case Method::extrapolation_8:
      if (is_adaptive(pass)) {
        return integrate_adaptive<W, M>(pass, model, AnyAdaptiveMethod{{pass.integration.method}});
      }
      return integrate_fixed_by<W, M>(pass, model, AnyFixedMethod{pass.integration.method});
  }
}

}  // namespace SALVO_ISA
}  // namespace salvo::solver
