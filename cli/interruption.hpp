// Ctrl-C and SIGTERM: the first asks the run to stop and leave a checkpoint, the second ends the
// process at once.
#pragma once

namespace salvo::cli {

/// From here on, for the life of the process.
void catch_interruptions();
bool interrupted();

}  // namespace salvo::cli
