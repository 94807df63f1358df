// States of complex numbers, and of numbers with derivatives: the steps of their parts, as a state of reals takes them by hand.
#include <catch2/catch.hpp>
#include <phistep/automatic.hpp>
#include <phistep/io.hpp>
#include <phistep/phistep.hpp>
#include <phistep/sparse.hpp>
#include <unsupported/Eigen/AutoDiff>

#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

namespace {
using namespace std::complex_literals;
using Complex = std::complex<double>;
using phistep::fixed;
using phistep::PhiStepper;
using phistep::tolerance;

const tolerance tight{.rtol = 1e-9, .atol = 1e-11};

/// H of a chain of sites with a phase on each bond, Hermitian.
Eigen::MatrixXcd chain(Eigen::Index n) {
  Eigen::MatrixXcd H = Eigen::MatrixXcd::Zero(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    H(k, k) = 0.3 * static_cast<double>(k % 3);
    if (k + 1 < n) {
      H(k, k + 1) = std::polar(1.0, 0.4 * static_cast<double>(k));
      H(k + 1, k) = std::conj(H(k, k + 1));
    }
  }
  return H;
}
Eigen::VectorXcd start(Eigen::Index n) {
  Eigen::VectorXcd psi(n);
  for (Eigen::Index k = 0; k < n; ++k) psi[k] = Complex{std::cos(0.7 * static_cast<double>(k)), 0.1};
  return psi.normalized();
}
/// exp(−iHt)ψ by its series, in pieces.
Eigen::VectorXcd exact(const Eigen::MatrixXcd& H, Eigen::VectorXcd psi, double t) {
  for (int piece = 0; piece < 16; ++piece) {
    Eigen::VectorXcd term = psi;
    for (int k = 1; k < 30; ++k) psi += term = (-1i * t / 16.0 / static_cast<double>(k)) * (H * term);
  }
  return psi;
}
struct Schroedinger {
  Eigen::MatrixXcd H;
  Eigen::VectorXcd operator()(const Eigen::VectorXcd& psi) const { return -1i * (H * psi); }
};
struct WithJacobian : Schroedinger {
  Eigen::MatrixXcd jacobian(const Eigen::VectorXcd& /*psi*/) const { return -1i * H; }
};
struct WithSparse : Schroedinger {
  Eigen::SparseMatrix<Complex> jacobian(const Eigen::VectorXcd& /*psi*/) const { return (-1i * H).sparseView(); }
};

/// y_k' = −k y_k² + y_{k+1}: nonlinear, analytic, of any numbers.
template <class Vector>
Vector reactions(const Vector& y) {
  Vector rate = y;
  for (Eigen::Index k = 0; k < y.size(); ++k)
    rate[k] = y[k] * y[k] * (-1.0 - static_cast<double>(k)) + y[(k + 1) % y.size()];
  return rate;
}
}  // namespace

#if PHISTEP_QUICK

TEST_CASE("complex states: every kind of scheme comes to exp(-iHt) psi, and phi = 1/2 keeps its norm") {
  const Eigen::MatrixXcd H = chain(6);
  const Eigen::VectorXcd wanted = exact(H, start(6), 2);
  const auto error_of = [&](auto scheme, const auto& control) {
    Eigen::VectorXcd psi = start(6);
    PhiStepper stepper{psi, Schroedinger{H}, scheme};
    REQUIRE(integrate(stepper, psi, {0.0, 2.0}, control));
    return (psi - wanted).norm();
  };
  for (const auto& [coarse, fine] :
       {std::pair{error_of(phistep::trapezoidal, fixed(0.02)), error_of(phistep::trapezoidal, fixed(0.01))},
        std::pair{error_of(phistep::tr_bdf2, fixed(0.02)), error_of(phistep::tr_bdf2, fixed(0.01))},
        std::pair{error_of(phistep::rodas4p2, fixed(0.2)) / 4, error_of(phistep::rodas4p2, fixed(0.1))}}) {
    CHECK(coarse / fine > 3.6);
    CHECK(coarse / fine < 5.5);
    CHECK(fine < 1e-3);
  }
  CHECK(error_of(phistep::dop853, tight) < 1e-7);
  CHECK(error_of(phistep::rodas5p, tight) < 1e-7);
  CHECK(error_of(phistep::radau, tight) < 1e-7);

  Eigen::VectorXcd psi = start(6);
  PhiStepper stepper{psi, phistep::affine(Schroedinger{H}), phistep::trapezoidal};
  REQUIRE(integrate(stepper, psi, {0.0, 100.0}, fixed(0.1)));
  CHECK(std::abs(psi.norm() - 1) < 1e-13);
  CHECK(stepper.statistics().jacobians == 1);
}

