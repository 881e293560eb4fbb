#include "cli/diagnostics_table.hpp"

#include <fmt/format.h>

#include <cmath>

#include "cli/text.hpp"
#include "cli/text_table.hpp"

namespace salvo::cli {

namespace {

constexpr std::size_t most_lines = 12;

std::vector<std::size_t> shown_of(std::size_t frames) {
  std::vector<std::size_t> shown;
  const std::size_t lines = std::min(frames, most_lines);
  for (std::size_t i = 0; i < lines; ++i) {
    shown.push_back(lines == 1 ? 0 : i * (frames - 1) / (lines - 1));
  }
  return shown;
}

std::string number(double value) { return fmt::format("{:.6g}", value); }

}  // namespace

std::string diagnostics_tables(const std::vector<FrameLine>& frames) {
  if (frames.empty()) return {};
  TextTable energies({"frame", "step", "time s", "particles", "mass kg", "kinetic J", "potential J",
                      "max speed m/s", "impacts", "rests", "removed"});
  TextTable extents(
      {"frame", "momentum kg m/s", "y", "z", "lowest m", "y", "z", "highest m", "y", "z"});
  // Of particles that touch. Overlaps as parts of the smaller radius.
  TextTable touching({"frame", "pairs", "with obstacles", "partners each", "overlap max %",
                      "mean %", "turning J", "springs J", "damped J", "slipped J"});
  const std::vector<std::size_t> shown = shown_of(frames.size());
  for (const std::size_t index : shown) {
    const recording::StateInfo& state = frames[index].state;
    const solver::Diagnostics& d = state.diagnostics;
    const std::string frame = fmt::to_string(frames[index].frame);
    energies.add({frame, fmt::to_string(state.step), number(state.time), grouped(d.count),
                  number(d.mass), number(d.kinetic_energy), number(d.potential_energy),
                  number(d.max_speed), grouped(state.tally.impacts), grouped(state.tally.rests),
                  grouped(state.removed)});
    extents.add({frame, number(d.momentum[0]), number(d.momentum[1]), number(d.momentum[2]),
                 number(d.lowest[0]), number(d.lowest[1]), number(d.lowest[2]),
                 number(d.highest[0]), number(d.highest[1]), number(d.highest[2])});
    if (!d.contacts) continue;
    const solver::ContactDiagnostics& c = *d.contacts;
    const auto percent = [](double part) { return fmt::format("{:.3g}", 100 * part); };
    const auto heat = [](double loss) { return std::isnan(loss) ? "-" : number(loss); };
    touching.add({frame, grouped(c.pair_contacts), grouped(c.wall_contacts),
                  fmt::format("{:.3g}", c.mean_coordination), percent(c.max_relative_overlap),
                  percent(c.mean_relative_overlap), number(c.rotational_energy),
                  number(c.elastic_energy), heat(c.damping_loss), heat(c.friction_loss)});
  }
  std::string text = energies.text() + "\n" + extents.text();
  if (frames.front().state.diagnostics.contacts) text += "\n" + touching.text();
  if (shown.size() < frames.size()) {
    text += fmt::format("({} of {} frames; --json lists all)\n", shown.size(), frames.size());
  }
  return text;
}

}  // namespace salvo::cli
