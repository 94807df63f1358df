// The schemes for stiff problems: of fixed size, of a band, of a sparse matrix.
#include <Eigen/SparseCore>
#include <phistep/phistep.hpp>
#include <phistep/sparse.hpp>

#include <algorithm>
#include <string>
#include <vector>

#include "pinned/pinned.hpp"
#include "problems/robertson.hpp"

namespace {

using namespace phistep;
using problems::Robertson;

void robertson(const char* name, const auto& scheme) {
  pinned::run(std::string("Robertson, ") + name, [&](pinned::Hash& hash) {
    auto y = Robertson::start();
    PhiStepper stepper{y, Robertson{}, scheme};
    if constexpr (decltype(stepper)::facts.traces) {
      pinned::good(integrate(stepper, y, {0, Robertson::end}, tolerance{.rtol = 1e-6, .atol = 1e-10}));
    } else {
      pinned::good(integrate(stepper, y, {0, 1}, fixed(0.0078125)));
    }
    hash.add(y);
  });
}

/// u_t = u_xx + u²(1 − u) on n points between two zeros.
auto front(Index n) {
  return [n](const Eigen::VectorXd& u) -> Eigen::VectorXd {
    const double scale = 0.0625 * static_cast<double>((n + 1) * (n + 1));
    Eigen::VectorXd rate(n);
    for (Index i = 0; i < n; ++i) {
      const double left = i > 0 ? u[i - 1] : 0, right = i + 1 < n ? u[i + 1] : 0;
      rate[i] = scale * (left - 2 * u[i] + right) + u[i] * u[i] * (1 - u[i]);
    }
    return rate;
  };
}
Eigen::VectorXd bump(Index n) {
  Eigen::VectorXd u(n);
  for (Index i = 0; i < n; ++i) {
    const double x = static_cast<double>(i + 1) / static_cast<double>(n + 1);
    u[i] = 4 * x * (1 - x);
  }
  return u;
}
Eigen::SparseMatrix<double> neighbours(Index n) {
  Eigen::SparseMatrix<double> pattern(n, n);
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < static_cast<int>(n); ++i)
    for (int j = std::max(0, i - 1); j <= std::min(static_cast<int>(n) - 1, i + 1); ++j) entries.emplace_back(i, j, 1);
  pattern.setFromTriplets(entries.begin(), entries.end());
  return pattern;
}
void field(const char* name, const auto& force, const auto& scheme, Index n) {
  pinned::run(name, [&](pinned::Hash& hash) {
    Eigen::VectorXd u = bump(n);
    PhiStepper stepper{u, force, scheme};
    pinned::good(integrate(stepper, u, {0, 4}, tolerance{.rtol = 1e-5, .atol = 1e-7}));
    hash.add(u);
  });
}

const bool added = pinned::added([] {
  robertson("tr_bdf2", tr_bdf2);
  robertson("rannacher", rannacher);
  robertson("rodas4", rodas4);
  robertson("rodas4p2", rodas4p2);
  robertson("rodas5p", rodas5p);
  robertson("radau", radau);
  field("front of 200, banded, tr_bdf2", banded(front(200), 1, 1), tr_bdf2, 200);
  field("front of 200, sparse, rodas4p2", sparsity(front(200), neighbours(200)), rodas4p2, 200);
});

}  // namespace
