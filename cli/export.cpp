// salvo export: recorded frames in the formats of other programs.
#include "recording/export.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "cli/json.hpp"
#include "cli/progress.hpp"
#include "cli/sweep_verbs.hpp"
#include "cli/terminal.hpp"
#include "cli/text.hpp"
#include "cli/verbs.hpp"
#include "recording/directory.hpp"
#include "recording/frame_reader.hpp"

namespace salvo::cli {

namespace {

namespace fs = std::filesystem;
using recording::ExportFormat;

// The one file that is meant: named itself, or by its number; nothing for all frames of a
// recording.
std::optional<fs::path> single_file(const fs::path& input, const Options& options) {
  if (fs::is_regular_file(input)) {
    if (options.frame) {
      throw UsageError(fmt::format("{} is one frame", input.string()), "leave out --frame");
    }
    return input;
  }
  if (!fs::is_directory(input)) {
    throw Failure(ExitStatus::input_output, fmt::format("{}: no such recording", input.string()),
                  "salvo run records into out/NAME OF THE SCENE unless told otherwise");
  }
  const auto frames = recording::list_frames(input);
  if (frames.empty()) {
    throw Failure(ExitStatus::input_output, fmt::format("{} holds no frames", input.string()));
  }
  if (!options.frame) return std::nullopt;
  for (const recording::NumberedFile& frame : frames) {
    if (frame.number == *options.frame) return frame.path;
  }
  throw UsageError(
      fmt::format("{} has no frame {}", input.string(), *options.frame),
      fmt::format("its frames go from {} to {}", frames.front().number, frames.back().number));
}

// One frame as data.
void print_frame(const fs::path& path, const Options& options) {
  recording::Frame frame = recording::read_frame(path);
  if (!options.columns.empty()) recording::select_columns(frame, options.columns);
  const recording::Sink sink = [](std::string_view bytes) { print(bytes); };
  switch (options.format) {
    case ExportFormat::csv:
      recording::write_csv(frame, sink);
      break;
    case ExportFormat::ply:
      recording::write_ply(frame, sink);
      break;
    case ExportFormat::npy:
      if (frame.columns.size() != 1) {
        throw UsageError("an NPY file holds one column", "name it: --columns position");
      }
      recording::write_npy(frame, frame.columns.front(), sink);
      break;
  }
}

}  // namespace

ExitStatus export_frames(const Options& options) try {
  const fs::path input = options.inputs.front();
  if (fs::is_directory(input) && !recording::list_parts(input).empty()) {
    return export_sweep(options);
  }
  const std::optional<fs::path> single = single_file(input, options);
  if (options.out == "-") {
    if (options.json) throw UsageError("--out - and --json both write to stdout");
    if (!single) throw UsageError("--out - writes one frame", "name it: --frame 0");
    print_frame(*single, options);
    return ExitStatus::done;
  }
  const fs::path folder = fs::is_directory(input) ? input : input.parent_path();
  const fs::path directory = options.out.value_or(folder / name(options.format));
  Progress progress(options.quiet);
  std::uint64_t bytes = 0;
  recording::ExportOptions settings;
  settings.format = options.format;
  settings.columns = options.columns;
  settings.progress = [&](const recording::ExportProgress& at) {
    bytes = at.bytes_written;
    progress.update(static_cast<double>(at.frames_done) / static_cast<double>(at.frames), [&] {
      return fmt::format("frame {} of {}  {} written", at.frames_done, at.frames,
                         bytes_text(at.bytes_written));
    });
  };
  const std::vector<fs::path> written = single
                                            ? recording::export_frame(*single, directory, settings)
                                            : recording::export_frames(input, directory, settings);
  progress.clear();
  if (options.json) {
    Json files = Json::array();
    for (const fs::path& path : written) files.push_back(path.string());
    print_json({{"status", "done"},
                {"format", name(options.format)},
                {"directory", directory.string()},
                {"bytes_written", bytes},
                {"files", files}});
  } else {
    print(fmt::format("{}, {} in {}\n", counted(written.size(), "file"), bytes_text(bytes),
                      directory.string()));
  }
  return ExitStatus::done;
} catch (const std::invalid_argument& error) {
  throw UsageError(error.what());  // a column that the frames lack
}

}  // namespace salvo::cli
