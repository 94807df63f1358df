/// Differential-algebraic equations of index 1, M y' = Ψ(t, y) with a singular M, each with its Jacobian and its solution at
/// the end. Robertson: rodas5p at rtol 1e-13, with which IDA at 1e-10 agrees to 1e-10; the amplifier: the test set's, with
/// which rodas5p at 1e-13 agrees to 1e-11.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <numbers>

namespace problems {

/// H. H. Robertson's reactions with the conservation law in place of the third rate (A. C. Hindmarsh & al., IDA's idaRoberts).
struct RobertsonDae {
  static constexpr int n = 3;
  static constexpr double t1 = 40;
  using State = Eigen::Vector<double, n>;
  static State start() { return {1, 0, 0}; }
  static State mass() { return {1, 1, 0}; }
  template <class T>
  static void rate(double, const T* y, T* out) {
    out[0] = -0.04 * y[0] + 1e4 * y[1] * y[2];
    out[1] = 0.04 * y[0] - 1e4 * y[1] * y[2] - 3e7 * y[1] * y[1];
    out[2] = y[0] + y[1] + y[2] - 1;
  }
  static void entries(double, const double* y, auto&& put) {
    put(0, 0, -0.04), put(0, 1, 1e4 * y[2]), put(0, 2, 1e4 * y[1]);
    put(1, 0, 0.04), put(1, 1, -1e4 * y[2] - 6e7 * y[1]), put(1, 2, -1e4 * y[1]);
    put(2, 0, 1.0), put(2, 1, 1.0), put(2, 2, 1.0);
  }
  static State end() { return {7.158270687194e-01, 9.185534764558e-06, 2.841637457458e-01}; }
};

/// The transistor amplifier (E. Hairer & G. Wanner, Solving ODEs II, sect. VI.1; Test Set for IVP Solvers): eight voltages, of
/// which five have a capacity; M has no row of zeros.
struct TransistorAmplifier {
  static constexpr int n = 8;
  static constexpr double t1 = 0.2;  // [s]
  using State = Eigen::Vector<double, n>;
  static constexpr double Ub = 6, R0 = 1000, R = 9000, alpha = 0.99;
  static State start() { return {0, Ub / 2, Ub / 2, Ub, Ub / 2, Ub / 2, Ub, 0}; }  // [V]
  static Eigen::Matrix<double, n, n> mass() {                                      // [F]
    Eigen::Matrix<double, n, n> M = Eigen::Matrix<double, n, n>::Zero();
    M.block<2, 2>(0, 0) << -1e-6, 1e-6, 1e-6, -1e-6;
    M(2, 2) = -2e-6;
    M.block<2, 2>(3, 3) << -3e-6, 3e-6, 3e-6, -3e-6;
    M(5, 5) = -4e-6;
    M.block<2, 2>(6, 6) << -5e-6, 5e-6, 5e-6, -5e-6;
    return M;
  }
  template <class T>
  static T g(T U) {
    using std::exp;
    return 1e-6 * (exp(U / 0.026) - 1);
  }
  static double dg(double U) { return 1e-6 / 0.026 * std::exp(U / 0.026); }
  template <class Time, class T>
  static void rate(Time t, const T* y, T* out) {
    using std::sin;
    const T Ue = 0.1 * sin(200 * std::numbers::pi_v<Time> * t), g23 = g(T(y[1] - y[2])), g56 = g(T(y[4] - y[5]));
    out[0] = (y[0] - Ue) / R0;
    out[1] = (2 * y[1] - Ub) / R + (1 - alpha) * g23;
    out[2] = y[2] / R - g23;
    out[3] = (y[3] - Ub) / R + alpha * g23;
    out[4] = (2 * y[4] - Ub) / R + (1 - alpha) * g56;
    out[5] = y[5] / R - g56;
    out[6] = (y[6] - Ub) / R + alpha * g56;
    out[7] = y[7] / R;
  }
  static void entries(double, const double* y, auto&& put) {
    const double a = dg(y[1] - y[2]), b = dg(y[4] - y[5]);
    put(0, 0, 1 / R0);
    put(1, 1, 2 / R + (1 - alpha) * a), put(1, 2, -(1 - alpha) * a);
    put(2, 1, -a), put(2, 2, 1 / R + a);
    put(3, 1, alpha * a), put(3, 2, -alpha * a), put(3, 3, 1 / R);
    put(4, 4, 2 / R + (1 - alpha) * b), put(4, 5, -(1 - alpha) * b);
    put(5, 4, -b), put(5, 5, 1 / R + b);
    put(6, 4, alpha * b), put(6, 5, -alpha * b), put(6, 6, 1 / R);
    put(7, 7, 1 / R);
  }
  static State end() {
    return {-0.5562145012262709e-2, 0.3006522471903042e1, 0.2849958788608128e1, 0.2926422536206241e1,
            0.2704617865010554e1,   0.2761837778393145e1, 0.4770927631616772e1, 0.1236995868091548e1};
  }
};

/// A pendulum of length 1 m in Cartesian coordinates, (x, y, v_x, v_y, λ), its constraint differentiated twice: index 1
/// (Hairer & Wanner, Solving ODEs II, eq. VII.1.24).
struct CartesianPendulum {
  static constexpr int n = 5;
  static constexpr double t1 = 2, gravity = 9.81;  // [s], [m/s²]
  using State = Eigen::Vector<double, n>;
  static State start() { return {1, 0, 0, 0, 0}; }
  static State mass() { return {1, 1, 1, 1, 0}; }
  template <class T>
  static void rate(double, const T* y, T* out) {
    out[0] = y[2];
    out[1] = y[3];
    out[2] = -y[4] * y[0];
    out[3] = -y[4] * y[1] - gravity;
    out[4] = y[2] * y[2] + y[3] * y[3] - y[4] * (y[0] * y[0] + y[1] * y[1]) - gravity * y[1];
  }
  static void entries(double, const double* y, auto&& put) {
    put(0, 2, 1.0), put(1, 3, 1.0);
    put(2, 0, -y[4]), put(2, 4, -y[0]);
    put(3, 1, -y[4]), put(3, 4, -y[1]);
    put(4, 0, -2 * y[4] * y[0]), put(4, 1, -2 * y[4] * y[1] - gravity);
    put(4, 2, 2 * y[2]), put(4, 3, 2 * y[3]), put(4, 4, -(y[0] * y[0] + y[1] * y[1]));
  }
  /// By the angle's equation φ'' = −g sin φ, by Taylor series of 25 digits.
  static State end() {
    return {0.7935661953433217, -0.6084839304437915, 2.102437874436126, 2.741935393010509, 17.907682072960784};
  }
};

/// Ψ and its Jacobian as phistep takes them.
template <class Problem>
struct DaeForce {
  using State = typename Problem::State;
  using Matrix = Eigen::Matrix<double, Problem::n, Problem::n>;
  State operator()(const State& y, double t) const {
    State out;
    Problem::rate(t, y.data(), out.data());
    return out;
  }
  Matrix jacobian(const State& y, double t) const {
    Matrix J = Matrix::Zero();
    Problem::entries(t, y.data(), [&J](int i, int j, double x) { J(i, j) += x; });
    return J;
  }
};
/// … where Ψ ignores t.
template <class Problem>
struct AutonomousDaeForce {
  using State = typename Problem::State;
  State operator()(const State& y) const { return DaeForce<Problem>{}(y, 0); }
  typename DaeForce<Problem>::Matrix jacobian(const State& y) const { return DaeForce<Problem>{}.jacobian(y, 0); }
};

}  // namespace problems
