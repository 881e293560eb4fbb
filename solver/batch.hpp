// A batch: many independent copies of one model, a row each, advanced together by fixed steps or
// each to its own end by steps of its own. The model may be a user's own: one header, one source
// that salvo_add_kernels compiles once per instruction set (solver/batch_kernel.hpp), and this.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "models/event.hpp"
#include "models/model_data.hpp"
#include "soa/table.hpp"
#include "solver/isa.hpp"
#include "solver/parallel.hpp"
#include "solver/state_hash.hpp"

namespace salvo::solver {

/// Rows [first_row, last_row) of a batch; plain data, because it crosses to the kernels of one
/// instruction set.
template <class T>
struct BatchPass {
  std::size_t first_row = 0;
  std::size_t last_row = 0;
  T* const* state = nullptr;
  const T* const* parameters = nullptr;
  const models::ModelData* data = nullptr;
  double t0 = 0;
  double dt = 0;
  std::int64_t first_step = 0;
  std::int64_t steps = 0;
};

enum class Method {
  explicit_euler,
  semi_implicit_euler,  ///< needs a model of positions and their velocities
  heun,
  runge_kutta_4,
  tsitouras_5,
  dormand_prince_5,
  extrapolation_8,  ///< for tight tolerances
  step_doubling_euler
};

constexpr bool knows_error(Method method) {
  return method == Method::tsitouras_5 || method == Method::dormand_prince_5 ||
         method == Method::extrapolation_8 || method == Method::step_doubling_euler;
}

/// Levels of a quantity at which the state of every row is sampled when it first rises to them.
struct Samples {
  static constexpr std::size_t time = ~std::size_t{0};

  std::size_t quantity = time;  ///< index of a state, or the time
  std::vector<double> levels;   ///< ascending
};

/// How each row is taken to its own end. Tolerances bound the error of a step; `accuracy` is that
/// of the end.
struct Integration {
  Method method = Method::dormand_prince_5;
  double step = 0;  ///< s; every step, or with tolerances the first one tried
  /// Both zero: fixed steps. Else a step is repeated with a shorter one until the largest component
  /// of its error is at most absolute + relative |y|. Needs a method that knows its error.
  double absolute_tolerance = 0;
  double relative_tolerance = 0;
  /// Zero, or what the state at a row's end may be off by (of models of positions and velocities:
  /// the positions, in m). Rows are run again with tolerances a thousand times tighter until
  /// their end moves by at most a quarter of it; the first absolute tolerance is a tenth of it,
  /// unless one is given. Needs double precision.
  double accuracy = 0;
  double smallest_step = 0;  ///< s; a row that needs a shorter one ends there
  double largest_step = std::numeric_limits<double>::infinity();  ///< s; with tolerances
  std::int64_t most_steps = 1'000'000;  ///< tried steps; a row that needs more ends there
  /// The model's events that end a row, a bit each; nothing: those that the model says.
  std::optional<std::uint32_t> stop_at;
  std::uint32_t record = 0;  ///< those whose first occurrence is kept
  Samples samples;
};

/// Why a row ended.
enum class Outcome : std::uint8_t {
  event,          ///< one of the model's events; `Integrated::event` says which
  time_limit,     ///< it reached its end
  step_limit,     ///< it took Integration::most_steps
  not_finite,     ///< its state overflowed or became NaN with the step that fails
  smallest_step,  ///< its error wanted a step below Integration::smallest_step
  not_accurate    ///< no tolerance brought it to Integration::accuracy
};

std::string_view name(Outcome outcome);

/// Columns of instants: time in s, and state.
struct InstantColumns {
  double* time = nullptr;
  double* const* state = nullptr;
};

/// Where samples go: instant k of a row is element row * count + k.
struct SamplePass {
  std::size_t quantity = Samples::time;
  std::size_t count = 0;
  const double* levels = nullptr;  // of the time: since t0
  InstantColumns to;
  std::uint32_t* taken = nullptr;  // by row
};

/// Rows [first_row, last_row) to be taken to their ends.
template <class T>
struct IntegratePass {
  std::size_t first_row = 0;
  std::size_t last_row = 0;
  T* const* state = nullptr;
  const T* const* parameters = nullptr;
  const models::ModelData* data = nullptr;
  const double* end = nullptr;  ///< s, for each row
  double* time = nullptr;       ///< where it ended
  Outcome* outcome = nullptr;
  std::uint8_t* event = nullptr;
  std::uint32_t* steps = nullptr;  ///< tried
  double t0 = 0;
  /// What the kernels need of an Integration.
  struct {
    Method method;
    double step;
    double absolute_tolerance;
    double relative_tolerance;
    double smallest_step;
    double largest_step;
    std::int64_t most_steps;
  } integration;
  std::uint32_t stop_at = 0;
  std::uint32_t record = 0;
  const InstantColumns* events = nullptr;  // by event
  std::uint32_t* grazes = nullptr;         // by row, a bit an event
  SamplePass samples;
  /// Steps of lanes that had a row, and of all lanes.
  std::uint64_t useful_steps = 0;
  std::uint64_t lane_steps = 0;
};

/// Rows of columns, one in and one out a field.
struct ColumnPass {
  std::size_t rows = 0;
  const double* const* in = nullptr;
  double* const* out = nullptr;
};

/// A model's kernels on one instruction set, and its fields.
struct BatchKernels {
  std::span<const soa::Field> state_fields;
  std::span<const soa::Field> parameter_fields;
  /// What a row is described by: the state and parameters, unless the model says otherwise.
  std::span<const soa::Field> input_fields;
  /// What follows from the inputs and an instant.
  std::span<const soa::Field> result_fields;
  std::span<const models::Event> events;
  bool of_positions;  ///< the state is positions, then their velocities
  void (*advance_float32)(const BatchPass<float>&);
  void (*advance_float64)(const BatchPass<double>&);
  void (*integrate_float32)(IntegratePass<float>&);
  void (*integrate_float64)(IntegratePass<double>&);
  void (*start)(const ColumnPass&);   ///< inputs to state, then parameters
  void (*finish)(const ColumnPass&);  ///< inputs, time and state to results
  bool (*accepts_data)(const models::ModelData&);
};

/// Instants of rows, NaN where there was none.
struct Instants {
  std::vector<double> time;                ///< s
  std::vector<std::vector<double>> state;  ///< by field
};

/// What Batch::integrate tells of the rows, by row.
struct Integrated {
  std::vector<double> time;  ///< s; where the row ended
  std::vector<Outcome> outcome;
  std::vector<std::uint8_t> event;   ///< index in the model's list, where the outcome is an event
  std::vector<std::uint32_t> steps;  ///< tried, in all runs of the row
  /// By event: the first of those that were recorded.
  std::vector<Instants> recorded;
  /// Events whose quantity touched zero within 1e-9 of its scale, a bit each.
  std::vector<std::uint32_t> grazes;
  Instants samples;  ///< element row * levels + level
  std::vector<std::uint32_t> samples_taken;
  std::uint64_t useful_steps = 0;  ///< of lanes that had a row
  std::uint64_t lane_steps = 0;    ///< of all lanes

