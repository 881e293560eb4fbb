// The recorder: bounded memory, whose directory it writes into, and what a failure leaves behind.
#include "recording/recorder.hpp"

#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "recording/checkpoint.hpp"
#include "recording/directory.hpp"
#include "recording/frame_reader.hpp"
#include "small_scene.hpp"

namespace salvo::recording {
namespace {

nlohmann::json json_of(const std::filesystem::path& path) {
  return nlohmann::json::parse(bytes_of(path));
}

TEST(Recorder, WritesFramesCheckpointsSeriesAndReport) {
  const scene::Scene scene = small_scene();
  const TemporaryDirectory directory;
  solver::World world = small_world(scene);
  Recorder recorder(directory / "deep/down", scene,
                    {{"salvo", "run", "small.toml"}, {}, false, false});
  EXPECT_EQ(json_of(directory / "deep/down/run.json")["status"], "running");
  run_on(world, recorder, scene, scene.steps);

  std::set<std::string> expected{"run.json", "frames.hdf.series", "checkpoint_000000020.hdf",
                                 "checkpoint_000000040.hdf", "checkpoint_000000060.hdf"};
  for (int frame = 0; frame <= 12; ++frame) expected.insert(frame_name(frame));
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(directory / "deep/down")) {
    names.insert(entry.path().filename().string());
  }
  EXPECT_EQ(names, expected);

  const nlohmann::json series = json_of(directory / "deep/down/frames.hdf.series");
  EXPECT_EQ(series["file-series-version"], "1.0");
  ASSERT_EQ(series["files"].size(), 13u);
  for (int frame = 0; frame <= 12; ++frame) {
    EXPECT_EQ(series["files"][frame]["name"], frame_name(frame));
    EXPECT_EQ(series["files"][frame]["time"].get<double>(), 5 * frame * 0.01);
  }

