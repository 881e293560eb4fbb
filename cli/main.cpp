// The salvo command: reads the command line, does what it says, turns every error into one message
// and an exit status.
#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <new>
#include <string_view>
#include <system_error>

#include "cli/json.hpp"
#include "cli/terminal.hpp"
#include "cli/verbs.hpp"
#include "recording/errors.hpp"
#include "recording/hdf5_table.hpp"
#include "scene/input_table.hpp"
#include "scene/load.hpp"

namespace salvo::cli {
namespace {

ExitStatus dispatch(const Options& options) {
  switch (options.verb) {
    case Verb::help:
      print(options.help_text);
      break;
    case Verb::version:
      print(fmt::format("salvo {}\n", SALVO_VERSION));
      break;
    case Verb::run:
      return run(options);
    case Verb::verify:
      return verify(options);
    case Verb::validate:
      return validate(options);
    case Verb::info:
      return info(options);
    case Verb::hash:
      return hash(options);
    case Verb::export_frames:
      return export_frames(options);
    case Verb::merge:
      return merge(options);
  }
  return ExitStatus::done;
}

// With --json the document says what went wrong, so that stdout holds exactly one on every way out.
ExitStatus failed(bool json, ExitStatus status, std::string_view problem,
                  std::string_view hint = {}) {
  say_error(problem, hint);
  if (json) {
    print_json({{"status", "failed"},
                {"exit_status", static_cast<int>(status)},
                {"error", {{"message", problem}, {"hint", hint}}}});
  }
  return status;
}

ExitStatus invalid(bool json, const scene::SceneError& error) {
  for (const std::string& mistake : error.mistakes()) say(mistake);
  if (json) {
    print_json({{"status", "failed"},
                {"exit_status", static_cast<int>(ExitStatus::scene_invalid)},
                {"error", {{"message", error.what()}, {"mistakes", error.mistakes()}}}});
  }
  return ExitStatus::scene_invalid;
}

ExitStatus guarded(int argc, char** argv) {
  const bool json = std::any_of(argv, argv + argc, [](const char* argument) {
    return std::string_view(argument) == "--json";
  });
  try {
    const ExitStatus status = dispatch(parse(argc, argv));
    flush_output();
    return status;
  } catch (const Failure& error) {
    return failed(json, error.status(), error.what(), error.hint());
  } catch (const scene::SceneError& error) {
    return invalid(json, error);
  } catch (const solver::NumericalError& error) {
    return failed(json, ExitStatus::numerical, error.what());
  } catch (const solver::OverlapAtBirth& error) {
    return failed(json, ExitStatus::scene_invalid, error.what(), error.hint());
  } catch (const recording::StateMismatch& error) {
    return failed(json, ExitStatus::run_failed, error.what());
  } catch (const recording::RecordingError& error) {
    return failed(json, ExitStatus::input_output, error.what());
  } catch (const std::system_error& error) {
    return failed(json, ExitStatus::input_output, error.what());
  } catch (const std::bad_alloc&) {
    return failed(json, ExitStatus::run_failed, "out of memory",
                  "salvo info SCENE says how much a scene takes");
  } catch (const std::exception& error) {
    return failed(json, ExitStatus::run_failed, error.what());
  }
}

}  // namespace
}  // namespace salvo::cli

int main(int argc, char** argv) {
  salvo::scene::open_hdf5_tables_with(&salvo::recording::open_hdf5_table);
  try {
    return static_cast<int>(salvo::cli::guarded(argc, argv));
  } catch (const std::exception& error) {  // stdout is gone
    salvo::cli::say_error(error.what());
    return static_cast<int>(salvo::cli::ExitStatus::input_output);
  }
}
