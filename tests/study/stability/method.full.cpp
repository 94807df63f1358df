// Schemes as numbers, against the steppers themselves and against the spectral radius of a step's matrix.
#include <phistep/phistep.hpp>
#include <phistep/study/stability/method.hpp>

#include <cmath>
#include <complex>

#include "instances/preflight.hpp"
#include "support/catch.hpp"

namespace method_cases {

using namespace phistep;
using Eigen::MatrixXd;
using Kind = Method::Kind;

/// The step's matrix, column by column, as the stepper does it: r'' = K r + C v in three dimensions.
template <class Scheme>
void compare_with_stepper(Scheme scheme) {
  Eigen::Matrix3d K, C;
  K << -4, 1, 0.5, 1, -9, 2, 0.5, 2, -3;
  C << -0.3, 0.7, 0, -0.7, -0.2, 0.1, 0, -0.1, -0.5;
  const double h = 0.3;
  const MatrixXd G = step_matrix(method_of(scheme), {K, C}, h);
  for (int j = 0; j < 6; ++j) {
    Motion state{Eigen::Vector3d(Eigen::Vector3d::Zero()), Eigen::Vector3d(Eigen::Vector3d::Zero())};
    (j < 3 ? state.r : state.v)[j % 3] = 1;
    PhiStepper stepper{state, linear(K, C), scheme};
    REQUIRE(stepper.step(state, 0.0, h));
    // Some ten roundings of numbers of order one.
    CHECK((state.r - G.col(j).head(3)).norm() < 1e-14);
    CHECK((state.v - G.col(j).tail(3)).norm() < 1e-14);
  }
}

}  // namespace method_cases

using namespace method_cases;

namespace {

/// |λ|max of a step of one oscillator or one decay, by the formula: no eigenvalue solver is compiled here.
double radius(const Method& method, const DenseSystemMatrices& system, double h) {
  const MatrixXd G = step_matrix(method, system, h);
  if (G.rows() == 1) return std::abs(G(0, 0));
  const double half = (G(0, 0) + G(1, 1)) / 2, det = G(0, 0) * G(1, 1) - G(0, 1) * G(1, 0);
  const double apart = (G(0, 0) - G(1, 1)) / 2, square = apart * apart + G(0, 1) * G(1, 0);
  return square < 0 ? std::sqrt(det) : std::abs(half) + std::sqrt(square);
}
DenseSystemMatrices oscillator(double omega, double c) {
  return {MatrixXd::Constant(1, 1, -omega * omega), MatrixXd::Constant(1, 1, -c)};
}

}  // namespace

TEST_CASE("the limit of an undamped oscillation, from both sides") {
  const double omega = 3;
  for (int i = 0; i <= 10; ++i)
    for (int j = 0; j <= 10; ++j) {
      const double f = i / 10.0, d = j / 10.0;
      INFO("phi_force " << f << ", phi_drift " << d);
      const Method method{f == d ? Kind::single : Kind::pair, f, d};
      const double limit = method.oscillation_limit();
      const auto at = [&](double a) { return radius(method, oscillator(omega, 0), a / omega); };
      if (limit == 0) {
        CHECK(at(0.3) > 1 + 1e-4);
      } else if (std::isinf(limit)) {
        for (const double a : {0.1, 1.0, 3.0, 10.0, 1e3}) CHECK(at(a) <= 1 + 1e-7);
      } else {
        for (const double share : {0.1, 0.5, 0.9, 0.999}) CHECK(at(share * limit) <= 1 + 1e-7);
        CHECK(at(1.001 * limit) > 1 + 1e-6);
      }
    }
  const Method verlet{Kind::verlet, 0.5, 0.5};
  for (const double c : {0.0, 0.5, 5.0, 50.0}) {
    CHECK(radius(verlet, oscillator(omega, c), 0.999 * 2 / omega) <= 1 + 1e-12);
    CHECK(radius(verlet, oscillator(omega, c), 1.01 * 2 / omega) > 1);
  }
}

TEST_CASE("the limit of a decay, from both sides") {
  for (const double f : {0.0, 0.2, 0.4})
    for (const std::complex<double> lambda :
         {std::complex{-0.1, 0.0}, std::complex{-10.0, 0.0}, std::complex{-3.0, 4.0}, std::complex{-1.0, 1e3}}) {
      const Method method{Kind::single, f, f};
      const double limit = method.decay_limit(lambda);
      CAPTURE(f, lambda, limit);
      CHECK(std::abs(method.factor(0.9 * limit * lambda)) < 1);
      CHECK(std::abs(method.factor(limit * lambda)) == Approx(1).epsilon(1e-12));
      CHECK(std::abs(method.factor(1.1 * limit * lambda)) > 1);
    }
  CHECK(Method{Kind::single, 0, 0}.decay_limit(-10.0) == Approx(0.2).epsilon(1e-15));
  CHECK(Method{Kind::single, 0, 0}.decay_limit({0, 10}) == 0);
  CHECK(std::isinf(Method{Kind::single, 0.5, 0.5}.decay_limit(-10.0)));
  CHECK(std::isinf(method_of(tr_bdf2).decay_limit(-10.0)));
}

