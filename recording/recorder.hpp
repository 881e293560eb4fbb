// Records a run into a directory while it goes on: frames, checkpoints and run.json, written by a
// thread of the recorder's own.
//
//   Recorder recorder(directory, scene, options);
//   recorder.record_due(world);
//   while (world.step() < scene.steps) {
//     world.advance_to(recorder.next_due(world.step()));
//     recorder.record_due(world);
//   }
//   recorder.finish(RunStatus::done);
//
// An error of the thread (disk full) is thrown by the next call and by those after it, by finish()
// only if no other call has; what was recorded before stays readable.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "recording/errors.hpp"
#include "recording/frame.hpp"
#include "recording/run_report.hpp"
#include "scene/scene.hpp"
#include "solver/world.hpp"

namespace salvo::recording {

struct RecorderOptions {
  std::vector<std::string> command_line;  ///< for run.json
  solver::Execution execution;            ///< for run.json
  bool resume = false;     ///< keep intact files that the recomputed state agrees with
  bool overwrite = false;  ///< replace another scene's recording
};

struct RecorderCounters {
  std::uint64_t frames = 0;         ///< recorded, kept ones included
  std::uint64_t kept = 0;           ///< frames found intact and equal when resuming
  std::uint64_t checkpoints = 0;    ///< likewise
  std::uint64_t bytes_written = 0;  ///< by the thread so far
  double seconds_waited = 0;        ///< for the thread, because it was behind by two frames
};

/// One thread calls it.
class Recorder {
 public:
  /// Creates the directory and run.json. Throws OutputError, ForeignRecording.
  Recorder(std::filesystem::path directory, const scene::Scene& scene, RecorderOptions options);
  /// Without finish(): completes what was handed over; run.json keeps saying "running".
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// The first step after `step` at which the scene wants a frame or a checkpoint, or the last
  /// step.
  std::int64_t next_due(std::int64_t step) const;
  /// Records the frame and the checkpoint that are due at the world's step, if any.
  void record_due(const solver::World& world);

  /// Hands a frame to the thread. The world's step is a multiple of the scene's frames.every. Waits
  /// while two are pending.
  void record(const solver::World& world);
  /// Hands a full checkpoint to the thread, at any step; finish(done) removes those that the scene
  /// did not ask for.
  void checkpoint(const solver::World& world);
  /// Returns when all that was handed over is on file.
  void flush();
  /// Completes the recording and run.json. `reason` says why the run failed or was interrupted.
  /// When it throws, calling it again makes run.json say so; a recording that is complete stays as
  /// it is.
  void finish(RunStatus status, const std::string& reason = {});

  RecorderCounters counters() const;
  /// The state recorded last.
  const StateInfo& last() const;
  /// Bytes of the buffers of the recorder, which do not grow with the run.
  std::uint64_t buffer_bytes() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace salvo::recording
