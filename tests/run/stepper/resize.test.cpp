// What may change between two steps besides numbers: a parameter, the number of components, the stepper's owner.
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <vector>

#include "contract/states.hpp"
#include "support/catch.hpp"
#if PHISTEP_QUICK
#include <phistep/particles/bodies/particles.hpp>
#endif
#if PHISTEP_FULL
#include <phistep/sparse.hpp>
#endif

using namespace phistep;
using namespace states;

namespace resize_cases {
/// Throws when told to, with its force half written.
struct Interrupted {
  static constexpr bool uses_velocity = false, uses_time = false;
  const bool* fail;
  void add(double, const auto& y, auto& out) const {
    out.force[0] -= 2 * y.r[0];
    if (*fail) throw std::runtime_error("force");
    for (Eigen::Index i = 1; i < y.r.size(); ++i) out.force[i] -= 2 * y.r[i];
  }
};

/// The one force that the quick half solves for: a stepper of dynamic vectors takes seconds to compile.
struct Elastic {
  double k;
  Dynamic operator()(const Dynamic& r) const { return -k * r; }
};

void check_interrupted(auto scheme) {
  bool fail = false;
  SecondOrder<Dynamic> a, b;
  PhiStepper stepper{a.state, Interrupted{&fail}, scheme};
  PhiStepper never{b.state, Interrupted{&fail}, scheme};
  for (int n = 0; n < 10; ++n) {
    fail = true;
    CHECK_THROWS_AS(stepper.step(a.state, 0.1 * n, 0.2), std::runtime_error);
    fail = false;
    REQUIRE(stepper.step(a.state, 0.1 * n, 0.1));
    REQUIRE(never.step(b.state, 0.1 * n, 0.1));
    CHECK(distance(numbers(a.state), numbers(b.state)) <= 1e-13);
  }
}

void check_parameter(auto scheme) {
  SecondOrder<Dynamic> a;
  PhiStepper stepper{a.state, Elastic{1}, scheme};
  REQUIRE(stepper.step(a.state, 0, 0.1));
  SecondOrder<Dynamic> b;
  b.state = a.state;
  stepper.force().k = 50;
  PhiStepper fresh{b.state, Elastic{50}, scheme};
  REQUIRE(stepper.step(a.state, 0.1, 0.1));
  REQUIRE(fresh.step(b.state, 0.1, 0.1));
  CHECK(distance(numbers(a.state), numbers(b.state)) <= 1e-14);
}

void check_reset(const auto& force, auto scheme, double tolerance) {
  SecondOrder<Dynamic> a, b;
  PhiStepper one{a.state, force, scheme}, two{b.state, force, scheme};
  for (int n = 0; n < 20; ++n) {
    two.reset();
    REQUIRE((one.step(a.state, 0, 0.1) && two.step(b.state, 0, 0.1)));
  }
  CHECK(distance(numbers(a.state), numbers(b.state)) <= tolerance);
}

void check_sizes(const auto& force, auto scheme, const auto&... masses) {
  Motion<Dynamic> y{Dynamic::Ones(2), Dynamic::Zero(2)};
  PhiStepper stepper{y, force, scheme, masses...};
  for (const Eigen::Index size : {2, 5, 5, 1, 8, 2}) {
    y.r = Dynamic::LinSpaced(size, 1, 2), y.v = Dynamic::Zero(size);
    auto z = y;
    PhiStepper fresh{z, force, scheme, masses...};
    REQUIRE(stepper.step(y, 0, 0.1));
    REQUIRE(fresh.step(z, 0, 0.1));
    CHECK(distance(numbers(y), numbers(z)) <= 1e-14);
  }
}

void check_mass_that_fits_no_more(auto scheme) {
  Dynamic y = Dynamic::Ones(2);
  PhiStepper stepper{y, Pull{}, scheme, mass(Eigen::Vector2d(1, 2))};
  REQUIRE(stepper.step(y, 0, 0.1));
  y = Dynamic::Ones(3);
  for (int k = 0; k < 2; ++k) CHECK_THROWS_AS(stepper.step(y, 0, 0.1), std::invalid_argument);
  CHECK(y == Dynamic::Ones(3));
  y = Dynamic::Ones(2);
  CHECK(stepper.step(y, 0, 0.1));
}

template <class State>
void check_copies(const State& start, const State& other, const auto& force, auto scheme) {
  const auto run = [&](bool disturb) {
    State y = start;
    PhiStepper stepper{y, force, scheme};
    for (int n = 0; n < 3; ++n) REQUIRE(stepper.step(y, 0, 0.01));
    auto copy = std::make_unique<decltype(stepper)>(stepper);
    if (disturb) {
      State z = other;
      REQUIRE(copy->step(z, 0, 0.3));
      copy.reset();
    }
    const Statistics before = stepper.statistics();
    for (int n = 0; n < 3; ++n) REQUIRE(stepper.step(y, 0, 0.01));
    return std::pair{y, stepper.statistics() - before};
  };
  const auto disturbed = run(true), alone = run(false);
  CHECK(same_bits(numbers(disturbed.first), numbers(alone.first)));
  CHECK(disturbed.second == alone.second);
}

}  // namespace resize_cases

