// Reading scenes of trajectories: what the keys fill, what is solved for, and the text of every
// kind of mistake.
#include "scene/load_sweep.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "scene/solve.hpp"

namespace salvo::scene {
namespace {

const std::string minimal = R"([projectile]
speed = 800
range = 100
[integration]
step = 0.01
absolute_tolerance = 1e-6
time_limit = 10
)";

// How the shots that are solved for are taken to their ends.
const std::string finely = R"([integration]
step = 0.05
absolute_tolerance = 1e-9
relative_tolerance = 1e-9
time_limit = 10
)";

std::string mistakes_of(const std::string& text, const std::vector<std::string>& overrides = {},
                        const std::string& path = "scene.toml") {
  try {
    parse_sweep(text, path, overrides);
  } catch (const SceneError& error) {
    return error.what();
  }
  return "no mistake";
}
std::string mistakes_with(const std::string& more) { return mistakes_of(minimal + more); }
std::string mistake_of_speed(const std::string& value) {
  return mistakes_of("[projectile]\nspeed = " + value +
                     "\n[integration]\nstep = 0.01\nabsolute_tolerance = 1e-6\ntime_limit = 10\n");
}

std::size_t input(const SweepScene& scene, std::string_view name) {
  const auto fields = scene.model->kernels(solver::Isa::scalar).input_fields;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (fields[i].name == name) return i;
  }
  throw std::invalid_argument(std::string(name));
}
const solver::Variation& of(const SweepScene& scene, std::string_view name) {
  return scene.setup.inputs[input(scene, name)];
}

TEST(SweepScene, ModelsAndKindsAreToldApart) {
  EXPECT_TRUE(std::holds_alternative<SweepScene>(parse_any(minimal, "s")));
  const std::string particles =
      "[time]\ndt = 0.01\nduration = 1\n[[emitter]]\nkind = \"burst\"\ncount = 10\n";
  EXPECT_TRUE(std::holds_alternative<Scene>(parse_any(particles, "s")));
  EXPECT_EQ(text_of(parse_any(particles, "s")).text, particles);
  const SweepScene scene = parse_sweep(minimal, "s");
  EXPECT_EQ(scene.model->name, "projectile");
  EXPECT_EQ(of(scene, "speed").a, 800);
  EXPECT_EQ(of(scene, "gravity").a, 9.80665);
  EXPECT_EQ(scene.setup.precision, soa::Precision::float64);
  EXPECT_EQ(solver::Sweep(scene.setup).rows(), 1u);
}

TEST(SweepScene, InputsVaryInEveryWay) {
  using Kind = solver::Variation::Kind;
  const SweepScene scene = parse_sweep(R"([projectile]
drag_function = "G1"
speed = { normal = ["2700 fps", "10 fps"] }
elevation = ["1 deg", "2 deg", 0.1]
azimuth = { uniform = ["-1 deg", "1 deg"] }
wind_z = { normal = [0, 2], within = [-5, 5] }
altitude = { from = "0 m", to = "1 km", count = 5 }
[sweep]
samples = 10
[integration]
step = "10 ms"
time_limit = 1
)",
                                       "s");
  EXPECT_EQ(of(scene, "drag_function").a, 0);
  EXPECT_EQ(of(scene, "speed").kind, Kind::normal);
  EXPECT_NEAR(of(scene, "speed").a, 2700 * 0.3048, 1e-12);
  EXPECT_NEAR(of(scene, "speed").b, 3.048, 1e-14);
  EXPECT_EQ(of(scene, "elevation").kind, Kind::grid);
  EXPECT_NEAR(of(scene, "elevation").values[1], M_PI / 90, 1e-15);
  EXPECT_EQ(of(scene, "azimuth").kind, Kind::uniform);
  EXPECT_EQ(of(scene, "wind_z").kind, Kind::truncated_normal);
  EXPECT_EQ(of(scene, "wind_z").highest, 5);
  EXPECT_EQ(of(scene, "altitude").values, (std::vector<double>{0, 250, 500, 750, 1000}));
  EXPECT_EQ(solver::Sweep(scene.setup).rows(), 150u);
}

