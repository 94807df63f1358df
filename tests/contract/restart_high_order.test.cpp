// Controlled runs of high order, restarted anywhere: order, step, matrices and dense output go on to the bit. Other
// problems: the stress tier.
#include <phistep/phistep.hpp>

#include <vector>

#include "contract/restart_run.hpp"
#include "problems/forced.hpp"
#include "support/catch.hpp"
#if PHISTEP_STRESS
#include "problems/hires.hpp"
#endif

using namespace phistep;
using restart_run::check;
using restart_run::steps;

#if PHISTEP_FULL

namespace {

const auto spring = [] { return problems::HardeningSpring::start(); };
/// Looks inside of steps.
const auto samples = [](std::vector<double>& log) {
  return std::tuple{sampled(0.7, [&log](double t, const auto& y) {
    log.push_back(t);
    log.push_back(y.r[0]);
  })};
};
constexpr double rtol = 1e-5;
const tolerance control{.rtol = rtol, .atol = 1e-4 * rtol};

}  // namespace

TEST_CASE("Rosenbrock") { check(spring, steps(problems::HardeningSpring{}, rodas4), 5, control, samples); }
TEST_CASE("Runge-Kutta pairs") { check(spring, steps(problems::HardeningSpring{}, tsit5), 20, control, samples); }
TEST_CASE("Nystrom pairs") { check(spring, steps(problems::HardeningSpring{}, rkn86), 20, control, samples); }
TEST_CASE("Radau") { check(spring, steps(problems::HardeningSpring{}, radau), 5, control, samples); }

#elif PHISTEP_STRESS
// Controlled runs of high order, restarted anywhere: all.

namespace {

const auto hires = [] { return problems::Hires::start(); };
const auto spring = [] { return problems::HardeningSpring::start(); };
/// Looks inside of steps.
const auto samples = [](std::vector<double>& log) {
  return std::tuple{sampled(0.7, [&log](double t, const auto& y) {
    log.push_back(t);
    if constexpr (requires { y[0]; }) log.push_back(y[0]);
    else log.push_back(y.r[0]);
  })};
};
constexpr double rtol = 1e-5;
const tolerance control{.rtol = rtol, .atol = 1e-4 * rtol};

}  // namespace

TEST_CASE("Rosenbrock") {
  CHECK(check(hires, steps(problems::Hires{}, rodas5p), 50, control, samples) > 10);
  check(spring, steps(problems::HardeningSpring{}, rodas4), 5, control, samples);
  const Eigen::Matrix3d K{{-3.0, 1.0, 0.0}, {1.0, -2.0, 0.5}, {0.0, 0.5, -1.0}};
  check([] { return Eigen::Vector3d(1, 2, 3); }, steps(linear(K), rodas4), 5, control, samples);  // keeps its Jacobian
}
TEST_CASE("Runge-Kutta pairs") { check(spring, steps(problems::HardeningSpring{}, dop853), 20, control, samples); }
TEST_CASE("Nystrom pairs") { check(spring, steps(problems::HardeningSpring{}, rkn86), 20, control, samples); }
TEST_CASE("Radau") { CHECK(check(hires, steps(problems::Hires{}, radau), 50, control, samples) > 10); }

#endif
