// A file that is truncated, extended or altered in any byte is refused, and no reading of it
// crashes.
#include "recording/sealed_file.hpp"

#include <gtest/gtest.h>

#include <random>

#include "recording/checkpoint.hpp"
#include "recording/frame_reader.hpp"
#include "small_scene.hpp"

namespace salvo::recording {
namespace {

class SealedFile : public testing::Test {
 protected:
  // A checkpoint of few particles: all kinds of HDF5 structures in few bytes.
  void SetUp() override {
    scene::Scene scene = small_scene(20);
    scene.setup.emitters.resize(1);
    solver::World world = small_world(scene);
    Recorder recorder(directory_.path(), scene, {});
    recorder.checkpoint(world);
    recorder.finish(RunStatus::interrupted);
    path_ = directory_ / "checkpoint_000000000.hdf";
    bytes_ = bytes_of(path_);
    ASSERT_NO_THROW(read_checkpoint(path_));
  }
  void put_byte(std::size_t at, char byte) {
    std::fstream file(path_, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(at)).put(byte);
  }
  void expect_refused(const std::string& bytes, const std::string& what) {
    put_bytes(path_, bytes);
    expect_refused(what);
  }
  void expect_refused(const std::string& what) {
    try {
      read_frame(path_);
      ADD_FAILURE() << "read although " << what;
    } catch (const CorruptFile& error) {
      EXPECT_NE(std::string(error.what()).find(path_.string()), std::string::npos) << error.what();
    }
  }

  TemporaryDirectory directory_;
  std::filesystem::path path_;
  std::string bytes_;
};

TEST_F(SealedFile, TruncatedAnywhereIsRefused) {
  for (std::size_t size = bytes_.size(); size-- > 0;) {
    std::filesystem::resize_file(path_, size);
    expect_refused("truncated to " + std::to_string(size));
  }
}

TEST_F(SealedFile, WithAnyByteFlippedIsRefused) {
  std::mt19937 random(11);
  for (std::size_t at = 0; at < bytes_.size(); ++at) {
    put_byte(at, static_cast<char>(bytes_[at] ^ (1 << random() % 8)));
    expect_refused("byte " + std::to_string(at) + " flipped");
    put_byte(at, bytes_[at]);
  }
  EXPECT_NO_THROW(read_frame(path_));
}

TEST_F(SealedFile, ExtendedOrEmptiedOrMissingIsRefused) {
  expect_refused(bytes_ + "\n", "extended");
  expect_refused(bytes_ + bytes_, "doubled");
  expect_refused(std::string(bytes_.size(), '\0'), "zeros");
  std::filesystem::remove(path_);
  EXPECT_THROW(read_frame(path_), CorruptFile);
  std::filesystem::create_directory(path_);
  EXPECT_THROW(read_frame(path_), CorruptFile);
}

TEST_F(SealedFile, ThatIsNoFrameIsRefused) {
  const std::string text = "not HDF5 at all, but sealed";
  write_sealed(path_, std::as_bytes(std::span(text)), Durability::machine);
  EXPECT_NO_THROW(verify_seal(path_));
  EXPECT_THROW(read_frame(path_), CorruptFile);
}

TEST_F(SealedFile, SealIsTheChecksumOfTheBytesBeforeIt) {
  const std::string before = bytes_.substr(0, bytes_.size() - seal_size);
  EXPECT_EQ(bytes_.substr(before.size()),
            "salvo xxh3-128 " + to_string(solver::digest_of(before.data(), before.size())) + "\n");
}

}  // namespace
}  // namespace salvo::recording
