// Radau IIA under control of its error, on more problems; the quick half is radau_run.test.cpp.
#include <phistep/io/checkpoint.hpp>

#include "schemes/radau/radau_run_cases.hpp"

using namespace radau_run_cases;

TEST_CASE("the error goes as rtol, from 1e-2 to 1e-12") {
  using problems::Hires, problems::Oregonator, problems::Robertson, problems::VanDerPol;
  // κ by problems::conditioning: 1.4, 92, 6.8, 1.6.
  check_law("Robertson", Robertson{}, 1e-6, 1.4, radau,
            [](const auto& y) { return worst(y, Robertson::exact(), 1e-6); });
  check_law("HIRES", Hires{}, 1e-4, 92, radau, [](const auto& y) { return worst(y, Hires::exact(), 1e-4); });
  check_law("Oregonator", Oregonator{}, 1e-6, 6.8, radau,
            [](const auto& y) { return worst(y, Oregonator::exact(), 1e-6); });
  check_law("Van der Pol", VanDerPol{}, 1, 1.6, radau, [](const auto& y) {
    return std::max(worst(y.r, VanDerPol::exact().r, 1), worst(y.v, VanDerPol::exact().v, 1));
  });
}

TEST_CASE("a run taken up from a checkpoint goes on to the same bits") {
  struct Whole {
    problems::Hires::State y = problems::Hires::start();
    PhiStepper<problems::Hires::State, problems::Hires, Radau> stepper{y, problems::Hires{}, radau};
    Run<decltype(stepper), problems::Hires::State, tolerance> run{
        stepper, y, {0, problems::Hires::end}, tolerance{.rtol = 1e-8, .atol = 1e-12}};
  };
  Whole unbroken;
  std::vector<std::string> places;
  do {
    std::ostringstream out;
    save_checkpoint(out, unbroken.run);
    places.push_back(out.str());
  } while (unbroken.run.advance());
  REQUIRE(unbroken.run.report());
  for (std::size_t k = 0; k < places.size(); k += 3) {
    Whole again;
    std::istringstream in(places[k]);
    load_checkpoint(in, again.run);
    while (again.run.advance()) {  // a save begins the checks of the Jacobian anew, so it is part of the story
      std::ostringstream out;
      save_checkpoint(out, again.run);
    }
    CAPTURE(k);
    CHECK(again.y == unbroken.y);
    CHECK(again.stepper.statistics() == unbroken.stepper.statistics());
  }
}

TEST_CASE("differences in place of a Jacobian, float, and where double precision ends") {
  problems::Robertson problem;
  const auto no_jacobian = [&](const Eigen::Vector3d& y) -> Eigen::Vector3d { return problem(y); };
  Eigen::Vector3d y = problems::Robertson::start();
  PhiStepper stepper{y, no_jacobian, radau};
  REQUIRE(integrate(stepper, y, {0, 40}, tolerance{.rtol = 1e-9, .atol = 1e-15}));
  CHECK(worst(y, problems::Robertson::exact(), 1e-6) <= 1e-8);

  const auto in_float = [](const Eigen::Vector3f& x) -> Eigen::Vector3f {
    const float a = 0.04f * x[0], b = 1e4f * x[1] * x[2], c = 3e7f * x[1] * x[1];
    return {-a + b, a - b - c, c};
  };
  Eigen::Vector3f x{1, 0, 0};
  PhiStepper narrow{x, in_float, radau};
  REQUIRE(integrate(narrow, x, {0, 40}, tolerance{.rtol = 1e-4, .atol = 1e-9}));
  CHECK(worst(x.cast<double>(), problems::Robertson::exact(), 1e-5) <= 1e-3);

  Eigen::Vector3d z = problems::Robertson::start();
  PhiStepper beyond{z, problem, radau};
  CHECK(integrate(beyond, z, {0, 40}, tolerance{.rtol = 1e-16, .atol = 1e-22}).outcome == Outcome::invalid_tolerance);
}

TEST_CASE("a force that is nowhere finite ends the run, and the state is kept") {
  using V = Eigen::Matrix<double, 1, 1>;
  const auto wall = [](const V& y) { return V{y[0] > 0.5 ? std::sqrt(-1.0) : 1.0}; };
  V y{0};
  PhiStepper stepper{y, wall, radau};
  const RunReport report = integrate(stepper, y, {0, 1}, tolerance{.rtol = 1e-6, .atol = 1e-6});
  CHECK_FALSE(report);
  CHECK(y[0] <= 0.5);
  CHECK(y[0] >= 0.4);  // as far as there is a force
}
