// Reports for machines: --json prints exactly one document on stdout.
#pragma once

#include <nlohmann/json.hpp>

#include "scene/scene.hpp"
#include "solver/world.hpp"

namespace salvo::cli {

/// Keys stay in the order in which they are written here; numbers that are not finite become null.
using Json = nlohmann::ordered_json;

void print_json(const Json& document);

Json json_of(const solver::StateHash& hash);
Json json_of(const solver::Diagnostics& diagnostics);
Json json_of(const solver::Execution& execution);
Json json_of(const solver::BadRow& row);
Json json_of(const solver::Removals& removals);
/// Path, digest, contract and version.
Json scene_identity(const scene::Scene& scene);
/// Keys "id", "stream" and "serial".
void add_id(Json& object, soa::Id id);

}  // namespace salvo::cli
