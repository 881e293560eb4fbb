#include "scene/load_sweep.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>

#include "kernels/lane.hpp"
#include "scene/document.hpp"
#include "scene/input_table.hpp"
#include "scene/mistakes.hpp"
#include "scene/nearest.hpp"
#include "scene/scene_keys.hpp"
#include "scene/solve.hpp"
#include "scene/sweep_keys.hpp"
#include "scene/units.hpp"
#include "solver/floating_point_environment.hpp"

namespace salvo::scene {

namespace {

using solver::Variation;
using S = kernels::ScalarLane<double>;

constexpr std::size_t most_levels = 100'000;
constexpr std::uint64_t most_solved_points = 10'000;
constexpr double reach = 8;  // deviations: beyond them lies one value of 10^15

// Turns what the keys hold into a scene, and checks what needs several keys.
class SweepCompletion {
 public:
  SweepCompletion(const Value& root, SweepKeys& keys, Mistakes& mistakes)
      : root_(root), keys_(keys), mistakes_(mistakes), reader_(sweep_section(), mistakes) {}

  void run() {
    if (keys_.models.empty()) {
      std::string names;
      for (const solver::ModelEntry& model : solver::models()) {
        names += fmt::format("{}[{}]", names.empty() ? "" : ", ", model.name);
      }
      fail("", "there is no model", "expected one of " + names);
      return;
    }
    keys_.model = &solver::models()[keys_.models.front()];
    if (keys_.models.size() > 1) {
      const solver::ModelEntry& other = solver::models()[keys_.models[1]];
      fail(std::string(other.name),
           fmt::format("[{}] and [{}] are both given", keys_.model->name, other.name),
           "a scene has one model");
      return;
    }
    kernels_ = &keys_.model->kernels(solver::Isa::scalar);
    keys_.setup.model = keys_.model->kernels;
    complete_inputs(keys_.inputs, std::string(keys_.model->name), keys_.setup.inputs);
    complete_drag();
    complete_joint();
    complete_integration();
    complete_samples();
    if (mistakes_.count() != 0) return;
    check_size();
    if (mistakes_.count() != 0) return;
    const solver::Sweep sweep(keys_.setup);
    complete_statistics(sweep);
    complete_stop(sweep);
    complete_solve(sweep);
  }

 private:
  void fail(const std::string& path, std::string problem, std::string hint = {}) {
    mistakes_.add(deepest(root_, path).place, std::move(problem), std::move(hint));
  }

  // The index of a name; else says what there is.
  template <class Names>
  std::optional<std::size_t> index_of(const Names& names, const std::string& name,
                                      const std::string& path, std::string_view what) {
    std::vector<std::string_view> known(names.begin(), names.end());
    const auto found = std::find(known.begin(), known.end(), name);
    if (found != known.end()) return static_cast<std::size_t>(found - known.begin());
    std::string hint = did_you_mean(name, known);
    if (hint.empty()) hint = fmt::format("expected {}", fmt::join(known, ", "));
    fail(path, fmt::format("there is no {} \"{}\"", what, name), hint);
    return std::nullopt;
  }
  static std::vector<std::string_view> names_of(std::span<const soa::Field> fields) {
    std::vector<std::string_view> names;
    for (const soa::Field& field : fields) names.push_back(field.name);
    return names;
  }
  std::vector<std::string_view> event_names() const {
    std::vector<std::string_view> names;
    for (const models::Event& event : kernels_->events) names.push_back(event.name);
    return names;
  }

  // A key whose unit is that of a field.
  static KeyText like(const soa::Field& field, const std::string& name, bool bounded) {
    KeyText key;
    key.name = name;
    key.unit = key.stored = field.unit;
    if (bounded) key.bounds = between(field.lowest, field.highest);
    return key;
  }
  template <class T>
  bool read(const Later& later, const KeyText& key, T& out) {
    if (!later.value) return false;
    const std::size_t before = mistakes_.count();
    reader_.read(*later.value, key, out);
    return mistakes_.count() == before;
  }

