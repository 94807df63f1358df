#include <phistep/base/facts/phi.hpp>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "support/catch.hpp"

using namespace phistep;

static_assert(std::is_empty_v<decltype(forward_euler)>);
static_assert(forward_euler.facts.is_explicit && !trapezoidal.facts.is_explicit && !phi(0.0).facts.is_explicit);
static_assert(symplectic_euler.facts.is_explicit && symplectic_euler.facts.motion_only &&
              symplectic_euler_adjoint.facts.is_explicit);
static_assert(!trapezoidal.facts.motion_only && !phi(0.5).facts.motion_only && phi(0.5, 0.5).facts.motion_only);
static_assert(trapezoidal.form == Form::endpoint && midpoint.form == Form::stage);
static_assert(trapezoidal.force.value<long double>() == 0.5L && backward_euler.drift.value<float>() == 1.0f);

TEST_CASE("order is 2 exactly where both weights are one half") {
  CHECK(forward_euler.order() == 1);
  CHECK(backward_euler.order() == 1);
  CHECK(symplectic_euler.order() == 1);
  CHECK(symplectic_euler_adjoint.order() == 1);
  CHECK(trapezoidal.order() == 2);
  CHECK(midpoint.order() == 2);
  CHECK(phi(0.5).order() == 2);
  CHECK(phi(0.5, 0.5).order() == 2);
  CHECK(phi_stage(0.5).order() == 2);
  CHECK(phi(0.7).order() == 1);
  CHECK(phi(0.5, 0.7).order() == 1);
  CHECK(phi(0.7, 0.5).order() == 1);
}

TEST_CASE("a run-time phi outside [0, 1], or NaN, throws") {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  for (const double bad : {-1e-300, -1.0, std::nextafter(1.0, 2.0), 2.0, nan, inf, -inf}) {
    CAPTURE(bad);
    CHECK_THROWS_AS(phi(bad), std::invalid_argument);
    CHECK_THROWS_AS(phi_stage(bad), std::invalid_argument);
    CHECK_THROWS_AS(phi(bad, 0.5), std::invalid_argument);
    CHECK_THROWS_AS(phi(0.5, bad), std::invalid_argument);
    CHECK_THROWS_AS(from_spectral_radius(bad), std::invalid_argument);
  }
  for (const double good : {0.0, 0.5, 1.0}) CHECK_NOTHROW(phi(good));
}

TEST_CASE("from_spectral_radius gives the phi whose stiff limit is that radius") {
  CHECK(from_spectral_radius(1.0).force.value<double>() == 0.5);
  CHECK(from_spectral_radius(0.0).force.value<double>() == 1.0);
  const double p = from_spectral_radius(0.6).force.value<double>();
  CHECK((1 - p) / p == Approx(0.6).epsilon(1e-15));
}
