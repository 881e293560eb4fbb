#include "cli/sweep_report.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "cli/drop_table.hpp"
#include "cli/text.hpp"
#include "cli/text_table.hpp"
#include "recording/frame.hpp"
#include "solver/models.hpp"

namespace salvo::cli {

namespace {

using solver::Sweep;
using solver::SweepRows;

std::string number(double value) { return fmt::format("{:.8g}", value); }

// The value of a field as JSON, whatever it holds.
Json value_of(const Sweep& sweep, const soa::Table& table, std::size_t field, std::size_t row) {
  const soa::Field& what = sweep.fields()[field];
  if (what.scalar == soa::Scalar::uint64) return table.column<std::uint64_t>(field)[row];
  if (what.scalar == soa::Scalar::uint32) {
    const std::uint32_t whole = table.stored(field)
                                    ? table.column<std::uint32_t>(field)[row]
                                    : static_cast<std::uint32_t>(table.uniform(field));
    if (what.name == "outcome") return sweep.outcomes()[whole];
    return whole;
  }
  if (!table.stored(field)) return table.uniform(field);
  return table.precision() == soa::Precision::float32
             ? Json(static_cast<double>(table.column<float>(field)[row]))
             : Json(table.column<double>(field)[row]);
}

std::string text_of(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return number(value.get<double>());
  if (value.is_number()) return fmt::to_string(value.get<std::uint64_t>());
  return "none";
}

std::string with_unit(const soa::Field& field) {
  return field.unit.empty() ? std::string(field.name)
                            : fmt::format("{} {}", field.name, field.unit);
}

}  // namespace

Json scene_identity(const scene::SweepScene& scene) {
  return {{"path", scene.path},
          {"overrides", scene.overrides},
          {"digest", solver::to_string(scene::row_digest(scene))},
          {"version", SALVO_VERSION},
          {"contract", scene::contract_version}};
}

Json json_of(const scene::SweepScene& scene, const Sweep& sweep,
             const solver::Statistics& statistics, const std::vector<std::uint64_t>& outcomes) {
  Json document = {{"rows", 0}, {"counted", statistics.moments.count()}};
  std::uint64_t rows = 0;
  Json by_outcome = Json::object();
  const std::vector<std::string> names = sweep.outcomes();
  for (std::size_t i = 0; i < names.size(); ++i) {
    by_outcome[names[i]] = outcomes[i];
    rows += outcomes[i];
  }
  document["rows"] = rows;
  document["outcomes"] = by_outcome;
  document["columns"] = Json::array();
  const solver::Moments& moments = statistics.moments;
  const std::vector<std::size_t>& columns = scene.statistics.columns;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const soa::Field& field = sweep.fields()[columns[i]];
    Json quantiles = Json::array();
    for (std::size_t q = 0; q < scene.statistics.quantiles.size(); ++q) {
      quantiles.push_back(
          {{"part", scene.statistics.quantiles[q]}, {"value", statistics.quantiles[i][q]}});
    }
    Json covariance = Json::array();
    for (std::size_t k = 0; k < columns.size(); ++k) {
      covariance.push_back(moments.covariance(i, k));
    }
    document["columns"].push_back({{"column", field.name},
                                   {"unit", field.unit},
                                   {"count", moments.count(i)},
                                   {"mean", moments.mean(i)},
                                   {"deviation", moments.deviation(i)},
                                   {"least", moments.least(i)},
                                   {"greatest", moments.greatest(i)},
                                   {"quantiles", quantiles},
                                   {"covariance", covariance}});
  }
  document["plane"] = nullptr;
  if (statistics.plane) {
    const solver::PlaneStatistics& plane = *statistics.plane;
    const auto circles = [](const std::array<double, 3>& radii) {
      return Json{{"50", radii[0]}, {"90", radii[1]}, {"95", radii[2]}};
    };
    Json axes = Json::array();
    for (const std::size_t column : scene.statistics.plane->columns) {
      axes.push_back(sweep.fields()[column].name);
    }
    document["plane"] = {{"axes", axes},
                         {"count", plane.count},
                         {"mean", plane.mean},
                         {"circular_error", circles(plane.circular_error)},
                         {"circular_error_of_aim", circles(plane.circular_error_of_aim)},
                         {"ellipse", {{"semi_axes", plane.semi_axes}, {"angle", plane.angle}}}};
    if (scene.statistics.plane->half_sizes) {
      document["plane"]["hits"] = {{"count", plane.hits},
                                   {"probability", plane.hit_probability},
                                   {"interval_95", plane.hit_interval}};
    }
  }
  return document;
}