TEST_CASE("complex states: the bits and the counts of their real and imaginary parts stepped as a real state") {
  const Eigen::MatrixXcd H = chain(5);
  const auto as_reals = [&H](const Eigen::VectorXd& y) -> Eigen::VectorXd {
    const Eigen::VectorXcd psi = Eigen::Map<const Eigen::VectorXcd>{reinterpret_cast<const Complex*>(y.data()), 5};
    const Eigen::VectorXcd rate = -1i * (H * psi);
    return Eigen::Map<const Eigen::VectorXd>{reinterpret_cast<const double*>(rate.data()), 10};
  };
  const auto same = [&](auto scheme, const auto& control) {
    Eigen::VectorXcd psi = start(5);
    Eigen::VectorXd y = Eigen::Map<const Eigen::VectorXd>{reinterpret_cast<const double*>(psi.data()), 10};
    PhiStepper complex{psi, Schroedinger{H}, scheme};
    PhiStepper real{y, as_reals, scheme};
    REQUIRE(integrate(complex, psi, {0.0, 1.0}, control));
    REQUIRE(integrate(real, y, {0.0, 1.0}, control));
    CHECK(Eigen::Map<const Eigen::VectorXd>{reinterpret_cast<const double*>(psi.data()), 10} == y);
    CHECK(complex.statistics().force_calls == real.statistics().force_calls);
    CHECK(complex.statistics().jacobians == real.statistics().jacobians);
  };
  same(phistep::backward_euler, fixed(0.1));
  same(phistep::dop853, tight);
  same(phistep::rodas5p, tight);
}

TEST_CASE("complex states: events, samples, observers and checkpoints see complex numbers") {
  Eigen::VectorXcd y{{1.0, 1i}};
  const auto spin = [](const Eigen::VectorXcd& z) -> Eigen::VectorXcd { return 1i * z; };
  PhiStepper stepper{y, spin, phistep::dop853};
  int looks = 0, steps = 0;
  auto level = phistep::event([](const Eigen::VectorXcd& z) { return z[0].real(); });
  const auto report = integrate(
      stepper, y, {0.0, 3.0}, tight, level,
      phistep::sampled(0.5,
                       [&](double t, const Eigen::VectorXcd& z) {
                         ++looks;
                         CHECK(std::abs(z[0] - std::exp(1i * t)) < 1e-7);
                       }),
      [&](double t, const Eigen::VectorXcd& z) { CHECK(std::abs(z[1] - 1i * std::exp(1i * t)) < 1e-7); },
      [&](const auto& step) {
        ++steps;
        const Eigen::VectorXcd inside = step.at((step.t0() + step.t1()) / 2), end = step.end();
        CHECK(std::abs(inside[0] - std::exp(0.5i * (step.t0() + step.t1()))) < 1e-7);
        CHECK(std::abs(end[0] - std::exp(1i * step.t1())) < 1e-7);
      });
  REQUIRE(report);
  CHECK(looks == 7);
  CHECK(steps == report.statistics.steps);
  REQUIRE(level.times().size() == 1);
  CHECK(std::abs(level.times()[0] - std::numbers::pi / 2) < 1e-8);

  std::stringstream file;
  phistep::save_checkpoint(file, "y", y, "stepper", stepper);
  Eigen::VectorXcd other = Eigen::VectorXcd::Zero(2);
  PhiStepper second{other, spin, phistep::dop853};
  phistep::load_checkpoint(file, "y", other, "stepper", second);
  CHECK(other == y);
  REQUIRE(stepper.step(y, 3.0, 0.1));
  REQUIRE(second.step(other, 3.0, 0.1));
  CHECK(other == y);
}