TEST(SweepScene, WrongVariationsAreNamedWithTheirPlace) {
  EXPECT_EQ(mistake_of_speed("{ normal = [800, -1] }"),
            "scene.toml:2:26: error: \"speed\" in [projectile] is out of bounds\n"
            "  2 | speed = { normal = [800, -1] }\n"
            "    |                          ^^ expected more than 0 m/s");
  EXPECT_EQ(mistake_of_speed("{ uniform = [5, 5] }"),
            "scene.toml:2:9: error: \"speed\" in [projectile] has no width\n"
            "  2 | speed = { uniform = [5, 5] }\n"
            "    |         ^^^^^^^^^^^^^^^^^^^^ expected [low, high], low below high");
  EXPECT_NE(mistake_of_speed("{ norml = [5, 5] }").find("varies in no known way"),
            std::string::npos);
  EXPECT_NE(mistake_of_speed("{ normal = [5, 1], within = [20, 30] }").find("8 deviations"),
            std::string::npos);
  EXPECT_NE(mistake_of_speed("[]").find("is empty"), std::string::npos);
  EXPECT_NE(mistake_of_speed("-3").find("out of bounds"), std::string::npos);
  EXPECT_NE(mistake_of_speed("\"3 kg\"").find("a speed"), std::string::npos);
  EXPECT_NE(mistake_of_speed("{ from = 1, to = 2, count = 1 }").find("out of bounds"),
            std::string::npos);
  EXPECT_NE(mistake_of_speed("{ column = \"v\" }").find("there is no table"), std::string::npos);
}

TEST(SweepScene, ADragFunctionIsANameOrAListOfThem) {
  const auto with = [](const std::string& value) {
    return mistakes_of(minimal, {"projectile.drag_function=" + value});
  };
  const SweepScene scene = parse_sweep(minimal, "s", {"projectile.drag_function=[\"G1\", \"G8\"]"});
  EXPECT_EQ(scene.setup.inputs[input(scene, "drag_function")].values, (std::vector<double>{0, 5}));
  EXPECT_NE(with("[\"G1\", \"G9\"]").find("G9"), std::string::npos);
  for (const char* value : {"2.5", "4", "[1, 2.5]", "{ uniform = [0, 7] }", "{ column = \"f\" }",
                            "{ from = 1, to = 2, count = 3 }", "[]", "true"}) {
    EXPECT_NE(with(value), "no mistake") << value;
  }
  EXPECT_NE(mistakes_with("[[solve]]\ninput = \"drag_function\"\nbetween = [\"G1\", \"G7\"]\n"
                          "quantity = \"end.y\"\n")
                .find("is a name"),
            std::string::npos);
}

TEST(SweepScene, AnUnknownKeyOrWordGetsASuggestion) {
  EXPECT_EQ(mistakes_of("[projectile]\nsped = 1\n[integration]\nstep = 1\ntime_limit = 1\n"),
            "scene.toml:2:1: error: unknown key \"sped\" in [projectile]\n"
            "  2 | sped = 1\n"
            "    | ^^^^ did you mean \"speed\"?");
  EXPECT_NE(mistakes_of("[projectil]\nspeed = 1\n[integration]\nstep = 1\ntime_limit = 1\n")
                .find("did you mean \"projectile\"?"),
            std::string::npos);
  EXPECT_NE(mistakes_with("record = [\"apx\"]\n").find("did you mean \"apex\"?"),
            std::string::npos);
  EXPECT_NE(mistakes_with("[statistics]\ncolumns = [\"end.yy\"]\n").find("there is no column"),
            std::string::npos);
  EXPECT_NE(
      mistakes_with("[statistics]\ncolumns = [\"outcome\"]\n").find("is no measured quantity"),
      std::string::npos);
  EXPECT_NE(mistakes_with("[lorenz]\n").find("[projectile] and [lorenz] are both given"),
            std::string::npos);
  EXPECT_NE(mistakes_of("[integration]\nstep = 1\ntime_limit = 1\n").find("there is no model"),
            std::string::npos);
}