Json json_of(const Sweep& sweep, const SweepRows& rows, double click) {
  Json list = Json::array();
  for (std::size_t row = 0; row < rows.table.rows(); ++row) {
    Json object = Json::object();
    for (std::size_t f = 0; f < sweep.fields().size(); ++f) {
      object[std::string(sweep.fields()[f].name)] = value_of(sweep, rows.table, f, row);
    }
    if (sweep.levels() != 0) {
      Json samples = Json::object();
      const auto add = [&](const std::string& name, const std::vector<double>& values) {
        const auto first = values.begin() + static_cast<std::ptrdiff_t>(row * sweep.levels());
        samples[name] =
            std::vector<double>(first, first + static_cast<std::ptrdiff_t>(sweep.levels()));
      };
      add("time", rows.sample_time);
      for (std::size_t f = 0; f < rows.samples.size(); ++f) {
        add(std::string(sweep.sample_fields()[f].name), rows.samples[f]);
      }
      if (click != 0) {
        for (const DropLine& line : drop_lines(sweep, rows, row, click)) {
          samples["clicks_up"].push_back(line.clicks_up);
          samples["clicks_right"].push_back(line.clicks_right);
        }
      }
      object["samples"] = samples;
    }
    list.push_back(std::move(object));
  }
  return list;
}

std::string solved_text(const scene::SweepScene& scene) {
  std::string text;
  const auto inputs = scene.model->kernels(solver::Isa::scalar).input_fields;
  for (const scene::Solved& solved : scene.solved) {
    const soa::Field& field = inputs[solved.input];
    if (!solved.by_point.empty()) {
      const auto [least, greatest] = std::ranges::minmax(solved.by_point);
      text += fmt::format("{} from {:.12g} to {:.12g} {} brings {} to {:g} at each of {} points\n",
                          field.name, least, greatest, field.unit, solved.quantity, solved.target,
                          grouped(solved.by_point.size()));
      continue;
    }
    text += fmt::format("{} = {:.12g} {} brings {} to {:g}\n", field.name, solved.value, field.unit,
                        solved.quantity, solved.target);
  }
  return text;
}

