// Heat on a line, with a source and a sparse Jacobian, by rodas4 under a tolerance.
#include <phistep/sparse.hpp>

#include <iostream>

using Vec = Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;

struct Heat {
  Vec operator()(const Vec& T) const {
    const auto n = T.size();
    Vec rate(n);
    for (Eigen::Index i = 0; i < n; ++i)
      rate[i] = (i > 0 ? T[i - 1] : 0) - 2 * T[i] + (i + 1 < n ? T[i + 1] : 0) - T[i] * T[i] * T[i];
    return rate;
  }
  Sparse jacobian(const Vec& T) const {
    const auto n = T.size();
    Sparse J(n, n);
    J.reserve(Eigen::VectorXi::Constant(n, 3));
    for (Eigen::Index i = 0; i < n; ++i) {
      if (i > 0) J.insert(i, i - 1) = 1;
      J.insert(i, i) = -2 - 3 * T[i] * T[i];
      if (i + 1 < n) J.insert(i, i + 1) = 1;
    }
    return J;
  }
};

int main() {
  Vec T = Vec::LinSpaced(1000, 0, 1);
  phistep::PhiStepper stepper{T, Heat{}, phistep::rodas4};
  const auto report = phistep::integrate(stepper, T, {0.0, 10.0}, phistep::tolerance{.rtol = 1e-6, .atol = 1e-9});
  std::cout << report << '\n';
  return report ? 0 : 1;
}
