// A state that is zero has no size: runs with the automatic atol leave it all the same, and end where they should.
#include <phistep/phistep.hpp>

#include <cmath>
#include <functional>

#include "support/catch.hpp"
#include "support/shared_force.hpp"

using namespace phistep;

namespace {

using One = Eigen::Matrix<double, 1, 1>;
using Force = shared_force::OfStateAndTime<One>;

/// From y(0) = 0 to t1, where the solution is known.
struct Cold {
  const char* name;
  Force force;
  double t1, exact;
};
const Cold growing{"y' = t^3 - y", [](const One& y, double t) -> One { return One(t * t * t - y[0]); }, 2,
                   8 - 12 + 12 - 6 + 6 * std::exp(-2.0)};
const Cold switched{"on at t = 5", [](const One& y, double t) -> One { return One((t >= 5 ? 1 : 0) - y[0]); }, 10,
                    1 - std::exp(-5.0)};

void check(const char* name, auto scheme, std::initializer_list<double> tolerances) {
  for (const Cold& problem : {growing, switched})
    for (const double rtol : tolerances) {
      One y = One::Zero();
      PhiStepper stepper{y, problem.force, scheme};
      const RunReport report = integrate(stepper, y, {0, problem.t1}, tolerance{.rtol = rtol});
      CAPTURE(name, problem.name, rtol, report.message(), y[0]);
      CHECK(report);
      CHECK(std::abs(y[0] - problem.exact) <= 10 * rtol * problem.exact);
    }
}

}  // namespace

TEST_CASE("from zero: a force that grows as a power of t, and one that is switched on") {
  check("trapezoidal", trapezoidal, {1e-3, 1e-5});
  check("tr_bdf2", tr_bdf2, {1e-3, 1e-5});
  check("rodas5p", rodas5p, {1e-3, 1e-6, 1e-9});
  check("radau", radau, {1e-3, 1e-6, 1e-9});
  check("forward_euler", forward_euler, {1e-2});
}
