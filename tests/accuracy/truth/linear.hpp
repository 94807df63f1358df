#pragma once

// Random stiff linear systems whose solution is known: y' = A (y − p(t)) + p'(t) with A = Q D Q⁻¹, D of numbers and of 2 × 2
// blocks of complex pairs, p = 0 or a slow oscillation: y = p(t) + Q exp(D t) Q⁻¹ (y(0) − p(0)).
//
// f is evaluated by the factors: with A as one matrix of doubles the slow modes would be known to u·|λ_fast| only, in f as in
// the answer. The Jacobian that the solvers get is A in doubles.

#include <Eigen/Core>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

#include "accuracy/truth/problem.hpp"
#include "accuracy/truth/random.hpp"

namespace truth {

class Linear {
 public:
  using Real = long double;
  template <class T>
  using Vector = Eigen::Matrix<T, Eigen::Dynamic, 1>;

  /// @param n            2 … 20
  /// @param ratio        of the fastest to the slowest |λ|, 1 … 1e12
  /// @param condition    of Q, about; 1: A is normal
  Linear(Random& random, int n, double ratio, double condition, bool forced) {
    // Of slow modes one may grow.
    const double decades = std::log10(ratio);
    for (int i = 0; i < n;) {
      double size = std::pow(10.0, i == 0 ? 0 : i >= n - 2 && i > 0 ? decades : random.uniform(0, decades));
      if (i + 2 <= n && random.chance(0.4)) {
        const double angle = random.uniform(0, 1.5);  // from the negative axis, 86°
        modes_.push_back({-size * std::cos(angle), size * std::sin(angle)});
        i += 2;
      } else {
        if (i == 0 && random.chance(0.2)) size = -0.5;
        modes_.push_back({-size, 0});
        i += 1;
      }
    }
    using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
    const auto rotation = [&] {
      Matrix x(n, n);
      for (Real& entry : x.reshaped()) entry = static_cast<Real>(random.normal());
      return Matrix(Eigen::HouseholderQR<Matrix>(x).householderQ());
    };
    const Matrix U = rotation(), V = rotation();
    Vector<Real> scale(n);
    for (int i = 0; i < n; ++i) scale[i] = std::pow(static_cast<Real>(condition), -Real(i) / Real(std::max(1, n - 1)));
    Q_ = (U * scale.asDiagonal() * V.transpose()).cast<double>();
    inverse_ = (V * scale.cwiseInverse().asDiagonal() * U.transpose()).cast<double>();
    p_ = q_ = Eigen::VectorXd::Zero(n);
    if (forced)
      for (int i = 0; i < n; ++i) p_[i] = random.normal(), q_[i] = random.normal();
    frequency_ = random.uniform(0.5, 3);
    A_.resize(n, n);
    for (int j = 0; j < n; ++j) A_.col(j) = Q_ * diagonal<double>(inverse_.col(j));
  }

  void rate(double t, const double* y, double* out) const {
    const auto n = Q_.rows();
    const Eigen::VectorXd away = Eigen::Map<const Eigen::VectorXd>(y, n) - path<double>(t);
    Eigen::Map<Eigen::VectorXd>(out, n) = Q_ * diagonal<double>(inverse_ * away) +
                                          frequency_ * (std::cos(frequency_ * t) * p_ - std::sin(frequency_ * t) * q_);
  }
  /// ∂f/∂t = p'' − A p'
  void by_time(double t, double* out) const {
    const double w = frequency_, c = std::cos(w * t), s = std::sin(w * t);
    const Eigen::VectorXd slope = w * (c * p_ - s * q_);
    Eigen::Map<Eigen::VectorXd>(out, Q_.rows()) = -w * w * (s * p_ + c * q_) - Q_ * diagonal<double>(inverse_ * slope);
  }
  [[nodiscard]] const Eigen::MatrixXd& matrix() const { return A_; }
  [[nodiscard]] Eigen::VectorXd at(const Eigen::VectorXd& start, double t) const {
    const Vector<Real> away = start.cast<Real>() - path<Real>(0);
    return (path<Real>(t) + propagated(away, static_cast<Real>(t))).cast<double>();
  }
  /// The largest max_i Σ_k |∂y_i(end)/∂y_k(s)| w_k(s)/w_i(end) over times s, w = |y| + a; at least 1.
  [[nodiscard]] double conditioning(const Eigen::VectorXd& start, double end, double a) const {
    const auto n = Q_.rows();
    const Eigen::ArrayXd at_end = at(start, end).array().abs() + a;
    std::vector<double> times{0};
    for (int k = 1; k <= 10; ++k) {
      times.push_back(end * k / 11);
      times.push_back(end * std::pow(10.0, -k));
    }
    double kappa = 1;
    for (const double s : times) {
      const Eigen::ArrayXd weight = at(start, s).array().abs() + a;
      Eigen::ArrayXd growth = Eigen::ArrayXd::Zero(n);
      for (Eigen::Index k = 0; k < n; ++k)
        growth +=
            propagated(Vector<Real>::Unit(n, k), static_cast<Real>(end - s)).cast<double>().array().abs() * weight[k];
      kappa = std::max(kappa, (growth / at_end).maxCoeff());
    }
    return kappa;
  }

