#include "recording/ownership.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>

#include "recording/directory.hpp"
#include "recording/frame_reader.hpp"
#include "recording/run_report.hpp"
#include "recording/sweep_part.hpp"

namespace salvo::recording {

std::optional<solver::Digest> recorded_scene(const std::filesystem::path& directory) {
  try {
    if (const auto run = read_run_report(directory)) return run->scene_digest;
  } catch (const CorruptFile&) {  // the frames know, too
  }
  for (const NumberedFile& part : list_parts(directory)) {
    try {
      return read_part_info(part.path).row_digest;
    } catch (const CorruptFile&) {  // the next one may be intact
    }
  }
  for (const auto& files : {list_checkpoints(directory), list_frames(directory)}) {
    for (const NumberedFile& file : files) {
      try {
        return read_frame_info(file.path).scene_digest;
      } catch (const CorruptFile&) {  // the next one may be intact
      }
    }
  }
  return std::nullopt;
}

void check_ownership(const std::filesystem::path& directory, const solver::Digest& scene) {
  const std::vector<std::filesystem::path> files = recording_files(directory);
  if (files.empty()) return;
  const auto recorded = recorded_scene(directory);
  if (!recorded) {
    throw ForeignRecording(fmt::format("{} exists and is not known to be a recording of salvo's",
                                       files.front().string()));
  }
  if (*recorded != scene) {
    throw ForeignRecording(
        fmt::format("{} holds the recording of another scene, or of this one with other settings "
                    "(digest {}, not {})",
                    directory.string(), to_string(*recorded), to_string(scene)));
  }
}

DirectoryLock::DirectoryLock(const std::filesystem::path& directory)
    : descriptor_(::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  // A file system without locks is no reason not to record.
  if (descriptor_ >= 0 && ::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    ::close(descriptor_);
    throw OutputError(
        fmt::format("cannot record into {}: another run is recording there", directory.string()));
  }
}

DirectoryLock::~DirectoryLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace salvo::recording
