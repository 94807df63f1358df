// Differences by colour: as few force calls as the pattern allows, and the steps that analytic tangents give.
#include <phistep/sparse.hpp>

#include <cmath>
#include <functional>

#include "contract/states.hpp"
#include "support/catch.hpp"
#if PHISTEP_QUICK
#include <Eigen/SparseCholesky>

#include "problems/march.hpp"
#include "support/shared_force.hpp"
#endif

using namespace phistep;
using Vec = Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;
using states::same_bits;

namespace difference_tangent_cases {

/// u_t = Δ_h u with u = 0 beyond both ends.
inline Vec heat(const Vec& u) {
  const Eigen::Index n = u.size();
  Vec rate = -2 * u;
  rate.head(n - 1) += u.tail(n - 1);
  rate.tail(n - 1) += u.head(n - 1);
  return 50 * rate;
}
inline Sparse tridiagonal(int n) {
  Sparse A(n, n);
  for (int j = 0; j < n; ++j)
    for (int i = std::max(0, j - 1); i < std::min(n, j + 2); ++i) A.insert(i, j) = i == j ? -100 : 50;
  return A;
}
inline Vec wave(Eigen::Index n) { return Vec::LinSpaced(n, 0, 7).array().sin(); }

/// Nonlinear springs between neighbours and dashpots; both tangents are tridiagonal.
inline Vec chain(const Vec& r, const Vec& v) {
  const Eigen::Index n = r.size();
  Vec force = -0.3 * v;
  for (Eigen::Index i = 0; i + 1 < n; ++i) {
    const double stretch = r[i + 1] - r[i], f = stretch + 4 * stretch * stretch * stretch + 0.1 * (v[i + 1] - v[i]);
    force[i] += f;
    force[i + 1] -= f;
  }
  return force;
}

/// Particles whose temperature slows them and that heat by friction: K, and C with two coupled blocks.
struct Warm {
  Vec r, v, T;
  static constexpr bool drifts = true;
  static auto blocks(auto& y) { return std::tie(y.r, y.v, y.T); }
  struct Rate {
    Vec force, heat;
    static auto blocks(auto& rate) { return std::tie(rate.force, rate.heat); }
  };
};
struct Friction : ForceTerm {
  static void add(double, const auto& y, auto& out) {
    out.force.array() += -y.r.array() - (1 + y.T.array()) * y.v.array();
    out.heat.array() += (1 + y.T.array()) * y.v.array().square() - 3 * y.T.array();
  }
};
/// Component i of the force depends on r_i, v_i and T_i; so does component n + i, the heat.
struct PatternedFriction : Friction {
  static constexpr Structure structure = Structure::sparse;
  static ColumnPattern pattern(Eigen::Index n) {
    ColumnPattern pattern;
    for (Eigen::Index j = 0; j < n; ++j) {
      pattern.row.push_back(j % (n / 2));
      pattern.row.push_back(n / 2 + j % (n / 2));
      pattern.start.push_back(2 * (j + 1));
    }
    return pattern;
  }
};

struct Coupled {
  static constexpr Structure structure = Structure::sparse;
  Eigen::Index reach;
  Vec operator()(const Vec& u) const {
    Vec rate = -u;
    rate.head(u.size() - reach) += 0.5 * u.tail(u.size() - reach);
    return rate;
  }
  [[nodiscard]] ColumnPattern pattern(Eigen::Index n) const { return band_pattern(n, 0, reach); }
};

/// Steps with Newton and counts. The force at a step's start is one call beside those of its iterations.
template <class State>
Statistics steps(State& y, auto force, auto scheme, int count, const auto&... more) {
  PhiStepper stepper{y, force, scheme, more...};
  for (int k = 0; k < count; ++k) {
    const StepReport report = stepper.step(y, 0.1 * k, 0.1);
    INFO(report.message());
    REQUIRE(report);
  }
  return stepper.statistics();
}

}  // namespace difference_tangent_cases

using namespace difference_tangent_cases;

#if PHISTEP_QUICK

// Compiles in half the time of SparseLU, which the full half takes.
const auto ldlt = newton<Eigen::SimplicialLDLT<Sparse>>();

TEST_CASE("one-dimensional heat of 5000 points: three force calls a Jacobian, no dense matrix") {
  constexpr int n = 5000;
  Vec u = wave(n);
  const Statistics s = steps(u, sparsity(heat, tridiagonal(n)), backward_euler, 3, ldlt);
  CHECK(s.jacobians == 1);
  CHECK(s.force_calls == s.iterations + 3 * s.jacobians);
  Vec exact = wave(n);
  // (1 − Δt A) u⁺ = u of constant diagonals: elimination of the row below, then backwards.
  for (int k = 0; k < 3; ++k) {
    Vec pivot(n);
    for (int i = 0; i < n; ++i) {
      pivot[i] = i == 0 ? 11 : 11 - 25 / pivot[i - 1];
      if (i > 0) exact[i] += 5 / pivot[i - 1] * exact[i - 1];
    }
    for (int i = n - 1; i >= 0; --i) exact[i] = (exact[i] + (i + 1 < n ? 5 * exact[i + 1] : 0.0)) / pivot[i];
  }
  // Newton iterates to rounding: κ(W) = 1 + 0.1·200 rounding errors of the size of u, in each of three steps.
  CHECK((u - exact).cwiseAbs().maxCoeff() <= 3 * 21 * 8 * 2.3e-16);
}

