#include "solver/batch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
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
  kernels.advance_float32(pass);
}
void call(const BatchKernels& kernels, const BatchPass<double>& pass) {
  kernels.advance_float64(pass);
}
void call(const BatchKernels& kernels, IntegratePass<float>& pass) {
  kernels.integrate_float32(pass);
}
void call(const BatchKernels& kernels, IntegratePass<double>& pass) {
  kernels.integrate_float64(pass);
}

}  // namespace

Batch::Batch(BatchModel model, soa::Precision precision, std::size_t rows, double t0,
             std::shared_ptr<const models::ModelData> data)
    : model_(model),
      fields_(fields_of(model(Isa::scalar))),
      table_(fields_, precision, std::vector<bool>(fields_.size(), true)),
      t0_(t0),
      data_(std::move(data)) {
  if (data_ && !model(Isa::scalar).accepts_data(*data_)) {
    throw std::invalid_argument("the model is not made from such data");
  }
  table_.append(rows);
  for (std::size_t row = 0; row < rows; ++row) table_.ids()[row] = row;
  for (std::size_t f = 1; f < fields_.size(); ++f) {
    const double value = fields_[f].fallback;
    if (precision == soa::Precision::float32) {
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

template Batch::Columns<double> Batch::columns_of(const BatchKernels&);

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
    pass.data = data_.get();
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
  if (table_.precision() == soa::Precision::float32) {
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
    case Outcome::not_accurate:
      return "not accurate";
  }
  return "unknown";
}

namespace {

// Where what is recorded goes, as the kernels want it.
class Watched {
 public:
  Watched(const BatchKernels& kernels, const Integration& integration, std::size_t rows, double t0,
          Integrated& result) {
    const std::size_t states = kernels.state_fields.size();
    stop_at = integration.stop_at.value_or(0);
    for (std::size_t e = 0; e < kernels.events.size(); ++e) {
      if (!integration.stop_at && kernels.events[e].stops) stop_at |= std::uint32_t{1} << e;
    }
    result.grazes.assign(rows, 0);
    result.recorded.resize(kernels.events.size());
    for (std::size_t e = 0; e < kernels.events.size(); ++e) {
      const bool wanted = (integration.record >> e & 1) != 0;
      events.push_back(make(result.recorded[e], wanted ? rows : 0, states));
    }
    const Samples& wanted = integration.samples;
    for (const double level : wanted.levels) {
      levels_.push_back(wanted.quantity == Samples::time ? level - t0 : level);
    }
    samples.quantity = wanted.quantity;
    samples.count = levels_.size();
    samples.levels = levels_.data();
    samples.to = make(result.samples, rows * levels_.size(), states);
    result.samples_taken.assign(rows, 0);
    samples.taken = result.samples_taken.data();
  }

  std::uint32_t stop_at = 0;
  std::vector<InstantColumns> events;
  SamplePass samples;

 private:
  InstantColumns make(Instants& instants, std::size_t count, std::size_t states) {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    instants.time.assign(count, none);
    instants.state.assign(states, std::vector<double>(count, none));
    std::vector<double*>& columns = columns_.emplace_back();
    for (std::vector<double>& column : instants.state) columns.push_back(column.data());
    return {instants.time.data(), columns.data()};
  }

  std::vector<double> levels_;
  std::deque<std::vector<double*>> columns_;
};

}  // namespace

template <class T>
void Batch::integrate_rows(const BatchKernels& kernels, std::span<const double> end,
                           const Integration& integration, int threads, Integrated& result) {
  const Columns<T> columns = columns_of<T>(kernels);
  const Watched watched(kernels, integration, rows(), t0_, result);
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
    pass.data = data_.get();
    pass.t0 = t0_;
    pass.integration = {integration.method,
                        std::min(integration.step, integration.largest_step),
                        integration.absolute_tolerance,
                        integration.relative_tolerance,
                        integration.smallest_step,
                        integration.largest_step,
                        integration.most_steps};
    pass.stop_at = watched.stop_at;
    pass.record = integration.record;
    pass.events = watched.events.data();
    pass.grazes = result.grazes.data();
    pass.samples = watched.samples;
    call(kernels, pass);
    taken[tile] = {pass.useful_steps, pass.lane_steps};
  });
  for (const auto& [useful, all] : taken) {
    result.useful_steps += useful;
    result.lane_steps += all;
  }
}

Integrated Batch::integrate(std::span<const double> end, const Integration& integration, Isa isa,
                            int threads) {
  require_available(isa);
  const auto refuse = [](std::string_view what) { throw std::invalid_argument(std::string(what)); };
  const bool adaptive = integration.absolute_tolerance > 0 || integration.relative_tolerance > 0 ||
                        integration.accuracy > 0;
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
  if (!(integration.accuracy >= 0)) refuse("the accuracy is negative");
  if (adaptive && !knows_error(integration.method)) {
    refuse("the method knows no error; choose another for tolerances");
  }
  if (!(integration.largest_step > 0)) refuse("the largest step must be positive");
  if (integration.most_steps < 1 || integration.most_steps > 1 << 24) {
    refuse("the step limit must be from 1 to 2^24");
  }
  const BatchKernels& kernels = model_(isa);
  if (integration.method == Method::semi_implicit_euler && !kernels.of_positions) {
    refuse("the semi-implicit Euler method needs a model of positions and their velocities");
  }
  const Samples& samples = integration.samples;
  if (samples.quantity != Samples::time && samples.quantity >= kernels.state_fields.size()) {
    refuse("the samples' quantity is none of the model's states");
  }
  if (!std::is_sorted(samples.levels.begin(), samples.levels.end())) {
    refuse("the samples' levels must ascend");
  }
  if (integration.accuracy == 0) return integrate_once(end, integration, isa, threads);
  if (table_.precision() == soa::Precision::float32) {
    refuse("an accuracy of the end needs double precision");
  }
  return integrate_until_accurate(end, integration, isa, threads);
}

Integrated Batch::integrate_once(std::span<const double> end, const Integration& integration,
                                 Isa isa, int threads) {
  const BatchKernels& kernels = model_(isa);
  Integrated result;
  result.time.resize(rows());
  result.outcome.resize(rows());
  result.event.resize(rows());
  result.steps.resize(rows());
  if (table_.precision() == soa::Precision::float32) {
    integrate_rows<float>(kernels, end, integration, threads, result);
  } else {
    integrate_rows<double>(kernels, end, integration, threads, result);
  }
  return result;
}

StateHash Batch::hash() const { return state_hash(table_, Parallel(1)); }

}  // namespace salvo::solver
