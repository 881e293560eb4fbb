// The keys of a scene of trajectories and what they fill before the checks that need several of
// them.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "models/projectile_tables.hpp"
#include "scene/keys.hpp"
#include "scene/sweep_scene.hpp"

namespace salvo::scene {

inline constexpr std::size_t most_inputs = solver::SampleLine::most_dimensions;

struct InputKeys {
  std::array<InputValue, most_inputs> inputs;
};

struct JointKeys {
  std::vector<std::string> inputs;
  Later mean;
  std::vector<std::vector<double>> covariance;
};

enum class WhichRoot { first, last };

struct SolveKeys {
  std::string input;
  Later between;
  std::string quantity;
  Later equals;
  std::string outcome;
  WhichRoot root = WhichRoot::first;
  bool each_point = false;
  Later with;
};

struct DragKeys {
  std::string table;
  std::string mach = "mach";
  std::string coefficient = "cd";
  models::DragInterpolation interpolation = models::DragInterpolation::monotone;
};

struct SampleKeys {
  std::string of = "time";
  Later levels;
  Later from;
  Later to;
  Later every;
  double click = 0;
};

struct PlaneKeys {
  std::array<std::string, 2> axes{"end.y", "end.z"};
  Later aim;
  Later half_sizes;
};

struct StatisticsKeys {
  std::vector<std::string> columns;
  std::vector<double> quantiles{0.05, 0.5, 0.95};
  std::vector<std::string> outcomes;
  std::optional<PlaneKeys> plane;
};

struct StopKeys {
  std::string column;
  Later half_width;
  double confidence = 0.95;
};

struct IntegrationKeys {
  solver::Method method = solver::Method::dormand_prince_5;
  double step = 0.01;
  double absolute_tolerance = 0;
  double relative_tolerance = 0;
  Later accuracy;
  double smallest_step = 0;
  double largest_step = std::numeric_limits<double>::infinity();
  std::int64_t most_steps = 1'000'000;
  double time_limit = 0;
  std::optional<std::vector<std::string>> stop_at;
  std::vector<std::string> record;
};

struct SweepKeys : SweepScene {
  std::vector<std::size_t> models;  ///< those whose sections are given, by solver::models()
  InputKeys inputs;
  std::string table;
  std::optional<DragKeys> drag;
  std::vector<JointKeys> joint;
  IntegrationKeys integration;
  std::optional<SampleKeys> sample_keys;
  StatisticsKeys statistics_keys;
  std::optional<StopKeys> stop_keys;
  std::vector<SolveKeys> solve;
};

/// The list of all keys.
const Section<SweepKeys>& sweep_section();

/// Whether an input's numbers stand for names.
bool stands_for_names(const soa::Field& input);

/// The section of a model's inputs.
const Section<InputKeys>& input_section(const solver::ModelEntry& model);

/// Those of them that say the same as others.
std::span<const Rivals> sweep_rival_keys();

}  // namespace salvo::scene
