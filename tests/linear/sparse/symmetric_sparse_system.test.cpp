// Symmetric matrices found by looking, behind steppers. Promised ones: the stress tier,
// symmetric_sparse_system_nets.stress.cpp.
#include <string>
#include <utility>
#if PHISTEP_FULL
#include <phistep/schemes/rosenbrock.hpp>
#include <phistep/sparse.hpp>

#include "problems/reaction_diffusion.hpp"
#include "support/catch.hpp"
#endif
#if PHISTEP_STRESS
#include "linear/sparse/symmetric_sparse_system_cases.hpp"
#endif

#if PHISTEP_FULL

using namespace phistep;
using namespace problems;
using Vec = Eigen::VectorXd;

namespace {

constexpr double dt = 2e-3;

struct Ended {
  Vec y;
  Statistics counts;
  std::string solver;
};
Ended steps(const ReactionDiffusion& problem, auto force, auto scheme, int count, auto... more) {
  Vec y = problem.start();
  PhiStepper stepper{y, force, scheme, more...};
  for (int k = 0; k < count; ++k) {
    const StepReport report = stepper.step(y, dt * k, dt);
    INFO(report.message());
    REQUIRE(report);
  }
  return {y, stepper.statistics(), stepper.solver_name()};
}
using Lu = Newton<Eigen::SparseLU<Eigen::SparseMatrix<double>>>;
double apart(const Vec& a, const Vec& b) { return (a - b).cwiseAbs().maxCoeff(); }

}  // namespace

TEST_CASE("a field whose Jacobian is symmetric is solved by LDLT, without a promise") {
  const ReactionDiffusion calm{.m = 12};
  const Ended lu = steps(calm, ReactionDiffusionTerm{calm}, trapezoidal, 10, Lu{});
  CHECK(lu.counts.factorizations > 1);
  const auto check = [&](const Ended& found, double tolerance) {
    CHECK(found.solver == "sparse LDLT, found symmetric");
    CHECK(found.counts.fallbacks == 0);
    CHECK(found.counts.analyses == 1);
    CHECK(apart(found.y, lu.y) <= tolerance);
  };
  SECTION("supplied: as with a promise, to the last bit") {
    const Ended found = steps(calm, ReactionDiffusionTerm{calm}, trapezoidal, 10);
    const Ended promised = steps(calm, symmetric(ReactionDiffusionTerm{calm}), trapezoidal, 10);
    check(found, 1e-14);
    CHECK(found.counts.factorizations == lu.counts.factorizations);
    CHECK(found.counts.iterations == lu.counts.iterations);
    CHECK((found.y.array() == promised.y.array()).all());
  }
  SECTION("by differences: iterations make up for what they are off") {
    const Ended found = steps(calm, sparsity(as_function(calm), calm.pattern()), trapezoidal, 10);
    check(found, 1e-14);
    CHECK(found.counts.iterations <= lu.counts.iterations + 2);
  }
  SECTION("linear stages, supplied") {
    const Ended found = steps(calm, ReactionDiffusionTerm{calm}, rodas4, 5);
    const Ended by_lu = steps(calm, ReactionDiffusionTerm{calm}, rodas4, 5, Lu{});
    CHECK(found.solver == "sparse LDLT, found symmetric");
    CHECK(found.counts.factorizations == by_lu.counts.factorizations);
    CHECK(apart(found.y, by_lu.y) <= 1e-14);
  }
}

TEST_CASE("what isn't corrected is not solved by half of a matrix of differences") {
  const ReactionDiffusion calm{.m = 6};
  CHECK(steps(calm, sparsity(as_function(calm), calm.pattern()), rodas4, 2).solver == "sparse LU");
  CHECK(steps(calm, sparsity(as_function(calm), calm.pattern()), trapezoidal, 2, linearly_implicit()).solver ==
        "sparse LU");
}

TEST_CASE("a field with wind has an unsymmetric Jacobian: LU, from the start or from where the wind rises") {
  const ReactionDiffusion windy{.m = 12, .wind = 5}, rising{.m = 12, .wind = 5, .wind_from = 5.5 * dt};
  const auto check = [](const ReactionDiffusion& problem, auto force, int fallbacks, int analyses) {
    const Ended found = steps(problem, force, trapezoidal, 10), lu = steps(problem, force, trapezoidal, 10, Lu{});
    CHECK(found.solver == "sparse LU");
    CHECK(found.counts.fallbacks == fallbacks);
    CHECK(found.counts.analyses == analyses);
    CHECK(apart(found.y, lu.y) <= 1e-14);
    return std::pair{found, lu};
  };
  const auto [found, lu] = check(windy, ReactionDiffusionTerm{windy}, 0, 1);
  const Ended same = steps(windy, ReactionDiffusionTerm{windy}, trapezoidal, 10, Newton<SparseLu<double>>{});
  CHECK((found.y.array() == same.y.array()).all());
  CHECK(found.counts.factorizations == lu.counts.factorizations);
  check(windy, sparsity(as_function(windy), windy.pattern()), 0, 1);
  check(rising, ReactionDiffusionTerm{rising}, 1, 2);
  check(rising, sparsity(as_function(rising), rising.pattern()), 1, 2);
}

#elif PHISTEP_STRESS
// symmetric_sparse_system behind a stepper: linear problems, differences, patterns. In short: systems.test.cpp.

using namespace symmetric_sparse_cases;

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

TEST_CASE("rounding doesn't break the promise") {
  Mat A = -4 * Mat::Identity(5, 5);
  A.diagonal(1).setConstant(1), A.diagonal(-1).setConstant(1 + 4e-16);
  A(0, 4) = 1e-15;
  Vec y = wave(5);
  CHECK(steps(y, symmetric(linear(A)), backward_euler, 1, 1.0).fallbacks == 0);
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

#endif
