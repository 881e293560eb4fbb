#include "scene/load.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <sstream>
#include <system_error>
#include <tuple>

#include "kernels/math.hpp"
#include "models/triangle_mesh.hpp"
#include "scene/document.hpp"
#include "scene/mesh_file.hpp"
#include "scene/mistakes.hpp"
#include "scene/scene_keys.hpp"
#include "scene/sweep_keys.hpp"
#include "scene/terrain.hpp"
#include "scene/units.hpp"
#include "solver/contact_time.hpp"
#include "solver/floating_point_environment.hpp"
#include "solver/walls.hpp"

namespace salvo::scene {

namespace {

using models::Obstacle;
using models::ObstacleShape;
using solver::EmitterKind;
using solver::Triple;
using S = kernels::ScalarLane<double>;

constexpr std::size_t most_samples = std::size_t{1} << 24;

// Turns what the keys hold into a scene, and checks what needs several keys. Values that are wrong
// were reported when they were read; what follows from them is left out.
class Completion {
 public:
  Completion(const Value& root, SceneKeys& keys, Mistakes& mistakes)
      : root_(root), keys_(keys), mistakes_(mistakes), read_whole_(mistakes.count() == 0) {}

  void run() {
    const std::size_t before = mistakes_.count();
    check_springs();
    complete_time();
    timed_ = mistakes_.count() == before && keys_.setup.dt > 0 && keys_.steps > 0;
    complete_forces();
    complete_obstacles();
    complete_domain();
    complete_emitters();
    complete_contact_law();
    if (mistakes_.count() == 0) check_count();
    if (timed_) complete_frames();
    // A value that could not be read may be what the others are for.
    if (read_whole_) refuse_what_does_nothing();
  }

 private:
  void fail(const std::string& path, std::string problem, std::string hint = {}) {
    mistakes_.add(deepest(root_, path).place, std::move(problem), std::move(hint));
  }

  // Whether at most one of a key and its rivals is given; else says so, at the last of them.
  bool at_most_one_of(const std::string& path, std::string_view key) {
    const std::vector<const Member*> given = given_of(path, key);
    if (given.size() < 2) return true;
    mistakes_.add(
        given.back()->value.place,
        fmt::format("\"{}\" and \"{}\" say the same", given.front()->key, given.back()->key),
        "keep one of them");
    return false;
  }
  bool one_of(const std::string& path, std::string_view key) {
    if (given_of(path, key).empty()) {
      const std::vector<std::string_view>& keys = group_of(path, key).keys;
      fail(path, fmt::format("missing key \"{}\" in {}", keys[0], label(path)),
           fmt::format("give it, or \"{}\"", keys[1]));
      return false;
    }
    return at_most_one_of(path, key);
  }
  // Those of a key and its rivals that are there, right or wrong, in the order in which they are
  // written.
  std::vector<const Member*> given_of(const std::string& path, std::string_view key) const {
    const Rivals& group = group_of(path, key);
    std::vector<const Member*> given;
    for (const Member& member : deepest(root_, path).members) {
      if (std::find(group.keys.begin(), group.keys.end(), member.key) != group.keys.end()) {
        given.push_back(&member);
      }
    }
    std::stable_sort(given.begin(), given.end(), [](const Member* a, const Member* b) {
      const auto order = [](const Place& p) { return std::tuple(p.source, p.line, p.column); };
      return order(a->key_place) < order(b->key_place);
    });
    return given;
  }
  static const Rivals& group_of(const std::string& path, std::string_view key) {
    return *rivals_of(rival_keys(), path.substr(0, path.find('.')), key);
  }
  // A key that is there but was wrong is no missing key.
  bool attempted(const std::string& section, const std::string& key) const {
    return deepest(root_, section).find(key) != nullptr;
  }
  // Whether a key may hold something else than its member: it was wrong, which was reported.
  bool unsure(const std::string& section, const std::string& key) const {
    return !read_whole_ && attempted(section, key);
  }
  static std::string label(const std::string& section) {
    const std::size_t dot = section.find('.');
    return dot == std::string::npos ? fmt::format("[{}]", section)
                                    : fmt::format("[[{}]]", section.substr(0, dot));
  }

  void complete_time() {
    const TimeKeys& time = keys_.time;
    keys_.setup.t0 = time.start;
    if (!root_.find("time")) return;
    const auto& law = keys_.setup.contact_law;
    const bool has_springs = law && law->kind != models::ContactLawKind::impulse;
    if (has_springs && given_of("time", "dt").empty()) return choose_step();
    const bool stepped = one_of("time", "dt") && (time.dt || time.steps_per_second);
    const bool limited = one_of("time", "duration") && (time.duration || time.steps);
    if (stepped) keys_.setup.dt = time.dt ? *time.dt : 1 / *time.steps_per_second;
    if (!stepped || !limited) return;
    if (time.steps) {
      keys_.steps = *time.steps;
      return;
    }
    const double steps = *time.duration / keys_.setup.dt;
    if (!(steps < static_cast<double>(soa::never))) {
      fail("time.duration", fmt::format("\"duration\" in [time] is {} steps", steps),
           fmt::format("expected at most {}", soa::never - 1));
    } else if (const double whole = std::round(steps);
               whole < 1 || std::abs(steps - whole) > 1e-6) {
      const double near = std::max(whole, 1.0);
      fail(
          "time.duration", fmt::format("\"duration\" in [time] is {:.9g} steps", steps),
          fmt::format("expected a whole number of steps, such as {:.9g} s", near * keys_.setup.dt));
    } else {
      keys_.steps = static_cast<std::int64_t>(whole);
    }
  }