using namespace resize_cases;

#if PHISTEP_QUICK

TEST_CASE("a step that was interrupted by an exception leaves nothing stale") { check_interrupted(velocity_verlet); }

TEST_CASE("a parameter changed through force() takes effect at once") {
  check_parameter(velocity_verlet), check_parameter(phi(0.7));
}

TEST_CASE("reset changes no result") {
  check_reset(Elastic{2}, velocity_verlet, 0), check_reset(Elastic{2}, phi(0.7), 1e-13);
}

// ---- the number of components may change between steps --------------------------------------------------------------

TEST_CASE("a dynamic state may grow and shrink between steps") {
  check_sizes(Elastic{2}, velocity_verlet), check_sizes(Elastic{2}, phi(0.7));
}

TEST_CASE("a mass per component does not fit a resized state: it throws, every time, and leaves the state") {
  check_mass_that_fits_no_more(forward_euler);
}

TEST_CASE("growing beyond what dense differences can do throws every time") {
  Motion<Dynamic> y{Dynamic::Ones(2), Dynamic::Ones(2)};
  PhiStepper stepper{y, Elastic{1}, phi(0.7)};
  REQUIRE(stepper.step(y, 0, 0.1));
  y.r = y.v = Dynamic::Ones(1001);
  for (int k = 0; k < 2; ++k) CHECK_THROWS_AS(stepper.step(y, 0, 0.1), std::invalid_argument);
  CHECK(y.r == Dynamic::Ones(1001));
  y.r = y.v = Dynamic::Ones(3);
  CHECK(stepper.step(y, 0, 0.1));
}

TEST_CASE("a motion whose r and v differ in size throws, at construction and later") {
  Motion<Dynamic> y{Dynamic::Ones(3), Dynamic::Ones(2)};
  CHECK_THROWS_AS((PhiStepper{y, Elastic{1}, forward_euler}), std::invalid_argument);
  y.v = Dynamic::Ones(3);
  PhiStepper stepper{y, Elastic{1}, velocity_verlet};
  y.v = Dynamic::Ones(4);
  CHECK_THROWS_AS(stepper.step(y, 0, 0.1), std::invalid_argument);
}

TEST_CASE("an empty state is stepped without complaint") {
  Motion<Dynamic> y{Dynamic(0), Dynamic(0)};
  CHECK(PhiStepper{y, Elastic{-1}, phi(0.7)}.step(y, 0, 0.1));
}

// ---- copies ---------------------------------------------------------------------------------------------------------

TEST_CASE("a copy of a stepper shares nothing with the original") {
  check_copies(Motion<Dynamic>{Dynamic::LinSpaced(4, 0.1, 0.2), Dynamic::Ones(4)},
               Motion<Dynamic>{Dynamic::LinSpaced(4, 1, 2), Dynamic::Ones(4)}, Elastic{3}, phi(0.7));
}

