#include "scene/sweep_keys.hpp"

#include <fmt/format.h>

#include <map>
#include <memory>

#include "models/drag_functions.hpp"

namespace salvo::scene {

namespace {

using solver::Method;
using solver::Sampling;

// Numbers that stand for something are given by its name.
Words words_of_input(std::string_view name) {
  Words words;
  if (name != "drag_function") return words;
  for (std::size_t i = 0; i < models::drag_functions.size(); ++i) {
    const models::DragFunction& function = models::drag_functions[i];
    words.emplace_back(function.name, static_cast<int>(i), function.projectile);
  }
  words.emplace_back("table", static_cast<int>(models::own_drag_function), "that of `[drag]`");
  return words;
}

std::string fallback_of(const soa::Field& field, const Words& words) {
  for (const Word& word : words) {
    if (word.value == static_cast<int>(field.fallback)) return fmt::format("`\"{}\"`", word.word);
  }
  return fmt::format("`{}`", field.fallback);
}

}  // namespace

bool stands_for_names(const soa::Field& input) { return !words_of_input(input.name).empty(); }

const Section<InputKeys>& input_section(const solver::ModelEntry& model) {
  static std::map<std::string_view, std::unique_ptr<const Section<InputKeys>>> sections;
  std::unique_ptr<const Section<InputKeys>>& section = sections[model.name];
  if (section) return *section;
  constexpr KeysOf<InputKeys> of;
  std::vector<Key<InputKeys>> keys;
  const std::span<const soa::Field> fields = model.kernels(solver::Isa::scalar).input_fields;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const soa::Field& field = fields[i];
    const Words words = words_of_input(field.name);
    keys.push_back(
        of.key(
              std::string(field.name),
              std::string(field.unit), [i](InputKeys & in) -> auto& { return in.inputs[i]; },
              std::string(field.meaning), between(field.lowest, field.highest), words)
            .otherwise(fallback_of(field, words)));
  }
  section = std::make_unique<const Section<InputKeys>>(std::string(model.name), false,
                                                       std::string(model.meaning), std::move(keys));
  return *section;
}