TEST(SweepScene, WhatDoesNotGoTogetherIsRefused) {
  EXPECT_NE(mistakes_of(minimal, {"integration.method=runge_kutta_4"}).find("knows no error"),
            std::string::npos);
  EXPECT_NE(mistakes_with("record = [\"range\"]\n").find("ends a row"), std::string::npos);
  EXPECT_NE(mistakes_with("[sweep]\nsamples = 10\n").find("no input is random"), std::string::npos);
  EXPECT_NE(mistakes_with("[samples]\nlevels = [3, 2]\n").find("do not ascend"), std::string::npos);
  EXPECT_NE(mistakes_with("[samples]\nto = 3\n").find("missing keys"), std::string::npos);
  EXPECT_NE(mistakes_with("[samples]\nof = \"x\"\nlevels = [\"1 s\"]\n").find("a length"),
            std::string::npos);
}

TEST(SweepScene, AnAccuracyHasTheUnitOfTheFirstState) {
  EXPECT_EQ(parse_sweep(minimal + "accuracy = \"1 mm\"\n", "s").setup.integration.accuracy, 1e-3);
  EXPECT_NE(mistakes_with("accuracy = \"1 s\"\n").find("a length"), std::string::npos);
  EXPECT_NE(mistakes_of(minimal + "accuracy = 1\n", {"precision=float"}).find("too few digits"),
            std::string::npos);
  EXPECT_NE(mistakes_with("accuracy = 0\n").find("out of bounds"), std::string::npos);
  EXPECT_NE(mistakes_of(minimal + "accuracy = 1\n",
                        {"integration.absolute_tolerance=0", "integration.relative_tolerance=0",
                         "integration.method=heun"})
                .find("knows no error"),
            std::string::npos);
}

TEST(SweepScene, AnOwnDragFunctionIsATableThatIsRight) {
  const auto mistake = [](const std::string& table, const std::string& drag,
                          const std::string& function = "table") {
    const std::string path = testing::TempDir() + "salvo_drag.csv";
    std::ofstream(path) << table;
    try {
      parse_sweep(minimal + "[drag]\n" + drag + "\n", testing::TempDir() + "scene.toml",
                  {"projectile.drag_function=" + function});
    } catch (const SceneError& error) {
      return std::string(error.what());
    }
    return std::string("no mistake");
  };
  const std::string right = "mach,cd\n0.5,0.2\n1,0.4\n2,0.3\n";
  const std::string given = "table = \"salvo_drag.csv\"";
  EXPECT_EQ(mistake(right, given), "no mistake");
  EXPECT_EQ(mistake(right, "interpolation = \"linear\"", "G7"), "no mistake");
  EXPECT_NE(mistake("mach,cd\n0.5,0.2\n1,0.4\n0.9,0.3\n", given)
                .find("row 3 of " + testing::TempDir() + "salvo_drag.csv: Mach 0.9 comes after 1"),
            std::string::npos);
  EXPECT_NE(mistake("mach,cd\n0.5,0.2\n1,-1\n2,0.3\n", given).find("drag coefficient of -1"),
            std::string::npos);
  EXPECT_NE(
      mistake("mach,cd\n0.5,0.2\n1,x\n2,0.3\n", given).find("salvo_drag.csv:3: column \"cd\""),
      std::string::npos);
  EXPECT_NE(mistake("mach,c\n0.5,0.2\n1,1\n2,0.3\n", given).find("has no column \"cd\""),
            std::string::npos);
  EXPECT_NE(mistake(right, "table = \"none.csv\"").find("cannot read"), std::string::npos);
  EXPECT_NE(mistake(right, given, "G7").find("no trajectory has this drag function"),
            std::string::npos);
  EXPECT_NE(mistake(right, "").find("the drag function is a table, but there is none"),
            std::string::npos);
  EXPECT_NE(mistakes_of("[lorenz]\n[drag]\ninterpolation = \"linear\"\n[integration]\nstep = "
                        "1\ntime_limit = 1\n")
                .find("the model lorenz has no drag function"),
            std::string::npos);
}

TEST(SweepScene, WhatADragFunctionIsDecidesTheRows) {
  const auto digest = [](const std::string& more) {
    return row_digest(parse_sweep(minimal + more, "s"));
  };
  EXPECT_EQ(digest("[drag]\ninterpolation = \"linear\"\n"),
            digest("[drag]\ninterpolation = \"linear\"\n"));
  EXPECT_NE(digest(""), digest("[drag]\ninterpolation = \"linear\"\n"));
}