TEST_CASE("complex states: csv writes their parts, and Halving takes them") {
  Eigen::Vector2cd y{1.0, 1i};
  std::ostringstream lines;
  const auto spin = [](const Eigen::Vector2cd& z) -> Eigen::Vector2cd { return 1i * z; };
  phistep::Halving stepper{PhiStepper{y, spin, phistep::trapezoidal}};
  REQUIRE(integrate(stepper, y, {0.0, 1.0}, fixed(1.0), phistep::csv(lines)));
  double t, re, im;
  const std::string start = "t,y0,y1,y2,y3\n0,1,0,0,1\n";
  REQUIRE(lines.str().substr(0, start.size()) == start);
  REQUIRE(std::sscanf(lines.str().c_str() + start.size(), "%lf,%lf,%lf,", &t, &re, &im) == 3);
  CHECK(Complex(re, im) == y[0]);
  CHECK(std::abs(y[0] - (1.0 + 0.5i) / (1.0 - 0.5i)) < 1e-14);  // the trapezoidal rule's step of 1
}

TEST_CASE("complex states: on a failure every bit stays, and a size that changes is followed") {
  Eigen::VectorXcd y{{1.0 + 1i, 2.0}};
  bool fails = true;
  PhiStepper stepper{y,
                     [&fails](const Eigen::VectorXcd& z) -> Eigen::VectorXcd {
                       return fails ? Eigen::VectorXcd(z * std::numeric_limits<double>::quiet_NaN())
                                    : Eigen::VectorXcd(1i * z);
                     },
                     phistep::backward_euler};
  const Eigen::VectorXcd before = y;
  CHECK(stepper.step(y, 0.0, 0.1).outcome() == phistep::Outcome::non_finite_force);
  CHECK(y == before);
  fails = false;
  y = Eigen::VectorXcd::Ones(3);
  REQUIRE(stepper.step(y, 0.0, 0.1));
  CHECK((y - Eigen::VectorXcd::Constant(3, 1.0 / (1.0 - 0.1i))).norm() < 1e-15);
}

#elif PHISTEP_FULL

TEST_CASE("complex states: integrate without a stepper chooses") {
  const Eigen::MatrixXcd H = chain(6);
  Eigen::VectorXcd chosen = start(6);
  REQUIRE(phistep::integrate(chosen, Schroedinger{H}, {0.0, 2.0}, tight));
  CHECK((chosen - exact(H, start(6), 2)).norm() < 1e-7);
}

