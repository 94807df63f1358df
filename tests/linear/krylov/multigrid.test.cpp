// A header-only algebraic multigrid, AMGCL, as a preconditioner, where its headers are found: it fits the hook.
#include <phistep/integrate.hpp>
#include <phistep/krylov.hpp>
#include <phistep/sparse.hpp>

#include "problems/reaction_diffusion.hpp"
#include "support/catch.hpp"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#include <boost/range.hpp>

#include <amgcl/amg.hpp>
#include <amgcl/backend/builtin.hpp>
#include <amgcl/coarsening/smoothed_aggregation.hpp>
#include <amgcl/relaxation/spai0.hpp>
#pragma GCC diagnostic pop

#include <algorithm>
#include <memory>
#include <vector>

using namespace phistep;
using namespace problems;
using Vec = Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;

namespace {

/// W's hierarchy, made anew where γ has left a factor of four.
struct Multigrid {
  using Amg =
      amgcl::amg<amgcl::backend::builtin<double>, amgcl::coarsening::smoothed_aggregation, amgcl::relaxation::spai0>;
  std::shared_ptr<Amg> amg{};
  double made_for = 0;
  static inline int hierarchies = 0, calls = 0;

  void factorize(const Sparse& W, double gamma_force, double /*gamma_drift*/) {
    ++calls;
    if (amg && gamma_force < 4 * made_for && made_for < 4 * gamma_force) return;
    ++hierarchies, made_for = gamma_force;
    // Rows of Wᵀ, which is W.
    const std::vector<int> start(W.outerIndexPtr(), W.outerIndexPtr() + W.cols() + 1);
    const std::vector<int> column(W.innerIndexPtr(), W.innerIndexPtr() + W.nonZeros());
    const std::vector<double> value(W.valuePtr(), W.valuePtr() + W.nonZeros());
    amg = std::make_shared<Amg>(amgcl::backend::crs<double>(start.size() - 1, start.size() - 1, start, column, value));
  }
  void solve_in_place(Vec& x) const {
    const std::vector<double> b(x.data(), x.data() + x.size());
    std::vector<double> z(b.size(), 0.0);
    amg->apply(b, z);
    std::copy(z.begin(), z.end(), x.data());
  }
  [[nodiscard]] Vec solve(Vec b) const {
    solve_in_place(b);
    return b;
  }
};
struct Ended {
  Vec y;
  Statistics counts;
};
Ended run(Eigen::Index m, auto solver) {
  const ReactionDiffusion field{.m = m};
  Vec y = field.start();
  PhiStepper stepper{y, ReactionDiffusionTerm{field}, tr_bdf2, solver};
  const auto report = integrate(stepper, y, {0.0, 0.05}, tolerance{.rtol = 1e-4, .atol = 1e-4});
  REQUIRE(report);
  return {y, report.statistics};
}

}  // namespace

TEST_CASE("an algebraic multigrid is told of gamma, keeps its hierarchy, and gives LU's answers") {
  const Ended direct = run(24, newton()), amg = run(24, newton<PreconditionedCg<Multigrid>>());
  CHECK((direct.y - amg.y).cwiseAbs().maxCoeff() <= 1e-5);
  CHECK(Multigrid::calls == amg.counts.factorizations);
  CHECK(3 * Multigrid::hierarchies <= Multigrid::calls);
}

TEST_CASE("iterations a solve grow half as much with the grid as those of the diagonal") {
  const auto growth = [](auto solver) {
    const auto each = [](const Ended& run) {
      return static_cast<double>(run.counts.linear_iterations) / static_cast<double>(run.counts.solves);
    };
    return each(run(96, solver)) / each(run(24, solver)) - 1;
  };
  CHECK(growth(newton<PreconditionedCg<Multigrid>>()) <= 0.5 * growth(newton<PreconditionedCg<>>()));
}
