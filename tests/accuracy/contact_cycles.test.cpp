// A body is led round a closed path on a floor or on another body: what friction and rolling resistance do to it over the
// whole path must not be a gain of energy. The body's motion is prescribed: before each step its place and its velocity are
// written, after it the change of its velocity tells the force. What the normal spring does cancels, and is taken out.
//
// With Hertz the tangential stiffness k grows with the overlap: sheared by s at little pressure and sheared back at much, a spring
// that kept its length would give back ½ Δk s² more than it took.
#include <phistep/particles.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>
#include <vector>

#include "accuracy/contact_chance.hpp"
#include "support/battery.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace contact_scenes;

#if PHISTEP_STRESS
constexpr int members = 400;
#elif PHISTEP_FULL
constexpr int members = 60;
#endif

namespace {

using Grains = Particles<double, 3, Spin>;
using Vec = Eigen::Vector3d;
constexpr double R = 0.01;
constexpr int steps = 1000;  // of each leg

/// A corner of the path.
struct Corner {
  Vec shift;     // of the center, from where the bodies just touch: −z is the overlap [length]
  Vec turn;      // angles about the axes
  double speed;  // of the leg that ends here; 1: `steps` steps
};
using Path = std::vector<Corner>;

struct Balance {
  double gain = 0;    // what the tangential and the rolling forces gave over the whole path [energy]
  double passed = 0;  // sum of the amounts that went either way
  // potential_energy of the tangential and rolling springs and the work that they gave, added up: by how much this sum
  // rose over its least value before, and fell below its largest.
  double rise = 0, fall = 0;
  double normal = 0;  // largest error of the normal force, relative to the largest force
  bool finished = true;
};

template <class Law>
double normal_force(const Law& law, double overlap, double radius) {
  if constexpr (std::is_same_v<Law, Hertz>) return 4. / 3 * law.modulus * std::sqrt(radius * overlap) * overlap;
  else return law.stiffness * overlap;
}

/// What the normal spring holds.
template <class Law>
double normal_energy(const Law&, double overlap, double force) {
  return (std::is_same_v<Law, Hertz> ? 0.4 : 0.5) * force * overlap;
}

/// @param damped  the law has dashpots
/// @param other  a still body lies below in place of a floor
template <class Law>
Balance lead(const Law& law, const Path& path, bool other, bool damped, double dt) {
  Balance balance;
  Eigen::Matrix3Xd r(3, other ? 2 : 1);
  const double reach = other ? 2 * R : R;  // of the center from the origin, where the bodies just touch
  const Index i = r.cols() - 1;
  const Vec home{0, 0, reach};
  r.setZero();
  r.col(i) = home + path.front().shift;
  Grains y{r};
  y.set_mass(1).set_radius(R);
  if (other) y.set_still({1, 0});
  const auto go = [&](auto force) {
    PhiStepper stepper{y, force, symplectic_euler};
    const double inertia = y.body().inertia(i);
    Vec place = home + path.front().shift, angle = path.front().turn, force_before = Vec::Zero(),
        torque_before = Vec::Zero();
    double t = 0, largest = 0, given = 0, least = 0, most = 0;
    for (std::size_t c = 1; c < path.size(); ++c) {
      const int n = std::max(1, static_cast<int>(steps / path[c].speed));
      const Vec from = home + path[c - 1].shift, to = home + path[c].shift;
      const Vec way = (to - from) / n, turn = (path[c].turn - path[c - 1].turn) / n;
      for (int k = 1; k <= n; ++k, t += dt) {
        const Vec now = from + k * way;
        y.r.col(i) = now, y.v.col(i) = way / dt, y.omega.col(i) = turn / dt;
        if (!stepper.step(y, t, dt)) {
          balance.finished = false;
          return;
        }
        const Vec all = (y.v.col(i) - way / dt) / dt, torque = inertia * (y.omega.col(i) - turn / dt) / dt;
        const Vec n_out = other ? Vec(now.normalized()) : Vec(0, 0, 1);
        const double distance = other ? now.norm() : now[2], overlap = std::max(0.0, reach - distance);
        const double normal = normal_force(law, overlap, other ? R / 2 : R);
        const Vec rest = all - normal * n_out;
        largest = std::max(largest, all.norm());
        if (!damped) balance.normal = std::max(balance.normal, std::abs(rest.dot(n_out)));
        const double work = 0.5 * (rest + force_before).dot(now - place) +
                            0.5 * (torque + torque_before).dot(k * turn + path[c - 1].turn - angle);
        balance.gain += work, balance.passed += std::abs(work);
        given += work;
        Grains asked = y;
        asked.r.col(i) = now, asked.v.col(i) = damped ? Vec(way / dt) : Vec::Zero().eval(), asked.omega.setZero();
        const double held = potential_energy(stepper, asked, t + dt) - normal_energy(law, overlap, normal);
        balance.rise = std::max(balance.rise, held + given - least);
        balance.fall = std::max(balance.fall, most - held - given);
        least = std::min(least, held + given), most = std::max(most, held + given);
        place = now, angle = path[c - 1].turn + k * turn, force_before = rest, torque_before = torque;
      }
    }
    if (largest > 0) balance.normal /= largest;
  };
  if (other) go(Contact{law});
  else go(Walls{law, Plane<3>{{0, 0, 0}, {0, 0, 1}}});
  return balance;
}

/// Press, shear or roll, press more, and back the same way.
Path press_and_back(Chance& chance, bool rolls) {
  const double little = R * chance.ratio(1e-4, 1e-3), much = little * chance.between(1.5, 4);
  const double s = R * chance.ratio(1e-4, 1e-3), way = chance.between(0, 2 * M_PI);
  const Vec up{0, 0, 0.1 * little}, slip{s * std::cos(way), s * std::sin(way), 0};
  Vec turn = Vec::Zero();
  if (rolls) turn[1] = chance.between(-1, 1) * s / R, turn[0] = chance.between(-1, 1) * s / R;
  const Vec low{0, 0, -little}, lower{0, 0, -much}, none = Vec::Zero();
  return {{up, none, 1},           {low, none, 1},   {low + slip, turn, 1},
          {lower + slip, turn, 1}, {lower, none, 1}, {up, none, 1}};
}
/// From corner to corner, anywhere within the contact.
Path anywhere(Chance& chance, bool rolls, bool unlike_speeds) {
  const double deep = R * chance.ratio(1e-4, 1e-3), s = R * chance.ratio(1e-4, 1e-3);
  const auto speed = [&] { return unlike_speeds ? chance.ratio(0.2, 20) : 1.0; };
  const Vec up{0, 0, 0.1 * deep}, none = Vec::Zero();
  Path path{{up, none, 1}, {{0, 0, -deep}, none, 1}};
  for (int n = 2 + chance.one_of(4); n > 0; --n) {
    const double x = chance.between(-s, s), y = chance.between(-s, s), z = -deep * chance.between(0.2, 2);
    const double a = chance.between(-1, 1) * s / R, b = chance.between(-1, 1) * s / R;
    path.push_back({{x, y, z}, rolls ? Vec(a, b, 0) : none, speed()});
  }
  path.push_back({{0, 0, -deep}, none, speed()});
  path.push_back({up, none, 1});
  return path;
}

Hooke linear(Chance& chance) {
  Hooke law{.stiffness = chance.ratio(1e3, 1e7), .friction = chance.yes() ? 1e9 : chance.ratio(0.1, 1)};
  law.tangential_stiffness = chance.between(0.2, 1);
  return law;
}
GranHooke gran(Chance& chance) {
  const double k = chance.ratio(1e3, 1e7), across = k * chance.between(0.2, 1);
  return {.stiffness = k,
          .tangential_stiffness = across,
          .damping = 0,
          .tangential_damping = 0,
          .friction = chance.yes() ? 1e9 : chance.ratio(0.1, 1)};
}
Hertz elastic(Chance& chance) {
  const double poisson = chance.between(0, 0.45);
  Hertz law = Hertz::elastic(chance.ratio(1e6, 1e11), poisson);
  law.friction = chance.yes() ? 1e9 : chance.ratio(0.1, 1);
  return law;
}

constexpr double allowed = 2e-3;  // of the energy that passed: the work is summed over `steps` steps a leg

/// No energy may be gained; linear springs that don't slide lose none.
template <class Law>
void judge(battery::Tally& tally, battery::Tally& held, const Law& law, const Path& path, bool other,
           const std::string& name) {
  const Balance b = lead(law, path, other, false, 1e-3);
  const bool sticks = law.friction > 1e8, right = b.finished && b.passed > 0 && b.normal < 1e-6;
  const bool closes = std::is_same_v<Law, Hertz> || !sticks || b.gain >= -allowed * b.passed;
  tally.count(right && b.gain <= allowed * b.passed && closes,
              text(name, ": gain ", b.gain, " of ", b.passed, " J that passed"));
  const bool keeps = std::is_same_v<Law, Hertz> || !sticks || b.fall <= allowed * b.passed;
  held.count(right && b.rise <= allowed * b.passed && keeps,
             text(name, ": energy and work, together, rose by ", b.rise, ", fell by ", b.fall, " of ", b.passed, " J"));
}

struct Tallies {
  battery::Tally gain, held;  // of the work round a path, and of potential_energy on the way
};

const Tallies& linear_springs() {
  static const Tallies counted = [] {
    Tallies tallies{{.name = "closed paths, linear springs"}, {.name = "energy of linear springs on the way"}};
    Chance chance{1};
    for (int n = 0; n < members; ++n) {
      const bool other = n % 2 == 1, rolls = n % 3 == 2;
      const Path path = n % 4 < 2 ? press_and_back(chance, rolls) : anywhere(chance, rolls, true);
      Hooke law = linear(chance);
      if (rolls) law.rolling_friction = chance.ratio(0.1, 1), law.friction = 0.5;
      if (n % 5 == 4) judge(tallies.gain, tallies.held, gran(chance), path, other, text(n, " GranHooke"));
      else judge(tallies.gain, tallies.held, law, path, other, text(n, " Hooke"));
    }
    return tallies;
  }();
  return counted;
}
const Tallies& growing_stiffness() {
  static const Tallies counted = [] {
    Tallies tallies{{.name = "closed paths, stiffness that grows with the overlap"},
                    {.name = "energy of springs that stiffen, on the way"}};
    Chance chance{2};
    for (int n = 0; n < members; ++n) {
      const bool other = n % 2 == 1;
      const Path path = n % 4 < 2 ? press_and_back(chance, false) : anywhere(chance, false, true);
      judge(tallies.gain, tallies.held, elastic(chance), path, other, text(n, other ? " between two" : " on a floor"));
    }
    return tallies;
  }();
  return counted;
}
const Tallies& dashpots() {
  static const Tallies counted = [] {
    Tallies tallies{{.name = "closed paths, sliding against spring and dashpot"},
                    {.name = "energy of springs beside dashpots, on the way"}};
    Chance chance{3};
    for (int n = 0; n < members; ++n) {
      Hooke law = linear(chance);
      law.restitution = chance.between(0.1, 0.9), law.friction = chance.ratio(0.05, 1);
      const Path path = anywhere(chance, false, true);
      const Balance b = lead(law, path, n % 2 == 1, true, chance.ratio(1e-6, 1e-3));
      const std::string name = text(n, " Hooke, e = ", law.restitution);
      tallies.gain.count(b.finished && b.passed > 0 && b.gain <= 5 * allowed * b.passed,
                         text(name, ": gain ", b.gain, " of ", b.passed, " J that passed"));
      tallies.held.count(b.finished && b.rise <= 10 * allowed * b.passed,
                         text(name, ": energy and work, together, rose by ", b.rise, " of ", b.passed, " J"));
    }
    return tallies;
  }();
  return counted;
}

}  // namespace

TEST_CASE("closed paths on linear springs gain no energy") { battery::none(linear_springs().gain); }
TEST_CASE("the energy of linear springs is what was put in") { battery::none(linear_springs().held); }
TEST_CASE("closed paths on stiffening springs gain no energy") { battery::none(growing_stiffness().gain); }
TEST_CASE("the energy of stiffening springs is at most what was put in") { battery::none(growing_stiffness().held); }
TEST_CASE("closed paths on springs with dashpots gain no energy") { battery::none(dashpots().gain); }
TEST_CASE("the energy of springs beside dashpots is at most what was put in") { battery::none(dashpots().held); }
