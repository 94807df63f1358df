// One problem of each class of DETEST, two of them on states of fixed size; all of them: detest.stress.cpp.

#include "acceptance/detest_cases.hpp"

namespace {

void check_schemes(const SmoothProblem& problem, const auto& start, const auto& f, double kappa) {
  for (const double rtol : {1e-3, 1e-6, 1e-9})
    for_each_explicit([&](const char* name, auto scheme) {
      auto y = start;
      phistep::PhiStepper stepper{y, f, scheme};
      const auto report =
          phistep::integrate(stepper, y, {0, problem.end}, phistep::tolerance{.rtol = rtol, .atol = rtol});
      check_end(problem, name, rtol, kappa, report, y);
    });
}
/// κ: as conditioning_of() measures it.
template <class P>
void check_fixed(P, double kappa) {
  using State = Eigen::Matrix<double, static_cast<int>(P::n), 1>;
  const SmoothProblem problem = smooth_problem(P{});
  const auto f = [](const State& y, double t) -> State {
    State out;
    P::rate(t, y.data(), out.data());
    return out;
  };
  check_schemes(problem, State{problem.start}, f, kappa);
}
void check(const SmoothProblem& problem, double kappa) { check_schemes(problem, problem.start, problem, kappa); }

}  // namespace

TEST_CASE("smooth problems of a few unknowns are solved to their tolerance") {
  check(smooth_problem(problems::detest::A4{}), 1);
  check_fixed(problems::detest::B5{}, 41);
  check(smooth_problem(problems::detest::C1{}), 5.5);
  check(smooth_problem(problems::detest::D3{}), 463);
  check_fixed(problems::detest::E2{}, 8.6);
}

TEST_CASE("the answers of smooth problems with a formula are that formula's") {
  using namespace problems::detest;
  CHECK(A1::exact()[0] == Approx(std::exp(-20.0)).epsilon(1e-14));
  CHECK(A2::exact()[0] == Approx(1 / std::sqrt(21.0)).epsilon(1e-14));
  CHECK(A3::exact()[0] == Approx(std::exp(std::sin(20.0))).epsilon(1e-14));
  CHECK(A4::exact()[0] == Approx(20 / (1 + 19 * std::exp(-5.0))).epsilon(1e-14));
}
