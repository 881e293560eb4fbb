#include "recording/recorder.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <ctime>
#include <exception>
#include <limits>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "recording/checkpoint.hpp"
#include "recording/directory.hpp"
#include "recording/frame_reader.hpp"
#include "recording/frame_writer.hpp"
#include "recording/output_file.hpp"
#include "recording/ownership.hpp"
#include "recording/sealed_file.hpp"
#include "recording/selection.hpp"
#include "solver/floating_point_environment.hpp"

namespace salvo::recording {

namespace {

using Clock = std::chrono::steady_clock;

// The index of the frames is written whole each time: not for every one of many small frames.
constexpr std::chrono::seconds series_interval{1};

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::filesystem::path created(std::filesystem::path directory) {
  ensure_directory(directory);
  return directory;
}

std::vector<std::size_t> recorded_fields(const scene::Scene& scene) {
  std::vector<std::size_t> fields;
  for (const soa::ParticleField column : scene.frames.columns) {
    const auto field = static_cast<std::size_t>(column);
    if (soa::only_of_contacts(field) && !scene.setup.contact_law) continue;
    if (std::find(fields.begin(), fields.end(), field) == fields.end()) fields.push_back(field);
  }
  return fields;
}

std::string what(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const std::exception& exception) {
    return exception.what();
  }
}

// What the thread has to write. A frame waits as columns, which the thread interleaves; a
// checkpoint, being large, as the finished file.
struct Pending {
  StateInfo state;
  RowBuffer frame;
  std::optional<hdf5::MemoryFile> checkpoint;
};

// A file ready to be written; without bytes when it is there already.
struct Finished {
  bool is_frame = false;
  StateInfo state;
  std::filesystem::path path;
  std::optional<hdf5::MemoryFile> file;
};

}  // namespace

class Recorder::Impl {
 public:
  Impl(std::filesystem::path directory, const scene::Scene& scene, RecorderOptions options);
  ~Impl();

  const scene::Scene& scene() const { return scene_; }
  /// Takes the world's state as the one to hand over.
  void observe(const solver::World& world);
  void hand_over_frame(const solver::World& world);
  void hand_over_checkpoint(const solver::World& world);
  void flush();
  void finish(RunStatus status, const std::string& reason);
  RecorderCounters counters() const;
  const StateInfo& last() const { return *last_; }
  std::uint64_t buffer_bytes() const;

 private:
  Pending& wait_for_slot();
  void hand_over();
  void join();
  void rethrow_error();  // with the mutex held
  void write_report(RunStatus status, const std::string& reason) const;
  void remove_unasked_checkpoints() const;

  // The thread.
  void work();
  Finished compose(Pending& pending);
  void write(Finished& finished);
  bool is_on_file(const std::filesystem::path& path, const StateInfo& state) const;
  void list_frame(std::int64_t frame);
  void list_frames_before(std::int64_t frame);
  void complete_series();
  void write_series();
  template <class Task>
  void attempt(std::unique_lock<std::mutex>& lock, Task task);

  const scene::Scene scene_;
  const RecorderOptions options_;
  const std::filesystem::path directory_;
  const DirectoryLock directory_lock_;
  const std::vector<std::size_t> fields_;
  const Selection selection_;
  const std::string started_ = utc_now();
  const Clock::time_point start_ = Clock::now();
  std::optional<StateInfo> last_;
  std::uint64_t particle_steps_ = 0;
  solver::Removals left_domain_;
  solver::Removals non_finite_;
  double seconds_waited_ = 0;
  FrameWriter checkpoint_writer_;

  // The thread's.
  FrameWriter frame_writer_;
  std::string series_;
  bool series_begun_ = false;
  bool series_behind_ = false;  // of what is on file
  std::optional<Clock::time_point> series_written_;
  std::atomic<std::uint64_t> frames_ = 0;
  std::atomic<std::uint64_t> kept_ = 0;
  std::atomic<std::uint64_t> checkpoints_ = 0;
  std::atomic<std::uint64_t> bytes_written_ = 0;
  std::atomic<std::uint64_t> largest_file_ = 0;

