// salvo run: steps a scene, records it, and says at the end what came of it, also when it was
// interrupted or broke.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <new>
#include <optional>

#include "cli/diagnostics_table.hpp"
#include "cli/interruption.hpp"
#include "cli/json.hpp"
#include "cli/memory.hpp"
#include "cli/progress.hpp"
#include "cli/run_profile.hpp"
#include "cli/scene_input.hpp"
#include "cli/stepper.hpp"
#include "cli/sweep_verbs.hpp"
#include "cli/terminal.hpp"
#include "cli/text.hpp"
#include "cli/verbs.hpp"
#include "recording/checkpoint.hpp"
#include "recording/directory.hpp"
#include "recording/recorder.hpp"

namespace salvo::cli {

namespace {

using recording::RunStatus;

// What a run left behind, however it ended.
struct Outcome {
  RunStatus status = RunStatus::running;
  ExitStatus exit = ExitStatus::done;
  std::string problem;
  std::optional<solver::BadRow> bad_row;
  bool no_room = false;  // on the disk
};

class RecordedRun {
 public:
  RecordedRun(const Options& options, const scene::Scene& scene, std::filesystem::path directory)
      : options_(options),
        scene_(scene),
        directory_(std::move(directory)),
        execution_(options.execution()),
        progress_(options.quiet) {}

  ExitStatus run() {
    start();
    Outcome outcome;
    try {
      outcome = step_and_record();
      recorder_->finish(outcome.status, outcome.problem);
    } catch (const solver::NumericalError& error) {
      outcome = {RunStatus::failed, ExitStatus::numerical, error.what(), error.row(), false};
      finish_after(outcome);
    } catch (const solver::OverlapAtBirth& error) {
      outcome = {RunStatus::failed, ExitStatus::scene_invalid,
                 fmt::format("{}; {}", error.what(), error.hint()), std::nullopt, false};
      finish_after(outcome);
    } catch (const recording::OutputError& error) {
      outcome = {RunStatus::failed, ExitStatus::input_output, error.what(), std::nullopt,
                 error.no_room()};
      finish_after(outcome);
    } catch (const std::bad_alloc&) {
      outcome = {RunStatus::failed, ExitStatus::run_failed, "out of memory", std::nullopt, false};
      finish_after(outcome);
    } catch (const std::exception& error) {
      outcome = {RunStatus::failed, ExitStatus::run_failed, error.what(), std::nullopt, false};
      finish_after(outcome);
    }
    seconds_ = progress_.seconds();
    progress_.clear();
    say_relaxed();
    say_removed();
    if (options_.json) {
      print_json(document(outcome));
    } else {
      print_result();
    }
    flush_output();
    if (options_.profile && !options_.json) {
      say(profile_text(
          {stepping_seconds_, recording_seconds_, recorder_->counters().seconds_waited, *world_}));
    }
    say_ending(outcome);
    return outcome.exit;
  }

 private:
  void start() {
    std::optional<recording::CheckpointData> state;
    if (options_.resume) {
      state = recording::resume_point(directory_, scene_, scene_.steps, say_warning);
      if (state) resumed_from_ = state->step;
    } else {
      say_what_is_replaced();
    }
    recording::RecorderOptions settings;
    settings.command_line = options_.command_line;
    settings.execution = execution_;
    settings.resume = options_.resume;
    settings.overwrite = options_.force;
    // The world first: where it does not fit in memory, what is in the folder stays.
    world_ = std::make_unique<solver::World>(scene_.setup, execution_);
    if (state) std::move(*state).restore(*world_);
    recorder_ = std::make_unique<recording::Recorder>(directory_, scene_, std::move(settings));
    if (resumed_from_) {
      note(fmt::format("going on from step {} of {} in {}", *resumed_from_, scene_.steps,
                       directory_.string()));
    } else if (options_.resume) {
      note(fmt::format("nothing to go on from in {}; starting at step 0", directory_.string()));
    }
  }

  void say_what_is_replaced() const {
    std::optional<recording::RecordedRun> before;
    try {
      before = recording::read_run_report(directory_);
    } catch (const recording::CorruptFile&) {
      return;  // the recorder decides
    }
    if (before && before->status != RunStatus::done && before->step > 0 &&
        before->scene_digest == scene::scene_digest(scene_)) {
      note(fmt::format("starting again; --resume would have gone on from the run in {}",
                       directory_.string()));
    }
  }

