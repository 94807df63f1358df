#pragma once

// Answers in extended precision, and how strongly a problem magnifies errors.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <utility>
#include <vector>

#include "accuracy/truth/extrapolation.hpp"
#include "accuracy/truth/network.hpp"
#include "accuracy/truth/problem.hpp"

namespace truth {

/// rate and entries of anything, without its type: one solver for all.
class Any {
 public:
  using State = Vector<Eigen::Dynamic>;
  template <class P>
  explicit Any(const P& problem)
      : rate_{[problem](const Real* y, Real* out) { problem.rate(y, out); }},
        entries_{[problem](const Real* y, const Put& put) { problem.entries(y, put); }} {}
  void rate(const State& y, State& out) const { rate_(y.data(), out.data()); }
  void entries(const State& y, auto&& put) const { entries_(y.data(), Put{put}); }

 private:
  using Put = std::function<void(int, int, Real)>;
  std::function<void(const Real*, Real*)> rate_;
  std::function<void(const Real*, const Put&)> entries_;
};

/// y(end) by extrapolation.
[[nodiscard]] inline Vector<Eigen::Dynamic> solution(const Any& problem, const Eigen::VectorXd& start, double end,
                                                     double a, Real rtol = 1e-12L) {
  using Rows = StiffRows<Dense<Any>>;
  Vector<Eigen::Dynamic> y = start.cast<Real>();
  const Real length = static_cast<Real>(end);
  Path<Rows>{{{end, Rows{Dense<Any>{problem}}}}, a, rtol}.go(y, 0, length, Real(1e-12) * length);
  return y;
}

/// Many nearby solutions, one a column, that share the Jacobian of the first.
class Bundle {
 public:
  using State = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
  explicit Bundle(Any problem) : one_{std::move(problem)} {}
  [[nodiscard]] State rate(const State& y) const {
    State out(y.rows(), y.cols());
    for (Eigen::Index k = 0; k < y.cols(); ++k) out.col(k) = one_.rate(y.col(k));
    return out;
  }
  void linearize(const State& y) { one_.linearize(y.col(0)); }
  void factorize(Real h) { one_.factorize(h); }
  [[nodiscard]] State solve(const State& b) const { return one_.solve(b); }

 private:
  Dense<Any> one_;
};

/// max over s of max_i Σ_k |∂y_i(end)/∂y_k(s)| w_k(s)/w_i(end), at least 1, with w = |y| + a: s = 0, tenths of the end time, and
/// its tenth, hundredth, … where fast modes live. By differences from each of these times to the next.
[[nodiscard]] inline double conditioning(const Any& problem, const Eigen::VectorXd& start, double end, double a) {
  using Rows = StiffRows<Bundle>;
  using State = typename Rows::State;
  constexpr Real rtol = 1e-8L, by = 1e-4L;
  Path<Rows> path{{{end, Rows{Bundle{problem}}}}, a, rtol};
  std::vector<Real> times{0};
  for (int k = 12; k > 1; --k) times.push_back(static_cast<Real>(end) * std::pow(Real(10), -k));
  for (int k = 1; k <= 10; ++k) times.push_back(static_cast<Real>(end) * k / 10);
  const auto n = start.size();
  using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
  using Column = Vector<Eigen::Dynamic>;
  Column y = start.template cast<Real>();
  const auto weight = [a](const Column& x) -> Column { return (x.array().abs() + static_cast<Real>(a)).matrix(); };
  std::vector<Column> weights{weight(y)};
  std::vector<Matrix> transitions;
  for (std::size_t s = 0; s + 1 < times.size(); ++s) {
    State all(n, 2 * n + 1);
    all.colwise() = y;
    for (Eigen::Index k = 0; k < n; ++k) {
      all(k, 1 + k) += by * weights.back()[k];
      all(k, 1 + n + k) -= by * weights.back()[k];
    }
    path.go(all, times[s], times[s + 1], (times[s + 1] - times[s]) / 100);
    y = all.col(0);
    transitions.push_back((all.middleCols(1, n) - all.rightCols(n)) *
                          (2 * by * weights.back()).cwiseInverse().asDiagonal());
    weights.push_back(weight(y));
  }
  Real kappa = 1;
  Matrix phi = Matrix::Identity(n, n);
  for (std::size_t s = transitions.size(); s-- > 0;) {
    phi = (phi * transitions[s]).eval();
    const Column growth = phi.cwiseAbs() * weights[s];
    kappa = std::max(kappa, (growth.array() / weights.back().array()).maxCoeff());
  }
  return static_cast<double>(kappa);
}

/// f and ∂f/∂y of anything with rate and entries.
template <class P>
void attach(Problem& to, const P& problem) {
  const auto n = to.start.size();
  to.rate = [problem](double, const double* y, double* out) { problem.rate(y, out); };
  to.jacobian = [problem, n](double, const double* y, double* J) {
    std::fill(J, J + n * n, 0.0);
    problem.entries(y, [J, n](int i, int j, double x) { J[i + n * j] += x; });
  };
}

/// The k-th of the random networks of a seed, without its answer.
struct RandomNetwork {
  Network network;
  Problem problem;
};
[[nodiscard]] inline RandomNetwork random_network(std::uint64_t seed, int k) {
  Random random{seed + 1000003 * static_cast<std::uint64_t>(k)};
  const int species = random.integer(3, 12), reactions = random.integer(4, 30);
  RandomNetwork made{Network(random, species, reactions), {}};
  Problem& problem = made.problem;
  problem.kind = Kind::network;
  problem.a = 1e-6;
  problem.end = random.power_of_ten(-1, 3);
  problem.start.resize(species);
  for (double& y : problem.start) y = random.chance(0.5) ? random.uniform() : 0;
  problem.start[random.integer(0, 2)] = 1;
  problem.conserved = made.network.masses();
  char name[100];
  std::snprintf(name, sizeof name, "network %d: %d species, %d reactions, to t = %.3g", k, species, reactions,
                problem.end);
  problem.name = name;
  attach(problem, made.network);
  return made;
}
/// With its answer.
[[nodiscard]] inline RandomNetwork network_problem(std::uint64_t seed, int k) {
  RandomNetwork made = random_network(seed, k);
  Problem& problem = made.problem;
  problem.exact = solution(Any{made.network}, problem.start, problem.end, problem.a).cast<double>();
  problem.kappa = conditioning(Any{made.network}, problem.start, problem.end, problem.a);
  return made;
}

}  // namespace truth
