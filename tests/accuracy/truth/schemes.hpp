#pragma once

// The library's schemes on such a problem.

#include <phistep/phistep.hpp>

#include <type_traits>

#include "accuracy/truth/count.hpp"

namespace truth {

/// f with its Jacobian …
struct Force {
  const Problem& problem;
  Eigen::VectorXd operator()(const Eigen::VectorXd& y, double t) const {
    Eigen::VectorXd rate(y.size());
    problem.rate(t, y.data(), rate.data());
    return rate;
  }
  [[nodiscard]] Eigen::MatrixXd jacobian(const Eigen::VectorXd& y, double t) const {
    Eigen::MatrixXd J(y.size(), y.size());
    problem.jacobian(t, y.data(), J.data());
    return J;
  }
};
/// … and without one: the library takes differences.
struct BareForce {
  const Problem& problem;
  Eigen::VectorXd operator()(const Eigen::VectorXd& y, double t) const { return Force{problem}(y, t); }
};
/// The acceleration of a motion.
struct Acceleration {
  const Problem& problem;
  Eigen::VectorXd operator()(const Eigen::VectorXd& r) const {
    Eigen::VectorXd a(r.size());
    problem.acceleration(r.data(), a.data());
    return a;
  }
};

template <class F, class Scheme>
[[nodiscard]] Answer run(const Problem& problem, Scheme scheme, double rtol) {
  const phistep::tolerance wanted{.rtol = rtol, .atol = problem.a * rtol, .max_steps = most_steps};
  const phistep::TimeSpan<double> span{0.0, problem.end};
  const auto n = problem.start.size();
  if constexpr (std::is_same_v<F, Acceleration>) {
    phistep::Motion<Eigen::VectorXd> y{problem.start.head(n / 2), problem.start.tail(n / 2)};
    phistep::PhiStepper stepper{y, F{problem}, scheme};
    if (!phistep::integrate(stepper, y, span, wanted)) return {};
    Eigen::VectorXd all(n);
    all << y.r, y.v;
    return all;
  } else {
    Eigen::VectorXd y = problem.start;
    phistep::PhiStepper stepper{y, F{problem}, scheme};
    if (!phistep::integrate(stepper, y, span, wanted)) return {};
    return y;
  }
}

}  // namespace truth
