#include "scene/scene_keys.hpp"

#include "kernels/math.hpp"

namespace salvo::scene {

namespace {

using models::Blast;
using models::ContactLaw;
using models::ContactLawKind;
using models::ContactResponse;
using models::ContactSettings;
using models::DragLaw;
using models::ForceSettings;
using models::Gust;
using models::Obstacle;
using models::ObstacleMotion;
using models::ObstacleShape;
using models::PointGravity;
using models::Wind;
using models::WindProfile;
using soa::ParticleField;
using solver::BadRowPolicy;
using solver::Emitter;
using solver::EmitterKind;
using solver::EnergyShares;
using solver::IntegratorKind;
using solver::LatticeKind;
using solver::LatticeShape;

constexpr double most_steps = soa::never - 1;
constexpr double most_serials = 0x1p40;

const Section<TimeKeys>& time_section() {
  constexpr KeysOf<TimeKeys> of;
  static const Section<TimeKeys> section(
      "time", false, "the steps: one of dt and steps_per_second, one of duration and steps",
      {
          of.key("start", "s", &TimeKeys::start, "time of step 0"),
          of.key("dt", "s", &TimeKeys::dt, "time step", positive)
              .otherwise("with a contact law: chosen from stiffness and mass"),
          of.key("steps_per_second", "1/s", &TimeKeys::steps_per_second, "the same, as a rate",
                 positive),
          of.key("duration", "s", &TimeKeys::duration, "simulated time, a whole number of steps",
                 positive),
          of.key("steps", "", &TimeKeys::steps, "the same, counted in steps",
                 between(1, most_steps)),
      });
  return section;
}

const Section<PointGravity>& point_gravity_section() {
  constexpr KeysOf<PointGravity> of;
  static const Section<PointGravity> section(
      "forces.point_gravity", true, "attraction to a fixed point, GM d/(|d|^2 + softening^2)^(3/2)",
      {
          of.key("position", "m", &PointGravity::center, "the centre").must(),
          of.key("strength", "m^3/s^2", &PointGravity::strength, "GM; negative repels").must(),
          of.key("softening", "m", &PointGravity::softening, "length that rounds off the centre",
                 not_negative),
      });
  return section;
}

const Section<Wind>& wind_section() {
  constexpr KeysOf<Wind> of;
  constexpr Kinds sheared = kinds(WindProfile::power_law, WindProfile::log_law);
  static const Section<Wind> section =
      Section<Wind>(
          "forces.wind", false, "mean wind; it acts through drag",
          {
              of.word("profile", &Wind::profile, "how the wind changes with height",
                      {{"uniform", WindProfile::uniform, "the same everywhere"},
                       {"power_law", WindProfile::power_law,
                        "velocity (h/reference_height)^exponent, none at and below the ground"},
                       {"log_law", WindProfile::log_law,
                        "velocity ln(h/roughness)/ln(reference_height/roughness), none up to the "
                        "roughness"}}),
              of.key("velocity", "m/s", &Wind::velocity, "the wind, at the reference height")
                  .must(),
              of.key("reference_height", "m", &Wind::reference_height,
                     "height of the given velocity", positive)
                  .only(sheared),
              of.key("exponent", "", &Wind::exponent, "power of the height", not_negative)
                  .only(kinds(WindProfile::power_law)),
              of.key("roughness", "m", &Wind::roughness, "roughness length", positive)
                  .only(kinds(WindProfile::log_law)),
              of.key("ground", "m", &Wind::ground, "where heights, along forces.up, begin")
                  .only(sheared),
          })
          .decided_by([](const Wind& wind) { return static_cast<int>(wind.profile); });
  return section;
}

const Section<Gust>& gust_section() {
  constexpr KeysOf<Gust> of;
  static const Section<Gust> section(
      "forces.gust", false,
      "gusts on top of the wind: eight sinusoids an axis, of wavelengths length/1 to length/8",
      {
          of.key("standard_deviation", "m/s", &Gust::standard_deviation, "of each axis",
                 not_negative)
              .must(),
          of.key("length", "m", &Gust::length, "longest wavelength", positive),
          of.key("speed", "m/s", &Gust::speed, "speed at which the pattern is carried along",
                 positive)
              .otherwise("the mean wind's"),
          of.key("direction", "", &Gust::direction, "where the pattern is carried, of any length")
              .otherwise("the mean wind's, or x"),
      });
  return section;
}

const Section<Blast>& blast_section() {
  constexpr KeysOf<Blast> of;
  static const Section<Blast> section(
      "forces.blast", true,
      "a blast: outward acceleration J/(m tau) (r0/max(r, r0))^n e^(-(t - t0)/tau) from t0 on",
      {
          of.key("position", "m", &Blast::center, "the centre").must(),
          of.key("time", "s", &Blast::time, "t0"),
          of.key("impulse", "N s", &Blast::impulse, "J, at the reference radius").must(),
          of.key("duration", "s", &Blast::duration, "tau; best several steps long", positive),
          of.key("reference_radius", "m", &Blast::reference_radius, "r0", positive),
          of.key("exponent", "", &Blast::exponent, "n", between(0, 16)),
      });
  return section;
}

const Section<ForceSettings>& force_section() {
  constexpr KeysOf<ForceSettings> of;
  static const Section<ForceSettings> section(
      "forces", false, "what acts on every particle",
      {
          of.key("gravity", "m/s^2", &ForceSettings::gravity, "uniform gravity"),
          of.key("up", "", &ForceSettings::up, "direction, of any length, of heights in the wind"),
          of.key("air_density", "kg/m^3", &ForceSettings::air_density, "of drag and buoyancy",
                 not_negative),
          of.key("quadratic_drag", "", &ForceSettings::quadratic_drag,
                 "drag 1/2 rho (Cd A) |u| u, u the velocity relative to the air"),
          of.word("drag_law", &ForceSettings::drag_law, "what drag is relative to",
                  {{"relative_flow", DragLaw::relative_flow, "the moving air"},
                   {"book_still_air", DragLaw::book_still_air,
                    "still air, and the wind is a constant push: chapter 8 of the book"}}),
          of.key("linear_drag", "kg/s", &ForceSettings::linear_drag,
                 "c of the drag c u; 0 for none", not_negative),
          of.key("buoyancy", "", &ForceSettings::buoyancy,
                 "lift by the air that a particle's sphere displaces"),
          of.table(
              "wind", wind_section(), [](ForceSettings & forces) -> auto& {
                forces.windy = true;
                return forces.wind;
              }),
          of.table(
              "gust", gust_section(), [](ForceSettings & forces) -> auto& {
                forces.gusty = true;
                return forces.gust;
              }),
          of.list("point_gravity", point_gravity_section(), &ForceSettings::point_gravity),
          of.list("blast", blast_section(), &ForceSettings::blasts),
      });
  return section;
}

const Section<ContactSettings>& contact_section() {
  constexpr KeysOf<ContactSettings> of;
  static const Section<ContactSettings> section =
      Section<ContactSettings>(
          "contact", false, "how particles meet obstacles",
          {
              of.word("response", &ContactSettings::response, "how a particle is turned back",
                      {{"swept", ContactResponse::swept,
                        "the path of the step is tested and continued after the impact; nothing "
                        "tunnels"},
                       {"impulse", ContactResponse::impulse,
                        "the velocity of a penetrating particle is changed before the step"},
                       {"force", ContactResponse::force,
                        "the impact force is the only force of a step: chapter 8 of the book"}}),
              of.key("max_impacts", "", &ContactSettings::max_impacts,
                     "impacts a step; one more lays the particle to rest on the surface",
                     between(1, 1000))
                  .only(kinds(ContactResponse::swept)),
              of.key("interpolate_at_plane", "", &ContactSettings::interpolate_at_plane,
                     "move a particle back along its path to the plane; the book's listing resets "
                     "the height alone")
                  .only(kinds(ContactResponse::force)),
          })
          .decided_by([](const ContactSettings& s) { return static_cast<int>(s.response); });
  return section;
}

const Section<ContactLaw>& contact_law_section() {
  constexpr KeysOf<ContactLaw> of;
  constexpr Kinds linear = kinds(ContactLawKind::linear_spring);
  constexpr Kinds hertz = kinds(ContactLawKind::hertz_mindlin);
  static const Section<ContactLaw> section =
      Section<ContactLaw>(
          "contact_law", false,
          "particles that touch: each other, and obstacles through the same law; without it they "
          "pass through each other",
          {
              of.word("kind", &ContactLaw::kind, "the force of an overlap",
                      {{"linear_spring", ContactLawKind::linear_spring,
                        "normal_stiffness times the overlap, and a dashpot"},
                       {"hertz_mindlin", ContactLawKind::hertz_mindlin,
                        "elastic spheres of one material, and a dashpot"},
                       {"impulse", ContactLawKind::impulse,
                        "the book's impulse between all that overlap and approach; needs a dt"}})
                  .must(),
              of.key("normal_stiffness", "N/m", &ContactLaw::normal_stiffness,
                     "of the linear spring", positive)
                  .only(linear)
                  .must(),
              of.key("tangential_ratio", "", &ContactLaw::tangential_ratio,
                     "tangential stiffness over the normal one", above(0, 1e3))
                  .only(linear),
              of.key("young_modulus", "Pa", &ContactLaw::young_modulus, "of the material", positive)
                  .only(hertz)
                  .must(),
              of.key("poisson_ratio", "", &ContactLaw::poisson_ratio, "of the material",
                     between(0, 0.5))
                  .only(hertz),
              of.key("restitution", "", &ContactLaw::restitution,
                     "of a head-on impact of two particles; an obstacle has its own",
                     between(0, 1)),
              of.key("tangential_damping", "", &ContactLaw::tangential_damping,
                     "over the normal damping", between(0, 1))
                  .only(linear | hertz),
              of.key("friction", "", &ContactLaw::friction,
                     "Coulomb coefficient between particles; with it they turn", not_negative),
              of.key("rolling_friction", "", &ContactLaw::rolling_friction,
                     "greatest rolling moment over the normal force and the effective radius",
                     not_negative)
                  .only(linear | hertz),
              of.key("surface_energy", "J/m^2", &ContactLaw::surface_energy,
                     "cohesion: spheres that touch pull with 4 pi times this and the effective "
                     "radius",
                     not_negative)
                  .only(linear | hertz),
              of.key("push_out", "", &ContactLaw::push_out,
                     "part of an overlap that a step takes back", between(0, 1))
                  .only(kinds(ContactLawKind::impulse)),
              of.key("energy_budget", "", &ContactLaw::energy_budget,
                     "keep the heat that each particle's contacts make, and what they gave it"),
              of.key("relax", "", &ContactLaw::relax,
                     "move particles apart that overlap others or obstacles by more than 1 % of "
                     "the smaller radius when they are emitted; without it that is an error"),
          })
          .decided_by([](const ContactLaw& law) { return static_cast<int>(law.kind); });
  return section;
}

const Section<ObstacleMotion>& motion_section() {
  constexpr KeysOf<ObstacleMotion> of;
  static const Section<ObstacleMotion> section(
      "obstacle.motion", false,
      "a given motion, for particles that touch: at time t the obstacle has moved by velocity t + "
      "amplitude sin(2 pi frequency t) and turned by angular_velocity t about its position",
      {
          of.key("velocity", "m/s", &ObstacleMotion::velocity, "steady"),
          of.key("amplitude", "m", &ObstacleMotion::amplitude, "of a swing to and fro"),
          of.key("frequency", "1/s", &ObstacleMotion::frequency, "of the swing", not_negative),
          of.key("angular_velocity", "rad/s", &ObstacleMotion::angular_velocity,
                 "along the axis that it turns about"),
      });
  return section;
}

const Section<Hills>& hills_section() {
  constexpr KeysOf<Hills> of;
  static const Section<Hills> section(
      "obstacle.hills", false, "rolling hills: eight waves of random direction and phase",
      {
          of.key("columns", "", &Hills::columns, "samples along x", between(2, 0x1p24)).must(),
          of.key("rows", "", &Hills::rows, "samples along z", between(2, 0x1p24)).must(),
          of.key("deviation", "m", &Hills::deviation, "standard deviation of the heights",
                 not_negative)
              .must(),
          of.key("length", "m", &Hills::length, "longest wavelength", positive).must(),
          of.key("seed", "", &Hills::seed, "of directions and phases", not_negative),
      });
  return section;
}

const Section<ObstacleKeys>& obstacle_section() {
  constexpr KeysOf<ObstacleKeys> of;
  using Shape = ObstacleShape;
  constexpr Kinds round = kinds(Shape::sphere, Shape::capsule, Shape::cylinder);
  constexpr Kinds long_ones = kinds(Shape::capsule, Shape::cylinder);
  constexpr Kinds field = kinds(Shape::height_field);
  static const Section<ObstacleKeys> section =
      Section<ObstacleKeys>(
          "obstacle", true, "an obstacle; obstacles are met in the order of the file",
          {
              of.word("shape", &Obstacle::shape, "what it is", words_of<Shape>()).must(),
              of.key("position", "m", &Obstacle::center,
                     "a point of a plane, the middle of a solid, the corner of least x and z of a "
                     "height field"),
              of.key("normal", "", &Obstacle::axis, "out of the plane, of any length")
                  .only(kinds(Shape::plane)),
              of.key("axis", "", &Obstacle::axis, "direction, of any length").only(long_ones),
              of.key("radius", "m", &Obstacle::radius, "radius", positive).only(round).must(),
              of.key("half_length", "m", &Obstacle::half_length,
                     "half the segment of a capsule, half the height of a cylinder", positive)
                  .only(long_ones)
                  .must(),
              of.key("half_size", "m", &Obstacle::half_size, "half the edges", positive)
                  .only(kinds(Shape::box))
                  .must(),
              of.key("rotation_axis", "", &ObstacleKeys::rotation_axis,
                     "what it is turned about, of any length")
                  .only(kinds(Shape::box, Shape::mesh)),
              of.key("rotation_angle", "rad", &ObstacleKeys::rotation_angle, "by how much")
                  .only(kinds(Shape::box, Shape::mesh)),
              of.key("file", "", &ObstacleKeys::mesh_file,
                     "of the mesh, OBJ or PLY, beside the scene; its origin is at the position")
                  .only(kinds(Shape::mesh))
                  .must(),
              of.key("scale", "", &ObstacleKeys::scale, "of the numbers in the file, to metres",
                     positive)
                  .only(kinds(Shape::mesh)),
              of.key("spacing", "m", &ObstacleKeys::spacing, "between samples", positive)
                  .only(field)
                  .must(),
              of.key("heights", "m", &ObstacleKeys::heights,
                     "rows of samples, each along x, the rows along z")
                  .only(field),
              of.table(
                    "hills", hills_section(),
                    [](ObstacleKeys & obstacle) -> auto& { return obstacle.hills.emplace(); })
                  .only(field),
              of.key("restitution", "", &Obstacle::restitution,
                     "speed of separation over that of approach", between(0, 1)),
              of.key("friction", "", &Obstacle::friction, "Coulomb coefficient", not_negative),
              of.key("mass", "kg", &Obstacle::mass,
                     "takes part in the impulse of [contact] alone: the obstacle stays", positive)
                  .otherwise("infinite"),
              of.key("hollow", "", &Obstacle::hollow,
                     "particles are inside; only of particles that touch")
                  .only(kinds(Shape::sphere, Shape::box, Shape::capsule, Shape::cylinder)),
              of.table(
                  "motion", motion_section(),
                  [](ObstacleKeys & obstacle) -> auto& { return obstacle.motion; }),
          })
          .decided_by([](const ObstacleKeys& o) { return static_cast<int>(o.shape); });
  return section;
}

const Section<DomainKeys>& domain_section() {
  constexpr KeysOf<DomainKeys> of;
  static const Section<DomainKeys> section(
      "domain", false, "where particles may be",
      {
          of.key("lowest", "m", &DomainKeys::lowest, "corner of least x, y and z"),
          of.key("highest", "m", &DomainKeys::highest, "the opposite corner"),
          of.word("on_leave", &DomainKeys::on_leave,
                  "what follows when a particle leaves the domain or becomes non-finite",
                  {{"stop", BadRowPolicy::stop, "the run stops and names the particle"},
                   {"remove", BadRowPolicy::remove, "the particle is removed and counted"}}),
      });
  return section;
}

const Section<EmitterKeys>& emitter_section() {
  constexpr KeysOf<EmitterKeys> of;
  using Kind = EmitterKind;
  constexpr Kinds book = kinds(Kind::book_explosion);
  constexpr Kinds budget = kinds(Kind::energy_explosion);
  constexpr Kinds jet = kinds(Kind::jet);
  constexpr Kinds narrow = kinds(Kind::cone, Kind::jet);
  constexpr Kinds at_speed = kinds(Kind::burst, Kind::shell, Kind::cone, Kind::jet, Kind::lattice);
  constexpr Kinds lattice = kinds(Kind::lattice);
  static const Section<EmitterKeys> section =
      Section<EmitterKeys>(
          "emitter", true, "a source of particles",
          {
              of.word("kind", &Emitter::kind, "what it is", words_of<Kind>()).must(),
              of.key("name", "", &Emitter::name, "for messages and reports"),
              of.key("stream", "", &EmitterKeys::given_stream,
                     "number line of its ids and random draws, unique",
                     between(0, static_cast<double>(soa::max_stream - 1)))
                  .otherwise("its place in the list, from 0"),
              of.key("count", "", &Emitter::count, "particles", between(1, most_serials))
                  .only(~(jet | lattice))
                  .must(),
              of.key("time", "s", &EmitterKeys::given_time, "when it fires, or begins to")
                  .otherwise("the start"),
              of.key("position", "m", &Emitter::position, "the centre"),
              of.key("velocity", "m/s", &Emitter::velocity, "added to every particle's")
                  .only(~budget),
              of.key("source_radius", "m", &Emitter::source_radius,
                     "of the ball (the sphere of a shell) from which particles start", not_negative)
                  .only(~(book | lattice)),
              of.word("lattice", &Emitter::lattice, "where the sites are",
                      {{"cubic", LatticeKind::cubic, "at the corners of cubes"},
                       {"close_packed", LatticeKind::close_packed,
                        "in hexagonal layers, as densely as equal spheres go"}})
                  .only(lattice),
              of.word("shape", &Emitter::shape, "what the lattice fills of its box",
                      {{"box", LatticeShape::box, "all"},
                       {"ellipsoid", LatticeShape::ellipsoid, "the largest one"},
                       {"cone", LatticeShape::cone, "the largest one that points up, along y"}})
                  .only(lattice),
              of.key("spacing", "m", &Emitter::spacing,
                     "of the nearest sites; layers follow one another along y", positive)
                  .only(lattice)
                  .must(),
              of.key("size", "m", &Emitter::size,
                     "of the box about the position; sites keep half a spacing from its faces",
                     positive)
                  .only(lattice)
                  .must(),
              of.key("jitter", "m", &Emitter::jitter,
                     "greatest random displacement from the site along each axis", not_negative)
                  .only(lattice),
              of.key("direction", "", &Emitter::direction, "axis of the cone, of any length")
                  .only(narrow),
              of.key("half_angle", "rad", &Emitter::half_angle, "of the cone",
                     between(0, kernels::pi))
                  .only(narrow),
              of.key("rate", "1/s", &Emitter::rate, "particles a second", positive)
                  .only(jet)
                  .must(),
              of.key("duration", "s", &EmitterKeys::given_duration, "of the jet", positive)
                  .only(jet)
                  .otherwise("to the end"),
              of.key("speed", "m/s", &Emitter::speed, "of the particles", not_negative)
                  .only(at_speed),
              of.key("strength", "m/s", &Emitter::strength, "greatest speed, whole",
                     between(0, 0x1p53))
                  .only(book)
                  .must(),
              of.key("angle", "rad", &Emitter::angle,
                     "0 right, 90 degrees up; particles within 10 degrees of it")
                  .only(book)
                  .kept_in("deg")
                  .otherwise("all directions"),
              of.key("longest_life", "s", &Emitter::life_ms, "life of the longest-lived", positive)
                  .only(book)
                  .kept_in("ms")
                  .otherwise("4"),
              of.key("energy", "J", &Emitter::energy, "budget of kinetic energy", positive)
                  .only(budget)
                  .must(),
              of.word("shares", &Emitter::shares, "how the budget is shared out",
                      {{"equal", EnergyShares::equal, "all the same"},
                       {"uniform", EnergyShares::uniform, "uniform on 0 to twice the mean"},
                       {"normal", EnergyShares::normal,
                        "normal, a quarter of the mean wide, within 0 to twice the mean"},
                       {"book", EnergyShares::book,
                        "each in turn draws a speed from what is left: the first take nearly all"}})
                  .only(budget),
              of.key("angular_velocity", "rad/s", &Emitter::angular_velocity,
                     "of particles that touch, with friction"),
              of.field(ParticleField::mass, &Emitter::mass),
              of.field(ParticleField::radius, &Emitter::radius),
              of.field(ParticleField::drag_area, &EmitterKeys::given_drag_area).otherwise("0"),
              of.key("drag_coefficient", "", &Emitter::drag_coefficient,
                     "in place of drag_area: that is then the coefficient times pi radius^2",
                     between(0, 1e6)),
              of.key("life", "s", &Emitter::life, "time after which a particle is gone", positive)
                  .only(~book)
                  .otherwise("none: for ever"),
              of.field(ParticleField::group, &Emitter::group),
          })
          .decided_by([](const EmitterKeys& e) { return static_cast<int>(e.kind); });
  return section;
}

Words field_words() {
  Words words;
  for (std::size_t f = 0; f < soa::particle_fields.size(); ++f) {
    const soa::Field& field = soa::particle_fields[f];
    words.emplace_back(field.name, static_cast<ParticleField>(f), field.meaning);
  }
  return words;
}

const Section<FrameKeys>& frame_section() {
  constexpr KeysOf<FrameKeys> of;
  static const Section<FrameKeys> section(
      "frames", false,
      "what a recording keeps: at most one of every, count and per_second; frame 0 is step 0",
      {
          of.key("every", "", &FrameKeys::given_every, "steps from frame to frame",
                 between(1, most_steps))
              .otherwise("1"),
          of.key("count", "", &FrameKeys::count, "frames after frame 0", between(1, most_steps)),
          of.key("per_second", "1/s", &FrameKeys::per_second, "frames a second", positive),
          of.word("columns", &FrameSettings::columns, "fields that are kept", field_words()),
          of.key("fraction", "", &FrameSettings::fraction,
                 "of the particles, chosen by a hash of the id: the same ones in every frame",
                 above(0, 1)),
      });
  return section;
}

const Section<CheckpointSettings>& checkpoint_section() {
  constexpr KeysOf<CheckpointSettings> of;
  static const Section<CheckpointSettings> section(
      "checkpoint", false, "full states, from which a run goes on with the same bits",
      {
          of.key("every", "", &CheckpointSettings::every,
                 "steps from checkpoint to checkpoint; 0 for none on the way",
                 between(0, most_steps)),
          of.key("at_end", "", &CheckpointSettings::at_end, "one after the last step"),
      });
  return section;
}

const Section<VerifySettings>& verify_section() {
  constexpr KeysOf<VerifySettings> of;
  static const Section<VerifySettings> section(
      "verify", false, "the size at which the scene is verified",
      {
          of.key("rows", "", &VerifySettings::rows,
                 "emitters are scaled down to at most this many particles", at_least(1)),
          of.key("steps", "", &VerifySettings::steps, "steps at most; 0 for all",
                 between(0, most_steps)),
      });
  return section;
}

}  // namespace

std::span<const Rivals> rival_keys() {
  static const std::vector<Rivals> groups{{"time", {"dt", "steps_per_second"}},
                                          {"time", {"duration", "steps"}},
                                          {"obstacle", {"heights", "hills"}},
                                          {"emitter", {"drag_area", "drag_coefficient"}},
                                          {"frames", {"every", "count", "per_second"}}};
  return groups;
}

const Section<SceneKeys>& scene_section() {
  constexpr KeysOf<SceneKeys> of;
  static const Section<SceneKeys> section(
      "", false, "what to simulate",
      {
          of.key("title", "", &Scene::title, "one line for people"),
          of.word(
              "precision", [](Scene & scene) -> auto& { return scene.setup.precision; },
              "how wide the numbers of the particles are", words_of<soa::Precision>()),
          of.key(
              "seed", "", [](Scene & scene) -> auto& { return scene.setup.seed; },
              "of every random draw", not_negative),
          of.word(
              "integrator", [](Scene & scene) -> auto& { return scene.setup.integrator; },
              "how a step is taken", words_of<IntegratorKind>()),
          of.table("time", time_section(), &SceneKeys::time).must(),
          of.table(
              "forces", force_section(), [](Scene & scene) -> auto& { return scene.setup.forces; }),
          of.table(
              "contact", contact_section(),
              [](Scene & scene) -> auto& { return scene.setup.contact; }),
          of.table(
              "contact_law", contact_law_section(),
              [](Scene & scene) -> auto& { return scene.setup.contact_law.emplace(); }),
          of.list("obstacle", obstacle_section(), &SceneKeys::obstacles),
          of.table("domain", domain_section(), &SceneKeys::domain),
          of.list("emitter", emitter_section(), &SceneKeys::emitters).must(),
          of.table("frames", frame_section(), &SceneKeys::frame_keys),
          of.table("checkpoint", checkpoint_section(), &Scene::checkpoint),
          of.table("verify", verify_section(), &Scene::verify),
      });
  return section;
}

}  // namespace salvo::scene
