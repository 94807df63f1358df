// Problems on fields, beside the same on Eigen's vectors.
#pragma once

#include "support/local_field.hpp"

#include <Eigen/Core>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

namespace fields {
using namespace phistep;

/// y_i' = −(i+1) y_i² + sin t
inline double rate(std::size_t i, double y, double t) { return -static_cast<double>(i + 1) * y * y + std::sin(t); }
struct Decay {
  int throws_at = -1;  ///< the call that throws
  int calls = 0;
  LocalField out{};
  const LocalField& operator()(const LocalField& y, double t) {
    if (calls++ == throws_at) throw std::runtime_error("the force of this rank");
    out.take_shape(y);
    for (std::size_t i = 0; i < numbers(y).size(); ++i) numbers(out)[i] = rate(i, numbers(y)[i], t);
    return out;
  }
};
inline Eigen::VectorXd decay(const Eigen::VectorXd& y, double t) {
  Eigen::VectorXd out(y.size());
  for (Eigen::Index i = 0; i < y.size(); ++i) out[i] = rate(static_cast<std::size_t>(i), y[i], t);
  return out;
}
struct DecayOfVectors {
  Eigen::VectorXd operator()(const Eigen::VectorXd& y, double t) const { return decay(y, t); }
  static Eigen::MatrixXd jacobian(const Eigen::VectorXd& y, double) {
    Eigen::VectorXd d(y.size());
    for (Eigen::Index i = 0; i < y.size(); ++i) d[i] = -2 * static_cast<double>(i + 1) * y[i];
    return d.asDiagonal();
  }
};

/// −(i+1) sin r_i − 0.1 v_i
inline double pull(std::size_t i, double r) { return -static_cast<double>(i + 1) * std::sin(r); }
struct Swings {
  LocalField out{};
  const LocalField& operator()(const LocalField& r) {
    out.take_shape(r);
    for (std::size_t i = 0; i < numbers(r).size(); ++i) numbers(out)[i] = pull(i, numbers(r)[i]);
    return out;
  }
};
struct DampedSwings {
  Swings swings{};
  const LocalField& operator()(const LocalField& r, const LocalField& v) {
    swings(r);
    for (std::size_t i = 0; i < numbers(r).size(); ++i) numbers(swings.out)[i] -= 0.1 * numbers(v)[i];
    return swings.out;
  }
};

/// The solver of these: diagonal matrices.
struct Diagonal {
  static constexpr bool is_field_solver = true;
  double mass = 1;
  std::vector<double> J{}, K{}, W{};
  int throws_at = -1, calls = 0;
  Outcome linearize(double, const LocalField& y) {
    if (calls++ == throws_at) throw std::runtime_error("the solver of this rank");
    J.clear(), K.clear();
    for (std::size_t i = 0; i < numbers(y).size(); ++i) J.push_back(-2 * static_cast<double>(i + 1) * numbers(y)[i]);
    return Outcome::success;
  }
  Outcome linearize(double, const LocalField& r, const LocalField&) {
    J.assign(numbers(r).size(), -0.1), K.clear();
    for (std::size_t i = 0; i < numbers(r).size(); ++i)
      K.push_back(-static_cast<double>(i + 1) * std::cos(numbers(r)[i]));
    return Outcome::success;
  }
  Outcome factorize(const Gamma<double>& gamma) {
    W.clear();
    for (std::size_t i = 0; i < J.size(); ++i)
      W.push_back(mass - gamma.force * J[i] - (K.empty() ? 0 : gamma.force * gamma.drift * K[i]));
    return Outcome::success;
  }
  Outcome solve(LocalField& x, double) {
    if (calls++ == throws_at) throw std::runtime_error("the solver of this rank");
    for (std::size_t i = 0; i < W.size(); ++i) numbers(x)[i] /= W[i];
    return Outcome::success;
  }
  [[nodiscard]] static std::int64_t iterations() { return 1; }
  [[nodiscard]] static const char* name() { return "diagonal"; }
};
}  // namespace fields
