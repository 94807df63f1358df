// A floor or a wall put together from several flush boxes is one box: a ball that bounces on a seam, slides over it or rolls
// over it does what it does on one.
#include <phistep/particles.hpp>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "accuracy/contact_chance.hpp"
#include "support/battery.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace contact_scenes;

#if PHISTEP_STRESS
constexpr int members = 300;
#elif PHISTEP_FULL
constexpr int members = 60;
#endif

namespace {

using Vec = Eigen::Vector3d;
using Grains = Particles<double, 3, Spin>;

/// A floor of boxes, cut along up to three seams across x and up to one across y, turned in space.
struct Floor {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  // columns: along, across, up
  Vec origin = Vec::Zero();                            // on a seam, or on the crossing of two
  std::vector<Wall<3>> pieces, whole;

  [[nodiscard]] Vec at(double x, double y, double z) const { return origin + axes * Vec(x, y, z); }
};
/// @param seams  at these x, and at y = 0 if `crossed`
Floor make_floor(Chance& chance, std::vector<double> seams, bool crossed, bool turned, double half_length) {
  Floor floor;
  if (turned) {
    const Vec a = chance.direction(), b = chance.direction();
    floor.axes.col(0) = a, floor.axes.col(2) = a.cross(b).normalized(), floor.axes.col(1) = floor.axes.col(2).cross(a);
    floor.origin = 0.1 * chance.vector();
  }
  const double thickness = chance.between(0.05, 0.2);
  const auto box = [&](double x0, double x1, double y0, double y1) -> Wall<3> {
    return SolidBox<3>{.center = floor.at((x0 + x1) / 2, (y0 + y1) / 2, -thickness),
                       .half = {(x1 - x0) / 2, (y1 - y0) / 2, thickness},
                       .axes = floor.axes};
  };
  seams.insert(seams.begin(), -half_length), seams.push_back(half_length);
  for (std::size_t k = 0; k + 1 < seams.size(); ++k) {
    if (crossed) {
      floor.pieces.push_back(box(seams[k], seams[k + 1], -1, 0));
      floor.pieces.push_back(box(seams[k], seams[k + 1], 0, 1));
    } else {
      floor.pieces.push_back(box(seams[k], seams[k + 1], -1, 1));
    }
  }
  floor.whole = {box(-half_length, half_length, -1, 1)};
  return floor;
}

struct Run {
  Vec r = Vec::Zero(), v = Vec::Zero(), omega = Vec::Zero();  // in the floor's axes
  bool finished = false;
};
template <class Law>
Run run(const Law& law, const Floor& floor, const std::vector<Wall<3>>& walls, const Grains& start, double g, double t1,
        double dt) {
  Grains y = start;
  PhiStepper stepper{y, Gravity{Vec(-g * floor.axes.col(2))} + Walls{law, walls}, symplectic_euler};
  Run out;
  out.finished = static_cast<bool>(integrate(stepper, y, {0.0, t1}, fixed(dt)));
  out.r = floor.axes.transpose() * (y.r.col(0) - floor.origin), out.v = floor.axes.transpose() * y.v.col(0);
  out.omega = floor.axes.transpose() * y.omega.col(0);
  return out;
}
Grains ball(const Floor& floor, Vec r, Vec v, double m, double R) {
  Grains y{floor.at(r[0], r[1], r[2]), Vec(floor.axes * v)};
  y.set_mass(m).set_radius(R);
  return y;
}

struct Tallies {
  battery::Tally bounce{.name = "bounces on seams"}, slide{.name = "slides over seams"},
      roll{.name = "rolls over seams"}, clear{.name = "floors without seams"};
};

template <class Law>
void bounce(Tallies& tallies, Chance& chance, Law law, double impact_of_unit, const std::string& name) {
  // The impact is at one speed and one mass; its duration is of Hooke, or of Hertz at 1 m/s, for `impact_of_unit`.
  const double m = 0.01, R = 0.01, e = chance.between(0.3, 1);
  law.restitution = e;
  const int seams = 1 + chance.one_of(3);
  std::vector<double> at{0.0};
  const bool near = chance.one_of(4) > 0;
  const double depth = 1.0 * impact_of_unit / M_PI;  // of the overlap, about
  const double reach = std::sqrt(2 * R * depth);     // so far from the seam the neighbour is touched
  for (int k = 1; k < seams; ++k) at.push_back(at.back() + chance.between(0.05, 0.3) * (near ? reach : 1));
  if (at.size() > 1 && near) at = {0.0, 3 * R};
  const bool turned = chance.yes(), crossed = chance.yes();
  const Floor floor = make_floor(chance, at, crossed, turned, 2);
  const double away = near ? chance.between(-0.7, 0.7) * reach : -chance.between(1.2, 3) * R;
  const double aside = near ? chance.between(-0.7, 0.7) * reach : -chance.between(1.2, 3) * R;
  const Grains y = ball(floor, {away, aside, R + 1e-5}, {0, 0, -1}, m, R);
  const double dt = impact_of_unit / 400, t1 = 6 * impact_of_unit;
  const Run b = run(law, floor, floor.pieces, y, 0, t1, dt);
  const bool right = b.finished && std::abs(b.v[2] - e) < 0.01 && std::hypot(b.v[0], b.v[1]) < 0.01;
  (near ? tallies.bounce : tallies.clear)
      .count(right, text(name, " on ", floor.pieces.size(), " boxes: e = ", e, " came out as ", b.v[2], ", aside ",
                         std::hypot(b.v[0], b.v[1])));
}
void slide(Tallies& tallies, Chance& chance, const std::string& name) {
  const double m = 0.01, R = 0.01, g = 9.81, k = chance.ratio(3e3, 1e5);
  const double v0 = chance.ratio(0.01, 1), e = chance.between(0.2, 1);
  std::vector<double> at;
  for (int n = 1 + chance.one_of(4); n > 0; --n)
    at.push_back((at.empty() ? 0.02 : at.back()) + chance.between(0.02, 0.05));
  const Floor floor = make_floor(chance, at, false, chance.yes(), 1);
  const double x0 = 0, t1 = (at.back() + 0.03) / v0;
  const Grains y = ball(floor, {x0, 0.3, R - m * g / k}, {v0, 0, 0}, m, R);
  const auto over = [&](battery::Tally& tally, const std::vector<Wall<3>>& walls) {  // nothing slows it down
    const Run b = run(Hooke{.stiffness = k, .restitution = e}, floor, walls, y, g, t1, M_PI * std::sqrt(m / k) / 40);
    const bool right = b.finished && std::abs(b.v[0] - v0) < 1e-3 * v0 && std::abs(b.v[2]) < 1e-3 * v0;
    tally.count(right, text(name, " over ", at.size(), " seams: ", v0, " m/s became ", b.v[0], ", upwards ", b.v[2]));
  };
  over(tallies.clear, floor.whole), over(tallies.slide, floor.pieces);
}
void roll(Tallies& tallies, Chance& chance, const std::string& name) {
  const double m = 0.01, R = 0.01, g = 9.81, k = chance.ratio(3e3, 1e5);
  const double v0 = chance.ratio(0.01, 1), e = chance.between(0.2, 0.9);
  std::vector<double> at;
  for (int n = 1 + chance.one_of(3); n > 0; --n)
    at.push_back((at.empty() ? 0.01 : at.back()) + chance.between(0.02, 0.04));
  const Floor floor = make_floor(chance, at, false, chance.yes(), 1);
  Grains y = ball(floor, {0, 0.3, R - m * g / k}, {v0, 0, 0}, m, R);
  y.omega.col(0) = floor.axes * Vec(0, v0 / (R - m * g / k), 0);  // rolls without slipping
  const auto over = [&](battery::Tally& tally, const std::vector<Wall<3>>& walls) {
    const Run b = run(Hooke{.stiffness = k, .restitution = e, .friction = 0.5}, floor, walls, y, g,
                      (at.back() + 0.02) / v0, M_PI * std::sqrt(m / k) / 40);
    const bool right =
        b.finished && std::abs(b.v[0] - v0) < 2e-3 * v0 && std::abs((R - m * g / k) * b.omega[1] - v0) < 2e-3 * v0;
    tally.count(right,
                text(name, " over ", at.size(), " seams: ", v0, " m/s became ", b.v[0], ", R omega ", R * b.omega[1]));
  };
  over(tallies.clear, floor.whole), over(tallies.roll, floor.pieces);
}

const Tallies& seams() {
  static const Tallies counted = [] {
    Tallies tallies;
    Chance chance{4};
    for (int n = 0; n < members; ++n) {
      if (n % 2 == 0) {
        const double k = chance.ratio(1e4, 1e6);
        bounce(tallies, chance, Hooke{.stiffness = k}, M_PI * std::sqrt(0.01 / k), text(n, " Hooke"));
      } else {
        Hertz law{.modulus = chance.ratio(1e7, 1e9)};
        const double impact = Hertz::impact(law.numbers(), 0.01, 0.01, 1);
        bounce(tallies, chance, law, impact, text(n, " Hertz"));
      }
      if (n % 2 == 0) slide(tallies, chance, text(n));
      if (n % 2 == 1) roll(tallies, chance, text(n));
    }
    return tallies;
  }();
  return counted;
}

}  // namespace

TEST_CASE("floors without seams keep restitution and speed") { battery::none(seams().clear); }
TEST_CASE("bounces on seams are those on one box") { battery::none(seams().bounce); }
TEST_CASE("slides over seams keep their speed") { battery::none(seams().slide); }
TEST_CASE("rolls over seams keep their speed") { battery::none(seams().roll); }