TEST_CASE("a resized state gets a pattern of its size; a pattern that can't fit throws and leaves the stepper") {
  Vec u = wave(5);
  Sparse five = tridiagonal(5);
  PhiStepper stepper{u, sparsity(heat, five), backward_euler, ldlt};
  REQUIRE(stepper.step(u, 0, 0.1));
  Vec longer = wave(8);
  const Vec before = longer;
  CHECK_THROWS_AS(stepper.step(longer, 0, 0.1), std::invalid_argument);
  CHECK(same_bits(longer, before));
  CHECK(stepper.step(u, 0.1, 0.1));  // under AddressSanitizer: nothing was left half resized
  CHECK_THROWS_AS((PhiStepper{longer, sparsity(heat, five), backward_euler, ldlt}), std::invalid_argument);
}

TEST_CASE("a dense Jacobian by differences of more than 1000 unknowns is refused, in words that name what to do") {
  const Vec u = wave(1001);
  for (const std::string cure : {"1001 unknowns", "sparsity(f, pattern)", "newton<MatrixFree<>>()",
                                 "<phistep/krylov.hpp>", "fixed_point()", "jacobian(...)"})
    CHECK_THROWS_WITH((PhiStepper{u, heat, backward_euler}), contains(cure));
}

TEST_CASE("differences are taken from the force itself, not from what a solve has left of it") {
  // phi > 1/2 carries the force from solve to solve, off by what solves to a tolerance leave. A Jacobian by differences
  // from there was off by that over the increment: Newton converged on it, to something else.
  using V2 = Eigen::Vector2d;
  const shared_force::OfState<V2> f = [](const V2& x) -> V2 { return -2 * x - x.cwiseProduct(x); };
  const auto end = [&](auto solver) {
    V2 y(1, 2);
    PhiStepper stepper{y, f, phi(0.7), solver};
    for (int n = 0; n < 10; ++n) problems::step(stepper, y, 0.1 * n, 0.1);
    return y;
  };
  const V2 tight = end(newton()), loose = end(newton({.rtol = 1e-4, .atol = 1e-6}));
  CHECK((loose - tight).norm() < 1e-4 * tight.norm());
}

#elif PHISTEP_FULL
// Differences by colour beside differences by column, for every kind of state.

TEST_CASE("one-dimensional heat of 5000 points: three force calls a Jacobian, no dense matrix") {
  constexpr int n = 5000;
  const auto check = [](auto force) {
    Vec u = wave(n);
    const Statistics s = steps(u, force, backward_euler, 3);
    CHECK(s.jacobians == 1);
    CHECK(s.force_calls == s.iterations + 3 * s.jacobians);
    return u;
  };
  const Vec by_sparsity = check(sparsity(heat, tridiagonal(n)));
  Vec exact = wave(n);
  const Sparse A = tridiagonal(n);
  Eigen::SparseLU<Sparse> lu(Sparse(Sparse(Vec::Ones(n).asDiagonal()) - 0.1 * A));
  for (int k = 0; k < 3; ++k) exact = lu.solve(exact).eval();
  // Newton iterates to rounding: κ(W) = 1 + 0.1·200 rounding errors of the size of u, in each of three steps.
  CHECK((by_sparsity - exact).cwiseAbs().maxCoeff() <= 3 * 21 * 8 * 2.3e-16);
}

TEST_CASE("a motion: K and C by three calls each, and the same steps as by columns") {
  constexpr int n = 30;
  const Motion<Vec> start{wave(n), wave(n).reverse()};
  Motion<Vec> by_color = start, by_column = start;
  const Statistics few = steps(by_color, sparsity(chain, tridiagonal(n)), trapezoidal, 5);
  const Statistics many = steps(by_column, chain, trapezoidal, 5);
  CHECK(few.force_calls == 5 + few.iterations + 6 * few.jacobians);
  CHECK(many.force_calls == 5 + many.iterations + 2 * n * many.jacobians);
  CHECK(few.iterations == many.iterations);
  // Both iterate to rounding; a few units in the last place of a state of size 1 in each of five steps.
  CHECK((by_color.r - by_column.r).cwiseAbs().maxCoeff() <= 5 * 8 * 2.3e-16);
  CHECK((by_color.v - by_column.v).cwiseAbs().maxCoeff() <= 5 * 8 * 2.3e-16);
}