TEST(SweepScene, SamplesTakeTheUnitOfWhatTheyAreOf) {
  const SweepScene scene =
      parse_sweep(minimal + "[samples]\nof = \"x\"\nto = \"100 yd\"\nevery = \"25 yd\"\n", "s");
  EXPECT_EQ(scene.setup.integration.samples.quantity, 0u);
  ASSERT_EQ(scene.setup.integration.samples.levels.size(), 5u);
  EXPECT_NEAR(scene.setup.integration.samples.levels[4], 91.44, 1e-12);
}

TEST(SweepScene, JointInputsNeedACovarianceThatIsOne) {
  const auto with = [](const std::string& covariance) {
    return mistakes_with(
        "[[joint_normal]]\ninputs = [\"wind_x\", \"wind_z\"]\nmean = [0, \"2 "
        "m/s\"]\ncovariance = " +
        covariance + "\n");
  };
  EXPECT_EQ(with("[[4, 1], [1, 2]]"), "no mistake");
  EXPECT_NE(with("[[1, 2], [2, 1]]").find("not positive definite"), std::string::npos);
  EXPECT_NE(with("[[1, 2], [3, 9]]").find("not symmetric"), std::string::npos);
  EXPECT_NE(with("[[1, 2]]").find("has not the right shape"), std::string::npos);
  EXPECT_NE(
      mistakes_with("[[joint_normal]]\ninputs = [\"speed\"]\nmean = [1]\ncovariance = [[1]]\n")
          .find("given elsewhere"),
      std::string::npos);
}

TEST(SweepScene, CholeskysFactorTimesItselfIsTheMatrix) {
  const std::vector<std::vector<double>> matrix{{4, 2, 0.6}, {2, 5, 1}, {0.6, 1, 3}};
  const auto factor = cholesky(matrix);
  ASSERT_TRUE(factor);
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      double sum = 0;
      for (std::size_t k = 0; k < 3; ++k) sum += (*factor)[a][k] * (*factor)[b][k];
      EXPECT_NEAR(sum, matrix[a][b], 1e-14);
    }
  }
}

class Table : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("salvo_table_" +
               std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string with(const std::string& csv) const {
    std::ofstream(folder_ / "shots.csv") << csv;
    return (folder_ / "scene.toml").string();
  }
  const std::string text_ = R"([projectile]
speed = { column = "v" }
altitude = { column = "height" }
[sweep]
table = "shots.csv"
[integration]
step = 0.01
time_limit = 1
)";
  std::filesystem::path folder_;
};

TEST_F(Table, ColumnsAreReadWithTheirUnits) {
  const std::string path = with("# made by hand\nv [fps],height\n1000,5\n2000, 6\n");
  const SweepScene scene = parse_sweep(text_, path);
  EXPECT_EQ(of(scene, "speed").values, (std::vector<double>{304.8, 609.6}));
  EXPECT_EQ(of(scene, "altitude").values, (std::vector<double>{5, 6}));
}

TEST_F(Table, ABadCellOrColumnIsNamedWithItsPlace) {
  const auto mistake = [&](const std::string& csv) { return mistakes_of(text_, {}, with(csv)); };
  EXPECT_NE(mistake("v,height\n1,2\n3,x4\n").find("shots.csv:3: column \"height\""),
            std::string::npos);
  EXPECT_NE(mistake("v,heigth\n1,2\n").find("did you mean \"heigth\"?"), std::string::npos);
  EXPECT_NE(mistake("v,height\n1\n").find("shots.csv:2: 1 cells"), std::string::npos);
  EXPECT_NE(mistake("v,height [fps\n1,2\n").find("shots.csv:1: \"height [fps\" has one bracket"),
            std::string::npos);
  EXPECT_NE(mistake("v,height,v\n1,2,3\n").find("shots.csv:1: two columns are \"v\""),
            std::string::npos);
  EXPECT_NE(mistake("v,height\n1,\n").find("shots.csv:2: column \"height\" is empty"),
            std::string::npos);
  EXPECT_EQ(mistake("\xEF\xBB\xBFv,height\n1,2\n"), "no mistake");
  EXPECT_NE(mistake("v,height\n").find("has no rows"), std::string::npos);
  EXPECT_NE(mistake("v,height\n-1,2\n").find("row 1 of column \"v\" is out of bounds"),
            std::string::npos);
  std::filesystem::remove(folder_ / "shots.csv");
  EXPECT_NE(mistakes_of(text_, {}, (folder_ / "scene.toml").string()).find("cannot read"),
            std::string::npos);
}

