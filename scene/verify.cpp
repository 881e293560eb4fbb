#include "scene/verify.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <type_traits>
#include <utility>

#include "solver/diagnostic_fields.hpp"

namespace salvo::scene {

namespace {

using solver::BadRow;
using solver::Digest;
using solver::Execution;
using solver::Setup;
using solver::World;

constexpr Execution reference_execution{solver::Isa::scalar, 1, 1};

// The results of a frame besides its state, which the contract covers as well.
struct SummaryField {
  std::string name;
  double value = 0;
};
using Summary = std::vector<SummaryField>;

Summary summary_of(const World& world) {
  Summary summary;
  const auto whole = [&](std::string_view name, std::uint64_t number) {
    summary.push_back({std::string(name), static_cast<double>(number)});
  };
  const auto add = [&](std::string_view name, std::string_view /*unit*/, const auto& member) {
    using Member = std::remove_cvref_t<decltype(member)>;
    if constexpr (std::is_same_v<Member, std::uint64_t>) {
      whole(name, member);
    } else if constexpr (std::is_same_v<Member, double>) {
      summary.push_back({std::string(name), member});
    } else {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        summary.push_back({fmt::format("{}.{}", name, "xyz"[axis]), member[axis]});
      }
    }
  };
  const solver::Diagnostics diagnostics = world.diagnose();
  for_each_field(diagnostics, add);
  whole("impacts", world.tally().impacts);
  whole("rests", world.tally().rests);
  whole("removed", world.removed());
  return summary;
}

std::optional<Difference> summary_difference(const Summary& reference, const Summary& varied) {
  for (std::size_t i = 0; i < reference.size(); ++i) {
    const double a = reference[i].value;
    const double b = varied[i].value;
    if (same_bits(a, b)) continue;
    Difference difference;
    difference.column = reference[i].name;
    difference.reference = hex_text(a);
    difference.varied = hex_text(b);
    return difference;
  }
  return std::nullopt;
}

// What a run goes on from.
struct Snapshot {
  std::int64_t step;
  soa::Table particles;
  soa::Table contacts;
  solver::ContactTally tally;
  std::uint64_t removed;
};

Snapshot snapshot_of(const World& world) {
  return {world.step(), world.particles().copy(), world.contacts().copy(), world.tally(),
          world.removed()};
}

void restore(World& world, const Snapshot& snapshot) {
  world.restore(snapshot.step, snapshot.particles.copy(), snapshot.tally, snapshot.removed,
                snapshot.contacts.copy());
}

void fill(soa::Table& table, std::size_t field, double value) {
  const auto fill_with = [&](auto number) {
    auto* column = table.column<decltype(number)>(field);
    std::fill(column, column + table.rows(), number);
  };
  switch (table.fields()[field].scalar) {
    case soa::Scalar::real:
      if (table.precision() == soa::Precision::float32) {
        fill_with(static_cast<float>(value));
      } else {
        fill_with(value);
      }
      break;
    case soa::Scalar::int32:
      fill_with(static_cast<std::int32_t>(value));
      break;
    case soa::Scalar::uint32:
      fill_with(static_cast<std::uint32_t>(value));
      break;
    case soa::Scalar::uint64:
      fill_with(static_cast<std::uint64_t>(value));
      break;
  }
}

// The rows whose ids are accepted, in the columns of the set-up's tables: an emitter alone stores
// fewer of them.
template <class Keeps>
soa::Table selected(const soa::Table& table, const Setup& setup, Keeps&& keeps) {
  std::vector<std::size_t> kept;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (keeps(table.ids()[row])) kept.push_back(row);
  }
  soa::Table selection = World::empty_table(setup);
  selection.append(kept.size());
  for (std::size_t f = 0; f < table.fields().size(); ++f) {
    if (!selection.stored(f)) continue;
    if (!table.stored(f)) {
      fill(selection, f, table.uniform(f));
      continue;
    }
    const std::size_t size = size_of(table.fields()[f].scalar, table.precision());
    for (std::size_t c = 0; c < table.fields()[f].components; ++c) {
      std::byte* to = selection.bytes(f, c);
      const std::byte* from = table.bytes(f, c);
      for (std::size_t i = 0; i < kept.size(); ++i) {
        std::memcpy(to + i * size, from + kept[i] * size, size);
      }
    }
  }
  return selection;
}