  // What dashpots can give, and steps can follow.
  void check_springs() {
    const auto& law = keys_.setup.contact_law;
    if (!law || law->kind == models::ContactLawKind::impulse) return;
    constexpr double least_restitution = 0.01;
    const auto check = [&](double restitution, const std::string& path, const char* section) {
      if (restitution >= least_restitution) return;
      followed_ = false;
      fail(path + ".restitution",
           fmt::format("\"restitution\" in {} is less than a dashpot gives", section),
           fmt::format("expected at least {}, or kind = \"impulse\"", least_restitution));
    };
    check(law->restitution, "contact_law", "[contact_law]");
    for (std::size_t i = 0; i < keys_.obstacles.size(); ++i) {
      check(keys_.obstacles[i].restitution, fmt::format("obstacle.{}", i), "[[obstacle]]");
    }
    for (std::size_t i = 0; i < keys_.emitters.size(); ++i) {
      const auto bounded = [&](const solver::Spread& spread, const char* key) {
        if (spread.kind != solver::Spread::Kind::normal || spread.a > 4 * spread.b) return;
        followed_ = false;
        fail(fmt::format("emitter.{}.{}", i, key),
             fmt::format("\"{}\" in [[emitter]] comes near zero, and no step follows that", key),
             "expected a deviation of less than a quarter of the mean, or { uniform = [..] }");
      };
      bounded(keys_.emitters[i].mass, "mass");
      bounded(keys_.emitters[i].radius, "radius");
    }
  }

  // The step that the contacts want, or the next smaller one of which there is a whole number in
  // the run, and between its frames.
  void choose_step() {
    const TimeKeys& time = keys_.time;
    if (!one_of("time", "duration") || !(time.duration || time.steps) || !followed_) return;
    solver::Setup setup = keys_.setup;
    for (const EmitterKeys& emitter : keys_.emitters) setup.emitters.push_back(emitter);
    for (const ObstacleKeys& obstacle : keys_.obstacles) setup.obstacles.push_back(obstacle);
    const double step = solver::contact_time(setup).step;
    if (!(step > 0) || !(step < std::numeric_limits<double>::max())) return;  // reported
    keys_.step_chosen = true;
    if (time.steps) {
      keys_.setup.dt = step;
      keys_.steps = *time.steps;
      return;
    }
    const FrameKeys& frames = keys_.frame_keys;
    const double pieces = frames.count         ? static_cast<double>(*frames.count)
                          : frames.per_second  ? std::round(*time.duration * *frames.per_second)
                          : frames.given_every ? static_cast<double>(*frames.given_every)
                                               : 1;
    const double steps = std::ceil(*time.duration / (step * pieces)) * pieces;
    if (!(steps < static_cast<double>(soa::never))) {
      fail("time.duration", fmt::format("\"duration\" in [time] is {:.3g} steps", steps),
           fmt::format("the contacts want steps of {:.3g} s; softer ones take longer", step));
      return;
    }
    keys_.steps = static_cast<std::int64_t>(std::max(steps, 1.0));
    keys_.setup.dt = *time.duration / static_cast<double>(keys_.steps);
  }

  void check_count() {
    std::uint64_t room = solver::World::most_particles(keys_.setup);
    for (std::size_t i = 0; i < keys_.emitters.size(); ++i) {
      const solver::Emitter& emitter = keys_.emitters[i];
      const std::uint64_t count =
          timed_ ? solver::EmissionSchedule(emitter, keys_.setup.t0, keys_.setup.dt).total()
                 : emitter.count;
      if (count > room) {
        fail(fmt::format("emitter.{}", i),
             fmt::format("{} particles are {} too many", count, count - room),
             fmt::format("expected at most {} in all{}", solver::World::most_particles(keys_.setup),
                         keys_.setup.contact_law ? ", as they touch each other" : ""));
        return;
      }
      room -= count;
    }
  }