TEST_CASE("factor and oscillation are eigenvalues of the step") {
  for (const Method& method :
       {Method{Kind::single, 0.3, 0.3}, Method{Kind::single, 0.5, 0.5}, Method{Kind::single, 1, 1},
        Method{Kind::verlet, 0.5, 0.5}, Method{Kind::pair, 0, 1}, Method{Kind::pair, 0.3, 0.9}})
    for (const double a : {0.01, 0.5, 1.5, 3.0}) {
      CHECK(std::abs(method.oscillation(a)) == Approx(radius(method, oscillator(1, 0), a)).epsilon(1e-12));
      if (method.is_single())
        CHECK(std::abs(method.factor(-a)) ==
              Approx(radius(method, {MatrixXd(1, 0), MatrixXd::Constant(1, 1, -1)}, a)).epsilon(1e-12));
    }
}

TEST_CASE("errors of the exponent: the textbook's") {
  const double a = 0.01;
  const std::complex<double> z{0, a};
  // Next terms: a⁴/80 for φ = ½, 3a⁴/640 for Verlet; (φ−½)a + O(a³), with −(1/3 − φ + φ²) a² in the frequency.
  CHECK(Method{Kind::single, 0.5, 0.5}.exponent_error(z).real() == Approx(-a * a / 12).epsilon(1e-4));
  CHECK(std::abs(Method{Kind::single, 0.5, 0.5}.exponent_error(z).imag()) < 1e-13);
  CHECK(Method{Kind::verlet, 0.5, 0.5}.exponent_error(z).real() == Approx(a * a / 24).epsilon(1e-4));
  CHECK(Method{Kind::single, 0.8, 0.8}.exponent_error(z).imag() == Approx(0.3 * a).epsilon(1e-3));
  CHECK(Method{Kind::single, 0.8, 0.8}.exponent_error(z).real() ==
        Approx(-(1. / 3 - 0.8 + 0.64) * a * a).epsilon(1e-3));
  // e^z − R = −0.0404 z³ for TR-BDF2: log R/z − 1 = 0.0404 z² = −0.0404 a².
  CHECK(method_of(tr_bdf2).exponent_error(z).real() == Approx(-0.0404 * a * a).epsilon(1e-2));
  // Δt for 1 %: a = √0.12 (φ = ½, with its next term), √0.24 (Verlet).
  CHECK(Method{Kind::single, 0.5, 0.5}.accurate_dt({0, 2}, 1e-4) == Approx(std::sqrt(12e-4) / 2).epsilon(1e-3));
  CHECK(Method{Kind::verlet, 0.5, 0.5}.accurate_dt({0, 2}, 1e-4) == Approx(std::sqrt(24e-4) / 2).epsilon(1e-3));
  CHECK(Method{Kind::single, 1, 1}.accurate_dt({0, 2}, 1e-4) == Approx(1e-4).epsilon(1e-3));
}

// method: every scheme, step by step.

TEST_CASE("the matrix of a step is what the steppers do") {
  compare_with_stepper(forward_euler);
  compare_with_stepper(trapezoidal);
  compare_with_stepper(backward_euler);
  compare_with_stepper(midpoint);
  compare_with_stepper(phi(0.3));
  compare_with_stepper(phi_stage(0.7));
  compare_with_stepper(phi(0.2, 0.9));
  compare_with_stepper(symplectic_euler);
  compare_with_stepper(symplectic_euler_adjoint);
  compare_with_stepper(velocity_verlet);
}

TEST_CASE("R(z) of TR-BDF2 is what its stepper does") {
  for (const double z : {-0.01, -1.0, -3.0, -100.0}) {
    Eigen::Vector<double, 1> y{1.0};
    PhiStepper stepper{y, linear(Eigen::Matrix<double, 1, 1>(z)), tr_bdf2};
    REQUIRE(stepper.step(y, 0.0, 1.0));
    CHECK(std::abs(y[0] - method_of(tr_bdf2).factor(z)) < 1e-15);
  }
}