  void complete_inputs(const InputKeys& given, const std::string& section,
                       std::vector<Variation>& inputs) {
    const std::span<const soa::Field> fields = kernels_->input_fields;
    bool columns = false;
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const InputValue& value = given.inputs[i];
      inputs.push_back(value.given ? value.variation : Variation::of(fields[i].fallback));
      if (!value.given || value.variation.kind != Variation::Kind::column) continue;
      columns = true;
      read_column(fields[i], value.column, fmt::format("{}.{}", section, fields[i].name),
                  inputs.back());
    }
    if (!keys_.table.empty() && !columns) {
      fail("sweep.table", "no input is a column of the table", "give one: { column = \"NAME\" }");
    }
  }

  void read_column(const soa::Field& field, const std::string& column, const std::string& path,
                   Variation& input) {
    input.values = {field.fallback};
    if (keys_.table.empty()) {
      fail(path, fmt::format("\"{}\" is a column, but there is no table", field.name),
           "give table in [sweep]");
      return;
    }
    if (unreadable_) return;
    try {
      if (!table_) {
        table_ = open_table(beside_scene(keys_.table));
      }
      input.values = table_->column(column, std::string(field.unit));
    } catch (const TableError& error) {
      // A file that cannot be read is told of once.
      unreadable_ = !table_;
      fail(table_ ? path : "sweep.table", error.what(), error.hint());
      return;
    }
    for (std::size_t row = 0; row < input.values.size(); ++row) {
      if (between(field.lowest, field.highest).contain(input.values[row])) continue;
      fail(path, fmt::format("row {} of column \"{}\" is out of bounds", row + 1, column),
           "expected " + between(field.lowest, field.highest).text(field.unit));
      return;
    }
  }

  void complete_drag() {
    const std::span<const soa::Field> fields = kernels_->input_fields;
    bool used = false;
    for (std::size_t i = 0; i < fields.size(); ++i) {
      if (fields[i].name != "drag_function") continue;
      const Variation& input = keys_.setup.inputs[i];
      const std::vector<double>& values = input.values;
      constexpr auto own = static_cast<double>(models::own_drag_function);
      used = values.empty() ? input.a == own : std::ranges::find(values, own) != values.end();
    }
    const std::string model(keys_.model->name);
    const bool given = keys_.drag && !keys_.drag->table.empty();
    if (used && !given) {
      fail(model + ".drag_function", "the drag function is a table, but there is none",
           "give table in [drag]");
    }
    if (!keys_.drag) return;
    if (given && !used) {
      fail("drag.table", "no trajectory has this drag function",
           fmt::format("expected drag_function = \"table\" in [{}]", model));
    }
    std::vector<models::DragPoint> points;
    if (given) {
      try {
        const std::unique_ptr<InputTable> table = open_table(beside_scene(keys_.drag->table));
        const std::vector<double> mach = table->column(keys_.drag->mach, "");
        const std::vector<double> coefficient = table->column(keys_.drag->coefficient, "");
        for (std::size_t i = 0; i < mach.size(); ++i) points.push_back({mach[i], coefficient[i]});
      } catch (const TableError& error) {
        fail("drag.table", error.what(), error.hint());
        return;
      }
      if (const auto mistake = models::DragTables::mistake_in(points)) {
        fail("drag.table",
             fmt::format("row {} of {}: {}", mistake->point + 1, beside_scene(keys_.drag->table),
                         mistake->problem),
             mistake->hint);
        return;
      }
    }
    keys_.setup.data =
        std::make_shared<const models::DragTables>(points, keys_.drag->interpolation);
    if (!kernels_->accepts_data(*keys_.setup.data)) {
      fail("drag", fmt::format("the model {} has no drag function", model), "remove [drag]");
    }
  }

  // Neither drawn nor solved for.
  void refuse_names(std::size_t input, const std::string& path) {
    const soa::Field& field = kernels_->input_fields[input];
    if (!stands_for_names(field)) return;
    fail(path, fmt::format("\"{}\" is a name", field.name), "expected an input that is a number");
  }

  std::string beside_scene(const std::string& file) const {
    return (std::filesystem::path(keys_.path).parent_path() / file).string();
  }

  // Values that a distribution comes to are values of the input.
  void check_reach(const soa::Field& field, double mean, double deviation,
                   const std::string& path) {
    const Bounds bounds = between(field.lowest, field.highest);
    if (bounds.contain(mean - reach * deviation) && bounds.contain(mean + reach * deviation))
      return;
    fail(path, fmt::format("\"{}\" would come out of its bounds", field.name),
         fmt::format("expected {} within {} deviations of the mean", bounds.text(field.unit),
                     reach));
  }

