#pragma once

#include <Eigen/Core>
#include <phistep/phistep.hpp>

#include <cmath>

namespace problems {

/// Eight unit masses between two walls, joined by hardening springs e + e³ (Fermi, Pasta & Ulam's chain), damped, the last
/// one driven: r'' = Ψ(r, v, t).
struct DrivenChain {
  static constexpr int n = 8;
  using Vector = Eigen::Matrix<double, n, 1>;
  using Matrix = Eigen::Matrix<double, n, n>;
  using State = phistep::Motion<Vector>;
  static constexpr double damping = 0.1, amplitude = 0.5, frequency = 1.2, end = 15;

  [[nodiscard]] static State start() {
    State y{Vector::Zero(), Vector::Zero()};
    y.r[0] = 0.5;
    y.v[1] = -0.5;
    return y;
  }
  Vector operator()(const Vector& r, const Vector& v, double t) const {
    Vector force = -damping * v;
    for (int i = 0; i <= n; ++i) {
      const double e = extension(r, i), pull = e + e * e * e;
      if (i > 0) force[i - 1] += pull;
      if (i < n) force[i] -= pull;
    }
    force[n - 1] += amplitude * std::sin(frequency * t);
    return force;
  }
  [[nodiscard]] phistep::MotionJacobian<Matrix, Matrix> jacobian(const Vector& r, const Vector& /*v*/,
                                                                 double /*t*/) const {
    Matrix K = Matrix::Zero();
    for (int i = 0; i <= n; ++i) {
      const double e = extension(r, i), stiffness = 1 + 3 * e * e;
      if (i > 0) K(i - 1, i - 1) -= stiffness;
      if (i < n) K(i, i) -= stiffness;
      if (i > 0 && i < n) K(i - 1, i) = K(i, i - 1) = stiffness;
    }
    return {K, -damping * Matrix::Identity()};
  }

  /// At t = 15, by the extrapolated midpoint rule in quadruple precision with 2000 and 4000 steps.
  [[nodiscard]] static State exact() {
    return {Vector{{0.330775009656190807199, 0.189276211593218309666, -0.0988041583162032436565, -0.14705772572930348024, 0.239932740894113395817, 0.162834948984330223885, -0.104634039902465110776, -0.265667767441001935629}},
            Vector{{-0.508265898466836302091, -0.317939155292626349511, 0.178129643004858493318, 0.359295557568174206159, 0.255257744962969821174, -0.222683136277894921188, -0.557471077604663626569, -0.0628721230282214009416}}};
  }

 private:
  /// Of the spring before mass i.
  [[nodiscard]] static double extension(const Vector& r, int i) {
    return (i < n ? r[i] : 0.0) - (i > 0 ? r[i - 1] : 0.0);
  }
};

}  // namespace problems
