// Controlled runs of a spring net, restarted anywhere, with ledger and recorder. In short: restart_run.test.cpp.
#include <phistep/phistep.hpp>
#include <phistep/sparse.hpp>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "contract/restart_run.hpp"
#include "contract/restart_run_cases.hpp"
#include "contract/states.hpp"
#include "problems/hires.hpp"
#include "problems/spring_net.hpp"
#include "problems/van_der_pol.hpp"
#include "support/catch.hpp"

using namespace phistep;
using problems::SpringNet;
using restart_run::check;
using namespace restart_run;

TEST_CASE("factors, predictors and rates that live on from step to step") {
  const auto net = [] { return SpringNet::start(); };
  const auto masses = mass(SpringNet::masses());
  for (const double rtol : {1e-2, 1e-4}) {
    check(net, steps(SpringNet::damped(), tr_bdf2, masses), 0.5, tolerance{.rtol = rtol});
    check(net, steps(SpringNet::elastic(), trapezoidal, masses), 0.5, tolerance{.rtol = rtol, .norm = Norm::particle});
  }
  check(positive, steps(linear(Eigen::MatrixXd(-3 * Eigen::MatrixXd::Identity(3, 3))), trapezoidal), 2, tolerance{});
}

TEST_CASE("a recorder and a ledger go on with what they have") {
  struct Program {
    Motion<Vec> y = SpringNet::start();
    decltype(steps(SpringNet::damped(), trapezoidal, mass(SpringNet::masses()))(y)) stepper =
        steps(SpringNet::damped(), trapezoidal, mass(SpringNet::masses()))(y);
    EnergyLedger<decltype(stepper)> ledger{stepper};
    Recorder<Motion<Vec>> recorder;
    Run<decltype(stepper), Motion<Vec>, tolerance, decltype(ledger)&, decltype(recorder)&> run{
        stepper, y, {0, 0.5}, tolerance{.rtol = 1e-3}, ledger, recorder};
  };
  Program unbroken;
  for (int k = 0; k < 9; ++k) REQUIRE(unbroken.run.advance());
  const std::string half_way = restart::saved(unbroken.run);
  REQUIRE(unbroken.run.finish());
  Program again;
  std::istringstream in(half_way);
  load_checkpoint(in, again.run);
  CHECK(restart::bytes(again.run) == half_way);
  REQUIRE(again.run.finish());
  CHECK(restart::bytes(again.ledger, again.recorder) == restart::bytes(unbroken.ledger, unbroken.recorder));
  CHECK(again.recorder.times() == unbroken.recorder.times());
  CHECK(again.recorder.position() == unbroken.recorder.position());
  CHECK(again.ledger.force_calls() == unbroken.ledger.force_calls());
  CHECK(again.ledger.closure() == unbroken.ledger.closure());
}