  void complete_joint() {
    std::map<std::size_t, std::string> taken;
    for (std::size_t j = 0; j < keys_.joint.size(); ++j) {
      JointKeys& given = keys_.joint[j];
      const std::string path = fmt::format("joint_normal.{}", j);
      const std::size_t n = given.inputs.size();
      const std::size_t before = mistakes_.count();
      solver::JointNormal joint;
      for (std::size_t k = 0; k < n; ++k) {
        const std::string at = fmt::format("{}.inputs.{}", path, k);
        const auto input = index_of(names_of(kernels_->input_fields), given.inputs[k], at, "input");
        if (!input) continue;
        refuse_names(*input, at);
        if (keys_.inputs.inputs[*input].given || !taken.emplace(*input, at).second) {
          fail(at, fmt::format("\"{}\" is given elsewhere, too", given.inputs[k]),
               "an input varies in one way");
        }
        joint.inputs.push_back(*input);
      }
      if (n == 0) fail(path + ".inputs", "\"inputs\" in [[joint_normal]] is empty");
      if (mistakes_.count() != before) continue;
      if (!given.mean.value || given.mean.value->kind != Value::Kind::list ||
          given.mean.value->items.size() != n) {
        fail(path + ".mean", "\"mean\" in [[joint_normal]] does not go with \"inputs\"",
             fmt::format("expected a list of {} values", n));
        continue;
      }
      for (std::size_t k = 0; k < n; ++k) {
        const soa::Field& field = kernels_->input_fields[joint.inputs[k]];
        double mean = 0;
        reader_.read(given.mean.value->items[k], like(field, given.inputs[k], true), mean);
        joint.mean.push_back(mean);
        check_reach(field, mean,
                    k < given.covariance.size() && k < given.covariance[k].size()
                        ? sqrt(S(std::max(given.covariance[k][k], 0.0))).value()
                        : 0,
                    fmt::format("{}.mean.{}", path, k));
        keys_.setup.inputs[joint.inputs[k]] = Variation::of(mean);
      }
      bool square = given.covariance.size() == n;
      for (const auto& row : given.covariance) square = square && row.size() == n;
      if (!square) {
        fail(path + ".covariance", "\"covariance\" in [[joint_normal]] has not the right shape",
             fmt::format("expected {} rows of {} numbers", n, n));
        continue;
      }
      for (std::size_t a = 0; a < n; ++a) {
        for (std::size_t b = 0; b < a; ++b) {
          if (given.covariance[a][b] == given.covariance[b][a]) continue;
          fail(fmt::format("{}.covariance.{}.{}", path, a, b),
               "\"covariance\" in [[joint_normal]] is not symmetric",
               fmt::format("expected {}, as across the diagonal", given.covariance[b][a]));
        }
      }
      const auto factor = cholesky(given.covariance);
      if (!factor) {
        fail(path + ".covariance", "\"covariance\" in [[joint_normal]] is not positive definite",
             "no numbers have these variances and covariances");
        continue;
      }
      joint.factor = *factor;
      keys_.setup.joint.push_back(std::move(joint));
    }
  }

  std::uint32_t events(const std::vector<std::string>& names, const std::string& path) {
    std::uint32_t mask = 0;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (const auto event =
              index_of(event_names(), names[i], fmt::format("{}.{}", path, i), "event")) {
        mask |= std::uint32_t{1} << *event;
      }
    }
    return mask;
  }

