/// @file
/// What is skipped of scenes that are partly at rest: Sleeping on and off, in turns of 25 steps.
#include <phistep/phistep.hpp>

#include <phistep/particles.hpp>
#include <phistep/particles/contacts/contact.hpp>
#include <phistep/particles/walls/walls.hpp>

#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <stdexcept>

#include "bullet.hpp"
#include "rows.hpp"

namespace bench {
namespace {
using Eigen::Vector3d;
using phistep::Index;
using Grains = phistep::Particles<double, 3, phistep::Spin>;
constexpr double dt = 2e-3;  // a contact lasts π √(m*/k) ≈ 11 of them
constexpr int chunk = 25;    // steps
const phistep::Hooke law{.stiffness = 1e4, .restitution = 0.3, .friction = 0.5, .rolling_friction = 0.1};

/// Shakes the grains within `reach` of a place; from the grain `orbiting` on they fly about `centre` instead.
struct Stirrer : phistep::ForceTerm {
  Vector3d at, reach;
  double strength;
  Index orbiting = std::numeric_limits<Index>::max();
  Vector3d centre = Vector3d::Zero();
  static constexpr double rate = 1.4;  // of an orbit
  static constexpr bool uses_velocity = false, uses_time = true, acts_on_each = true, computes_active_only = true;
  Stirrer(Vector3d place, Vector3d how_far, double force)
      : at{std::move(place)}, reach{std::move(how_far)}, strength{force} {}

  [[nodiscard]] Vector3d push(double t, const Vector3d& r) const {
    if (((r - at).cwiseAbs().array() > reach.array()).any()) return Vector3d::Zero();
    return {strength * std::sin(7 * t + 3 * r.y()), strength * std::cos(5 * t + 3 * r.x()), 0};
  }
  void add(auto t, const auto& y, auto& out) const {
    const auto one = [&](Index i) {
      if (i < orbiting) out.force.col(i) += push(t, y.r.col(i));
      else out.force.col(i) += rate * rate * (centre - y.r.col(i)) + Vector3d::UnitZ();
    };
    if (const phistep::ActiveSet* active = phistep::active_set(y))
      for (const Index i : active->list()) one(i);
    else
      for (Index i = 0; i < y.r.cols(); ++i) one(i);
  }
};

auto on_floor(double tilt = 0) {
  return phistep::Gravity{Vector3d{std::sin(tilt), 0, -std::cos(tilt)}} + phistep::Contact{law} +
         phistep::Walls{phistep::Materials{law}, phistep::Plane<3>{{0, 0, 0}, {0, 0, 1}}};
}
/// A floor with a gap across it.
auto over_gap(double length, double width) {
  const double half = length / 4 - 1.5;
  const auto slab = [&](double x) { return phistep::SolidBox<3>{{x, width / 2, -1}, {half, width, 1}}; };
  return phistep::Gravity{Vector3d{0, 0, -1}} + phistep::Contact{law} +
         phistep::Walls{phistep::Materials{law}, slab(half), slab(length - half)};
}

/// Unit grains in a loose lattice above a floor, periodic to the sides.
Grains loose(int nx, int ny, int layers) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> shake(-0.04, 0.04);
  Eigen::Matrix3Xd r(3, nx * ny * layers);
  Index n = 0;
  for (int z = 0; z < layers; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x, ++n) {
        r.col(n) << 1.1 * x, 1.1 * y, 0.6 + 1.1 * z;
        for (double& component : r.col(n)) component += shake(random);
      }
  Grains grains{r};
  grains.set_radius(0.5);
  auto box = phistep::Box<double, 3>::periodic({0, 0, 0}, {1.1 * nx, 1.1 * ny, 1});
  box.is_periodic[2] = false;
  grains.set_box(box);
  return grains;
}
/// side² heaps of 25 grains, apart.
Grains heaps(int side) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> shake(-0.012, 0.012);
  Eigen::Matrix3Xd r(3, 25 * side * side);
  Index n = 0;
  for (int h = 0; h < side * side; ++h)
    for (int k = 0; k < 25; ++k, ++n) {
      const Vector3d corner{12.0 * (h % side), 12.0 * (h / side), 0};
      if (k < 16) r.col(n) = corner + Vector3d{1.0 * (k % 4), 1.0 * (k / 4), 0.5};
      else r.col(n) = corner + Vector3d{0.5 + (k - 16) % 3, 0.5 + (k - 16) / 3, 1.25};
      for (double& component : r.col(n)) component += shake(random);
    }
  Grains grains{r};
  grains.set_radius(0.5);
  return grains;
}

/// With four fast grains above the others, each on an orbit of its own about the middle.
void add_fast(Grains& grains, Stirrer& stirrer) {
  const Vector3d low = grains.r.rowwise().minCoeff(), high = grains.r.rowwise().maxCoeff();
  stirrer.orbiting = grains.size();
  stirrer.centre << (low + high).head<2>() / 2, high.z() + 4;
  Grains fast{Eigen::Matrix3Xd(3, 4)};
  for (int k = 0; k < 4; ++k) {
    const double angle = k * std::numbers::pi / 4, size = 12.0 + k;
    fast.r.col(k) = stirrer.centre + Vector3d{0, 0, 2.0 * k};
    fast.v.col(k) = Stirrer::rate * size * Vector3d{std::cos(angle), std::sin(angle), 0};
  }
  // Each at its own height: none meets another.
  fast.set_radius(0.5).set_box(grains.box());
  grains.add(fast);
}

