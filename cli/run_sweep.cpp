// salvo run, for scenes of trajectories: rows to files, part by part, and what is told of them all.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <future>
#include <memory>
#include <optional>

#include "cli/interruption.hpp"
#include "cli/mean_stop.hpp"
#include "cli/memory.hpp"
#include "cli/progress.hpp"
#include "cli/scene_input.hpp"
#include "cli/sweep_report.hpp"
#include "cli/sweep_verbs.hpp"
#include "cli/terminal.hpp"
#include "cli/text.hpp"
#include "recording/directory.hpp"
#include "recording/sweep_recording.hpp"

namespace salvo::cli {

namespace {

using recording::PartDigest;
using recording::RunStatus;
using solver::Sweep;

// Rows that are worth printing one by one.
constexpr std::uint64_t few_rows = 6;

class SweepRun {
 public:
  SweepRun(const Options& options, const scene::SweepScene& scene, std::filesystem::path directory)
      : options_(options),
        scene_(scene),
        sweep_(scene.setup),
        directory_(std::move(directory)),
        execution_(options.execution()),
        progress_(options.quiet),
        last_(parts_of(sweep_.rows())) {
    if (scene.stop) stop_.emplace(scene);
    if (!options.shard) return;
    const auto [shard, shards] = *options.shard;
    first_ = last_ * (shard - 1) / shards;
    last_ = last_ * shard / shards;
    if (scene.stop) {
      throw UsageError("--shard runs a part of the rows, and [stop] asks after all before them",
                       "remove [stop], or run it in one piece");
    }
    if (first_ == last_) {
      throw UsageError(
          fmt::format("shard {} of {} has no rows", shard, shards),
          fmt::format("the sweep has {} of {} rows", counted(parts_of(sweep_.rows()), "part"),
                      grouped(Sweep::part_rows)));
    }
  }

  ExitStatus run() {
    // One part runs while another is written.
    check_memory(scene_, sweep_.bytes_of(std::min(sweep_.rows(), 2 * Sweep::part_rows)));
    recording::SweepOptions settings{options_.command_line, execution_, options_.resume,
                                     options_.force, std::nullopt};
    if (options_.shard) settings.shard = {first_, last_};
    recording_ = std::make_unique<recording::SweepRecording>(directory_, scene_, sweep_, settings);
    if (!options_.json) print(solved_text(scene_));
    try {
      take_parts();
      return conclude();
    } catch (const recording::OutputError& error) {
      seconds_ = progress_.seconds();
      progress_.clear();
      fail(error.what());
      if (options_.json) {
        Json document = result("failed");
        document["exit_status"] = static_cast<int>(ExitStatus::input_output);
        document["error"] = {{"message", error.what()}};
        print_json(document);
      }
      say_error(error.what(), fmt::format("recorded so far and readable: {} in {}",
                                          counted(rows(), "row"), directory_.string()));
      if (error.no_room()) say("  to go on when there is room: " + resume_command());
      return ExitStatus::input_output;
    } catch (const std::exception& error) {
      progress_.clear();
      fail(error.what());
      throw;
    }
  }

 private:
  static std::uint64_t parts_of(std::uint64_t rows) {
    return (rows + Sweep::part_rows - 1) / Sweep::part_rows;
  }

  // A part is hashed and written while the next one is computed.
  void take_parts() {
    for (std::uint64_t part = first_; part < last_ && !stopped(); ++part) {
      const std::uint64_t first = part * Sweep::part_rows;
      const std::uint64_t count = std::min(Sweep::part_rows, sweep_.rows() - first);
      if (const auto kept = recording_->kept(part, count)) {
        take_written();
        parts_.push_back(*kept);
        kept_ += count;
        // They are told from their rows, which a file does not give back as they were.
        if (few()) tell_rows(sweep_.run(first, count, execution_));
      } else {
        auto rows = std::make_shared<const solver::SweepRows>(sweep_.run(first, count, execution_));
        efficiency_ += rows->simd_efficiency * static_cast<double>(count);
        if (few()) tell_rows(*rows);
        take_written();
        written_ = std::async(std::launch::async,
                              [this, part, rows] { return recording_->write(part, *rows); });
      }
      if (stop_) {
        take_written();
        ask_to_stop();
      }
      progress_.update(static_cast<double>(part + 1 - first_) / static_cast<double>(last_ - first_),
                       [&] {
                         return fmt::format("{} of {} rows  {}  {} written", grouped(rows()),
                                            grouped(wanted_rows()), trajectory_rate(),
                                            bytes_text(recording_->bytes_written()));
                       });
      if (interrupted() && part + 1 < last_) {
        interrupted_ = true;
        break;
      }
    }
    take_written();
  }

