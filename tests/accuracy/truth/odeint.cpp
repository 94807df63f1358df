#define BOOST_UBLAS_NDEBUG 1
#include "accuracy/truth/odeint.hpp"

#include <algorithm>
#include <boost/numeric/odeint.hpp>
#include <boost/numeric/ublas/matrix.hpp>
#include <boost/numeric/ublas/vector.hpp>
#include <cstddef>
#include <exception>
#include <utility>
#include <vector>

namespace truth {
namespace {

namespace odeint = boost::numeric::odeint;

/// Odeint never gives up by itself.
constexpr long most_calls = 12 * 20000;
struct TooMany {};

template <class State, class Stepper, class System>
Answer go(const Problem& problem, const Stepper& stepper, const System& system) {
  State y(static_cast<std::size_t>(problem.start.size()));
  std::copy(problem.start.data(), problem.start.data() + problem.start.size(), y.begin());
  try {
    odeint::integrate_adaptive(stepper, system, y, 0.0, problem.end, std::min(1e-6, 1e-6 * problem.end));
  } catch (const TooMany&) {
    return {};
  } catch (const std::exception&) {  // a singular matrix, a step that can't be made
    return {};
  }
  return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(&y[0], problem.start.size()));
}

}  // namespace

Answer odeint_rosenbrock4(const Problem& problem, double rtol) {
  using Vector = boost::numeric::ublas::vector<double>;
  using Matrix = boost::numeric::ublas::matrix<double>;
  const auto n = static_cast<std::size_t>(problem.start.size());
  long calls = 0;
  const auto rate = [&](const Vector& y, Vector& out, double t) {
    if (++calls > most_calls) throw TooMany{};
    problem.rate(t, &y[0], &out[0]);
  };
  std::vector<double> columns(n * n);
  const auto jacobian = [&](const Vector& y, Matrix& J, const double& t, Vector& by_time) {
    problem.jacobian(t, &y[0], columns.data());
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) J(i, j) = columns[i + n * j];
    std::fill(by_time.begin(), by_time.end(), 0.0);
    if (problem.by_time) problem.by_time(t, &by_time[0]);
  };
  return go<Vector>(problem, odeint::make_controlled(problem.a * rtol, rtol, odeint::rosenbrock4<double>()),
                    std::make_pair(rate, jacobian));
}

Answer odeint_dopri5(const Problem& problem, double rtol) {
  using State = std::vector<double>;
  long calls = 0;
  const auto rate = [&](const State& y, State& out, double t) {
    if (++calls > most_calls) throw TooMany{};
    problem.rate(t, y.data(), out.data());
  };
  return go<State>(problem, odeint::make_controlled(problem.a * rtol, rtol, odeint::runge_kutta_dopri5<State>()), rate);
}

}  // namespace truth