  void complete_integration() {
    const IntegrationKeys& given = keys_.integration;
    solver::Integration& integration = keys_.setup.integration;
    integration.method = given.method;
    integration.step = given.step;
    integration.absolute_tolerance = given.absolute_tolerance;
    integration.relative_tolerance = given.relative_tolerance;
    integration.smallest_step = given.smallest_step;
    integration.largest_step = given.largest_step;
    if (given.accuracy.value) {
      KeyText key = like(kernels_->state_fields[0], "accuracy", false);
      key.bounds = positive;
      read(given.accuracy, key, integration.accuracy);
      if (keys_.setup.precision == soa::Precision::float32) {
        fail("integration.accuracy",
             "single precision has too few digits for an accuracy of the end",
             "expected precision = \"double\", or tolerances");
      }
    }
    integration.most_steps = given.most_steps;
    keys_.setup.time_limit = given.time_limit;
    const bool adaptive = given.absolute_tolerance > 0 || given.relative_tolerance > 0 ||
                          given.accuracy.value.has_value();
    if (adaptive && !solver::knows_error(given.method)) {
      fail("integration.method", "the method knows no error, but there is a tolerance",
           "expected one that knows its error, or no tolerance");
    }
    if (given.method == solver::Method::semi_implicit_euler && !kernels_->of_positions) {
      fail("integration.method", "the model is not one of positions and velocities",
           "expected another method");
    }
    if (given.stop_at) integration.stop_at = events(*given.stop_at, "integration.stop_at");
    integration.record = events(given.record, "integration.record");
    for (std::size_t e = 0; e < kernels_->events.size(); ++e) {
      const bool stops =
          integration.stop_at ? (*integration.stop_at >> e & 1) != 0 : kernels_->events[e].stops;
      if (!stops || (integration.record >> e & 1) == 0) continue;
      fail("integration.record",
           fmt::format("\"{}\" ends a row, so the row's end records it", kernels_->events[e].name),
           "remove it here");
    }
  }

  void complete_samples() {
    if (!keys_.sample_keys) return;
    const SampleKeys& given = *keys_.sample_keys;
    solver::Samples& samples = keys_.setup.integration.samples;
    soa::Field field{"time", soa::Scalar::real, 1, "s", "", 0, 0, 1e300};
    if (given.of != "time") {
      const auto state =
          index_of(names_of(kernels_->state_fields), given.of, "samples.of", "state");
      if (!state) return;
      samples.quantity = *state;
      field = kernels_->state_fields[*state];
    }
    keys_.click = given.click;
    if (given.click != 0 && !has_drops()) {
      fail("samples.click", "there are clicks, but no drop table",
           "expected of = \"x\", and a model with the states x, y and z");
    }
    const auto level = [&](const Later& later, const char* name, double& out) {
      return read(later, like(field, name, false), out);
    };
    if (given.levels.value) {
      if (given.from.value || given.to.value || given.every.value) {
        fail("samples", "there are levels, and from, to or every", "keep one of them");
      }
      read(given.levels, like(field, "levels", false), samples.levels);
      if (!std::is_sorted(samples.levels.begin(), samples.levels.end(), std::less_equal<>())) {
        fail("samples.levels", "\"levels\" in [samples] do not ascend");
      }
      return;
    }
    double from = 0;
    double to = 0;
    double every = 0;
    level(given.from, "from", from);
    if (!level(given.to, "to", to) || !level(given.every, "every", every)) {
      if (mistakes_.count() == 0) {
        fail("samples", "missing keys in [samples]", "give levels, or to and every");
      }
      return;
    }
    const double count = std::floor((to - from) / every + 1e-9);
    if (!(every > 0) || !(count >= 0) || count >= most_levels) {
      fail("samples.every", "from, to and every in [samples] make no list of levels",
           fmt::format("expected 1 to {} levels", most_levels));
      return;
    }
    for (std::size_t i = 0; i <= static_cast<std::size_t>(count); ++i) {
      samples.levels.push_back(from + static_cast<double>(i) * every);
    }
  }

  // Samples at ranges, of places.
  bool has_drops() const {
    const std::vector<std::string_view> states = names_of(kernels_->state_fields);
    const std::array<std::string_view, 3> place{"x", "y", "z"};
    return keys_.sample_keys->of == "x" && states.size() >= place.size() &&
           std::ranges::equal(place, std::span(states).first(place.size()));
  }

  void check_size() {
    double rows = static_cast<double>(keys_.setup.samples);
    bool table = false;
    for (const Variation& input : keys_.setup.inputs) {
      const bool column = input.kind == Variation::Kind::column;
      if (input.kind == Variation::Kind::grid || (column && !table)) {
        rows *= static_cast<double>(input.values.size());
      }
      table = table || column;
    }
    if (rows > 0x1p40)
      fail("sweep", fmt::format("there are {:.3g} rows", rows), "expected at most 2^40");
    bool random = !keys_.setup.joint.empty();
    for (const Variation& input : keys_.setup.inputs) random = random || input.random();
    if (keys_.setup.samples > 1 && !random) {
      fail("sweep.samples", "there are several samples, but no input is random",
           "all samples would be the same");
    }
  }

