// A program's own neighbour list, its removal of particles, its arrays that move, its masses, as docs/embedding.md has them.
#include <phistep/phistep.hpp>

#include <cmath>
#include <functional>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace {

using Coordinates = Eigen::Map<Eigen::VectorXd>;
const std::function<Eigen::VectorXd(const Eigen::VectorXd&)> honest = [](const Eigen::VectorXd& r) -> Eigen::VectorXd {
  return -4 * r;
};

}  // namespace

namespace {

using Places = Eigen::Matrix2Xd;

/// Pairs nearer than `cutoff` repel each other. With `skin` > 0 only pairs of a list are looked at, which the force makes anew
/// when some particle has moved by half a skin since.
struct Repulsion {
  static constexpr double cutoff = 1.0;
  double skin = 0;
  std::vector<std::pair<Eigen::Index, Eigen::Index>> list;
  Places listed;
  int lists = 0, calls = 0;

  Places operator()(const Places& r) {
    ++calls;
    if (skin > 0 && (listed.cols() != r.cols() || (r - listed).colwise().norm().maxCoeff() > skin / 2)) search(r);
    Places f = -0.2 * r;
    const auto add = [&](Eigen::Index i, Eigen::Index j) {
      const Eigen::Vector2d d = r.col(i) - r.col(j);
      const double d2 = d.squaredNorm();
      if (d2 >= cutoff * cutoff) return;
      const Eigen::Vector2d push = (1 - d2) * (1 - d2) * d;
      f.col(i) += push, f.col(j) -= push;
    };
    if (skin > 0) {
      for (const auto& [i, j] : list) add(i, j);
    } else {
      for (Eigen::Index i = 0; i < r.cols(); ++i)
        for (Eigen::Index j = i + 1; j < r.cols(); ++j) add(i, j);
    }
    return f;
  }
  void search(const Places& r) {
    ++lists;
    listed = r;
    list.clear();
    for (Eigen::Index i = 0; i < r.cols(); ++i)
      for (Eigen::Index j = i + 1; j < r.cols(); ++j)
        if ((r.col(i) - r.col(j)).squaredNorm() < (cutoff + skin) * (cutoff + skin)) list.emplace_back(i, j);
  }
};
using Cloud = Motion<Places>;
Cloud cloud(Eigen::Index n) {
  Cloud y{Places(2, n), Places(2, n)};
  for (Eigen::Index k = 0; k < n; ++k) {
    const double a = static_cast<double>(k);
    y.r.col(k) << 2 * std::sin(1.7 * a), 2 * std::cos(2.3 * a);
    y.v.col(k) << std::cos(a), std::sin(3 * a);
  }
  return y;
}
bool same(const Cloud& a, const Cloud& b) { return equal_bits(std::tie(a.r, a.v), std::tie(b.r, b.v)); }

}  // namespace

TEST_CASE("a neighbour list of the force's own, made anew by the force at any trial state, is right with Verlet") {
  Cloud a = cloud(30), b = a;
  Repulsion all, listed;
  listed.skin = 0.4;
  PhiStepper one{a, std::ref(all), velocity_verlet}, other{b, std::ref(listed), velocity_verlet};
  int failed_steps = 0;
  for (int n = 0; n < 200; ++n) {
    // A step that fails on the way has the force make a list far away.
    if (n % 50 == 25) failed_steps += other.step(b, 0, 1e200) ? 0 : 1;
    REQUIRE((one.step(a, 0.05 * n, 0.05) && other.step(b, 0.05 * n, 0.05)));
    CHECK(same(a, b));
  }
  CHECK(failed_steps == 4);
  CHECK((10 < listed.lists && listed.lists < listed.calls / 2));
}