TEST_CASE("complex states: a force that isn't analytic has its whole Jacobian") {
  // ψ' = −i|ψ|²ψ turns each number by its own |ψ|²
  const auto turn = [](const Eigen::VectorXcd& psi) -> Eigen::VectorXcd {
    return -1i * psi.cwiseAbs2().cast<Complex>().cwiseProduct(psi);
  };
  const Eigen::VectorXcd first{{Complex{1, 0.5}, Complex{-0.3, 2}, Complex{0, 0.7}}};
  Eigen::VectorXcd psi = first;
  PhiStepper stepper{psi, turn, phistep::trapezoidal};
  const auto report = integrate(stepper, psi, {0.0, 1.0}, fixed(1e-3));
  REQUIRE(report);
  for (Eigen::Index k = 0; k < 3; ++k) {
    CHECK(std::abs(psi[k] - first[k] * std::exp(-1i * std::norm(first[k]))) < 3e-5);
    CHECK(std::abs(std::abs(psi[k]) - std::abs(first[k])) < 1e-12);
  }

  // y' = −10⁴ Re y, by one step: M y = y0 would need a Jacobian of no complex number
  Eigen::Vector2cd y{1.0 + 1i, 2.0 - 1i};
  PhiStepper stiff{y, [](const Eigen::Vector2cd& z) -> Eigen::Vector2cd { return -1e4 * z.real().cast<Complex>(); },
                   phistep::backward_euler};
  REQUIRE(stiff.step(y, 0.0, 1.0));
  CHECK((y - Eigen::Vector2cd{1.0 / 10001 + 1i, 2.0 / 10001 - 1i}).norm() < 1e-12);
  CHECK(stiff.statistics().iterations <= 3);
}

TEST_CASE("complex states: a Jacobian of their own is taken, dense or sparse") {
  const Eigen::MatrixXcd H = chain(6);
  const auto run = [&](auto force) {
    Eigen::VectorXcd psi = start(6);
    PhiStepper stepper{psi, force, phistep::rodas5p};
    REQUIRE(integrate(stepper, psi, {0.0, 2.0}, tight));
    CHECK((psi - exact(H, start(6), 2)).norm() < 1e-7);
    return stepper.statistics();
  };
  const auto by_differences = run(Schroedinger{H}), dense = run(WithJacobian{{H}}), sparse = run(WithSparse{{H}});
  REQUIRE(dense.jacobians > 0);
  CHECK(by_differences.force_calls == dense.force_calls + 12 * dense.jacobians);
  CHECK(sparse.jacobians == dense.jacobians);
  CHECK(sparse.force_calls == dense.force_calls);
}

TEST_CASE("complex states: matrices, rows, Maps, small ones, motions") {
  const auto spin = [](const auto& y, double /*t*/) { return std::decay_t<decltype(y)>(1i * y); };
  const auto turned = [&](auto y) {
    const auto first = y;
    PhiStepper stepper{y, spin, phistep::tsit5};
    REQUIRE(integrate(stepper, y, {0.0, 1.0}, tight));
    CHECK((y - first * std::exp(1i)).norm() < 1e-7);
  };
  turned(Eigen::Vector2cd{1.0 + 2i, -0.5i});
  turned(Eigen::MatrixXcd{{1.0 + 2i, -0.5i, 3}, {0.1, 0.2i, 1i}});
  turned(Eigen::Matrix<Complex, 2, 3, Eigen::RowMajor>{{1.0 + 2i, -0.5i, 3}, {0.1, 0.2i, 1i}});
  turned(Eigen::RowVectorXcd{{1.0 + 2i, -0.5i, 3}});
  turned(Eigen::Matrix<Complex, 1, 1>{1.0 + 2i});

  std::vector<Complex> memory{1.0 + 2i, 7, -0.5i, 8};
  Eigen::Map<Eigen::VectorXcd, 0, Eigen::InnerStride<2>> every_other{memory.data(), 2};
  PhiStepper in_place{every_other, [](const Eigen::VectorXcd& y) -> Eigen::VectorXcd { return 1i * y; },
                      phistep::tsit5};
  REQUIRE(integrate(in_place, every_other, {0.0, 1.0}, tight));
  CHECK(std::abs(memory[0] - (1.0 + 2i) * std::exp(1i)) < 1e-7);
  CHECK(memory[1] == 7.0);
  CHECK(std::abs(memory[2] + 0.5i * std::exp(1i)) < 1e-7);
  CHECK(memory[3] == 8.0);
  Eigen::Map<Eigen::VectorXcd, 0, Eigen::InnerStride<>> one_place{memory.data(), 2, Eigen::InnerStride<>(0)};
  CHECK_THROWS_AS(
      (PhiStepper{one_place, [](const Eigen::VectorXcd& y) -> Eigen::VectorXcd { return y; }, phistep::tsit5}),
      std::invalid_argument);

  // r'' = −4r, each part a spring of its own; with a drag, too
  phistep::Motion swing{Eigen::Vector2cd{1.0 + 1i, 2i}, Eigen::Vector2cd{0.0, 2.0}};
  PhiStepper verlet{swing, [](const Eigen::Vector2cd& r) -> Eigen::Vector2cd { return -4.0 * r; },
                    phistep::velocity_verlet};
  REQUIRE(integrate(verlet, swing, {0.0, std::numbers::pi}, fixed(std::numbers::pi / 2000)));
  CHECK((swing.r - Eigen::Vector2cd{1.0 + 1i, 2i}).norm() < 2e-5);
  phistep::Motion damped{Eigen::Vector2cd{1.0 + 1i, 2i}, Eigen::Vector2cd{0.0, 0.0}};
  PhiStepper implicit{
      damped, [](const Eigen::Vector2cd& r, const Eigen::Vector2cd& v) -> Eigen::Vector2cd { return -r - 2.0 * v; },
      phistep::radau};
  REQUIRE(integrate(implicit, damped, {0.0, 1.0}, tight));
  CHECK((damped.r - Eigen::Vector2cd{1.0 + 1i, 2i} * 2.0 * std::exp(-1.0)).norm() < 1e-7);
}