  const nlohmann::json report = json_of(directory / "deep/down/run.json");
  EXPECT_EQ(report["status"], "done");
  EXPECT_EQ(report["command"], (std::vector<std::string>{"salvo", "run", "small.toml"}));
  EXPECT_EQ(report["scene"]["digest"], to_string(scene_digest(scene)));
  EXPECT_EQ(report["result"]["step"], 60);
  EXPECT_EQ(report["result"]["state_hash"], to_string(world.hash().total));
  EXPECT_EQ(report["timing"]["particle_steps"], world.particle_steps());
  const RecorderCounters counters = recorder.counters();
  EXPECT_EQ(counters.frames, 13u);
  EXPECT_EQ(counters.checkpoints, 3u);
  EXPECT_EQ(counters.kept, 0u);
  std::uint64_t bytes = 0;
  for (const auto& [name, content] : contents_of(directory / "deep/down")) {
    if (name.ends_with(".hdf")) bytes += content.size();
  }
  EXPECT_EQ(counters.bytes_written, bytes);
}

TEST(Recorder, KnowsWhatIsDueNext) {
  scene::Scene scene = small_scene();
  scene.steps = 63;
  scene.checkpoint.every = 12;
  const TemporaryDirectory directory;
  const Recorder recorder(directory.path(), scene, {});
  std::vector<std::int64_t> due;
  for (std::int64_t step = 0; step < scene.steps;) due.push_back(step = recorder.next_due(step));
  EXPECT_EQ(due, (std::vector<std::int64_t>{5, 10, 12, 15, 20, 24, 25, 30, 35, 36, 40, 45, 48, 50,
                                            55, 60, 63}));
  EXPECT_EQ(recorder.next_due(63), 63);
}

TEST(Recorder, TellsTheStateAtTheLastStepEvenWhenNothingIsDueThere) {
  scene::Scene scene = small_scene();
  scene.steps = 63;
  scene.checkpoint = {0, false};
  const TemporaryDirectory directory;
  solver::World world = small_world(scene);
  Recorder recorder(directory.path(), scene, {});
  run_on(world, recorder, scene, scene.steps);
  EXPECT_EQ(recorder.last().step, 63);
  EXPECT_EQ(json_of(directory / "run.json")["result"]["state_hash"], to_string(world.hash().total));
}

// The frames of a long run take the same two buffers; a writer that is slower than the solver makes
// it wait.
TEST(Recorder, MemoryDoesNotGrowWithTheRun) {
  scene::Scene scene = small_scene(50000);
  scene.setup.emitters.resize(1);
  scene.setup.emitters[0].life.reset();
  const TemporaryDirectory directory;
  const solver::World world = small_world(scene);
  Recorder recorder(directory.path(), scene, {});
  for (int i = 0; i < 4; ++i) recorder.record(world);
  recorder.flush();
  const std::uint64_t after_four = recorder.buffer_bytes();
  for (int i = 0; i < 60; ++i) recorder.record(world);
  recorder.flush();
  EXPECT_EQ(recorder.buffer_bytes(), after_four);
  const std::uint64_t frame = 50000 * (8 + 12 + 12);
  EXPECT_LT(after_four, 3 * frame + 100000);
  recorder.finish(RunStatus::done);
}

TEST(Recorder, WithoutFinishCompletesWhatItWasGiven) {
  const scene::Scene scene = small_scene();
  const TemporaryDirectory directory;
  const solver::World world = small_world(scene);
  {
    Recorder recorder(directory.path(), scene, {});
    recorder.record(world);
  }
  EXPECT_EQ(json_of(directory / "run.json")["status"], "running");
  EXPECT_NO_THROW(read_frame(directory / "frame_000000.hdf"));
}

TEST(Recorder, RefusesAnotherScenesDirectoryUnlessToldToOverwrite) {
  const TemporaryDirectory directory;
  scene::Scene scene = small_scene();
  record_run(scene, directory.path());
  put_bytes(directory / "notes.txt", "mine");
  put_bytes(directory / "frame_1.hdf", "mine");
  const auto before = contents_of(directory.path());
  scene.steps = 10;
  scene.text += "# edited\n";
  EXPECT_THROW(Recorder(directory.path(), scene, {}), ForeignRecording);
  EXPECT_EQ(contents_of(directory.path()), before);
  solver::World world = small_world(scene);
  Recorder recorder(directory.path(), scene, {{}, {}, false, true});
  run_on(world, recorder, scene, scene.steps);
  const auto after = contents_of(directory.path());
  EXPECT_EQ(after.size(),
            3u + 1u + 1u + 2u);  // frames, checkpoint, series, what is not a recording's
  EXPECT_EQ(after.at("notes.txt"), "mine");
  EXPECT_EQ(after.at("frame_1.hdf"), "mine");
}

TEST(Recorder, RefusesFilesThatAreNotKnownToBeSalvos) {
  const TemporaryDirectory directory;
  put_bytes(directory / "frame_000003.hdf", "somebody else's");
  EXPECT_THROW(Recorder(directory.path(), small_scene(), {}), ForeignRecording);
  EXPECT_EQ(bytes_of(directory / "frame_000003.hdf"), "somebody else's");
  EXPECT_FALSE(std::filesystem::exists(directory / "run.json"));
}

TEST(Recorder, KnowsItsSceneWithoutRunJson) {
  const TemporaryDirectory directory;
  const scene::Scene scene = small_scene();
  record_run(scene, directory.path());
  const auto before = contents_of(directory.path());
  put_bytes(directory / "run.json", "{ \"damaged\": ");
  record_run(scene, directory.path());
  std::filesystem::remove(directory / "run.json");
  record_run(scene, directory.path());
  EXPECT_EQ(contents_of(directory.path()), before);
}

TEST(Recorder, LetsOneRunAtATimeIntoADirectory) {
  const TemporaryDirectory directory;
  const scene::Scene scene = small_scene();
  Recorder first(directory.path(), scene, {});
  EXPECT_THROW(Recorder(directory.path(), scene, {}), OutputError);
  first.finish(RunStatus::done);
}

TEST(Recorder, RemovesPartsThatAKilledRunLeft) {
  const TemporaryDirectory directory;
  const scene::Scene scene = small_scene();
  record_run(scene, directory.path());
  put_bytes(directory / ".frame_000004.hdf.partial", "part");
  put_bytes(directory / ".notes.partial", "mine");
  record_run(scene, directory.path());
  EXPECT_FALSE(std::filesystem::exists(directory / ".frame_000004.hdf.partial"));
  EXPECT_TRUE(std::filesystem::exists(directory / ".notes.partial"));
}

TEST(Recorder, DirectoryThatCannotBeMadeIsAnOutputError) {
  const TemporaryDirectory directory;
  put_bytes(directory / "file", "");
  EXPECT_THROW(Recorder(directory / "file", small_scene(), {}), OutputError);
  EXPECT_THROW(Recorder(directory / "file/below", small_scene(), {}), OutputError);
  EXPECT_THROW(Recorder("/proc/salvo", small_scene(), {}), OutputError);
}

TEST(Recorder, DirectoryWithoutPermissionIsAnOutputError) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  const TemporaryDirectory directory;
  std::filesystem::create_directory(directory / "closed");
  ASSERT_EQ(::chmod((directory / "closed").c_str(), 0500), 0);
  EXPECT_THROW(Recorder(directory / "closed", small_scene(), {}), OutputError);
}

