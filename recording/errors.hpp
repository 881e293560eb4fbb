// What can go wrong with files. Every message is complete: it names the file and says what is the
// matter.
#pragma once

#include <cerrno>
#include <stdexcept>
#include <string>

namespace salvo::recording {

class RecordingError : public std::runtime_error {
  using runtime_error::runtime_error;
};

/// A file or directory cannot be written: disk full, no permission, a name that is taken.
class OutputError : public RecordingError {
 public:
  /// `error` is the system's errno where it gave one.
  explicit OutputError(const std::string& message, int error = 0)
      : RecordingError(message), error_(error) {}
  /// The disk, a quota or the largest size of a file is full.
  bool no_room() const { return error_ == ENOSPC || error_ == EDQUOT || error_ == EFBIG; }

 private:
  int error_;
};

/// A file that is missing, truncated, altered, or not a recording of salvo's.
class CorruptFile : public RecordingError {
  using RecordingError::RecordingError;
};

/// The directory holds the recording of another scene, or files that salvo did not write.
class ForeignRecording : public RecordingError {
  using RecordingError::RecordingError;
};

/// The directory holds more rows of the same sweep than are asked for.
class LongerRecording : public RecordingError {
  using RecordingError::RecordingError;
};

/// A recomputed state has another hash than the recording says: another salvo wrote it, or the
/// machine errs.
class StateMismatch : public RecordingError {
  using RecordingError::RecordingError;
};

}  // namespace salvo::recording
