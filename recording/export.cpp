#include "recording/export.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "recording/directory.hpp"
#include "recording/frame_reader.hpp"
#include "recording/output_file.hpp"

namespace salvo::recording {

namespace {

constexpr std::size_t block_bytes = std::size_t{1} << 20;
constexpr std::array component_names{"x", "y", "z"};

// Gathers small pieces into blocks for the sink.
class Block {
 public:
  explicit Block(const Sink& sink) : sink_(sink) { text_.reserve(block_bytes + 4096); }
  ~Block() = default;
  std::string& text() { return text_; }
  void pass_on_when_full() {
    if (text_.size() >= block_bytes) pass_on();
  }
  void pass_on() {
    if (!text_.empty()) sink_(text_);
    text_.clear();
  }

 private:
  const Sink& sink_;
  std::string text_;
};

// Calls visit with a value of the type that the column holds.
template <class Visit>
auto with_type(const FrameColumn& column, soa::Precision precision, Visit visit) {
  switch (column.scalar) {
    case soa::Scalar::int32:
      return visit(std::int32_t{});
    case soa::Scalar::uint32:
      return visit(std::uint32_t{});
    case soa::Scalar::uint64:
      return visit(std::uint64_t{});
    case soa::Scalar::real:
      break;
  }
  return precision == soa::Precision::float32 ? visit(float{}) : visit(double{});
}

std::string component_name(const FrameColumn& column, std::size_t component) {
  return column.components == 1 ? column.name
                                : fmt::format("{}_{}", column.name, component_names[component]);
}

template <class T>
void append_number(std::string& text, const std::byte* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  text.append(digits.data(), end.ptr);
}

std::size_t element_size(const FrameColumn& column, soa::Precision precision) {
  return size_of(column.scalar, precision);
}

}  // namespace

void write_csv(const Frame& frame, const Sink& sink) {
  using Append = void (*)(std::string&, const std::byte*);
  struct Cell {
    const std::byte* values;
    std::size_t stride;
    Append append;
    const std::vector<std::string>* words;
  };
  std::vector<Cell> cells;
  Block block(sink);
  for (const FrameColumn& column : frame.columns) {
    const std::size_t size = element_size(column, frame.info.precision);
    const Append append = with_type(column, frame.info.precision, [](auto value) -> Append {
      return append_number<decltype(value)>;
    });
    for (std::size_t c = 0; c < column.components; ++c) {
      block.text() += (cells.empty() ? "" : ",") + component_name(column, c);
      if (!column.unit.empty()) block.text() += fmt::format(" [{}]", column.unit);
      cells.push_back({column.values.data() + c * size, column.components * size, append,
                       column.words.empty() ? nullptr : &column.words});
    }
  }
  block.text() += '\n';
  for (std::size_t row = 0; row < frame.rows; ++row) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (i != 0) block.text() += ',';
      const Cell& cell = cells[i];
      const std::byte* value = cell.values + row * cell.stride;
      if (cell.words) {
        std::uint32_t word = 0;
        std::memcpy(&word, value, sizeof word);
        block.text() += cell.words->at(word);
      } else {
        cell.append(block.text(), value);
      }
    }
    block.text() += '\n';
    block.pass_on_when_full();
  }
  block.pass_on();
}

void write_npy(const Frame& frame, const FrameColumn& column, const Sink& sink) {
  const std::string type = with_type(column, frame.info.precision, [](auto value) {
    const char kind = std::is_floating_point_v<decltype(value)> ? 'f'
                      : std::is_signed_v<decltype(value)>       ? 'i'
                                                                : 'u';
    return fmt::format("<{}{}", kind, sizeof value);
  });
  const std::string shape = column.components == 1
                                ? fmt::format("({},)", frame.rows)
                                : fmt::format("({}, {})", frame.rows, column.components);
  std::string header =
      fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}", type, shape);
  // Magic, version 1.0, length of the header as 16 bits; the data start at a multiple of 64.
  constexpr std::size_t preamble = 10;
  constexpr std::size_t alignment = 64;
  header.append(alignment - 1 - (preamble + header.size()) % alignment, ' ');
  header += '\n';
  std::string start("\x93NUMPY\x01\x00", 8);
  start += static_cast<char>(header.size() & 0xff);
  start += static_cast<char>(header.size() >> 8);
  sink(start + header);
  if (!column.values.empty()) {
    sink({reinterpret_cast<const char*>(column.values.data()), column.values.size()});
  }
}