// Something in the way of a frame: the thread fails, the next call tells, what was there before
// stays.
TEST(Recorder, FailureOfTheThreadIsToldByTheNextCall) {
  const TemporaryDirectory directory;
  const scene::Scene scene = small_scene();
  solver::World world = small_world(scene);
  Recorder recorder(directory.path(), scene, {});
  recorder.record(world);
  recorder.flush();
  std::filesystem::create_directories(directory / "frame_000001.hdf/in the way");
  world.advance_to(5);
  recorder.record(world);
  EXPECT_THROW(recorder.flush(), OutputError);
  EXPECT_THROW(recorder.record(world), OutputError);
  recorder.finish(RunStatus::failed, "because");
  EXPECT_EQ(json_of(directory / "run.json")["status"], "failed");
  EXPECT_EQ(json_of(directory / "run.json")["reason"], "because");
  EXPECT_NO_THROW(read_frame(directory / "frame_000000.hdf"));
  EXPECT_EQ(json_of(directory / "frames.hdf.series")["files"].size(), 1u);
}

TEST(Recorder, FailureThatNoCallToldIsToldByFinish) {
  const TemporaryDirectory directory;
  const scene::Scene scene = small_scene();
  const solver::World world = small_world(scene);
  std::filesystem::create_directories(directory / "frame_000000.hdf/in the way");
  Recorder recorder(directory.path(), scene, {});
  recorder.record(world);
  EXPECT_THROW(recorder.finish(RunStatus::done), OutputError);
  EXPECT_EQ(json_of(directory / "run.json")["status"], "failed");
}

TEST(Recorder, IsFinishedOnce) {
  const TemporaryDirectory directory;
  const scene::Scene scene = small_scene();
  solver::World world = small_world(scene);
  Recorder recorder(directory.path(), scene, {});
  run_on(world, recorder, scene, scene.steps);
  recorder.finish(RunStatus::failed, "after all");
  EXPECT_EQ(json_of(directory / "run.json")["status"], "done");
}

// The report is in the way, then no more.
TEST(Recorder, FinishedAgainSaysWhatItCouldNotSayBefore) {
  const TemporaryDirectory directory;
  const scene::Scene scene = small_scene();
  const solver::World world = small_world(scene);
  Recorder recorder(directory.path(), scene, {});
  recorder.record(world);
  std::filesystem::create_directories(directory / ".run.json.partial/in the way");
  EXPECT_THROW(recorder.finish(RunStatus::done), OutputError);
  EXPECT_EQ(json_of(directory / "run.json")["status"], "running");
  std::filesystem::remove_all(directory / ".run.json.partial");
  recorder.finish(RunStatus::failed, "because");
  EXPECT_EQ(json_of(directory / "run.json")["reason"], "because");
}

