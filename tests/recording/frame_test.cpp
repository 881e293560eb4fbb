// Frames: what is read back is what was written, and equal runs give equal bytes.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <thread>

#include "recording/checkpoint.hpp"
#include "recording/directory.hpp"
#include "recording/frame_reader.hpp"
#include "recording/frame_writer.hpp"
#include "recording/sealed_file.hpp"
#include "small_scene.hpp"

namespace salvo::recording {
namespace {

const FrameColumn& column(const Frame& frame, std::string_view name) {
  for (const FrameColumn& column : frame.columns) {
    if (column.name == name) return column;
  }
  throw std::runtime_error("no column " + std::string(name));
}

template <class T>
T value(const FrameColumn& column, std::size_t row, std::size_t component = 0) {
  T value;
  const std::size_t at = (row * column.components + component) * sizeof(T);
  std::memcpy(&value, column.values.data() + at, sizeof(T));
  return value;
}

class FrameOf : public testing::TestWithParam<soa::Precision> {};

template <class T>
void expect_columns_equal(const Frame& frame, const soa::Table& table) {
  ASSERT_EQ(frame.rows, table.rows());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    ASSERT_EQ(value<soa::Id>(column(frame, "id"), row), table.ids()[row]);
    for (std::size_t c = 0; c < 3; ++c) {
      ASSERT_EQ(value<T>(column(frame, "position"), row, c), table.column<T>(1, c)[row]);
      ASSERT_EQ(value<T>(column(frame, "velocity"), row, c), table.column<T>(2, c)[row]);
    }
    ASSERT_EQ(value<T>(column(frame, "mass"), row), table.column<T>(3)[row]);
    // Uniform fields read as if every particle had its own.
    ASSERT_EQ(value<T>(column(frame, "radius"), row), T{0.25});
    ASSERT_EQ(value<std::int32_t>(column(frame, "birth"), row), table.column<std::int32_t>(6)[row]);
    ASSERT_EQ(value<std::uint32_t>(column(frame, "group"), row),
              table.column<std::uint32_t>(8)[row]);
  }
}

TEST_P(FrameOf, AllFieldsIsReadBackExactly) {
  const scene::Scene scene = with_complete_frames(small_scene(1237, GetParam()));
  const TemporaryDirectory directory;
  solver::World world = small_world(scene);
  Recorder recorder(directory.path(), scene, {});
  world.advance_to(35);
  recorder.record(world);
  recorder.flush();

  const Frame frame = read_frame(directory / "frame_000007.hdf");
  if (GetParam() == soa::Precision::float32) {
    expect_columns_equal<float>(frame, world.particles());
  } else {
    expect_columns_equal<double>(frame, world.particles());
  }
  // Those of contacts are of scenes with contacts.
  std::size_t fields = 0;
  while (!soa::only_of_contacts(fields)) ++fields;
  ASSERT_EQ(frame.columns.size(), fields);
  for (std::size_t f = 0; f < frame.columns.size(); ++f) {
    EXPECT_EQ(frame.columns[f].name, soa::particle_fields[f].name);
    EXPECT_EQ(frame.columns[f].unit, soa::particle_fields[f].unit);
    EXPECT_EQ(frame.columns[f].meaning, soa::particle_fields[f].meaning);
  }
  const FrameInfo& info = frame.info;
  EXPECT_EQ(info.step, 35);
  EXPECT_EQ(info.time, world.time());
  EXPECT_EQ(info.seed, 7u);
  EXPECT_EQ(info.precision, GetParam());
  EXPECT_TRUE(info.complete);
  EXPECT_EQ(info.scene_text, scene.text);
  EXPECT_EQ(info.overrides, scene.overrides);
  EXPECT_EQ(info.scene_digest, scene_digest(scene));
  EXPECT_EQ(info.contract, scene::contract_version);
  EXPECT_FALSE(info.version.empty());
  EXPECT_EQ(info.state_hash, world.hash().total);
  EXPECT_EQ(info.field_digests.size(), world.hash().fields.size());
  EXPECT_EQ(info.diagnostics.count, world.particles().rows());
  EXPECT_EQ(info.diagnostics.kinetic_energy, world.diagnose().kinetic_energy);
  EXPECT_EQ(info.diagnostics.momentum, world.diagnose().momentum);
}

INSTANTIATE_TEST_SUITE_P(Precisions, FrameOf,
                         testing::Values(soa::Precision::float32, soa::Precision::float64),
                         [](const auto& parameter) {
                           return parameter.param == soa::Precision::float32 ? "Float32"
                                                                             : "Float64";
                         });

TEST(Frame, HoldsOnlyTheChosenColumns) {
  scene::Scene scene = small_scene();
  scene.frames.columns = {soa::ParticleField::velocity, soa::ParticleField::velocity};
  const TemporaryDirectory directory;
  record_run(scene, directory.path());
  const Frame frame = read_frame(directory / "frame_000012.hdf");
  ASSERT_EQ(frame.columns.size(), 1u);
  EXPECT_EQ(frame.columns[0].name, "velocity");
  EXPECT_FALSE(frame.info.complete);
}

TEST(Frame, KeepsTheSameFractionOfParticlesInEveryFrame) {
  scene::Scene scene = small_scene(40000);
  scene.frames.fraction = 0.05;
  const TemporaryDirectory directory;
  record_run(scene, directory.path());
  const solver::World world = small_world(scene);
  std::set<soa::Id> expected;
  for (std::size_t row = 0; row < 40000; ++row) {
    const soa::Id id = world.particles().ids()[row];
    if (static_cast<double>(hash_of_id(id)) < 0.05 * std::ldexp(1.0, 64)) expected.insert(id);
  }
  EXPECT_NEAR(static_cast<double>(expected.size()), 2000, 5 * std::sqrt(2000.0));
  const Frame first = read_frame(directory / "frame_000000.hdf");
  EXPECT_EQ(first.rows, expected.size());
  EXPECT_FALSE(first.info.complete);
  EXPECT_EQ(first.info.fraction, 0.05);
  for (std::size_t row = 0; row < first.rows; ++row) {
    EXPECT_TRUE(expected.count(value<soa::Id>(column(first, "id"), row)));
  }
  // Later frames have deaths and the jet's particles, none of the burst that was not there before.
  const Frame last = read_frame(directory / "frame_000012.hdf");
  for (std::size_t row = 0; row < last.rows; ++row) {
    const auto id = value<soa::Id>(column(last, "id"), row);
    EXPECT_TRUE(soa::stream_of(id) != 1 || expected.count(id));
  }
}

TEST(Selection, OfALargerFractionHoldsThatOfASmallerOne) {
  EXPECT_EQ(hash_of_id(0), 0xe220a8397b1dcdafu);  // SplitMix64's first output for the seed 0
  for (soa::Id id = 0; id < 3000; ++id) {
    EXPECT_TRUE(Selection(1).keeps(id));
    EXPECT_FALSE(Selection(0).keeps(id));
    EXPECT_TRUE(!Selection(0.3).keeps(id) || Selection(0.7).keeps(id));
  }
}

TEST(Frame, OfNoParticlesIsReadBack) {
  scene::Scene scene = small_scene();
  scene.setup.emitters[0].time = 100;
  scene.setup.emitters[1].time = 100;
  const TemporaryDirectory directory;
  record_run(scene, directory.path());
  const Frame frame = read_frame(directory / "frame_000003.hdf");
  EXPECT_EQ(frame.rows, 0u);
  EXPECT_TRUE(std::isnan(frame.info.diagnostics.lowest[0]));
}

// Attributes of more than 64 KiB are stored in another way.
TEST(Frame, KeepsALongSceneText) {
  scene::Scene scene = small_scene();
  for (int i = 0; i < 20000; ++i) scene.text += "# line " + std::to_string(i) + " of many\n";
  scene.overrides.clear();
  const TemporaryDirectory directory;
  record_run(scene, directory.path());
  const FrameInfo info = read_frame_info(directory / "frame_000000.hdf");
  EXPECT_EQ(info.scene_text, scene.text);
  EXPECT_TRUE(info.overrides.empty());
}

TEST(Frame, FilesOfEqualRunsAreEqualWhateverTheExecution) {
  for (const double fraction : {1.0, 0.3}) {
    scene::Scene scene = small_scene(9001);
    scene.frames.fraction = fraction;
    const TemporaryDirectory one;
    const TemporaryDirectory other;
    record_run(scene, one.path());
    std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // time stamps count seconds
    solver::Execution execution;
    execution.isa = solver::Isa::scalar;
    execution.threads = 5;
    execution.pass_steps = 3;
    solver::World world(scene.setup, execution);
    scene.path = "elsewhere/small.toml";  // where the file lies is not part of the scene
    Recorder recorder(other.path(), scene, {{"salvo", "run"}, execution, false, false});
    run_on(world, recorder, scene, scene.steps);
    expect_equal_contents(one.path(), other.path());
    EXPECT_EQ(contents_of(one.path()).size(), 13u + 3u + 1u);
  }
}

// A block of connectivity is made once and used again; the number of points differs from frame to
// frame.
TEST(Frame, ConnectivityCountsThePointsAroundTheBlockSize) {
  const scene::Scene scene = small_scene();
  FrameWriter reused(scene);
  for (const std::size_t rows : {1u, 65535u, 65536u, 65537u, 200001u, 3u, 131072u, 0u, 7u}) {
    std::vector<std::byte> zeros(rows * sizeof(double));
    Rows content;
    content.count = rows;
    content.stored.assign(soa::particle_fields.size(), true);
    content.uniform.assign(soa::particle_fields.size(), 0);
    FieldRows position;
    position.field = 1;
    position.components = {zeros.data(), zeros.data(), zeros.data()};
    content.fields = {position};
    const hdf5::Session session;
    hdf5::MemoryFile file = reused.compose({}, content, 1);
    std::vector<std::int32_t> numbers(rows);
    const hdf5::Handle dataset = hdf5::open_dataset(file, "/VTKHDF/Connectivity");
    ASSERT_EQ(hdf5::extents_of(dataset), hdf5::Extents{rows});
    if (rows != 0) hdf5::read_all(dataset, hdf5::type_of<std::int32_t>(), numbers.data());
    for (std::size_t i = 0; i < rows; ++i) ASSERT_EQ(numbers[i], static_cast<std::int32_t>(i));

    FrameWriter fresh(scene);
    hdf5::MemoryFile again = fresh.compose({}, content, 1);
    EXPECT_TRUE(std::ranges::equal(file.bytes(), again.bytes())) << rows;
  }
}

TEST(Checkpoint, IsReadBackWithEveryBit) {
  for (const auto precision : {soa::Precision::float32, soa::Precision::float64}) {
    const scene::Scene scene = small_scene(1237, precision);
    const TemporaryDirectory directory;
    record_run(scene, directory.path());
    solver::World world = small_world(scene);
    world.advance_to(40);
    const CheckpointData data = read_checkpoint(directory / "checkpoint_000000040.hdf");
    EXPECT_EQ(data.step, 40);
    EXPECT_EQ(data.hash.total, world.hash().total);
    EXPECT_EQ(data.tally.impacts, world.tally().impacts);
    EXPECT_EQ(data.removed, world.removed());
    const soa::Table& table = world.particles();
    ASSERT_EQ(data.particles.rows(), table.rows());
    for (std::size_t f = 0; f < table.fields().size(); ++f) {
      ASSERT_EQ(data.particles.stored(f), table.stored(f));
      if (!table.stored(f)) {
        EXPECT_EQ(data.particles.uniform(f), table.uniform(f));
        continue;
      }
      for (std::size_t c = 0; c < table.fields()[f].components; ++c) {
        EXPECT_EQ(0, std::memcmp(data.particles.bytes(f, c), table.bytes(f, c),
                                 table.rows() * size_of(table.fields()[f].scalar, precision)));
      }
    }
  }
}

TEST(Checkpoint, IsNotReadFromAFrameThatHoldsLess) {
  const TemporaryDirectory directory;
  record_run(small_scene(), directory.path());
  EXPECT_THROW(read_checkpoint(directory / "frame_000004.hdf"), RecordingError);
}

// Sealed again after the change, so that only the state hash can tell.
TEST(Checkpoint, WhoseStateHasAnotherHashIsRefused) {
  const TemporaryDirectory directory;
  const scene::Scene scene = small_scene();
  record_run(scene, directory.path());
  const std::filesystem::path path = directory / "checkpoint_000000020.hdf";
  std::string bytes = bytes_of(path);
  solver::World world = small_world(scene);
  world.advance_to(20);
  const float mass = world.particles().column<float>(3)[500];
  const std::string pattern(reinterpret_cast<const char*>(world.particles().bytes(3, 0)), 400);
  const std::size_t at = bytes.find(pattern);
  ASSERT_NE(at, std::string::npos) << mass;
  bytes[at + 17] = static_cast<char>(bytes[at + 17] ^ 1);
  bytes.resize(bytes.size() - seal_size);
  write_sealed(path, std::as_bytes(std::span(bytes)), Durability::process);
  EXPECT_NO_THROW(read_frame_info(path));
  try {
    read_checkpoint(path);
    ADD_FAILURE() << "the altered checkpoint was read";
  } catch (const CorruptFile& error) {
    EXPECT_NE(std::string(error.what()).find("hash"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace salvo::recording