  // What particles that touch need.
  void complete_contact_law() {
    if (!keys_.setup.contact_law) {
      for (std::size_t i = 0; i < keys_.obstacles.size(); ++i) {
        const std::string path = fmt::format("obstacle.{}", i);
        if (keys_.obstacles[i].hollow) {
          fail(path + ".hollow", "\"hollow\" in [[obstacle]] needs particles that touch",
               "give a [contact_law]");
        }
        if (keys_.obstacles[i].shape == ObstacleShape::mesh) {
          fail(path + ".shape", "a mesh needs particles that touch", "give a [contact_law]");
        }
        if (attempted(path, "motion")) {
          fail(path + ".motion", "[obstacle.motion] needs particles that touch",
               "give a [contact_law]");
        }
      }
      return;
    }
    const models::ContactLaw& law = *keys_.setup.contact_law;
    if (keys_.setup.integrator != solver::IntegratorKind::semi_implicit_euler) {
      fail("integrator", "particles that touch are stepped by semi_implicit_euler alone",
           "remove the integrator");
    }
    if (root_.find("contact")) {
      fail("contact", "[contact] is for particles that do not touch each other",
           "obstacles are met through [contact_law]; remove one of the two");
    }
    const bool turns = law.friction > 0 || unsure("contact_law", "friction");
    if (!turns) {
      const auto refuse = [&](const std::string& section, const char* key) {
        if (!attempted(section, key)) return;
        fail(fmt::format("{}.{}", section, key),
             fmt::format("\"{}\" in {} is given, but there is no friction", key, label(section)),
             "give a friction in [contact_law], or remove it");
      };
      for (const char* key : {"tangential_ratio", "tangential_damping", "rolling_friction"}) {
        refuse("contact_law", key);
      }
      for (std::size_t i = 0; i < keys_.emitters.size(); ++i) {
        refuse(fmt::format("emitter.{}", i), "angular_velocity");
      }
    }
    for (std::size_t i = 0; i < keys_.emitters.size(); ++i) {
      check_sizes(keys_.emitters[i], fmt::format("emitter.{}", i));
    }
    for (std::size_t i = 0; i < keys_.obstacles.size(); ++i) {
      const std::string path = fmt::format("obstacle.{}", i);
      if (attempted(path, "mass")) {
        fail(path + ".mass", "\"mass\" in [[obstacle]] is for the impulse of [contact]",
             "to particles that touch each other an obstacle is infinitely heavy: remove it");
      }
      if (keys_.obstacles[i].friction == 0 || turns) continue;
      fail(path + ".friction", "\"friction\" in [[obstacle]] needs particles that turn",
           "give a friction in [contact_law]");
    }
    keys_.setup.birth_tolerance = 0.01;
    if (!timed_ || mistakes_.count() != 0) return;
    if (law.kind != models::ContactLawKind::impulse) check_step();
    for (std::size_t i = 0; i < keys_.obstacles.size(); ++i) {
      check_motion(keys_.obstacles[i], fmt::format("obstacle.{}.motion", i));
    }
    for (std::size_t i = 0; i < keys_.emitters.size(); ++i) {
      check_launch(keys_.emitters[i], fmt::format("emitter.{}", i));
    }
  }

  // Masses and radii of particles that touch are multiplied in the precision of the scene: with
  // each other, and to moments of inertia. No product may vanish, lose its digits or overflow.
  void check_sizes(const EmitterKeys& emitter, const std::string& path) {
    if (!attempted(path, "radius")) {
      fail(path, "particles that touch need a radius", "give radius in [[emitter]]");
      return;
    }
    if (unsure(path, "radius") || unsure(path, "mass")) return;
    const bool is_float = keys_.setup.precision == soa::Precision::float32;
    const double smallest = is_float ? 0x1p-126 : 0x1p-1022;
    const double root = is_float ? 0x1p-63 : 0x1p-511;
    const char* wider = is_float ? ", or precision = \"double\"" : "";
    const std::size_t before = mistakes_.count();
    const auto check = [&](const solver::Spread& size, const char* key, const char* unit) {
      const double least = least_drawn(size);
      const double greatest = size.greatest();
      if (least == 0) {
        fail(fmt::format("{}.{}", path, key), fmt::format("particles that touch need a {}", key),
             fmt::format("expected more than 0 {}", unit));
      } else if (least < root || greatest > 1 / root) {
        fail(fmt::format("{}.{}", path, key),
             fmt::format("\"{}\" in [[emitter]] comes to {:.3g} {}: the square is out of range",
                         key, least < root ? least : greatest, unit),
             fmt::format("expected {:.2g} to {:.2g} {}{}", root, 1 / root, unit, wider));
      }
    };
    check(emitter.radius, "radius", "m");
    check(emitter.mass, "mass", "kg");
    if (mistakes_.count() != before || !keys_.setup.contact_law->turns()) return;
    const double radius = least_drawn(emitter.radius);
    const double inertia = 0.4 * least_drawn(emitter.mass) * radius * radius;
    if (inertia >= smallest) return;  // the bounds of both keep it from overflowing
    fail(path + ".radius",
         fmt::format("\"radius\" and \"mass\" in [[emitter]] give a moment of inertia of {:.3g} "
                     "kg m^2, which is out of range",
                     inertia),
         fmt::format("expected at least {:.2g} kg m^2{}", smallest, wider));
  }

  // A normal spread may come near zero, which draws do with no chance to speak of.
  static double least_drawn(const solver::Spread& spread) {
    return spread.least() > 0 || spread.kind != solver::Spread::Kind::normal ? spread.least()
                                                                             : spread.a;
  }

