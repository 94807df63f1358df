// One problem of each class of DETEST, two of them on states of fixed size; all of them: the stress tier.
#include <phistep/phistep.hpp>

#include <string>
#include <vector>

#include "problems/detest.hpp"
#include "problems/smooth.hpp"
#include "problems/ten.hpp"
#include "support/catch.hpp"

namespace {

/// f(name, scheme) for each scheme of any y' = f(y, t). One more is one line more.
[[maybe_unused]] void for_each_explicit(auto&& f) {
  f("tsit5", phistep::tsit5);
  f("dop853", phistep::dop853);
}
/// … and for each of conservative motions.
[[maybe_unused]] void for_each_nystrom(auto&& f) {
  f("RKN 8(6)", phistep::rkn86);
  f("RKN 12(10)", phistep::rkn1210);
}

/// A problem of any size as one type, so that a scheme's stepper is compiled once.
struct SmoothProblem {
  std::string name;
  Eigen::VectorXd start, exact;
  double end;
  void (*rate)(const double& t, const double* y, double* out);
  void (*acceleration)(const double* r, double* a) = nullptr;  ///< where it is a conservative motion

  /// f(y, t) and f(r)
  Eigen::VectorXd operator()(const Eigen::VectorXd& y, double t) const {
    Eigen::VectorXd out(y.size());
    rate(t, y.data(), out.data());
    return out;
  }
  [[nodiscard]] auto force() const {
    return [a = acceleration](const Eigen::VectorXd& r) -> Eigen::VectorXd {
      Eigen::VectorXd out(r.size());
      a(r.data(), out.data());
      return out;
    };
  }
};

template <class Array>
[[nodiscard]] Eigen::VectorXd vector_of(const Array& x) {
  return Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size()));
}
template <class P>
[[nodiscard]] SmoothProblem smooth_problem(P) {
  SmoothProblem problem{P::name, vector_of(P::start()), vector_of(P::exact()), P::end, &P::template rate<double>};
  if constexpr (requires(double* x) { P::acceleration(x, x); })
    problem.acceleration = &P::template acceleration<double>;
  return problem;
}
[[maybe_unused]] [[nodiscard]] std::vector<SmoothProblem> smooth_problems() {
  std::vector<SmoothProblem> all;
  const auto add = [&](auto problem) { all.push_back(smooth_problem(problem)); };
  problems::for_each_of_detest(add);
  problems::for_each_smooth(add);
  return all;
}

/// By how much a problem magnifies an error.
[[nodiscard]] inline double conditioning_of(const SmoothProblem& problem) {
  return problems::conditioning([&](double t, const problems::Vector& y) { return problem(y, t); }, problem.start,
                                problem.end, 1.0);
}

/// A run is a success, and its error at the end at most a hundred times what the problem makes of the tolerance:
/// beyond that it would be a wrong answer called a success.
[[maybe_unused]] void check_end(const SmoothProblem& problem, const std::string& scheme, double rtol, double kappa,
                                const phistep::RunReport& report, const Eigen::VectorXd& y) {
  const double error = problems::relative_error(y, problem.exact, 1.0);
  CAPTURE(problem.name, scheme, rtol, kappa, error, report.message());
  REQUIRE(report);
  CHECK(error <= 100 * kappa * rtol);
}

}  // namespace

#if PHISTEP_FULL

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

#elif PHISTEP_STRESS
// Every problem of DETEST, and the other smooth ones, at coarse, medium and tight tolerances: each run is a success,
// and its answer right.

TEST_CASE("smooth problems are solved to their tolerance") {
  for (const SmoothProblem& problem : smooth_problems()) {
    const double kappa = conditioning_of(problem);
    for (const double rtol : {1e-3, 1e-6, 1e-9}) {
      const phistep::tolerance control{.rtol = rtol, .atol = rtol};
      for_each_explicit([&](const char* name, auto scheme) {
        Eigen::VectorXd y = problem.start;
        phistep::PhiStepper stepper{y, problem, scheme};
        const auto report = phistep::integrate(stepper, y, {0, problem.end}, control);
        check_end(problem, name, rtol, kappa, report, y);
      });
      if (problem.acceleration == nullptr) continue;
      const auto half = problem.start.size() / 2;
      for_each_nystrom([&](const char* name, auto scheme) {
        phistep::Motion<Eigen::VectorXd> y{problem.start.head(half), problem.start.tail(half)};
        phistep::PhiStepper stepper{y, problem.force(), scheme};
        const auto report = phistep::integrate(stepper, y, {0, problem.end}, control);
        check_end(problem, name, rtol, kappa, report, problems::stacked(y));
      });
    }
  }
}

#endif