  // Handed from one to the other: pending_ slots from oldest_ on are the thread's to read.
  std::array<Pending, 2> slots_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t oldest_ = 0;
  std::size_t pending_ = 0;
  bool writing_ = false;
  bool flush_ = false;
  bool stop_ = false;
  std::exception_ptr error_;
  bool error_told_ = false;
  bool reported_ = false;  // run.json says how it ended

  std::thread thread_;  // the last member: it uses the others
};

Recorder::Impl::Impl(std::filesystem::path directory, const scene::Scene& scene,
                     RecorderOptions options)
    : scene_(scene),
      options_(std::move(options)),
      directory_(created(std::move(directory))),
      directory_lock_(directory_),
      fields_(recorded_fields(scene_)),
      selection_(scene_.frames.fraction),
      checkpoint_writer_(scene_),
      frame_writer_(scene_) {
  try {
    check_ownership(directory_, scene::scene_digest(scene_));
  } catch (const ForeignRecording&) {
    if (!options_.overwrite) throw;
    for (const std::filesystem::path& path : recording_files(directory_)) remove_file(path);
  }
  remove_partial_files(directory_);
  write_report(RunStatus::running, {});
  thread_ = std::thread([this] { work(); });
}

Recorder::Impl::~Impl() { join(); }

void Recorder::Impl::join() {
  if (!thread_.joinable()) return;
  {
    const std::unique_lock lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void Recorder::Impl::observe(const solver::World& world) {
  last_ = StateInfo{world.step(),     world.time(),  world.hash(),
                    world.diagnose(), world.tally(), world.removed()};
  particle_steps_ = world.particle_steps();
  left_domain_ = world.left_domain();
  non_finite_ = world.non_finite();
}

Pending& Recorder::Impl::wait_for_slot() {
  std::unique_lock lock(mutex_);
  if (pending_ == slots_.size() && !error_) {
    const Clock::time_point start = Clock::now();
    changed_.wait(lock, [this] { return pending_ < slots_.size() || error_; });
    seconds_waited_ += seconds_since(start);
  }
  rethrow_error();
  Pending& slot = slots_[(oldest_ + pending_) % slots_.size()];
  slot.state = *last_;
  return slot;
}

void Recorder::Impl::hand_over() {
  {
    const std::unique_lock lock(mutex_);
    ++pending_;
  }
  changed_.notify_all();
}

void Recorder::Impl::hand_over_frame(const solver::World& world) {
  assert(world.step() % scene_.frames.every == 0);
  wait_for_slot().frame.copy(world.particles(), fields_, selection_, world.parallel());
  hand_over();
}

void Recorder::Impl::hand_over_checkpoint(const solver::World& world) {
  Pending& slot = wait_for_slot();
  constexpr double everything = 1;
  slot.checkpoint = checkpoint_writer_.compose(slot.state, all_rows(world.particles()), everything,
                                               &world.contacts());
  hand_over();
}

void Recorder::Impl::rethrow_error() {
  if (!error_) return;
  error_told_ = true;
  std::rethrow_exception(error_);
}

void Recorder::Impl::flush() {
  std::unique_lock lock(mutex_);
  flush_ = true;
  changed_.notify_all();
  changed_.wait(lock, [this] { return pending_ == 0 && !writing_ && !flush_; });
  rethrow_error();
}

void Recorder::Impl::finish(RunStatus status, const std::string& reason) {
  if (reported_) return;
  join();
  if (error_) {
    const bool said = status == RunStatus::failed && !reason.empty();
    try {
      write_report(RunStatus::failed, said ? reason : what(error_));
      reported_ = true;
    } catch (const OutputError&) {  // the first error is the one to tell
    }
    if (!error_told_) rethrow_error();
    return;
  }
  if (status == RunStatus::done) remove_unasked_checkpoints();
  write_report(status, reason);
  reported_ = true;
}

// Those that an interrupted run left to go on from.
void Recorder::Impl::remove_unasked_checkpoints() const {
  for (const NumberedFile& checkpoint : list_checkpoints(directory_)) {
    if (!checkpoint_due(scene_, checkpoint.number)) remove_file(checkpoint.path);
  }
}

void Recorder::Impl::write_report(RunStatus status, const std::string& reason) const {
  RunReport report;
  report.status = status;
  report.reason = reason;
  report.command_line = options_.command_line;
  report.execution = options_.execution;
  report.started = started_;
  report.wall_seconds = seconds_since(start_);
  report.seconds_waited = seconds_waited_;
  report.bytes_written = bytes_written_;
  report.frames = frames_;
  report.particle_steps = particle_steps_;
  report.last = last_;
  report.left_domain = left_domain_;
  report.non_finite = non_finite_;
  write_run_report(directory_, scene_, report);
}

RecorderCounters Recorder::Impl::counters() const {
  return {frames_, kept_, checkpoints_, bytes_written_, seconds_waited_};
}

std::uint64_t Recorder::Impl::buffer_bytes() const {
  std::uint64_t bytes = largest_file_;
  for (const Pending& slot : slots_) bytes += slot.frame.capacity_bytes();
  return bytes;
}

// Does a part of the thread's work without the mutex; the first error stays.
template <class Task>
void Recorder::Impl::attempt(std::unique_lock<std::mutex>& lock, Task task) {
  lock.unlock();
  std::exception_ptr error;
  try {
    task();
  } catch (...) {
    error = std::current_exception();
  }
  lock.lock();
  if (!error_) error_ = error;
}

void Recorder::Impl::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return pending_ != 0 || flush_ || stop_; });
    if (pending_ == 0) {
      attempt(lock, [&] { complete_series(); });
      flush_ = false;
      changed_.notify_all();
      if (stop_) return;
      continue;
    }
    writing_ = true;
    Pending& pending = slots_[oldest_];
    std::optional<Finished> finished;
    if (!error_) attempt(lock, [&] { finished = compose(pending); });
    // The slot is free again while the file is being written.
    oldest_ = (oldest_ + 1) % slots_.size();
    --pending_;
    changed_.notify_all();
    if (finished) {
      attempt(lock, [&] {
        write(*finished);
        finished.reset();
      });
    }
    writing_ = false;
    changed_.notify_all();
  }
}