  // Contacts follow an obstacle that goes no farther than a radius in a step, and of a swing or a
  // turn as many steps as show which way it goes.
  void check_motion(const ObstacleKeys& obstacle, const std::string& path) {
    constexpr double least_steps = 8;
    const models::ObstacleMotion& motion = obstacle.motion;
    const double dt = keys_.setup.dt;
    if (motion.frequency * dt * least_steps > 1) {
      fail(path + ".frequency",
           fmt::format("a swing of [obstacle.motion] takes {:.3g} steps",
                       1 / (motion.frequency * dt)),
           fmt::format("expected at least {}: at most {:.3g} 1/s, or steps of {:.3g} s",
                       least_steps, 1 / (least_steps * dt), 1 / (least_steps * motion.frequency)));
      return;
    }
    // What a plane does far from where it turns about, no bound can say.
    double speed = solver::fastest(obstacle);
    if (!(speed < std::numeric_limits<double>::infinity())) {
      const Triple& spin = motion.angular_velocity;
      const double rate = norm(kernels::Vec3<S>{S(spin[0]), S(spin[1]), S(spin[2])}).value();
      const double fastest_rate = 2 * kernels::pi / (least_steps * dt);
      if (rate > fastest_rate) {
        fail(path + ".angular_velocity",
             fmt::format("a turn of [obstacle.motion] takes {:.3g} steps",
                         2 * kernels::pi / (rate * dt)),
             fmt::format("expected at least {}: at most {:.3g} rad/s, or steps of {:.3g} s",
                         least_steps, fastest_rate, 2 * kernels::pi / (least_steps * rate)));
        return;
      }
      Obstacle straight = obstacle;
      straight.motion.angular_velocity = {};
      speed = solver::fastest(straight);
    }
    const double smallest = smallest_radius();
    if (speed * dt <= smallest) return;
    fail(path,
         fmt::format("[obstacle.motion] goes as far as {:.3g} m in a step, farther than the "
                     "smallest radius, {:.3g} m",
                     speed * dt, smallest),
         fmt::format("expected at most {:.3g} m/s, or steps of {:.3g} s", smallest / dt,
                     smallest / speed));
  }

  // What starts faster than that flies through others and obstacles.
  void check_launch(const EmitterKeys& emitter, const std::string& path) {
    const Triple& v = emitter.velocity;
    const double given = sqrt(S(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])).value();
    const double speed =
        given + std::max(std::abs(emitter.speed.least()), std::abs(emitter.speed.greatest()));
    const double dt = keys_.setup.dt;
    const double smallest = smallest_radius();
    if (speed * dt <= smallest) return;
    fail(path + (attempted(path, "speed") ? ".speed" : ".velocity"),
         fmt::format("particles of [[emitter]] start with up to {:.3g} m/s: {:.3g} m in a step, "
                     "farther than the smallest radius, {:.3g} m",
                     speed, speed * dt, smallest),
         fmt::format("expected at most {:.3g} m/s, or steps of {:.3g} s", smallest / dt,
                     smallest / speed));
  }

  double smallest_radius() const {
    double smallest = std::numeric_limits<double>::max();
    for (const EmitterKeys& emitter : keys_.emitters) {
      smallest = std::min(smallest, least_drawn(emitter.radius));
    }
    return smallest;
  }

  void check_step() {
    const solver::ContactTime time = solver::contact_time(keys_.setup);
    if (keys_.setup.dt <= time.longest_step) return;
    const char* key = keys_.time.dt ? "dt" : "steps_per_second";
    fail(fmt::format("time.{}", key),
         fmt::format("steps of {:.3g} s cannot follow {}, {:.3g} s", keys_.setup.dt, time.of,
                     time.duration),
         fmt::format("expected at most {:.3g} s, best {:.3g} s: leave \"{}\" out, or make the "
                     "contacts softer",
                     time.longest_step, time.step, key));
  }

  double end() const { return keys_.setup.t0 + static_cast<double>(keys_.steps) * keys_.setup.dt; }

  // Scales a direction to unit length.
  void complete_direction(Triple& direction, const std::string& path, const std::string& key) {
    // The larger components first, so that no square overflows or vanishes.
    const double largest =
        std::max({std::abs(direction[0]), std::abs(direction[1]), std::abs(direction[2])});
    if (!(largest > 0)) {
      fail(path, fmt::format("\"{}\" is zero", key), "a direction has some length");
      return;
    }
    for (double& component : direction) component /= largest;
    const double length = sqrt(S(direction[0] * direction[0] + direction[1] * direction[1] +
                                 direction[2] * direction[2]))
                              .value();
    for (double& component : direction) component /= length;
  }

  void complete_forces() {
    models::ForceSettings& forces = keys_.setup.forces;
    complete_direction(forces.up, "forces.up", "up");
    if (forces.gusty && attempted("forces.gust", "direction")) {
      complete_direction(forces.gust.direction, "forces.gust.direction", "direction");
    }
    const models::Wind& wind = forces.wind;
    if (forces.windy && wind.profile == models::WindProfile::log_law &&
        !(wind.roughness < wind.reference_height)) {
      fail("forces.wind.roughness",
           "\"roughness\" in [forces.wind] is not below the reference height",
           fmt::format("expected less than {} m", wind.reference_height));
    }
    if (forces.drag_law == models::DragLaw::book_still_air) complete_still_air();
    for (std::size_t b = 0; timed_ && b < forces.blasts.size(); ++b) {
      if (forces.blasts[b].time > end()) {
        fail(fmt::format("forces.blast.{}.time", b),
             "\"time\" in [[forces.blast]] is after the end", end_hint());
      }
    }
  }

