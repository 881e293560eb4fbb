// Numbers with units: exact factors, one rounding, and what is said about a wrong unit.
#include "scene/units.hpp"

#include <gtest/gtest.h>

#include <cfenv>
#include <cstdlib>
#include <random>

#include "kernels/forces.hpp"
#include "kernels/math.hpp"

namespace salvo::scene {
namespace {

std::string problem_of(const std::string& text, const std::string& unit) {
  try {
    quantity(text, unit);
  } catch (const UnitError& error) {
    return std::string(error.what()) + " | " + error.hint();
  }
  return "no problem";
}

TEST(Units, ConvertByExactFactors) {
  EXPECT_EQ(quantity("2700 fps", "m/s"), 822.96);
  EXPECT_EQ(quantity("168 gr", "kg"), 0.01088621688);
  EXPECT_EQ(quantity("180 deg", "rad"), kernels::pi);
  EXPECT_EQ(quantity("1 rev", "rad"), 2 * kernels::pi);
  EXPECT_EQ(quantity("5 ms", "s"), 0.005);
  EXPECT_EQ(quantity("1.225 kg/m^3", "kg/m^3"), 1.225);
  EXPECT_EQ(quantity("36 km/h", "m/s"), 10.0);
  EXPECT_EQ(quantity("3600 kn", "m/s"), 1852.0);
  EXPECT_EQ(quantity("1 kg TNT", "J"), 4.184e6);
  EXPECT_EQ(quantity("1 lbf", "N"), 4.4482216152605);
  EXPECT_EQ(quantity("1 slug ft/s^2", "N"), 4.4482216152605);
  EXPECT_EQ(quantity("9.8 N/kg", "m/s^2"), 9.8);
  EXPECT_EQ(quantity("2 N s", "N s"), 2.0);
  EXPECT_EQ(quantity("50 %", ""), 0.5);
  EXPECT_EQ(quantity("10 Hz", "1/s"), 10.0);
}

TEST(Units, OfTable1_1) {  // 1.2: English units in SI
  struct Row {
    const char* english;
    const char* si;
    double factor, tolerance;
  };
  const Row rows[] = {{"1 ft/s^2", "m/s^2", 0.3048, 0},
                      {"1 rad/s^2", "rad/s^2", 1, 0},
                      {"1 slug/ft^3", "kg/m^3", 515.378818, 6e-7},
                      {"1 lbf", "N", 4.4482216153, 6e-11},
                      {"1 ft^2/s", "m^2/s", 0.09290304, 0},
                      {"1 ft", "m", 0.3048, 0},
                      {"1 slug", "kg", 14.5939029372, 6e-11},
                      {"1 ft lbf", "N m", 1.3558179483, 6e-11},
                      {"1 lbf ft s^2", "kg m^2", 1.3558179483, 6e-11},
                      {"1 lbf/ft^2", "N/m^2", 47.88025898, 6e-9},
                      {"1 s", "s", 1, 0},
                      {"1 ft/s", "m/s", 0.3048, 0},
                      {"1 rad/s", "rad/s", 1, 0},
                      {"1 lbf s/ft^2", "N s/m^2", 47.88025898, 6e-9}};
  for (const Row& row : rows) {
    EXPECT_NEAR(quantity(row.english, row.si), row.factor, row.tolerance) << row.english;
  }
}

TEST(Units, OfAKnot) {                                // 1.2
  EXPECT_NEAR(quantity("1 kn", "m/s"), 0.514, 5e-4);  // printed
  EXPECT_NEAR(quantity("10 kn", "m/s"), 5.14444, 6e-6);
  const double feet = quantity("1 kn", "ft/s");
  EXPECT_NEAR(feet * feet, 2.848702, 6e-7);  // 185 % too much for who forgets it, in feet
  // Friction 1/2 rho V^2 S Cf of a hull of 50 m^2, Cf 0.002, in sea water at 10 knots.
  using V = kernels::ScalarLane<double>;
  const kernels::Vec3<V> flow{V(quantity("10 kn", "m/s")), V(0), V(0)};
  const auto friction = kernels::quadratic_drag(flow, V(0.5 * 1025 * 50 * 0.002));
  EXPECT_NEAR(-friction.x.value(), 1356.34, 1356.34e-5);
}

TEST(Units, OfTheGravitationalConstant) {  // 3.2: in ft^4/(lbf s^4); the printed one is 0.09 % off
  EXPECT_NEAR(quantity("3.4391e-8 ft^4/lbf/s^4", "m^4/N/s^4"), 6.673e-11, 1e-15);
  EXPECT_NEAR(quantity("3.436e-8 ft^4/lbf/s^4", "m^4/N/s^4"), 6.667e-11, 1e-14);
}

TEST(Units, OfTnt) {  // 18.4.2, A8.1, A8.2
  const double charge = quantity("1 kg TNT", "J");
  EXPECT_EQ(charge / quantity("400 J", "J"), 10460);  // rounds of 9 mm
  EXPECT_NEAR(charge / 3, 1394666.667, 6e-4);         // what a third of it gives
  EXPECT_NEAR(charge / 3 / 5, 278933.333, 6e-4);      // to each of five pieces
}

TEST(Units, NeverChangeTheResult) {
  EXPECT_EQ(quantity("100 cm", "m"), 1.0);
  EXPECT_EQ(quantity("0.1 km", "m"), 100.0);
  EXPECT_EQ(quantity("39.37007874015748031496062992125984251968503937 in", "m"), 1.0);
  // 0.1 and 0.001 are no doubles: multiplying them would round twice.
  EXPECT_EQ(quantity("1.1 ms", "s"), 0.0011);
  EXPECT_EQ(quantity("4.35 cm", "m"), 0.0435);
  EXPECT_EQ(quantity("1001 mm", "m"), 1.001);
  std::minstd_rand random(3);
  for (int i = 0; i < 2000; ++i) {
    const std::string digits = std::to_string(random()) + std::to_string(random());
    const std::string micrometres = digits + " um";
    EXPECT_EQ(quantity(micrometres, "m"), std::strtod((digits + "e-6").c_str(), nullptr)) << digits;
  }
}

TEST(Units, RoundLikeTheCLibrary) {
  for (const char* text :
       {"0", "-0", "1", "0.1", "-2.5e-3", "123456789012345678901234567890", "9007199254740993",
        "9007199254740992.9999999999999999999999", "1.7976931348623157e308", "5e-324", "2.4e-324",
        "2.470328229206232720882843964341e-324", "2.2250738585072011e-308", "1e-400", "1e23",
        "8.5e22", "1_000.5", "6.5", "0.30000000000000004"}) {
    std::string plain = text;
    std::erase(plain, '_');
    const double expected = std::strtod(plain.c_str(), nullptr);
    EXPECT_EQ(number_in(text, ""), expected) << text;
    EXPECT_EQ(std::signbit(number_in(text, "")), std::signbit(expected)) << text;
  }
  std::minstd_rand random(5);
  for (int i = 0; i < 5000; ++i) {
    const std::string text = std::to_string(random()) + "." + std::to_string(random()) + "e" +
                             std::to_string(static_cast<int>(random() % 640) - 320);
    const double expected = std::strtod(text.c_str(), nullptr);
    if (std::isinf(expected)) {
      EXPECT_THROW(number_in(text, ""), UnitError) << text;
    } else {
      EXPECT_EQ(number_in(text, ""), expected) << text;
    }
  }
}

TEST(Units, DoNotDependOnTheRoundingModeOfTheCaller) {
  std::fesetround(FE_UPWARD);
  const double up = quantity("0.1 ms", "s");
  std::fesetround(FE_TONEAREST);
  EXPECT_EQ(up, 0.0001);
}

TEST(Units, AreReadAsPeopleWriteThem) {
  EXPECT_EQ(quantity(" 10deg ", "rad"), quantity("10 deg", "rad"));
  EXPECT_EQ(quantity("10°", "rad"), quantity("10 deg", "rad"));
  EXPECT_EQ(quantity("3 m³/s²", "m^3/s^2"), 3.0);
  EXPECT_EQ(quantity("3 m3/s2", "m^3/s^2"), 3.0);
  EXPECT_EQ(quantity("3 m s^-1", "m/s"), 3.0);
  EXPECT_EQ(quantity("7 µm", "m"), 7e-6);
  EXPECT_EQ(quantity("2 N*s", "N s"), 2.0);
  EXPECT_EQ(quantity("+1_000.5e-1 m", "m"), 100.05);
  EXPECT_EQ(quantity("2 1/s", "1/s"), 2.0);
}

TEST(Units, NumbersWithoutUnitAreSi) {
  EXPECT_EQ(number_in("4", "s"), 4.0);
  EXPECT_EQ(number_in("4", "ms"), 4000.0);
  EXPECT_EQ(number_in("3.141592653589793", "deg"), 180.0);
}

TEST(Units, WrongOnesAreNamed) {
  EXPECT_EQ(problem_of("5 kg", "m/s"), "\"5 kg\" is a mass | expected a speed in m/s");
  EXPECT_EQ(problem_of("5", "m/s"), "\"5\" has no unit | expected a speed in m/s");
  EXPECT_EQ(problem_of("5 m", ""), "\"5 m\" is a length | expected a number without a unit");
  EXPECT_EQ(problem_of("5 m^2 kg", "m"),
            "\"5 m^2 kg\" is another kind of quantity | expected a length in m");
  EXPECT_EQ(problem_of("5 metre", "m"), "unknown unit \"metre\" | expected a number in m");
  EXPECT_EQ(problem_of("5 fsp", "m/s"), "unknown unit \"fsp\" | did you mean \"fps\"?");
  EXPECT_EQ(problem_of("5 m^", "m"), "\"m^\" is no unit | a power is ^1 to ^9");
  EXPECT_EQ(problem_of("5 m/", "m"), "\"m/\" is no unit | one unit follows each /");
  EXPECT_EQ(problem_of("5 m//1", "m"), "\"m//1\" is no unit | one unit follows each /");
  EXPECT_EQ(problem_of("fast", "m/s"),
            "\"fast\" does not start with a number | expected a speed in m/s");
  EXPECT_EQ(problem_of("", "m"), "\"\" does not start with a number | expected a length in m");
  EXPECT_EQ(problem_of("1e999 m", "m"), "\"1e999 m\" is too large | expected a length in m");
  EXPECT_EQ(problem_of("1e99999999 m", "m"),
            "\"1e99999999 m\" is too large | expected a length in m");
}

TEST(Units, WhatIsNotFiniteIsRefused) {
  for (const char* text : {"inf", "-inf", "nan", "1e309", "", "-", ".", "1e309"}) {
    EXPECT_THROW(number_in(text, ""), UnitError) << text;
  }
}

}  // namespace
}  // namespace salvo::scene