  std::optional<std::size_t> column(const solver::Sweep& sweep, const std::string& name,
                                    const std::string& path) {
    const auto found = index_of(names_of(sweep.fields()), name, path, "column");
    if (found && sweep.fields()[*found].scalar != soa::Scalar::real) {
      fail(path, fmt::format("\"{}\" is no measured quantity", name), "expected a real column");
      return std::nullopt;
    }
    return found;
  }

  void complete_statistics(const solver::Sweep& sweep) {
    const StatisticsKeys& given = keys_.statistics_keys;
    solver::StatisticsSettings& settings = keys_.statistics;
    for (std::size_t i = 0; i < given.columns.size(); ++i) {
      if (const auto found =
              column(sweep, given.columns[i], fmt::format("statistics.columns.{}", i))) {
        settings.columns.push_back(*found);
      }
    }
    if (given.columns.empty()) {
      for (std::size_t f = 0; f < sweep.fields().size(); ++f) {
        const std::string_view name = sweep.fields()[f].name;
        if (name == "time" || name.starts_with("end.")) settings.columns.push_back(f);
      }
    }
    settings.quantiles = given.quantiles;
    const std::vector<std::string> outcomes = sweep.outcomes();
    keys_.counted.assign(outcomes.size(), false);
    if (given.outcomes.empty()) {
      // Models without events end at the time limit.
      const std::size_t events = kernels_->events.size();
      for (std::size_t e = 0; e < std::max<std::size_t>(events, 1); ++e) keys_.counted[e] = true;
    }
    for (std::size_t i = 0; i < given.outcomes.size(); ++i) {
      if (const auto found = index_of(outcomes, given.outcomes[i],
                                      fmt::format("statistics.outcomes.{}", i), "outcome")) {
        keys_.counted[*found] = true;
      }
    }
    if (!given.plane) return;
    solver::PlaneSettings plane;
    std::array<KeyText, 2> axes;
    for (std::size_t i = 0; i < 2; ++i) {
      const auto found =
          column(sweep, given.plane->axes[i], fmt::format("statistics.plane.axes.{}", i));
      if (!found) return;
      plane.columns[i] = *found;
      axes[i] = like(sweep.fields()[*found], "aim", false);
    }
    const auto pair = [&](const Later& later, const char* name, Bounds bounds,
                          std::array<double, 2>& out) {
      if (!later.value) return false;
      if (later.value->kind != Value::Kind::list || later.value->items.size() != 2) {
        fail(fmt::format("statistics.plane.{}", name),
             fmt::format("\"{}\" in [statistics.plane] is no pair", name),
             "expected two values, one for each axis");
        return false;
      }
      for (std::size_t i = 0; i < 2; ++i) {
        axes[i].name = name;
        axes[i].bounds = bounds;
        reader_.read(later.value->items[i], axes[i], out[i]);
      }
      return true;
    };
    pair(given.plane->aim, "aim", any_number, plane.aim);
    std::array<double, 2> half_sizes{};
    if (pair(given.plane->half_sizes, "half_sizes", positive, half_sizes)) {
      plane.half_sizes = half_sizes;
    }
    settings.plane = plane;
  }

  void complete_stop(const solver::Sweep& sweep) {
    if (!keys_.stop_keys) return;
    const auto found = column(sweep, keys_.stop_keys->column, "stop.column");
    if (!found) return;
    StopSettings stop;
    stop.column = *found;
    stop.confidence = keys_.stop_keys->confidence;
    KeyText key = like(sweep.fields()[*found], "half_width", false);
    key.bounds = positive;
    read(keys_.stop_keys->half_width, key, stop.half_width);
    keys_.stop = stop;
    if (keys_.setup.sampling != solver::Sampling::random) {
      fail("stop", "[stop] needs independent samples", "expected sampling = \"random\" in [sweep]");
    }
  }

