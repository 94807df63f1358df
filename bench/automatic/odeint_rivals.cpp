/// @file
/// Odeint of Boost 1.74, which is no C++20: this file does not see phistep.
#define BOOST_UBLAS_NDEBUG 1
#include <boost/numeric/odeint.hpp>
#include <boost/numeric/ublas/matrix.hpp>
#include <boost/numeric/ublas/vector.hpp>

#include <algorithm>
#include <exception>
#include <utility>
#include <vector>

#include "rivals.hpp"

namespace automatic {
namespace {

namespace odeint = boost::numeric::odeint;
struct TooMany : std::exception {};

template <class State>
struct Rate {
  const BareProblem& problem;
  long& calls;
  void operator()(const State& y, State& out, double t) const {
    if (++calls > most_calls) throw TooMany{};
    problem.rate(problem.self.get(), t, &y[0], &out[0]);
  }
};

template <class State, class Stepper, class System>
Eigen::VectorXd run(const BareProblem& problem, const Stepper& stepper, const System& system) {
  State y(static_cast<std::size_t>(problem.start.size()));
  std::copy(problem.start.data(), problem.start.data() + problem.start.size(), y.begin());
  try {
    odeint::integrate_adaptive(stepper, system, y, 0.0, problem.end, 1e-6 * std::min(problem.end, 1000.0));
  } catch (const std::exception&) {  // too many calls, a step that can't be made, a singular matrix
    return {};
  }
  return Eigen::Map<const Eigen::VectorXd>(&y[0], problem.start.size());
}

}  // namespace

Rivals odeint_rivals(const BareProblem& problem) {
  using Vector = boost::numeric::ublas::vector<double>;
  using Matrix = boost::numeric::ublas::matrix<double>;
  using Plain = std::vector<double>;
  return {{"Odeint rosenbrock4",
           [problem](double rtol) {
             long calls = 0;
             const auto jacobian = [&](const Vector& y, Matrix& J, const double& t, Vector& by_time) {
               jacobian_by_differences(problem, t, &y[0], &J.data()[0], &by_time[0]);
             };
             return run<Vector>(problem, odeint::make_controlled(problem.a * rtol, rtol, odeint::rosenbrock4<double>()),
                                std::make_pair(Rate<Vector>{problem, calls}, jacobian));
           }},
          {"Odeint dopri5",
           [problem](double rtol) {
             long calls = 0;
             return run<Plain>(problem,
                               odeint::make_controlled(problem.a * rtol, rtol, odeint::runge_kutta_dopri5<Plain>()),
                               Rate<Plain>{problem, calls});
           }},
          {"Odeint fehlberg78", [problem](double rtol) {
             long calls = 0;
             return run<Plain>(problem,
                               odeint::make_controlled(problem.a * rtol, rtol, odeint::runge_kutta_fehlberg78<Plain>()),
                               Rate<Plain>{problem, calls});
           }}};
}

}  // namespace automatic