TEST_CASE("numbers with derivatives: the gradient of a run is that of the complex step, to 1e-12") {
  constexpr int n = 3;
  using Dual = Eigen::AutoDiffScalar<Eigen::Vector2d>;
  using Duals = Eigen::Matrix<Dual, n, 1>;
  const Eigen::Vector3d from{1, 0.5, 2};
  const auto gradient_of = [&](auto scheme, const auto& control) {
    Duals y;
    for (int k = 0; k < n; ++k) y[k] = from[k];
    y[0].derivatives() = Eigen::Vector2d{1, 0};
    y[2].derivatives() = Eigen::Vector2d{0, 1};
    PhiStepper stepper{y, [](const Duals& z) { return reactions(z); }, scheme};
    REQUIRE(integrate(stepper, y, {0.0, 1.0}, control));
    Eigen::Matrix<double, n, 2> all;
    for (int k = 0; k < n; ++k) all.row(k) = y[k].derivatives();
    return all;
  };
  const auto by_complex_step = [&](auto scheme, const auto& control) {
    Eigen::Matrix<double, n, 2> all;
    for (int p = 0; p < 2; ++p) {
      Eigen::Vector3cd y = from.cast<Complex>();
      y[2 * p] += 1e-30i;
      PhiStepper stepper{y, [](const Eigen::Vector3cd& z) { return reactions(z); }, scheme};
      REQUIRE(integrate(stepper, y, {0.0, 1.0}, control));
      all.col(p) = y.imag() / 1e-30;
    }
    return all;
  };
  const auto agree = [&](auto scheme) {
    const Eigen::Matrix<double, n, 2> a = gradient_of(scheme, fixed(0.05)), b = by_complex_step(scheme, fixed(0.05));
    CHECK((a - b).cwiseAbs().maxCoeff() < 1e-12 * a.cwiseAbs().maxCoeff());
  };
  agree(phistep::tsit5);
  agree(phistep::backward_euler);
  agree(phistep::tr_bdf2);
  agree(phistep::rodas4p2);
}

