// salvo verify: one table of hashes a scene, and where the bits first differ if they do.
#include "scene/verify.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <new>

#include "cli/json.hpp"
#include "cli/memory.hpp"
#include "cli/progress.hpp"
#include "cli/scene_input.hpp"
#include "cli/sweep_verbs.hpp"
#include "cli/terminal.hpp"
#include "cli/text.hpp"
#include "cli/verbs.hpp"
#include "cli/verify_report.hpp"

namespace salvo::cli {

namespace {

using scene::VerifyResult;
using scene::VerifyRun;

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

// Prints a scene's table; fills in its document.
ExitStatus verify_scene(const std::string& path, const Options& options, Json& document) {
  const scene::AnyScene any = load_scene(path, options);
  if (const auto* sweep = std::get_if<scene::SweepScene>(&any)) {
    return verify_sweep(options, *sweep, document);
  }
  const auto& scene = std::get<scene::Scene>(any);
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

  Json runs = Json::array();
  for (const VerifyRun& run : result.runs) runs.push_back(json_of_run(run));
  document["scene"] = scene_identity(scene);
  document["equal"] = result.equal();
  document["particles"] = solver::World::total_emitted(verified.setup);
  document["steps"] = result.steps;
  document["seconds"] = progress.seconds();
  document["runs"] = runs;
  if (!options.json) {
    print(verify_report(scene, verified, result) +
          (result.equal()
               ? fmt::format("the same bits in {} ({})\n\n", counted(result.runs.size(), "run"),
                             seconds_text(progress.seconds()))
               : "the bits DIFFER\n\n"));
    flush_output();
  }
  const ExitStatus status = verify_status(result);
  if (status == ExitStatus::numerical) {
    const solver::NumericalError error(*result.runs.front().stopped);
    say_error(fmt::format("{}: every run stopped: {}", path, error.what()));
  }
  return status;
}

// A scene that cannot be verified does not keep the others from it.
ExitStatus verify_one(const std::string& path, const Options& options, Json& document) {
  try {
    return verify_scene(path, options, document);
  } catch (const scene::SceneError& error) {
    for (const std::string& mistake : error.mistakes()) say(mistake);
    document["mistakes"] = error.mistakes();
    return ExitStatus::scene_invalid;
  } catch (const Failure& error) {
    say_error(error.what(), error.hint());
    document["mistakes"] = {error.what()};
    return error.status();
  } catch (const std::bad_alloc&) {
    say_error(fmt::format("{}: out of memory", path));
    document["mistakes"] = {"out of memory"};
    return ExitStatus::run_failed;
  }
}

}  // namespace

ExitStatus verify(const Options& options) {
  ExitStatus worst = ExitStatus::done;
  Json documents = Json::array();
  for (const std::string& path : options.inputs) {
    Json document = {{"path", path}};
    worst = std::max(worst, verify_one(path, options, document));
    documents.push_back(std::move(document));
  }
  if (options.json) {
    const bool equal = std::all_of(documents.begin(), documents.end(), [](const Json& document) {
      return document.value("equal", false);
    });
    print_json({{"status", worst == ExitStatus::done ? "done" : "failed"},
                {"exit_status", static_cast<int>(worst)},
                {"equal", equal},
                {"scenes", documents}});
  }
  return worst;
}

}  // namespace salvo::cli
