#include "cli/interruption.hpp"

#include <unistd.h>

#include <atomic>
#include <csignal>

#include "cli/exit_status.hpp"

namespace salvo::cli {

namespace {

std::atomic<int> signals{0};
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler touches it");

void on_signal(int) {
  if (signals.fetch_add(1) == 0) {
    // Without fmt or stdio: neither may be used in a signal handler.
    static constexpr char text[] = "\nsalvo: stopping; once more to stop at once\n";
    [[maybe_unused]] const auto written = write(STDERR_FILENO, text, sizeof text - 1);
  } else {
    _exit(static_cast<int>(ExitStatus::interrupted));
  }
}

}  // namespace

void catch_interruptions() {
  struct sigaction action = {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool interrupted() { return signals.load() > 0; }

}  // namespace salvo::cli