Finished Recorder::Impl::compose(Pending& pending) {
  Finished finished;
  finished.state = std::move(pending.state);
  finished.file = std::exchange(pending.checkpoint, std::nullopt);
  finished.is_frame = !finished.file;
  const std::int64_t step = finished.state.step;
  finished.path = directory_ / (finished.is_frame ? frame_name(step / scene_.frames.every)
                                                  : checkpoint_name(step));
  if (options_.resume && is_on_file(finished.path, finished.state)) {
    finished.file.reset();
  } else if (finished.is_frame) {
    finished.file = frame_writer_.compose(finished.state, pending.frame.rows(),
                                          std::min(scene_.frames.fraction, 1.0));
  }
  return finished;
}

void Recorder::Impl::write(Finished& finished) {
  if (finished.file) {
    const std::span<const std::byte> bytes = finished.file->bytes();
    write_sealed(finished.path, bytes,
                 finished.is_frame ? Durability::process : Durability::machine);
    bytes_written_ += bytes.size() + seal_size;
    largest_file_ = std::max<std::uint64_t>(largest_file_, bytes.size());
  } else {
    ++kept_;
  }
  if (finished.is_frame) {
    list_frame(finished.state.step / scene_.frames.every);
    ++frames_;
    if (!series_written_ || Clock::now() - *series_written_ > series_interval) write_series();
  } else {
    ++checkpoints_;
  }
}

