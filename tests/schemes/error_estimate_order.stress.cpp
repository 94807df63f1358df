// A step's estimate tends to its error, by every scheme; in short: error_estimate.test.cpp.
#include "schemes/error_estimate_cases.hpp"

using namespace error_estimate_cases;

TEST_CASE("first order: the estimate tends to the error, at every φ, by every way") {
  const Vec start = Flow::exact(0.3);
  const auto all = [&](const char* name, auto scheme) {
    CAPTURE(name);
    check(flow(scheme), start, 0.04);
  };
  all("0", forward_euler), all("phi(0)", phi(0.0)), all("0.25", phi(0.25)), all("phi(0.5)", phi(0.5));
  all("trapezoidal", trapezoidal), all("0.7", phi(0.7)), all("1", backward_euler), all("tr_bdf2", tr_bdf2);
  all("midpoint", midpoint), all("stage", phi_stage(0.7)), all("rannacher", rannacher);
}

TEST_CASE("motion with drag: the same, for r and for v") {
  const auto with = [](auto scheme) {
    return [scheme](const Motion<Vec>& y) { return PhiStepper{y, Swing{}, scheme, mass(Swing::mass)}; };
  };
  const Motion<Vec> start = Swing::exact(0.3);
  const auto all = [&](const char* name, auto scheme) {
    CAPTURE(name);
    check(with(scheme), start, 0.04);
  };
  all("0", forward_euler), all("0.25", phi(0.25)), all("trapezoidal", trapezoidal), all("0.7", phi(0.7));
  all("1", backward_euler), all("tr_bdf2", tr_bdf2), all("midpoint", midpoint), all("verlet", velocity_verlet);
  all("symplectic", symplectic_euler), all("adjoint", symplectic_euler_adjoint), all("pair", phi(0.6, 0.8));
}
