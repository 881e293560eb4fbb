// The golden hashes: runs scenes and compares their bits with those that are committed, on any
// compiler, instruction set and processor family.
//
//   salvo_hashes [--isa NAME|all] [--threads N] --check|--write FILE SCENE...
//
// A scene runs at golden size: scaled as for verify, to as many particles as make a million
// particle-steps (at least 64), so that all shipped scenes together take under a minute of one core
// without optimisation, and no step is left out. FILE has, for each scene, a line with its path,
// precision, the digest of all frame hashes and the hash of the last frame, and under it the first
// four digits of every frame's hash, by which the first frame that differs is found.
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "scene/load_sweep.hpp"
#include "solver/world.hpp"

namespace {

using salvo::scene::Scene;
using salvo::solver::Isa;

constexpr std::uint64_t golden_particle_steps = 1'000'000;
constexpr std::uint64_t fewest_rows = 64;
constexpr std::size_t mark_digits = 4;
constexpr std::size_t marks_a_line = 24;

struct Options {
  std::vector<Isa> isas{salvo::solver::widest_isa()};
  int threads = salvo::solver::hardware_threads();
  bool write = false;
  std::string file;
  std::vector<std::string> scenes;
};

struct Hashes {
  std::string precision;
  std::string frames;              // digest of all frame hashes
  std::string last;                // hash of the last frame
  std::vector<std::string> marks;  // start of each frame's hash

  friend bool operator==(const Hashes&, const Hashes&) = default;
};

using Golden = std::map<std::string, Hashes>;

[[noreturn]] void usage(const std::string& problem) {
  std::cerr
      << "salvo_hashes: " << problem
      << "\nusage: salvo_hashes [--isa NAME|all] [--threads N] --check|--write FILE SCENE...\n";
  std::exit(2);
}

Options options_of(const std::vector<std::string>& arguments) {
  Options options;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    if (!argument.starts_with("--")) {
      options.scenes.push_back(argument);
      continue;
    }
    if (i + 1 == arguments.size()) usage(argument + " needs a value");
    const std::string& value = arguments[++i];
    if (argument == "--isa" && value == "all") {
      options.isas = salvo::solver::available_isas();
    } else if (argument == "--isa") {
      const auto isa = salvo::solver::isa_named(value);
      if (!isa) usage("unknown instruction set \"" + value + "\"");
      options.isas = {*isa};
    } else if (argument == "--threads") {
      const char* end = value.data() + value.size();
      if (std::from_chars(value.data(), end, options.threads).ptr != end || options.threads < 1) {
        usage("--threads needs a number from 1 on");
      }
    } else if (argument == "--check" || argument == "--write") {
      options.write = argument == "--write";
      options.file = value;
    } else {
      usage("unknown option " + argument);
    }
  }
  if (options.file.empty() || options.scenes.empty()) usage("needs --check or --write, and scenes");
  return options;
}

// "scenes/book/x.toml" from wherever the program was started.
std::string name_of(const std::string& path) {
  const std::size_t at = path.rfind("scenes/");
  return at == std::string::npos ? path : path.substr(at);
}

Scene golden_size(Scene scene) {
  const std::uint64_t rows =
      golden_particle_steps / static_cast<std::uint64_t>(std::max<std::int64_t>(scene.steps, 1));
  scene.verify.rows = std::max(rows, fewest_rows);
  scene.verify.steps = 0;
  return salvo::scene::scaled_for_verify(scene);
}

Hashes run(const Scene& scene, Isa isa, int threads) {
  Hashes hashes;
  hashes.precision = scene.setup.precision == salvo::soa::Precision::float32 ? "float" : "double";
  salvo::solver::Execution execution;
  execution.isa = isa;
  execution.threads = threads;
  salvo::solver::World world(scene.setup, execution);
  std::string all;
  for (std::int64_t step = 0; step <= scene.steps; step += scene.frames.every) {
    world.advance_to(step);
    hashes.last = to_string(world.hash().total);
    hashes.marks.push_back(hashes.last.substr(0, mark_digits));
    all += hashes.last;
  }
  hashes.frames = to_string(salvo::solver::digest_of(all.data(), all.size()));
  return hashes;
}

// Of a scene of trajectories: pieces of its first rows instead of frames.
constexpr std::uint64_t golden_rows = 2048;
constexpr std::uint64_t golden_piece = 128;

Hashes run(const salvo::scene::SweepScene& scene, Isa isa, int threads) {
  Hashes hashes;
  hashes.precision = scene.setup.precision == salvo::soa::Precision::float32 ? "float" : "double";
  const salvo::solver::Sweep sweep(scene.setup);
  const std::uint64_t rows = std::min(sweep.rows(), golden_rows);
  std::string all;
  for (std::uint64_t first = 0; first < rows; first += golden_piece) {
    const auto piece = sweep.run(first, std::min(golden_piece, rows - first), {isa, threads, 1});
    hashes.last = to_string(piece.hash(salvo::solver::Parallel(1)));
    hashes.marks.push_back(hashes.last.substr(0, mark_digits));
    all += hashes.last;
  }
  hashes.frames = to_string(salvo::solver::digest_of(all.data(), all.size()));
  return hashes;
}