std::string statistics_text(const scene::SweepScene& scene, const Sweep& sweep,
                            const solver::Statistics& statistics,
                            const std::vector<std::uint64_t>& outcomes) {
  std::string text;
  const std::vector<std::string> names = sweep.outcomes();
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (outcomes[i] == 0) continue;
    text += fmt::format("{:>16}  {}{}\n", grouped(outcomes[i]), names[i],
                        scene.counted[i] ? "" : " (not counted)");
  }
  if (statistics.moments.count() == 0) return text + "\nno row counts for the statistics\n";
  std::vector<std::string> headings{"<column", "mean", "deviation", "least", "greatest"};
  for (const double part : scene.statistics.quantiles) {
    headings.push_back(fmt::format("{:g} %", 100 * part));
  }
  TextTable table(headings);
  for (std::size_t i = 0; i < scene.statistics.columns.size(); ++i) {
    const solver::Moments& moments = statistics.moments;
    std::vector<std::string> row{with_unit(sweep.fields()[scene.statistics.columns[i]]),
                                 number(moments.mean(i)), number(moments.deviation(i)),
                                 number(moments.least(i)), number(moments.greatest(i))};
    for (const double value : statistics.quantiles[i]) row.push_back(number(value));
    table.add(std::move(row));
  }
  text += "\n" + table.text();
  for (std::size_t i = 0; i < scene.statistics.columns.size(); ++i) {
    if (statistics.moments.count(i) == statistics.moments.count()) continue;
    text += fmt::format("{} is of the {} rows that have it\n",
                        sweep.fields()[scene.statistics.columns[i]].name,
                        grouped(statistics.moments.count(i)));
  }
  if (!statistics.plane) return text;
  const solver::PlaneStatistics& plane = *statistics.plane;
  const auto axis = [&](std::size_t i) {
    return sweep.fields()[scene.statistics.plane->columns[i]].name;
  };
  const std::string_view unit = sweep.fields()[scene.statistics.plane->columns[0]].unit;
  const auto circles = [&](const char* about, const std::array<double, 3>& radii) {
    return fmt::format("circular error {:<14} 50 %: {:.6g}, 90 %: {:.6g}, 95 %: {:.6g} {}\n", about,
                       radii[0], radii[1], radii[2], unit);
  };
  text += fmt::format("\nplane of {} and {}: mean point {:.6g}, {:.6g} {}\n", axis(0), axis(1),
                      plane.mean[0], plane.mean[1], unit);
  text += circles("about the mean", plane.circular_error);
  text += circles("about the aim", plane.circular_error_of_aim);
  text += fmt::format(
      "ellipse of one deviation: semi-axes {:.6g} and {:.6g} {}, {:.4g} deg from {}\n",
      plane.semi_axes[0], plane.semi_axes[1], unit, plane.angle * 57.29577951308232, axis(0));
  if (scene.statistics.plane->half_sizes) {
    text += fmt::format("hits {} of {}: {:.4f} %, between {:.4f} and {:.4f} % at 95 %\n",
                        grouped(plane.hits), grouped(plane.count), 100 * plane.hit_probability,
                        100 * plane.hit_interval[0], 100 * plane.hit_interval[1]);
  }
  return text;
}

std::string rows_text(const Sweep& sweep, const SweepRows& rows, double click) {
  std::vector<std::string> headings{"<"};
  for (std::size_t row = 0; row < rows.table.rows(); ++row) {
    headings.push_back(fmt::format("row {}", rows.table.ids()[row]));
  }
  TextTable table(headings);
  for (std::size_t f = 1; f < sweep.fields().size(); ++f) {
    // What is the same in every row and given is no news.
    if (!rows.table.stored(f)) continue;
    std::vector<std::string> line{with_unit(sweep.fields()[f])};
    for (std::size_t row = 0; row < rows.table.rows(); ++row) {
      line.push_back(text_of(value_of(sweep, rows.table, f, row)));
    }
    table.add(std::move(line));
  }
  std::string text = table.text();
  if (sweep.levels() == 0) return text;
  constexpr std::size_t most_lines = 200;
  std::vector<std::string> columns{"time s"};
  for (const soa::Field& field : sweep.sample_fields()) columns.push_back(with_unit(field));
  TextTable samples(columns);
  for (std::size_t level = 0; level < std::min(sweep.levels(), most_lines); ++level) {
    std::vector<std::string> line{number(rows.sample_time[level])};
    for (const std::vector<double>& values : rows.samples) line.push_back(number(values[level]));
    samples.add(std::move(line));
  }
  text += fmt::format("\nsamples of row {}\n", rows.table.ids()[0]) + samples.text();
  if (sweep.levels() > most_lines) {
    text += fmt::format("... {} more\n", grouped(sweep.levels() - most_lines));
  }
  if (click == 0) return text;
  return text +
         fmt::format("\ndrop table of row {}, clicks of {:g} mrad\n", rows.table.ids()[0],
                     1e3 * click) +
         drop_table_text(drop_lines(sweep, rows, 0, click));
}

}  // namespace salvo::cli