  void take_written() {
    if (!written_.valid()) return;
    parts_.push_back(written_.get());
    computed_ += parts_.back().rows;
  }

  void ask_to_stop() {
    const std::size_t column = scene_.stop->column;
    recording_->counted_columns({parts_.back()})(std::span(&column, 1),
                                                 [&](auto columns) { stop_->add_part(columns); });
  }
  bool stopped() const { return stop_ && stop_->reached(); }

  bool few() const { return sweep_.rows() <= few_rows; }
  void tell_rows(const solver::SweepRows& rows) {
    few_ = rows_text(sweep_, rows, scene_.click);
    few_json_ = json_of(sweep_, rows, scene_.click);
  }

  ExitStatus conclude() {
    seconds_ = progress_.seconds();
    progress_.clear();
    const solver::Digest hash = recording::sweep_hash(parts_);
    if (interrupted_) {
      recording_->finish(RunStatus::interrupted, parts_, {}, seconds_,
                         fmt::format("interrupted after {} rows", rows()));
      if (options_.json) {
        Json document = result("interrupted");
        document["resume"] = resume_command();
        print_json(document);
      }
      say(fmt::format(
          "salvo: interrupted after {} of {}; what is recorded is complete\nto go on: {}",
          grouped(rows()), counted(wanted_rows(), "row"), resume_command()));
      return ExitStatus::interrupted;
    }
    const std::vector<std::uint64_t> outcomes = recording_->outcome_counts(parts_);
    const solver::Statistics statistics =
        solver::statistics(scene_.statistics, recording_->counted_columns(parts_));
    const Json told = json_of(scene_, sweep_, statistics, outcomes);
    recording_->finish(RunStatus::done, parts_,
                       told.dump(2, ' ', false, Json::error_handler_t::replace) + "\n", seconds_);
    if (options_.json) {
      Json document = result("done");
      document["statistics"] = told;
      if (!few_json_.is_null()) document["trajectories"] = few_json_;
      print_json(document);
    } else {
      if (!few_.empty()) {
        print(few_);
      } else {
        print(statistics_text(scene_, sweep_, statistics, outcomes));
      }
      if (stopped()) {
        print(fmt::format("\nstopped after {}: the mean of {} is known to +-{:.4g}\n",
                          counted(rows(), "row"), sweep_.fields()[scene_.stop->column].name,
                          stop_->half_width()));
      }
      print(fmt::format("\nhash  {} of {}\n", to_string(hash), counted(rows(), "row")));
      if (computed_ != 0) {
        print(fmt::format("{} in {}: {} ({}, {})\n", counted(computed_, "trajectory"),
                          seconds_text(seconds_), trajectory_rate(), solver::name(execution_.isa),
                          counted(static_cast<std::uint64_t>(execution_.threads), "thread")));
      }
      if (kept_ != 0) {
        print(fmt::format("{} {} there\n", counted(kept_, "row"), kept_ == 1 ? "was" : "were"));
      }
      print(
          fmt::format("{} in {}\n", bytes_text(recording_->bytes_written()), directory_.string()));
    }
    flush_output();
    if (!options_.quiet) {
      say(fmt::format("salvo: look at it: h5py.File(\"{}\"), or salvo export {} --format csv",
                      (directory_ / recording::trajectories_name).string(),
                      shell_quoted(directory_.string())));
    }
    return ExitStatus::done;
  }

  void fail(const std::string& reason) {
    try {
      recording_->finish(RunStatus::failed, parts_, {}, progress_.seconds(), reason);
    } catch (const std::exception&) {  // NOLINT(bugprone-empty-catch)
    }
  }