  void complete_solve(const solver::Sweep& sweep) {
    std::vector<Equation> equations;
    for (std::size_t i = 0; i < keys_.solve.size(); ++i) {
      const SolveKeys& given = keys_.solve[i];
      const std::string path = fmt::format("solve.{}", i);
      const std::size_t before = mistakes_.count();
      Equation equation;
      equation.path = path;
      const auto input =
          index_of(names_of(kernels_->input_fields), given.input, path + ".input", "input");
      const auto quantity = column(sweep, given.quantity, path + ".quantity");
      if (!input || !quantity) continue;
      equation.input = *input;
      equation.column = *quantity;
      equation.last = given.root == WhichRoot::last;
      if (!given.outcome.empty()) {
        const std::vector<std::string> outcomes = sweep.outcomes();
        if (const auto outcome = index_of(outcomes, given.outcome, path + ".outcome", "outcome")) {
          equation.outcome = static_cast<std::uint32_t>(*outcome);
        }
      }
      refuse_names(*input, path + ".input");
      const Variation& varies = keys_.setup.inputs[*input];
      if (varies.kind == Variation::Kind::grid || varies.kind == Variation::Kind::column) {
        fail(path + ".input", fmt::format("\"{}\" is a list of values", given.input),
             "expected an input with one value or mean");
      }
      const soa::Field& field = kernels_->input_fields[*input];
      read(given.between, like(field, "between", true), equation.between);
      if (mistakes_.count() == before && !(equation.between[0] < equation.between[1])) {
        fail(path + ".between", "\"between\" in [[solve]] has no width", "expected [low, high]");
      }
      read(given.equals, like(sweep.fields()[*quantity], "equals", false), equation.target);
      complete_with(given, path, equation);
      if (mistakes_.count() == before) equations.push_back(std::move(equation));
    }
    if (mistakes_.count() != 0 || equations.empty()) return;
    const bool each_point = keys_.solve.front().each_point;
    for (std::size_t i = 0; i < keys_.solve.size(); ++i) {
      if (keys_.solve[i].each_point == each_point) continue;
      fail(fmt::format("solve.{}", i), "one equation is for each point of the grid, another is not",
           "give each_point in all [[solve]] or in none");
    }
    if (each_point && sweep.points() > most_solved_points) {
      fail("solve.0.each_point", fmt::format("the grid has {} points", sweep.points()),
           fmt::format("expected at most {}, each of which is solved for before the sweep begins",
                       most_solved_points));
    }
    if (mistakes_.count() != 0) return;
    for (const Unsolved& unsolved :
         each_point ? solve_each_point(equations, keys_.setup) : solve(equations, keys_.setup)) {
      const Equation& equation = *unsolved.equation;
      const soa::Field& field = kernels_->input_fields[equation.input];
      const soa::Field& quantity = sweep.fields()[equation.column];
      const std::string at_point =
          each_point ? fmt::format(", at point {} of the grid", unsolved.point) : std::string();
      if (unsolved.pinned) {
        fail(equation.path + ".quantity",
             fmt::format("for some values of {}, {} is {:.9g} {} because trajectories end there{}",
                         field.name, quantity.name, equation.target, quantity.unit, at_point),
             "put what ends them out of reach, such as with = { ground = -1e6 }");
        continue;
      }
      if (unsolved.least > unsolved.greatest) {
        fail(equation.path + (equation.outcome ? ".outcome" : ".between"),
             fmt::format("no {} from {:.9g} to {:.9g} {} {}{}", field.name, equation.between[0],
                         equation.between[1], field.unit,
                         equation.outcome ? "has this outcome" : "brings a trajectory to an end",
                         at_point),
             equation.outcome ? "expected an outcome that some trajectory has"
                              : "all of them break off: look at the outcome of one");
        continue;
      }
      fail(equation.path + ".between",
           fmt::format("no {} from {:.9g} to {:.9g} {} brings {} to {:.9g} {}{}", field.name,
                       equation.between[0], equation.between[1], field.unit, quantity.name,
                       equation.target, quantity.unit, at_point),
           fmt::format("it comes to {:.9g} to {:.9g} {}", unsolved.least, unsolved.greatest,
                       quantity.unit));
    }
    check_solved(equations);
    for (const Equation& equation : equations) {
      keys_.solved.push_back({equation.input, equation.value, equation.by_point,
                              std::string(sweep.fields()[equation.column].name), equation.target});
    }
  }

