// Differential-algebraic equations of index 1: the forms of M, references and Jacobians by differences that index_1.test leaves out.
#include "dae/index_1_cases.hpp"

using namespace index_1_cases;

TEST_CASE("orders of convergence, differential and algebraic components apart") {
  // One template steps for every Rosenbrock tableau, one for every φ: rodas4 and backward Euler stand for them.
  check_orders(rodas4, 4, 64, sparse);
  check_orders(radau, 5, 8, dense, sparse);
  check_orders(tr_bdf2, 2, 40, dense, sparse);
  check_orders(backward_euler, 1, 80, dense, sparse);
}

TEST_CASE("Robertson's reactions, the transistor amplifier and a pendulum come to their references") {
  using namespace problems;
  const AutonomousDaeForce<RobertsonDae> robertson;
  CHECK(error(RobertsonDae{}, robertson, rodas5p, 1e-10, 1e-6) <= 1e-9);
  CHECK(error(RobertsonDae{}, robertson, radau, 1e-7, 1e-6) <= 1e-7);
  CHECK(error(RobertsonDae{}, robertson, tr_bdf2, 1e-4, 1e-6) <= 1e-4);
  const AutonomousDaeForce<CartesianPendulum> pendulum;
  CHECK(error(CartesianPendulum{}, pendulum, rodas4, 1e-6, 1) <= 1e-5);
  CHECK(error(CartesianPendulum{}, pendulum, rodas5p, 1e-10, 1) <= 1e-9);
  CHECK(error(CartesianPendulum{}, pendulum, radau, 1e-8, 1) <= 1e-6);
  CHECK(error(CartesianPendulum{}, pendulum, tr_bdf2, 1e-4, 1) <= 1e-3);
  const DaeForce<TransistorAmplifier> amplifier;
  CHECK(error(TransistorAmplifier{}, amplifier, rodas4, 1e-4, 1) <= 1e-4);
  CHECK(error(TransistorAmplifier{}, amplifier, rodas5p, 1e-4, 1) <= 1e-4);
  CHECK(error(TransistorAmplifier{}, amplifier, radau, 1e-6, 1) <= 1e-5);
  CHECK(error(TransistorAmplifier{}, amplifier, tr_bdf2, 1e-3, 1) <= 1e-3);
}

TEST_CASE("the error goes with the tolerance, algebraic components included") {
  check_tolerances(known, radau, 1e-9);
  check_tolerances(known, tr_bdf2, 1e-6);
  check_tolerances(known, backward_euler, 1e-4);
  check_tolerances(WithJacobian{}, rodas5p, 1e-9);
  check_tolerances(WithJacobian{}, phi_stage(1.0), 1e-4);
}

TEST_CASE("samples and events of algebraic components") {
  check_samples(rodas4, fixed(0.02), 1e-4);
  check_samples(rodas5p, tolerance{.rtol = 1e-6, .atol = 1e-6}, 1e-5);
  check_samples(rodas5p, fixed(0.02), 1e-4);
  check_samples(tr_bdf2, tolerance{.rtol = 1e-4, .atol = 1e-4}, 1e-3);
}

TEST_CASE("a run goes on from a checkpoint bit for bit") {
  check_restart(rodas4, fixed(0.1));
  check_restart(tr_bdf2, tolerance{.rtol = 1e-4});
  check_restart(backward_euler, fixed(0.1));
}