// Of a run without a frame on the way also its middle: one that is resumed at the start shows
// nothing.
std::vector<std::int64_t> frame_steps(const Scene& scene) {
  std::vector<std::int64_t> steps;
  for (std::int64_t step = 0; step <= scene.steps; step += scene.frames.every) {
    steps.push_back(step);
  }
  if (steps.back() != scene.steps) steps.push_back(scene.steps);
  if (steps.size() == 2 && scene.steps > 1) steps.insert(steps.begin() + 1, scene.steps / 2);
  return steps;
}

bool same(const std::optional<BadRow>& a, const std::optional<BadRow>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return a->step == b->step && a->id == b->id && a->column == b->column &&
         same_bits(a->value, b->value);
}

class Verifier {
 public:
  Verifier(const Scene& scene, const VerifyOptions& options)
      : scene_(scene), options_(options), steps_(frame_steps(scene)), alone_(last_to_emit(scene)) {
    list_runs();
  }

  VerifyResult run() {
    run_reference(runs_.front());
    for (index_ = 1; index_ < runs_.size(); ++index_) run_varied(runs_[index_]);
    return {std::move(runs_), scene_.steps};
  }

 private:
  // The reference at a frame: of the whole state, and of the parts that other runs are made of.
  struct Frame {
    Digest whole;
    Digest rows;
    Digest emitter;
    Summary summary;
  };

  void list_runs() {
    add(VerifyAxis::reference, "scalar, 1 thread, 1 step a pass");
    const auto isas = options_.isas.empty() ? solver::available_isas() : options_.isas;
    for (const solver::Isa isa : isas) {
      if (isa != reference_execution.isa) {
        add(VerifyAxis::isa, std::string(solver::name(isa))).execution.isa = isa;
      }
    }
    for (const int threads : options_.threads) {
      if (threads != reference_execution.threads) {
        add(VerifyAxis::threads, fmt::to_string(threads)).execution.threads = threads;
      }
    }
    const bool touching = scene_.setup.contact_law.has_value();
    // Particles that touch go one step a pass, whatever is asked for.
    for (const std::int32_t pass : options_.passes) {
      if (!touching && pass != reference_execution.pass_steps) {
        add(VerifyAxis::pass, fmt::to_string(pass)).execution.pass_steps = pass;
      }
    }
    if (steps_.size() > 1) {
      add(VerifyAxis::resume, fmt::format("at step {}", steps_[middle()]));
    }
    if (touching) {
      // No row is the same without the others, but however their lists are built they are.
      add(VerifyAxis::lists, "wide margins").execution.contact.margin = wide_margin(scene_.setup);
      add(VerifyAxis::lists, "large cells").execution.contact.cell_scale = 1.7;
      auto& sorted = add(VerifyAxis::lists, "sorted every 3 steps").execution.contact;
      sorted.list_interval = 3;
      sorted.outer_margins = 1;
      return;
    }
    add(VerifyAxis::rows, "every third");
    if (alone_) {
      add(VerifyAxis::emitter, alone_->name.empty() ? fmt::format("stream {} alone", alone_->stream)
                                                    : alone_->name + " alone");
    }
  }

  // As wide as the mean particle of the first emitter.
  static double wide_margin(const Setup& setup) {
    return setup.emitters.empty() ? 1.0 : std::max(setup.emitters.front().radius.a, 1e-9);
  }

  VerifyRun& add(VerifyAxis axis, std::string value) {
    VerifyRun& run = runs_.emplace_back();
    run.axis = axis;
    run.value = std::move(value);
    run.execution = reference_execution;
    return run;
  }

  std::size_t middle() const { return (steps_.size() - 1) / 2; }

  // The emitter to run alone, if there are several: the last one that emits anything, since alone
  // it fills other rows than after the others.
  static const solver::Emitter* last_to_emit(const Scene& scene) {
    const Setup& setup = scene.setup;
    if (setup.emitters.size() < 2) return nullptr;
    for (auto emitter = setup.emitters.rbegin(); emitter != setup.emitters.rend(); ++emitter) {
      const solver::EmissionSchedule schedule(*emitter, setup.t0, setup.dt);
      if (schedule.emitted_before(scene.steps + 1) > 0) return &*emitter;
    }
    return nullptr;
  }

  Setup setup_of(const VerifyRun& run) const {
    Setup setup = scene_.setup;
    if (run.axis == VerifyAxis::emitter) setup.emitters = {*alone_};
    return setup;
  }

  // Whether a particle of the reference takes part in a run.
  bool takes_part(const VerifyRun& run, soa::Id id) const {
    if (run.axis == VerifyAxis::emitter) {
      return soa::stream_of(id) == alone_->stream;
    }
    return run.axis != VerifyAxis::rows ||
           !std::binary_search(dropped_.begin(), dropped_.end(), id);
  }

