#include "cli/terminal.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <system_error>

#include "cli/exit_status.hpp"

namespace salvo::cli {

namespace {

bool set_and_not_empty(const char* variable) {
  const char* value = std::getenv(variable);
  return value && *value;
}

// https://no-color.org
bool colored() { return stderr_is_terminal() && !set_and_not_empty("NO_COLOR"); }

void labelled(std::string_view label, const char* color, std::string_view text) {
  if (colored()) {
    say(fmt::format("salvo: \033[{}m{}:\033[0m {}", color, label, text));
  } else {
    say(fmt::format("salvo: {}: {}", label, text));
  }
}

[[noreturn]] void output_failed() {
  throw Failure(ExitStatus::input_output,
                fmt::format("cannot write to stdout: {}", std::generic_category().message(errno)));
}

}  // namespace

bool stderr_is_terminal() {
  const char* kind = std::getenv("TERM");
  return isatty(STDERR_FILENO) == 1 && kind && std::string_view(kind) != "dumb";
}

std::size_t terminal_columns() {
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  return 80;
}

void print(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size()) output_failed();
}

void flush_output() {
  if (std::fflush(stdout) != 0) output_failed();
}

void say(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fputc('\n', stderr);
}

void say_error(std::string_view problem, std::string_view hint) {
  labelled("error", "1;31", problem);
  if (!hint.empty()) say(fmt::format("  {}", hint));
}

void say_warning(std::string_view problem) { labelled("warning", "1;33", problem); }

}  // namespace salvo::cli
