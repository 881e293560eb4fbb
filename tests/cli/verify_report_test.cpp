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

}  // namespace
}  // namespace salvo::tests