TEST_CASE("held particles are taken away, or come, and the next step is a fresh stepper's") {
  const auto scene = [](Index n) {
    Particles<double, 3> y{Eigen::Matrix3Xd::Random(3, n)};
    std::vector<std::uint8_t> still(static_cast<std::size_t>(n));
    for (std::size_t i = 0; i < still.size(); ++i) still[i] = i % 2;
    y.set_still(still);
    return y;
  };
  const auto force = Gravity{Eigen::Vector3d{0, 0, -1}};
  for (const Origin origin : {Origin::unknown, Origin::unedited}) {
    auto y = scene(60);
    PhiStepper stepper{y, force, symplectic_euler};
    for (int k = 0; k < 2; ++k) REQUIRE(stepper.step(y, 0.1 * k, 0.1, origin));
    CHECK(y.erase_if([](Index i) { return i >= 30; }) == 30);
    for (const Index more : {0, 40}) {
      if (more > 0) y = scene(more);
      auto expected = y;
      PhiStepper fresh{expected, force, symplectic_euler};
      for (int k = 0; k < 3; ++k) {
        REQUIRE(stepper.step(y, 0.1 * k, 0.1, k == 0 ? Origin::unknown : origin));
        REQUIRE(fresh.step(expected, 0.1 * k, 0.1));
        CHECK((y.r.array() == expected.r.array()).all());
        CHECK((y.v.array() == expected.v.array()).all());
      }
    }
  }
}

#elif PHISTEP_FULL
// Resets, resizes, edits of parameters and copies with every scheme.

TEST_CASE("a step that was interrupted by an exception leaves nothing stale") {
  check_interrupted(forward_euler), check_interrupted(velocity_verlet), check_interrupted(phi(0.7));
}

TEST_CASE("a parameter changed through force() takes effect at once") {
  check_parameter(velocity_verlet), check_parameter(phi(0.7)), check_parameter(backward_euler);
}

TEST_CASE("reset changes no result") { check_reset(Pull{}, velocity_verlet, 0), check_reset(Pull{}, phi(0.7), 1e-13); }

// ---- the number of components may change between steps --------------------------------------------------------------

TEST_CASE("a dynamic state may grow and shrink between steps") {
  const auto heavy = mass(2.0);
  check_sizes(Pull{}, forward_euler, heavy), check_sizes(Pull{}, velocity_verlet, heavy);
  check_sizes(Pull{}, phi(0.7), heavy);
}

TEST_CASE("a mass per component does not fit a resized state: it throws, every time, and leaves the state") {
  check_mass_that_fits_no_more(forward_euler), check_mass_that_fits_no_more(backward_euler);
}

TEST_CASE("growing beyond what dense differences can do throws every time") {
  Dynamic y = Dynamic::Ones(2);
  PhiStepper stepper{y, [](const Dynamic& x) -> Dynamic { return -x; }, backward_euler};
  REQUIRE(stepper.step(y, 0, 0.1));
  y = Dynamic::Ones(1001);
  for (int k = 0; k < 2; ++k) CHECK_THROWS_AS(stepper.step(y, 0, 0.1), std::invalid_argument);
  CHECK(y == Dynamic::Ones(1001));
  y = Dynamic::Ones(3);
  CHECK(stepper.step(y, 0, 0.1));
}

TEST_CASE("a motion whose r and v differ in size throws, at construction and later") {
  Motion<Dynamic> y{Dynamic::Ones(3), Dynamic::Ones(2)};
  CHECK_THROWS_AS((PhiStepper{y, Pull{}, forward_euler}), std::invalid_argument);
  CHECK_THROWS_AS((PhiStepper{y, Pull{}, trapezoidal}), std::invalid_argument);
  y.v = Dynamic::Ones(3);
  PhiStepper stepper{y, Pull{}, velocity_verlet};
  y.v = Dynamic::Ones(4);
  CHECK_THROWS_AS(stepper.step(y, 0, 0.1), std::invalid_argument);
}

TEST_CASE("an empty state is stepped without complaint") {
  Dynamic y(0);
  const auto nothing = [](const Dynamic& x) -> Dynamic { return x; };
  CHECK(PhiStepper{y, nothing, forward_euler}.step(y, 0, 0.1));
  CHECK(PhiStepper{y, nothing, trapezoidal}.step(y, 0, 0.1));
}

// ---- copies ---------------------------------------------------------------------------------------------------------

TEST_CASE("a copy of a stepper shares nothing with the original") {
  struct Sparse {
    Dynamic operator()(const Dynamic& y) const { return -y.array().cube(); }
    Eigen::SparseMatrix<double> jacobian(const Dynamic& y) const {
      const Eigen::MatrixXd J = (-3 * y.array().square()).matrix().asDiagonal();
      return J.sparseView();
    }
  };
  const Dynamic y = Dynamic::LinSpaced(4, 0.1, 0.2), z = Dynamic::LinSpaced(4, 1, 2);
  check_copies(y, z, Pull{}, backward_euler), check_copies(y, z, Sparse{}, backward_euler);
}

#endif
