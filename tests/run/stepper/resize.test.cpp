// What may change between two steps besides numbers: a parameter, the number of components, the stepper's owner.
#include <phistep/particles/bodies/particles.hpp>

#include <cstdint>
#include <vector>

#include "run/stepper/resize_cases.hpp"

using namespace resize_cases;

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