void write_ply(const Frame& frame, const Sink& sink) {
  const auto position = std::find_if(frame.columns.begin(), frame.columns.end(),
                                     [](const FrameColumn& c) { return c.name == "position"; });
  if (position == frame.columns.end()) {
    throw std::invalid_argument("a PLY file needs the column position");
  }
  std::vector<const FrameColumn*> columns{&*position};
  for (const FrameColumn& column : frame.columns) {
    if (&column != &*position) columns.push_back(&column);
  }

  Block block(sink);
  block.text() += fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment salvo step {} time {} s\nelement vertex {}\n",
      frame.info.step, frame.info.time, frame.rows);
  for (const FrameColumn* column : columns) {
    const std::string_view type =
        with_type(*column, frame.info.precision, [](auto value) -> std::string_view {
          using T = decltype(value);
          if (std::is_same_v<T, float>) return "float";
          if (std::is_same_v<T, double>) return "double";
          return std::is_signed_v<T> ? "int" : "uint";
        });
    for (std::size_t c = 0; c < column->components; ++c) {
      const std::string name =
          column == &*position ? component_names[c] : component_name(*column, c);
      if (column->scalar == soa::Scalar::uint64) {
        block.text() += fmt::format("property {0} {1}_low\nproperty {0} {1}_high\n", type, name);
      } else {
        block.text() += fmt::format("property {} {}\n", type, name);
      }
    }
  }
  block.text() += "end_header\n";
  for (std::size_t row = 0; row < frame.rows; ++row) {
    for (const FrameColumn* column : columns) {
      const std::size_t size = column->components * element_size(*column, frame.info.precision);
      block.text().append(reinterpret_cast<const char*>(column->values.data()) + row * size, size);
    }
    block.pass_on_when_full();
  }
  block.pass_on();
}

void select_columns(Frame& frame, const std::vector<std::string>& columns) {
  if (columns.empty()) return;
  std::vector<FrameColumn> selected;
  for (const std::string& name : columns) {
    const auto found = std::find_if(frame.columns.begin(), frame.columns.end(),
                                    [&](const FrameColumn& column) { return column.name == name; });
    if (found == frame.columns.end()) {
      std::string known;
      for (const FrameColumn& column : frame.columns) {
        known += (known.empty() ? "" : ", ") + column.name;
      }
      throw std::invalid_argument(
          fmt::format("no column \"{}\" in the frame; it has {}", name, known));
    }
    selected.push_back(*found);
  }
  frame.columns = std::move(selected);
}

namespace {

// Exports a frame and adds what was written to the progress.
std::vector<std::filesystem::path> export_one(const std::filesystem::path& path,
                                              const std::filesystem::path& directory,
                                              const ExportOptions& options,
                                              ExportProgress& progress) {
  Frame frame = read_frame(path);
  select_columns(frame, options.columns);
  ensure_directory(directory);
  const std::string stem = path.stem().string();
  std::vector<std::filesystem::path> written;
  const auto write = [&](const std::string& name, auto&& write_to) {
    OutputFile file(directory / name);
    write_to([&](std::string_view bytes) {
      file.write(bytes);
      progress.bytes_written += bytes.size();
    });
    file.commit();
    written.push_back(directory / name);
  };
  switch (options.format) {
    case ExportFormat::csv:
      write(stem + ".csv", [&](const Sink& sink) { write_csv(frame, sink); });
      break;
    case ExportFormat::ply:
      write(stem + ".ply", [&](const Sink& sink) { write_ply(frame, sink); });
      break;
    case ExportFormat::npy:
      for (const FrameColumn& column : frame.columns) {
        write(fmt::format("{}_{}.npy", stem, column.name),
              [&](const Sink& sink) { write_npy(frame, column, sink); });
      }
      break;
  }
  ++progress.frames_done;
  if (options.progress) options.progress(progress);
  return written;
}

}  // namespace

std::vector<std::filesystem::path> export_frame(const std::filesystem::path& frame,
                                                const std::filesystem::path& directory,
                                                const ExportOptions& options) {
  ExportProgress progress{0, 1, 0};
  return export_one(frame, directory, options, progress);
}

std::vector<std::filesystem::path> export_frames(const std::filesystem::path& recording,
                                                 const std::filesystem::path& directory,
                                                 const ExportOptions& options) {
  const std::vector<NumberedFile> frames = list_frames(recording);
  if (frames.empty()) {
    throw CorruptFile(fmt::format("cannot read {}: there are no frames in it", recording.string()));
  }
  ExportProgress progress{0, frames.size(), 0};
  std::vector<std::filesystem::path> written;
  for (const NumberedFile& frame : frames) {
    for (std::filesystem::path& path : export_one(frame.path, directory, options, progress)) {
      written.push_back(std::move(path));
    }
  }
  return written;
}

}  // namespace salvo::recording