// Of many frames a second; the index of the frames is whole when anybody is told that they are.
TEST(Recorder, ListsTheFramesNowAndThenAndWhenFlushed) {
  const TemporaryDirectory directory;
  const scene::Scene scene = small_scene();
  solver::World world = small_world(scene);
  const auto listed = [&] { return json_of(directory / "frames.hdf.series")["files"].size(); };
  Recorder recorder(directory.path(), scene, {});
  recorder.record(world);
  recorder.flush();
  for (std::size_t frame = 1; frame <= 6; ++frame) {
    world.advance_to(static_cast<std::int64_t>(5 * frame));
    recorder.record(world);
    if (frame % 3 != 0) continue;
    recorder.flush();
    EXPECT_EQ(listed(), frame + 1);
  }
}

TEST(Recorder, ResumedWhenAllIsRecordedListsTheFramesAgain) {
  const TemporaryDirectory directory;
  scene::Scene scene = small_scene();
  scene.steps = 63;  // no frame is due at the end
  record_run(scene, directory.path());
  const auto before = contents_of(directory.path());
  std::filesystem::remove(directory / "frames.hdf.series");
  solver::World world = small_world(scene);
  auto state = resume_point(directory.path(), scene);
  ASSERT_TRUE(state);
  ASSERT_EQ(state->step, 63);
  std::move(*state).restore(world);
  Recorder recorder(directory.path(), scene, {{}, {}, true, false});
  run_on(world, recorder, scene, scene.steps);
  EXPECT_EQ(contents_of(directory.path()), before);
}

TEST(Recorder, ErrorsKnowWhetherThereIsRoom) {
  EXPECT_TRUE(OutputError("full", ENOSPC).no_room());
  EXPECT_FALSE(OutputError("closed", EACCES).no_room());
  EXPECT_FALSE(OutputError("unknown").no_room());
}

TEST(Recorder, FullDiskIsAnOutputErrorAndKeepsWhatIsThere) {
  const TemporaryDirectory directory;
  const std::filesystem::path disk = directory / "disk";
  std::filesystem::create_directory(disk);
  if (::mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=300k") != 0) {
    GTEST_SKIP() << "needs the right to mount a small disk";
  }
  const scene::Scene scene = small_scene();
  {
    solver::World world = small_world(scene);
    Recorder recorder(disk, scene, {});
    std::string message;
    try {
      run_on(world, recorder, scene, scene.steps);
      ADD_FAILURE() << "the disk was large enough";
    } catch (const OutputError& error) {
      message = error.what();
      recorder.finish(RunStatus::failed, message);
    }
    EXPECT_NE(message.find("No space left on device"), std::string::npos) << message;
    const std::vector<NumberedFile> frames = list_frames(disk);
    EXPECT_GT(frames.size(), 1u);
    EXPECT_LT(frames.size(), 13u);
    for (const NumberedFile& frame : frames) EXPECT_NO_THROW(read_frame(frame.path));
    for (const auto& [name, bytes] : contents_of(disk)) EXPECT_FALSE(name.starts_with(".")) << name;
    EXPECT_LE(json_of(disk / "frames.hdf.series")["files"].size(), frames.size());
  }
  // With more room the run goes on and the recording is whole.
  ASSERT_EQ(::mount("tmpfs", disk.c_str(), "tmpfs", MS_REMOUNT, "size=10m"), 0);
  {
    solver::World world = small_world(scene);
    if (auto state = resume_point(disk, scene)) std::move(*state).restore(world);
    Recorder recorder(disk, scene, {{}, {}, true, false});
    run_on(world, recorder, scene, scene.steps);
  }
  record_run(scene, directory / "whole");
  expect_equal_contents(disk, directory / "whole");
  ::umount(disk.c_str());
}

}  // namespace
}  // namespace salvo::recording