  // The book's law knows no other part of the air.
  void complete_still_air() {
    const models::ForceSettings& forces = keys_.setup.forces;
    const std::string law = "with drag_law = \"book_still_air\"";
    if (!forces.quadratic_drag) {
      fail("forces.drag_law", "\"drag_law\" in [forces] is given, but there is no quadratic drag",
           "set quadratic_drag = true");
    }
    if (forces.linear_drag != 0) {
      fail("forces.linear_drag", "\"linear_drag\" in [forces] does not go " + law, "remove one");
    }
    if (forces.gusty) fail("forces.gust", "[forces.gust] does not go " + law, "remove one");
    if (forces.windy && forces.wind.profile != models::WindProfile::uniform) {
      fail("forces.wind.profile", "\"profile\" in [forces.wind] does not go " + law,
           "expected \"uniform\"");
    }
  }

  std::string end_hint() const { return fmt::format("the run ends at {:.9g} s", end()); }

  void complete_obstacles() {
    for (std::size_t i = 0; i < keys_.obstacles.size(); ++i) {
      const std::size_t before = mistakes_.count();
      ObstacleKeys& given = keys_.obstacles[i];
      const std::string path = fmt::format("obstacle.{}", i);
      const char* axis = given.shape == ObstacleShape::plane ? "normal" : "axis";
      complete_direction(given.axis, path + "." + axis, axis);
      complete_direction(given.rotation_axis, path + ".rotation_axis", "rotation_axis");
      const S half(0.5 * given.rotation_angle);
      const double sine = sin(half).value();
      given.rotation = {cos(half).value(), sine * given.rotation_axis[0],
                        sine * given.rotation_axis[1], sine * given.rotation_axis[2]};
      if (given.shape == ObstacleShape::height_field) complete_heights(given, path);
      if (given.shape == ObstacleShape::mesh) complete_mesh(given, path);
      if (mistakes_.count() == before) {
        keys_.setup.obstacles.push_back(models::normalized(static_cast<const Obstacle&>(given)));
      }
    }
  }

  void complete_mesh(ObstacleKeys& given, const std::string& path) {
    if (given.mesh_file.empty()) {
      if (attempted(path, "file") && !unsure(path, "file")) {
        fail(path + ".file", "\"file\" in [[obstacle]] is empty", "expected an .obj or .ply file");
      }
      return;  // otherwise reported
    }
    const auto file = std::filesystem::path(keys_.path).parent_path() / given.mesh_file;
    try {
      auto [mesh, bytes] = read_mesh(file.string());
      keys_.inputs.push_back(solver::digest_of(bytes.data(), bytes.size()));
      const double reach = given.scale * models::reach(mesh);
      constexpr double least = 1e-15;
      constexpr double most = 1e15;
      if (!(least <= reach && reach <= most)) {
        const bool scaled = attempted(path, "scale");
        fail(path + (scaled ? ".scale" : ".file"),
             fmt::format("the mesh reaches {:.3g} m from its origin", reach),
             fmt::format("expected {:g} to {:g} m: {} \"scale\"", least, most,
                         scaled ? "choose another" : "give a"));
        return;
      }
      for (models::Triple& vertex : mesh.vertices) {
        for (double& coordinate : vertex) coordinate *= given.scale;
      }
      given.mesh = std::make_shared<const models::MeshFeatures>(make_features(mesh));
    } catch (const MeshError& error) {
      fail(path + ".file", error.what(), error.hint());
    } catch (const std::system_error& error) {
      fail(path + ".file", error.what(), "the path is relative to the scene's file");
    }
  }

  void complete_heights(ObstacleKeys& given, const std::string& path) {
    if (!one_of(path, "heights") || (!given.heights && !given.hills)) return;
    if (given.hills) {
      const Hills& hills = *given.hills;
      if (!(hills.length > 0) || hills.columns < 2 || hills.rows < 2) return;  // reported
      if (hills.columns > most_samples / hills.rows) {
        fail(path + ".hills.rows", too_many_samples(), samples_hint());
        return;
      }
      given.samples = models::make_height_samples(hills.columns, hills.rows, given.spacing,
                                                  hill_heights(hills, given.spacing));
      return;
    }
    const std::vector<std::vector<double>>& rows = *given.heights;
    const std::size_t columns = rows.empty() ? 0 : rows.front().size();
    if (rows.size() < 2 || columns < 2) {
      fail(path + ".heights", "\"heights\" in [[obstacle]] are too few",
           "expected at least two rows of at least two samples");
      return;
    }
    if (columns > most_samples / rows.size()) {
      fail(path + ".heights", too_many_samples(), samples_hint());
      return;
    }
    std::vector<double> heights;
    for (std::size_t j = 0; j < rows.size(); ++j) {
      if (rows[j].size() != columns) {
        fail(fmt::format("{}.heights.{}", path, j),
             fmt::format("row {} of \"heights\" in [[obstacle]] has {} samples", j, rows[j].size()),
             fmt::format("expected {}, as in row 0", columns));
        return;
      }
      heights.insert(heights.end(), rows[j].begin(), rows[j].end());
    }
    given.samples =
        models::make_height_samples(columns, rows.size(), given.spacing, std::move(heights));
  }
  static std::string too_many_samples() { return "the height field has too many samples"; }
  static std::string samples_hint() { return fmt::format("expected at most {}", most_samples); }

