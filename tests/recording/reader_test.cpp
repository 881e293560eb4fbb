// Other programs' readers: h5py and VTK open the frames and see what the CSV export says.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>

#include "recording/export.hpp"
#include "small_scene.hpp"

namespace salvo::recording {
namespace {

void expect_readable(const scene::Scene& scene) {
  const TemporaryDirectory directory;
  record_run(scene, directory / "run");
  export_frames(directory / "run", directory / "csv", {});
  // Debian's modules belong to this Python; another one may come first on the path.
  const std::string command = std::string("/usr/bin/python3 ") + SALVO_READ_FRAMES + " " +
                              (directory / "run").string() + " " + (directory / "csv").string();
  const int status = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == 77) GTEST_SKIP() << "h5py, NumPy or VTK is missing";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(Readers, SeeTheDefaultColumns) { expect_readable(small_scene()); }

TEST(Readers, SeeAllColumnsInBothPrecisions) {
  expect_readable(with_complete_frames(small_scene(311)));
  expect_readable(with_complete_frames(small_scene(311, soa::Precision::float64)));
}

TEST(Readers, SeeAFraction) {
  scene::Scene scene = small_scene(5000);
  scene.frames.fraction = 0.1;
  expect_readable(scene);
}

TEST(Readers, SeeNoParticles) {
  scene::Scene scene = small_scene();
  for (solver::Emitter& emitter : scene.setup.emitters) emitter.time = 100;
  expect_readable(scene);
}

}  // namespace
}  // namespace salvo::recording
