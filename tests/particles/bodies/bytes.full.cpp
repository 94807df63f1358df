// What an atom and a grain take of the heap, all of it: state, stepper, force, lists. (Blocks as malloc hands them out.)
#include <phistep/particles.hpp>
#include <phistep/phistep.hpp>

#include <cmath>
#include <functional>

#include "support/catch.hpp"
#include "support/sanitizers.hpp"

#if defined(__GLIBC__)
#include <malloc.h>
#endif

using namespace phistep;

namespace {

#if defined(__GLIBC__) && __GLIBC_PREREQ(2, 33) && !defined(__SANITIZE_ADDRESS__)
constexpr bool heap_is_known = true;
double heap() {
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
}
#else
constexpr bool heap_is_known = false;
double heap() { return 0; }
#endif

/// Points of a cubic lattice, each moved by up to `by` along each axis.
Eigen::Matrix3Xd lattice(int side, double spacing, double by) {
  Eigen::Matrix3Xd r(3, side * side * side);
  for (Eigen::Index i = 0; i < r.cols(); ++i) {
    const double k = static_cast<double>(i);
    r.col(i) = spacing * Eigen::Vector3d(static_cast<double>(i % side), static_cast<double>(i / side % side),
                                         static_cast<double>(i / side / side));
    r.col(i) += by * Eigen::Vector3d(std::sin(12.9 * k), std::sin(78.2 * k), std::sin(37.7 * k));
  }
  return r;
}
struct Bytes {
  double least, most;
};
void check_bytes(double before, Eigen::Index n, const Bytes& expected) {
  const double each = (heap() - before) / static_cast<double>(n);
  CAPTURE(each);
  if (!heap_is_known) return;
  CHECK(each >= expected.least);
  CHECK(each <= expected.most);
}

}  // namespace

TEST_CASE("a grain takes 750 bytes at three contacts, 950 with springs of rolling, after the second search, too") {
  for (const bool rolls : {false, true}) {
    CAPTURE(rolls);
    const double before = heap();
    using Grains = Particles<double, 3, Spin>;
    constexpr int side = 30;
    Grains y{lattice(side, 0.98, 0.001)};
    y.set_radius(Eigen::VectorXd::Constant(y.size(), 0.5));
    Contact contact{Hooke{.stiffness = 1e4, .friction = 0.5, .rolling_friction = rolls ? 0.1 : 0.0}};
    PhiStepper stepper{y, std::ref(contact), symplectic_euler};
    for (int step = 0; step < 3; ++step) REQUIRE(stepper.step(y, 0.0, 1e-4));
    CHECK(contact.statistics().rebuilds == 1);
    CHECK(static_cast<double>(contact.statistics().touching) > 2.8 * static_cast<double>(y.size()));
    const Bytes expected = rolls ? Bytes{850, 950} : Bytes{680, 750};
    check_bytes(before, y.size(), expected);

    y.r.row(0).array() += 1;  // beyond half the skin, all together: the same contacts
    for (int step = 0; step < 3; ++step) REQUIRE(stepper.step(y, 0.0, 1e-4));
    CHECK(contact.statistics().rebuilds == 2);
    check_bytes(before, y.size(), expected);
  }
}

TEST_CASE("an atom of a melt takes 560 bytes where its box has 20 of them along an axis") {
  const double before = heap();
  constexpr int side = 20;
  const double spacing = std::cbrt(1 / 0.8442);
  Particles<double, 3> y{lattice(side, spacing, 0.02)};
  y.set_box(Box<double, 3>::periodic(Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(side * spacing)));
  Pairs pairs{LennardJones{}, 2.5, {.skin = 0.4}};
  PhiStepper stepper{y, std::ref(pairs), velocity_verlet};
  for (int step = 0; step < 3; ++step) REQUIRE(stepper.step(y, 0.0, 1e-3));
  check_bytes(before, y.size(), {480, 560});
}
