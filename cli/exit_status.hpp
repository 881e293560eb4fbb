// How the command ends: its exit status, and the errors that lead to one. Every error is said once,
// in one form, by main.
#pragma once

#include <stdexcept>
#include <string>

namespace salvo::cli {

enum class ExitStatus : int {
  done = 0,
  run_failed = 1,
  usage = 2,
  scene_invalid = 3,
  input_output = 4,
  numerical = 5,
  difference = 6,
  interrupted = 130,  ///< and resumable
};

/// An error with its exit status. what() says what is the matter; hint(), if any, what to do.
class Failure : public std::runtime_error {
 public:
  Failure(ExitStatus status, const std::string& problem, std::string hint = {})
      : std::runtime_error(problem), status_(status), hint_(std::move(hint)) {}
  ExitStatus status() const { return status_; }
  const std::string& hint() const { return hint_; }

 private:
  ExitStatus status_;
  std::string hint_;
};

/// A mistake on the command line.
class UsageError : public Failure {
 public:
  explicit UsageError(const std::string& problem, std::string hint = {})
      : Failure(ExitStatus::usage, problem, std::move(hint)) {}
};

}  // namespace salvo::cli
