#include "cli/run_profile.hpp"

#include <fmt/format.h>

#include "cli/text.hpp"

namespace salvo::cli {

namespace {

double ratio(double a, double b) { return b > 0 ? a / b : 0; }
double ratio(std::uint64_t a, std::uint64_t b) {
  return ratio(static_cast<double>(a), static_cast<double>(b));
}

// Particles whose lists a build makes; those that there were on average.
double rows_of(const RunProfile& profile, const solver::ContactProfile& contacts) {
  return ratio(profile.world.particle_steps(), contacts.steps);
}

}  // namespace

std::string profile_text(const RunProfile& profile) {
  const double all = profile.stepping + profile.recording;
  std::string text = "where the time went\n";
  const auto add = [&](std::string_view what, double seconds, const std::string& more = {}) {
    text += fmt::format("  {:<20} {:>10}  {:>5.1f} %  {}\n", what, seconds_text(seconds),
                        100 * ratio(seconds, all), more);
  };
  const auto steps = static_cast<double>(profile.world.particle_steps());
  add("stepping", profile.stepping, rate_text(ratio(steps, profile.stepping)));
  if (const solver::ContactProfile* contacts = profile.world.contact_profile()) {
    const double rows = rows_of(profile, *contacts);
    const double listed = rows * static_cast<double>(contacts->list_builds);
    add("  forces and motion", contacts->step_seconds,
        fmt::format("{:.3g} ns a particle and step", 1e9 * ratio(contacts->step_seconds, steps)));
    add("  neighbor lists", contacts->list_seconds,
        fmt::format("anew every {:.3g} steps, {:.3g} neighbors a particle in {:.3g} slots",
                    ratio(contacts->steps, contacts->list_builds),
                    ratio(static_cast<double>(contacts->list_entries), listed),
                    ratio(static_cast<double>(contacts->list_slots), listed)));
    add("  sorting by cells", contacts->sort_seconds,
        fmt::format("every {:.3g} steps", ratio(contacts->steps, contacts->sorts)));
  }
  add("recording", profile.recording);
  add("  waiting for files", profile.waiting);
  if (const solver::ContactProfile* contacts = profile.world.contact_profile()) {
    add("to and from tables", contacts->transfer_seconds, "of both");
  }
  text.pop_back();
  return text;
}

Json profile_document(const RunProfile& profile) {
  Json document = {{"stepping_seconds", profile.stepping},
                   {"recording_seconds", profile.recording},
                   {"waiting_seconds", profile.waiting},
                   {"particle_steps_per_second",
                    ratio(static_cast<double>(profile.world.particle_steps()), profile.stepping)},
                   {"contacts", nullptr}};
  if (const solver::ContactProfile* contacts = profile.world.contact_profile()) {
    const double listed = rows_of(profile, *contacts) * static_cast<double>(contacts->list_builds);
    document["contacts"] = {
        {"step_seconds", contacts->step_seconds},
        {"list_seconds", contacts->list_seconds},
        {"sort_seconds", contacts->sort_seconds},
        {"transfer_seconds", contacts->transfer_seconds},
        {"steps", contacts->steps},
        {"list_builds", contacts->list_builds},
        {"steps_per_build", ratio(contacts->steps, contacts->list_builds)},
        {"sorts", contacts->sorts},
        {"steps_per_sort", ratio(contacts->steps, contacts->sorts)},
        {"neighbors_per_particle", ratio(static_cast<double>(contacts->list_entries), listed)},
        {"slots_per_particle", ratio(static_cast<double>(contacts->list_slots), listed)}};
  }
  return document;
}

}  // namespace salvo::cli
