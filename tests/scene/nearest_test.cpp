// What a mistyped word may have meant.
#include "scene/nearest.hpp"

#include <gtest/gtest.h>

namespace salvo::scene {
namespace {

TEST(Nearest, CountsEdits) {
  EXPECT_EQ(edit_distance("speed", "speed"), 0u);
  EXPECT_EQ(edit_distance("sped", "speed"), 1u);
  EXPECT_EQ(edit_distance("speeed", "speed"), 1u);
  EXPECT_EQ(edit_distance("spead", "speed"), 1u);
  EXPECT_EQ(edit_distance("psede", "speed"), 2u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("abc", ""), 3u);
}

TEST(Nearest, SuggestsOnlyWhatIsNear) {
  const std::vector<std::string_view> words{"count", "speed", "spread", "time"};
  EXPECT_EQ(nearest("sped", words), "speed");
  EXPECT_EQ(nearest("spraed", words), "spread");
  EXPECT_EQ(nearest("tiem", words), "time");
  EXPECT_EQ(nearest("viscosity", words), "");
  EXPECT_EQ(did_you_mean("cuont", words), "did you mean \"count\"?");
  EXPECT_EQ(did_you_mean("viscosity", words), "");
  EXPECT_EQ(nearest("x", {}), "");
}

}  // namespace
}  // namespace salvo::scene
