// Resuming: whatever was lost or damaged, the directory ends up as that of an uninterrupted run,
// byte for byte.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <thread>

#include "recording/checkpoint.hpp"
#include "recording/directory.hpp"
#include "recording/frame_reader.hpp"
#include "small_scene.hpp"

namespace salvo::recording {
namespace {

struct Resumed {
  std::int64_t from = 0;
  std::vector<std::string> messages;
  RecorderCounters counters;
};

// As the command does.
Resumed resume(const scene::Scene& scene, const std::filesystem::path& directory,
               std::int64_t last_step = std::numeric_limits<std::int64_t>::max()) {
  Resumed resumed;
  solver::World world = small_world(scene);
  auto state = resume_point(directory, scene, last_step, [&](const std::string& message) {
    resumed.messages.push_back(message);
  });
  if (state) std::move(*state).restore(world);
  resumed.from = world.step();
  Recorder recorder(directory, scene, {{}, {}, true, false});
  run_on(world, recorder, scene, scene.steps);
  resumed.counters = recorder.counters();
  return resumed;
}

void damage(const std::filesystem::path& path) {
  std::string bytes = bytes_of(path);
  bytes[bytes.size() / 3] = static_cast<char>(bytes[bytes.size() / 3] ^ 4);
  put_bytes(path, bytes);
}

class Resume : public testing::Test {
 protected:
  void SetUp() override { record_run(scene_, directory_ / "whole"); }
  std::filesystem::path interrupted() {
    std::filesystem::copy(directory_ / "whole", directory_ / "again");
    return directory_ / "again";
  }
  void expect_whole() { expect_equal_contents(directory_ / "again", directory_ / "whole"); }