  static bool is_part(const VerifyRun& run) {
    return run.axis == VerifyAxis::rows || run.axis == VerifyAxis::emitter;
  }

  // The particles of a world that take part in a run, in the columns of the whole scene.
  soa::Table part(const World& world, const VerifyRun& run) const {
    return selected(world.particles(), scene_.setup,
                    [&](soa::Id id) { return takes_part(run, id); });
  }

  // Two particles of three of the first frame that has any.
  void choose_dropped(const World& world, std::size_t frame) {
    if (drop_frame_ != no_frame || world.particles().rows() == 0) return;
    drop_frame_ = frame;
    for (std::size_t row = 0; row < world.particles().rows(); ++row) {
      if (row % 3 != 0) dropped_.push_back(world.particles().ids()[row]);
    }
  }

  // Where the scene says stop, the particle because of which.
  std::optional<BadRow> advance(const VerifyRun& run, World& world, std::int64_t step) const {
    try {
      if (options_.advance) {
        options_.advance(run, world, step);
      } else {
        world.advance_to(step);
      }
    } catch (const solver::NumericalError& error) {
      return error.row();
    }
    return std::nullopt;
  }

  void run_reference(VerifyRun& run) {
    World world(scene_.setup, run.execution);
    VerifyRun rows;
    rows.axis = VerifyAxis::rows;
    VerifyRun emitter;
    emitter.axis = VerifyAxis::emitter;
    for (std::size_t f = 0; f < steps_.size(); ++f) {
      run.stopped = advance(run, world, steps_[f]);
      if (run.stopped) break;
      choose_dropped(world, f);
      Frame& frame = frames_.emplace_back();
      frame.whole = world.hash().total;
      if (!scene_.setup.contact_law) {
        frame.rows = state_hash(part(world, rows), world.parallel()).total;
      }
      if (alone_) {
        frame.emitter = state_hash(part(world, emitter), world.parallel()).total;
      }
      frame.summary = summary_of(world);
      record(run, frame.whole, world);
    }
    run.particle_steps = world.particle_steps();
  }

  void record(VerifyRun& run, const Digest& hash, const World& world) const {
    ++run.frames;
    run.hash = hash;
    run.rows = world.particles().rows();
    if (options_.on_progress) {
      options_.on_progress({index_, runs_.size(), &run, world.step(), scene_.steps});
    }
  }

  void run_varied(VerifyRun& run) const {
    auto world = std::make_unique<World>(setup_of(run), run.execution);
    std::optional<Snapshot> equal;
    for (std::size_t f = 0; f < steps_.size(); ++f) {
      run.stopped = advance(run, *world, steps_[f]);
      if (run.stopped || f == frames_.size()) {
        if (!stops_as_reference(run, f)) run.difference = locate(run, f, equal, *world);
        break;
      }
      if (run.axis == VerifyAxis::rows && f == drop_frame_) {
        world->restore(world->step(), part(*world, run), world->tally(), world->removed());
      }
      const Digest hash = is_part(run) ? state_hash(part(*world, run), world->parallel()).total
                                       : world->hash().total;
      record(run, hash, *world);
      if (!equal_frame(run, frames_[f], hash, *world)) {
        run.difference = locate(run, f, equal, *world);
        break;
      }
      equal.emplace(snapshot_of(*world));
      if (run.axis == VerifyAxis::resume && f == middle()) {
        run.particle_steps += world->particle_steps();
        world = std::make_unique<World>(setup_of(run), run.execution);
        restore(*world, *equal);
      }
    }
    run.particle_steps += world->particle_steps();
  }

  // Whether a run stopped, or did not, before a frame as it should have.
  bool stops_as_reference(const VerifyRun& run, std::size_t frame) const {
    std::optional<BadRow> stop;
    if (frame == frames_.size()) stop = runs_.front().stopped;
    if (!stop || takes_part(run, stop->id)) return same(run.stopped, stop);
    // The reference stopped at a particle that this run lacks: the run may go on, to stop at a
    // later one.
    return !run.stopped ||
           std::pair(run.stopped->step, run.stopped->id) > std::pair(stop->step, stop->id);
  }

  static bool equal_frame(const VerifyRun& run, const Frame& frame, const Digest& hash,
                          const World& world) {
    if (run.axis == VerifyAxis::rows) return hash == frame.rows;
    if (run.axis == VerifyAxis::emitter) return hash == frame.emitter;
    return hash == frame.whole && !summary_difference(frame.summary, summary_of(world));
  }

