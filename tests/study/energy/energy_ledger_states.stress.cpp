// energy_ledger: masses that are matrices; states and scalars are in energy_ledger_scalars.stress.cpp.
// In short: energy_ledger.test.cpp.
#include "study/energy/energy_ledger_cases.hpp"

using namespace energy_ledger_cases;

TEST_CASE("masses that are matrices, 3xN states, maps, float and long double") {
  const Eigen::MatrixXd M = coupled_masses(), K = coupled_springs();
  check_mass_matrix(velocity_verlet, linear(K), M);
  check_mass_matrix(backward_euler, linear(K), M);
  check_mass_matrix(trapezoidal, linear(K), M);
  check_mass_matrix(velocity_verlet, linear(K), Eigen::SparseMatrix<double>(M.sparseView()));
  check_mass_matrix(backward_euler, linear(Eigen::SparseMatrix<double>(K.sparseView())), M);
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
  check_editing_observer(stepper, y);
}