// A scene at golden size, whatever it is of.
struct GoldenScene {
  explicit GoldenScene(const std::string& path) : scene(salvo::scene::load_any(path)) {
    if (auto* particles = std::get_if<Scene>(&scene)) *particles = golden_size(*particles);
  }
  Hashes run(Isa isa, int threads) const {
    return std::visit([&](const auto& either) { return ::run(either, isa, threads); }, scene);
  }
  std::uint64_t rows() const {
    if (const auto* sweep = std::get_if<salvo::scene::SweepScene>(&scene)) {
      return std::min(salvo::solver::Sweep(sweep->setup).rows(), golden_rows);
    }
    return salvo::solver::World::total_emitted(std::get<Scene>(scene).setup);
  }
  std::int64_t steps() const {
    const auto* particles = std::get_if<Scene>(&scene);
    return particles ? particles->steps : 0;
  }

  salvo::scene::AnyScene scene;
};

Golden read_golden(const std::string& path) {
  std::ifstream file(path);
  if (!file) {
    std::cerr << "salvo_hashes: cannot read " << path << '\n';
    std::exit(4);
  }
  Golden golden;
  Hashes* current = nullptr;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    if (line.empty() || line[0] == '#') continue;
    if (line[0] != ' ') {
      std::string scene;
      words >> scene;
      current = &golden[scene];
      words >> current->precision >> current->frames >> current->last;
    } else if (current) {
      for (std::string mark; words >> mark;) current->marks.push_back(mark);
    }
  }
  return golden;
}

void write_golden(const std::string& path, const Golden& golden) {
  std::ofstream file(path);
  file << "# Golden hashes: the bits of the shipped scenes at golden size (tests/hashes). Written "
          "by\n"
          "#   salvo_hashes --write tests/golden/hashes.txt scenes/*.toml scenes/*/*.toml\n"
          "# A change here is a change of bits: say why in CHANGELOG and raise contract_version.\n"
          "# scene, precision, digest of all frame hashes, hash of the last frame; start of each "
          "frame's hash\n";
  for (const auto& [scene, hashes] : golden) {
    file << scene << ' ' << hashes.precision << ' ' << hashes.frames << ' ' << hashes.last << '\n';
    for (std::size_t i = 0; i < hashes.marks.size(); ++i) {
      const bool ends = (i + 1) % marks_a_line == 0 || i + 1 == hashes.marks.size();
      file << ' ' << hashes.marks[i] << (ends ? "\n" : "");
    }
  }
  file.close();
  if (!file) {
    std::cerr << "salvo_hashes: cannot write " << path << '\n';
    std::exit(4);
  }
}

// Why two sets of hashes differ; "" when they are equal.
std::string difference(const Hashes& expected, const Hashes& found) {
  if (expected == found) return {};
  if (expected.precision != found.precision) return "precision was " + expected.precision;
  if (expected.marks.size() != found.marks.size()) {
    return std::to_string(found.marks.size()) + " frames, golden has " +
           std::to_string(expected.marks.size());
  }
  const auto at = std::mismatch(expected.marks.begin(), expected.marks.end(), found.marks.begin());
  if (at.first == expected.marks.end()) return "differs in some frame";
  return "first differs in frame " + std::to_string(at.first - expected.marks.begin());
}

}  // namespace

int main(int count, char** arguments) {
  const Options options = options_of({arguments + 1, arguments + count});
  const Golden expected = options.write ? Golden() : read_golden(options.file);
  Golden golden;
  int differences = 0;
  std::printf("%-44s %-9s %-7s %8s %6s  %-32s %s\n", "scene", "precision", "isa", "rows", "steps",
              "last frame", options.write ? "" : "golden");
  for (const std::string& path : options.scenes) {
    const std::string name = name_of(path);
    try {
      const GoldenScene scene(path);
      for (const Isa isa : options.isas) {
        const Hashes hashes = scene.run(isa, options.threads);
        std::string verdict;
        if (!options.write) {
          const auto found = expected.find(name);
          verdict = found == expected.end() ? "not in " + options.file
                                            : difference(found->second, hashes);
        } else if (!golden.emplace(name, hashes).second && golden[name] != hashes) {
          verdict = "differs between instruction sets";
        }
        differences += verdict.empty() ? 0 : 1;
        std::printf("%-44s %-9s %-7s %8llu %6lld  %-32s %s\n", name.c_str(),
                    hashes.precision.c_str(), std::string(salvo::solver::name(isa)).c_str(),
                    static_cast<unsigned long long>(scene.rows()),
                    static_cast<long long>(scene.steps()), hashes.last.c_str(),
                    !verdict.empty() ? verdict.c_str()
                    : options.write  ? ""
                                     : "equal");
        std::fflush(stdout);
      }
    } catch (const std::exception& error) {
      std::printf("%s\n", error.what());
      ++differences;
    }
  }
  if (options.write && differences == 0) write_golden(options.file, golden);
  if (differences != 0) std::printf("%d differences\n", differences);
  return differences == 0 ? 0 : 1;
}