TEST_F(Table, AnHdf5FileIsRefusedByAProgramThatReadsNone) {
  for (const char* name : {"shots.hdf", "shots.h5", "shots.HDF5"}) {
    std::string text = text_;
    text.replace(text.find("shots.csv"), 9, name);
    const std::string mistake = mistakes_of(text, {}, with("v,height\n1,2\n"));
    EXPECT_NE(mistake.find(std::string(name) + ": this program reads no HDF5 files"),
              std::string::npos)
        << mistake;
    EXPECT_NE(mistake.find("expected a CSV file"), std::string::npos) << mistake;
  }
}

// sin(2 e) = g x / v^2 without air, which has a flat and a steep root.
TEST(Solve, ElevationForARangeInVacuum) {
  const auto elevation = [](const std::string& root) {
    const SweepScene scene = parse_sweep(R"([shot_in_air]
speed = 100
ground = 0
[integration]
step = 0.1
absolute_tolerance = 1e-12
relative_tolerance = 1e-12
time_limit = 100
[[solve]]
input = "elevation"
between = [0.01, 1.56]
quantity = "end.x"
equals = 500
root = ")" + root + "\"\n",
                                         "s");
    return of(scene, "elevation").a;
  };
  const double flat = 0.5 * std::asin(9.80665 * 500 / 10'000);
  EXPECT_NEAR(elevation("first"), flat, 1e-13);
  EXPECT_NEAR(elevation("last"), M_PI / 2 - flat, 1e-13);
}

TEST(Solve, AimingHoldsOffForTheWindInBothAngles) {
  const SweepScene scene = parse_sweep(R"([projectile]
speed = 800
wind_z = { normal = [5, 1] }
elevation = { normal = [0, 1e-4] }
range = 800
[sweep]
samples = 4
)" + finely + R"([[solve]]
input = "elevation"
between = ["0 deg", "5 deg"]
quantity = "end.y"
[[solve]]
input = "azimuth"
between = ["-5 deg", "5 deg"]
quantity = "end.z"
)",
                                       "s");
  EXPECT_EQ(of(scene, "elevation").kind, solver::Variation::Kind::normal);
  ASSERT_EQ(scene.solved.size(), 2u);
  const solver::Sweep sweep(nominal(scene.setup));
  const solver::SweepRows rows = sweep.run(0, 1, {});
  for (std::size_t f = 0; f < sweep.fields().size(); ++f) {
    if (sweep.fields()[f].name == "end.y" || sweep.fields()[f].name == "end.z") {
      EXPECT_NEAR(rows.table.column<double>(f)[0], 0, 1e-9);
    }
  }
  EXPECT_LT(of(scene, "azimuth").a, 0);  // into the wind, which blows to the right
}

TEST(Solve, EachPointOfAGridHasItsOwnRoot) {
  const auto scene_with = [](const std::string& speeds, const std::string& elevation) {
    return parse_sweep("[projectile]\nspeed = " + speeds + "\nelevation = " + elevation + R"(
y = -0.04
range = 300
ballistic_coefficient = [150, 250]
[sweep]
samples = 3
)" + finely + R"([[solve]]
input = "elevation"
between = ["0 deg", "5 deg"]
quantity = "end.y"
each_point = true
)",
                       "s");
  };
  const std::string angles = "{ normal = [1e-3, 1e-4] }";
  const SweepScene scene = scene_with("[700, 800, 900]", angles);
  ASSERT_EQ(scene.solved.size(), 1U);
  ASSERT_EQ(scene.solved[0].by_point.size(), 6U);
  // The ballistic coefficient is the later input: it varies faster.
  const SweepScene alone = scene_with("800", angles);
  EXPECT_EQ(alone.solved[0].by_point[0], scene.solved[0].by_point[2]);
  EXPECT_EQ(alone.solved[0].by_point[1], scene.solved[0].by_point[3]);
  EXPECT_NE(row_digest(scene), row_digest(alone));
  // A point's rows are its root and the same draws.
  const solver::Sweep sweep(scene.setup);
  const solver::SweepRows rows = sweep.run(0, 18, {});
  std::size_t elevation = 0;
  while (sweep.fields()[elevation].name != "input.elevation") ++elevation;
  const double* drawn = rows.table.column<double>(elevation);
  for (std::size_t row = 0; row < 18; ++row) {
    EXPECT_NEAR(drawn[row] - scene.solved[0].by_point[row % 6],
                drawn[row - row % 6] - scene.solved[0].by_point[0], 1e-17);
  }
  // Without a spread all rows strike the aim.
  const SweepScene exact = [&] {
    SweepScene without = scene;
    without.setup.inputs[input(scene, "elevation")].b = 0;
    return without;
  }();
  const solver::Sweep struck(exact.setup);
  const solver::SweepRows strikes = struck.run(0, 6, {});
  std::size_t height = 0;
  while (struck.fields()[height].name != "end.y") ++height;
  for (std::size_t row = 0; row < 6; ++row) {
    EXPECT_NEAR(strikes.table.column<double>(height)[row], 0, 1e-9);
  }
}