  void complete_domain() {
    const DomainKeys& given = keys_.domain;
    solver::Setup& setup = keys_.setup;
    setup.on_bad = given.on_leave;
    if (!given.lowest && !given.highest) return;
    if (!given.lowest || !given.highest) {
      const char* missing = given.lowest ? "highest" : "lowest";
      if (!attempted("domain", missing)) {
        fail("domain", fmt::format("missing key \"{}\" in [domain]", missing),
             "a domain has two corners");
      }
      return;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if ((*given.lowest)[axis] < (*given.highest)[axis]) continue;
      fail("domain.highest",
           fmt::format("\"highest\" in [domain] is not above \"lowest\" in {}", "xyz"[axis]),
           fmt::format("expected more than {} m", (*given.lowest)[axis]));
      return;
    }
    setup.domain = {true, *given.lowest, *given.highest};
  }

  void complete_emitters() {
    if (root_.find("emitter") && keys_.emitters.empty()) {
      const std::size_t reported = mistakes_.count();
      if (reported == 0) fail("emitter", "there is no [[emitter]]", "expected at least one");
      return;
    }
    std::map<std::uint64_t, std::size_t> taken;
    for (std::size_t i = 0; i < keys_.emitters.size(); ++i) {
      EmitterKeys& given = keys_.emitters[i];
      const std::string path = fmt::format("emitter.{}", i);
      given.stream = given.given_stream.value_or(i);
      const auto [first, free] = taken.emplace(given.stream, i);
      if (!free) {
        fail(path + ".stream",
             fmt::format("stream {} is that of emitter {} too", given.stream, first->second),
             given.given_stream ? "a stream belongs to one emitter"
                                : "without a stream an emitter takes its place in the list");
      }
      complete_emitter(given, path);
      keys_.setup.emitters.push_back(given);
    }
  }

  // Where and how fast particles start has to have a square in the precision of the scene.
  void check_start(const EmitterKeys& given, const std::string& path) {
    const bool is_float = keys_.setup.precision == soa::Precision::float32;
    const double most = is_float ? 0x1p63 : 0x1p511;
    const auto check = [&](const char* key, std::initializer_list<double> numbers,
                           const char* unit) {
      double largest = 0;
      for (const double number : numbers) largest = std::max(largest, std::abs(number));
      if (largest <= most) return;
      fail(fmt::format("{}.{}", path, key),
           fmt::format("\"{}\" in [[emitter]] is {:.3g} {}: the square is out of range", key,
                       largest, unit),
           fmt::format("expected at most {:.2g} {}{}", most, unit,
                       is_float ? ", or precision = \"double\"" : ""));
    };
    const auto three = [&](const char* key, const Triple& of, const char* unit) {
      check(key, {of[0], of[1], of[2]}, unit);
    };
    three("position", given.position, "m");
    three("size", given.size, "m");
    check("source_radius", {given.source_radius}, "m");
    check("jitter", {given.jitter}, "m");
    three("velocity", given.velocity, "m/s");
    check("speed", {given.speed.least(), given.speed.greatest()}, "m/s");
    three("angular_velocity", given.angular_velocity, "rad/s");
  }

  void complete_emitter(EmitterKeys& given, const std::string& path) {
    check_start(given, path);
    complete_direction(given.direction, path + ".direction", "direction");
    given.time = given.given_time.value_or(keys_.setup.t0);
    if (timed_ && given.time < keys_.setup.t0) {
      fail(path + ".time", "\"time\" in [[emitter]] is before the start",
           fmt::format("the run starts at {:.9g} s", keys_.setup.t0));
    } else if (timed_ && given.time > end()) {
      fail(path + ".time", "\"time\" in [[emitter]] is after the end", end_hint());
    }
    if (given.kind == EmitterKind::jet && timed_) complete_jet(given, path);
    if (given.kind == EmitterKind::lattice) complete_lattice(given, path);
    at_most_one_of(path, "drag_area");
    if (given.drag_coefficient && !given.radius.varies() && given.radius.a == 0 &&
        !attempted(path, "radius")) {
      fail(path + ".drag_coefficient", "\"drag_coefficient\" in [[emitter]] needs a radius",
           "give radius, or drag_area instead");
    }
    given.drag_area = given.given_drag_area.value_or(solver::Spread{});
    if (given.kind == EmitterKind::book_explosion && std::floor(given.strength) != given.strength) {
      fail(path + ".strength", "\"strength\" in [[emitter]] is not whole",
           "expected whole metres a second: the book draws whole speeds");
    }
    const solver::Domain& domain = keys_.setup.domain;
    for (std::size_t axis = 0; domain.bounded && axis < 3; ++axis) {
      const double at = given.position[axis];
      if (domain.lowest[axis] <= at && at <= domain.highest[axis]) continue;
      fail(path + ".position",
           fmt::format("\"position\" in [[emitter]] is outside the domain in {}", "xyz"[axis]),
           fmt::format("expected {} to {} m", domain.lowest[axis], domain.highest[axis]));
      break;
    }
  }

