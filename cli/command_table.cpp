#include "cli/command_table.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace salvo::cli {

namespace {

constexpr OptionEntry set{"--set", "", "KEY=VALUE",
                          "change a key of the scene, such as time.dt=1e-3 or emitter.0.count=1000",
                          true};
constexpr OptionEntry isa{"--isa", "", "NAME", "instruction set: scalar, sse2, avx2, avx512, neon"};
constexpr OptionEntry threads{"--threads", "", "N", "number of threads; the machine's by default"};
constexpr OptionEntry pass{"--pass", "", "STEPS", "steps a pass at most, 32 by default"};
constexpr OptionEntry json{"--json", "", "", "print one JSON document"};
constexpr OptionEntry quiet{"--quiet", "-q", "", "no progress and no notes, only the result"};
constexpr OptionEntry help{"--help", "-h", "", "print this help"};

std::string option_lines(std::span<const OptionEntry> options) {
  std::string text;
  for (const OptionEntry& option : options) {
    std::string left =
        option.short_name.empty() ? std::string("    ") : fmt::format("{}, ", option.short_name);
    left += option.name;
    if (!option.value.empty()) left += fmt::format(" {}", option.value);
    text += fmt::format("  {:<24} {}\n", left, option.help);
  }
  return text;
}

}  // namespace

std::span<const CommandEntry> commands() {
  static const std::vector<CommandEntry> table{
      {Verb::run,
       "run",
       "SCENE",
       "run a scene and record it",
       "Runs a scene and records its frames and checkpoints, or its trajectories, into a folder.\n"
       "Ctrl-C leaves a checkpoint\n"
       "that --resume goes on from, to the same files as without the interruption; a run that is "
       "killed\n"
       "goes on from its last checkpoint.\n"
       "The instruction set, threads and pass length change the speed and no bit of the result.",
       {{"--out", "-o", "DIR", "where to record; out/NAME OF THE SCENE by default"},
        {"--resume", "", "", "go on from the newest intact state in that folder"},
        {"--force", "-f", "", "replace another scene's recording"},
        {"--index", "", "N",
         "one row of a sweep, alone, with the bits that it has among the others"},
        {"--shard", "", "I/N",
         "the I-th of N equal shares of a sweep's rows; salvo merge joins them"},
        {"--profile", "", "", "say at the end where the time went; for scenes of particles"},
        set,
        isa,
        threads,
        pass,
        json,
        quiet,
        help},
       "  salvo run scenes/explosion.toml\n"
       "  salvo run scenes/explosion.toml --out /data/boom --threads 8\n"
       "  salvo run scenes/explosion.toml --set seed=7 --set emitter.0.count=5000\n"
       "  salvo run scenes/explosion.toml --out /data/boom --resume\n"
       "  salvo run scenes/dispersion.toml\n"
       "  salvo run scenes/dispersion.toml --index 123456\n"
       "  salvo run scenes/dispersion.toml --shard 2/8 --out /data/shard2\n"},
      {Verb::verify,
       "verify",
       "SCENE...",
       "check that the bits depend on the scene alone",
       "Runs a scene a dozen times, varying one thing at a time from the reference (scalar, one "
       "thread,\n"
       "one step a pass), and compares the state hash of every frame. On a difference it names the "
       "first\n"
       "step, column and particle, and exits with 6. Scenes run at their [verify] size.",
       {{"--isa", "", "NAMES", "instruction sets to try, such as sse2,avx2; all by default", true},
        {"--threads", "", "LIST", "numbers of threads; 2,3,4,8,13 by default", true},
        {"--pass", "", "LIST", "steps a pass, unless particles touch; 7,64 by default", true},
        {"--full", "", "", "the scene at its own size"},
        set,
        json,
        quiet,
        help},
       "  salvo verify scenes/explosion.toml\n"
       "  salvo verify scenes/*.toml --threads 2,13 --pass 7\n"},
      {Verb::validate,
       "validate",
       "SCENE...",
       "check scenes without running them",
       "Reads scenes and says everything that is wrong with them, in one go. Only a run finds who\n"
       "overlaps when emitted.",
       {set, json, help},
       "  salvo validate scenes/*.toml\n"},
      {Verb::info,
       "info",
       "[SCENE]",
       "what a scene is and takes, or what this machine offers",
       "With a scene: what it simulates, how much memory it takes, how many bytes its frames "
       "have.\n"
       "Without: version, instruction sets and threads of this machine, libraries.",
       {{"--keys", "", "", "print every key of a scene: unit, meaning, default, bounds"},
        set,
        json,
        help},
       "  salvo info scenes/explosion.toml\n"
       "  salvo info --keys\n"},
      {Verb::hash,
       "hash",
       "SCENE",
       "run a scene and print the state hash of every frame",
       "Runs a scene without recording it. Prints a line a frame: state hash, step, time; the last "
       "line\n"
       "is the state at the end.",
       {set, isa, threads, pass, json, quiet, help},
       "  salvo hash scenes/explosion.toml\n"
       "  salvo hash scenes/explosion.toml --isa scalar --threads 1\n"},
      {Verb::export_frames,
       "export",
       "DIR",
       "turn recorded frames into CSV, NPY or PLY",
       "Turns the frames of a recording, or one file of it, into files that other programs read.",
       {{"--format", "", "NAME", "csv, npy or ply"},
        {"--frame", "", "N", "this frame alone"},
        {"--columns", "", "NAMES", "such as id,position; all that were recorded by default", true},
        {"--out", "-o", "DIR",
         "where to write; a folder in DIR by default; - writes one frame to stdout"},
        json,
        quiet,
        help},
       "  salvo export out/explosion --format csv --frame 12 -o -\n"
       "  salvo export out/explosion --format npy --columns id,position\n"
       "  salvo export out/dispersion --format csv\n"},
      {Verb::merge,
       "merge",
       "DIR...",
       "put the shards of a sweep together",
       "Checks that the shards are of one scene and cover all its rows, copies them into one "
       "folder, "
       "and\n"
       "tells of them what one run of the whole sweep tells, with the same hash.",
       {{"--out", "-o", "DIR", "where the whole sweep goes"},
        {"--force", "-f", "", "replace another scene's recording"},
        json,
        quiet,
        help},
       "  salvo merge /data/shard1 /data/shard2 --out /data/dispersion\n"},
  };
  return table;
}

