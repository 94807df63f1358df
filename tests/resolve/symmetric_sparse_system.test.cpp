// Symmetric sparse tangents: LDLᵀ where W is definite, LU where it isn't, and a promise that is checked.
#include <phistep/sparse.hpp>

#include <cmath>
#include <cstdlib>

#include "contract/states.hpp"
#include "problems/spring_net.hpp"
#include "support/catch.hpp"

using namespace phistep;
using problems::SpringNet;
using states::same_bits;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;
using Sparse = Eigen::SparseMatrix<double>;

namespace {

/// y' = A y
struct Linear {
  Sparse A;
  Vec operator()(const Vec& y) const { return A * y; }
  [[nodiscard]] const Sparse& jacobian(const Vec&) const { return A; }
};
Linear linear(const Mat& A) { return {A.sparseView()}; }

Vec wave(Eigen::Index n) { return Vec::LinSpaced(n, 0, 7).array().sin(); }

bool same_motion(const Motion<Vec>& a, const Motion<Vec>& b) { return same_bits(a.r, b.r) && same_bits(a.v, b.v); }

/// A square of springs pressed to 0.6 of their lengths: across the springs it wants to buckle.
Motion<Vec> pressed() {
  auto y = SpringNet::start();
  y.r *= 0.6;
  return y;
}

template <class State>
Statistics steps(State& y, auto force, auto scheme, int count, double dt, const auto&... more) {
  PhiStepper stepper{y, force, scheme, more...};
  for (int k = 0; k < count; ++k) {
    const StepReport report = stepper.step(y, dt * k, dt);
    INFO(report.message());
    REQUIRE(report);
  }
  return stepper.statistics();
}

/// A network whose tangent is wanted as a matrix, entry by entry.
template <class Net>
struct ByEntries : Net {
  static constexpr Structure structure = Structure::sparse;
  static constexpr bool has_edges = false, is_symmetric = false;
  explicit ByEntries(Net net) : Net(std::move(net)) {}
};
template <class Net>
ByEntries<Net> by_entries(Net net) {
  return ByEntries<Net>{std::move(net)};
}

/// One step that must fail so, and leave every bit.
void must_fail(Outcome expected, Motion<Vec> y, auto force, auto scheme, double dt) {
  PhiStepper stepper{y, force, scheme, mass(SpringNet::masses())};
  const Motion<Vec> before = y;
  const StepReport report = stepper.step(y, 0, dt);
  INFO(report.message());
  CHECK(report.outcome() == expected);
  CHECK(same_motion(y, before));
}
void must_fail(Outcome expected, const Mat& A) {
  Vec y = wave(A.rows());
  const Vec before = y;
  PhiStepper stepper{y, symmetric(linear(A)), backward_euler};
  const StepReport report = stepper.step(y, 0, 1);
  INFO(report.message());
  CHECK(report.outcome() == expected);
  CHECK(same_bits(y, before));
}

}  // namespace

TEST_CASE("a stretched net: definite, no fallback, the same steps as by LU") {
  auto by_ldlt = SpringNet::start(), by_lu = by_ldlt;
  const auto masses = mass(SpringNet::masses());
  const Statistics s = steps(by_ldlt, symmetric(by_entries(SpringNet::elastic())), trapezoidal, 20, 0.05, masses);
  const Statistics lu = steps(by_lu, by_entries(SpringNet::elastic()), trapezoidal, 20, 0.05, masses);
  CHECK(s.fallbacks == 0);
  CHECK(s.analyses == 1);
  CHECK(s.iterations == lu.iterations);
  // Both iterate to rounding: a few units in the last place of a state of size 3 in each step.
  CHECK((by_ldlt.r - by_lu.r).cwiseAbs().maxCoeff() <= 20 * 8 * 3 * 2.3e-16);
}

TEST_CASE("a compressed net in a long step: indefinite matrices are solved by LU, and counted") {
  auto by_ldlt = pressed(), by_lu = by_ldlt;
  const auto masses = mass(SpringNet::masses());
  PhiStepper stepper{by_ldlt, symmetric(by_entries(SpringNet::elastic())), backward_euler, masses};
  PhiStepper reference{by_lu, by_entries(SpringNet::elastic()), backward_euler, masses};
  const StepReport report = stepper.step(by_ldlt, 0, 0.6), expected = reference.step(by_lu, 0, 0.6);
  INFO(report.message() << "\n" << expected.message());
  REQUIRE(expected);
  REQUIRE(report);
  CHECK(stepper.statistics().fallbacks > 0);
  CHECK(stepper.statistics().analyses == 2);  // one for each of the two solvers
  CHECK(stepper.statistics().iterations == reference.statistics().iterations);
  CHECK((by_ldlt.r - by_lu.r).cwiseAbs().maxCoeff() <= 1e-13);
  // The same net in a short step is definite again: LDLᵀ serves.
  const std::int64_t fallbacks = stepper.statistics().fallbacks;
  REQUIRE(stepper.step(by_ldlt, 0.6, 1e-3));
  CHECK(stepper.statistics().fallbacks == fallbacks);
  CHECK(stepper.statistics().analyses == 2);
}

