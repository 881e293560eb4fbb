// What the commands tell of a sweep: to people in tables, to machines in JSON.
#pragma once

#include <string>
#include <vector>

#include "cli/json.hpp"
#include "scene/sweep_scene.hpp"

namespace salvo::cli {

Json scene_identity(const scene::SweepScene& scene);
Json json_of(const scene::SweepScene& scene, const solver::Sweep& sweep,
             const solver::Statistics& statistics, const std::vector<std::uint64_t>& outcomes);
/// Every column of the rows, and their samples.
Json json_of(const solver::Sweep& sweep, const solver::SweepRows& rows, double click);

std::string solved_text(const scene::SweepScene& scene);
std::string statistics_text(const scene::SweepScene& scene, const solver::Sweep& sweep,
                            const solver::Statistics& statistics,
                            const std::vector<std::uint64_t>& outcomes);
/// A line a field, a column a row; and the samples of the first row.
std::string rows_text(const solver::Sweep& sweep, const solver::SweepRows& rows, double click);

}  // namespace salvo::cli
