#include "solver/sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "solver/floating_point_environment.hpp"
#include "solver/tile.hpp"

namespace salvo::solver {

namespace {

constexpr soa::Field whole(std::string_view name, std::string_view meaning) {
  return {name, soa::Scalar::uint32, 1, "", meaning, 0, 0, 4294967295.0};
}

std::vector<double*> pointers(std::vector<std::vector<double>>& columns) {
  std::vector<double*> all;
  all.reserve(columns.size());
  for (std::vector<double>& column : columns) all.push_back(column.data());
  return all;
}

}  // namespace

Digest SweepRows::hash(const Parallel& parallel) const {
  const Digest of_table = state_hash(table, parallel).total;
  if (samples.empty() || sample_time.empty()) return of_table;
  std::vector<std::uint64_t> words{of_table.high, of_table.low};
  const auto add = [&](const std::vector<double>& column) {
    const Digest digest = digest_of(column.data(), column.size() * sizeof(double));
    words.push_back(digest.high);
    words.push_back(digest.low);
  };
  add(sample_time);
  for (const std::vector<double>& column : samples) add(column);
  return digest_of(words.data(), words.size() * sizeof(std::uint64_t));
}

Sweep::Sweep(SweepSetup setup) : setup_(std::move(setup)), kernels_(&setup_.model(Isa::scalar)) {
  const FloatingPointEnvironment environment;
  const std::span<const soa::Field> inputs = kernels_->input_fields;
  if (setup_.inputs.size() != inputs.size()) {
    throw std::invalid_argument("a sweep wants one variation for each input of the model");
  }
  std::vector<bool> is_joint(inputs.size(), false);
  for (const JointNormal& joint : setup_.joint) {
    for (const std::size_t input : joint.inputs) is_joint[input] = true;
  }
  // The last axis varies fastest; columns share one axis.
  for (std::size_t i = inputs.size(); i-- > 0;) {
    if (setup_.inputs[i].kind != Variation::Kind::grid) continue;
    axes_.push_back({i, points_});
    points_ *= setup_.inputs[i].values.size();
  }
  std::uint64_t table_rows = 0;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (setup_.inputs[i].kind != Variation::Kind::column) continue;
    axes_.push_back({i, points_});
    table_rows = setup_.inputs[i].values.size();
  }
  if (table_rows != 0) points_ *= table_rows;

  const auto line = [&](std::size_t input) {
    return SampleLine(setup_.sampling, setup_.seed, inputs[input].name, input, setup_.samples);
  };
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const Variation& variation = setup_.inputs[i];
    if (variation.random()) random_.push_back({i, line(i), Quantile(variation)});
  }
  for (const JointNormal& joint : setup_.joint) {
    JointInput& lines = joint_.emplace_back();
    for (const std::size_t input : joint.inputs) lines.lines.push_back(line(input));
  }

  add_field("id",
            {"", soa::Scalar::uint64, 1, "", "index of the row", 0, 0,
             std::numeric_limits<double>::max()},
            true);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const bool varies = setup_.inputs[i].kind != Variation::Kind::constant || is_joint[i] ||
                        !setup_.inputs[i].shifts.empty();
    add_field(fmt::format("input.{}", inputs[i].name), inputs[i], varies);
  }
  add_field("outcome", whole("", "why the trajectory ended"), true);
  add_field("steps", whole("", "steps tried"), true);
  add_field("grazes", whole("", "events that touched zero, a bit each"), !kernels_->events.empty());
  add_field("sampled", whole("", "samples that were reached"), levels() != 0);
  const soa::Field time{
      "", soa::Scalar::real, 1, "s", "when it ended", 0, 0, std::numeric_limits<double>::max()};
  add_field("time", time, true);
  const auto add_state = [&](std::string_view group, bool results) {
    for (const soa::Field& field : kernels_->state_fields) {
      add_field(fmt::format("{}.{}", group, field.name), field, true);
    }
    for (const soa::Field& field : kernels_->result_fields) {
      if (results) add_field(fmt::format("{}.{}", group, field.name), field, true);
    }
  };
  add_state("end", true);
  for (std::size_t e = 0; e < kernels_->events.size(); ++e) {
    if ((setup_.integration.record >> e & 1) == 0) continue;
    const std::string_view event = kernels_->events[e].name;
    soa::Field first = time;
    first.meaning = kernels_->events[e].meaning;
    add_field(fmt::format("{}.time", event), first, true);
    add_state(event, false);
  }
  for (const soa::Field& field : kernels_->state_fields) sample_fields_.push_back(field);
  for (const soa::Field& field : kernels_->result_fields) sample_fields_.push_back(field);
}

void Sweep::add_field(const std::string& name, soa::Field field, bool stored) {
  field.name = fields_->names.emplace_back(name);
  fields_->list.push_back(field);
  stored_.push_back(stored);
}

std::vector<std::string> Sweep::outcomes() const {
  std::vector<std::string> names;
  for (const models::Event& event : kernels_->events) names.emplace_back(event.name);
  for (int outcome = 1; outcome <= static_cast<int>(Outcome::not_accurate); ++outcome) {
    names.emplace_back(name(static_cast<Outcome>(outcome)));
  }
  return names;
}