  Outcome step_and_record() {
    Stepper stepper(*world_, [&] { show_progress(); });
    record_due();
    while (world_->step() < scene_.steps) {
      const double start = progress_.seconds();
      stepper.advance_to(recorder_->next_due(world_->step()));
      stepping_seconds_ += progress_.seconds() - start;
      record_due();
      if (interrupted() && world_->step() < scene_.steps) {
        recorder_->checkpoint(*world_);
        return {RunStatus::interrupted, ExitStatus::interrupted,
                fmt::format("interrupted at step {}", world_->step()), std::nullopt, false};
      }
    }
    return {RunStatus::done, ExitStatus::done, {}, std::nullopt, false};
  }

  void record_due() {
    const double start = progress_.seconds();
    recorder_->record_due(*world_);
    recording_seconds_ += progress_.seconds() - start;
    if (world_->step() % scene_.frames.every == 0) {
      frames_.push_back({world_->step() / scene_.frames.every, recorder_->last()});
    }
  }

  void show_progress() {
    const double done = static_cast<double>(world_->step()) /
                        static_cast<double>(std::max<std::int64_t>(scene_.steps, 1));
    progress_.update(done, [&] {
      return fmt::format("frame {} of {}  {}  {} written", world_->step() / scene_.frames.every + 1,
                         scene_.frame_count(), rate_text(rate()),
                         bytes_text(recorder_->counters().bytes_written));
    });
  }

  double rate() const {
    const double seconds = seconds_ > 0 ? seconds_ : progress_.seconds();
    return seconds > 0 ? static_cast<double>(world_->particle_steps()) / seconds : 0;
  }

  // The recording of a run that broke: what there is becomes readable, and the first error stays
  // the one that is told.
  void finish_after(const Outcome& outcome) {
    try {
      recorder_->finish(outcome.status, outcome.problem);
    } catch (const std::exception&) {  // NOLINT(bugprone-empty-catch)
    }
  }

  void note(const std::string& text) const {
    if (!options_.quiet) say("salvo: " + text);
  }

  const recording::StateInfo* last() const {
    return frames_.empty() ? nullptr : &recorder_->last();
  }

  void print_result() {
    print(diagnostics_tables(frames_));
    const recording::RecorderCounters counters = recorder_->counters();
    if (last()) {
      print(fmt::format("\nstate hash  {} at step {}\n", to_string(last()->hash.total),
                        last()->step));
    }
    print(fmt::format("{} in {}: {} ({}, {})\n", counted(world_->particle_steps(), "particle-step"),
                      seconds_text(seconds_), rate_text(rate()), solver::name(execution_.isa),
                      counted(static_cast<std::uint64_t>(execution_.threads), "thread")));
    print(fmt::format("{}, {}, {} in {}\n", counted(counters.frames, "frame"),
                      counted(counters.checkpoints, "checkpoint"),
                      bytes_text(counters.bytes_written), directory_.string()));
  }

  void say_relaxed() const {
    const solver::BirthOverlaps& relaxed = world_->relaxed();
    if (relaxed.pairs > 0) note(fmt::format("{}; moved apart", describe(relaxed)));
  }

  // Particles that leave are what the scene expects; those that become non-finite are not.
  void say_removed() const {
    const auto text = [](const solver::Removals& removals) {
      return fmt::format("{} removed; the first: {}", counted(removals.count, "particle"),
                         solver::NumericalError(*removals.first).what());
    };
    if (world_->left_domain().first) note(text(world_->left_domain()));
    if (world_->non_finite().first) say_warning(text(world_->non_finite()));
  }

  std::string resume_command() const {
    return command_for(scene_, "run") + " --out " + shell_quoted(directory_.string()) + " --resume";
  }

