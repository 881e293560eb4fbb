// salvo verify: one table of hashes a scene, and where the bits first differ if they do.
#include "scene/verify.hpp"

#include <fmt/format.h>

#include <cstdlib>

#include "cli/json.hpp"
#include "cli/memory.hpp"
#include "cli/progress.hpp"
#include "cli/scene_input.hpp"
#include "cli/terminal.hpp"
#include "cli/text.hpp"
#include "cli/text_table.hpp"
#include "cli/verbs.hpp"

namespace salvo::cli {

namespace {

using scene::Difference;
using scene::VerifyResult;
using scene::VerifyRun;

// "0x1.8p+1 (3)": the bits, and the number for a person.
std::string with_decimal(const std::string& value) {
  if (value.find("0x") == std::string::npos) return value;
  return fmt::format("{} ({:.9g})", value, std::strtod(value.c_str(), nullptr));
}

std::string describe(const Difference& difference) {
  std::string text = difference.exact()
                         ? fmt::format("first difference at step {}", difference.step)
                         : fmt::format(
                               "differs at step {}, after equal bits at step {}, and not "
                               "again in single steps",
                               difference.step, difference.equal_step);
  text += fmt::format(": {}", difference.column);
  if (difference.id) {
    text += fmt::format(" of particle {} (stream {}, serial {})", *difference.id,
                        soa::stream_of(*difference.id), soa::serial_of(*difference.id));
  }
  text += fmt::format("\n  reference  {}\n  here       {}\n", with_decimal(difference.reference),
                      with_decimal(difference.varied));
  if (difference.rows > 1) {
    text += fmt::format("  {} differ at this step\n", counted(difference.rows, "particle"));
  }
  return text;
}

std::string heading(const scene::Scene& verified) {
  const std::uint64_t rows = solver::World::total_emitted(verified.setup);
  return fmt::format("{}: {}\n", verified.path,
                     verified.scaling.empty()
                         ? fmt::format("{}, {}", counted(rows, "particle"),
                                       counted(static_cast<std::uint64_t>(verified.steps), "step"))
                         : verified.scaling);
}

std::string result_of(const VerifyRun& run, const VerifyRun& reference) {
  if (run.difference) return "DIFFERENT";
  if (&run == &reference) return "";
  return run.hash == reference.hash ? "equal" : "equal to the same particles";
}

std::string table_of(const VerifyResult& result) {
  TextTable table({"<axis", "<set to", "particles", "frames", "<hash of the last frame", "<"});
  for (const VerifyRun& run : result.runs) {
    table.add({std::string(name(run.axis)), run.value, grouped(run.rows), grouped(run.frames),
               to_string(run.hash), result_of(run, result.runs.front())});
  }
  return table.text();
}

Json json_of_run(const VerifyRun& run) {
  Json object = {
      {"axis", name(run.axis)},  {"value", run.value},   {"execution", json_of(run.execution)},
      {"particles", run.rows},   {"frames", run.frames}, {"hash", to_string(run.hash)},
      {"equal", !run.difference}};
  if (run.stopped) object["stopped"] = json_of(*run.stopped);
  if (run.difference) {
    Json difference = {{"step", run.difference->step},
                       {"equal_step", run.difference->equal_step},
                       {"exact", run.difference->exact()},
                       {"column", run.difference->column}};
    if (run.difference->id) add_id(difference, *run.difference->id);
    difference["reference"] = run.difference->reference;
    difference["varied"] = run.difference->varied;
    difference["particles"] = run.difference->rows;
    object["difference"] = difference;
  }
  return object;
}

scene::VerifyOptions settings_of(const Options& options) {
  scene::VerifyOptions settings;
  settings.isas = options.isas;
  if (!options.threads.empty()) settings.threads = options.threads;
  if (!options.passes.empty()) settings.passes = options.passes;
  return settings;
}

// Prints a scene's table; adds its document.
ExitStatus verify_one(const std::string& path, const Options& options, Json& documents) {
  const scene::Scene scene = load_scene(path, options);
  const scene::Scene verified = options.full ? scene : scene::scaled_for_verify(scene);
  // The world, the copy of its last equal frame, and what a restore passes through.
  check_memory(verified, 3 * run_bytes(verified, false));
  scene::VerifyOptions settings = settings_of(options);
  Progress progress(options.quiet);
  settings.on_progress = [&](const scene::VerifyProgress& at) {
    const double of_run =
        at.steps == 0 ? 1 : static_cast<double>(at.step) / static_cast<double>(at.steps);
    progress.update((static_cast<double>(at.run) + of_run) / static_cast<double>(at.runs), [&] {
      return fmt::format("{}: run {} of {}, {} {}", path, at.run + 1, at.runs, name(at.what->axis),
                         at.what->axis == scene::VerifyAxis::reference ? "" : at.what->value);
    });
  };
  const VerifyResult result = scene::verify(verified, settings);
  progress.clear();

  const std::optional<solver::BadRow>& stopped = result.runs.front().stopped;
  Json runs = Json::array();
  for (const VerifyRun& run : result.runs) runs.push_back(json_of_run(run));
  documents.push_back({{"scene", scene_identity(scene)},
                       {"equal", result.equal()},
                       {"particles", solver::World::total_emitted(verified.setup)},
                       {"steps", result.steps},
                       {"seconds", progress.seconds()},
                       {"runs", runs}});
  if (!options.json) {
    print(heading(verified) + table_of(result));
    for (const VerifyRun& run : result.runs) {
      if (run.difference)
        print(fmt::format("{} {}: {}", name(run.axis), run.value, describe(*run.difference)));
    }
    print(result.equal()
              ? fmt::format("the same bits in {} ({})\n\n", counted(result.runs.size(), "run"),
                            seconds_text(progress.seconds()))
              : "the bits DIFFER\n\n");
    flush_output();
  }
  if (!result.equal()) return ExitStatus::difference;
  if (!stopped) return ExitStatus::done;
  say_error(
      fmt::format("{}: every run stopped: {}", path, solver::NumericalError(*stopped).what()));
  return ExitStatus::numerical;
}

}  // namespace

ExitStatus verify(const Options& options) {
  ExitStatus worst = ExitStatus::done;
  Json documents = Json::array();
  for (const std::string& path : options.inputs) {
    worst = std::max(worst, verify_one(path, options, documents));
  }
  if (options.json) {
    print_json({{"status", worst == ExitStatus::done ? "done" : "failed"},
                {"exit_status", static_cast<int>(worst)},
                {"equal", worst != ExitStatus::difference},
                {"scenes", documents}});
  }
  return worst;
}

}  // namespace salvo::cli