/// One way to run a scene.
template <class Force>
class Runner {
 public:
  Runner(const Grains& start, const Force& force, double speed)
      : grains_{start},
        stepper_{phistep::PhiStepper{grains_, force, phistep::symplectic_euler},
                 phistep::SleepOptions{.speed = speed}} {}
  void steps(int count) {
    for (const int end = n_ + count; n_ < end; ++n_)
      if (const auto report = stepper_.step(grains_, n_ * dt, dt); !report) throw std::runtime_error(report.message());
  }
  [[nodiscard]] double timed_chunk() {
    const Stopwatch watch;
    steps(chunk);
    return watch.seconds();
  }
  [[nodiscard]] const Grains& grains() const { return grains_; }
  [[nodiscard]] double time() const { return n_ * dt; }
  [[nodiscard]] phistep::SleepReport report() const { return stepper_.report(); }

 private:
  Grains grains_;
  phistep::Sleeping<phistep::PhiStepper<Grains, Force, std::remove_const_t<decltype(phistep::symplectic_euler)>>>
      stepper_;
  int n_ = 0;
};
Grains settled(const Grains& start, int steps) {
  Runner run{start, on_floor(), 0};
  run.steps(steps);
  return run.grains();
}

/// Runs a scene with sleeping and without, and says what that cost, what it gained, and by what the heights differ.
/// @param warm   steps before the clock starts
/// @param other  what is compared with `start`, all awake, where that isn't `start` itself
void compare(const char* name, const Grains& start, const auto& force, double speed, int warm, int turns, Table& table,
             const Grains* other = nullptr) {
  Runner awake{other != nullptr ? *other : start, force, 0}, sleeping{start, force, speed};
  awake.steps(warm), sleeping.steps(warm);
  const auto before = sleeping.report();
  const std::string scene = name;
  std::vector<Entrant> entrants{{scene + ", all awake", [&] { return awake.timed_chunk(); }},
                                {scene + ", sleeping", [&] { return sleeping.timed_chunk(); }}};
  take_turns(entrants, turns);
  const auto after = sleeping.report();
  std::vector<double> ratios;
  for (std::size_t k = 0; k < entrants[0].times.size(); ++k)
    ratios.push_back(entrants[1].times[k] / entrants[0].times[k]);
  std::sort(ratios.begin(), ratios.end());
  const double n = static_cast<double>(start.size()), grain_steps = n * chunk * turns;
  const auto height = [](const Grains& g) { return g.r.row(2).mean(); };
  const double off = height(sleeping.grains()) - height(awake.grains());
  const double computed = 1 - static_cast<double>(after.skipped - before.skipped) / grain_steps;
  const double ratio = ratios[ratios.size() / 2];
  std::printf(
      "  %-22s computed %5.1f %%, time %5.1f %% of all awake; fell asleep %lld times, woken %lld; energy removed %.1e; "
      "mean "
      "height off by %.1e\n",
      name, 100 * computed, 100 * ratio, static_cast<long long>(after.fell_asleep - before.fell_asleep),
      static_cast<long long>(after.woken - before.woken), after.energy_removed, off);
  // The budget: none moves faster than `speed` unseen.
  if (other == nullptr && std::abs(off) > speed * sleeping.time())
    throw std::runtime_error(scene + ": asleep, the grains lie elsewhere than awake");
  table.rates("skipping", start.size(), n * chunk, "M grain-steps/s", entrants, {scene + ", all awake"});
  table.add({"skipping", scene + ", time of all awake", start.size(), 1, "ratio of medians in turns", "", ratio});
}

