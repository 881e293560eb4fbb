// A sweep: one trajectory of a model, run many times with inputs that vary. A row is a function of
// its index: any part of a sweep, on any machine, gives the rows that the whole gives.
//
// Row i is sample i / P of point i mod P of the grid, which has P points: all combinations of the
// axes, the last input's varying fastest, a table of columns being one axis, the slowest. More
// samples leave the rows before them as they are (but for a Latin hypercube).
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "soa/table.hpp"
#include "solver/batch.hpp"
#include "solver/sampling.hpp"
#include "solver/variation.hpp"
#include "solver/world.hpp"

namespace salvo::solver {

/// Inputs that are normal together: mean + factor z, z independent and standard normal.
struct JointNormal {
  std::vector<std::size_t> inputs;
  std::vector<double> mean;
  std::vector<std::vector<double>> factor;  ///< lower triangular: Cholesky's of the covariance
};

struct SweepSetup {
  BatchModel model = nullptr;
  soa::Precision precision = soa::Precision::float64;
  std::shared_ptr<const models::ModelData> data;  ///< what the model is made from
  std::uint64_t seed = 0;
  std::vector<Variation> inputs;  ///< by the model's input fields
  std::vector<JointNormal> joint;
  Sampling sampling = Sampling::random;
  std::uint64_t samples = 1;  ///< of each point of the grid
  Integration integration;
  double time_limit = 0;  ///< s; trajectories start at 0
};

/// The fields of a sweep's rows and their names.
struct SweepFields {
  std::deque<std::string> names;
  std::vector<soa::Field> list;
};

/// Rows of a sweep: one list of fields, and the samples of each row.
struct SweepRows {
  std::shared_ptr<const SweepFields> fields;  ///< of the table, which outlives the sweep
  soa::Table table;
  /// The states and results at the levels of Integration::samples, element row * levels + level.
  std::vector<double> sample_time;
  std::vector<std::vector<double>> samples;  ///< by Sweep::sample_fields
  double simd_efficiency = 1;

  /// Of the table, and of the samples when there are any.
  Digest hash(const Parallel& parallel) const;
};

class Sweep {
 public:
  /// Rows 65,536 at a time are what is recorded, summed up and tested for convergence.
  static constexpr std::uint64_t part_rows = 65536;

  explicit Sweep(SweepSetup setup);

  const SweepSetup& setup() const { return setup_; }
  std::uint64_t points() const { return points_; }  ///< of the grid
  std::uint64_t rows() const { return points_ * setup_.samples; }

  /// The setup with the inputs that the grid varies as they are at a point of it, and without their
  /// shifts.
  SweepSetup at_point(std::uint64_t point) const;

  /// The fields of a row: id, "input.NAME", "outcome", "steps", "grazes", "sampled", "time",
  /// "end.NAME" (states, then results), and "EVENT.time", "EVENT.NAME" of recorded events.
  std::span<const soa::Field> fields() const { return fields_->list; }
  /// Of a sample: states, then results.
  std::span<const soa::Field> sample_fields() const { return sample_fields_; }
  std::size_t levels() const { return setup_.integration.samples.levels.size(); }
  /// The values of "outcome": the model's events, then the others.
  std::vector<std::string> outcomes() const;

  /// Rows [first, first + count), at most a few parts at once. `execution.pass_steps` says nothing.
  SweepRows run(std::uint64_t first, std::uint64_t count, const Execution& execution) const;

  /// Bytes that `count` rows take while they run.
  std::uint64_t bytes_of(std::uint64_t count) const;

 private:
  struct Axis {
    std::size_t input;
    std::uint64_t stride;  ///< grid points from one value to the next
  };

  void add_field(const std::string& name, soa::Field field, bool stored);
  template <class T>
  void fill_state(const std::vector<std::vector<double>>& started, Batch& batch) const;
  void inputs_of(std::uint64_t row, double* const* to, std::size_t at) const;

  SweepSetup setup_;
  const BatchKernels* kernels_;
  std::uint64_t points_ = 1;
  std::vector<Axis> axes_;
  struct RandomInput {
    std::size_t input;
    SampleLine line;
    Quantile quantile;
  };
  std::vector<RandomInput> random_;
  struct JointInput {
    std::vector<SampleLine> lines;
  };
  std::vector<JointInput> joint_;
  std::shared_ptr<SweepFields> fields_ = std::make_shared<SweepFields>();
  std::vector<bool> stored_;
  std::vector<soa::Field> sample_fields_;
};

/// The setup with every input at its nominal value: one row.
SweepSetup nominal(const SweepSetup& setup);

}  // namespace salvo::solver
