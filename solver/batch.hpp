// A batch: many independent copies of one model, a row each, advanced by fixed steps. The model may
// be a user's own: one header, one source that salvo_add_kernels compiles once per instruction set
// (solver/batch_kernel.hpp), and this.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

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
  double t0 = 0;
  double dt = 0;
  std::int64_t first_step = 0;
  std::int64_t steps = 0;
};

/// A model's kernels on one instruction set, and its fields.
struct BatchKernels {
  std::span<const soa::Field> state_fields;
  std::span<const soa::Field> parameter_fields;
  void (*advance_single)(const BatchPass<float>&);
  void (*advance_twice)(const BatchPass<double>&);
};

/// Looks a model's kernels up by instruction set: what SALVO_DECLARE_MODEL(name) declares as
/// `name_kernels`.
using BatchModel = const BatchKernels& (*)(Isa);

class Batch {
 public:
  /// `rows` copies of the model, ids 0 .. rows - 1, every field at its fallback, at t0.
  Batch(BatchModel model, soa::Precision precision, std::size_t rows, double t0 = 0);

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

  StateHash hash() const;

 private:
  std::size_t field_index(std::string_view name) const;
  template <class T>
  void advance_rows(const BatchKernels& kernels, std::int64_t steps, double dt, int threads);

  BatchModel model_;
  std::vector<soa::Field> fields_;
  soa::Table table_;
  double t0_;
  std::int64_t step_ = 0;
};

}  // namespace salvo::solver