namespace {

const Section<SweepKeys>& draw_section() {
  constexpr KeysOf<SweepKeys> of;
  static const Section<SweepKeys> section(
      "sweep", false, "how many rows, and how their random inputs are drawn",
      {
          of.key(
              "samples", "", [](SweepKeys & keys) -> auto& { return keys.setup.samples; },
              "rows for each point of the grid that lists and columns make", between(1, 0x1p40)),
          of.word(
              "sampling", [](SweepKeys & keys) -> auto& { return keys.setup.sampling; },
              "how random inputs are drawn",
              {{"random", Sampling::random, "independently; more samples keep the first ones"},
               {"latin_hypercube", Sampling::latin_hypercube,
                "one value in each of as many equal parts as there are samples: their number is "
                "fixed"},
               {"sobol", Sampling::sobol,
                "a low-discrepancy sequence; more samples keep the first ones"}}),
          of.key("table", "", &SweepKeys::table,
                 "CSV or HDF5 (.hdf, .h5, .hdf5) file, beside the scene, whose columns inputs may "
                 "be"),
      });
  return section;
}

const Section<DragKeys>& drag_section() {
  using models::DragInterpolation;
  constexpr KeysOf<DragKeys> of;
  static const Section<DragKeys> section(
      "drag", false,
      "of the model `projectile`: an own drag function, and how they are interpolated",
      {
          of.key("table", "", &DragKeys::table,
                 "file, beside the scene, of Mach numbers and drag coefficients: the drag function "
                 "`\"table\"`"),
          of.key("mach", "", &DragKeys::mach, "its column of Mach numbers"),
          of.key(
              "cd", "", &DragKeys::coefficient,
              "its column of drag coefficients, referred to the area of the calibre; outside the "
              "Mach numbers the first and the last hold"),
          of.word("interpolation", &DragKeys::interpolation,
                  "between points, of all drag functions",
                  {{"monotone", DragInterpolation::monotone,
                    "a cubic with a continuous slope that does not overshoot"},
                   {"linear", DragInterpolation::linear, "straight lines"}}),
      });
  return section;
}

const Section<JointKeys>& joint_section() {
  constexpr KeysOf<JointKeys> of;
  static const Section<JointKeys> section(
      "joint_normal", true, "inputs that are normal together",
      {
          of.key("inputs", "", &JointKeys::inputs, "which").must(),
          of.key("mean", "", &JointKeys::mean, "a list, in the units of the inputs").must(),
          of.key("covariance", "", &JointKeys::covariance,
                 "a list of rows, in the SI units of the inputs; positive definite")
              .must(),
      });
  return section;
}

const Section<IntegrationKeys>& integration_section() {
  constexpr KeysOf<IntegrationKeys> of;
  static const Section<IntegrationKeys> section(
      "integration", false, "how each row is taken to its own end",
      {
          of.word("method", &IntegrationKeys::method, "how a step is taken",
                  {{"explicit_euler", Method::explicit_euler, "order 1"},
                   {"semi_implicit_euler", Method::semi_implicit_euler,
                    "order 1, for models of positions and velocities"},
                   {"heun", Method::heun, "order 2, the improved Euler method"},
                   {"runge_kutta_4", Method::runge_kutta_4, "order 4"},
                   {"tsitouras_5", Method::tsitouras_5, "order 5, knows its error"},
                   {"dormand_prince_5", Method::dormand_prince_5, "order 5, knows its error"},
                   {"extrapolation_8", Method::extrapolation_8,
                    "order 8, knows its error: for tolerances below 1e-9"},
                   {"step_doubling_euler", Method::step_doubling_euler,
                    "order 1, knows its error by two steps of half the length"}}),
          of.key("step", "s", &IntegrationKeys::step,
                 "every step; with tolerances the first one tried", positive),
          of.key("absolute_tolerance", "", &IntegrationKeys::absolute_tolerance,
                 "of the error of a step, in the SI units of the state; without tolerances steps "
                 "are fixed",
                 not_negative),
          of.key("relative_tolerance", "", &IntegrationKeys::relative_tolerance,
                 "added to it: a part of each component of the state", not_negative),
          of.key("accuracy", "", &IntegrationKeys::accuracy,
                 "what the end may be off by, in the unit of the first state (of positions and "
                 "velocities: the positions); rows are run with tighter tolerances until their end "
                 "stays within a quarter of it"),
          of.key("smallest_step", "s", &IntegrationKeys::smallest_step,
                 "a row that needs a shorter one ends there", not_negative),
          of.key("largest_step", "s", &IntegrationKeys::largest_step,
                 "no step is longer: what happens twice within a step may be missed", positive)
              .otherwise("no limit"),
          of.key("most_steps", "", &IntegrationKeys::most_steps, "a row that needs more ends there",
                 between(1, 0x1p24)),
          of.key("time_limit", "s", &IntegrationKeys::time_limit, "the end of every row", positive)
              .must(),
          of.key("stop_at", "", &IntegrationKeys::stop_at, "events that end a row")
              .otherwise("the model's"),
          of.key("record", "", &IntegrationKeys::record,
                 "events of which the first is kept, with its time and state"),
      });
  return section;
}

const Section<SampleKeys>& sample_section() {
  constexpr KeysOf<SampleKeys> of;
  static const Section<SampleKeys> section(
      "samples", false, "states on the way: either levels, or from, to and every",
      {
          of.key("of", "", &SampleKeys::of,
                 "what the levels are of: the time, or a state, when it first rises to them"),
          of.key("levels", "", &SampleKeys::levels, "a list, ascending"),
          of.key("from", "", &SampleKeys::from, "the first level").otherwise("`0`"),
          of.key("to", "", &SampleKeys::to, "the last level"),
          of.key("every", "", &SampleKeys::every, "between levels"),
          of.key("click", "rad", &SampleKeys::click,
                 "by how much a click turns the sight: samples of x are printed as a drop table",
                 positive)
              .otherwise("no drop table"),
      });
  return section;
}

const Section<PlaneKeys>& plane_section() {
  constexpr KeysOf<PlaneKeys> of;
  static const Section<PlaneKeys> section(
      "statistics.plane", false,
      "dispersion in a plane: circular error, ellipse, and hits of a target",
      {
          of.key("axes", "", &PlaneKeys::axes, "two columns"),
          of.key("aim", "", &PlaneKeys::aim, "the point that is aimed at").otherwise("`[0, 0]`"),
          of.key("half_sizes", "", &PlaneKeys::half_sizes, "of a rectangular target about it"),
      });
  return section;
}

const Section<StatisticsKeys>& statistics_section() {
  constexpr KeysOf<StatisticsKeys> of;
  static const Section<StatisticsKeys> section(
      "statistics", false, "what is told of all rows together",
      {
          of.key("columns", "", &StatisticsKeys::columns,
                 "of which mean, deviation and quantiles "
                 "are told")
              .otherwise("the time and the state at the end"),
          of.key("quantiles", "", &StatisticsKeys::quantiles, "which", between(0, 1)),
          of.key("outcomes", "", &StatisticsKeys::outcomes, "rows that count: those that ended so")
              .otherwise("all events"),
          of.table(
              "plane", plane_section(),
              [](StatisticsKeys & keys) -> auto& { return keys.plane.emplace(); }),
      });
  return section;
}

const Section<StopKeys>& stop_section() {
  constexpr KeysOf<StopKeys> of;
  static const Section<StopKeys> section(
      "stop", false,
      "end the sweep when a mean is known well enough, asked after every 65,536 rows",
      {
          of.key("column", "", &StopKeys::column, "whose mean").must(),
          of.key("half_width", "", &StopKeys::half_width, "of its confidence interval, in its unit")
              .must(),
          of.key("confidence", "", &StopKeys::confidence, "of the interval",
                 between(0.5, 0.999999)),
      });
  return section;
}

const Section<SolveKeys>& solve_section() {
  constexpr KeysOf<SolveKeys> of;
  static const Section<SolveKeys> section(
      "solve", true,
      "an input whose value follows from what it is to bring about, with all others at their means "
      "and at the first point of the grid",
      {
          of.key("input", "", &SolveKeys::input, "which; its mean, where it varies").must(),
          of.key("between", "", &SolveKeys::between, "[low, high]: where its value is sought")
              .must(),
          of.key("quantity", "", &SolveKeys::quantity, "the column that it brings to a value")
              .must(),
          of.key("equals", "", &SolveKeys::equals, "that value").otherwise("`0`"),
          of.key("outcome", "", &SolveKeys::outcome,
                 "trajectories that end otherwise do not count, such as those that fall short")
              .otherwise("all count"),
          of.word("root", &SolveKeys::root, "which, where there are several",
                  {{"first", WhichRoot::first, "the lowest value of the input"},
                   {"last", WhichRoot::last, "the highest"}}),
          of.key("each_point", "", &SolveKeys::each_point,
                 "solve at every point of the grid by itself"),
          of.key("with", "", &SolveKeys::with,
                 "inputs that are different meanwhile, as in the model's section"),
      });
  return section;
}

const Section<SweepKeys>& sweep_verify_section() {
  constexpr KeysOf<SweepKeys> of;
  static const Section<SweepKeys> section(
      "verify", false, "the size at which the scene is verified",
      {of.key("rows", "", &SweepScene::verify_rows, "at most this many of the first rows",
              between(1, 0x1p24))});
  return section;
}

}  // namespace

