// Four complex matrices at once: each lane as good as pivoted elimination of that matrix alone.
#include <phistep/linear/banded/banded_lu.hpp>
#include <phistep/linear/lanes/complex_pack.hpp>

#include <Eigen/Core>
#include <Eigen/LU>

#include <cmath>
#include <complex>
#include <limits>
#include <random>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace complex_pack_cases {

inline constexpr int lanes = 4;
using Complex = std::complex<long double>;
using Matrix = Eigen::Matrix<Complex, Eigen::Dynamic, Eigen::Dynamic>;

/// λ_l M − J, as the lanes have it: M = 1 but where `permuted`, whose pivots lie off the diagonal.
inline std::vector<Matrix> shifted(int n, unsigned seed, bool sparse, bool permuted) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Eigen::MatrixXd J(n, n), M = Eigen::MatrixXd::Identity(n, n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) J(i, j) = sparse && uniform(random) < 0.5 ? 0 : uniform(random);
  if (permuted) {
    for (int i = 0; i < n; ++i) J.col(i).swap(J.col((i + 1) % n));
    for (int i = 0; i < n; ++i) J(i, (i + 1) % n) += 2 * n;
  }
  std::vector<Matrix> all;
  for (int l = 0; l < lanes; ++l) {
    const Complex lambda{3.0L + l, 2.0L * l};
    all.push_back((permuted ? Complex{0.01L} : lambda) * M.cast<Complex>() - J.cast<Complex>());
  }
  return all;
}

template <class Scalar>
using Number = ComplexPack<Scalar, lanes>;

template <class Scalar>
void fill(BandedLu<Number<Scalar>>& lu, const std::vector<Matrix>& W) {
  using Real = typename Number<Scalar>::Real;
  const int n = static_cast<int>(W[0].rows());
  lu.resize(n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      Scalar re[lanes], im[lanes];
      for (int l = 0; l < lanes; ++l) {
        const auto k = static_cast<std::size_t>(l);
        re[l] = static_cast<Scalar>(W[k](i, j).real());
        im[l] = static_cast<Scalar>(W[k](i, j).imag());
      }
      lu.column(j)[i - j] = {Real::load(re), Real::load(im)};
    }
}

template <class Scalar>
void check(int n) {
  CAPTURE(n, sizeof(Scalar));
  using Real = typename Number<Scalar>::Real;
  BandedLu<Number<Scalar>> lu;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const auto W = shifted(n, seed, seed % 3 == 1, seed % 4 == 2);
    fill(lu, W);
    REQUIRE(lu.factorize());
    std::vector<Number<Scalar>> x(static_cast<std::size_t>(n));
    std::vector<Eigen::Matrix<Complex, Eigen::Dynamic, 1>> b(lanes, Eigen::Matrix<Complex, Eigen::Dynamic, 1>(n));
    for (int i = 0; i < n; ++i) {
      Scalar re[lanes], im[lanes];
      for (int l = 0; l < lanes; ++l) {
        re[l] = static_cast<Scalar>(std::sin(1.0 + i + 3 * l));
        im[l] = static_cast<Scalar>(std::cos(2.0 * i - l));
        b[static_cast<std::size_t>(l)][i] = Complex{re[l], im[l]};
      }
      x[static_cast<std::size_t>(i)] = {Real::load(re), Real::load(im)};
    }
    lu.solve_in_place(x);
    for (int l = 0; l < lanes; ++l) {
      const auto k = static_cast<std::size_t>(l);
      Eigen::Matrix<Complex, Eigen::Dynamic, 1> found(n);
      for (int i = 0; i < n; ++i)
        found[i] = Complex{x[static_cast<std::size_t>(i)].re[l], x[static_cast<std::size_t>(i)].im[l]};
      // Shared exchanges and multipliers up to 8 cost a factor of growth.
      const long double size_of = W[k].norm() * found.norm() + b[k].norm();
      const long double u = std::max(static_cast<long double>(std::numeric_limits<Scalar>::epsilon()), 1e-19L);
      CAPTURE(seed, l);
      CHECK((W[k] * found - b[k]).norm() <= 100 * n * u * size_of);
    }
  }
}

}  // namespace complex_pack_cases

using namespace complex_pack_cases;

#if PHISTEP_QUICK

TEMPLATE_TEST_CASE("all lanes are solved to rounding", "", double) {
  for (const int n : {2, 7}) check<TestType>(n);
}

TEST_CASE("a lane that is singular, infinite or NaN is told, whichever it is") {
  for (const int n : {2, 9})
    for (int l = 0; l < lanes; ++l)
      for (const int kind : {0, 1, 2}) {
        CAPTURE(n, l, kind);
        auto W = shifted(n, 5, false, false);
        auto& one = W[static_cast<std::size_t>(l)];
        if (kind == 0) one.row(1) = one.row(0);
        if (kind == 1) one(1, 0) = std::numeric_limits<double>::infinity();
        if (kind == 2) one(1, 1) = std::numeric_limits<double>::quiet_NaN();
        BandedLu<Number<double>> lu;
        fill(lu, W);
        CHECK_FALSE((lu.factorize() && kind != 0));
      }
  // Exactly singular where elimination meets an exact zero.
  auto W = shifted(3, 1, false, false);
  W[2].setZero();
  BandedLu<Number<double>> lu;
  fill(lu, W);
  CHECK_FALSE(lu.factorize());
}

#elif PHISTEP_FULL

TEMPLATE_TEST_CASE("all lanes are solved to rounding", "", float, double, long double) {
  for (const int n : {1, 2, 3, 6, 7, 9, 20}) check<TestType>(n);
}

#endif
