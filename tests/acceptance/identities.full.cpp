// Relations that hold for one step of any problem, by every named scheme too, of first order, and a million steps of
// the clock. The quick half: identities.test.cpp.

#include "acceptance/identities_cases.hpp"

using problems::ForcedFlow;

TEST_CASE("a step satisfies the source's equations (1.12) and (1.13)") {
  for (const double phi : phis) {
    const double residual = worst_residual(by(phistep::phi(phi)), source(phi));
    CAPTURE(phi, residual);
    CHECK(residual <= residual_bound);
  }
  CHECK(worst_residual(by(phistep::forward_euler), source(0)) <= residual_bound);
  CHECK(worst_residual(by(phistep::trapezoidal), source(0.5)) <= residual_bound);
  CHECK(worst_residual(by(phistep::backward_euler), source(1)) <= residual_bound);
  CHECK(worst_residual(by(phistep::from_spectral_radius(0.25)), source(0.8)) <= residual_bound);
}

TEST_CASE("a stage step evaluates the force once, at t + phi h on the chord") {
  for (const double phi : phis) {
    const double residual = worst_residual(by(phistep::phi_stage(phi)), stage(phi));
    CAPTURE(phi, residual);
    CHECK(residual <= residual_bound);
  }
  CHECK(worst_residual(by(phistep::midpoint), stage(0.5)) <= residual_bound);
}

TEST_CASE("a pair weights the force by phi_force and the drift by phi_drift") {
  for (const double phi_force : phis)
    for (const double phi_drift : phis) {
      const double residual = worst_residual(by(phistep::phi(phi_force, phi_drift)), pair(phi_force, phi_drift));
      CAPTURE(phi_force, phi_drift, residual);
      CHECK(residual <= residual_bound);
    }
  CHECK(worst_residual(by(phistep::symplectic_euler), pair(0, 1)) <= residual_bound);
  CHECK(worst_residual(by(phistep::symplectic_euler_adjoint), pair(1, 0)) <= residual_bound);
}

TEST_CASE("twins: endpoint is backward Euler after forward Euler, stage the other way round") {
  for (const double phi : {0.25, 0.5, 0.7}) {
    const double before = (1 - phi) * h, after = phi * h;
    const double endpoint =
        twin_defect(by(phistep::phi(phi)), by(phistep::forward_euler), before, by(phistep::backward_euler), after);
    const double stage = twin_defect(by(phistep::phi_stage(phi)), by(phistep::backward_euler), after,
                                     by(phistep::forward_euler), before);
    CAPTURE(phi, endpoint, stage);
    CHECK(endpoint <= 1e-14);
    CHECK(stage <= 1e-14);
    // The two forms are not the same scheme.
    CHECK(twin_defect(by(phistep::phi(phi)), by(phistep::backward_euler), after, by(phistep::forward_euler), before) >
          1e-5);
  }
}

TEST_CASE("adjoint: a step with phi over h and one with 1 - phi over -h lead back") {
  for (const double phi : phis) {
    CAPTURE(phi);
    CHECK(return_defect(by(phistep::phi(phi)), by(phistep::phi(1 - phi))) <= 1e-13);
    CHECK(return_defect(by(phistep::phi_stage(phi)), by(phistep::phi_stage(1 - phi))) <= 1e-13);
  }
  CHECK(return_defect(by(phistep::forward_euler), by(phistep::backward_euler)) <= 1e-13);
  CHECK(return_defect(by(phistep::backward_euler), by(phistep::forward_euler)) <= 1e-13);
  CHECK(return_defect(by(phistep::trapezoidal), by(phistep::trapezoidal)) <= 1e-13);
  CHECK(return_defect(by(phistep::midpoint), by(phistep::midpoint)) <= 1e-13);
  CHECK(return_defect(by(phistep::symplectic_euler), by(phistep::symplectic_euler_adjoint)) <= 1e-13);
  CHECK(return_defect(by(phistep::symplectic_euler_adjoint), by(phistep::symplectic_euler)) <= 1e-13);
  CHECK(return_defect(by(phistep::velocity_verlet), by(phistep::velocity_verlet)) <= 1e-13);
  CHECK(return_defect(by(phistep::phi(0.7)), by(phistep::phi(0.7))) > 1e-4);  // only its adjoint undoes a step
}

TEST_CASE("a first-order step satisfies its formula with a capacity") {
  using Problem = ForcedFlow<>;
  const Problem problem;
  const auto worst = [&](auto scheme, double phi, bool stage) {
    Vec y = Problem::exact(0);
    phistep::PhiStepper stepper{y, problem, scheme, phistep::capacity(Problem::capacity)};
    double largest_residual = 0;
    for (int n = 0; n < 50; ++n) {
      const Vec before = y;
      const double t = h * n;
      problems::step(stepper, y, t, h);
      const Vec rate = stage ? problem(before + phi * (y - before), t + phi * h)
                             : Vec(phi * problem(y, t + h) + (1 - phi) * problem(before, t));
      largest_residual =
          std::max(largest_residual, (Problem::capacity * (y - before) - h * rate).cwiseAbs().maxCoeff());
    }
    return largest_residual;
  };
  for (const double phi : phis) {
    CAPTURE(phi);
    CHECK(worst(phistep::phi(phi), phi, false) <= residual_bound);
    CHECK(worst(phistep::phi_stage(phi), phi, true) <= residual_bound);
  }
}

TEST_CASE("time: a million steps of 0.1 end at 1e5, in double and in float") {
  // As a running sum, double would miss 1e5 by 1e-6, float by 958.
  const auto end_of_run = []<class T>(T dt) {
    using One = Eigen::Matrix<T, 1, 1>;
    One y{T{1}};
    phistep::PhiStepper stepper{y, [](const One& x) -> One { return T(-1e-5) * x; }, phistep::forward_euler};
    const auto report = phistep::integrate(stepper, y, {T{0}, T{100000}}, phistep::fixed(static_cast<double>(dt)));
    CHECK(report);
    CHECK(report.statistics.steps == 1000000);
    return report.t;
  };
  CHECK(end_of_run(0.1) == 100000);
  CHECK(end_of_run(0.1F) == 100000);
}