TEST(Solve, TrajectoriesThatBreakOffAreNoAnswer) {
  const std::string text = minimal +
                           "most_steps = 3\n[[solve]]\ninput = \"elevation\"\nbetween = [\"0 "
                           "deg\", \"5 deg\"]\nquantity = \"end.y\"\n";
  EXPECT_NE(mistakes_of(text).find("brings a trajectory to an end"), std::string::npos)
      << mistakes_of(text);
}

TEST(Solve, ADistributionThatIsMovedStaysWithinBounds) {
  const std::string text = R"([shot_in_air]
speed = { normal = [800, 90] }
elevation = 0.1
ground = 0
[integration]
step = 0.1
absolute_tolerance = 1e-9
time_limit = 100
[[solve]]
input = "speed"
between = [1, 900]
quantity = "end.x"
equals = 500
)";
  EXPECT_NE(mistakes_of(text).find("would come out of its bounds about the value found"),
            std::string::npos)
      << mistakes_of(text);
}

TEST(Solve, APointOfAGridWithoutARootIsNamed) {
  const std::string text = R"([shot_in_air]
speed = [100, 50]
[integration]
step = 0.1
absolute_tolerance = 1e-9
time_limit = 100
[[solve]]
input = "elevation"
between = [0.01, 1.56]
quantity = "end.x"
equals = 500
)";
  const std::string each = mistakes_of(text, {"shot_in_air.ground=0", "solve.0.each_point=true"});
  EXPECT_NE(each.find("brings end.x to 500 m, at point 1 of the grid"), std::string::npos) << each;
  const std::string mixed =
      mistakes_of(text +
                      "[[solve]]\ninput = \"azimuth\"\nbetween = [-1, 1]\nquantity = "
                      "\"end.z\"\neach_point = true\n",
                  {"shot_in_air.ground=0"});
  EXPECT_NE(mixed.find("another is not"), std::string::npos) << mixed;
}

TEST(Solve, WithOtherInputsThanTheRunIsTheZeroOfARifle) {
  const std::string text = R"([projectile]
speed = 800
y = -0.04
range = 600
)" + finely + R"([[solve]]
input = "elevation"
between = ["0 deg", "1 deg"]
quantity = "end.y"
)";
  const SweepScene near = parse_sweep(text + "with = { range = \"100 m\" }\n", "s");
  const SweepScene far = parse_sweep(text, "s");
  EXPECT_EQ(of(near, "range").a, 600);
  EXPECT_LT(of(near, "elevation").a, of(far, "elevation").a);
}

TEST(Solve, WhatCannotBeReachedIsSaidWithWhatCan) {
  const std::string mistake = mistakes_of(R"([shot_in_air]
speed = 100
ground = 0
[integration]
step = 0.1
absolute_tolerance = 1e-9
time_limit = 100
[[solve]]
input = "elevation"
between = [0.1, 1.5]
quantity = "end.x"
equals = "2 km"
)");
  EXPECT_NE(
      mistake.find("scene.toml:10:11: error: no elevation from 0.1 to 1.5 rad brings end.x to "
                   "2000 m"),
      std::string::npos)
      << mistake;
  EXPECT_NE(mistake.find("it comes to 143.902"), std::string::npos) << mistake;
}