  double simd_efficiency() const {
    return lane_steps == 0 ? 1
                           : static_cast<double>(useful_steps) / static_cast<double>(lane_steps);
  }
};

/// Looks a model's kernels up by instruction set: what SALVO_DECLARE_MODEL(name) declares as
/// `name_kernels`.
using BatchModel = const BatchKernels& (*)(Isa);

class Batch {
 public:
  /// `rows` copies of the model, ids 0 .. rows - 1, every field at its fallback, at t0; `data` is
  /// what they share, where the model is made from something. Throws std::invalid_argument when it
  /// is made from something else.
  Batch(BatchModel model, soa::Precision precision, std::size_t rows, double t0 = 0,
        std::shared_ptr<const models::ModelData> data = nullptr);

  std::size_t rows() const { return table_.rows(); }
  const soa::Table& table() const { return table_; }
  /// The column of the field (state or parameter) of this name; `rows()` values. T must be the
  /// precision's type. Throws std::invalid_argument when the model has no such field.
  template <class T>
  std::span<T> column(std::string_view name) {
    return {table_.column<T>(field_index(name)), rows()};
  }

  /// Takes `steps` steps of classical Runge-Kutta of size `dt`, in s. The bits do not depend on
  /// `isa` and `threads`, nor on how many calls take the steps (with the same dt).
  void advance(std::int64_t steps, double dt, Isa isa = widest_isa(),
               int threads = hardware_threads());
  std::int64_t step() const { return step_; }

  /// Takes each row from t0 to `end[row]`, in s, by itself: a row's bits do not depend on the
  /// others, on `isa` or on `threads`. Lanes whose row has ended take up the next one. Throws
  /// std::invalid_argument.
  Integrated integrate(std::span<const double> end, const Integration& integration,
                       Isa isa = widest_isa(), int threads = hardware_threads());

  StateHash hash() const;

 private:
  template <class T>
  struct Columns {
    std::vector<T*> state;
    std::vector<const T*> parameters;
  };

  std::size_t field_index(std::string_view name) const;
  template <class T>
  Columns<T> columns_of(const BatchKernels& kernels);
  template <class T>
  void integrate_rows(const BatchKernels& kernels, std::span<const double> end,
                      const Integration& integration, int threads, Integrated& result);
  Integrated integrate_once(std::span<const double> end, const Integration& integration, Isa isa,
                            int threads);
  Integrated integrate_until_accurate(std::span<const double> end, Integration integration, Isa isa,
                                      int threads);
  template <class T>
  void advance_rows(const BatchKernels& kernels, std::int64_t steps, double dt, int threads);

  BatchModel model_;
  std::vector<soa::Field> fields_;
  soa::Table table_;
  double t0_;
  std::shared_ptr<const models::ModelData> data_;
  std::int64_t step_ = 0;
};

}  // namespace salvo::solver
