// Inputs of a sweep from an HDF5 file: values, units and the message of every mistake.
#include "recording/hdf5_table.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "recording/hdf5.hpp"
#include "recording/sealed_file.hpp"
#include "recording/sweep_recording.hpp"
#include "scene/load_sweep.hpp"
#include "small_scene.hpp"

namespace salvo::recording {
namespace {

using hdf5::Handle;

class Hdf5Table : public testing::Test {
 protected:
  Hdf5Table() { scene::open_hdf5_tables_with(&open_hdf5_table); }
  ~Hdf5Table() override { scene::open_hdf5_tables_with(nullptr); }

  // A file of the datasets that `fill` makes.
  template <class Fill>
  void with(Fill fill) const {
    const hdf5::Session session;
    hdf5::MemoryFile file;
    fill(hid_t{file});
    const auto bytes = file.bytes();
    put_bytes(table_, std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  }
  static Handle put(hid_t parent, const std::string& name, const std::vector<double>& values) {
    hdf5::write_dataset<double>(parent, name, values);
    return hdf5::open_dataset(parent, name);
  }
  void with_two(const std::vector<double>& v, const std::vector<double>& height,
                const char* units = nullptr) const {
    with([&](hid_t file) {
      const Handle dataset = put(file, "v", v);
      if (units != nullptr) hdf5::write_attribute(dataset, "units", std::string_view(units));
      const Handle group = hdf5::create_group(file, "end");
      put(group, "height", height);
    });
  }
  scene::SweepScene load(const std::string& speed = "v", const std::string& file = "inputs.hdf") {
    return scene::parse_sweep(
        "[projectile]\nspeed = { column = \"" + speed +
            "\" }\naltitude = { column = \"end/height\" }\n[sweep]\ntable = \"" + file +
            "\"\n[integration]\nstep = 0.01\ntime_limit = 1\n",
        (directory_ / "scene.toml").string());
  }
  static const std::vector<double>& values(const scene::SweepScene& scene, std::string_view name) {
    const auto fields = scene.model->kernels(solver::Isa::scalar).input_fields;
    std::size_t i = 0;
    while (fields[i].name != name) ++i;
    return scene.setup.inputs[i].values;
  }
  void expect_mistake(const std::string& problem, const std::string& hint,
                      const std::string& speed = "v", const std::string& file = "inputs.hdf") {
    try {
      load(speed, file);
      ADD_FAILURE() << "no mistake, expected " << problem;
    } catch (const scene::SceneError& error) {
      const std::string text = error.what();
      EXPECT_NE(text.find((directory_ / file).string()), std::string::npos) << text;
      EXPECT_NE(text.find(problem), std::string::npos) << text;
      EXPECT_NE(text.find(hint), std::string::npos) << text;
    }
  }

  TemporaryDirectory directory_;
  std::filesystem::path table_ = directory_ / "inputs.hdf";
};

TEST_F(Hdf5Table, ColumnsAreReadByTheirPaths) {
  with_two({1000, 2000.5}, {5, 6});
  for (const char* name : {"v", "/v"}) {
    const scene::SweepScene scene = load(name);
    EXPECT_EQ(values(scene, "speed"), (std::vector<double>{1000, 2000.5}));
    EXPECT_EQ(values(scene, "altitude"), (std::vector<double>{5, 6}));
  }
}

// 1000.1 fps is 304.83048 m/s to the last bit only when 1000.1 is taken as the decimal number.
TEST_F(Hdf5Table, UnitsAreConvertedAsThoseOfACsvFile) {
  with_two({1000.1, 2000}, {5, 6}, "fps");
  put_bytes(directory_ / "inputs.csv", "v [fps],end/height\n1000.1,5\n2000,6\n");
  EXPECT_EQ(values(load(), "speed"), (std::vector<double>{304.83048, 609.6}));
  EXPECT_EQ(values(load("v", "inputs.csv"), "speed"), values(load(), "speed"));
  for (const char* none : {"", "m/s", "m/s  "}) {
    with_two({1000.1, 2000}, {5, 6}, none);
    EXPECT_EQ(values(load(), "speed"), (std::vector<double>{1000.1, 2000})) << none;
  }
}

TEST_F(Hdf5Table, TypesLayoutsAndTextsOfOtherProgramsAreRead) {
  with([](hid_t file) {
    hdf5::write_dataset<std::int32_t>(file, "v", std::array{100, 200, 300});
    const Handle dataset = hdf5::open_dataset(file, "v");
    const Handle text(H5Tcopy(H5T_C_S1), "create a string type");
    H5Tset_size(text, H5T_VARIABLE);
    const char* units = "km/h";
    hdf5::write_attribute(dataset, "units", text, {}, &units);
    const Handle group = hdf5::create_group(file, "end");
    const float constant = 0.5F;
    hdf5::create_constant_dataset(group, "height", hdf5::type_of<float>(), {3}, &constant);
  });
  const scene::SweepScene scene = load();
  EXPECT_EQ(values(scene, "speed"), (std::vector<double>{100 / 3.6, 200 / 3.6, 300 / 3.6}));
  EXPECT_EQ(values(scene, "altitude"), (std::vector<double>{0.5, 0.5, 0.5}));
}

TEST_F(Hdf5Table, AFileThatIsNoneIsNamed) {
  expect_mistake("cannot read", "No such file");
  put_bytes(table_, "v,height\n1,2\n");
  expect_mistake("is not an HDF5 file", "a CSV file has another ending");
  with_two({1}, {2});
  put_bytes(table_, bytes_of(table_).substr(0, 600));
  expect_mistake("cannot read", "expected a complete HDF5 file");
}

TEST_F(Hdf5Table, AColumnThatIsNoneIsNamed) {
  with([](hid_t file) {
    put(file, "speeds", {1, 2});
    hdf5::write_dataset<std::int32_t>(file, "x", std::array{1, 2});
    hdf5::create_dataset(file, "matrix", hdf5::type_of<double>(), {2, 2});
    hdf5::create_dataset(file, "number", hdf5::type_of<double>(), {});
    hdf5::create_dataset(file, "empty", hdf5::type_of<double>(), {0});
    hdf5::create_dataset(file, "text", H5T_C_S1, {2});
    hdf5::create_soft_link(file, "nowhere", "/missing");
    const Handle group = hdf5::create_group(file, "end");
    put(group, "height", {1, 2});
    const Handle odd = put(file, "odd", {1, 2});
    hdf5::write_attribute(odd, "units", 1.0);
  });
  expect_mistake("has no dataset \"speed\"", "did you mean \"speeds\"?", "speed");
  expect_mistake("has no dataset \"end.height\"", "did you mean \"end/height\"?", "end.height");
  expect_mistake("has no dataset \"end\"", "it has empty, end/height", "end");
  expect_mistake("has no dataset \"nowhere\"", "it has empty, end/height, odd, speeds, x",
                 "nowhere");
  expect_mistake("dataset \"matrix\" has 2 dimensions", "expected one", "matrix");
  expect_mistake("dataset \"number\" has 0 dimensions", "expected one", "number");
  expect_mistake("dataset \"empty\" has no rows", "a number for each row", "empty");
  expect_mistake("dataset \"text\" does not hold numbers", "expected integers", "text");
  expect_mistake("has an attribute \"units\" that is not a text", "expected a text such as", "odd");
}

TEST_F(Hdf5Table, ABadUnitLengthOrValueIsNamed) {
  with_two({1, 2}, {1, 2}, "fsp");
  expect_mistake("dataset \"v\" has the units \"fsp\": unknown unit \"fsp\"", "did you mean");
  with_two({1, 2}, {1, 2}, "kg");
  expect_mistake("dataset \"v\" has the units \"kg\"", "is a mass");
  with_two({1e300, 2}, {1, 2}, "km/us");
  expect_mistake("dataset \"v\" in row 1", "too large");
  with_two({1, 2}, {1, 2, 3});
  expect_mistake("dataset \"end/height\" has 3 rows, but \"v\" has 2", "expected one length");
  with_two({1, NAN}, {1, 2});
  expect_mistake("dataset \"v\" is nan in row 2", "expected a finite number");
  with_two({1, 2}, {HUGE_VAL, 2});
  expect_mistake("dataset \"end/height\" is inf in row 1", "expected a finite number");
  with_two({1, -2}, {1, 2});
  try {
    load();
    ADD_FAILURE() << "a negative speed is taken";
  } catch (const scene::SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("row 2 of column \"v\" is out of bounds"),
              std::string::npos);
  }
}

// Another table is another scene, although the text of the scene is the same.
TEST_F(Hdf5Table, ValuesDecideTheDigestOfRows) {
  with_two({100, 200}, {5, 6});
  const solver::Digest digest = scene::row_digest(load());
  with_two({100, 200}, {5, 6});
  EXPECT_EQ(scene::row_digest(load()), digest);
  with_two({100, std::nextafter(200.0, 300.0)}, {5, 6});
  EXPECT_NE(scene::row_digest(load()), digest);
}

// HDF5 alone would read zeros for the rows of a file that is missing.
TEST_F(Hdf5Table, ARecordingIsTakenWholeOrRefused) {
  const std::string text =
      "[projectile]\nspeed = { from = 10, to = 20, count = 3 }\n[integration]\nstep = 0.1\n"
      "time_limit = 1\n";
  const scene::SweepScene first = scene::parse_sweep(text, "first.toml");
  const solver::Sweep sweep(first.setup);
  {
    SweepRecording recording(directory_ / "out", first, sweep, {});
    const PartDigest part = recording.write(0, sweep.run(0, 3, {}));
    recording.finish(RunStatus::done, {part}, {}, 0);
  }
  const auto second = [&](const std::string& column) {
    return scene::parse_sweep("[projectile]\nspeed = { column = \"" + column +
                                  "\" }\n[sweep]\ntable = \"out/trajectories.hdf\"\n"
                                  "[integration]\nstep = 0.1\ntime_limit = 1\n",
                              (directory_ / "second.toml").string());
  };
  const auto mistake = [&] {
    try {
      second("input/speed");
    } catch (const scene::SceneError& error) {
      return std::string(error.what());
    }
    return std::string("no mistake");
  };
  EXPECT_EQ(values(second("input/speed"), "speed"), (std::vector<double>{10, 15, 20}));
  for (const char* name : {"rows_000000.hdf", "trajectories.hdf"}) {
    const std::string bytes = bytes_of(directory_ / "out" / name);
    std::string altered = bytes;
    altered[altered.size() - seal_size - 1] ^= 1;
    put_bytes(directory_ / "out" / name, altered);
    EXPECT_NE(mistake().find(name), std::string::npos) << mistake();
    EXPECT_NE(mistake().find("run its scene again"), std::string::npos) << mistake();
    put_bytes(directory_ / "out" / name, bytes);
  }
  EXPECT_EQ(mistake(), "no mistake");
  std::filesystem::remove(directory_ / "out/rows_000000.hdf");
  EXPECT_NE(mistake().find("rows_000000.hdf, which is missing"), std::string::npos) << mistake();
}

// Not ours, so without a seal: every column is looked up, and none reads as zeros.
TEST_F(Hdf5Table, ADatasetThatIsShownMustBeThere) {
  const std::vector<hdf5::VirtualPart> parts{{"source.hdf", 2}};
  with([&](hid_t file) {
    const hid_t type = hdf5::type_of<double>();
    hdf5::create_virtual_dataset(file, "v", type, {2}, "/v", parts);
    const Handle group = hdf5::create_group(file, "end");
    hdf5::create_virtual_dataset(group, "height", type, {2}, "/end/height", parts);
  });
  const std::filesystem::path shown = table_;
  const auto put_source = [&](bool height) {
    table_ = directory_ / "source.hdf";
    with([&](hid_t file) {
      put(file, "v", {100, 200});
      const Handle group = hdf5::create_group(file, "end");
      if (height) put(group, "height", {5, 6});
    });
    table_ = shown;
  };
  try {
    load();
    ADD_FAILURE() << "rows of a missing file are taken";
  } catch (const scene::SceneError& error) {
    ASSERT_EQ(error.mistakes().size(), 2U) << error.what();
    for (const std::string& mistake : error.mistakes()) {
      EXPECT_NE(mistake.find("source.hdf, which is missing"), std::string::npos) << mistake;
    }
  }
  put_source(false);
  expect_mistake("dataset \"end/height\" shows rows of", "has no dataset \"/end/height\"");
  put_source(true);
  EXPECT_EQ(values(load(), "altitude"), (std::vector<double>{5, 6}));
}

}  // namespace
}  // namespace salvo::recording