void Sweep::inputs_of(std::uint64_t row, double* const* to, std::size_t at) const {
  for (std::size_t i = 0; i < setup_.inputs.size(); ++i) {
    if (setup_.inputs[i].kind == Variation::Kind::constant) to[i][at] = setup_.inputs[i].a;
  }
  const std::uint64_t point = row % points_;
  const std::uint64_t sample = row / points_;
  for (const Axis& axis : axes_) {
    const std::vector<double>& values = setup_.inputs[axis.input].values;
    to[axis.input][at] = values[point / axis.stride % values.size()];
  }
  for (const RandomInput& random : random_) {
    to[random.input][at] = random.quantile(random.line(sample));
  }
  for (std::size_t j = 0; j < joint_.size(); ++j) {
    const JointNormal& joint = setup_.joint[j];
    std::array<double, 64> z;
    for (std::size_t k = 0; k < joint.inputs.size(); ++k) {
      z[k] = normal_quantile(joint_[j].lines[k](sample));
      double value = joint.mean[k];
      for (std::size_t m = 0; m <= k; ++m) value += joint.factor[k][m] * z[m];
      to[joint.inputs[k]][at] = value;
    }
  }
  for (std::size_t i = 0; i < setup_.inputs.size(); ++i) {
    const std::vector<double>& shifts = setup_.inputs[i].shifts;
    if (!shifts.empty()) to[i][at] += shifts[point];
  }
}

SweepSetup Sweep::at_point(std::uint64_t point) const {
  SweepSetup setup = setup_;
  for (const Axis& axis : axes_) {
    const std::vector<double>& values = setup_.inputs[axis.input].values;
    setup.inputs[axis.input] = Variation::of(values[point / axis.stride % values.size()]);
  }
  for (Variation& input : setup.inputs) input.shifts.clear();
  return setup;
}

template <class T>
void Sweep::fill_state(const std::vector<std::vector<double>>& started, Batch& batch) const {
  const auto copy = [&](std::string_view name, const std::vector<double>& from) {
    const std::span<T> to = batch.column<T>(name);
    std::transform(from.begin(), from.end(), to.begin(),
                   [](double x) { return static_cast<T>(x); });
  };
  const std::size_t states = kernels_->state_fields.size();
  for (std::size_t f = 0; f < started.size(); ++f) {
    copy(f < states ? kernels_->state_fields[f].name : kernels_->parameter_fields[f - states].name,
         started[f]);
  }
}