  void complete_lattice(EmitterKeys& given, const std::string& path) {
    if (!(given.spacing > 0) || unsure(path, "size")) return;  // reported
    double sites = 1;
    for (const double length : given.size) sites *= length / given.spacing;
    if (sites > 0x1p32) {
      fail(path + ".size", fmt::format("the lattice has about {:.3g} sites", sites),
           "expected at most 2^32");
      return;
    }
    given.count = solver::lattice_sites(given);
    if (given.count == 0) {
      fail(path + ".size", "the lattice has no site", "expected more than a spacing each way");
    }
  }

  void complete_jet(EmitterKeys& given, const std::string& path) {
    given.duration = given.given_duration.value_or(end() - given.time);
    const double total = given.rate * given.duration;
    if (given.rate > 0 && !(total >= 1)) {
      fail(path + ".rate", fmt::format("the jet emits {:.9g} particles", total),
           "expected at least 1 within its duration");
    } else if (total > 0x1p40) {
      fail(path + ".rate", fmt::format("the jet emits {:.9g} particles", total),
           "expected at most 2^40 within its duration");
    }
  }

  void complete_frames() {
    const FrameKeys& given = keys_.frame_keys;
    keys_.frames = given;
    if (!at_most_one_of("frames", "every")) return;
    const std::int64_t steps = keys_.steps;
    if (given.count) {
      keys_.frames.every = steps / *given.count;
      if (steps % *given.count != 0) {
        fail("frames.count", not_whole(fmt::format("{} frames", *given.count)),
             fmt::format("such as {}", nearest_divisor(*given.count)));
      }
    } else if (given.per_second) {
      const double every = 1 / (*given.per_second * keys_.setup.dt);
      const double whole = std::round(every);
      const bool fits = whole >= 1 && std::abs(every - whole) <= 1e-6 && whole <= 0x1p31;
      if (!fits) {
        fail("frames.per_second",
             fmt::format("a frame every {:.9g} steps is no whole number of steps", every),
             fmt::format("expected a divisor of {:.9g} steps a second", 1 / keys_.setup.dt));
        return;
      }
      keys_.frames.every = static_cast<std::int64_t>(whole);
      check_every("frames.per_second");
    } else if (given.given_every) {
      keys_.frames.every = *given.given_every;
      check_every("frames.every");
    }
    complete_columns();
  }

  void check_every(const std::string& path) {
    const std::int64_t every = keys_.frames.every;
    if (keys_.steps % every == 0) return;
    fail(path, not_whole(fmt::format("a frame every {} steps", every)),
         fmt::format("such as {} steps", nearest_divisor(every)));
  }
  std::string not_whole(const std::string& what) const {
    return fmt::format("{} do{} not divide the run of {} steps", what,
                       what.ends_with("frames") ? "" : "es", keys_.steps);
  }
  // Of two that are equally near the smaller one.
  std::int64_t nearest_divisor(std::int64_t wanted) const {
    std::int64_t nearest = 1;
    const auto consider = [&](std::int64_t divisor) {
      const std::int64_t off = std::abs(divisor - wanted) - std::abs(nearest - wanted);
      if (off < 0 || (off == 0 && divisor < nearest)) nearest = divisor;
    };
    for (std::int64_t divisor = 1; divisor * divisor <= keys_.steps; ++divisor) {
      if (keys_.steps % divisor != 0) continue;
      consider(divisor);
      consider(keys_.steps / divisor);
    }
    return nearest;
  }

  void complete_columns() {
    const std::vector<soa::ParticleField>& columns = keys_.frames.columns;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      check_column(columns[i], fmt::format("frames.columns.{}", i));
      if (std::find(columns.begin(), columns.begin() + i, columns[i]) == columns.begin() + i) {
        continue;
      }
      fail(fmt::format("frames.columns.{}", i),
           fmt::format("\"{}\" is in \"columns\" twice", soa::field(columns[i]).name),
           "keep one of them");
    }
    if (columns.empty()) {
      fail("frames.columns", "\"columns\" in [frames] is empty", "expected at least one field");
    }
  }

  void check_column(soa::ParticleField column, const std::string& path) {
    const auto refuse = [&](std::string_view of, std::string_view remedy) {
      fail(path, fmt::format("\"{}\" is of {}", soa::field(column).name, of),
           fmt::format("{}, or remove it", remedy));
    };
    const auto field = static_cast<std::size_t>(column);
    const std::optional<models::ContactLaw>& law = keys_.setup.contact_law;
    if (!law) {
      if (soa::only_of_contacts(field)) refuse("particles that touch", "give a [contact_law]");
    } else if (soa::only_of_budgets(field) && !law->energy_budget) {
      refuse("the energy budget", "set energy_budget = true in [contact_law]");
    } else if (column == soa::ParticleField::angular_velocity && !law->turns() &&
               !unsure("contact_law", "friction")) {
      refuse("particles that turn", "give a friction in [contact_law]");
    }
  }

