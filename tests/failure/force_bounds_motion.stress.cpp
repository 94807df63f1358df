// Forces of motions that are NaN beyond a bound: a contact's power law, a spring's table. The members are judged as
// force_bounds.hpp says.
#include "failure/force_bounds.hpp"

using namespace force_bounds;

// Counts that may flip with a rounding have some room.
constexpr int members = 1500, known_tolerance = 7;

namespace {

using V1 = Eigen::Matrix<double, 1, 1>;
using Moving = Problem<Motion<V1>, std::function<V1(const V1&)>>;

Moving draw(truth::Random& random) {
  const double k = random.power_of_ten(-2, 3), w = std::sqrt(k);
  Moving p;
  p.scale = 1;
  p.fewest_steps = 40;
  const int kind = random.integer(0, 2);
  if (kind == 0) {
    // r'' = w²(1 − r^1.5): a ball under its weight on a contact that it does not leave. At rest at r = 1.
    const double amplitude = random.uniform(0.02, 0.6);
    p.name = "a ball rests on a contact";
    p.y = {V1{1 + amplitude}, V1{0}};
    p.force = [k](const V1& r) { return V1{k * (1 - std::pow(r[0], 1.5))}; };
    p.t1 = random.uniform(5, 15) / w;
    p.is_inside = [](const Motion<V1>& y, double) { return y.r[0] >= 0; };
  } else if (kind == 1) {
    // r'' = −w² r^1.5: an impact that ends where r = 0. It lasts 2.943275 r_most/v, r_most = (5 v²/(4 w²))^0.4.
    const double v = random.uniform(0.1, 1), most = std::pow(1.25 * v * v / k, 0.4);
    p.name = "an impact, to its end";
    p.scale = most;
    p.y = {V1{0}, V1{v}};
    p.force = [k](const V1& r) { return V1{-k * std::pow(r[0], 1.5)}; };
    p.t1 = random.uniform(0.98, 1) * 2.9432750 * most / v;
    p.is_inside = [](const Motion<V1>& y, double) { return y.r[0] >= 0; };
    p.touches = true;
  } else {
    // The table of a spring ends at the amplitude: the ball starts there at rest and comes back.
    p.name = "a spring's table ends at the amplitude";
    p.y = {V1{1}, V1{0}};
    p.force = [k](const V1& r) { return V1{std::abs(r[0]) <= 1 ? -k * r[0] : not_a_number}; };
    p.t1 = random.uniform(3, 20) / w;
    p.is_inside = [](const Motion<V1>& y, double) { return std::abs(y.r[0]) <= 1; };
    p.exact = std::cos(w * p.t1);
    p.touches = true;
  }
  return p;
}

struct MotionBatteries {
  std::vector<Subject<Moving>> implicit = {
      subject<Moving>("trapezoidal", trapezoidal, 4),
      subject<Moving>("tr_bdf2", tr_bdf2, 4),
      subject<Moving>("backward_euler", backward_euler, 3),
      subject<Moving>("rodas5p", rodas5p),
      subject<Moving>("radau", radau),
  };
  std::vector<Subject<Moving>> explicit_ones = {
      subject<Moving>("velocity_verlet", velocity_verlet, 4),
      subject<Moving>("rkn86", rkn86),
      subject<Moving>("tsit5", tsit5),
  };

  const battery::Tally& with_tolerance() const {
    static const battery::Tally counted = [this] {
      std::vector<Subject<Moving>> all = implicit;
      all.insert(all.end(), explicit_ones.begin(), explicit_ones.end());
      return run<Moving>("force bounds, motion, a tolerance", all, members, 21, false, draw);
    }();
    return counted;
  }
  const battery::Tally& implicit_steps() const {
    static const battery::Tally counted =
        run<Moving>("force bounds, motion, implicit, fixed steps", implicit, members, 22, true, draw);
    return counted;
  }
  const battery::Tally& explicit_steps() const {
    static const battery::Tally counted =
        run<Moving>("force bounds, motion, explicit, fixed steps", explicit_ones, members, 23, true, draw);
    return counted;
  }
};
const MotionBatteries& bounds() {
  static const MotionBatteries all;
  return all;
}

}  // namespace

TEST_CASE("force bounds of motions, a tolerance: no more are wrong than known") {
  battery::at_most(known_tolerance, bounds().with_tolerance());
}
TEST_CASE("force bounds of motions, a tolerance: none is wrong", "[!shouldfail][48]") {
  battery::none(bounds().with_tolerance());
}
TEST_CASE("force bounds of motions, fixed steps: none is wrong") {
  battery::at_most(0, bounds().implicit_steps());
  battery::at_most(0, bounds().explicit_steps());
}
