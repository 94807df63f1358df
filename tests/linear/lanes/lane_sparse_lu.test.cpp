// Complex band and sparse matrices side by side: each lane as good as pivoted elimination of that matrix alone.
#include <phistep/linear/banded/banded_lu.hpp>
#include <phistep/linear/lanes/lane_sparse_lu.hpp>

#include <Eigen/LU>

#include <complex>
#include <limits>
#include <random>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace {

constexpr int lanes = 4;
using Complex = std::complex<double>;
using Dense = Eigen::MatrixXcd;
using Pattern = Eigen::SparseMatrix<double>;
using Sparse = LaneSparseLu<double, lanes>;
using Number = Sparse::Number;
using Banded = BandedLu<Number>;

[[nodiscard]] Number pack(const auto& of) {
  double re[lanes], im[lanes];
  for (int l = 0; l < lanes; ++l) re[l] = of(l).real(), im[l] = of(l).imag();
  return {Number::Real::load(re), Number::Real::load(im)};
}

/// λ_l − J by lanes, with one pattern. @param dominance  what the diagonal has more than the rest
struct Matrices {
  Pattern J;
  std::vector<Dense> W;
  Matrices(int n, int band, double density, double dominance, unsigned seed) : J(n, n), W(lanes, Dense::Zero(n, n)) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1), chance(0, 1);
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < n; ++i)
      for (int j = std::max(0, i - band); j <= std::min(n - 1, i + band); ++j)
        if (i == j || chance(random) < density) entries.emplace_back(i, j, uniform(random));
    J.setFromTriplets(entries.begin(), entries.end());
    J.makeCompressed();
    for (int l = 0; l < lanes; ++l) {
      W[static_cast<std::size_t>(l)] = -Dense(J.cast<Complex>());
      for (int i = 0; i < n; ++i)
        W[static_cast<std::size_t>(l)](i, i) += dominance * Complex(3 + l, 2 * l) + Complex(0.1, 0.05 * l);
    }
  }
  [[nodiscard]] Number at(Eigen::Index i, Eigen::Index j) const {
    return pack([&](int l) { return W[static_cast<std::size_t>(l)](i, j); });
  }
  void put(Sparse& lu) const {
    std::size_t p = 0;
    for (int j = 0; j < J.cols(); ++j)
      for (Pattern::InnerIterator it(J, j); it; ++it) lu.values()[p++] = at(it.row(), j);
  }
  void put(Banded& lu) const {
    lu.clear();
    for (int j = 0; j < J.cols(); ++j)
      for (Pattern::InnerIterator it(J, j); it; ++it) lu.column(j)[it.row() - j] = at(it.row(), j);
  }
  /// ‖W x − b‖ beside ‖W‖‖x‖, the worst lane.
  [[nodiscard]] double residual(auto& lu) const {
    const auto n = J.cols();
    std::vector<Number> x;
    for (int i = 0; i < n; ++i) x.push_back(pack([&](int l) { return Complex(1 + i % 3, l - i % 2); }));
    lu.solve_in_place(x);
    double worst = 0;
    for (int l = 0; l < lanes; ++l) {
      Eigen::VectorXcd y(n), b(n);
      for (int i = 0; i < n; ++i) {
        y[i] = {x[static_cast<std::size_t>(i)].re[l], x[static_cast<std::size_t>(i)].im[l]};
        b[i] = Complex(1 + i % 3, l - i % 2);
      }
      const Dense& A = W[static_cast<std::size_t>(l)];
      worst = std::max(worst, (A * y - b).norm() / (A.norm() * y.norm()));
    }
    return worst;
  }
};

}  // namespace

TEST_CASE("bands and sparse matrices are solved to rounding, in every lane, whatever the pivots") {
  for (const int n : {1, 2, 7, 60})
    for (const double dominance : {2.0, 0.0})  // 0: rows have to change places
      for (unsigned seed = 0; seed < 5; ++seed) {
        CAPTURE(n, dominance, seed);
        const Matrices band(n, 3, 0.8, dominance, seed), sparse(n, n, std::min(1.0, 4.0 / n), dominance, seed + 9);
        Banded by_band;
        by_band.resize(n, 3, 3);
        band.put(by_band);
        REQUIRE(by_band.factorize());
        // Multipliers up to 8 let entries grow: a few digits at most, in practice none.
        CHECK(band.residual(by_band) <= 1e-13);
        for (const Matrices* of : {&band, &sparse}) {
          Sparse lu;
          lu.analyze(of->J);
          of->put(lu);
          REQUIRE(lu.factorize());
          CHECK(of->residual(lu) <= 1e-13);
          CHECK(of->residual(lu) <= 1e-13);
        }
      }
}

TEST_CASE("a second factorization takes the first one's pivots, or new ones where these can't be trusted") {
  const Matrices first(60, 60, 0.07, 2.0, 3);
  Sparse lu;
  lu.analyze(first.J);
  first.put(lu);
  REQUIRE(lu.factorize());
  const auto fill = lu.fill();
  Matrices second = first;
  for (Dense& W : second.W) W *= Complex(0.5, 0.1);
  second.put(lu);
  REQUIRE(lu.factorize());
  CHECK(lu.fill() == fill);
  CHECK(second.residual(lu) <= 1e-13);
  // The diagonal all but vanishes.
  for (Dense& W : second.W) W.diagonal().array() *= 1e-9;
  second.put(lu);
  REQUIRE(lu.factorize());
  CHECK(second.residual(lu) <= 1e-13);
}

TEST_CASE("a lane that is singular, infinite or NaN is told, and the next matrix is solved again") {
  const Matrices good(9, 2, 1, 2.0, 1);
  for (int l = 0; l < lanes; ++l)
    for (const double bad : {0.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
      CAPTURE(l, bad);
      Matrices W = good;
      for (int i = 0; i < 9; ++i)
        if (W.J.coeff(i, 4) != 0) W.W[static_cast<std::size_t>(l)](i, 4) = bad;
      Banded band;
      band.resize(9, 2, 2);
      W.put(band);
      CHECK_FALSE(band.factorize());
      Sparse sparse;
      sparse.analyze(W.J);
      good.put(sparse);
      CHECK(sparse.factorize());
      W.put(sparse);
      CHECK_FALSE(sparse.factorize());
      good.put(sparse);
      CHECK(sparse.factorize());
      CHECK(good.residual(sparse) <= 1e-13);
    }
}

TEST_CASE("a grid's fill is that of a symmetric ordering") {
  const int m = 20, n = m * m;
  std::vector<Eigen::Triplet<double>> entries;
  for (int k = 0; k < n; ++k) {
    entries.emplace_back(k, k, 1);
    if (k % m > 0) entries.emplace_back(k, k - 1, 1);
    if (k % m + 1 < m) entries.emplace_back(k, k + 1, 1);
    if (k >= m) entries.emplace_back(k, k - m, 1);
    if (k + m < n) entries.emplace_back(k, k + m, 1);
  }
  Pattern grid(n, n);
  grid.setFromTriplets(entries.begin(), entries.end());
  Sparse lu;
  lu.analyze(grid);
  for (int j = 0, p = 0; j < n; ++j)
    for (Pattern::InnerIterator it(grid, j); it; ++it, ++p)
      lu.values()[static_cast<std::size_t>(p)] =
          pack([&](int l) { return it.row() == j ? Complex(4 + l, l) : Complex(-1, 0); });
  REQUIRE(lu.factorize());
  // Column by column, both triangles of the band would have 2·20·400.
  CHECK(lu.fill() <= 8000);
}