  // What is solved for moves a distribution: it must stay within the input's bounds.
  void check_solved(const std::vector<Equation>& equations) {
    for (const Equation& equation : equations) {
      const soa::Field& field = kernels_->input_fields[equation.input];
      const Variation& input = keys_.setup.inputs[equation.input];
      const auto [least, greatest] = input.shifts.empty() ? std::ranges::minmax_result<double>{0, 0}
                                                          : std::ranges::minmax(input.shifts);
      double low = input.a;
      double high = input.a;
      if (input.kind == Variation::Kind::uniform) high = input.b;
      if (input.kind == Variation::Kind::normal) {
        low -= reach * input.b;
        high += reach * input.b;
      }
      if (input.kind == Variation::Kind::truncated_normal) {
        low = input.lowest;
        high = input.highest;
      }
      const Bounds bounds = between(field.lowest, field.highest);
      if (bounds.contain(low + least) && bounds.contain(high + greatest)) continue;
      fail(equation.path + ".input",
           fmt::format("\"{}\" would come out of its bounds about the value found", field.name),
           fmt::format("expected {}, within {} deviations of a normal one; within = [low, high] "
                       "holds it",
                       bounds.text(field.unit), reach));
    }
  }

  void complete_with(const SolveKeys& given, const std::string& path, Equation& equation) {
    if (!given.with.value) return;
    if (given.with.value->kind != Value::Kind::table) {
      fail(path + ".with", fmt::format("\"with\" in [[solve]] is {}", name(given.with.value->kind)),
           "expected a table of inputs, such as { range = 100 }");
      return;
    }
    InputKeys with;
    input_section(*keys_.model).read(reader_, *given.with.value, with);
    for (std::size_t i = 0; i < kernels_->input_fields.size(); ++i) {
      if (!with.inputs[i].given) continue;
      if (with.inputs[i].variation.kind != Variation::Kind::constant) {
        fail(fmt::format("{}.with.{}", path, kernels_->input_fields[i].name),
             fmt::format("\"{}\" varies", kernels_->input_fields[i].name),
             "expected one value: solving is done with all inputs at their means");
      }
      if (stands_for_names(kernels_->input_fields[i]) && !keys_.setup.data &&
          with.inputs[i].variation.a == static_cast<double>(models::own_drag_function)) {
        fail(fmt::format("{}.with.{}", path, kernels_->input_fields[i].name),
             "the drag function is a table, but there is none", "give table in [drag]");
      }
      equation.with.emplace_back(i, with.inputs[i].variation.a);
    }
  }

  const Value& root_;
  SweepKeys& keys_;
  Mistakes& mistakes_;
  Reader reader_;
  const solver::BatchKernels* kernels_ = nullptr;
  std::unique_ptr<InputTable> table_;
  bool unreadable_ = false;
};

bool is_sweep(const Value& root) {
  const auto models = solver::models();
  return root.find("sweep") || root.find("integration") ||
         std::any_of(models.begin(), models.end(),
                     [&](const solver::ModelEntry& model) { return root.find(model.name); });
}

}  // namespace

const SceneText& text_of(const AnyScene& scene) {
  return std::visit([](const auto& either) -> const SceneText& { return either; }, scene);
}

SweepScene parse_sweep(const std::string& text, const std::string& path,
                       const std::vector<std::string>& overrides) {
  const solver::FloatingPointEnvironment environment;
  const std::string_view body = without_mark(text);
  Mistakes mistakes(path, body, overrides);
  SweepKeys keys;
  keys.path = path;
  keys.text = text;
  keys.overrides = overrides;
  if (const std::optional<Value> root =
          read_document(body, overrides, sweep_rival_keys(), mistakes)) {
    Reader reader(sweep_section(), mistakes);
    sweep_section().read(reader, *root, keys);
    SweepCompletion(*root, keys, mistakes).run();
  }
  if (mistakes.count() != 0) throw SceneError(mistakes.texts());
  return keys;
}

AnyScene parse_any(const std::string& text, const std::string& path,
                   const std::vector<std::string>& overrides) {
  Mistakes ignored(path, without_mark(text), overrides);
  const std::optional<Value> root =
      read_document(without_mark(text), overrides, rival_keys(), ignored);
  if (root && is_sweep(*root)) return parse_sweep(text, path, overrides);
  return parse(text, path, overrides);
}

AnyScene load_any(const std::string& path, const std::vector<std::string>& overrides) {
  return parse_any(read_scene_file(path), path, overrides);
}

}  // namespace salvo::scene