const std::string aimed = R"([projectile]
speed = 800
ground = GROUND
range = 300
elevation = ELEVATION
)" + finely + R"([[solve]]
input = "elevation"
between = ["0 deg", "5 deg"]
quantity = "end.y"
)";
std::string aimed_with(std::string ground, const std::string& elevation, const std::string& more) {
  std::string text = aimed;
  text.replace(text.find("GROUND"), 6, ground);
  text.replace(text.find("ELEVATION"), 9, elevation);
  return text + more;
}

TEST(Solve, ADistributionMovesAsAWhole) {
  const auto variation = [](const std::string& elevation) {
    return of(parse_sweep(aimed_with("-1e9", elevation, ""), "s"), "elevation");
  };
  const double root = variation("0").a;
  EXPECT_GT(root, 1e-3);
  const solver::Variation uniform = variation("{ uniform = [-0.001, 0.001] }");
  EXPECT_NEAR(uniform.a, root - 0.001, 1e-15);
  EXPECT_NEAR(uniform.b, root + 0.001, 1e-15);
  const solver::Variation truncated =
      variation("{ normal = [0.01, 0.001], within = [0.008, 0.011] }");
  EXPECT_NEAR(truncated.a, root, 1e-15);
  EXPECT_NEAR(truncated.lowest, root - 0.002, 1e-15);
  EXPECT_NEAR(truncated.highest, root + 0.001, 1e-15);
}

// A shot that falls short ends at y = 0 by the ground, which is no answer to end.y = 0.
TEST(Solve, WhatEndsAtTheTargetForAnotherReasonIsRefused) {
  EXPECT_NE(mistakes_of(aimed_with("0", "0", "")).find("because trajectories end there"),
            std::string::npos);
  const std::string far = "with = { ground = -1e6 }\n";
  EXPECT_EQ(of(parse_sweep(aimed_with("0", "0", far), "s"), "elevation").a,
            of(parse_sweep(aimed_with("-1e9", "0", ""), "s"), "elevation").a);
  EXPECT_EQ(of(parse_sweep(aimed_with("-1e9", "0", "outcome = \"range\"\n"), "s"), "elevation").a,
            of(parse_sweep(aimed_with("-1e9", "0", ""), "s"), "elevation").a);
  EXPECT_NE(mistakes_of(aimed_with("-1e9", "0", "outcome = \"ground\"\n")).find("has this outcome"),
            std::string::npos);
  EXPECT_NE(
      mistakes_of(aimed_with("-1e9", "0", "outcome = \"rang\"\n")).find("did you mean \"range\"?"),
      std::string::npos);
}

TEST(SweepScene, ADistributionThatComesOutOfTheBoundsIsRefused) {
  EXPECT_NE(mistake_of_speed("{ normal = [1, 5] }").find("would come out of its bounds"),
            std::string::npos);
  EXPECT_EQ(mistake_of_speed("{ normal = [1, 5], within = [0, 9] }"), "no mistake");
  EXPECT_NE(mistakes_with("[[joint_normal]]\ninputs = [\"altitude\"]\nmean = [0]\ncovariance = "
                          "[[1e6]]\n")
                .find("would come out of its bounds"),
            std::string::npos);
}

TEST(SweepScene, RowsOfMoreSamplesHaveTheSameDigest) {
  const std::string random = R"([projectile]
speed = { normal = [800, 1] }
[sweep]
samples = 10
[integration]
step = 0.01
time_limit = 1
)";
  const auto digest = [&](const std::vector<std::string>& overrides) {
    return to_string(row_digest(parse_sweep(random, "s", overrides)));
  };
  EXPECT_EQ(digest({}), digest({"sweep.samples=20"}));
  EXPECT_EQ(digest({"sweep.sampling=sobol"}), digest({"sweep.sampling=sobol", "sweep.samples=20"}));
  EXPECT_NE(digest({"sweep.sampling=latin_hypercube"}),
            digest({"sweep.sampling=latin_hypercube", "sweep.samples=20"}));
  EXPECT_NE(digest({}), digest({"seed=1"}));
  EXPECT_NE(digest({}), digest({"projectile.y=1"}));
  EXPECT_NE(digest({}), digest({"integration.step=0.02"}));
  EXPECT_EQ(digest({}), digest({"title=other"}));
}

}  // namespace
}  // namespace salvo::scene
