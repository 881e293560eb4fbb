// Exports: every number reads back exactly, whatever the format.
#include "recording/export.hpp"

#include <gtest/gtest.h>

#include <charconv>
#include <cstring>
#include <sstream>

#include "recording/frame_reader.hpp"
#include "small_scene.hpp"

namespace salvo::recording {
namespace {

class Export : public testing::Test {
 protected:
  void SetUp() override {
    scene_ = with_complete_frames(small_scene(311));
    scene_.checkpoint = {0, false};
    record_run(scene_, directory_ / "run");
    frame_ = read_frame(directory_ / "run/frame_000006.hdf");
  }

  scene::Scene scene_;
  TemporaryDirectory directory_;
  Frame frame_;
};

template <class T>
T parsed(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  EXPECT_EQ(error, std::errc()) << text;
  EXPECT_EQ(end, text.data() + text.size()) << text;
  return value;
}

TEST_F(Export, CsvReadsBackExactly) {
  std::vector<std::filesystem::path> paths =
      export_frame(directory_ / "run/frame_000006.hdf", directory_ / "csv", {});
  ASSERT_EQ(paths, std::vector{directory_ / "csv/frame_000006.csv"});
  std::istringstream lines(bytes_of(paths[0]));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(
      line,
      "id,position_x [m],position_y [m],position_z [m],velocity_x [m/s],velocity_y [m/s],"
      "velocity_z [m/s],mass [kg],radius [m],drag_area [m^2],birth [step],death [step],group");
  std::size_t rows = 0;
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    std::string cell;
    for (const FrameColumn& column : frame_.columns) {
      const std::size_t size = size_of(column.scalar, frame_.info.precision);
      for (std::size_t c = 0; c < column.components; ++c) {
        ASSERT_TRUE(std::getline(cells, cell, ','));
        const std::byte* at = column.values.data() + (rows * column.components + c) * size;
        if (column.scalar == soa::Scalar::real) {
          const auto value = parsed<float>(cell);
          ASSERT_EQ(0, std::memcmp(at, &value, size)) << line;
        } else {
          const auto value = parsed<std::int64_t>(cell);
          ASSERT_EQ(0, std::memcmp(at, &value, size)) << line;
        }
      }
    }
    EXPECT_FALSE(std::getline(cells, cell, ','));
    ++rows;
  }
  EXPECT_EQ(rows, frame_.rows);
}

TEST_F(Export, NpyHasTheColumnsBytesAtAMultipleOf64) {
  ExportOptions options;
  options.format = ExportFormat::npy;
  options.columns = {"velocity", "id"};
  const auto paths = export_frame(directory_ / "run/frame_000006.hdf", directory_ / "npy", options);
  ASSERT_EQ(paths.size(), 2u);
  EXPECT_EQ(paths[0].filename(), "frame_000006_velocity.npy");
  const std::string bytes = bytes_of(paths[0]);
  const std::size_t header = 10 + static_cast<unsigned char>(bytes[8]) +
                             256 * static_cast<std::size_t>(static_cast<unsigned char>(bytes[9]));
  EXPECT_EQ(header % 64, 0u);
  EXPECT_EQ(bytes.substr(0, 8), std::string("\x93NUMPY\x01\x00", 8));
  EXPECT_EQ(bytes[header - 1], '\n');
  EXPECT_NE(bytes.find("'<f4'"), std::string::npos);
  EXPECT_NE(bytes.find("(" + std::to_string(frame_.rows) + ", 3)"), std::string::npos);
  const std::vector<std::byte>& values = frame_.columns[2].values;
  ASSERT_EQ(bytes.size(), header + values.size());
  EXPECT_EQ(0, std::memcmp(bytes.data() + header, values.data(), values.size()));
}

TEST_F(Export, PlyHasOneRecordAParticle) {
  ExportOptions options;
  options.format = ExportFormat::ply;
  options.columns = {"id", "position", "group"};
  const auto paths = export_frame(directory_ / "run/frame_000006.hdf", directory_ / "ply", options);
  const std::string bytes = bytes_of(paths.at(0));
  const std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment salvo step 30 time 0.3 s\nelement vertex " +
      std::to_string(frame_.rows) +
      "\nproperty float x\nproperty float y\nproperty float z\nproperty uint id_low\n"
      "property uint id_high\nproperty uint group\nend_header\n";
  ASSERT_EQ(bytes.substr(0, header.size()), header);
  constexpr std::size_t record = 12 + 8 + 4;
  ASSERT_EQ(bytes.size(), header.size() + frame_.rows * record);
  for (std::size_t row = 0; row < frame_.rows; ++row) {
    const char* at = bytes.data() + header.size() + row * record;
    ASSERT_EQ(0, std::memcmp(at, frame_.columns[1].values.data() + row * 12, 12));
    ASSERT_EQ(0, std::memcmp(at + 12, frame_.columns[0].values.data() + row * 8, 8));
    ASSERT_EQ(0, std::memcmp(at + 20, frame_.columns[8].values.data() + row * 4, 4));
  }
  frame_.columns.erase(frame_.columns.begin() + 1);
  EXPECT_THROW(write_ply(frame_, [](std::string_view) {}), std::invalid_argument);
}

TEST_F(Export, OfAllFramesTellsItsProgress) {
  ExportOptions options;
  std::vector<std::uint64_t> done;
  std::uint64_t bytes = 0;
  options.progress = [&](const ExportProgress& progress) {
    done.push_back(progress.frames_done);
    EXPECT_EQ(progress.frames, 13u);
    EXPECT_GT(progress.bytes_written, bytes);
    bytes = progress.bytes_written;
  };
  const auto paths = export_frames(directory_ / "run", directory_ / "csv", options);
  EXPECT_EQ(paths.size(), 13u);
  EXPECT_EQ(done.size(), 13u);
  std::uint64_t on_file = 0;
  for (const auto& path : paths) on_file += std::filesystem::file_size(path);
  EXPECT_EQ(on_file, bytes);
}

TEST_F(Export, RefusesUnknownColumnsAndDamagedFrames) {
  ExportOptions options;
  options.columns = {"positoin"};
  const auto frame = directory_ / "run/frame_000006.hdf";
  try {
    export_frame(frame, directory_ / "csv", options);
    ADD_FAILURE();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("position, velocity"), std::string::npos);
  }
  std::string bytes = bytes_of(frame);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] + 1);
  put_bytes(frame, bytes);
  EXPECT_THROW(export_frame(frame, directory_ / "csv", {}), CorruptFile);
  EXPECT_THROW(export_frames(directory_ / "nowhere", directory_ / "csv", {}), CorruptFile);
  EXPECT_FALSE(std::filesystem::exists(directory_ / "csv"));
}

}  // namespace
}  // namespace salvo::recording