SweepRows Sweep::run(std::uint64_t first, std::uint64_t count, const Execution& execution) const {
  const FloatingPointEnvironment environment;
  const Parallel parallel(execution.threads);
  const BatchKernels& kernels = setup_.model(execution.isa);
  const std::size_t inputs = kernels.input_fields.size();
  const std::size_t states = kernels.state_fields.size();
  const std::size_t results = kernels.result_fields.size();
  const auto columns = [&](std::size_t fields, std::size_t length) {
    return std::vector<std::vector<double>>(fields, std::vector<double>(length));
  };

  std::vector<std::vector<double>> in = columns(inputs, count);
  std::vector<std::vector<double>> started =
      columns(states + kernels.parameter_fields.size(), count);
  const std::vector<double*> in_pointers = pointers(in);
  const std::vector<double*> started_pointers = pointers(started);
  parallel.for_each(tiles_of(count), [&](std::size_t tile) {
    const std::size_t begin = tile * tile_rows;
    const std::size_t end = std::min<std::size_t>(count, begin + tile_rows);
    for (std::size_t row = begin; row < end; ++row) inputs_of(first + row, in_pointers.data(), row);
    std::vector<const double*> from;
    std::vector<double*> to;
    from.reserve(in_pointers.size());
    to.reserve(started_pointers.size());
    for (const double* column : in_pointers) from.push_back(column + begin);
    for (double* column : started_pointers) to.push_back(column + begin);
    kernels.start({end - begin, from.data(), to.data()});
  });

  Batch batch(setup_.model, setup_.precision, count, 0, setup_.data);
  const bool narrow = setup_.precision == soa::Precision::float32;
  narrow ? fill_state<float>(started, batch) : fill_state<double>(started, batch);
  const std::vector<double> end(count, setup_.time_limit);
  const Integrated ended =
      batch.integrate(end, setup_.integration, execution.isa, execution.threads);

  // Inputs, time and state to results, at the end and at every sample.
  const auto finish = [&](const std::vector<double>& time,
                          const std::vector<std::vector<double>>& state, std::size_t each) {
    std::vector<std::vector<double>> out = columns(results, time.size());
    if (results == 0 || time.empty()) return out;
    std::vector<std::vector<double>> repeated;
    if (each != 1) {
      repeated = columns(inputs, time.size());
      for (std::size_t f = 0; f < inputs; ++f) {
        for (std::size_t k = 0; k < time.size(); ++k) repeated[f][k] = in[f][k / each];
      }
    }
    const std::vector<std::vector<double>>& of_rows = each == 1 ? in : repeated;
    parallel.for_each(tiles_of(time.size()), [&](std::size_t tile) {
      const std::size_t begin = tile * tile_rows;
      std::vector<const double*> from;
      from.reserve(of_rows.size() + 1 + state.size());
      for (const auto& column : of_rows) from.push_back(column.data() + begin);
      from.push_back(time.data() + begin);
      for (const auto& column : state) from.push_back(column.data() + begin);
      std::vector<double*> to;
      to.reserve(out.size());
      for (auto& column : out) to.push_back(column.data() + begin);
      kernels.finish({std::min(tile_rows, time.size() - begin), from.data(), to.data()});
    });
    return out;
  };

  SweepRows rows{fields_,
                 soa::Table(fields_->list, setup_.precision, stored_),
                 {},
                 {},
                 ended.simd_efficiency()};
  std::vector<std::vector<double>> state = columns(states, count);
  for (std::size_t f = 0; f < states; ++f) {
    const std::string_view name = kernels.state_fields[f].name;
    if (narrow) {
      std::ranges::copy(batch.column<float>(name), state[f].begin());
    } else {
      std::ranges::copy(batch.column<double>(name), state[f].begin());
    }
  }
  const std::vector<std::vector<double>> at_end = finish(ended.time, state, 1);

  soa::Table& table = rows.table;
  table.append(count);
  std::size_t field = 0;
  // One NaN, whatever the arithmetic made.
  const auto canonical = [](double x) {
    return std::isnan(x) ? std::numeric_limits<double>::quiet_NaN() : x;
  };
  const auto put_real = [&](const std::vector<double>& values) {
    if (!stored_[field]) {
      table.set_uniform(field++, values.empty() ? 0 : values[0]);
    } else if (narrow) {
      std::ranges::transform(values, table.column<float>(field++),
                             [&](double x) { return static_cast<float>(canonical(x)); });
    } else {
      std::ranges::transform(values, table.column<double>(field++), canonical);
    }
  };
  const auto put_whole = [&](const auto& values) {
    if (!stored_[field]) {
      table.set_uniform(field++, 0);
    } else {
      std::ranges::copy(values, table.column<std::uint32_t>(field++));
    }
  };
  for (std::uint64_t row = 0; row < count; ++row) table.ids()[row] = first + row;
  ++field;
  for (const std::vector<double>& column : in) put_real(column);
  std::vector<std::uint32_t> outcome(count);
  for (std::size_t row = 0; row < count; ++row) {
    const auto events = static_cast<std::uint32_t>(kernels.events.size());
    outcome[row] = ended.outcome[row] == Outcome::event
                       ? ended.event[row]
                       : events + static_cast<std::uint32_t>(ended.outcome[row]) - 1;
  }
  put_whole(outcome);
  put_whole(ended.steps);
  put_whole(ended.grazes);
  put_whole(ended.samples_taken);
  put_real(ended.time);
  for (const std::vector<double>& column : state) put_real(column);
  for (const std::vector<double>& column : at_end) put_real(column);
  for (std::size_t e = 0; e < kernels.events.size(); ++e) {
    if ((setup_.integration.record >> e & 1) == 0) continue;
    put_real(ended.recorded[e].time);
    for (const std::vector<double>& column : ended.recorded[e].state) put_real(column);
  }
  if (levels() != 0) {
    rows.sample_time = ended.samples.time;
    rows.samples = ended.samples.state;
    for (std::vector<double>& column : finish(ended.samples.time, ended.samples.state, levels())) {
      // What was not reached has no results either.
      for (std::size_t k = 0; k < column.size(); ++k) {
        if (std::isnan(rows.sample_time[k])) column[k] = std::numeric_limits<double>::quiet_NaN();
      }
      rows.samples.push_back(std::move(column));
    }
    for (std::vector<double>& column : rows.samples) {
      std::ranges::transform(column, column.begin(), canonical);
    }
  }
  table.clear_padding();
  return rows;
}

std::uint64_t Sweep::bytes_of(std::uint64_t count) const {
  const std::uint64_t columns =
      2 * fields_->list.size() + kernels_->parameter_fields.size() +
      (setup_.integration.accuracy > 0
           ? 2 * kernels_->state_fields.size() + kernels_->parameter_fields.size() +
                 levels() * (kernels_->state_fields.size() + 1)
           : 0) +
      levels() * (2 * sample_fields_.size() + kernels_->input_fields.size());
  return count * columns * sizeof(double);
}

SweepSetup nominal(const SweepSetup& setup) {
  SweepSetup one = setup;
  for (Variation& input : one.inputs) input = Variation::of(input.nominal());
  for (const JointNormal& joint : setup.joint) {
    for (std::size_t k = 0; k < joint.inputs.size(); ++k) {
      one.inputs[joint.inputs[k]].a = joint.mean[k];
    }
  }
  one.joint.clear();
  one.samples = 1;
  return one;
}

}  // namespace salvo::solver
