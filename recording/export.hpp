// Frames to other formats: CSV (shortest digits that read back exactly), NumPy (one file a field),
// PLY (binary, little-endian).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/errors.hpp"
#include "recording/frame.hpp"

namespace salvo::recording {

enum class ExportFormat { csv, npy, ply };

/// In the order of the enumeration; files end in them.
inline constexpr std::array<std::string_view, 3> export_formats{"csv", "npy", "ply"};
constexpr std::string_view name(ExportFormat format) {
  return export_formats[static_cast<std::size_t>(format)];
}

struct ExportProgress {
  std::uint64_t frames_done = 0;
  std::uint64_t frames = 0;
  std::uint64_t bytes_written = 0;
};

struct ExportOptions {
  ExportFormat format = ExportFormat::csv;
  std::vector<std::string> columns;  ///< field names; empty: all that the frame holds
  std::function<void(const ExportProgress&)> progress;  ///< called after every frame
};

/// Takes bytes of an exported file, in order.
using Sink = std::function<void(std::string_view bytes)>;

/// One header line with units, such as "id,position_x [m],..", then one line a particle.
void write_csv(const Frame& frame, const Sink& sink);
/// The NumPy array of one column: shape (rows) or (rows, components).
void write_npy(const Frame& frame, const FrameColumn& column, const Sink& sink);
/// Vertices x, y, z from the position, the other columns as properties; an id becomes id_low and
/// id_high, 32 bits each, because PLY has no wider integers. Throws std::invalid_argument for a
/// frame without positions.
void write_ply(const Frame& frame, const Sink& sink);

/// Keeps only the named columns, in that order. Throws std::invalid_argument, naming what the frame
/// has.
void select_columns(Frame& frame, const std::vector<std::string>& columns);

/// Exports one frame or checkpoint file into a directory, as NAME.csv, NAME.ply or NAME_FIELD.npy;
/// returns what was written. Throws CorruptFile, OutputError, std::invalid_argument.
std::vector<std::filesystem::path> export_frame(const std::filesystem::path& frame,
                                                const std::filesystem::path& directory,
                                                const ExportOptions& options);

/// Exports all frames of a recording, in order.
std::vector<std::filesystem::path> export_frames(const std::filesystem::path& recording,
                                                 const std::filesystem::path& directory,
                                                 const ExportOptions& options);

}  // namespace salvo::recording
