// What each command does. They throw what the library throws; main turns that into messages and
// exit statuses.
#pragma once

#include "cli/exit_status.hpp"
#include "cli/options.hpp"

namespace salvo::cli {

ExitStatus run(const Options& options);
ExitStatus verify(const Options& options);
ExitStatus validate(const Options& options);
ExitStatus info(const Options& options);
ExitStatus hash(const Options& options);
ExitStatus export_frames(const Options& options);
ExitStatus merge(const Options& options);

}  // namespace salvo::cli