  void say_ending(const Outcome& outcome) const {
    switch (outcome.status) {
      case RunStatus::running:
      case RunStatus::done:
        note(fmt::format("look at it: salvo export {} --format csv, or open {} in ParaView",
                         shell_quoted(directory_.string()),
                         (directory_ / recording::series_name).string()));
        break;
      case RunStatus::interrupted:
        say(fmt::format("salvo: {} of {}; what is recorded is complete\nto go on: {}",
                        outcome.problem, scene_.steps, resume_command()));
        break;
      case RunStatus::failed: {
        const recording::RecorderCounters counters = recorder_->counters();
        say_error(outcome.problem,
                  counters.frames == 0
                      ? fmt::format("no frame is recorded in {}", directory_.string())
                      : fmt::format("recorded so far and readable: {} in {}",
                                    counted(counters.frames, "frame"), directory_.string()));
        if (outcome.no_room) {
          say("  to go on when there is room: " + resume_command());
        }
        break;
      }
    }
  }

  Json document(const Outcome& outcome) const {
    const recording::RecorderCounters counters = recorder_->counters();
    Json document = {{"status", recording::name(outcome.status)},
                     {"exit_status", static_cast<int>(outcome.exit)},
                     {"scene", scene_identity(scene_)},
                     {"directory", directory_.string()},
                     {"execution", json_of(execution_)},
                     {"step", world_->step()},
                     {"steps", scene_.steps},
                     {"resumed_from", resumed_from_ ? Json(*resumed_from_) : Json(nullptr)},
                     {"particle_steps", world_->particle_steps()},
                     {"seconds", seconds_},
                     {"particle_steps_per_second", rate()},
                     {"recorded",
                      {{"frames", counters.frames},
                       {"kept", counters.kept},
                       {"checkpoints", counters.checkpoints},
                       {"bytes_written", counters.bytes_written}}}};
    document["removed"] = {{"left_domain", json_of(world_->left_domain())},
                           {"non_finite", json_of(world_->non_finite())}};
    document["relaxed"] = {{"pairs", world_->relaxed().pairs}, {"worst", world_->relaxed().worst}};
    document["state_hash"] = last() ? Json(to_string(last()->hash.total)) : Json(nullptr);
    if (outcome.status == RunStatus::interrupted) document["resume"] = resume_command();
    if (outcome.status == RunStatus::failed) {
      document["error"] = {{"message", outcome.problem}};
      if (outcome.bad_row) document["error"].update(json_of(*outcome.bad_row));
    }
    if (options_.profile) {
      document["profile"] = profile_document(
          {stepping_seconds_, recording_seconds_, counters.seconds_waited, *world_});
    }
    document["frames"] = Json::array();
    for (const FrameLine& line : frames_) {
      Json frame = {{"frame", line.frame},
                    {"step", line.state.step},
                    {"time", line.state.time},
                    {"hash", to_string(line.state.hash.total)}};
      frame.update(json_of(line.state.diagnostics));
      frame["impacts"] = line.state.tally.impacts;
      frame["rests"] = line.state.tally.rests;
      frame["removed"] = line.state.removed;
      document["frames"].push_back(std::move(frame));
    }
    return document;
  }

  const Options& options_;
  const scene::Scene& scene_;
  const std::filesystem::path directory_;
  const solver::Execution execution_;
  Progress progress_;
  std::unique_ptr<recording::Recorder> recorder_;
  std::unique_ptr<solver::World> world_;
  std::optional<std::int64_t> resumed_from_;
  std::vector<FrameLine> frames_;
  double seconds_ = 0;
  double stepping_seconds_ = 0;
  double recording_seconds_ = 0;
};

std::filesystem::path default_directory(const scene::Scene& scene) {
  return std::filesystem::path("out") / std::filesystem::path(scene.path).stem();
}

}  // namespace

ExitStatus run(const Options& options) {
  const scene::AnyScene any = load_scene(options.inputs.front(), options);
  if (const auto* sweep = std::get_if<scene::SweepScene>(&any)) return run_sweep(options, *sweep);
  const auto& scene = std::get<scene::Scene>(any);
  if (options.index || options.shard) {
    throw UsageError("--index and --shard are for scenes of trajectories",
                     fmt::format("{} is one of particles", scene.path));
  }
  check_memory(scene, run_bytes(scene, true));
  catch_interruptions();
  const std::filesystem::path directory = options.out.value_or(default_directory(scene));
  try {
    return RecordedRun(options, scene, directory).run();
  } catch (const recording::ForeignRecording& error) {
    throw Failure(ExitStatus::input_output, error.what(),
                  "--out records elsewhere; --force replaces what is there");
  }
}

}  // namespace salvo::cli
