// salvo info: what this salvo and this machine are, or what a scene is and takes.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "cli/json.hpp"
#include "cli/memory.hpp"
#include "cli/scene_input.hpp"
#include "cli/sweep_verbs.hpp"
#include "cli/terminal.hpp"
#include "cli/text.hpp"
#include "cli/verbs.hpp"
#include "scene/scene_keys.hpp"
#include "scene/sweep_keys.hpp"
#include "scene/words.hpp"
#include "solver/contact_time.hpp"

namespace salvo::cli {

namespace {

using solver::Emitter;
using solver::Setup;

std::vector<std::string> forces_of(const models::ForceSettings& forces) {
  std::vector<std::string> names;
  const auto add = [&](bool present, const char* name) {
    if (present) names.emplace_back(name);
  };
  const models::Triple& g = forces.gravity;
  add(g[0] != 0 || g[1] != 0 || g[2] != 0, "gravity");
  add(!forces.point_gravity.empty(), "point gravity");
  add(forces.linear_drag != 0, "linear drag");
  add(forces.quadratic_drag, "quadratic drag");
  add(forces.windy, "wind");
  add(forces.gusty, "gusts");
  add(forces.buoyancy, "buoyancy");
  add(!forces.blasts.empty(), "blast");
  return names;
}

std::vector<std::string> column_names(const scene::FrameSettings& frames) {
  std::vector<std::string> names;
  for (const soa::ParticleField column : frames.columns) {
    names.emplace_back(soa::field(column).name);
  }
  return names;
}

// Full states that are kept: on the way, and at the end.
std::uint64_t checkpoint_count(const scene::Scene& scene) {
  const std::int64_t every = scene.checkpoint.every;
  std::int64_t count = every > 0 ? scene.steps / every : 0;
  if (scene.checkpoint.at_end && (every == 0 || scene.steps % every != 0)) ++count;
  return static_cast<std::uint64_t>(count);
}

// Whether a run that is killed can go on from somewhere: a checkpoint or a frame that holds all.
bool leaves_full_states(const scene::Scene& scene) {
  if (scene.checkpoint.every > 0 && scene.checkpoint.every < scene.steps) return true;
  if (scene.frames.fraction < 1) return false;
  const std::vector<soa::ParticleField>& columns = scene.frames.columns;
  const std::vector<bool> stored = solver::World::stored_fields(scene.setup);
  for (std::size_t f = 0; f < stored.size(); ++f) {
    const auto field = static_cast<soa::ParticleField>(f);
    if (stored[f] && std::find(columns.begin(), columns.end(), field) == columns.end()) {
      return false;
    }
  }
  return true;
}

std::string line(std::string_view label, std::string_view text) {
  return fmt::format("  {:<12} {}\n", label, text);
}

void describe_machine(const Options& options) {
  std::vector<std::string_view> isas;
  for (const solver::Isa isa : solver::available_isas()) isas.push_back(solver::name(isa));
  const std::optional<std::uint64_t> memory = available_memory();
  if (options.json) {
    print_json({{"version", SALVO_VERSION},
                {"contract", scene::contract_version},
                {"isas", isas},
                {"default_isa", solver::name(solver::widest_isa())},
                {"threads", solver::hardware_threads()},
                {"memory_available", memory ? Json(*memory) : Json(nullptr)},
                {"compiler", SALVO_COMPILER},
                {"libraries", SALVO_LIBRARIES}});
    return;
  }
  print(fmt::format("salvo {}, contract {}\n", SALVO_VERSION, scene::contract_version));
  print(line("instructions",
             fmt::format("{} (the last unless --isa says otherwise)", fmt::join(isas, ", "))));
  print(line("threads", fmt::to_string(solver::hardware_threads())));
  if (memory) print(line("memory", bytes_text(*memory) + " available"));
  print(line("compiler", SALVO_COMPILER));
  print(line("libraries", SALVO_LIBRARIES));
}

Json emitter_document(const Emitter& emitter, const Setup& setup) {
  const solver::EmissionSchedule schedule(emitter, setup.t0, setup.dt);
  return {{"name", emitter.name},
          {"kind", scene::name(emitter.kind)},
          {"stream", emitter.stream},
          {"particles", schedule.total()},
          {"time", emitter.time}};
}

constexpr std::string_view name_of(models::ContactLawKind kind) {
  switch (kind) {
    case models::ContactLawKind::linear_spring:
      return "linear_spring";
    case models::ContactLawKind::hertz_mindlin:
      return "hertz_mindlin";
    case models::ContactLawKind::impulse:
      break;
  }
  return "impulse";
}

std::string law_text(const models::ContactLaw& law) {
  std::string text(name_of(law.kind));
  if (law.kind == models::ContactLawKind::linear_spring) {
    text += fmt::format(", {:g} N/m", law.normal_stiffness);
  } else if (law.kind == models::ContactLawKind::hertz_mindlin) {
    text += fmt::format(", {:g} Pa, Poisson {:g}", law.young_modulus, law.poisson_ratio);
  }
  text += fmt::format(", restitution {:g}", law.restitution);
  if (law.friction > 0) text += fmt::format(", friction {:g}", law.friction);
  if (law.rolling_friction > 0) text += fmt::format(", rolling {:g}", law.rolling_friction);
  if (law.surface_energy > 0) text += fmt::format(", cohesion {:g} J/m^2", law.surface_energy);
  return text;
}

// How the step follows the contacts; empty where they last no time.
std::string step_text(const scene::Scene& scene) {
  const models::ContactLaw& law = *scene.setup.contact_law;
  if (law.kind == models::ContactLawKind::impulse) return "given; an impulse takes no time";
  const solver::ContactTime time = solver::contact_time(scene.setup);
  const std::string parts = fmt::format("1/{:.3g} of {}, {:.3g} s", time.duration / scene.setup.dt,
                                        time.of, time.duration);
  return scene.step_chosen ? fmt::format("chosen: {}", parts)
                           : fmt::format("given: {}; {:.3g} s would be chosen", parts, time.step);
}

Json law_document(const scene::Scene& scene) {
  if (!scene.setup.contact_law) return nullptr;
  const models::ContactLaw& law = *scene.setup.contact_law;
  Json document = {{"kind", name_of(law.kind)},
                   {"restitution", law.restitution},
                   {"friction", law.friction},
                   {"rolling_friction", law.rolling_friction},
                   {"surface_energy", law.surface_energy},
                   {"step_chosen", scene.step_chosen}};
  if (law.kind == models::ContactLawKind::linear_spring) {
    document["normal_stiffness"] = law.normal_stiffness;
  } else if (law.kind == models::ContactLawKind::hertz_mindlin) {
    document["young_modulus"] = law.young_modulus;
    document["poisson_ratio"] = law.poisson_ratio;
  }
  if (law.kind != models::ContactLawKind::impulse) {
    const solver::ContactTime time = solver::contact_time(scene.setup);
    document["shortest_contact"] = time.duration;
    document["best_dt"] = time.step;
    document["longest_dt"] = time.longest_step;
  }
  return document;
}

void describe_scene(const scene::Scene& scene, const Options& options) {
  const Setup& setup = scene.setup;
  const std::uint64_t particles = solver::World::total_emitted(setup);
  const auto frames = static_cast<std::uint64_t>(scene.frame_count());
  const std::uint64_t checkpoints = checkpoint_count(scene);
  const std::uint64_t bytes = frames * frame_bytes(scene) + checkpoints * checkpoint_bytes(scene);
  const std::string_view integrator = scene::name(setup.integrator);
  std::vector<std::string_view> obstacles;
  for (const models::Obstacle& obstacle : setup.obstacles) {
    obstacles.push_back(scene::name(obstacle.shape));
  }
  const double end = setup.t0 + static_cast<double>(scene.steps) * setup.dt;
  if (options.json) {
    Json emitters = Json::array();
    for (const Emitter& emitter : setup.emitters) {
      emitters.push_back(emitter_document(emitter, setup));
    }
    print_json({{"scene", scene_identity(scene)},
                {"title", scene.title},
                {"precision", scene::name(setup.precision)},
                {"seed", setup.seed},
                {"integrator", integrator},
                {"forces", forces_of(setup.forces)},
                {"obstacles", obstacles},
                {"contact_law", law_document(scene)},
                {"emitters", emitters},
                {"particles", particles},
                {"dt", setup.dt},
                {"steps", scene.steps},
                {"time_begin", setup.t0},
                {"time_end", end},
                {"memory_bytes", run_bytes(scene, true)},
                {"frames",
                 {{"count", frames},
                  {"every", scene.frames.every},
                  {"columns", column_names(scene.frames)},
                  {"fraction", scene.frames.fraction},
                  {"bytes_each", frame_bytes(scene)}}},
                {"checkpoints",
                 {{"count", checkpoints},
                  {"bytes_each", checkpoint_bytes(scene)},
                  {"resumable_when_killed", leaves_full_states(scene)}}},
                {"bytes", bytes}});
    return;
  }
  print(fmt::format("{}{}{}\n", scene.path, scene.title.empty() ? "" : ": ", scene.title));
  print(line("particles", fmt::format("{}, {} precision, seed {}", grouped(particles),
                                      scene::name(setup.precision), setup.seed)));
  for (const Emitter& emitter : setup.emitters) {
    const solver::EmissionSchedule schedule(emitter, setup.t0, setup.dt);
    print(line(
        "", fmt::format("{} {}: {} at {:g} s (stream {})", scene::name(emitter.kind), emitter.name,
                        grouped(schedule.total()), emitter.time, emitter.stream)));
  }
  const std::vector<std::string> forces = forces_of(setup.forces);
  print(line("forces", forces.empty() ? "none" : fmt::format("{}", fmt::join(forces, ", "))));
  print(line("obstacles",
             obstacles.empty() ? "none" : fmt::format("{}", fmt::join(obstacles, ", "))));
  if (setup.contact_law) print(line("contacts", law_text(*setup.contact_law)));
  print(line("time", fmt::format("{:g} s to {:g} s, {} of {:g} s, {}", setup.t0, end,
                                 counted(static_cast<std::uint64_t>(scene.steps), "step"), setup.dt,
                                 integrator)));
  if (setup.contact_law) print(line("", "dt is " + step_text(scene)));
  print(line(
      "frames",
      fmt::format("{}, one every {}, {} each: {}{}", grouped(frames),
                  counted(static_cast<std::uint64_t>(scene.frames.every), "step"),
                  bytes_text(frame_bytes(scene)), fmt::join(column_names(scene.frames), ", "),
                  scene.frames.fraction < 1
                      ? fmt::format(" of {:.3g} % of the particles", 100 * scene.frames.fraction)
                      : "")));
  print(line("checkpoints", fmt::format("{}, {} each", grouped(checkpoints),
                                        bytes_text(checkpoint_bytes(scene)))));
  if (!leaves_full_states(scene)) {
    print(line("", "none on the way (checkpoint.every): when killed, it starts again at step 0"));
  }
  print(line("recording", fmt::format("about {} when all particles are alive", bytes_text(bytes))));
  print(line("memory", bytes_text(run_bytes(scene, true))));
  print(line("digest", to_string(scene::scene_digest(scene))));
}

// An object a key, and after it those of the section that it is.
void add_keys(const scene::SectionText& section, Json& keys) {
  for (const scene::KeyText* key : section.keys()) {
    Json object = {{"section", section.path()}, {"key", key->name}};
    if (key->section) {
      object["type"] = key->section->label();
      object["meaning"] = key->section->meaning();
    } else {
      object["type"] = key->type;
      object["unit"] = key->unit;
      std::string fallback = key->fallback;
      std::erase(fallback, '`');  // of Markdown
      object["default"] = fallback;
      object["bounds"] = key->bounds.text("");
      object["meaning"] = key->meaning;
    }
    object["required"] = key->required != 0;
    if (!key->words.empty()) {
      Json words = Json::array();
      for (const scene::Word& word : key->words) words.push_back(word.word);
      object["words"] = words;
    }
    keys.push_back(std::move(object));
    if (key->section) add_keys(*key->section, keys);
  }
}

}  // namespace

ExitStatus info(const Options& options) {
  if (options.keys) {
    if (options.json) {
      Json keys = Json::array();
      add_keys(scene::scene_section(), keys);
      Json sweep_keys = Json::array();
      add_keys(scene::sweep_section(), sweep_keys);
      print_json({{"keys", keys}, {"trajectory_keys", sweep_keys}});
    } else {
      print(scene::key_reference());
    }
  } else if (options.inputs.empty()) {
    describe_machine(options);
  } else {
    const scene::AnyScene any = load_scene(options.inputs.front(), options);
    if (const auto* sweep = std::get_if<scene::SweepScene>(&any)) {
      describe_sweep(options, *sweep);
    } else {
      describe_scene(std::get<scene::Scene>(any), options);
    }
  }
  return ExitStatus::done;
}

}  // namespace salvo::cli
