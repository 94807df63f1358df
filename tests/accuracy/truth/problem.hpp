#pragma once

// A problem with its answer, as every solver here sees it: y' = f(t, y) on bare arrays. C++17, for Odeint's sake.

#include <Eigen/Core>

#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>

namespace truth {

enum class Kind { classical, linear, network, smooth, motion };  // the last two aren't stiff

struct Problem {
  std::string name;
  Kind kind = Kind::classical;
  Eigen::VectorXd start{}, exact{};  ///< exact: at `end`; a motion's y is (r, v)
  double end = 1;
  double a = 1;      ///< what a component below it is measured by: atol = a·rtol
  double kappa = 1;  ///< by how much the problem magnifies a small error
  std::function<void(double t, const double* y, double* rate)> rate{};
  std::function<void(double t, const double* y, double* J)> jacobian{};  ///< column by column
  std::function<void(double t, double* slope)> by_time{};                ///< ∂f/∂t; empty where f doesn't see t
  std::function<void(const double* r, double* acceleration)> acceleration{};  ///< of motions
  Eigen::VectorXd conserved{};  ///< c ≥ 0 with c·y constant; empty where none is known
  /// What rounding makes of it at least: f is known to u |∂f/∂y| |y|, and the run adds that up.
  [[nodiscard]] double rounding_of_conserved() const {
    const auto n = start.size();
    Eigen::MatrixXd J(n, n);
    jacobian(end, exact.data(), J.data());
    const double known = conserved.dot(start);
    return std::numeric_limits<double>::epsilon() * (1 + end * conserved.dot(J.cwiseAbs() * exact.cwiseAbs()) / known);
  }

  /// max |y_i − exact_i|/(|exact_i| + a); infinite where y isn't finite
  [[nodiscard]] double error(const Eigen::VectorXd& y) const {
    if (y.size() != exact.size() || !y.allFinite()) return std::numeric_limits<double>::infinity();
    return ((y - exact).array() / (exact.array().abs() + a)).abs().maxCoeff();
  }
};

/// y at the end; nothing where the solver says that it failed.
using Answer = std::optional<Eigen::VectorXd>;

}  // namespace truth
