// Resets, resizes, edits of parameters and copies with every scheme; the quick half is resize.test.cpp.
#include <phistep/sparse.hpp>

#include "run/stepper/resize_cases.hpp"

using namespace resize_cases;

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
