// Controlled runs of high order, restarted anywhere: order, step, matrices and dense output go on to the bit. Other
// problems: restart_high_order.stress.cpp.
#include <phistep/phistep.hpp>

#include <vector>

#include "contract/restart_run.hpp"
#include "problems/forced.hpp"
#include "support/catch.hpp"

using namespace phistep;
using restart_run::check;
using restart_run::steps;

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
