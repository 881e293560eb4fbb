// salvo validate: everything that is wrong with some scenes, in one go.
#include <fmt/format.h>

#include "cli/json.hpp"
#include "cli/scene_input.hpp"
#include "cli/terminal.hpp"
#include "cli/text.hpp"
#include "cli/verbs.hpp"

namespace salvo::cli {

ExitStatus validate(const Options& options) {
  ExitStatus status = ExitStatus::done;
  Json documents = Json::array();
  for (const std::string& path : options.inputs) {
    Json document = {{"path", path}, {"valid", false}};
    try {
      const scene::AnyScene any = load_scene(path, options);
      document["valid"] = true;
      if (const auto* sweep = std::get_if<scene::SweepScene>(&any)) {
        document["digest"] = to_string(scene::row_digest(*sweep));
        if (!options.json) {
          print(fmt::format("{}: valid, {}\n", path,
                            counted(solver::Sweep(sweep->setup).rows(), "trajectory")));
        }
        documents.push_back(std::move(document));
        continue;
      }
      const auto& scene = std::get<scene::Scene>(any);
      document["digest"] = to_string(scene::scene_digest(scene));
      if (!options.json) {
        print(fmt::format("{}: valid, {}, {}\n", path,
                          counted(solver::World::total_emitted(scene.setup), "particle"),
                          counted(static_cast<std::uint64_t>(scene.steps), "step")));
      }
    } catch (const scene::SceneError& error) {
      for (const std::string& mistake : error.mistakes()) say(mistake);
      document["mistakes"] = error.mistakes();
      status = ExitStatus::scene_invalid;
    } catch (const Failure& error) {
      say_error(error.what(), error.hint());
      document["mistakes"] = {error.what()};
      if (status == ExitStatus::done) status = error.status();
    }
    documents.push_back(std::move(document));
  }
  if (options.json) {
    print_json({{"status", status == ExitStatus::done ? "done" : "failed"},
                {"exit_status", static_cast<int>(status)},
                {"scenes", documents}});
  }
  return status;
}

}  // namespace salvo::cli