TEST_CASE("who names SimplicialLDLT gets it, and is told that the matrix is indefinite") {
  auto y = pressed();
  const auto before = y;
  PhiStepper stepper{y, symmetric(by_entries(SpringNet::elastic())), backward_euler, mass(SpringNet::masses()),
                     newton<Eigen::SimplicialLDLT<Sparse>>()};
  CHECK(stepper.step(y, 0, 0.6).outcome() == Outcome::not_positive_definite);
  CHECK(stepper.statistics().fallbacks == 0);
  CHECK(same_motion(y, before));
}

TEST_CASE("an indefinite linear system is solved exactly, whatever the sign of its pivots") {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::srand(seed);
    constexpr int n = 15;
    Mat A = Mat::Random(n, n);
    A = (A.array().abs() < 0.6).select(0, A).eval();
    A = (A + A.transpose()).eval() * 3;
    Vec y = wave(n);
    const Vec b = y;
    const Mat W = Mat::Identity(n, n) - A;
    const Statistics s = steps(y, symmetric(linear(A)), backward_euler, 1, 1.0);
    CAPTURE(seed);
    CHECK(s.fallbacks == s.factorizations);
    CHECK((W * y - b).norm() <= 1e-13 * W.norm() * y.norm());
  }
}

TEST_CASE("a zero on the diagonal is no reason to fail") {
  // W = [0 1; 1 0]: LDLᵀ without pivoting has none, the matrix is as regular as can be.
  Vec y = Eigen::Vector2d(3, 5);
  const Statistics s = steps(y, symmetric(linear((Mat(2, 2) << 1, -1, -1, 1).finished())), backward_euler, 1, 1.0);
  CHECK(y == Eigen::Vector2d(5, 3));
  CHECK(s.fallbacks == 1);
}

TEST_CASE("singular: 1 = γz in every component, in one, and in a combination") {
  must_fail(Outcome::singular_matrix, Mat::Identity(3, 3));
  must_fail(Outcome::singular_matrix, Vec(Eigen::Vector3d(-1, 1, -2)).asDiagonal());
  must_fail(Outcome::singular_matrix, Mat::Constant(2, 2, 0.5));  // W = [½ −½; −½ ½]
}

TEST_CASE("a matrix singular but for rounding never passes for a solution") {
  // A = v vᵀ/|v|² has the eigenvalue 1 up to rounding, so W = 1 − A none but rounding along v.
  for (unsigned seed = 1; seed <= 50; ++seed) {
    std::srand(seed);
    const Vec v = Vec::Random(6);
    Vec y = wave(6);
    const Vec before = y;
    const Mat A = v * v.transpose() / v.squaredNorm();
    PhiStepper stepper{y, symmetric(linear(A)), backward_euler};
    const StepReport report = stepper.step(y, 0, 1);
    CAPTURE(seed, report.message());
    if (report) CHECK(((Mat::Identity(6, 6) - A) * y - before).norm() <= 1e-14 * y.norm());
    else CHECK(same_bits(y, before));
  }
}

TEST_CASE("a tangent that isn't symmetric is named: one entry, a missing triangle, dashpots in motion") {
  Mat A = -4 * Mat::Identity(5, 5);
  A.diagonal(1).setConstant(1), A.diagonal(-1).setConstant(1);
  must_fail(Outcome::not_symmetric, [&] {
    Mat B = A;
    B(3, 2) += 1e-9;
    return B;
  }());
  must_fail(Outcome::not_symmetric, [&] {
    Mat B = A;
    B(0, 4) = 0.5;  // whose transpose has no entry
    return B;
  }());
  must_fail(Outcome::not_symmetric, Mat(A.triangularView<Eigen::Lower>()));
  must_fail(Outcome::not_symmetric, SpringNet::start(), symmetric(by_entries(SpringNet::damped())), backward_euler,
            0.1);
  Vec y = wave(5);
  CHECK(PhiStepper{y, symmetric(linear(A)), backward_euler}.step(y, 0, 1));
}

