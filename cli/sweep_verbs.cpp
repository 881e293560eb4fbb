// What salvo hash, verify, info and export do with scenes of trajectories.
#include "cli/sweep_verbs.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <optional>

#include "cli/mean_stop.hpp"
#include "cli/memory.hpp"
#include "cli/progress.hpp"
#include "cli/sweep_report.hpp"
#include "cli/terminal.hpp"
#include "cli/text.hpp"
#include "cli/text_table.hpp"
#include "recording/directory.hpp"
#include "recording/export.hpp"
#include "recording/output_file.hpp"
#include "recording/run_report.hpp"
#include "recording/sweep_part.hpp"
#include "recording/sweep_recording.hpp"
#include "scene/verify_sweep.hpp"
#include "scene/words.hpp"

namespace salvo::cli {

using solver::Sweep;

ExitStatus verify_sweep(const Options& options, const scene::SweepScene& scene, Json& document) {
  scene::SweepVerifyOptions settings;
  settings.isas = options.isas;
  if (!options.threads.empty()) settings.threads = options.threads;
  const Sweep sweep(scene.setup);
  settings.rows = options.full ? sweep.rows() : std::min(sweep.rows(), scene.verify_rows);
  // The reference, and the rows that are compared with it.
  check_memory(scene, 2 * sweep.bytes_of(settings.rows));
  Progress progress(options.quiet);
  settings.on_progress = [&](std::size_t run, std::size_t runs) {
    progress.update(static_cast<double>(run) / static_cast<double>(runs),
                    [&] { return fmt::format("{}: run {} of {}", scene.path, run, runs); });
  };
  const std::vector<scene::SweepVerifyRun> runs = scene::verify(scene, settings);
  progress.clear();

  bool equal = true;
  TextTable table({"<axis", "<value", "rows", "<hash", "<"});
  Json list = Json::array();
  std::string differences;
  for (const scene::SweepVerifyRun& run : runs) {
    equal = equal && !run.difference;
    table.add({run.axis, run.value, fmt::to_string(run.rows), to_string(run.hash),
               run.difference ? "DIFFERS" : ""});
    Json object = {{"axis", run.axis},
                   {"value", run.value},
                   {"rows", run.rows},
                   {"hash", to_string(run.hash)},
                   {"equal", !run.difference}};
    if (const auto& difference = run.difference) {
      object["difference"] = {{"index", difference->index},
                              {"column", difference->column},
                              {"reference", difference->reference},
                              {"varied", difference->varied}};
      differences += fmt::format("{} {}: row {} differs first, in {}: {:.17g}, not {:.17g}\n",
                                 run.axis, run.value, difference->index, difference->column,
                                 difference->varied, difference->reference);
    }
    list.push_back(std::move(object));
  }
  document["scene"] = scene_identity(scene);
  document["equal"] = equal;
  document["rows"] = settings.rows;
  document["seconds"] = progress.seconds();
  document["runs"] = list;
  if (!options.json) {
    const std::string size =
        settings.rows < sweep.rows()
            ? fmt::format("{} of {} rows", grouped(settings.rows), grouped(sweep.rows()))
            : counted(sweep.rows(), "row");
    print(fmt::format("{}: {}\n{}{}{}\n\n", scene.path, size, table.text(), differences,
                      equal ? fmt::format("the same bits in {} ({})", counted(runs.size(), "run"),
                                          seconds_text(progress.seconds()))
                            : "the bits DIFFER"));
    flush_output();
  }
  return equal ? ExitStatus::done : ExitStatus::difference;
}

ExitStatus hash_sweep(const Options& options, const scene::SweepScene& scene) {
  const Sweep sweep(scene.setup);
  check_memory(scene, sweep.bytes_of(std::min(sweep.rows(), Sweep::part_rows)));
  std::optional<MeanStop> stop;
  if (scene.stop) stop.emplace(scene);
  Progress progress(options.quiet);
  const solver::Parallel parallel(options.execution().threads);
  std::vector<recording::PartDigest> parts;
  std::uint64_t hashed = 0;
  while (hashed < sweep.rows() && !(stop && stop->reached())) {
    const std::uint64_t first = hashed;
    const std::uint64_t count = std::min(Sweep::part_rows, sweep.rows() - first);
    hashed += count;
    const solver::SweepRows rows = sweep.run(first, count, options.execution());
    parts.push_back({first, count, rows.hash(parallel)});
    if (stop) stop->add_part(sweep, rows);
    progress.update(static_cast<double>(first + count) / static_cast<double>(sweep.rows()),
                    [&] { return fmt::format("row {} of {}", first + count, sweep.rows()); });
    if (!options.json) {
      progress.clear();
      print(fmt::format("{}  rows {} to {}\n", to_string(parts.back().hash), first,
                        first + count - 1));
      flush_output();
    }
  }
  const std::string total = to_string(recording::sweep_hash(parts));
  if (options.json) {
    Json list = Json::array();
    for (const recording::PartDigest& part : parts) {
      list.push_back({{"first", part.first}, {"rows", part.rows}, {"hash", to_string(part.hash)}});
    }
    Json document = {{"status", "done"},
                     {"scene", scene_identity(scene)},
                     {"execution", json_of(options.execution())},
                     {"state_hash", total},
                     {"parts", list}};
    if (stop) document["stop"] = {{"reached", stop->reached()}, {"half_width", stop->half_width()}};
    print_json(document);
  } else if (hashed < sweep.rows()) {
    print(fmt::format("{}  {} rows, where [stop] ends the sweep\n", total, hashed));
  } else {
    print(fmt::format("{}  all {} rows\n", total, sweep.rows()));
  }
  return ExitStatus::done;
}

void describe_sweep(const Options& options, const scene::SweepScene& scene) {
  const Sweep sweep(scene.setup);
  const auto inputs = scene.model->kernels(solver::Isa::scalar).input_fields;
  std::vector<std::string> varied;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (scene.setup.inputs[i].kind != solver::Variation::Kind::constant) {
      varied.emplace_back(inputs[i].name);
    }
  }
  for (const solver::JointNormal& joint : scene.setup.joint) {
    for (const std::size_t input : joint.inputs) varied.emplace_back(inputs[input].name);
  }
  std::uint64_t bytes = 0;
  std::vector<std::string_view> columns;
  for (const soa::Field& field : sweep.fields()) {
    columns.push_back(field.name);
    bytes += size_of(field.scalar, scene.setup.precision);
  }
  bytes += sweep.levels() * (1 + sweep.sample_fields().size()) * sizeof(double);
  bytes *= sweep.rows();
  if (options.json) {
    print_json({{"scene", scene_identity(scene)},
                {"title", scene.title},
                {"model", scene.model->name},
                {"precision", scene::name(scene.setup.precision)},
                {"seed", scene.setup.seed},
                {"rows", sweep.rows()},
                {"grid_points", sweep.points()},
                {"samples", scene.setup.samples},
                {"varied", varied},
                {"columns", columns},
                {"bytes", bytes},
                {"memory_bytes", sweep.bytes_of(std::min(sweep.rows(), Sweep::part_rows))}});
    return;
  }
  const auto line = [](const char* name, const std::string& text) {
    return fmt::format("  {:<12} {}\n", name, text);
  };
  print(fmt::format("{}{}{}\n", scene.path, scene.title.empty() ? "" : ": ", scene.title));
  print(line("model", fmt::format("{}: {}", scene.model->name, scene.model->meaning)));
  print(line("rows", fmt::format("{}: {} of {}, {} precision, seed {}", grouped(sweep.rows()),
                                 counted(scene.setup.samples, "sample"),
                                 counted(sweep.points(), "grid point"),
                                 scene::name(scene.setup.precision), scene.setup.seed)));
  print(line("varied", varied.empty() ? "nothing" : fmt::format("{}", fmt::join(varied, ", "))));
  const std::string solved = solved_text(scene);
  for (std::size_t from = 0; from < solved.size();) {
    const std::size_t end = solved.find('\n', from);
    print(line(from == 0 ? "solved" : "", solved.substr(from, end - from)));
    from = end + 1;
  }
  print(line("columns", fmt::format("{}", fmt::join(columns, " "))));
  print(line("recording", fmt::format("about {}", bytes_text(bytes))));
  print(line("memory", bytes_text(sweep.bytes_of(std::min(sweep.rows(), Sweep::part_rows)))));
  print(line("digest", to_string(scene::row_digest(scene))));
}

