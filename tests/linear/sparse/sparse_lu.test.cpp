// Sparse LU: as good as Eigen's with real numbers; with complex ones side by side, each lane as good as pivoted elimination
// of that matrix alone, in a band, too.
#include <phistep/linear/banded/banded_lu.hpp>
#include <phistep/linear/sparse/sparse_lu.hpp>

#include <Eigen/LU>
#include <Eigen/SparseLU>

#include <algorithm>
#include <cmath>
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
using Number = ComplexPack<double, lanes>;
/// With the values beside it.
struct Sparse : SparseLu<Number> {
  Pattern pattern;
  std::vector<Number> numbers;
  void analyze(const Pattern& A) {
    pattern = A;
    numbers.resize(static_cast<std::size_t>(A.nonZeros()));
    analyzePattern(pattern);
  }
  [[nodiscard]] std::vector<Number>& values() { return numbers; }
  [[nodiscard]] bool factorize() { return SparseLu<Number>::factorize(pattern, numbers.data()); }
};
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

namespace {

template <class Scalar>
using MatrixOf = Eigen::SparseMatrix<Scalar>;
template <class Scalar>
using VectorOf = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

/// n rows of up to `row` entries beside a diagonal of `own`, which has a slot though it be zero.
template <class Scalar>
[[nodiscard]] MatrixOf<Scalar> random_matrix(int n, int row, double own, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Eigen::Triplet<Scalar>> entries;
  for (int i = 0; i < n; ++i) {
    entries.emplace_back(i, i, static_cast<Scalar>(own));
    entries.emplace_back(i, (i + 1) % n, static_cast<Scalar>(2));  // regular with no diagonal, too
    for (int k = 1; k < row; ++k)
      entries.emplace_back(i, static_cast<int>(random() % static_cast<unsigned>(n)),
                           static_cast<Scalar>(uniform(random) / row));
  }
  MatrixOf<Scalar> A(n, n);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}
/// ‖A x − b‖∞ beside the sizes of its terms, row by row: it sees no scale.
template <class Scalar>
[[nodiscard]] double backward_error(const MatrixOf<Scalar>& A, auto&& solve) {
  const VectorOf<Scalar> b = A * VectorOf<Scalar>::LinSpaced(A.cols(), -1, 3);
  VectorOf<Scalar> x = b;
  solve(x);
  const VectorOf<Scalar> sizes = A.cwiseAbs() * x.cwiseAbs() + b.cwiseAbs();
  return static_cast<double>(
      ((A * x - b).array().abs() / sizes.array().max(std::numeric_limits<Scalar>::min())).maxCoeff());
}
template <class Scalar>
[[nodiscard]] double error_of_ours(const MatrixOf<Scalar>& A) {
  SparseLu<Scalar> lu;
  lu.analyzePattern(A);
  lu.factorize(A);
  REQUIRE(lu.info() == Eigen::Success);
  const double first = backward_error(A, [&](auto& x) { lu.solve_in_place(x); });
  lu.factorize(A);  // the same pivots
  REQUIRE(lu.info() == Eigen::Success);
  return std::max(first, backward_error(A, [&](auto& x) { lu.solve_in_place(x); }));
}
[[nodiscard]] double error_of_eigens(const Pattern& A) {
  Eigen::SparseLU<Pattern> lu(A);
  return backward_error(A, [&](auto& x) { x = lu.solve(x).eval(); });
}
[[nodiscard]] bool is_factorized(SparseLu<double>& lu, const Pattern& A) {
  lu.factorize(A);
  return lu.info() == Eigen::Success;
}
/// Rows and columns times powers of ten between 1e-8 and 1e8.
[[nodiscard]] Pattern badly_scaled(Pattern A, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> power(-8, 8);
  Eigen::VectorXd rows(A.rows()), columns(A.rows());
  for (double& r : rows) r = std::pow(10, power(random));
  for (double& c : columns) c = std::pow(10, power(random));
  A = rows.asDiagonal() * A * columns.asDiagonal();
  return A;
}
/// m × m points: diffusion and wind; `reversed` rows, so that hardly a pivot lies on the diagonal.
[[nodiscard]] Pattern field(int m, bool reversed) {
  const int n = m * m;
  std::vector<Eigen::Triplet<double>> entries;
  const auto put = [&](int i, int j, double x) { entries.emplace_back(reversed ? n - 1 - i : i, j, x); };
  for (int k = 0; k < n; ++k) {
    entries.emplace_back(k, k, 0);
    put(k, k, 5);
    if (k % m > 0) put(k, k - 1, -1.3);
    if (k % m + 1 < m) put(k, k + 1, -0.7);
    if (k >= m) put(k, k - m, -1);
    if (k + m < n) put(k, k + m, -1);
  }
  Pattern A(n, n);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}
/// Incompressible flow, say: A with m constraints of three unknowns each, which have no diagonal.
[[nodiscard]] Pattern constrained(Pattern A, int m) {
  const int n = static_cast<int>(A.cols());
  std::vector<Eigen::Triplet<double>> entries;
  for (int j = 0; j < n; ++j)
    for (Pattern::InnerIterator it(A, j); it; ++it) entries.emplace_back(it.row(), j, it.value());
  for (int k = 0; k < m; ++k)
    for (int l = 0; l < 3; ++l) {
      const int i = (k * n / m + l * l) % n;
      entries.emplace_back(n + k, i, 1 + l);
      entries.emplace_back(i, n + k, 1 - 0.3 * l);
      entries.emplace_back(n + k, n + k, 0);
    }
  Pattern B(n + m, n + m);
  B.setFromTriplets(entries.begin(), entries.end());
  return B;
}

}  // namespace