std::span<const Rivals> sweep_rival_keys() {
  static const std::vector<Rivals> groups{{"samples", {"levels", "every"}}};
  return groups;
}

const Section<SweepKeys>& sweep_section() {
  constexpr KeysOf<SweepKeys> of;
  static const Section<SweepKeys> section = [&] {
    std::vector<Key<SweepKeys>> keys{
        of.key("title", "", &SweepScene::title, "one line for people"),
        of.word(
            "precision", [](SweepScene & scene) -> auto& { return scene.setup.precision; },
            "how wide the numbers of the trajectories are", words_of<soa::Precision>()),
        of.key(
            "seed", "", [](SweepScene & scene) -> auto& { return scene.setup.seed; },
            "of every random draw", not_negative),
    };
    for (std::size_t m = 0; m < solver::models().size(); ++m) {
      const solver::ModelEntry& model = solver::models()[m];
      keys.push_back(of.table(
          model.name, input_section(model), [m](SweepKeys & scene) -> auto& {
            scene.models.push_back(m);
            return scene.inputs;
          }));
    }
    const auto self = [](SweepKeys & scene) -> auto& { return scene; };
    keys.push_back(of.table("sweep", draw_section(), self));
    keys.push_back(of.table(
        "drag", drag_section(), [](SweepKeys & scene) -> auto& { return scene.drag.emplace(); }));
    keys.push_back(of.list("joint_normal", joint_section(), &SweepKeys::joint));
    keys.push_back(of.table("integration", integration_section(), &SweepKeys::integration).must());
    keys.push_back(of.table(
        "samples", sample_section(),
        [](SweepKeys & scene) -> auto& { return scene.sample_keys.emplace(); }));
    keys.push_back(of.list("solve", solve_section(), &SweepKeys::solve));
    keys.push_back(of.table("statistics", statistics_section(), &SweepKeys::statistics_keys));
    keys.push_back(of.table(
        "stop", stop_section(),
        [](SweepKeys & scene) -> auto& { return scene.stop_keys.emplace(); }));
    keys.push_back(of.table("verify", sweep_verify_section(), self));
    return Section<SweepKeys>("", false, "which trajectories to compute", std::move(keys));
  }();
  return section;
}

}  // namespace salvo::scene