  scene::Scene scene_ = small_scene();
  TemporaryDirectory directory_;
};

// What the contacts remember is in the checkpoints, too.
TEST(ResumeOfContacts, AfterAnInterruptionEndsUpTheSame) {
  scene::Scene scene = small_scene(300);
  models::ContactLaw law;
  law.normal_stiffness = 40;  // N/m: an impact of some thirty steps
  law.friction = 0.5;
  law.rolling_friction = 0.2;
  scene.setup.contact_law = law;
  scene.setup.integrator = solver::IntegratorKind::semi_implicit_euler;
  models::Obstacle floor;
  floor.center = {0, -0.5, 0};
  floor.friction = 0.3;
  scene.setup.obstacles = {floor};
  for (solver::Emitter& emitter : scene.setup.emitters) {
    emitter.radius.a = 0.2;
    emitter.source_radius = 2;
  }
  const TemporaryDirectory directory;
  record_run(scene, directory / "whole");
  std::filesystem::copy(directory / "whole", directory / "again");
  for (const int frame : {5, 6, 7, 8, 9, 10, 11, 12}) {
    std::filesystem::remove(directory / "again" / frame_name(frame));
  }
  const Resumed resumed = resume(scene, directory / "again");
  EXPECT_EQ(resumed.from, 20);
  expect_equal_contents(directory / "again", directory / "whole");
  EXPECT_GT(read_checkpoint(directory / "whole" / checkpoint_name(20)).contacts->rows(), 20U);
}

TEST_F(Resume, AfterAnInterruptionAtAnyFrameEndsUpTheSame) {
  for (std::int64_t stop = 0; stop <= 60; stop += 5) {
    const std::filesystem::path again = directory_ / "again";
    {
      solver::World world = small_world(scene_);
      Recorder recorder(again, scene_, {});
      recorder.record_due(world);
      while (world.step() < stop) {
        world.advance_to(recorder.next_due(world.step()));
        recorder.record_due(world);
      }
      recorder.checkpoint(world);  // as Ctrl-C does
      recorder.finish(RunStatus::interrupted);
    }
    EXPECT_EQ(resume(scene_, again).from, stop);
    expect_whole();
    std::filesystem::remove_all(again);
  }
}

TEST_F(Resume, OfAWholeRecordingChangesNothing) {
  const auto again = interrupted();
  const Resumed resumed = resume(scene_, again);
  EXPECT_EQ(resumed.from, 60);
  EXPECT_EQ(resumed.counters.kept, 2u);  // the frame and the checkpoint at the end
  EXPECT_EQ(resumed.counters.bytes_written, 0u);
  EXPECT_TRUE(resumed.messages.empty());
  expect_whole();
}

TEST_F(Resume, OfAnEmptyOrMissingDirectoryStartsAtTheBeginning) {
  EXPECT_EQ(resume(scene_, directory_ / "again").from, 0);
  expect_whole();
}

TEST_F(Resume, RecomputesFromBeforeADamagedFrame) {
  const auto again = interrupted();
  damage(again / "frame_000006.hdf");  // step 30
  const Resumed resumed = resume(scene_, again);
  EXPECT_EQ(resumed.from, 20);
  ASSERT_EQ(resumed.messages.size(), 1u);
  EXPECT_NE(resumed.messages[0].find("frame_000006.hdf"), std::string::npos);
  EXPECT_EQ(resumed.counters.kept, 9u + 3u - 1u);
  expect_whole();
}

TEST_F(Resume, RecomputesFromBeforeAMissingFrame) {
  const auto again = interrupted();
  std::filesystem::remove(again / "frame_000009.hdf");  // step 45
  EXPECT_EQ(resume(scene_, again).from, 40);
  expect_whole();
}

TEST_F(Resume, SkipsADamagedCheckpoint) {
  const auto again = interrupted();
  damage(again / "checkpoint_000000060.hdf");
  EXPECT_EQ(*latest_checkpoint(again), again / "checkpoint_000000040.hdf");
  damage(again / "checkpoint_000000040.hdf");
  std::vector<std::string> messages;
  const auto latest =
      latest_checkpoint(again, [&](const std::string& message) { messages.push_back(message); });
  EXPECT_EQ(*latest, again / "checkpoint_000000020.hdf");
  EXPECT_EQ(messages.size(), 2u);
  const Resumed resumed = resume(scene_, again);
  EXPECT_EQ(resumed.from, 20);
  expect_whole();
}

TEST_F(Resume, WithoutCheckpointsStartsAtTheBeginning) {
  const auto again = interrupted();
  for (const NumberedFile& file : list_checkpoints(again)) std::filesystem::remove(file.path);
  EXPECT_FALSE(latest_checkpoint(again));
  EXPECT_EQ(resume(scene_, again).from, 0);
  expect_whole();
}

TEST_F(Resume, FromAnEarlierStepAgreesWithAllThatIsThere) {
  const auto again = interrupted();
  const Resumed resumed = resume(scene_, again, 33);
  EXPECT_EQ(resumed.from, 20);
  EXPECT_EQ(resumed.counters.bytes_written, 0u);
  expect_whole();
}

TEST_F(Resume, FromACompleteFrame) {
  const scene::Scene scene = with_complete_frames(scene_);
  record_run(scene, directory_ / "complete");
  std::filesystem::copy(directory_ / "complete", directory_ / "cut");
  const std::filesystem::path cut = directory_ / "cut";
  for (const NumberedFile& file : list_checkpoints(cut)) std::filesystem::remove(file.path);
  for (int frame = 8; frame <= 12; ++frame) std::filesystem::remove(cut / frame_name(frame));
  const auto state = resume_point(cut, scene);
  ASSERT_TRUE(state);
  EXPECT_EQ(state->step, 35);
  EXPECT_EQ(read_checkpoint(cut / "frame_000002.hdf").step, 10);
  // Checkpoints that were removed before the state are not asked for again; those after it are.
  resume(scene, cut);
  std::filesystem::remove(directory_ / "complete/checkpoint_000000020.hdf");
  expect_equal_contents(cut, directory_ / "complete");
}

TEST_F(Resume, RefusesAnotherScenesRecording) {
  const auto again = interrupted();
  scene::Scene scene = scene_;
  scene.overrides = {"seed=8"};
  EXPECT_THROW(resume_point(again, scene), ForeignRecording);
}

TEST_F(Resume, RefusesAFrameThatTheRecomputedStateContradicts) {
  const auto again = interrupted();
  scene::Scene scene = scene_;
  scene.setup.seed = 8;  // and the same text, as if the solver had changed
  solver::World world = small_world(scene);
  Recorder recorder(again, scene, {{}, {}, true, false});
  recorder.record(world);
  try {
    recorder.finish(RunStatus::done);
    ADD_FAILURE() << "the contradiction was not seen";
  } catch (const StateMismatch& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("frame_000000.hdf"), std::string::npos) << message;
    EXPECT_NE(message.find("velocity"), std::string::npos) << message;
    EXPECT_EQ(message.find("position"), std::string::npos) << message;
  }
  EXPECT_TRUE(bytes_of(again / "frame_000000.hdf") ==
              bytes_of(directory_ / "whole/frame_000000.hdf"));
}

// A process that records is killed after more and more time; every file under its name is whole,
// and the run goes on.
TEST_F(Resume, AfterKillMinusNineEndsUpTheSame) {
  const std::filesystem::path again = directory_ / "again";
  bool finished = false;
  int kills = 0;
  for (int milliseconds = 1; !finished && kills < 200; milliseconds += 1 + milliseconds / 8) {
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      solver::Execution execution;
      execution.threads = 1;  // the threads of the parent are not in the child
      solver::World world(scene_.setup, execution);
      Recorder recorder(again, scene_, {});
      run_on(world, recorder, scene_, scene_.steps);
      ::_exit(0);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
    ::kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    finished = WIFEXITED(status);
    for (const NumberedFile& file : list_frames(again)) EXPECT_NO_THROW(read_frame(file.path));
    for (const NumberedFile& file : list_checkpoints(again)) {
      EXPECT_NO_THROW(read_checkpoint(file.path));
    }
    if (finished) break;
    ++kills;
    resume(scene_, again);
    expect_whole();
    std::filesystem::remove_all(again);
  }
  EXPECT_TRUE(finished);
  EXPECT_GT(kills, 3);
}

}  // namespace
}  // namespace salvo::recording