TEMPLATE_TEST_CASE("real matrices are solved to rounding, on the diagonal or off it", "", float, double, long double) {
  for (const int n : {1, 2, 7, 60, 200})
    for (const double own : {4.0, 0.5, 0.0})
      for (unsigned seed = 0; seed < 5; ++seed) {
        CAPTURE(n, own, seed);
        if (n == 2 && own == 0.5) continue;  // may be singular
        const double u = std::max(static_cast<double>(std::numeric_limits<TestType>::epsilon()), 1e-18);
        // Multipliers of 8, and 80 where pivots repeat, let entries grow by a few digits at most.
        CHECK(error_of_ours(random_matrix<TestType>(n, 4, own, seed)) <= 300 * u);
      }
}

TEST_CASE("as good as Eigen's LU on matrices of any scale, and with constraints") {
  for (const double own : {4.0, 1.0, 0.0}) {
    double plain = 0, scaled = 0, with = 0;  // mean digits that are lost
    const auto lost = [](const Pattern& A) {
      return std::log10((error_of_ours(A) + 1e-16) / (error_of_eigens(A) + 1e-16)) / 50;
    };
    for (unsigned seed = 0; seed < 50; ++seed) {
      const Pattern A = random_matrix<double>(80, 4, own, seed);
      plain += lost(A), scaled += lost(badly_scaled(A, seed)), with += lost(constrained(A, 25));
    }
    CAPTURE(own);
    CHECK(plain <= 0.7);  // multipliers of 2, one after the other, are what `own` = 1 was made for
    CHECK(scaled <= 0.5);
    CHECK(with <= 0.7);
  }
  const Pattern grid = field(16, false), upside_down = field(16, true), flow = constrained(grid, 100);
  for (const Pattern* each : {&grid, &upside_down, &flow}) CHECK(error_of_ours(*each) <= 5e-15);
}