TEST_CASE("a resized state gets a pattern of its size; a pattern that can't fit throws and leaves the stepper") {
  Vec u = wave(5);
  Sparse five = tridiagonal(5);
  PhiStepper stepper{u, sparsity(heat, five), backward_euler};
  REQUIRE(stepper.step(u, 0, 0.1));
  Vec longer = wave(8);
  const Vec before = longer;
  CHECK_THROWS_AS(stepper.step(longer, 0, 0.1), std::invalid_argument);
  CHECK(same_bits(longer, before));
  CHECK(stepper.step(u, 0.1, 0.1));  // under AddressSanitizer: nothing was left half resized
  CHECK_THROWS_AS((PhiStepper{longer, sparsity(heat, five), backward_euler}), std::invalid_argument);
}

TEST_CASE("several blocks: the pattern runs over all unknowns, and a colour may span blocks") {
  constexpr int n = 40;
  const Warm start{wave(n), Vec::Constant(n, 0.5), Vec::LinSpaced(n, 0.1, 1)};
  Warm by_color = start, by_column = start;
  const Statistics few = steps(by_color, PatternedFriction{}, backward_euler, 5);
  const Statistics many = steps(by_column, Friction{}, backward_euler, 5);
  // Columns of v_i and T_i share rows: two colours for C. Those of r: one for K.
  CHECK(few.force_calls == few.iterations + 3 * few.jacobians);
  CHECK(many.force_calls == many.iterations + 3 * n * many.jacobians);
  CHECK(few.iterations == many.iterations);
  CHECK((by_color.v - by_column.v).cwiseAbs().maxCoeff() <= 5 * 8 * 2.3e-16);
  CHECK((by_color.T - by_column.T).cwiseAbs().maxCoeff() <= 5 * 8 * 2.3e-16);
}

TEST_CASE("a stiff kick is measured again, by colour as by column") {
  // The force at the start throws u far beyond what the step then moves: the tangent there is another one.
  constexpr int n = 20;
  const auto stiff = [](const Vec& u) -> Vec { return -1e6 * (u.array() - 1).cube() - 1e8 * (u.array() - 1); };
  Sparse diagonal(n, n);
  diagonal.setIdentity();
  Vec by_color = Vec::Constant(n, 1.001), by_column = by_color;
  const Statistics few = steps(by_color, sparsity(stiff, diagonal), backward_euler, 1);
  const Statistics many = steps(by_column, stiff, backward_euler, 1);
  CHECK(few.jacobians == many.jacobians);
  CHECK(few.jacobians > 1);
  CHECK(few.force_calls == few.iterations + few.jacobians);
  CHECK(same_bits(by_color, by_column));
}

TEST_CASE("a force that is changed between steps brings its new pattern") {
  Vec u = wave(50);
  PhiStepper stepper{u, Coupled{1}, backward_euler};
  REQUIRE(stepper.step(u, 0, 0.1));
  const Statistics before = stepper.statistics();
  stepper.force().reach = 3;
  REQUIRE(stepper.step(u, 0.1, 0.1));
  const Statistics change = stepper.statistics() - before;
  CHECK(change.jacobians == 1);
  CHECK(change.force_calls == change.iterations + 4);
}

TEST_CASE("a force kept outside is asked for its pattern too") {
  auto force = sparsity(heat, tridiagonal(2000));
  Vec u = wave(2000);
  const Statistics s = steps(u, std::ref(force), trapezoidal, 1);
  CHECK(s.force_calls == s.iterations + 3 * s.jacobians);
}

TEST_CASE("a spring stretched at the start, slack at the end: its first tangent's crawl is no convergence") {
  // Across itself a long spring is stiff, W = 1 + 0.3 k Δt²; at its rest length it isn't, W = 1. Corrections by the first
  // tangent then fall by a factor near 1 and are small beside what they leave.
  using Vector = Eigen::VectorXd;
  Vector start(6);
  start << 0, 0.1, 0.1, 1.1, 0.3, 0;
  for (const double k : {1e3, 1e4, 1e5, 1e6}) {
    const auto spring = [k](const Vector& r) -> Vector {
      const Eigen::Vector3d d = r.tail<3>() - r.head<3>(), pull = k * (d.norm() - 1) / d.norm() * d;
      Vector f(6);
      f << pull, -pull;
      return f;
    };
    phistep::Motion<Vector> y{start, Vector::Zero(6)};
    phistep::PhiStepper stepper{y, spring, phistep::backward_euler};
    const double dt = 0.1;
    REQUIRE(stepper.step(y, 0, dt));
    CAPTURE(k);
    // Rounding of r ≈ 1, once in each of some sums, reaches the residual times k Δt.
    CHECK((y.v - dt * spring(y.r)).cwiseAbs().maxCoeff() <= 8 * 2.2e-16 * (1 + k * dt));
  }
}

#endif
