// Steps in which something happens: an event, a graze, a sample. They are put aside until there is
// a pack of them, because what has to be done is several steps' work, and it would be wasted on the
// lanes to which nothing happens.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "integrators/crossing.hpp"
#include "kernels/dual.hpp"
#include "models/event.hpp"
#include "solver/lane_rows.hpp"
#include "solver/step_method.hpp"

namespace salvo::solver {
inline namespace SALVO_ISA {

/// The model's events; none when it lists none.
template <class M>
inline constexpr std::span<const models::Event> events_of = [] {
  if constexpr (requires { M::events; }) {
    return std::span<const models::Event>(M::events);
  } else {
    return std::span<const models::Event>();
  }
}();

constexpr bool has(std::uint32_t events, std::size_t event) { return (events >> event & 1) != 0; }

/// The quantity of an event over a step, from its ends.
template <class W, class M, std::size_t N, std::size_t P>
integrators::QuantityOverStep<W> quantity_over(const M& model, std::size_t event,
                                               const std::array<W, N>& start,
                                               const std::array<W, N>& start_slope,
                                               const std::array<W, N>& end,
                                               const std::array<W, N>& end_slope,
                                               const std::array<W, P>& p, W t, W h) {
  using D = kernels::Dual<W>;
  const auto constants = kernels::array_of<P>([&](std::size_t i) { return D(p[i], W(0)); });
  const auto at = [&](W time, const std::array<W, N>& y, const std::array<W, N>& slope) {
    return model.quantity(event, D(time, W(1)),
                          kernels::array_of<N>([&](std::size_t i) { return D(y[i], slope[i]); }),
                          constants);
  };
  const D first = at(t, start, start_slope);
  const D last = at(t + h, end, end_slope);
  return {first.value, first.rate * h, last.value, last.rate * h};
}

/// Where the event's quantity comes through zero, for lanes in which the model accepts the place: a
/// model with `accepts` has events that need more than their quantity's zero, such as the face of a
/// box. The place and state are those of the cubics through the ends of the step.
template <class W, class M, std::size_t N, std::size_t P>
integrators::Bracket<W> bracket_of(const M& model, std::size_t event,
                                   const integrators::QuantityOverStep<W>& q,
                                   const std::array<W, N>& start,
                                   const std::array<W, N>& start_slope, const std::array<W, N>& end,
                                   const std::array<W, N>& end_slope, const std::array<W, P>& p,
                                   W h) {
  const models::Direction way = M::events[event].direction;
  auto bracket =
      first_bracket(q, way != models::Direction::rising, way != models::Direction::falling);
  if constexpr (requires { model.accepts(event, start, p); }) {
    if (any(bracket.found)) {
      const W s = zero_in(q, bracket);
      const auto there = kernels::array_of<N>([&](std::size_t i) {
        return hermite(start[i], h * start_slope[i], end[i], h * end_slope[i], s);
      });
      bracket.found = bracket.found & model.accepts(event, there, p);
    }
  }
  return bracket;
}

/// What happens to the lanes within a step.
template <class W>
struct Remarks {
  using Mask = typename W::Mask;
  Mask any{false};
  Mask stops{false};
};

/// Looks at a step from its ends. `reached` is what the samples' quantity has come to.
template <class W, class M, std::size_t N, std::size_t P, class T>
Remarks<W> remarks_on(const IntegratePass<T>& pass, const M& model, const std::array<W, N>& start,
                      const std::array<W, N>& start_slope, const std::array<W, N>& end,
                      const std::array<W, N>& end_slope, const std::array<W, P>& p, W t, W h,
                      W reached, W next_level, typename W::Mask of) {
  Remarks<W> remarks;
  if constexpr (!events_of<M>.empty()) {
    const std::uint32_t watched = pass.stop_at | pass.record;
    for (std::size_t e = 0; e < M::events.size(); ++e) {
      if (!has(watched, e)) continue;
      const auto q = quantity_over<W>(model, e, start, start_slope, end, end_slope, p, t, h);
      const auto near = of & may_cross(q);
      if (!any(near)) continue;
      const auto bracket = bracket_of(model, e, q, start, start_slope, end, end_slope, p, h);
      remarks.any = remarks.any | (near & (bracket.found | bracket.graze));
      if (has(pass.stop_at, e)) remarks.stops = remarks.stops | (near & bracket.found);
    }
  }
  if (pass.samples.count != 0) remarks.any = remarks.any | (of & (reached >= next_level));
  return remarks;
}

/// Method is one of solver/step_method.hpp.
template <class W, class M, class Method>
class RemarkableSteps {
 public:
  using T = typename W::Real;
  using Mask = typename W::Mask;
  static constexpr std::size_t states = M::state_fields.size();
  static constexpr std::size_t parameters = M::parameter_fields.size();
  using State = std::array<W, states>;

  RemarkableSteps(IntegratePass<T>& pass, const M& model, Method method)
      : pass_(pass), model_(model), method_(method) {
    // Lanes without a step compute on with harmless values.
    for (auto& column : state_) std::fill_n(column, W::width, T(0));
    for (auto& column : slope_) std::fill_n(column, W::width, T(0));
    for (auto& column : parameter_) std::fill_n(column, W::width, T(1));
    std::fill_n(time_, W::width, T(0));
    std::fill_n(h_, W::width, T(1));
  }

  [[gnu::noinline]] void put_aside(const LaneRows<W, M>& rows, const Remarks<W>& remarks,
                                   const State& y, const State& slope, W time, W h, W reached) {
    const Flags<W> remarkable(remarks.any);
    const Flags<W> stops(remarks.stops);
    alignas(soa::alignment) Column state[states];
    alignas(soa::alignment) Column slopes[states];
    alignas(soa::alignment) Column times;
    alignas(soa::alignment) Column lengths;
    alignas(soa::alignment) Column levels;
    reached.store(levels);
    for (std::size_t i = 0; i < states; ++i) y[i].store(state[i]);
    for (std::size_t i = 0; i < states; ++i) slope[i].store(slopes[i]);
    time.store(times);
    h.store(lengths);
    for (std::size_t lane = 0; lane < W::width; ++lane) {
      if (!remarkable[lane]) continue;
      const std::size_t row = rows.row(lane);
      row_[count_] = row;
      stops_[count_] = stops[lane] ? 1 : 0;
      for (std::size_t i = 0; i < states; ++i) state_[i][count_] = state[i][lane];
      for (std::size_t i = 0; i < states; ++i) slope_[i][count_] = slopes[i][lane];
      for (std::size_t i = 0; i < parameters; ++i) {
        parameter_[i][count_] = pass_.parameters[i][row];
      }
      time_[count_] = times[lane];
      h_[count_] = lengths[lane];
      reached_[count_] = levels[lane];
      if (++count_ == W::width) work_off();
    }
  }

  /// Does what there is to do in the steps that were put aside.
  [[gnu::noinline]] void work_off() {
    const auto y = kernels::array_of<states>([&](std::size_t i) { return W::load(state_[i]); });
    const auto slope = kernels::array_of<states>([&](std::size_t i) { return W::load(slope_[i]); });
    const auto p =
        kernels::array_of<parameters>([&](std::size_t i) { return W::load(parameter_[i]); });
    const W time = W::load(time_);
    const Context c{y, p, W(pass_.t0) + time, W::load(h_)};
    const Rate rate = c.rate(model_);
    const Step step(method_, y, slope, c.t, c.h, rate);
    W place(1);
    State end = step.end;
    if constexpr (!events_of<M>.empty()) {
      find_stop(c, step, place, end);
      for (std::size_t e = 0; e < M::events.size(); ++e) {
        if (has(pass_.stop_at | pass_.record, e)) note_graze(c, step, e, place);
        if (has(pass_.record, e)) record(c, step, e, place);
      }
    }
    if (pass_.samples.count != 0) take_samples(step, time, place, end);
    hand_in(time + place * c.h, end);
    count_ = 0;
  }

 private:
  using Column = T[W::width];
  // Out of line: what is rare need not be fast, and would be most of the code.
  struct Rate {
    const M& model;
    const std::array<W, parameters>& p;
    [[gnu::noinline]] State operator()(W t, const State& s) const { return model.rate(t, s, p); }
  };
  using Step = typename Method::template Step<W, states, Rate>;

  struct Context {
    State y;
    std::array<W, parameters> p;
    W t;
    W h;
    Rate rate(const M& model) const { return {model, p}; }
  };

  auto over(const Context& c, const Step& step, std::size_t e) const {
    return quantity_over<W>(model_, e, step.start, step.start_slope(), step.end, step.end_slope(),
                            c.p, c.t, c.h);
  }
  auto bracket(const Context& c, const Step& step, const integrators::QuantityOverStep<W>& q,
               std::size_t e) const {
    return bracket_of(model_, e, q, step.start, step.start_slope(), step.end, step.end_slope(), c.p,
                      c.h);
  }

  // Where the event's quantity is zero: on the cubic, then on the solution within the step, which
  // is nearer by orders of h, so that Newton's method needs few rounds.
  struct Found {
    Mask found{false};
    W place{1};
  };
  Found find(const Context& c, const Step& step, std::size_t e) const {
    const auto q = over(c, step, e);
    const auto here = bracket(c, step, q, e);
    if (!any(here.found)) return {};
    W s = zero_in(q, here);
    const W slope = q.slope(s);
    for (int round = 0; round < 5; ++round) {
      const W value = model_.quantity(e, c.t + c.h * s, step.at(s), c.p);
      s = select(slope == W(0), s, clamp(s - value / slope, W(0), W(1)));
    }
    return {here.found, s};
  }

  // The state there by a step of its own, which is of the method's order, and the place again from
  // that state, until both are good to the last bits.
  State settle(const Context& c, std::size_t e, Mask which, W& place) const {
    using D = kernels::Dual<W>;
    const auto rate = c.rate(model_);
    const auto constants =
        kernels::array_of<parameters>([&](std::size_t i) { return D(c.p[i], W(0)); });
    for (int round = 0; round < 2; ++round) {
      const W part = c.h * place;
      const State there = method_.result(c.y, c.t, part, rate);
      const State slope = rate(c.t + part, there);
      const D q = model_.quantity(
          e, D(c.t + part, W(1)),
          kernels::array_of<states>([&](std::size_t i) { return D(there[i], slope[i]); }),
          constants);
      const W better = place - q.value / (q.rate * c.h);
      const Mask good = which & (better >= W(0)) & (better <= W(1));
      place = select(good, better, place);
    }
    return method_.result(c.y, c.t, c.h * place, rate);
  }

  // The earliest of the events that end a row.
  void find_stop(const Context& c, const Step& step, W& place, State& end) {
    alignas(soa::alignment) Column stopping;
    for (std::size_t i = 0; i < W::width; ++i) stopping[i] = i < count_ && stops_[i] != 0 ? 1 : 0;
    const Mask stops = W::load(stopping) > W(0);
    if (!any(stops)) return;
    Mask found(false);
    W number(0);
    for (std::size_t e = 0; e < M::events.size(); ++e) {
      if (!has(pass_.stop_at, e)) continue;
      const Found here = find(c, step, e);
      const Mask earlier = stops & here.found & ((here.place < place) | !found);
      found = found | (stops & here.found);
      place = select(earlier, here.place, place);
      number = select(earlier, W(static_cast<double>(e)), number);
    }
    for (std::size_t e = 0; e < M::events.size(); ++e) {
      const Mask mine = found & (number == W(static_cast<double>(e)));
      if (!has(pass_.stop_at, e) || !any(mine)) continue;
      const State there = settle(c, e, mine, place);
      for (std::size_t i = 0; i < states; ++i) end[i] = select(mine, there[i], end[i]);
    }
    number.store(number_);
  }

  void note_graze(const Context& c, const Step& step, std::size_t e, W end_place) {
    const auto q = over(c, step, e);
    const auto here = bracket(c, step, q, e);
    if (!any(here.graze)) return;
    const W value =
        model_.quantity(e, c.t + c.h * here.graze_place, step.at(here.graze_place), c.p);
    const Flags<W> grazes(here.graze & (here.graze_place <= end_place) &
                          (abs(value) <= q.scale() * W(integrators::graze_depth)));
    for (std::size_t i = 0; i < count_; ++i) {
      if (grazes[i]) pass_.grazes[row_[i]] |= std::uint32_t{1} << e;
    }
  }

  void record(const Context& c, const Step& step, std::size_t e, W end_place) {
    Found here = find(c, step, e);
    const Mask before_end = here.found & (here.place <= end_place);
    const Flags<W> found(before_end);
    bool wanted = false;
    for (std::size_t i = 0; i < count_; ++i) {
      wanted = wanted || (found[i] && std::isnan(pass_.events[e].time[row_[i]]));
    }
    if (!wanted) return;
    const State there = settle(c, e, before_end, here.place);
    alignas(soa::alignment) Column place;
    alignas(soa::alignment) Column values[states];
    (c.h * here.place).store(place);
    for (std::size_t i = 0; i < states; ++i) there[i].store(values[i]);
    for (std::size_t i = 0; i < count_; ++i) {
      double& time = pass_.events[e].time[row_[i]];
      if (!found[i] || !std::isnan(time)) continue;
      time = pass_.t0 + static_cast<double>(time_[i] + place[i]);
      for (std::size_t k = 0; k < states; ++k) {
        pass_.events[e].state[k][row_[i]] = static_cast<double>(values[k][i]);
      }
    }
  }

  // The samples of each lane up to the end of its part of the step.
  void take_samples(const Step& step, W time, W end_place, const State& end) {
    const SamplePass& samples = pass_.samples;
    const bool of_time = samples.quantity == Samples::time;
    const W at_stop = of_time ? time + end_place * step.h : end[of_time ? 0 : samples.quantity];
    alignas(soa::alignment) Column to;
    at_stop.store(to);
    for (std::size_t i = 0; i < count_; ++i) to[i] = stops_[i] != 0 ? to[i] : reached_[i];
    while (true) {
      alignas(soa::alignment) Column level;
      bool due = false;
      for (std::size_t i = 0; i < W::width; ++i) {
        const std::uint32_t taken = i < count_ ? samples.taken[row_[i]] : 0;
        const bool more = i < count_ && taken < samples.count;
        level[i] = more ? static_cast<T>(samples.levels[taken]) : T(0);
        const bool hit = more && level[i] <= to[i] && !earlier_step_is_due(i);
        due_[i] = hit ? 1 : 0;
        due = due || hit;
      }
      if (!due) return;
      const W at = W::load(level);
      const W s = of_time ? clamp((at - time) / step.h, W(0), W(1))
                          : place_of_level(step, samples.quantity, at);
      const State there = step.at(s);
      alignas(soa::alignment) Column instant;
      alignas(soa::alignment) Column values[states];
      (of_time ? at : time + s * step.h).store(instant);
      for (std::size_t k = 0; k < states; ++k) there[k].store(values[k]);
      for (std::size_t i = 0; i < count_; ++i) {
        if (due_[i] == 0) continue;
        const std::size_t element = row_[i] * samples.count + samples.taken[row_[i]]++;
        samples.to.time[element] = pass_.t0 + static_cast<double>(instant[i]);
        for (std::size_t k = 0; k < states; ++k) {
          samples.to.state[k][element] = static_cast<double>(values[k][i]);
        }
      }
    }
  }

  // Steps of one row are worked off in their order.
  bool earlier_step_is_due(std::size_t i) const {
    for (std::size_t before = 0; before < i; ++before) {
      if (row_[before] == row_[i] && due_[before] != 0) return true;
    }
    return false;
  }

  // A level that the step begins at or above is at its start.
  static W place_of_level(const Step& step, std::size_t quantity, W level) {
    const integrators::QuantityOverStep<W> q{
        step.start[quantity] - level, step.start_slope()[quantity] * step.h,
        step.end[quantity] - level, step.end_slope()[quantity] * step.h};
    const auto bracket = first_bracket(q, false, true);
    W s = zero_in(q, bracket);
    const W slope = q.slope(s);
    for (int round = 0; round < 5; ++round) {
      const W value = step.at(s)[quantity] - level;
      s = select(slope == W(0), s, clamp(s - value / slope, W(0), W(1)));
    }
    return select(bracket.found, s, W(0));
  }

  void hand_in(W time, const State& end) {
    alignas(soa::alignment) Column at;
    alignas(soa::alignment) Column values[states];
    time.store(at);
    for (std::size_t i = 0; i < states; ++i) end[i].store(values[i]);
    for (std::size_t i = 0; i < count_; ++i) {
      if (stops_[i] == 0) continue;
      const std::size_t row = row_[i];
      for (std::size_t k = 0; k < states; ++k) pass_.state[k][row] = values[k][i];
      pass_.time[row] = pass_.t0 + static_cast<double>(at[i]);
      pass_.outcome[row] = Outcome::event;
      pass_.event[row] = static_cast<std::uint8_t>(number_[i]);
    }
  }

  IntegratePass<T>& pass_;
  const M& model_;
  const Method method_;
  std::size_t count_ = 0;
  std::size_t row_[W::width];
  std::uint8_t stops_[W::width];
  std::uint8_t due_[W::width];
  alignas(soa::alignment) Column state_[states];
  alignas(soa::alignment) Column slope_[states];
  alignas(soa::alignment) Column parameter_[parameters == 0 ? 1 : parameters];
  alignas(soa::alignment) Column time_;
  alignas(soa::alignment) Column h_;
  alignas(soa::alignment) Column reached_;
  alignas(soa::alignment) Column number_;
};

}  // namespace SALVO_ISA
}  // namespace salvo::solver
