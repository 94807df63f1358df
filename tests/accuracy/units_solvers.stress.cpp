// The same problem in other units: affine forces, every solver. In short: units.test.cpp.
#include <phistep/krylov.hpp>
#include <phistep/sparse.hpp>

#include "accuracy/units_cases.hpp"

TEST_CASE("units: affine forces, dense and sparse") {
  const auto K = [](const Units& u) {
    Eigen::MatrixXd k = Eigen::MatrixXd::Zero(5, 5);
    for (int i = 0; i < 5; ++i) {
      k(i, i) = u.of(-81.3, 0, 1, -2);
      if (i > 0) k(i, i - 1) = k(i - 1, i) = u.of(40.1, 0, 1, -2);
    }
    return k;
  };
  const auto C = [](const Units& u) { return Eigen::MatrixXd(u.of(-0.3, 0, 1, -1) * Eigen::MatrixXd::Identity(5, 5)); };
  for (const double dt : {0.01, 0.3, 10.0}) {
    check_motion(
        trapezoidal, [&](const Units& u) { return linear(K(u), C(u)); }, to_rounding, dt, 20);
    check_motion(
        backward_euler, [&](const Units& u) { return linear(Eigen::SparseMatrix<double>(K(u).sparseView())); },
        to_rounding, dt, 20);
    check_motion(
        tr_bdf2, [&](const Units& u) { return symmetric(linear(Eigen::SparseMatrix<double>(K(u).sparseView()))); },
        to_rounding, dt, 20);
    check_motion(
        trapezoidal, [&](const Units& u) { return affine([k = K(u)](const Vec& r) -> Vec { return k * r; }); },
        to_rounding, dt, 20);
  }
}

TEST_CASE("units: sparse, banded, particles by themselves, a matrix-free solver") {
  check_motion(
      trapezoidal, [](const Units& u) { return banded(chain(u), 1, 1); }, to_rounding, 0.1, 20);
  Eigen::SparseMatrix<double> pattern(5, 5);
  for (int i = 0; i < 5; ++i) {
    pattern.insert(i, i) = 1;
    if (i > 0) pattern.insert(i, i - 1) = 1, pattern.insert(i - 1, i) = 1;
  }
  check_motion(
      trapezoidal, [&](const Units& u) { return sparsity(chain(u), pattern); }, to_rounding, 0.1, 20);
  check_motion(
      backward_euler, [&](const Units& u) { return symmetric(sparsity(elastic_chain(u), pattern)); }, to_rounding, 0.1,
      20);
  using One = Eigen::Matrix<double, 1, 1>;
  const auto wells = [](const Units& u) {
    return local<1>([k = u.of(4, 0, 1, -2), q = u.of(9, -2, 1, -2), c = u.of(0.3, 0, 1, -1)](
                        const One& r, const One& v) -> One { return One{-(k + q * r[0] * r[0]) * r[0] - c * v[0]}; });
  };
  check_motion(trapezoidal, wells, to_rounding, 0.2, 40);
  check_motion(
      backward_euler, wells, [](const Units& u) { return newton({.rtol = 1e-4, .atol = u.of(1e-5, 1, 0, -1)}); }, 0.2,
      40);
  const auto krylov = [](const Units&) { return newton<MatrixFree<>>(); };
  check_motion(trapezoidal, chain, krylov, 0.1, 20);
  check_motion(trapezoidal, tangent_chain, krylov, 0.1, 20);
}