  std::optional<Difference> compare(const VerifyRun& run, const World& reference,
                                    const World& varied) const {
    if (is_part(run)) return first_difference(part(reference, run), part(varied, run));
    auto difference = first_difference(reference.particles(), varied.particles());
    if (!difference) difference = first_difference(reference.contacts(), varied.contacts());
    return difference ? difference : summary_difference(summary_of(reference), summary_of(varied));
  }

  // Of two runs at most one of which went on: what the one that stopped saw, and the other's value
  // there.
  std::optional<Difference> compare_stops(const World& reference, const World& varied,
                                          const std::optional<BadRow>& reference_stop,
                                          const std::optional<BadRow>& varied_stop) const {
    if (same(reference_stop, varied_stop)) return std::nullopt;
    const BadRow& bad = reference_stop ? *reference_stop : *varied_stop;
    const auto text = [&](const World& world, const std::optional<BadRow>& stop) {
      if (!stop) return value_text(world.particles(), bad.id, bad.column);
      if (stop->id == bad.id && stop->column == bad.column) return hex_text(stop->value);
      return fmt::format("stopped at {} of particle {}", stop->column, stop->id);
    };
    Difference difference;
    difference.column = bad.column;
    difference.id = bad.id;
    difference.reference = text(reference, reference_stop);
    difference.varied = text(varied, varied_stop);
    difference.rows = 1;
    return difference;
  }

  // The first difference of a run that differed at a frame, `now` being its world there. Both runs
  // go on from the last equal frame in single steps. Where the state went through a copy or a part
  // of it is compared, the reference starts again: a restored reference would share what a restore
  // or a neighbour did wrong.
  Difference locate(const VerifyRun& run, std::size_t frame, const std::optional<Snapshot>& equal,
                    const World& now) const {
    World reference(scene_.setup, reference_execution);
    if (!equal) return settled(compare(run, reference, now), 0, -1);
    if (is_part(run) || run.axis == VerifyAxis::resume) {
      advance(runs_.front(), reference, equal->step);
    } else {
      restore(reference, *equal);
    }
    World varied(setup_of(run), run.execution);
    restore(varied, *equal);
    std::optional<BadRow> reference_stop;
    for (std::int64_t step = equal->step + 1; step <= steps_[frame]; ++step) {
      reference_stop = advance(runs_.front(), reference, step);
      if (reference_stop && !takes_part(run, reference_stop->id)) break;
      const std::optional<BadRow> varied_stop = advance(run, varied, step);
      const auto difference = reference_stop || varied_stop
                                  ? compare_stops(reference, varied, reference_stop, varied_stop)
                                  : compare(run, reference, varied);
      if (difference) return settled(difference, step, step - 1);
      if (reference_stop) break;
    }
    if (run.stopped || reference_stop) {
      return settled(compare_stops(reference, now, reference_stop, run.stopped),
                     run.stopped ? run.stopped->step : reference_stop->step, equal->step);
    }
    return settled(compare(run, reference, now), steps_[frame], equal->step);
  }

  static Difference settled(const std::optional<Difference>& found, std::int64_t step,
                            std::int64_t equal_step) {
    Difference difference;
    if (found) {
      difference = *found;
    } else {
      difference.column = "a state that did not come again, of the reference or of the run";
    }
    difference.step = step;
    difference.equal_step = equal_step;
    return difference;
  }

  static constexpr std::size_t no_frame = static_cast<std::size_t>(-1);

  const Scene& scene_;
  const VerifyOptions& options_;
  std::vector<std::int64_t> steps_;  // of the frames
  const solver::Emitter* alone_;
  std::vector<VerifyRun> runs_;
  std::size_t index_ = 0;  // of the run that runs
  std::vector<Frame> frames_;
  std::size_t drop_frame_ = no_frame;
  std::vector<soa::Id> dropped_;  // ascending
};

}  // namespace

std::string_view name(VerifyAxis axis) {
  switch (axis) {
    case VerifyAxis::reference:
      return "reference";
    case VerifyAxis::isa:
      return "isa";
    case VerifyAxis::threads:
      return "threads";
    case VerifyAxis::pass:
      return "pass";
    case VerifyAxis::resume:
      return "resume";
    case VerifyAxis::lists:
      return "lists";
    case VerifyAxis::rows:
      return "rows";
    case VerifyAxis::emitter:
      return "emitter";
  }
  return {};
}

bool VerifyResult::equal() const {
  return std::none_of(runs.begin(), runs.end(),
                      [](const VerifyRun& run) { return run.difference.has_value(); });
}

VerifyResult verify(const Scene& scene, const VerifyOptions& options) {
  return Verifier(scene, options).run();
}

}  // namespace salvo::scene
