// Particle explosions: the book's kinematic one and the one with an energy budget.   [Bourg &
// Bywalec 2.6, 18.4]
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "tests/physics/flight.hpp"

namespace salvo::tests {

namespace {

using solver::EnergyShares;
using solver::Execution;
using solver::World;

// y is up here and down on the book's screen, so its gravity of 30 points along -y and its angles
// keep their sense: 90 is up.
solver::Setup book_setup() {
  solver::Setup setup = plain_setup();
  setup.integrator = IntegratorKind::velocity_verlet;
  setup.forces.gravity = {0, -30, 0};
  return setup;
}

Emitter book_explosion(std::uint64_t count) {
  Emitter emitter;
  emitter.kind = EmitterKind::book_explosion;
  emitter.stream = 1;
  emitter.count = count;
  emitter.strength = 75;
  emitter.life_ms = 4000;
  return emitter;
}

constexpr std::uint64_t many = 50 * 333;

// The angle of a velocity in whole degrees of [0, 360).
int whole_angle(const Particle& p) {
  const double angle = std::atan2(p.velocity[1], p.velocity[0]) / degree;
  const double rounded = std::round(angle);
  EXPECT_NEAR(angle, rounded, 1e-10);
  return (static_cast<int>(rounded) + 360) % 360;
}

}  // namespace

// ---- 2.6
// ------------------------------------------------------------------------------------------

TEST(BookExplosion, PathsAreTheBooks) {  // PE1, A6.1, A6.2; y up
  struct Row {
    double angle, t, x, y;
  };
  const Row rows[] = {{0, 1, 75, -15},
                      {0, 4, 300, -240},
                      {90, 1, 0, 60},
                      {90, 4, 0, 60},
                      {90, 2.5, 0, 93.75},
                      {90, 5, 0, 0},
                      {-90, 4, 0, -540},
                      {45, 1, 53.033009, 38.033009},
                      {45, 4, 212.132034, -27.867966},
                      {-45, 4, 212.1320344, -452.1320344}};
  for (const Row& row : rows) {
    const auto with_pi = [&](double value) {
      const double angle = row.angle * value / 180;
      Flight flight(book_setup(), {0, 0, 0}, {75 * std::cos(angle), 75 * std::sin(angle), 0});
      return flight.at_time(row.t).position;
    };
    const auto p = with_pi(pi);
    EXPECT_NEAR(p[0], row.x, 6e-7) << row.angle << " deg, " << row.t << " s";
    EXPECT_NEAR(p[1], row.y, 6e-7) << row.angle << " deg, " << row.t << " s";
    const auto books = with_pi(3.14159);  // of the listing
    EXPECT_NEAR(books[0], p[0], 1e-3) << row.angle << " deg, " << row.t << " s";
    EXPECT_NEAR(books[1], p[1], 1e-3) << row.angle << " deg, " << row.t << " s";
  }
}

// PE2, PE3: drawn ceil(life/10 ms) times, fading as 1 - age/life from 1 to a last value in (0, 10
// ms/life].
TEST(BookExplosion, ALifeLastsItsWholeNumberOfFrames) {
  struct Row {
    double life_ms;
    std::int64_t draws;
  };
  for (const Row row : {Row{3200, 320}, Row{3205, 321}, Row{3999, 400}, Row{4000, 400}}) {
    solver::Setup setup = book_setup();
    setup.emitters = {particles_from(1, {0, 0, 0}, {1, 1, 0}, 3)};
    setup.emitters[0].life = constant(row.life_ms / 1000);
    World world(setup, {});
    std::int64_t draws = 0;
    double fade = 0;
    for (std::int64_t step = 0; step < 500; ++step) {
      world.advance_to(step);
      if (world.particles().rows() != 3) continue;
      fade = 1 - 1000 * world.time() / row.life_ms;
      if (draws == 0) {
        EXPECT_EQ(fade, 1) << row.life_ms;
      }
      ++draws;
    }
    EXPECT_EQ(draws, row.draws) << row.life_ms;
    EXPECT_GT(fade, 0) << row.life_ms;
    EXPECT_LE(fade, 10 / row.life_ms + 1e-12) << row.life_ms;
  }
}

TEST(BookExplosion, LivesAre80To100PercentInWholePercent) {  // PE2, A6.3
  solver::Setup setup = book_setup();
  setup.emitters = {book_explosion(many)};
  World world(setup, {});
  std::set<std::int32_t> deaths;
  for (const Particle& p : read_particles(world.particles())) deaths.insert(p.death);
  std::set<std::int32_t> wanted;
  for (int percent = 80; percent <= 100; ++percent) wanted.insert(4 * percent);
  EXPECT_EQ(deaths, wanted);
  world.advance_to(319);
  EXPECT_EQ(world.particles().rows(), many);
  world.advance_to(320);
  EXPECT_LT(world.particles().rows(), many);
  world.advance_to(399);
  EXPECT_GT(world.particles().rows(), 0U);
  world.advance_to(400);
  EXPECT_EQ(world.particles().rows(), 0U);
}

TEST(BookExplosion, SpeedsAreWholeFromHalfTheStrengthOn) {  // PE3, A6.4
  solver::Setup setup = book_setup();
  setup.emitters = {book_explosion(many)};
  const World world(setup, {});
  std::map<int, int> counts;
  double squares = 0;
  for (const Particle& p : read_particles(world.particles())) {
    EXPECT_NEAR(speed(p), std::round(speed(p)), 1e-12);
    ++counts[static_cast<int>(std::lround(speed(p)))];
    squares += speed(p) * speed(p);
    EXPECT_EQ(p.velocity[2], 0);
    EXPECT_EQ(p.position, (std::array<double, 3>{0, 0, 0}));
  }
  EXPECT_EQ(counts.size(), 39U);
  EXPECT_EQ(counts.begin()->first, 37);
  EXPECT_EQ(counts.rbegin()->first, 75);
  double mean_square = 0;
  for (int v = 37; v <= 75; ++v) mean_square += v * v / 39.0;
  EXPECT_NEAR(squares / many, mean_square, 5 * 1270 / std::sqrt(static_cast<double>(many)));
}

TEST(BookExplosion, AnglesAreWholeDegreesAllAroundOrWithin10) {  // PE3
  solver::Setup setup = book_setup();
  setup.emitters = {book_explosion(many)};
  std::map<int, int> around;
  for (const Particle& p : read_particles(World(setup, {}).particles())) ++around[whole_angle(p)];
  EXPECT_EQ(around.size(), 360U);
  // 0 and 360 are the same direction, so it comes twice as often.
  EXPECT_NEAR(around[0], 2.0 * many / 361, 5 * std::sqrt(2.0 * many / 361));

  setup.emitters[0].angle = 90;
  std::map<int, int> aimed;
  for (const Particle& p : read_particles(World(setup, {}).particles())) ++aimed[whole_angle(p)];
  EXPECT_EQ(aimed.size(), 21U);
  EXPECT_EQ(aimed.begin()->first, 80);
  EXPECT_EQ(aimed.rbegin()->first, 100);
  for (const auto& [angle, count] : aimed) {  // an offset of 0 has both signs
    const double expected = many / 22.0 * (angle == 90 ? 2 : 1);
    EXPECT_NEAR(count, expected, 5 * std::sqrt(expected)) << angle;
  }
}

TEST(Burst, MeanSquareSpeedOfAUniformSpread) {  // A6.5: 7/12 V0^2 on [V0/2, V0]
  solver::Setup setup = book_setup();
  setup.emitters = {burst(1, 99'999)};
  setup.emitters[0].speed = uniform(37.5, 75);
  double squares = 0;
  for (const Particle& p : read_particles(World(setup, {}).particles())) {
    EXPECT_GE(speed(p), 37.5 * (1 - 1e-15));
    EXPECT_LT(speed(p), 75 * (1 + 1e-15));
    squares += speed(p) * speed(p);
  }
  // The variance of v^2 is V0^4 (31/80 - 49/144).
  const double deviation = 75 * 75 * std::sqrt(31 / 80.0 - 49 / 144.0);
  EXPECT_NEAR(squares / 99'999, 7 / 12.0 * 75 * 75, 5 * deviation / std::sqrt(99'999.0));
}

TEST(BookExplosion, KeepsCentreOfMassAndEnergyAndItsClosedForm) {  // PE3, A6.6, A6.7, A6.8
  for (const bool semi_implicit : {false, true}) {
    solver::Setup setup = book_setup();
    if (semi_implicit) setup.integrator = IntegratorKind::semi_implicit_euler;
    setup.emitters = {book_explosion(50)};
    World world(setup, {});
    const std::vector<Particle> born = read_particles(world.particles());
    for (const std::int64_t step : {1, 33, 319, 333, 390}) {
      world.advance_to(step);
      const double t = world.time();
      // The book's step moves with the new velocity: exactly g dt t/2 too low.
      const double late = semi_implicit ? -30 * setup.dt * t / 2 : 0;
      std::array<double, 2> mean{};
      const std::vector<Particle> alive = read_particles(world.particles());
      for (const Particle& p : alive) {
        const Particle& start = born[soa::serial_of(p.id)];
        const double x = start.velocity[0] * t;
        const double y = start.velocity[1] * t - 15 * t * t + late;
        EXPECT_NEAR(p.position[0], x, 1e-10);
        EXPECT_NEAR(p.position[1], y, 1e-10);
        mean[0] += x / static_cast<double>(alive.size());
        mean[1] += y / static_cast<double>(alive.size());
        if (semi_implicit) continue;
        const double energy = speed(p) * speed(p) / 2 + 30 * p.position[1];
        const double start_energy = speed(start) * speed(start) / 2;
        EXPECT_NEAR(energy, start_energy, start_energy * 1e-12);
      }
      ASSERT_FALSE(alive.empty()) << step;
      EXPECT_NEAR(world.diagnose().center_of_mass[0], mean[0], 1e-10);
      EXPECT_NEAR(world.diagnose().center_of_mass[1], mean[1], 1e-10);
    }
  }
}

TEST(BookExplosion, OfAMillionHasTheSameBitsForAnyWidthAndThreads) {  // PE4, A6.9
  solver::Setup setup = book_setup();
  setup.precision = Precision::float32;
  setup.emitters = {book_explosion(1'000'000)};
  const auto hash = [&](const Execution& execution) {
    World world(setup, execution);
    world.advance_to(33);
    return to_string(world.hash().total);
  };
  const std::string wanted = hash({solver::Isa::scalar, 1, 16});
  EXPECT_EQ(hash({solver::widest_isa(), 13, 64}), wanted);
  EXPECT_EQ(hash({solver::widest_isa(), 2, 7}), wanted);
}

// ---- 18.4.1
// ---------------------------------------------------------------------------------------

namespace {

constexpr double bullet_energy = 566.5725;  // J: 7.45 g at 390 m/s

Emitter energy_explosion(std::uint64_t count, EnergyShares shares, double mass = 0.005,
                         double energy = bullet_energy) {
  Emitter emitter;
  emitter.kind = EmitterKind::energy_explosion;
  emitter.stream = 1;
  emitter.count = count;
  emitter.shares = shares;
  emitter.mass = constant(mass);
  emitter.energy = energy;
  return emitter;
}

constexpr EnergyShares all_shares[] = {EnergyShares::equal, EnergyShares::uniform,
                                       EnergyShares::normal, EnergyShares::book};

std::vector<Particle> exploded(const Emitter& emitter, Precision precision = Precision::float64,
                               std::uint64_t seed = 3) {
  solver::Setup setup = plain_setup(precision);
  setup.seed = seed;
  setup.emitters = {emitter};
  return read_particles(World(setup, {solver::widest_isa(), 1, 1}).particles());
}

// Exact enough to tell: 64 bits of mantissa against products and sums of stored values.
long double kinetic_energy(const std::vector<Particle>& particles) {
  long double sum = 0;
  for (const Particle& p : particles) {
    long double v2 = 0;
    for (const double v : p.velocity) v2 += static_cast<long double>(v) * v;
    sum += static_cast<long double>(p.mass) * v2 / 2;
  }
  return sum;
}

}  // namespace

TEST(EnergyExplosion, NeverExceedsItsBudget) {
  for (const Precision precision : {Precision::float32, Precision::float64}) {
    for (const EnergyShares shares : all_shares) {
      for (const std::uint64_t count : {1, 3, 50, 999, 12345}) {
        for (std::uint64_t seed = 0; seed < (count > 100 ? 3 : 33); ++seed) {
          for (const bool varied : {false, true}) {
            Emitter emitter = energy_explosion(count, shares);
            if (varied) emitter.mass = uniform(0.001, 0.02);
            const std::vector<Particle> particles = exploded(emitter, precision, seed);
            const auto energy = kinetic_energy(particles);
            ASSERT_LE(energy, static_cast<long double>(bullet_energy))
                << count << " particles, shares " << static_cast<int>(shares) << ", seed " << seed;
            if (shares == EnergyShares::book) continue;  // leaves a rest
            ASSERT_GE(energy, static_cast<long double>(bullet_energy) *
                                  (precision == Precision::float32 ? 1 - 1e-6L : 1 - 1e-11L));
          }
        }
      }
    }
  }
}

TEST(EnergyExplosion, EqualSharesHaveTheBooksSpeeds) {
  struct Row {
    double mass, speed, tolerance;
  };
  for (const Row row : {Row{0.001, 150.5420, 6e-5}, Row{0.005, 67.32444, 6e-6},
                        Row{0.010, 47.60557, 6e-6}, Row{0.25, 9.521113, 6e-7}}) {
    for (const Particle& p : exploded(energy_explosion(50, EnergyShares::equal, row.mass))) {
      EXPECT_NEAR(speed(p), row.speed, row.tolerance) << row.mass;
    }
  }
  // The round that "holds about 400 J", in the listing's gravel of 0.25 kg.
  for (const Particle& p : exploded(energy_explosion(50, EnergyShares::equal, 0.25, 400))) {
    EXPECT_NEAR(speed(p), 8, 1e-10);
  }
}

// 18.4.2, A8.3: of 1 kg of TNT a third goes to five pieces that do not spin.
TEST(EnergyExplosion, EqualSharesOfAChargeHaveTheBooksSpeeds) {
  struct Row {
    double mass, speed;
  };
  for (const Row row :
       {Row{1, 746.904724}, Row{2, 528.141395}, Row{5, 334.025947}, Row{10, 236.192012}}) {
    for (const Particle& p :
         exploded(energy_explosion(5, EnergyShares::equal, row.mass, 4.184e6 / 3))) {
      EXPECT_NEAR(speed(p), row.speed, 6e-7) << row.mass;
      EXPECT_NEAR(p.mass * speed(p) * speed(p) / 2, 278933.333, 6e-4) << row.mass;
    }
  }
}

TEST(EnergyExplosion, NoStoneIsFasterThanTheWholeBudget) {
  constexpr double fastest = 476.0557;  // m/s, one stone of 5 g with everything
  EXPECT_NEAR(speed(exploded(energy_explosion(1, EnergyShares::equal)).front()), fastest, 6e-5);
  for (const EnergyShares shares : all_shares) {
    for (std::uint64_t seed = 0; seed < 99; ++seed) {
      for (const Particle& p : exploded(energy_explosion(3, shares), Precision::float64, seed)) {
        EXPECT_LE(speed(p), fastest + 6e-5);
      }
    }
  }
}

// Drawn one after the other from what is left: the n-th expects 1/3 (2/3)^(n-1) of the budget.
TEST(EnergyExplosion, TheBooksSharesFallByAThird) {
  constexpr std::uint64_t runs = 20'000;
  constexpr std::uint64_t stones = 10;
  solver::Setup setup = plain_setup();
  for (std::uint64_t run = 0; run < runs; ++run) {
    setup.emitters.push_back(energy_explosion(stones, EnergyShares::book));
    setup.emitters.back().stream = run;
  }
  const World world(setup, {solver::widest_isa(), 1, 1});
  std::array<double, stones> mean{};
  double first_square = 0;
  for (const Particle& p : read_particles(world.particles())) {
    const double share = 0.5 * 0.005 * speed(p) * speed(p) / bullet_energy;
    mean[soa::serial_of(p.id)] += share / runs;
    if (soa::serial_of(p.id) == 0) first_square += share * share / runs;
  }
  double wanted = 1 / 3.0;
  double taken = 0;
  for (std::size_t n = 0; n < stones; ++n) {
    EXPECT_NEAR(mean[n], wanted, 5 * 0.2981 / std::sqrt(static_cast<double>(runs))) << n;
    wanted *= 2 / 3.0;
    taken += mean[n];
  }
  // The first ten take 98 %: 1 - (2/3)^10, with a deviation of ((8/15)^10 - (4/9)^10)^(1/2).
  EXPECT_NEAR(taken, 0.98266, 5 * 0.0395 / std::sqrt(static_cast<double>(runs)));
  EXPECT_NEAR(std::sqrt(first_square - mean[0] * mean[0]), 0.298142, 0.005);
}

TEST(EnergyExplosion, TheBooksSharesLeaveNextToNothing) {
  double left = 0;  // on average (2/3)^50 = 1.6e-9 of the budget
  for (std::uint64_t seed = 0; seed < 99; ++seed) {
    const auto particles =
        exploded(energy_explosion(50, EnergyShares::book), Precision::float64, seed);
    left += 1 - static_cast<double>(kinetic_energy(particles)) / bullet_energy;
  }
  EXPECT_LT(left / 99, 1e-6);
}

// A slow light bullet makes a small splash: with the same seed every speed grows as the root of the
// energy.
TEST(EnergyExplosion, SpeedsScaleWithTheRootOfTheEnergy) {
  for (const EnergyShares shares : all_shares) {
    const auto small = exploded(energy_explosion(33, shares, 0.005, bullet_energy / 3));
    const auto large = exploded(energy_explosion(33, shares));
    for (std::size_t i = 0; i < small.size(); ++i) {
      EXPECT_NEAR(speed(large[i]) / speed(small[i]), std::sqrt(3.0), 1e-12);
    }
  }
}

}  // namespace salvo::tests