TEST_CASE("the fill is no more than Eigen's, and less where the diagonal serves") {
  const auto fill = [](const Pattern& A) {
    SparseLu<double> lu;
    lu.analyzePattern(A);
    REQUIRE(is_factorized(lu, A));
    const std::size_t found = lu.fill();
    REQUIRE(is_factorized(lu, A));
    CHECK(lu.fill() == found);
    Eigen::SparseLU<Pattern> eigens(A);
    return static_cast<double>(found) / static_cast<double>(eigens.nnzL() + eigens.nnzU() - 2 * A.cols());
  };
  CHECK(fill(field(24, false)) <= 0.8);
  CHECK(fill(field(24, true)) <= 1.1);  // 2.3 in the order of W + Wᵀ
  CHECK(fill(constrained(field(16, false), 60)) <= 1.1);
}

TEST_CASE("what is singular, in its pattern or in its numbers, is told, NaN and infinity, too") {
  const Pattern good = random_matrix<double>(30, 3, 3, 1);
  SparseLu<double> lu;
  lu.analyzePattern(good);
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const auto check = [&](auto&& spoil) {
    CHECK(is_factorized(lu, good));
    Pattern bad = good;
    spoil(bad);
    CHECK_FALSE(is_factorized(lu, bad));
    CHECK_FALSE(is_factorized(lu, bad));  // nor by new pivots
    SparseLu<double> first;
    first.analyzePattern(bad);
    CHECK_FALSE(is_factorized(first, bad));
  };
  for (const double x : {0.0, nan, infinity}) {
    CAPTURE(x);
    check([x](Pattern& A) { A.coeffRef(17, 17) = 1, A.col(17) *= x; });
    check([x](Pattern& A) {
      for (Eigen::Index j = 0; j < A.cols(); ++j)
        for (Pattern::InnerIterator it(A, j); it; ++it)
          if (it.row() == 11) it.valueRef() *= x;
    });
  }
  check([](Pattern& A) { A *= 0.0; });
  // Two columns with entries in one row alone.
  std::vector<Eigen::Triplet<double>> entries{{0, 0, 1}, {1, 1, 1}, {2, 2, 0}, {3, 3, 0},
                                              {1, 2, 3}, {1, 3, 4}, {2, 0, 1}, {3, 1, 1}};
  Pattern A(4, 4);
  A.setFromTriplets(entries.begin(), entries.end());
  SparseLu<double> structurally;
  structurally.analyzePattern(A);
  CHECK_FALSE(is_factorized(structurally, A));
  CHECK(is_factorized(lu, good));
  CHECK(backward_error(good, [&](auto& x) { lu.solve_in_place(x); }) <= 1e-14);
}

TEST_CASE("one number that isn't finite spoils the factors or the solution, wherever it is") {
  const Pattern good = random_matrix<double>(12, 3, 3, 2);
  for (Eigen::Index p = 0; p < good.nonZeros(); ++p) {
    CAPTURE(p);
    Pattern bad = good;
    bad.valuePtr()[p] = std::numeric_limits<double>::quiet_NaN();
    SparseLu<double> lu;
    lu.analyzePattern(bad);
    Eigen::VectorXd x = Eigen::VectorXd::Ones(12);
    for (int repeats = 0; repeats < 2; ++repeats) {
      if (repeats == 1) REQUIRE(is_factorized(lu, good));
      const bool done = is_factorized(lu, bad);
      if (done) lu.solve_in_place(x);
      CHECK((!done || !x.allFinite()));
    }
  }
}

TEST_CASE("pivots that were good for other numbers are chosen again") {
  const Pattern A = random_matrix<double>(100, 4, 4, 7);
  SparseLu<double> lu;
  lu.analyzePattern(A);
  REQUIRE(is_factorized(lu, A));
  for (const double size : {1e-3, 1e-9, 0.0, 1.0}) {
    CAPTURE(size);
    Pattern B = A;
    for (int j = 0; j < 100; ++j) B.coeffRef(j, j) *= size;
    REQUIRE(is_factorized(lu, B));
    CHECK(backward_error(B, [&](auto& x) { lu.solve_in_place(x); }) <= 1e-13);
  }
}