TEST_CASE("numbers with derivatives: where a planet comes to, by its first velocity") {
  using Dual = Eigen::AutoDiffScalar<Eigen::Vector2d>;
  const auto pull = []<class Vector>(const Vector& r) -> Vector {
    using std::sqrt;
    const auto square = r[0] * r[0] + r[1] * r[1];
    const typename Vector::Scalar cube = square * sqrt(square);
    return Vector{-r[0] / cube, -r[1] / cube};
  };
  const auto end_from = [&]<class Number>(Number vx, Number vy) {
    using Vector = Eigen::Matrix<Number, 2, 1>;
    phistep::Motion y{Vector{Number(1.0), Number(0.0)}, Vector{vx, vy}};
    PhiStepper stepper{y, pull, phistep::velocity_verlet};
    REQUIRE(integrate(stepper, y, {0.0, 3.0}, fixed(0.01)));
    return y.r;
  };
  const auto r = end_from(Dual(0.1, Eigen::Vector2d{1, 0}), Dual(0.9, Eigen::Vector2d{0, 1}));
  const Eigen::Vector2cd by_x = end_from(Complex{0.1, 1e-30}, Complex{0.9, 0});
  const Eigen::Vector2cd by_y = end_from(Complex{0.1, 0}, Complex{0.9, 1e-30});
  for (int k = 0; k < 2; ++k) {
    CHECK(std::abs(r[k].derivatives()[0] - by_x[k].imag() / 1e-30) < 1e-12);
    CHECK(std::abs(r[k].derivatives()[1] - by_y[k].imag() / 1e-30) < 1e-12);
  }
}

namespace {
/// Numbers of eight systems, side by side: a number type of a user's own.
struct Eight {
  std::array<double, 8> of{};
  Eight() = default;
  Eight(double x) { of.fill(x); }  // NOLINT(google-explicit-constructor): as numbers are
  template <class F>
  [[nodiscard]] static Eight each(F&& f) {
    Eight all;
    for (std::size_t l = 0; l < 8; ++l) all.of[l] = f(l);
    return all;
  }
  friend Eight operator+(const Eight& a, const Eight& b) {
    return each([&](auto l) { return a.of[l] + b.of[l]; });
  }
  friend Eight operator-(const Eight& a, const Eight& b) {
    return each([&](auto l) { return a.of[l] - b.of[l]; });
  }
  friend Eight operator*(const Eight& a, const Eight& b) {
    return each([&](auto l) { return a.of[l] * b.of[l]; });
  }
};
using Oscillators = Eigen::Matrix<Eight, 2, 1>;

/// Van der Pol's equation, μ a number or several.
template <class Vector, class Mu>
Vector relaxation(const Vector& y, const Mu& mu) {
  Vector rate;
  rate[0] = y[1];
  rate[1] = mu * (1.0 - y[0] * y[0]) * y[1] - y[0];
  return rate;
}
}  // namespace
template <>
struct Eigen::NumTraits<Eight> : Eigen::GenericNumTraits<Eight> {};
template <>
struct phistep::NumberParts<Eight> {
  using Real = double;
  static constexpr int count = 8;
  static auto& part(auto& x, Eigen::Index p) { return x.of[static_cast<std::size_t>(p)]; }
};

TEST_CASE("numbers of a user's own: eight systems side by side, each as if it were alone") {
  const Eight mu = Eight::each([](auto l) { return 0.5 * static_cast<double>(l); });
  const auto together = [&](auto scheme) {
    Oscillators y{Eight{2}, Eight{0}};
    PhiStepper stepper{y, [&](const Oscillators& z) { return relaxation(z, mu); }, scheme};
    REQUIRE(integrate(stepper, y, {0.0, 5.0}, fixed(0.05)));
    for (std::size_t l = 0; l < 8; ++l) {
      Eigen::Vector2d alone{2, 0};
      PhiStepper one{alone, [&](const Eigen::Vector2d& z) { return relaxation(z, mu.of[l]); }, scheme};
      REQUIRE(integrate(one, alone, {0.0, 5.0}, fixed(0.05)));
      CHECK(std::abs(y[0].of[l] - alone[0]) < 1e-10);
      CHECK(std::abs(y[1].of[l] - alone[1]) < 1e-10);
    }
  };
  together(phistep::trapezoidal);
  together(phistep::rodas4p2);
}

#endif