  Json result(const char* status) const {
    Json document = {
        {"status", status},
        {"scene", scene_identity(scene_)},
        {"directory", directory_.string()},
        {"execution", json_of(execution_)},
        {"rows", rows()},
        {"kept", kept_},
        {"hash", parts_.empty() ? Json() : Json(to_string(recording::sweep_hash(parts_)))},
        {"seconds", seconds_},
        {"trajectories_per_second", rate()},
        {"simd_efficiency", computed_ == 0 ? 1 : efficiency_ / static_cast<double>(computed_)},
        {"bytes_written", recording_->bytes_written()}};
    document["solved"] = Json::array();
    const auto inputs = scene_.model->kernels(solver::Isa::scalar).input_fields;
    for (const scene::Solved& solved : scene_.solved) {
      Json entry = {{"input", inputs[solved.input].name}};
      solved.by_point.empty() ? entry["value"] = solved.value : entry["values"] = solved.by_point;
      document["solved"].push_back(std::move(entry));
    }
    if (stop_) document["stop"] = {{"reached", stopped()}, {"half_width", stop_->half_width()}};
    return document;
  }

  std::uint64_t rows() const { return kept_ + computed_; }
  std::uint64_t wanted_rows() const {
    return std::min(sweep_.rows(), last_ * Sweep::part_rows) - first_ * Sweep::part_rows;
  }
  double rate() const {
    const double seconds = seconds_ > 0 ? seconds_ : progress_.seconds();
    return seconds > 0 ? static_cast<double>(computed_) / seconds : 0;
  }
  std::string trajectory_rate() const {
    return fmt::format("{:.4g} k trajectories/s", rate() / 1e3);
  }
  std::string resume_command() const {
    std::string command =
        command_for(scene_, "run") + " --out " + shell_quoted(directory_.string());
    if (options_.shard)
      command += fmt::format(" --shard {}/{}", options_.shard->first, options_.shard->second);
    return command + " --resume";
  }

  const Options& options_;
  const scene::SweepScene& scene_;
  const Sweep sweep_;
  const std::filesystem::path directory_;
  const solver::Execution execution_;
  Progress progress_;
  std::unique_ptr<recording::SweepRecording> recording_;
  std::future<PartDigest> written_;
  std::vector<PartDigest> parts_;
  std::optional<MeanStop> stop_;
  std::uint64_t first_ = 0;  // parts
  std::uint64_t last_;
  std::uint64_t kept_ = 0;  // rows
  std::uint64_t computed_ = 0;
  double efficiency_ = 0;
  bool interrupted_ = false;
  double seconds_ = 0;
  std::string few_;
  Json few_json_;
};

// One row alone, not recorded.
ExitStatus run_index(const Options& options, const scene::SweepScene& scene) {
  const Sweep sweep(scene.setup);
  const std::uint64_t index = *options.index;
  if (index >= sweep.rows()) {
    throw UsageError(fmt::format("there is no row {}", index),
                     fmt::format("the rows go from 0 to {}", sweep.rows() - 1));
  }
  check_memory(scene, sweep.bytes_of(1));
  const solver::SweepRows rows = sweep.run(index, 1, options.execution());
  if (options.json) {
    print_json({{"status", "done"},
                {"scene", scene_identity(scene)},
                {"execution", json_of(options.execution())},
                {"index", index},
                {"hash", to_string(rows.hash(solver::Parallel(1)))},
                {"trajectories", json_of(sweep, rows, scene.click)}});
  } else {
    print(rows_text(sweep, rows, scene.click));
    print(fmt::format("\nhash  {}\n", to_string(rows.hash(solver::Parallel(1)))));
  }
  return ExitStatus::done;
}

}  // namespace

ExitStatus run_sweep(const Options& options, const scene::SweepScene& scene) {
  if (options.profile) {
    throw UsageError("--profile is for scenes of particles",
                     fmt::format("{} is one of trajectories", scene.path));
  }
  if (options.index) return run_index(options, scene);
  catch_interruptions();
  const std::filesystem::path directory =
      options.out.value_or(std::filesystem::path("out") / std::filesystem::path(scene.path).stem());
  try {
    return SweepRun(options, scene, directory).run();
  } catch (const recording::ForeignRecording& error) {
    throw Failure(ExitStatus::input_output, error.what(),
                  "--out records elsewhere; --force replaces what is there");
  } catch (const recording::LongerRecording& error) {
    throw Failure(
        ExitStatus::input_output, error.what(),
        "more samples keep them, --out records elsewhere; --force replaces what is there");
  }
}

}  // namespace salvo::cli