namespace {

// A recording's rows follow on from file to file; a shard's begin elsewhere than at row 0.
void require_next(const recording::PartInfo& before, const recording::PartInfo& part,
                  const std::filesystem::path& path) {
  const std::string folder = path.parent_path().string();
  if (part.row_digest != before.row_digest) {
    throw Failure(ExitStatus::input_output,
                  fmt::format("{} is of another scene than the files before it", path.string()),
                  fmt::format("their digests are {} and {}", to_string(part.row_digest),
                              to_string(before.row_digest)));
  }
  const std::uint64_t next = before.first + before.rows;
  if (part.first == next) return;
  throw Failure(ExitStatus::input_output,
                part.first > next
                    ? fmt::format("rows {} to {} are missing in {}", next, part.first - 1, folder)
                    : fmt::format("{} begins at row {}, not {}", path.string(), part.first, next),
                "salvo run with --resume computes what is missing");
}

// Rows that the last run left, as it says; 0 when it says nothing.
std::uint64_t reported_rows(const std::filesystem::path& directory) {
  try {
    const auto run = recording::read_run_report(directory);
    return run ? run->rows : 0;
  } catch (const recording::CorruptFile&) {
    return 0;
  }
}

}  // namespace

ExitStatus export_sweep(const Options& options) {
  namespace fs = std::filesystem;
  if (options.format != recording::ExportFormat::csv) {
    throw UsageError("a sweep is exported as CSV", "its HDF5 files hold the same arrays");
  }
  if (options.frame) throw UsageError("a sweep has no frames", "leave out --frame");
  const fs::path input = options.inputs.front();
  const auto parts = recording::list_parts(input);
  const bool to_stdout = options.out == "-";
  const fs::path directory = to_stdout ? fs::path() : options.out.value_or(input / "csv");
  const fs::path path = directory / "trajectories.csv";
  std::optional<recording::OutputFile> file;
  if (!to_stdout) {
    recording::ensure_directory(directory);
    file.emplace(path);
  }
  Progress progress(options.quiet);
  std::uint64_t bytes = 0;
  std::uint64_t rows = 0;
  std::optional<recording::PartInfo> before;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    auto [info, part] = recording::read_part(parts[i].path);
    if (before) require_next(*before, info, parts[i].path);
    rows += info.rows;
    before = std::move(info);
    recording::select_columns(part, options.columns);
    // One header for all parts.
    bool header = i != 0;
    recording::write_csv(part, [&](std::string_view text) {
      if (header) text.remove_prefix(text.find('\n') + 1);
      header = false;
      bytes += text.size();
      to_stdout ? print(text) : file->write(text);
    });
    progress.update(static_cast<double>(i + 1) / static_cast<double>(parts.size()), [&] {
      return fmt::format("part {} of {}  {} written", i + 1, parts.size(), bytes_text(bytes));
    });
  }
  progress.clear();
  if (const std::uint64_t recorded = reported_rows(input); rows < recorded) {
    throw Failure(ExitStatus::input_output,
                  fmt::format("{} holds {} of the {} rows that {} tells of", input.string(), rows,
                              recorded, recording::run_name),
                  "salvo run with --resume computes what is missing");
  }
  if (to_stdout) return ExitStatus::done;
  file->commit();
  if (options.json) {
    print_json({{"status", "done"},
                {"format", "csv"},
                {"directory", directory.string()},
                {"bytes_written", bytes},
                {"files", {path.string()}}});
  } else {
    print(fmt::format("{}, {}\n", path.string(), bytes_text(bytes)));
  }
  return ExitStatus::done;
}

}  // namespace salvo::cli
