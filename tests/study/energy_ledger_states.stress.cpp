// energy_ledger: masses that are matrices; states and scalars are in energy_ledger_scalars.stress.cpp.
// The quick half is energy_ledger.test.cpp.
#include "study/energy_ledger_cases.hpp"

using namespace energy_ledger_cases;

TEST_CASE("masses that are matrices, 3xN states, maps, float and long double") {
  const int n = 300;
  {
    Eigen::MatrixXd M(3, 3), K(3, 3);
    M << 4, 1, 0, 1, 3, 0.5, 0, 0.5, 2;
    K << -9, 2, 0, 2, -7, 1, 0, 1, -5;
    const auto check = [&](auto scheme, const auto& force, const auto& m) {
      Motion<Eigen::VectorXd> y{Eigen::Vector3d(1, 0, -0.5), Eigen::Vector3d(0, 0.3, 0)};
      PhiStepper stepper{y, force, scheme, mass(m)};
      EnergyLedger ledger{stepper};
      march(stepper, y, 0.1, n, ledger);
      CHECK(std::abs(ledger.closure()) <= rounding(n) * ledger.largest_energy());
      CHECK(std::abs(ledger.solver()) <= 1e-12 * ledger.largest_energy());
      CHECK(ledger.scheme() == Approx(ledger.energy() - ledger.start()).margin(1e-12));
      CHECK(ledger.external() == 0);
    };
    check(velocity_verlet, linear(K), M);
    check(backward_euler, linear(K), M);
    check(trapezoidal, linear(K), M);
    check(velocity_verlet, linear(K), Eigen::SparseMatrix<double>(M.sparseView()));
    check(backward_euler, linear(Eigen::SparseMatrix<double>(K.sparseView())), M);
  }
}

TEST_CASE("a matrix K that is not symmetric has no potential: its work is external") {
  Eigen::Matrix2d K;
  K << -4, 1, -1, -4;
  Motion<Eigen::Vector2d> y{Eigen::Vector2d(1, 0), Eigen::Vector2d(0, 0)};
  PhiStepper stepper{y, linear(K), trapezoidal};
  EnergyLedger ledger{stepper};
  march(stepper, y, 0.1, 100, ledger);
  CHECK(ledger.potential() == 0);
  CHECK(std::abs(ledger.external()) > 0.1);
  CHECK(ledger.scheme() == Approx(0).margin(1e-14));
  CHECK(std::abs(ledger.closure()) <= rounding(100) * ledger.largest_energy());
}

TEST_CASE("a run of fixed steps with an observer that edits: what it does counts as edits") {
  Motion<One> y{One{1.0}, One{0.0}};
  PhiStepper stepper{y, spring, trapezoidal};
  EnergyLedger ledger{stepper};
  double added = 0;
  int shown = 0;
  const auto thermostat = [&](double, Motion<One>& s) {
    if (++shown % 10 != 0) return;
    const double before = s.v[0] * s.v[0] / 2;
    s.v[0] *= 1.1;
    added += s.v[0] * s.v[0] / 2 - before;
  };
  REQUIRE(integrate(stepper, y, {0.0, 10.05}, fixed(0.1), ledger, thermostat));  // the last step is shorter
  CHECK(ledger.steps() == 101);
  CHECK(ledger.edits() == Approx(added).epsilon(1e-13));
  CHECK(std::abs(ledger.scheme()) <= 1e-14);
  CHECK(std::abs(ledger.closure()) <= 1e-14);
  CHECK(stepper.statistics().steps == 101);
}
