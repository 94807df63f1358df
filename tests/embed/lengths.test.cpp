// Arrays in place whose lengths change: by the routine, which is refused, and between steps.
#include <phistep/in_place.hpp>

#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace {

struct Bead {
  double x[3], v[3], f[3];
};
std::vector<Bead> ten() {
  std::vector<Bead> beads(10);
  for (std::size_t i = 0; i < beads.size(); ++i) beads[i].x[0] = 0.1 * static_cast<double>(i);
  return beads;
}
void pull(std::vector<Bead>& beads) {
  for (Bead& bead : beads)
    for (int d = 0; d < 3; ++d) bead.f[d] = -bead.x[d];
}
bool same(const std::vector<Bead>& a, const std::vector<Bead>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Bead)) == 0;
}
template <class Scheme>
void check_routine_that_resizes(Scheme scheme) {
  for (int which = 1; which <= 4; ++which)
    for (const std::size_t length : {5u, 12u, 500u}) {
      std::vector<Bead> beads = ten();
      MotionInPlace state{places(beads, &Bead::x), places(beads, &Bead::v), places(beads, &Bead::f)};
      int calls = 0;
      PhiStepper stepper{state, state.force_of_r([&] {
                           pull(beads);
                           if (++calls == which) beads.resize(length);
                         }),
                         scheme};
      int told = 0;
      for (int n = 0; n < 4; ++n) try {
          const bool done = static_cast<bool>(stepper.step(state, 0.1 * n, 0.1));
          REQUIRE(done);
        } catch (const std::logic_error& error) {
          CHECK_THAT(error.what(), contains("number of particles"));
          ++told;
        }
      CHECK(told == 1);
      CHECK(beads.size() == length);
    }
}

}  // namespace

TEST_CASE("in place: a routine that adds or removes particles is told so, in any call", "[embed]") {
  check_routine_that_resizes(symplectic_euler);
  check_routine_that_resizes(velocity_verlet);
  check_routine_that_resizes(srkn6b);
}

TEST_CASE("in place: a routine that changes the length of one array is told so", "[embed]") {
  std::vector<double> x(30, 1), v(30), f(30);
  MotionInPlace state{places(x), places(v), places(f)};
  const auto check = [&](auto scheme) {
    f.resize(30);
    int calls = 0;
    PhiStepper stepper{state, state.force_of_r([&] {
                         for (std::size_t i = 0; i < 30; ++i) f[i] = -x[i];
                         if (++calls == 3) f.resize(40);
                       }),
                       scheme};
    int n = 0;
    CHECK_THROWS_AS(
        [&] {
          for (; n < 4; ++n) static_cast<void>(stepper.step(state, 0.1 * n, 0.1));
        }(),
        std::logic_error);
    CHECK(calls == 3);
  };
  check(velocity_verlet), check(srkn6b);
}

TEST_CASE("in place: outside of steps a call puts the arrays back after their lengths have changed, too", "[embed]") {
  std::vector<Bead> beads = ten();
  MotionInPlace state{places(beads, &Bead::x), places(beads, &Bead::v), places(beads, &Bead::f)};
  PhiStepper stepper{state, state.force_of_r([&] { pull(beads); }), velocity_verlet};
  REQUIRE(stepper.step(state, 0, 0.1));
  beads.resize(20, beads[3]);
  REQUIRE(stepper.step(state, 0.1, 0.1));
  Motion<Eigen::Matrix3Xd> elsewhere{Eigen::Matrix3Xd::Ones(3, 20), Eigen::Matrix3Xd::Zero(3, 20)}, slope = elsewhere;
  const std::vector<Bead> before = beads;
  REQUIRE(stepper.slope(0, elsewhere, slope));
  CHECK(same(beads, before));
}
