#include "recording/output_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

namespace salvo::recording {

namespace {

std::string describe(int error) { return std::generic_category().message(error); }

// The name of the new file is safe only when the directory is, too. File systems that cannot do it
// do it by themselves.
void sync_directory(const std::filesystem::path& directory) {
  const int descriptor = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

std::filesystem::path directory_of(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

}  // namespace

std::filesystem::path partial_path(const std::filesystem::path& target) {
  return directory_of(target) / ("." + target.filename().string() + ".partial");
}

OutputFile::OutputFile(std::filesystem::path target)
    : target_(std::move(target)), partial_(partial_path(target_)) {
  constexpr mode_t readable = 0666;  // less the umask
  descriptor_ = ::open(partial_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, readable);
  if (descriptor_ < 0) fail(errno);
}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!partial_.empty()) ::unlink(partial_.c_str());
}

void OutputFile::write(std::span<const std::byte> bytes) {
  constexpr std::size_t at_once = std::size_t{1} << 30;
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), std::min(bytes.size(), at_once));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(errno);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void OutputFile::write(std::string_view text) { write(std::as_bytes(std::span(text))); }

void OutputFile::commit(Durability durability) {
  if (durability == Durability::machine && ::fsync(descriptor_) != 0) fail(errno);
  // Some file systems tell only now that the disk is full.
  if (::close(std::exchange(descriptor_, -1)) != 0) fail(errno);
  if (std::rename(partial_.c_str(), target_.c_str()) != 0) fail(errno);
  partial_.clear();
  if (durability == Durability::machine) sync_directory(directory_of(target_));
}

void OutputFile::fail(int error) const {
  throw OutputError(fmt::format("cannot write {}: {}", target_.string(), describe(error)), error);
}

void write_file(const std::filesystem::path& target, std::string_view text, Durability durability) {
  OutputFile file(target);
  file.write(text);
  file.commit(durability);
}

void copy_file(const std::filesystem::path& source, const std::filesystem::path& target) {
  const std::filesystem::path partial = partial_path(target);
  std::error_code error;
  std::filesystem::copy_file(source, partial, std::filesystem::copy_options::overwrite_existing,
                             error);
  if (!error) std::filesystem::rename(partial, target, error);
  if (!error) return;
  std::error_code ignored;
  std::filesystem::remove(partial, ignored);
  throw OutputError(fmt::format("cannot write {}: {}", target.string(), error.message()),
                    error.value());
}

void ensure_directory(const std::filesystem::path& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (!error && !std::filesystem::is_directory(directory, error) && !error) {
    error = std::make_error_code(std::errc::not_a_directory);
  }
  if (error) {
    throw OutputError(
        fmt::format("cannot create directory {}: {}", directory.string(), error.message()),
        error.value());
  }
}

void remove_file(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::remove(path, error);
  if (error) {
    throw OutputError(fmt::format("cannot remove {}: {}", path.string(), error.message()),
                      error.value());
  }
}

}  // namespace salvo::recording
