#pragma once

// DETEST and the other smooth problems under a tolerance, with the schemes that are not stiff: what both halves of
// acceptance/detest need.

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
