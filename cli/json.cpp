#include "cli/json.hpp"

#include "cli/terminal.hpp"
#include "solver/diagnostic_fields.hpp"

namespace salvo::cli {

void print_json(const Json& document) {
  // Text that is no UTF-8, as a path may be, is replaced rather than refused.
  print(document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  flush_output();
}

Json json_of(const solver::StateHash& hash) {
  Json fields = Json::object();
  for (const solver::FieldDigest& field : hash.fields) {
    fields[std::string(field.field)] = solver::to_string(field.digest);
  }
  return {{"total", solver::to_string(hash.total)}, {"fields", fields}};
}

Json json_of(const solver::Diagnostics& diagnostics) {
  Json object = Json::object();
  for_each_field(diagnostics, [&](std::string_view name, std::string_view, const auto& member) {
    object[name == "count" ? std::string("particles") : std::string(name)] = member;
  });
  return object;
}

Json json_of(const solver::Removals& removals) {
  Json object = {{"count", removals.count}, {"first", nullptr}};
  if (removals.first) object["first"] = json_of(*removals.first);
  return object;
}

Json json_of(const solver::Execution& execution) {
  return {{"isa", solver::name(execution.isa)},
          {"threads", execution.threads},
          {"pass_steps", execution.pass_steps}};
}

void add_id(Json& object, soa::Id id) {
  object["id"] = id;
  object["stream"] = soa::stream_of(id);
  object["serial"] = soa::serial_of(id);
}

Json json_of(const solver::BadRow& row) {
  Json object = {{"step", row.step}};
  add_id(object, row.id);
  object["column"] = row.column;
  object["value"] = row.value;
  object["reason"] = row.left_domain ? "left the domain" : "not finite";
  return object;
}

Json scene_identity(const scene::Scene& scene) {
  return {{"path", scene.path},
          {"overrides", scene.overrides},
          {"digest", solver::to_string(scene::scene_digest(scene))},
          {"version", SALVO_VERSION},
          {"contract", scene::contract_version}};
}

}  // namespace salvo::cli
