// spectral_bound against 1000 random matrices. The quick half is spectral_bound.test.cpp.
#include <phistep/study/stability/spectrum.hpp>

#include "study/stability/spectral_bound_cases.hpp"

using namespace spectral_bound_cases;

namespace {

MatrixXd random_matrix(std::mt19937& random, Eigen::Index n, double density) {
  std::normal_distribution<double> entry;
  std::uniform_real_distribution<double> there;
  MatrixXd A = MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      // A cycle in all of them: the eigenvalues of nilpotent matrices would be rounding and nothing else.
      if (there(random) < density || j == (i + 1) % n) A(i, j) = entry(random) * std::exp(entry(random));
  return A;
}

double true_largest(const MatrixXd& A, const VectorXd& m) {
  const VectorXd s = m.cwiseSqrt().cwiseInverse();
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(s.asDiagonal() * A * s.asDiagonal()).eigenvalues().maxCoeff();
}

}  // namespace

TEST_CASE("no bound lies below the eigenvalue: 1000 random matrices") {
  for (unsigned seed = 0; seed < 1000; ++seed) {
    INFO("seed " << seed);
    std::mt19937 random(seed);
    const int d = static_cast<int>(seed % 3) + 1;
    const Eigen::Index n = d * static_cast<Eigen::Index>(2 + random() % 10);
    const MatrixXd A = random_matrix(random, n, 0.1 + 0.9 * static_cast<double>(random() % 100) / 100);
    VectorXd m(n);
    std::uniform_real_distribution<double> exponent(-2, 2);
    for (Eigen::Index i = 0; i < n; ++i) m[i] = i % d == 0 ? std::pow(10, exponent(random)) : m[i - 1];
    const MatrixXd S = A + A.transpose();
    // The eigenvalues themselves carry rounding.
    const double rounding = 1e-12 * S.cwiseAbs().sum() / m.minCoeff();
    CHECK(largest_eigenvalue_bound(SparseRows(S.sparseView()), m, d).value >= true_largest(S, m) - rounding);
    CHECK(largest_eigenvalue_bound(SparseRows((-S).sparseView()), m, d).value >= true_largest(-S, m) - rounding);
    if (d == 2)
      CHECK(largest_eigenvalue_bound_by_blocks<2>(SparseRows(S.sparseView()), m).value >=
            true_largest(S, m) - rounding);
    if (d == 3)
      CHECK(largest_eigenvalue_bound_by_blocks<3>(SparseRows(S.sparseView()), m).value >=
            true_largest(S, m) - rounding);
    double radius = 0;
    for (const auto lambda : eigenvalues_of(A)) radius = std::max(radius, std::abs(lambda));
    CHECK(spectral_radius_bound(SparseRows(A.sparseView()), d).value >= radius * (1 - 1e-8));
  }
}