std::string general_help() {
  std::string text =
      "salvo: steps millions of particles and trajectories, with the same bits on every machine.\n"
      "\n"
      "usage: salvo COMMAND [OPTIONS]\n"
      "\n";
  for (const CommandEntry& command : commands()) {
    text += fmt::format("  {:<20} {}\n", fmt::format("{} {}", command.name, command.operands),
                        command.summary);
  }
  text +=
      "\n"
      "examples:\n"
      "  salvo run scenes/explosion.toml              records into out/explosion\n"
      "  salvo run scenes/dispersion.toml             a million trajectories and their statistics\n"
      "  salvo verify scenes/explosion.toml           the same bits however it is run?\n"
      "  salvo export out/explosion --format csv      frames as text\n"
      "\n"
      "salvo COMMAND --help says more; salvo --version prints the version.\n"
      "exit status: 0 done, 1 run failed, 2 usage, 3 scene invalid, 4 input or output,\n"
      "5 numerical, 6 verify found a difference, 130 interrupted and resumable\n";
  return text;
}

std::string help_of(const CommandEntry& command) {
  return fmt::format(
      "salvo {}: {}\n\nusage: salvo {} {} [OPTIONS]\n\n{}\n\noptions:\n{}\nexamples:\n{}",
      command.name, command.summary, command.name, command.operands, command.description,
      option_lines(command.options), command.examples);
}

}  // namespace salvo::cli
