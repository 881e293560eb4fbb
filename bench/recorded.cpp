// What recording costs a run: 2^20 particles, position and velocity, a frame every 64 steps, on the
// file system of the current folder; against the same run without recording and against write() of
// as many bytes.
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "bench/harness.hpp"
#include "recording/recorder.hpp"

namespace salvo::bench {

namespace {

constexpr std::size_t rows = 1 << 20;
constexpr std::int64_t every = 64;
constexpr std::int64_t frames = 32;

scene::Scene recorded_scene() {
  scene::Scene scene;
  scene.path = "bench";
  scene.text = "bench";
  scene.setup = free_world(soa::Precision::float32, rows).setup();
  scene.steps = every * frames;
  scene.frames.every = every;
  scene.frames.columns = {soa::ParticleField::position, soa::ParticleField::velocity};
  scene.checkpoint.at_end = false;
  return scene;
}

double seconds_recorded(const scene::Scene& scene, const solver::Execution& execution,
                        const std::filesystem::path& folder, std::uint64_t& bytes) {
  std::filesystem::remove_all(folder);
  solver::World world(scene.setup, execution);
  recording::RecorderOptions options;
  options.execution = execution;
  const double start = now();
  recording::Recorder recorder(folder, scene, options);
  recorder.record_due(world);
  while (world.step() < scene.steps) {
    world.advance_to(recorder.next_due(world.step()));
    recorder.record_due(world);
  }
  recorder.finish(recording::RunStatus::done);
  const double seconds = now() - start;
  bytes = recorder.counters().bytes_written;
  return seconds;
}

// The same work with nothing kept: the frames' state hashes are part of a run.
double seconds_unrecorded(const scene::Scene& scene, const solver::Execution& execution) {
  solver::World world(scene.setup, execution);
  const double start = now();
  for (std::int64_t step = 0; step <= scene.steps; step += every) {
    world.advance_to(step);
    benchmark::DoNotOptimize(world.hash());
    benchmark::DoNotOptimize(world.diagnose());
  }
  return now() - start;
}

double seconds_written(const std::filesystem::path& folder, std::uint64_t bytes) {
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const std::vector<char> buffer(bytes / (frames + 1), 'x');
  const double start = now();
  for (std::int64_t frame = 0; frame <= frames; ++frame) {
    const std::string path = folder / fmt::format("plain_{}", frame);
    const int file = ::open(path.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0644);
    std::size_t done = 0;
    while (file >= 0 && done < buffer.size()) {
      const ssize_t wrote = ::write(file, buffer.data() + done, buffer.size() - done);
      if (wrote <= 0) break;
      done += static_cast<std::size_t>(wrote);
    }
    ::close(file);
  }
  return now() - start;
}

}  // namespace

void register_recorded() {
  for (const int threads : {1, 2}) {
    const solver::Isa isa = solver::widest_isa();
    benchmark::RegisterBenchmark(
        fmt::format("particles/recorded/isa:{}/real:float/n:{}/substeps:{}/threads:{}",
                    solver::name(isa), rows, every, threads)
            .c_str(),
        [=](benchmark::State& state) {
          const std::filesystem::path folder =
              std::filesystem::current_path() / "salvo_bench_recording";
          const scene::Scene scene = recorded_scene();
          const solver::Execution execution{isa, threads, static_cast<std::int32_t>(every)};
          std::vector<double> recorded;
          std::vector<double> unrecorded;
          std::vector<double> written;
          std::uint64_t bytes = 0;
          // One iteration is long enough for the harness; three rounds in it give a median.
          for (auto _ : state) {
            for (int round = 0; round < 3; ++round) {
              recorded.push_back(seconds_recorded(scene, execution, folder, bytes));
              unrecorded.push_back(seconds_unrecorded(scene, execution));
              written.push_back(seconds_written(folder, bytes));
            }
          }
          std::filesystem::remove_all(folder);
          const auto steps = static_cast<double>(rows * scene.steps);
          state.counters["particle_steps_per_second"] = steps / median(recorded);
          state.counters["bytes_per_second"] = static_cast<double>(bytes) / median(recorded);
          state.counters["fraction_lost"] = 1 - median(unrecorded) / median(recorded);
          state.counters["fraction_of_ceiling"] = median(written) / median(recorded);
          state.SetLabel(proof_hash(&free_world, soa::Precision::float32, execution));
        })
        ->Unit(benchmark::kMillisecond);
  }
}

}  // namespace salvo::bench
