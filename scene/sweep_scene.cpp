#include "scene/sweep_scene.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <span>

#include "scene/words.hpp"

namespace salvo::scene {

solver::Digest row_digest(const SweepScene& scene) {
  const solver::SweepSetup& setup = scene.setup;
  const solver::Integration& integration = setup.integration;
  std::string text = fmt::format("salvo {} rows\n{} {} {}\n", contract_version, scene.model->name,
                                 name(setup.precision), setup.seed);
  const auto add = [&](std::span<const double> values) {
    for (const double value : values) text += fmt::format(" {:a}", value);
    text += '\n';
  };
  for (const solver::Variation& input : setup.inputs) {
    text += fmt::format("{}", static_cast<int>(input.kind));
    add(std::array{input.a, input.b, input.lowest, input.highest});
    add(input.values);
    add(input.shifts);
  }
  for (const solver::JointNormal& joint : setup.joint) {
    text += fmt::format("joint {}", fmt::join(joint.inputs, " "));
    add(joint.mean);
    for (const std::vector<double>& row : joint.factor) add(row);
  }
  const bool fixed = setup.sampling == solver::Sampling::latin_hypercube;
  text += fmt::format("{} {}\n", static_cast<int>(setup.sampling), fixed ? setup.samples : 0);
  text += fmt::format("{} {} {} {}\n", static_cast<int>(integration.method), integration.most_steps,
                      integration.stop_at.value_or(~std::uint32_t{0}), integration.record);
  add(std::array{integration.step, integration.absolute_tolerance, integration.relative_tolerance,
                 integration.accuracy, integration.smallest_step, integration.largest_step,
                 setup.time_limit});
  if (setup.data) add(setup.data->numbers());
  text += fmt::format("{}", integration.samples.quantity);
  add(integration.samples.levels);
  return solver::digest_of(text.data(), text.size());
}

}  // namespace salvo::scene
