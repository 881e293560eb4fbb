#include "recording/run_report.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/utsname.h>

#include <array>
#include <cmath>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>

#include "recording/directory.hpp"
#include "recording/errors.hpp"
#include "recording/hdf5.hpp"
#include "recording/output_file.hpp"
#include "scene/words.hpp"

namespace salvo::recording {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::array status_names{"running", "done", "interrupted", "failed"};

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const auto colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

std::string operating_system() {
  utsname names{};
  if (uname(&names) != 0) return "unknown";
  return fmt::format("{} {} {}", names.sysname, names.release, names.machine);
}

Json to_json(const StateInfo& state) {
  Json fields;
  for (const solver::FieldDigest& field : state.hash.fields) {
    fields[std::string(field.field)] = to_string(field.digest);
  }
  return {{"step", state.step},
          {"time", state.time},
          {"particles", state.diagnostics.count},
          {"state_hash", to_string(state.hash.total)},
          {"field_hashes", fields},
          {"impacts", state.tally.impacts},
          {"rests", state.tally.rests},
          {"removed", state.removed}};
}

Json to_json(const solver::Removals& removals) {
  Json json{{"count", removals.count}, {"first", nullptr}};
  if (const auto& first = removals.first) {
    json["first"] = {{"id", first->id}, {"step", first->step}, {"column", first->column}};
  }
  return json;
}

Json versions() {
  return {{"salvo", SALVO_VERSION},
          {"contract", scene::contract_version},
          {"hdf5", hdf5::library_version()},
          {"compiler", __VERSION__}};
}

Json machine(const solver::Execution& execution) {
  return {{"isa", solver::name(execution.isa)},
          {"threads", execution.threads},
          {"pass_steps", execution.pass_steps},
          {"processor", processor()},
          {"system", operating_system()}};
}

// What every run has.
template <class Report>
Json head(const Report& report) {
  return {{"program", "salvo"},
          {"status", name(report.status)},
          {"reason", report.reason},
          {"command", report.command_line},
          {"versions", versions()}};
}

template <class Setup>
Json scene_of(const scene::SceneText& scene, const solver::Digest& digest, const Setup& setup) {
  return {{"path", scene.path},          {"title", scene.title},
          {"digest", to_string(digest)}, {"overrides", scene.overrides},
          {"seed", setup.seed},          {"precision", scene::name(setup.precision)}};
}

// Text of the user's that is not UTF-8 is shown as well as can be rather than refused.
void write(const std::filesystem::path& directory, const Json& json) {
  const std::string text = json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  write_file(directory / run_name, text, Durability::machine);
}

}  // namespace

std::string_view name(RunStatus status) { return status_names[static_cast<std::size_t>(status)]; }

void write_run_report(const std::filesystem::path& directory, const scene::Scene& scene,
                      const RunReport& report) {
  const double solved = report.wall_seconds - report.seconds_waited;
  Json json = head(report);
  json["scene"] = scene_of(scene, scene_digest(scene), scene.setup);
  json["scene"].update({{"steps", scene.steps}, {"dt", scene.setup.dt}});
  json.update(Json{
      {"result", report.last ? to_json(*report.last) : Json()},
      {"removed",
       {{"left_domain", to_json(report.left_domain)}, {"non_finite", to_json(report.non_finite)}}},
      {"machine", machine(report.execution)},
      {"timing",
       {{"started", report.started},
        {"wall_seconds", report.wall_seconds},
        {"seconds_waited_for_writing", report.seconds_waited},
        {"particle_steps", report.particle_steps},
        {"particle_steps_per_second",
         solved > 0 ? static_cast<double>(report.particle_steps) / solved : 0.0},
        {"frames", report.frames},
        {"bytes_written", report.bytes_written}}},
  });
  write(directory, json);
}

void write_sweep_report(const std::filesystem::path& directory, const scene::SweepScene& scene,
                        const SweepReport& report) {
  const double rate =
      report.wall_seconds > 0 ? static_cast<double>(report.rows_computed) / report.wall_seconds : 0;
  Json json = head(report);
  json["scene"] = scene_of(scene, row_digest(scene), scene.setup);
  json["scene"]["model"] = scene.model->name;
  json.update(
      Json{{"result", nullptr},
           {"sweep", {{"rows", report.rows}, {"hash", report.hash ? to_string(*report.hash) : ""}}},
           {"machine", machine(report.execution)},
           {"timing",
            {{"started", report.started},
             {"wall_seconds", report.wall_seconds},
             {"trajectories_per_second", rate},
             {"bytes_written", report.bytes_written}}}});
  write(directory, json);
}

std::string utc_now() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
}

std::optional<RecordedRun> read_run_report(const std::filesystem::path& directory) {
  const std::filesystem::path path = directory / run_name;
  if (!std::filesystem::exists(path)) return std::nullopt;
  std::ifstream file(path);
  try {
    const Json json = Json::parse(file);
    RecordedRun run;
    const auto status = json.at("status").get<std::string>();
    for (std::size_t i = 0; i < status_names.size(); ++i) {
      if (status == status_names[i]) run.status = static_cast<RunStatus>(i);
    }
    run.reason = json.at("reason").get<std::string>();
    run.version = json.at("versions").at("salvo").get<std::string>();
    run.scene_path = json.at("scene").at("path").get<std::string>();
    run.scene_digest = solver::digest_from(json.at("scene").at("digest").get<std::string>());
    if (const Json& result = json.at("result"); !result.is_null()) {
      run.step = result.at("step").get<std::int64_t>();
      run.state_hash = solver::digest_from(result.at("state_hash").get<std::string>());
    }
    if (const auto sweep = json.find("sweep"); sweep != json.end()) {
      run.rows = sweep->at("rows").get<std::uint64_t>();
    }
    return run;
  } catch (const std::exception& error) {
    throw CorruptFile(
        fmt::format("cannot read {}: not a report of salvo's: {}", path.string(), error.what()));
  }
}

}  // namespace salvo::recording
