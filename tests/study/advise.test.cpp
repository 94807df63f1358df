// What is advised, and how stiffness is found out.
#include "study/advise_cases.hpp"
#include "support/shared_force.hpp"

using namespace advise_cases;

namespace {

auto advise_on(const shared_force::OfState<Eigen::Vector2d>& force) {
  return advise(Eigen::Vector2d(1, 1), force, {0.0, 1.0});
}

}  // namespace

TEST_CASE("the rate is found where it is: in a decay, an oscillation, after a transient, in any units") {
  check_rates(velocity_verlet);
}

TEST_CASE("real problems get what wins on their diagrams") {
  const auto decays = [](double rate) {
    return advise_on([rate](const Eigen::Vector2d& y) -> Eigen::Vector2d { return {-y[0], -rate * (y[1] - y[0])}; });
  };
  const auto stiff = decays(1e6), slow = decays(2);
  CHECK(stiff.stiffness.known);
  CHECK(stiff.stiffness.is_stiff);
  CHECK(stiff.stiffness.rate == Approx(1e6).epsilon(0.1));
  CHECK(stiff.stiffness.steps < 30);
  CHECK((stiff.scheme == "rodas4p2" || stiff.scheme == "radau" || stiff.scheme == "rodas5p"));
  CHECK(slow.stiffness.known);
  CHECK_FALSE(slow.stiffness.is_stiff);
  CHECK(slow.scheme == "dop853");
}

TEST_CASE("the rules, one by one") {
  // A problem of the diagrams each, with the digits at which its best scheme changes.
  CHECK(choice(scene(3, 1e-3), true) == "rodas4p2");
  CHECK(choice(scene(3, 1e-4), true) == "rodas5p");
  CHECK(choice(scene(3, 1e-5), true) == "radau");
  AdvisedProblem pollution = scene(20, 1e-2);
  pollution.has_sparse_lu = true;
  CHECK(choice(pollution, true) == "rodas4p2");
  pollution.rtol = 1e-9;
  CHECK(choice(pollution, true) == "rodas5p");
  pollution.rtol = 1e-11;
  CHECK(choice(pollution, true) == "radau");
  CHECK(choice(scene(20, 1e-6), true) == "rodas5p");
  CHECK(choice(scene(20, 1e-7), true) == "radau");
  AdvisedProblem modulator = scene(15, 1e-2);
  modulator.is_driven = true;
  CHECK(choice(modulator, true) == "rodas4p2");
  modulator.rtol = 1e-3;
  CHECK(choice(modulator, true) == "radau");
  AdvisedProblem beam = scene(80, 1e-2);
  beam.has_jacobian = false;
  CHECK(choice(beam, true) == "rodas4p2");
  beam.rtol = 1e-5;
  CHECK(choice(beam, true) == "rodas5p");
  beam.rtol = 1e-6;
  CHECK(choice(beam, true) == "radau");
  CHECK(choice(scene(1000, 1e-2, Structure::banded), true) == "rodas4p2");
  CHECK(choice(scene(1000, 1e-5, Structure::banded), true) == "rodas5p");
  CHECK(choice(scene(1000, 1e-6, Structure::banded), true) == "radau");
  CHECK(choice(scene(96, 1e-2, Structure::sparse), true) == "radau");
  CHECK(choice(scene(1000, 1e-3, Structure::sparse), true) == "rodas5p");
  CHECK(choice(scene(1000, 1e-4, Structure::sparse), true) == "radau");
  AdvisedProblem heat = scene(4096, 1e-7, Structure::sparse);
  heat.is_affine = true;
  CHECK(choice(heat, true) == "rodas5p");
  heat.rtol = 1e-8;
  CHECK(choice(heat, true) == "radau");
  CHECK(choice(scene(1000, 1e-3, Structure::network), true) == "tr_bdf2");
  AdvisedProblem blind = scene(5000, 1e-6);
  blind.has_jacobian = false;
  CHECK(choice(blind, true) == "tr_bdf2");
  CHECK_FALSE(decide(blind, stiffness(true)).warnings.empty());

  AdvisedProblem motion = scene(6, 1e-6);
  motion.is_motion = true;
  CHECK(choice(motion, false) == "rkn86");
  CHECK(choice(motion, true) == "radau");
  motion.rtol = 1e-10;
  CHECK(choice(motion, false) == "rkn1210");
  motion.uses_velocity = true;
  CHECK(choice(motion, false) == "dop853");
  motion.rtol = 5e-4;
  CHECK(choice(motion, false) == "dop853");
  motion.rtol = 1e-3;
  CHECK(choice(motion, false) == "tsit5");
  motion.uses_velocity = false, motion.rtol = 1e-3, motion.unknowns = 30000;
  CHECK(choice(motion, false) == "velocity_verlet");
  motion.has_history = true;
  CHECK(choice(motion, false) == "velocity_verlet");
  CHECK(decide(motion, stiffness(false)).control == "phistep::fixed(dt)");

  AdvisedProblem much = scene(3, 1e-16);
  CHECK_THAT(decide(much, stiffness(true)).message(), contains("below what a number of 15 digits can hold"));
}

TEST_CASE("a force that throws or is not finite is no reason to throw") {
  const auto thrown = advise_on([](const Eigen::Vector2d&) -> Eigen::Vector2d { throw std::runtime_error("no"); });
  CHECK_THAT(thrown.message(), contains("could not be found out"));
  const auto advice = advise_on([](const Eigen::Vector2d&) -> Eigen::Vector2d { return {NAN, NAN}; });
  CHECK_FALSE(advice.stiffness.known);
  std::ostringstream text;
  text << advice;
  CHECK(text.str() == advice.message());
}
