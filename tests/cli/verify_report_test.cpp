// What salvo verify says and exits with when one run differs: a bit is flipped in it.
#include "cli/verify_report.hpp"

#include <gtest/gtest.h>

#include "scene/load.hpp"

namespace salvo::tests {

namespace {

TEST(VerifyReport, SaysWhereTheBitsFirstDiffer) {
  const scene::Scene scene = scene::parse(R"(
[time]
dt = 0.5
steps = 4
[forces]
gravity = [0, 0, 0]
[[emitter]]
kind = "burst"
count = 3
velocity = [0, 1.5, 0]
speed = 0
[frames]
every = 4
)",
                                          "small.toml");
  scene::VerifyOptions options;
  options.isas = {solver::Isa::scalar};
  options.threads = {2};
  options.passes = {3};
  options.advance = [](const scene::VerifyRun& run, solver::World& world, std::int64_t step) {
    if (run.axis == scene::VerifyAxis::threads && world.step() < 3 && step >= 3) {
      world.advance_to(3);
      auto& particles = const_cast<soa::Table&>(world.particles());
      particles.column<float>(static_cast<std::size_t>(soa::ParticleField::velocity), 1)[2] = 1.75F;
    }
    world.advance_to(step);
  };
  const scene::VerifyResult result = scene::verify(scene, options);
  EXPECT_EQ(cli::verify_status(result), cli::ExitStatus::difference);
  const std::string report = cli::verify_report(scene, scene, result);
  EXPECT_TRUE(report.starts_with("small.toml: 3 particles, 4 steps\n")) << report;
  EXPECT_NE(report.find("DIFFERENT\n"), std::string::npos) << report;
  EXPECT_NE(
      report.find("\nthreads 2: first difference at step 3: velocity.y of particle 2 (stream 0, "
                  "serial 2)\n"
                  "  reference  0x1.8p+0 (1.5)\n"
                  "  here       0x1.cp+0 (1.75)\n"),
      std::string::npos)
      << report;
}

TEST(VerifyReport, NamesBothSidesOfAContact) {
  scene::Difference difference;
  difference.step = 12;
  difference.equal_step = 11;
  difference.column = "tangential_displacement.x";
  difference.id = soa::make_id(1, 3);
  difference.partner = soa::make_id(0, 5);
  difference.reference = "0x1p-1";
  difference.varied = "0x1p+0";
  difference.rows = 2;
  scene::VerifyResult result;
  result.runs.resize(2);
  result.runs[1].axis = scene::VerifyAxis::threads;
  result.runs[1].value = "3";
  const auto report = [&] {
    result.runs[1].difference = difference;
    return cli::verify_report({}, {}, result);
  };
  const std::string id = std::to_string(soa::make_id(1, 3));
  const std::string of_pair = report();
  EXPECT_NE(of_pair.find("threads 3: first difference at step 12: tangential_displacement.x of "
                         "particle " +
                         id +
                         " (stream 1, serial 3) and particle 5 (stream 0, "
                         "serial 5)\n"),
            std::string::npos)
      << of_pair;
  EXPECT_NE(of_pair.find("  2 contacts differ at this step\n"), std::string::npos) << of_pair;
  difference.partner = soa::make_id(soa::max_stream, 4);
  const std::string of_wall = report();
  EXPECT_NE(of_wall.find(" and part 4 of the obstacles\n"), std::string::npos) << of_wall;
}

}  // namespace
}  // namespace salvo::tests
