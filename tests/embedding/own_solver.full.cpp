// A program's own linear solver in implicit steps, as docs/embedding.md has it.
#include <phistep/phistep.hpp>
#include <phistep/sparse.hpp>

#include <algorithm>
#include <string>

#include "support/catch.hpp"

using namespace phistep;

namespace {

/// A chain of springs between neighbours, with its sparse Jacobian.
struct Chain {
  Eigen::VectorXd operator()(const Eigen::VectorXd& r) const {
    Eigen::VectorXd f = -2 * r - r.array().cube().matrix();
    f.tail(r.size() - 1) += r.head(r.size() - 1);
    f.head(r.size() - 1) += r.tail(r.size() - 1);
    return f;
  }
  [[nodiscard]] Eigen::SparseMatrix<double> jacobian(const Eigen::VectorXd& r) const {
    Eigen::SparseMatrix<double> K(r.size(), r.size());
    for (Eigen::Index i = 0; i < r.size(); ++i) {
      if (i > 0) K.insert(i, i - 1) = 1;
      K.insert(i, i) = -2 - 3 * r[i] * r[i];
      if (i + 1 < r.size()) K.insert(i, i + 1) = 1;
    }
    return K;
  }
};
/// A program's own solver for tridiagonal matrices (Thomas), with the five members that are asked for. All its solutions are
/// too long by `off`.
struct Thomas {
  using Matrix = Eigen::SparseMatrix<double>;
  static inline int analyses = 0, factorizations = 0, solves = 0;
  static inline double off = 0;
  static inline bool compressed = true;

  void analyzePattern(const Matrix&) { ++analyses; }
  void factorize(const Matrix& W) {
    ++factorizations;
    compressed = compressed && W.isCompressed();
    const Eigen::Index n = W.rows();
    below.setZero(n), above.setZero(n), pivot.setZero(n);
    for (Eigen::Index j = 0; j < n; ++j)
      for (Matrix::InnerIterator it(W, j); it; ++it)
        (it.row() == j  ? pivot
         : it.row() > j ? below
                        : above)[std::max(it.row(), j) - (it.row() == j ? 0 : 1)] = it.value();
    for (Eigen::Index i = 0; i + 1 < n; ++i) {
      below[i] /= pivot[i];
      pivot[i + 1] -= below[i] * above[i];
    }
    fine = pivot.allFinite() && (pivot.array() != 0).all();
  }
  [[nodiscard]] Eigen::ComputationInfo info() const { return fine ? Eigen::Success : Eigen::NumericalIssue; }
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& b) const {
    ++solves;
    Eigen::VectorXd x = b;
    for (Eigen::Index i = 1; i < x.size(); ++i) x[i] -= below[i - 1] * x[i - 1];
    for (Eigen::Index i = x.size(); i-- > 0;) {
      if (i + 1 < x.size()) x[i] -= above[i] * x[i + 1];
      x[i] /= pivot[i];
    }
    return (1 + off) * x;
  }

  Eigen::VectorXd below, above, pivot;
  bool fine = false;
};
struct Ended {
  Eigen::VectorXd r;
  Outcome outcome = Outcome::success;
  const char* solver;
  Statistics statistics;
};
Ended chain_steps(auto scheme, const auto&... solver) {
  Motion<Eigen::VectorXd> y{Eigen::VectorXd::LinSpaced(9, 0, 1), Eigen::VectorXd::Zero(9)};
  PhiStepper stepper{y, Chain{}, scheme, solver...};
  Ended end;
  for (int n = 0; n < 10 && end.outcome == Outcome::success; ++n) end.outcome = stepper.step(y, 0.5 * n, 0.5).outcome();
  end.r = y.r, end.solver = stepper.solver_name(), end.statistics = stepper.statistics();
  return end;
}

}  // namespace

TEST_CASE("a program's own linear solver: newton<Solver>() uses it, and only it") {
  const Ended library = chain_steps(backward_euler);
  Thomas::analyses = Thomas::factorizations = Thomas::solves = 0;
  const Ended own = chain_steps(backward_euler, newton<Thomas>());
  CHECK(own.outcome == Outcome::success);
  CHECK(own.solver == std::string("a solver of the user's own"));
  CHECK((own.r - library.r).cwiseAbs().maxCoeff() < 1e-14);
  CHECK(Thomas::analyses == 1);
  CHECK(Thomas::compressed);
  CHECK((Thomas::factorizations == own.statistics.factorizations && Thomas::factorizations > 0));
  CHECK((Thomas::solves == own.statistics.solves && Thomas::solves > Thomas::factorizations));
}

TEST_CASE("an own linear solver that is 1 % off: Newton's answer keeps its digits, a Rosenbrock step is refused") {
  const Ended exact = chain_steps(backward_euler, newton<Thomas>());
  Thomas::off = 0.01;
  const Ended off = chain_steps(backward_euler, newton<Thomas>());
  CHECK(off.outcome == Outcome::success);
  CHECK((off.r - exact.r).cwiseAbs().maxCoeff() < 1e-14);
  CHECK(chain_steps(rodas4, newton<Thomas>()).outcome == Outcome::wrong_jacobian);
  Thomas::off = 0;
  CHECK(chain_steps(rodas4, newton<Thomas>()).outcome == Outcome::success);
}
