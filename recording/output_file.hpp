// A file that is written beside its target, as ".NAME.partial", and renamed when complete: under
// its name there is the old file or the whole new one, never a part.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "recording/errors.hpp"

namespace salvo::recording {

/// What a file survives: the death of the process, or that of the machine too.
enum class Durability { process, machine };

class OutputFile {
 public:
  /// Throws OutputError, as all functions do.
  explicit OutputFile(std::filesystem::path target);
  /// Removes the partial file unless it was committed.
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(std::span<const std::byte> bytes);
  void write(std::string_view text);
  void commit(Durability durability = Durability::process);

 private:
  [[noreturn]] void fail(int error) const;

  std::filesystem::path target_;
  std::filesystem::path partial_;
  int descriptor_ = -1;
};

void write_file(const std::filesystem::path& target, std::string_view text,
                Durability durability = Durability::process);

/// Where a file is written until it is complete.
std::filesystem::path partial_path(const std::filesystem::path& target);

/// A copy under the target's name, complete or not there.
void copy_file(const std::filesystem::path& source, const std::filesystem::path& target);
void ensure_directory(const std::filesystem::path& directory);
void remove_file(const std::filesystem::path& path);

}  // namespace salvo::recording