 private:
  template <class T>
  [[nodiscard]] Vector<T> path(T t) const {
    const T w = static_cast<T>(frequency_) * t;
    return std::sin(w) * p_.cast<T>() + std::cos(w) * q_.cast<T>();
  }
  /// D z
  template <class T>
  [[nodiscard]] Vector<T> diagonal(const Vector<T>& z) const {
    Vector<T> out(z.size());
    Eigen::Index i = 0;
    for (const auto& [re, im] : modes_) {
      const T a = static_cast<T>(re), b = static_cast<T>(im);
      if (im == 0) {
        out[i] = a * z[i];
        i += 1;
      } else {
        out[i] = a * z[i] + b * z[i + 1], out[i + 1] = a * z[i + 1] - b * z[i];
        i += 2;
      }
    }
    return out;
  }
  /// Q exp(D t) Q⁻¹ x
  [[nodiscard]] Vector<Real> propagated(const Vector<Real>& x, Real t) const {
    Vector<Real> z = inverse_.cast<Real>() * x;
    Eigen::Index i = 0;
    for (const auto& [re, im] : modes_) {
      const Real size = std::exp(static_cast<Real>(re) * t), turn = static_cast<Real>(im) * t;
      if (im == 0) {
        z[i] *= size;
        i += 1;
      } else {
        const Real c = std::cos(turn), s = std::sin(turn), first = z[i], second = z[i + 1];
        z[i] = size * (c * first + s * second), z[i + 1] = size * (c * second - s * first);
        i += 2;
      }
    }
    return Q_.cast<Real>() * z;
  }

  std::vector<std::pair<double, double>> modes_;  // λ = re ± i·im
  Eigen::MatrixXd Q_, inverse_, A_;
  Eigen::VectorXd p_, q_;  // p(t) = p sin ωt + q cos ωt
  double frequency_ = 1;
};

/// The k-th of the random linear systems of a seed.
[[nodiscard]] inline Problem linear_problem(std::uint64_t seed, int k) {
  Random random{seed + 1000003 * static_cast<std::uint64_t>(k)};
  const int n = random.integer(2, 20);
  const double ratio = random.power_of_ten(0, 12), condition = random.chance(0.5) ? 1 : random.power_of_ten(0, 3);
  const bool forced = random.chance(0.5);
  const Linear system(random, n, ratio, condition, forced);
  Problem problem;
  char name[120];
  std::snprintf(name, sizeof name, "linear %d: n = %d, stiffness %.1e, cond Q = %.0f%s", k, n, ratio, condition,
                forced ? ", forced" : "");
  problem.name = name;
  problem.kind = Kind::linear;
  problem.a = 1e-2;
  problem.end = random.uniform(0.5, 5);
  problem.start.resize(n);
  for (double& y : problem.start) y = random.normal();
  problem.exact = system.at(problem.start, problem.end);
  problem.kappa = system.conditioning(problem.start, problem.end, problem.a);
  problem.rate = [system](double t, const double* y, double* out) { system.rate(t, y, out); };
  if (forced) problem.by_time = [system](double t, double* out) { system.by_time(t, out); };
  problem.jacobian = [n, A = system.matrix()](double, const double*, double* J) {
    Eigen::Map<Eigen::MatrixXd>(J, n, n) = A;
  };
  return problem;
}

}  // namespace truth