/// Time a step of heaps of which one is stirred, with sleeping and without, ours and Bullet's.
void beside_bullet(const Grains& heaps, const Stirrer& stirrer, double speed, int warm, int turns, Table& table) {
  if (!BulletHeaps::is_here()) {
    std::printf("  Bullet was not found (Debian: libbullet-dev)\n");
    return;
  }
  const auto shake = [stirrer](double t, const Vector3d& r) { return stirrer.push(t, r); };
  BulletHeaps their_awake{heaps.r, false, 25, shake}, theirs{heaps.r, true, 25, shake};
  Runner awake{heaps, on_floor() + stirrer, 0}, sleeping{heaps, on_floor() + stirrer, speed};
  const double height = heaps.r.row(2).mean();
  awake.steps(warm), sleeping.steps(warm), their_awake.steps(warm), theirs.steps(warm);
  const auto timed = [](BulletHeaps& bullet) {
    const Stopwatch watch;
    bullet.steps(chunk);
    return watch.seconds();
  };
  double active = 0;
  std::vector<Entrant> entrants{{"phistep, all awake", [&] { return awake.timed_chunk(); }},
                                {"phistep, sleeping", [&] { return sleeping.timed_chunk(); }},
                                {"Bullet, all awake", [&] { return timed(their_awake); }},
                                {"Bullet, sleeping", [&] {
                                   active += theirs.awake() / turns;
                                   return timed(theirs);
                                 }}};
  take_turns(entrants, turns);
  const auto off = [height](double now) { return now - height; };
  std::printf(
      "  100 heaps, one stirred: mean height changed by %.1e, sleeping %.1e; Bullet %.1e, sleeping %.1e; it has "
      "%.1f %% awake\n",
      off(awake.grains().r.row(2).mean()), off(sleeping.grains().r.row(2).mean()), off(their_awake.mean_height()),
      off(theirs.mean_height()), 100 * active);
  for (const Entrant& one : entrants) {
    const double step = 1e6 * one.median() / chunk;
    const bool is_bullet = one.name[0] == 'B';
    table.add({"skipping", one.name, heaps.size(), 1, "time", "us a step", step});
    table.add(
        {"skipping", one.name, heaps.size(), 1, "time", "us for sqrt(d/g)", step / (is_bullet ? BulletHeaps::dt : dt)});
  }
}
/// A bed and heaps of which a part is stirred, four fast grains above them.
void few_fast(const Grains& bed, const Grains& many, int warm, int turns, Table& table) {
  const double width = bed.box().length().x(), height = bed.r.row(2).maxCoeff();
  for (const int percent : {2, 10, 40}) {
    const std::string name = std::to_string(percent) + " % stirred, 4 fast";
    // The three upper layers of a strip of the bed; and so many of the heaps, row by row.
    const double half = 0.005 * percent * width;
    Stirrer slab{{half, 0, height}, {half, 1e3, 3}, 1};
    Grains some = bed;
    add_fast(some, slab);
    compare(("bed, " + name).c_str(), some, on_floor() + slab, 1e-2, warm, turns, table);
    Stirrer rows{{0, 0, 1}, {percent < 10 ? 18 : 1e3, percent < 20 ? 6 : 1.2 * percent - 6, 3}, 2};
    Grains heaped = many;
    add_fast(heaped, rows);
    compare(("heaps, " + name).c_str(), heaped, on_floor() + rows, 1e-2, warm / 3, 5 * turns, table);
  }
}
}  // namespace

void skipping(const Options& options, Table& table) {
  use_threads(1);
  const bool is_short = options.is_short;
  const int nx = is_short ? 8 : 40, ny = is_short ? 8 : 50, layers = is_short ? 4 : 10;
  const int settles = is_short ? 2000 : 25000, warm = is_short ? 500 : 3000, turns = is_short ? 4 : 40;
  constexpr double slow = 2e-3, stirred_slow = 1e-2;  // as after a fall by 2e-6 and 5e-5 diameters

  const Grains start = loose(nx, ny, layers), bed = settled(start, settles);
  compare("settling", start, on_floor(), slow, 0, turns, table);
  compare("settled", bed, on_floor(), slow, warm, turns, table);

  Grains one{Eigen::Matrix3Xd::Constant(3, 1, 0.55 * nx)};
  one.r(2, 0) = bed.r.row(2).maxCoeff() + 3;
  one.v(2, 0) = -2;
  one.set_radius(0.5).set_box(bed.box());
  Grains hit = bed;
  hit.add(one);
  compare("hit by one", hit, on_floor(), stirred_slow, warm / 3, turns, table);
  const double top = bed.r.row(2).maxCoeff();
  compare("a corner stirred", bed, on_floor() + Stirrer{{3, 3, top}, {4, 4, 4}, 1}, stirred_slow, warm, turns, table);
  compare("creeping, tilted by 5", bed, on_floor(5 * std::numbers::pi / 180), slow, warm, turns, table);
  compare("creeping, tilted by 15", bed, on_floor(15 * std::numbers::pi / 180), slow, warm, turns, table);
  compare("a hopper that runs", bed, over_gap(1.1 * nx, 1.1 * ny), stirred_slow, warm / 3, turns, table);

  const Grains many = settled(heaps(is_short ? 3 : 10), settles);
  const Stirrer stirrer{{1.5, 1.5, 1}, {3, 3, 3}, 2};
  compare("heaps, one stirred", many, on_floor() + stirrer, slow, warm, 10 * turns, table);
  beside_bullet(many, stirrer, slow, warm, 10 * turns, table);
  few_fast(bed, many, warm, turns, table);

  Grains gas = loose(nx, ny, layers);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (double& component : gas.v.reshaped()) component = normal(random);
  compare("a gas", gas, on_floor(), slow, 50, turns, table);

  Grains held = bed;
  std::vector<std::uint8_t> still(static_cast<std::size_t>(held.size()), 1);
  for (std::size_t i = 0; i < still.size(); i += 100) still[i] = 0;
  held.set_still(still);
  held.v.setZero(), held.omega.setZero();
  compare("99 % held", held, on_floor(), 0, 10, turns, table, &bed);
}

}  // namespace bench
