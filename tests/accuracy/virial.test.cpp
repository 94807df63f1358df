// pressure() of particles in a periodic box is (2 E_kin − λ dU/dλ)/(3 V), U being the potential energy with all places and
// the box λ times as large. The derivative is taken by differences of potential_energy.
#include <phistep/particles.hpp>

#include <cmath>
#include <string>
#include <vector>

#include "accuracy/contact_chance.hpp"
#include "support/battery.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace contact_scenes;

#if PHISTEP_STRESS
constexpr int members = 400;
#elif PHISTEP_FULL
constexpr int members = 40;
#endif

namespace {

using Vec = Eigen::Vector3d;
using Balls = Particles<double, 3>;

/// A jittered lattice of n × n × n in a periodic box.
struct Sample {
  Balls y;
  double apart;  // between neighbours of the lattice
  int n;
};
Sample sample(Chance& chance) {
  const int n = 3 + chance.one_of(2);
  const double apart = chance.ratio(1e-3, 10);
  Eigen::Matrix3Xd r(3, n * n * n), v(3, n * n * n);
  Eigen::VectorXd m(n * n * n);
  const double fast = chance.yes() ? chance.ratio(1e-3, 1) * apart : 0;
  for (int i = 0; i < r.cols(); ++i) {
    r.col(i) = apart * (Vec(i % n, i / n % n, i / n / n) + 0.08 * chance.vector());
    v.col(i) = fast * chance.vector();
    m[i] = chance.between(1, 3);
  }
  Sample s{Balls{r, v}, apart, n};
  s.y.set_mass(m).set_box(Box<double, 3>::periodic(Vec::Zero(), Vec::Constant(n * apart)));
  return s;
}

void compare(battery::Tally& tally, auto force, const Sample& s, const std::string& name) {
  const double length = s.n * s.apart, volume = length * length * length;
  const auto energy = [&](double lambda) {
    Balls y = s.y;
    y.r *= lambda;
    y.set_box(Box<double, 3>::periodic(Vec::Zero(), Vec::Constant(lambda * length)));
    PhiStepper stepper{y, force, velocity_verlet};
    return potential_energy(stepper, y);
  };
  const auto slope = [&](double h) { return (energy(1 + h) - energy(1 - h)) / (2 * h); };
  const double h = 1e-4, derivative = (4 * slope(h / 2) - slope(h)) / 3;
  double twice_kinetic = 0;
  for (Index i = 0; i < s.y.size(); ++i) twice_kinetic += s.y.mass()[i] * s.y.v.col(i).squaredNorm();
  const double right = (twice_kinetic - derivative) / (3 * volume);
  Balls y = s.y;
  PhiStepper stepper{y, force, velocity_verlet};
  const double p = pressure(stepper, y), unit = (twice_kinetic + std::abs(derivative)) / (3 * volume);
  tally.count(unit > 0 && std::abs(p - right) <= 1e-3 * unit, text(name, ": ", p, " for ", right));
}

struct Tallies {
  battery::Tally pairs{.name = "pressure of pair forces"}, springs{.name = "pressure with springs"},
      contacts{.name = "pressure with contacts"};
};
const Tallies& all() {
  static const Tallies counted = [] {
    Tallies tallies;
    Chance chance{9};
    for (int n = 0; n < members; ++n) {
      Sample s = sample(chance);
      const double k = chance.ratio(0.1, 100);
      const Pairs soft{SoftSphere{.height = chance.ratio(0.1, 10) * s.apart * s.apart, .diameter = 1.4 * s.apart},
                       1.4 * s.apart};
      compare(tallies.pairs, soft, s, text(n, " soft spheres"));
      std::vector<Spring> bonds;  // between neighbours within the box, as springs don't see its images
      for (int i = 0; i < s.y.size(); ++i)
        if (i % s.n + 1 < s.n) bonds.push_back({i, i + 1, k, chance.between(0.8, 1.2) * s.apart});
      const auto springs = spring_network<3>(bonds);
      if (n % 2 == 0) compare(tallies.springs, springs, s, text(n, " springs"));
      else compare(tallies.springs, springs + soft, s, text(n, " springs and soft spheres"));
      s.y.set_radius(0.5 * s.apart * chance.between(1, 1.1));
      if (n % 2 == 0) compare(tallies.contacts, Contact{Hooke{.stiffness = k}}, s, text(n, " Hooke"));
      else compare(tallies.contacts, Contact{Hertz{.modulus = k / s.apart}}, s, text(n, " Hertz"));
    }
    return tallies;
  }();
  return counted;
}

}  // namespace

TEST_CASE("the pressure of pair forces is that of their energy") { battery::none(all().pairs); }
TEST_CASE("the pressure with springs is that of their energy") { battery::none(all().springs); }
TEST_CASE("the pressure with contacts is that of their energy") { battery::none(all().contacts); }
