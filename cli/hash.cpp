// salvo hash: the state hash of every frame of a scene, without a recording.
#include <fmt/format.h>

#include "cli/json.hpp"
#include "cli/memory.hpp"
#include "cli/progress.hpp"
#include "cli/scene_input.hpp"
#include "cli/stepper.hpp"
#include "cli/sweep_verbs.hpp"
#include "cli/terminal.hpp"
#include "cli/text.hpp"
#include "cli/verbs.hpp"

namespace salvo::cli {

ExitStatus hash(const Options& options) {
  const scene::AnyScene any = load_scene(options.inputs.front(), options);
  if (const auto* sweep = std::get_if<scene::SweepScene>(&any)) return hash_sweep(options, *sweep);
  const auto& scene = std::get<scene::Scene>(any);
  check_memory(scene, run_bytes(scene, false));
  solver::World world(scene.setup, options.execution());
  Progress progress(options.quiet);
  Stepper stepper(world, [&] {
    progress.update(static_cast<double>(world.step()) / static_cast<double>(scene.steps), [&] {
      return fmt::format(
          "step {} of {}  {}", world.step(), scene.steps,
          rate_text(static_cast<double>(world.particle_steps()) / progress.seconds()));
    });
  });
  Json frames = Json::array();
  const auto report = [&] {
    const solver::StateHash state = world.hash();
    if (options.json) {
      Json frame = {{"step", world.step()}, {"time", world.time()}};
      frame.update(json_of(state));
      frames.push_back(std::move(frame));
    } else {
      progress.clear();
      print(fmt::format("{}  step {}  {:.6g} s\n", to_string(state.total), world.step(),
                        world.time()));
      flush_output();
    }
  };
  report();
  while (world.step() < scene.steps) {
    const std::int64_t next_frame = (world.step() / scene.frames.every + 1) * scene.frames.every;
    stepper.advance_to(std::min(next_frame, scene.steps));
    report();
  }
  if (options.json) {
    print_json({{"status", "done"},
                {"scene", scene_identity(scene)},
                {"execution", json_of(world.execution())},
                {"state_hash", frames.back()["total"]},
                {"frames", frames}});
  }
  return ExitStatus::done;
}

}  // namespace salvo::cli