// Whether an intact file of the same state is there. One that disagrees is not replaced: somebody
// has to look at it.
bool Recorder::Impl::is_on_file(const std::filesystem::path& path, const StateInfo& state) const {
  if (!std::filesystem::exists(path)) return false;
  FrameInfo info;
  try {
    info = read_frame_info(path);
  } catch (const CorruptFile&) {
    return false;
  }
  if (info.scene_digest != scene_digest(scene_) || info.step != state.step) return false;
  if (info.state_hash == state.hash.total) return true;
  std::string differing;
  for (const NamedDigest& recorded : info.field_digests) {
    for (const solver::FieldDigest& digest : state.hash.fields) {
      if (digest.field == recorded.field && digest.digest != recorded.digest) {
        differing += (differing.empty() ? "" : ", ") + recorded.field;
      }
    }
  }
  throw StateMismatch(fmt::format(
      "{} (salvo {}) has the state hash {} at step {}, this run (salvo {}) has {}; they "
      "differ in {}",
      path.string(), info.version, to_string(info.state_hash), state.step, SALVO_VERSION,
      to_string(state.hash.total), differing.empty() ? "which fields they store" : differing));
}

void Recorder::Impl::list_frame(std::int64_t frame) {
  const solver::FloatingPointEnvironment environment;
  if (!series_begun_) list_frames_before(frame);
  const auto step = static_cast<double>(frame * scene_.frames.every);
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(),
                                 scene_.setup.t0 + step * scene_.setup.dt);
  series_ += fmt::format("{}\n    {{\"name\": \"{}\", \"time\": {}}}", series_.empty() ? "" : ",",
                         frame_name(frame), std::string_view(digits.data(), end.ptr));
  series_behind_ = true;
}

// Those that the run which is resumed has recorded.
void Recorder::Impl::list_frames_before(std::int64_t frame) {
  series_begun_ = true;
  if (!options_.resume) return;
  for (const NumberedFile& earlier : list_frames(directory_)) {
    if (earlier.number < frame) list_frame(earlier.number);
  }
}

void Recorder::Impl::complete_series() {
  // A run that was killed after its last frame had perhaps not listed it.
  if (!series_begun_) list_frames_before(std::numeric_limits<std::int64_t>::max());
  if (series_behind_) write_series();
}

// The index of the frames and their times that ParaView opens.
void Recorder::Impl::write_series() {
  write_file(
      directory_ / series_name,
      fmt::format("{{\n  \"file-series-version\": \"1.0\",\n  \"files\": [{}\n  ]\n}}\n", series_));
  series_written_ = Clock::now();
  series_behind_ = false;
}

Recorder::Recorder(std::filesystem::path directory, const scene::Scene& scene,
                   RecorderOptions options)
    : impl_(std::make_unique<Impl>(std::move(directory), scene, std::move(options))) {}

Recorder::~Recorder() = default;

std::int64_t Recorder::next_due(std::int64_t step) const {
  const scene::Scene& scene = impl_->scene();
  const auto multiple_after = [&](std::int64_t every) { return (step / every + 1) * every; };
  std::int64_t next = std::min(scene.steps, multiple_after(scene.frames.every));
  if (scene.checkpoint.every > 0) next = std::min(next, multiple_after(scene.checkpoint.every));
  return next;
}

void Recorder::record_due(const solver::World& world) {
  const scene::Scene& scene = impl_->scene();
  const bool frame = world.step() % scene.frames.every == 0;
  const bool checkpoint = checkpoint_due(scene, world.step());
  if (frame || checkpoint || world.step() == scene.steps) impl_->observe(world);
  if (frame) impl_->hand_over_frame(world);
  if (checkpoint) impl_->hand_over_checkpoint(world);
}

void Recorder::record(const solver::World& world) {
  impl_->observe(world);
  impl_->hand_over_frame(world);
}

void Recorder::checkpoint(const solver::World& world) {
  impl_->observe(world);
  impl_->hand_over_checkpoint(world);
}

void Recorder::flush() { impl_->flush(); }

void Recorder::finish(RunStatus status, const std::string& reason) {
  impl_->finish(status, reason);
}

RecorderCounters Recorder::counters() const { return impl_->counters(); }
const StateInfo& Recorder::last() const { return impl_->last(); }
std::uint64_t Recorder::buffer_bytes() const { return impl_->buffer_bytes(); }

}  // namespace salvo::recording