TEST_CASE("particles may be removed and added between steps: the next step is a new stepper's") {
  Cloud a = cloud(8);
  PhiStepper stepper{a, Repulsion{}, velocity_verlet, mass(2.0)};
  for (const Eigen::Index n : {8, 5, 5, 9, 1}) {
    const Cloud whole = cloud(9);
    a.r = whole.r.leftCols(n), a.v = whole.v.leftCols(n);
    Cloud b = a;
    PhiStepper fresh{b, Repulsion{}, velocity_verlet, mass(2.0)};
    REQUIRE((stepper.step(a, 0, 0.1) && fresh.step(b, 0, 0.1)));
    CHECK(same(a, b));
  }
  // The same number, other particles: an edit like any other.
  a.r = cloud(9).r.rightCols(1);
  Cloud b = a;
  PhiStepper fresh{b, Repulsion{}, velocity_verlet, mass(2.0)};
  REQUIRE((stepper.step(a, 0, 0.1) && fresh.step(b, 0, 0.1)));
  CHECK(same(a, b));
}

TEST_CASE("an observer may remove particles: the steps of a loop by hand that does") {
  const auto leave = [](Cloud& y, Eigen::Index n) {
    const Cloud all = y;
    y.r = all.r.leftCols(n), y.v = all.v.leftCols(n);
  };
  Cloud a = cloud(8), b = a, c = a;
  PhiStepper by_hand{a, Repulsion{}, velocity_verlet}, observed{b, Repulsion{}, velocity_verlet};
  for (int n = 0; n < 10; ++n) {
    REQUIRE(by_hand.step(a, 0.1 * n, 0.1));
    if (n == 4) leave(a, 5);
  }
  int step = -1;  // the start is shown too
  REQUIRE(integrate(observed, b, {0, 1}, fixed(0.1), [&](double, Cloud& y) {
    if (++step == 5) leave(y, 5);
  }));
  CHECK(same(a, b));
  // Under a tolerance the controller's past has another size, too.
  PhiStepper controlled{c, Repulsion{}, velocity_verlet};
  int steps = 0;
  REQUIRE(integrate(controlled, c, {0, 2}, tolerance{.rtol = 1e-4, .atol = 1e-6}, [&](double, Cloud& y) {
    if (++steps == 5) leave(y, 3);
    if (steps == 9) y = cloud(20);
  }));
  CHECK((c.r.cols() == 20 && c.r.allFinite()));
}

TEST_CASE("a Map is placed anew over arrays that have moved or shrunk") {
  std::vector<double> x{1, 2, 3, 4}, v{0, 0, 1, 1};
  const auto size = [&] { return static_cast<Eigen::Index>(x.size()); };
  Motion<Coordinates> state{Coordinates{x.data(), size()}, Coordinates{v.data(), size()}};
  PhiStepper stepper{state, honest, velocity_verlet};
  REQUIRE(stepper.step(state, 0, 0.1));
  x.erase(x.begin() + 1), v.erase(v.begin() + 1);
  x.shrink_to_fit(), v.shrink_to_fit();
  std::construct_at(&state.r, x.data(), size()), std::construct_at(&state.v, v.data(), size());
  Motion<Eigen::VectorXd> owned{state.r, state.v};
  PhiStepper fresh{owned, honest, velocity_verlet};
  REQUIRE((stepper.step(state, 0.1, 0.1) && fresh.step(owned, 0.1, 0.1)));
  CHECK(state.r == owned.r);
  CHECK(state.v == owned.v);
}

TEST_CASE(
    "masses are copied: one a particle that no longer fits throws, and the state stays; others ask for a new stepper") {
  Cloud y = cloud(4);
  Eigen::VectorXd m = Eigen::VectorXd::LinSpaced(4, 1, 4);
  PhiStepper stepper{y, Repulsion{}, velocity_verlet, mass(m)};
  Cloud z = y;
  PhiStepper before{z, Repulsion{}, velocity_verlet, mass(m)};
  m *= 2;  // … of the program's own array
  REQUIRE((stepper.step(y, 0, 0.1) && before.step(z, 0, 0.1)));
  CHECK(same(y, z));
  const Cloud shorter{y.r.leftCols(3), y.v.leftCols(3)};
  y = shorter;
  CHECK_THROWS_AS(stepper.step(y, 0.1, 0.1), std::invalid_argument);
  CHECK(same(y, shorter));
  // A stepper is assigned a new one, in place.
  stepper = PhiStepper{y, Repulsion{}, velocity_verlet, mass(Eigen::VectorXd(m.head(3)))};
  CHECK(stepper.step(y, 0.1, 0.1));
}