TEST_CASE("rounding doesn't break the promise") {
  Mat A = -4 * Mat::Identity(5, 5);
  A.diagonal(1).setConstant(1), A.diagonal(-1).setConstant(1 + 4e-16);
  A(0, 4) = 1e-15;
  Vec y = wave(5);
  CHECK(steps(y, symmetric(linear(A)), backward_euler, 1, 1.0).fallbacks == 0);
}

TEST_CASE("differences: symmetric to their accuracy, and still refused where the promise is broken") {
  constexpr int n = 400;
  Sparse tridiagonal(n, n);
  for (int j = 0; j < n; ++j)
    for (int i = std::max(0, j - 1); i < std::min(n, j + 2); ++i) tridiagonal.insert(i, j) = 1;
  const auto chain = [](const Vec& r) -> Vec {
    Vec force = Vec::Zero(r.size());
    for (Eigen::Index i = 0; i + 1 < r.size(); ++i) {
      const double stretch = r[i + 1] - r[i], f = stretch + 40 * stretch * stretch * stretch;
      force[i] += f;
      force[i + 1] -= f;
    }
    return force;
  };
  const Motion<Vec> start{10 * wave(n), Vec::Zero(n)};
  auto by_ldlt = start, by_lu = start;
  const Statistics s = steps(by_ldlt, symmetric(sparsity(chain, tridiagonal)), trapezoidal, 5, 0.1);
  const Statistics lu = steps(by_lu, sparsity(chain, tridiagonal), trapezoidal, 5, 0.1);
  CHECK(s.fallbacks == 0);
  CHECK(s.analyses == 1);
  CHECK(s.force_calls == 5 + s.iterations + 3 * s.jacobians);
  CHECK(s.iterations == lu.iterations);
  CHECK((by_ldlt.r - by_lu.r).cwiseAbs().maxCoeff() <= 5 * 8 * 10 * 2.3e-16);

  const auto skewed = [chain](const Vec& r) -> Vec {
    Vec force = chain(r);
    force[7] += 0.05 * r[8];
    return force;
  };
  Motion<Vec> y = start;
  PhiStepper stepper{y, symmetric(sparsity(skewed, tridiagonal)), trapezoidal};
  CHECK(stepper.step(y, 0, 1).outcome() == Outcome::not_symmetric);
  CHECK(same_motion(y, start));
}

TEST_CASE("a pattern that changes is analysed again, one that doesn't is not") {
  /// Every second neighbour couples where `reach` says so.
  struct Coupled {
    int reach;
    Vec operator()(const Vec& y) const { return jacobian(y) * y; }
    [[nodiscard]] Sparse jacobian(const Vec& y) const {
      const int n = static_cast<int>(y.size());
      Sparse A(n, n);
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i)
          if (std::abs(i - j) <= reach) A.insert(i, j) = i == j ? -8 - y[0] * y[0] : 1;
      return A;
    }
  };
  const auto check = [](auto wrap) {
    Vec y = wave(30);
    PhiStepper stepper{y, wrap(Coupled{1}), backward_euler};
    std::int64_t analyses = 1;
    for (const int reach : {1, 2, 2, 1, 4}) {
      const int before = stepper.force().reach;
      stepper.force().reach = reach;
      analyses += reach != before;
      for (int k = 0; k < 4; ++k) REQUIRE(stepper.step(y, 0.1 * k, 0.1 + 0.01 * k));
      CHECK(stepper.statistics().analyses == analyses);
    }
    CHECK(analyses == 4);
    CHECK(stepper.statistics().jacobians >= 5);
    CHECK(stepper.statistics().factorizations >= 20);  // a new dt each time
  };
  check([](auto force) { return force; });
  // Not symmetric to the last digit of its own derivative, but of what jacobian() returns: that is what is promised.
  check([](auto force) { return symmetric(force); });
}

TEST_CASE("a copy of a stepper has solvers of its own, and goes on with the same digits") {
  auto y = SpringNet::start();
  PhiStepper stepper{y, symmetric(by_entries(SpringNet::elastic())), trapezoidal, mass(SpringNet::masses())};
  REQUIRE(stepper.step(y, 0, 0.05));
  auto copy = stepper;
  auto other = y;
  REQUIRE(copy.step(other, 0.05, 0.05));
  REQUIRE(stepper.step(y, 0.05, 0.05));
  CHECK((y.r - other.r).cwiseAbs().maxCoeff() <= 8 * 3 * 2.3e-16);
}
