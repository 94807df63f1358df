// What the library's own choice costs on fields of some hundred unknowns, in force calls.
#include <phistep/automatic.hpp>
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdint>
#include <string>

#include "support/catch.hpp"

namespace {

/// A rod of n points at 1 whose ends are held, by differences; nothing is told of the pattern.
struct Rod {
  Eigen::VectorXd operator()(const Eigen::VectorXd& y) const {
    const Eigen::Index n = y.size();
    const double c = static_cast<double>((n + 1) * (n + 1));
    Eigen::VectorXd q = Eigen::VectorXd::Zero(n);
    for (Eigen::Index i = 1; i < n - 1; ++i) q[i] = c * (y[i - 1] - 2 * y[i] + y[i + 1]);
    return q;
  }
};
/// Whether the report hints at a pattern, or one was found: then some calls for it, and few for the steps.
bool hinted_or_cheap(Eigen::Index n) {
  Eigen::VectorXd y = Eigen::VectorXd::Ones(n);
  y[0] = 0;
  auto report = phistep::integrate(y, Rod{}, {0, 0.01}, phistep::tolerance{.rtol = 1e-3, .atol = 1e-5});
  return report &&
         (report.schemes.message().find("sparsity(") != std::string::npos || report.statistics.force_calls <= 4 * n);
}

/// Force calls of 100 steps of Verlet with a drag that isn't linear, n particles in space.
std::int64_t verlet_calls(Eigen::Index n, auto... solver) {
  using Points = Eigen::Matrix3Xd;
  Points r(3, n), v(3, n);
  for (Eigen::Index i = 0; i < r.size(); ++i)
    r.data()[i] = std::sin(static_cast<double>(i)), v.data()[i] = std::cos(3.0 * static_cast<double>(i));
  phistep::Motion y{r, v};
  auto force = [](const Points& x, const Points& u) -> Points { return -x - 0.1 * u.cwiseAbs().cwiseProduct(u); };
  phistep::PhiStepper stepper{y, force, phistep::velocity_verlet, solver...};
  auto report = phistep::integrate(stepper, y, {0, 1}, phistep::fixed(0.01));
  REQUIRE(report);
  return report.statistics.force_calls;
}

}  // namespace

TEST_CASE("a rod of 1001 points without a stepper: the report hints at a pattern") { CHECK(hinted_or_cheap(1001)); }
TEST_CASE("a rod of 400 to 1000 points without a stepper: a hint at a pattern, or few calls") {
  bool good = true;
  for (const Eigen::Index n : {400, 900, 1000}) good = good && hinted_or_cheap(n);
  CHECK(good);
}

TEST_CASE("Verlet with drag, 1020 unknowns: not more calls than fixed-point iterations need") {
  CHECK(2 * verlet_calls(340) <= 3 * verlet_calls(340, phistep::fixed_point()));
}
TEST_CASE("Verlet with drag, 300 and 990 unknowns: not more calls than fixed-point iterations need") {
  bool good = true;
  for (const Eigen::Index n : {100, 330})
    good = good && 2 * verlet_calls(n) <= 3 * verlet_calls(n, phistep::fixed_point());
  CHECK(good);
}
