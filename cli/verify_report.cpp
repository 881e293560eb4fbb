#include "cli/verify_report.hpp"

#include <fmt/format.h>

#include <cstdlib>

#include "cli/text.hpp"
#include "cli/text_table.hpp"

namespace salvo::cli {

namespace {

using scene::Difference;
using scene::VerifyResult;
using scene::VerifyRun;

// "0x1.8p+1 (3)": the bits, and the number for a person.
std::string with_decimal(const std::string& value) {
  if (value.find("0x") == std::string::npos) return value;
  return fmt::format("{} ({:.9g})", value, std::strtod(value.c_str(), nullptr));
}

std::string particle(soa::Id id) {
  return fmt::format("particle {} (stream {}, serial {})", id, soa::stream_of(id),
                     soa::serial_of(id));
}

// In a contact: another particle, or one of the smooth parts of all obstacles.
std::string partner(soa::Id id) {
  if (soa::stream_of(id) != soa::max_stream) return particle(id);
  return fmt::format("part {} of the obstacles", soa::serial_of(id));
}

std::string describe(const Difference& difference) {
  std::string text = difference.exact()
                         ? fmt::format("first difference at step {}", difference.step)
                         : fmt::format(
                               "differs at step {}, after equal bits at step {}, and not "
                               "again in single steps",
                               difference.step, difference.equal_step);
  text += fmt::format(": {}", difference.column);
  if (difference.id) text += " of " + particle(*difference.id);
  if (difference.partner) text += " and " + partner(*difference.partner);
  text += fmt::format("\n  reference  {}\n  here       {}\n", with_decimal(difference.reference),
                      with_decimal(difference.varied));
  if (difference.rows > 1) {
    text += fmt::format("  {} differ at this step\n",
                        counted(difference.rows, difference.partner ? "contact" : "particle"));
  }
  return text;
}

std::string of(std::uint64_t part, std::uint64_t whole) {
  return part == whole ? grouped(part) : fmt::format("{} of {}", grouped(part), grouped(whole));
}

std::string heading(const scene::Scene& scene, const scene::Scene& verified) {
  return fmt::format(
      "{}: {} particles, {} steps\n", scene.path,
      of(solver::World::total_emitted(verified.setup), solver::World::total_emitted(scene.setup)),
      of(static_cast<std::uint64_t>(verified.steps), static_cast<std::uint64_t>(scene.steps)));
}

std::string result_of(const VerifyRun& run, const VerifyRun& reference) {
  if (run.difference) return "DIFFERENT";
  if (&run == &reference) return "";
  return run.hash == reference.hash ? "equal" : "equal to the same particles";
}

std::string table_of(const VerifyResult& result) {
  TextTable table({"<axis", "<set to", "particles", "frames", "<hash of the last frame", "<"});
  for (const VerifyRun& run : result.runs) {
    table.add({std::string(name(run.axis)), run.value, grouped(run.rows), grouped(run.frames),
               to_string(run.hash), result_of(run, result.runs.front())});
  }
  return table.text();
}

}  // namespace

std::string verify_report(const scene::Scene& scene, const scene::Scene& verified,
                          const VerifyResult& result) {
  std::string text = heading(scene, verified) + table_of(result);
  for (const VerifyRun& run : result.runs) {
    if (!run.difference) continue;
    text += fmt::format("{} {}: {}", name(run.axis), run.value, describe(*run.difference));
  }
  return text;
}

ExitStatus verify_status(const VerifyResult& result) {
  if (!result.equal()) return ExitStatus::difference;
  return result.runs.front().stopped ? ExitStatus::numerical : ExitStatus::done;
}

}  // namespace salvo::cli