  // What is written for nothing is a mistake: its author expects something of it.
  void refuse_what_does_nothing() {
    const models::ForceSettings& forces = keys_.setup.forces;
    if (!forces.quadratic_drag && forces.linear_drag == 0) {
      for (const char* wind : {"wind", "gust"}) {
        if (!attempted("forces", wind)) continue;
        fail(fmt::format("forces.{}", wind),
             fmt::format("[forces.{}] acts through drag, and there is none", wind),
             "set quadratic_drag = true, or a linear_drag");
      }
    }
    for (std::size_t i = 0; i < keys_.obstacles.size(); ++i) {
      const std::string path = fmt::format("obstacle.{}.motion", i);
      const models::ObstacleMotion& motion = keys_.obstacles[i].motion;
      const auto half_a_swing = [&](const char* given, const char* other) {
        if (!attempted(path, given)) return;
        fail(fmt::format("{}.{}", path, given),
             fmt::format("\"{}\" in [obstacle.motion] is given, but there is no {}", given, other),
             fmt::format("give the {}, or remove it", other));
      };
      const bool swings = motion.amplitude != Triple{};
      if (swings && motion.frequency == 0) half_a_swing("amplitude", "frequency");
      if (!swings && motion.frequency > 0) half_a_swing("frequency", "amplitude");
      // Its samples stand over a grid in x and z.
      if (keys_.obstacles[i].shape == ObstacleShape::height_field &&
          motion.angular_velocity != Triple{}) {
        fail(path + ".angular_velocity", "a height field does not turn",
             "remove angular_velocity, or use a mesh");
      }
    }
    // A field that is recorded is of use without drag, too.
    const std::vector<soa::ParticleField>& columns = keys_.frame_keys.columns;
    const bool recorded =
        std::find(columns.begin(), columns.end(), soa::ParticleField::drag_area) != columns.end();
    for (std::size_t i = 0; !forces.quadratic_drag && !recorded && i < keys_.emitters.size(); ++i) {
      const std::string path = fmt::format("emitter.{}", i);
      for (const Member* given : given_of(path, "drag_area")) {
        mistakes_.add(given->value.place,
                      fmt::format("\"{}\" in [[emitter]] is given, but there is no quadratic drag",
                                  given->key),
                      "set quadratic_drag = true in [forces]");
      }
    }
    const auto has_radius = [](const EmitterKeys& emitter) {
      return emitter.radius.varies() || emitter.radius.a > 0;
    };
    if (forces.buoyancy && std::none_of(keys_.emitters.begin(), keys_.emitters.end(), has_radius)) {
      fail("forces.buoyancy", "\"buoyancy\" in [forces] lifts no particle: all have radius 0",
           "give an emitter a radius");
    }
    if (root_.find("contact") && !root_.find("obstacle") && !keys_.setup.contact_law) {
      fail("contact", "[contact] is given, but there is no [[obstacle]]",
           "add one, or remove [contact]");
    }
  }

  const Value& root_;
  SceneKeys& keys_;
  Mistakes& mistakes_;
  const bool read_whole_;  // no value was wrong
  bool timed_ = false;     // the step and the end are known
  bool followed_ = true;   // by some step, what contacts do
};

}  // namespace

SceneError::SceneError(std::vector<std::string> mistakes)
    : std::runtime_error(fmt::format("{}", fmt::join(mistakes, "\n"))),
      mistakes_(std::move(mistakes)) {}

Scene parse(const std::string& text, const std::string& path,
            const std::vector<std::string>& overrides) {
  const solver::FloatingPointEnvironment environment;
  // Some editors begin a file with a byte order mark, which is no part of its first line.
  constexpr std::string_view mark = "\xEF\xBB\xBF";
  std::string_view body = text;
  if (body.starts_with(mark)) body.remove_prefix(mark.size());
  Mistakes mistakes(path, body, overrides);
  SceneKeys keys;
  keys.path = path;
  if (const std::optional<Value> root = read_document(body, overrides, rival_keys(), mistakes)) {
    Reader reader(scene_section(), mistakes);
    scene_section().read(reader, *root, keys);
    Completion(*root, keys, mistakes).run();
  }
  if (mistakes.count() != 0) throw SceneError(mistakes.texts());
  Scene scene = std::move(keys);
  scene.text = text;
  scene.overrides = overrides;
  return scene;
}

std::string read_scene_file(const std::string& path) {
  const auto refuse = [&](int error) {
    throw std::system_error(error, std::generic_category(), "cannot read " + path);
  };
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) refuse(errno != 0 ? errno : ENOENT);
  std::ostringstream text;
  text << file.rdbuf();
  // A folder opens, but gives nothing.
  if (file.bad() || (text.fail() && errno != 0)) refuse(errno != 0 ? errno : EIO);
  return text.str();
}

Scene load(const std::string& path, const std::vector<std::string>& overrides) {
  return parse(read_scene_file(path), path, overrides);
}

std::string key_reference() {
  return reference(scene_section()) + "\n## Scenes of trajectories\n\n" +
         reference(sweep_section()) + "\n## Units\n\n" + unit_reference();
}

}  // namespace salvo::scene
