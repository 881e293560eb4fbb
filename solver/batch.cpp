#include "solver/batch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "solver/tile.hpp"

namespace salvo::solver {

namespace {

std::vector<soa::Field> fields_of(const BatchKernels& kernels) {
  std::vector<soa::Field> fields;
  fields.push_back({"id", soa::Scalar::uint64, 1, "", "row of the batch", 0, 0, 0});
  fields.insert(fields.end(), kernels.state_fields.begin(), kernels.state_fields.end());
  fields.insert(fields.end(), kernels.parameter_fields.begin(), kernels.parameter_fields.end());
  return fields;
}

void call(const BatchKernels& kernels, const BatchPass<float>& pass) {
  kernels.advance_single(pass);
}
void call(const BatchKernels& kernels, const BatchPass<double>& pass) {
  kernels.advance_twice(pass);
}
void call(const BatchKernels& kernels, IntegratePass<float>& pass) {
  kernels.integrate_single(pass);
}
void call(const BatchKernels& kernels, IntegratePass<double>& pass) {
  kernels.integrate_twice(pass);
}

}  // namespace

Batch::Batch(BatchModel model, soa::Precision precision, std::size_t rows, double t0)
    : model_(model),
      fields_(fields_of(model(Isa::scalar))),
      table_(fields_, precision, std::vector<bool>(fields_.size(), true)),
      t0_(t0) {
  table_.append(rows);
  for (std::size_t row = 0; row < rows; ++row) table_.ids()[row] = row;
  for (std::size_t f = 1; f < fields_.size(); ++f) {
    const double value = fields_[f].fallback;
    if (precision == soa::Precision::single) {
      std::fill_n(table_.column<float>(f), rows, static_cast<float>(value));
    } else {
      std::fill_n(table_.column<double>(f), rows, value);
    }
  }
}

std::size_t Batch::field_index(std::string_view name) const {
  for (std::size_t f = 1; f < fields_.size(); ++f) {
    if (fields_[f].name == name) return f;
  }
  throw std::invalid_argument(fmt::format("the model has no field \"{}\"", name));
}

template <class T>
Batch::Columns<T> Batch::columns_of(const BatchKernels& kernels) {
  Columns<T> columns;
  for (std::size_t f = 1; f < fields_.size(); ++f) {
    T* column = table_.column<T>(f);
    if (f <= kernels.state_fields.size()) {
      columns.state.push_back(column);
    } else {
      columns.parameters.push_back(column);
    }
  }
  return columns;
}

template <class T>
void Batch::advance_rows(const BatchKernels& kernels, std::int64_t steps, double dt, int threads) {
  const Columns<T> columns = columns_of<T>(kernels);
  const std::size_t tiles = tiles_of(rows());
  Parallel(threads).for_each(tiles, [&](std::size_t tile) {
    BatchPass<T> pass;
    pass.first_row = tile * tile_rows;
    pass.last_row = std::min(rows(), pass.first_row + tile_rows);
    pass.state = columns.state.data();
    pass.parameters = columns.parameters.data();
    pass.t0 = t0_;
    pass.dt = dt;
    pass.first_step = step_;
    pass.steps = steps;
    call(kernels, pass);
  });
}

void Batch::advance(std::int64_t steps, double dt, Isa isa, int threads) {
  require_available(isa);
  const BatchKernels& kernels = model_(isa);
  if (table_.precision() == soa::Precision::single) {
    advance_rows<float>(kernels, steps, dt, threads);
  } else {
    advance_rows<double>(kernels, steps, dt, threads);
  }
  table_.clear_padding();
  step_ += steps;
}

std::string_view name(Outcome outcome) {
  switch (outcome) {
    case Outcome::event:
      return "event";
    case Outcome::time_limit:
      return "time limit";
    case Outcome::step_limit:
      return "step limit";
    case Outcome::not_finite:
      return "not finite";
    case Outcome::smallest_step:
      return "smallest step";
  }
  return "unknown";
}

template <class T>
void Batch::integrate_rows(const BatchKernels& kernels, std::span<const double> end,
                           const Integration& integration, int threads, Integrated& result) {
  const Columns<T> columns = columns_of<T>(kernels);
  const std::size_t tiles = tiles_of(rows());
  std::vector<std::array<std::uint64_t, 2>> taken(tiles);
  Parallel(threads).for_each(tiles, [&](std::size_t tile) {
    IntegratePass<T> pass;
    pass.first_row = tile * tile_rows;
    pass.last_row = std::min(rows(), pass.first_row + tile_rows);
    pass.state = columns.state.data();
    pass.parameters = columns.parameters.data();
    pass.end = end.data();
    pass.time = result.time.data();
    pass.outcome = result.outcome.data();
    pass.event = result.event.data();
    pass.steps = result.steps.data();
    pass.t0 = t0_;
    pass.integration = integration;
    call(kernels, pass);
    taken[tile] = {pass.useful_steps, pass.lane_steps};
  });
  std::uint64_t useful = 0;
  std::uint64_t all = 0;
  for (const auto& [tile_useful, tile_all] : taken) {
    useful += tile_useful;
    all += tile_all;
  }
  result.simd_efficiency = all == 0 ? 1 : static_cast<double>(useful) / static_cast<double>(all);
}

Integrated Batch::integrate(std::span<const double> end, const Integration& integration, Isa isa,
                            int threads) {
  require_available(isa);
  const auto refuse = [](std::string_view what) { throw std::invalid_argument(std::string(what)); };
  const bool adaptive = integration.absolute_tolerance > 0 || integration.relative_tolerance > 0;
  if (end.size() != rows()) refuse("one end time a row is needed");
  for (std::size_t row = 0; row < end.size(); ++row) {
    if (!(end[row] >= t0_) || !std::isfinite(end[row])) {
      refuse(fmt::format("row {} ends at {} s, before {} s", row, end[row], t0_));
    }
  }
  if (!(integration.step > 0)) refuse("the step must be positive");
  if (!(integration.absolute_tolerance >= 0) || !(integration.relative_tolerance >= 0)) {
    refuse("a tolerance is negative");
  }
  if (adaptive && integration.method == Method::runge_kutta_4) {
    refuse("the classical Runge-Kutta method knows no error; choose another for tolerances");
  }
  if (integration.most_steps < 1 || integration.most_steps > 1 << 24) {
    refuse("the step limit must be from 1 to 2^24");
  }
  const BatchKernels& kernels = model_(isa);
  if (!adaptive && integration.stop_at_events && !kernels.events.empty()) {
    refuse("a model with events needs a tolerance, or stop_at_events = false");
  }
  Integrated result;
  result.time.resize(rows());
  result.outcome.resize(rows());
  result.event.resize(rows());
  result.steps.resize(rows());
  if (table_.precision() == soa::Precision::single) {
    integrate_rows<float>(kernels, end, integration, threads, result);
  } else {
    integrate_rows<double>(kernels, end, integration, threads, result);
  }
  return result;
}

StateHash Batch::hash() const { return state_hash(table_, Parallel(1)); }

}  // namespace salvo::solver
