// Steps with a banded matrix: phistep.hpp alone, no sparse matrix anywhere.
// A macro of Eigen's own keeps the precompiled header away (tests/CMakeLists.txt), which holds Eigen/Sparse.
#define EIGEN_MPL2_ONLY
#include "linear/banded/banded_system_cases.hpp"
#include "support/shared_force.hpp"

#include <algorithm>
#include <random>

#ifdef EIGEN_SPARSECORE_MODULE_H
#error "phistep.hpp reaches Eigen/SparseCore"
#endif

using namespace banded_cases;
using Rate = shared_force::OfState<Vec>;

namespace {

/// Solves with 11 on the diagonal and −5 beside it, by elimination down and up.
Vec by_hand(Vec u, int count) {
  const Eigen::Index n = u.size();
  Vec pivot(n);
  for (; count > 0; --count) {
    pivot[0] = 11;
    for (Eigen::Index i = 1; i < n; ++i) pivot[i] = 11 - 25 / pivot[i - 1], u[i] += 5 / pivot[i - 1] * u[i - 1];
    u[n - 1] /= pivot[n - 1];
    for (Eigen::Index i = n - 1; i-- > 0;) u[i] = (u[i] + 5 * u[i + 1]) / pivot[i];
  }
  return u;
}
Vec heat(const Vec& u) {
  const Eigen::Index n = u.size();
  Vec rate(n);
  for (Eigen::Index i = 0; i < n; ++i)
    rate[i] = -100 * u[i] + (i > 0 ? 50 * u[i - 1] : 0) + (i + 1 < n ? 50 * u[i + 1] : 0);
  return rate;
}

/// Beads at rest a unit apart, held at the first: springs that harden.
struct BandedChain {
  static constexpr Structure structure = Structure::banded;
  static double stretch(const auto& r, Eigen::Index i) { return i > 0 ? r[i] - r[i - 1] - 1 : r[0] - 1; }
  void add(double, const auto& y, auto& out) const {
    for (Eigen::Index i = 0; i < y.r.size(); ++i) {
      const double a = stretch(y.r, i), pull = 1e8 * (a + a * a * a);
      out.force[i] -= pull;
      if (i > 0) out.force[i - 1] += pull;
    }
  }
  void add_jacobian(double, const auto& y, auto& to) const {
    for (Eigen::Index i = 0; i < y.r.size(); ++i) {
      const double a = stretch(y.r, i), k = 1e8 * (1 + 3 * a * a);
      to.position(i, i, -k);
      if (i > 0) to.position(i - 1, i - 1, -k), to.position(i, i - 1, k), to.position(i - 1, i, k);
    }
  }
};

}  // namespace

TEST_CASE("banded(f, 1, 1) just works: three force calls a Jacobian, one factorization, no analysis") {
  constexpr int n = 200;
  Vec u = wave(n);
  const Statistics s = steps(u, banded(Rate{heat}, 1, 1), backward_euler, 3);
  CHECK(s.force_calls == s.iterations + 3);
  CHECK(s.jacobians == 1);
  CHECK(s.factorizations == 1);
  CHECK(s.analyses == 0);
  CHECK(s.fallbacks == 0);
  // κ(W) = 21, to rounding in each of three steps.
  CHECK((u - by_hand(wave(n), 3)).cwiseAbs().maxCoeff() <= 3 * 21 * 8 * 2.3e-16);
}

TEST_CASE("declared of a term, of a sum or of its terms, a band costs the calls that it costs a force alone") {
  const Rate half{[](const Vec& u) -> Vec { return heat(u) / 2; }};
  const Rate from_below{[](const Vec& u) -> Vec {
    Vec rate = -50 * u;
    rate.tail(u.size() - 1) += 50 * u.head(u.size() - 1);
    return rate;
  }};
  const Rate from_above{[&](const Vec& u) -> Vec { return from_below(u.reverse()).reverse(); }};
  Vec alone = wave(100);
  const Statistics s = steps(alone, banded(Rate{heat}, 1, 1), backward_euler, 2);
  const auto check = [&](const auto& force) {
    Vec u = wave(100);
    CHECK(steps(u, force, backward_euler, 2).force_calls == s.force_calls);
    CHECK((u - alone).cwiseAbs().maxCoeff() <= 1e-14);
  };
  check(banded(term(Rate{heat}), 1, 1));
  check(banded(term(half) + term(half), 1, 1));
  check(term(banded(from_below, 1, 0)) + term(banded(from_above, 0, 1)));
}

TEST_CASE("a wider promise than needed changes no digit that counts, and costs its calls") {
  Vec u = wave(100), v = u;
  const Statistics s = steps(u, banded(Rate{heat}, 4, 2), backward_euler, 2);
  CHECK(s.force_calls == s.iterations + 7 * s.jacobians);
  CHECK((u - by_hand(v, 2)).cwiseAbs().maxCoeff() <= 2 * 21 * 8 * 2.3e-16);
}

TEST_CASE("a hundred thousand points, analytic and by differences") {
  constexpr int n = 100000;
  Vec a = wave(n), b = a;
  steps(a, AnalyticHeat{{.sink = 3}}, trapezoidal, 2);
  steps(b, BandedHeat{{.sink = 3}}, trapezoidal, 2);
  CHECK((a - b).cwiseAbs().maxCoeff() <= 2 * 6 * 8 * 2.3e-16);
}

TEST_CASE("a pivot that vanishes: rows change places") {
  // W = 1 − Δt J with Δt J_ii = 1: zeros on the diagonal, −Δt J_ij beside it.
  constexpr int n = 6;
  const Rate swap = [](const Vec& y) -> Vec {
    Vec rate = 10 * y;
    for (Eigen::Index i = 0; i + 1 < n; i += 2) rate[i] += 5 * y[i + 1], rate[i + 1] += 7 * y[i];
    return rate;
  };
  Vec y = wave(n), exact = y;
  for (int i = 0; i + 1 < n; i += 2) exact[i + 1] = y[i] / -0.5, exact[i] = y[i + 1] / -0.7;
  steps(y, banded(swap, 1, 1), backward_euler, 1);
  CHECK((y - exact).cwiseAbs().maxCoeff() <= 1e-14 * exact.cwiseAbs().maxCoeff());
}

TEST_CASE("a singular matrix is named, and the state keeps every bit") {
  Vec y = wave(6);
  const Vec before = y;
  const Rate grow = [](const Vec& u) -> Vec { return u; };
  PhiStepper stepper{y, banded(grow, 1, 1), backward_euler};
  CHECK(stepper.step(y, 0, 1).outcome() == Outcome::singular_matrix);
  CHECK(y == before);
  CHECK(stepper.step(y, 0, 0.5));
}

TEST_CASE("the band is found from the entries, and grows where one falls outside") {
  constexpr int n = 9;
  const auto masses = [](auto&& put) {
    for (int i = 0; i < n; ++i) put(i, i, 2.0);
  };
  BandedSystem<double, true, true> system;
  system.resize(n);
  Statistics counts;
  const auto check = [&](const Mat& K, const Mat& C, Eigen::Index lower, Eigen::Index upper) {
    system.clear();
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        if (K(i, j) != 0) system.position(i, j, K(i, j));
        if (C(i, j) != 0) system.velocity(i, j, C(i, j) / 2), system.velocity(i, j, C(i, j) / 2);
      }
    REQUIRE(system.factorize(masses, 2.0, 0.5, counts) == Outcome::success);
    REQUIRE(system.factorize(masses, 0.5, 0.25, counts) == Outcome::success);  // a new γ: the same K and C
    CHECK(system.lower() == lower);
    CHECK(system.upper() == upper);
    const Mat W = 2 * Mat::Identity(n, n) - 0.5 * (C + 0.25 * K);
    const Vec b = Vec::LinSpaced(n, -1, 3);
    Vec x = b;
    REQUIRE(system.solve(x) == Outcome::success);
    CHECK((W * x - b).norm() <= 1e-14 * W.norm() * x.norm());
    const auto of_columns = [](const Mat& A) { return A.cwiseAbs().colwise().maxCoeff().array().eval(); };
    CHECK(system.drift_share() == Approx(0.125 * (of_columns(K) / of_columns(W)).maxCoeff()));
  };
  Mat K = -Mat::Identity(n, n), C = Mat::Zero(n, n);
  check(K, C, 0, 0);
  K.diagonal(-1).setConstant(0.7);
  check(K, C, 1, 0);
  C.diagonal(2).setConstant(-0.3);
  C.diagonal().setConstant(-5);
  check(K, C, 1, 2);
  C(n - 1, 0) = 4;
  check(K, C, n - 1, 2);
  C(n - 1, 0) = 0;
  check(K, C, n - 1, 2);  // it never shrinks
  system.resize(n);
  check(-Mat::Identity(n, n), -Mat::Identity(n, n), 0, 0);
}

TEST_CASE("a heavy bead at the end of a stiff chain doesn't hide how rounding of positions moves the others") {
  // v is far smaller than r/γ: Newton's corrections end at the rounding of r, and are seen to.
  constexpr int n = 20;
  Motion<Vec> y{Vec::LinSpaced(n, 1, n), 1e-6 * Vec::Unit(n, 0)};
  Vec masses = Vec::Ones(n);
  masses[n - 1] = 1e12;
  PhiStepper stepper{y, BandedChain{}, trapezoidal, mass(masses)};
  for (int k = 0; k < 10; ++k) REQUIRE(stepper.step(y, 1e-3 * k, 1e-3));
  CHECK(stepper.statistics().iterations <= 100);
}

TEST_CASE("masses beside the diagonal widen the band") {
  BandedSystem<double, false, true> system;
  system.resize(3);
  Statistics counts;
  system.velocity(0, 0, -1.0);
  const auto masses = [](auto&& put) {
    for (int i = 0; i < 3; ++i) put(i, i, 4.0);
    put(2, 0, 1.0), put(0, 1, 1.0);
  };
  REQUIRE(system.factorize(masses, 1.0, 0.0, counts) == Outcome::success);
  Vec x = Eigen::Vector3d(6, 4, 5);
  REQUIRE(system.solve(x) == Outcome::success);
  CHECK((x - Eigen::Vector3d(1, 1, 1)).norm() <= 1e-15);
}

TEST_CASE("a matrix made again holds nothing of what exchanges of rows filled in before") {
  constexpr int n = 12, lower = 2, upper = 1;
  BandedSystem<double, false, true> system;
  system.resize(n);
  Statistics counts;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> entry(-1, 1);
  const auto masses = [](auto&& put) {
    for (int i = 0; i < n; ++i) put(i, i, 0.25);
  };
  for (int again = 0; again < 4; ++again) {
    Mat W = 0.25 * Mat::Identity(n, n);  // small beside the rest: rows change places
    system.clear();
    for (int j = 0; j < n; ++j)
      for (int i = std::max(0, j - upper); i <= std::min(n - 1, j + lower); ++i) {
        const double c = entry(random);
        system.velocity(i, j, c);
        W(i, j) -= c;
      }
    REQUIRE(system.factorize(masses, 1.0, 0.0, counts) == Outcome::success);
    const Vec b = wave(n);
    Vec x = b;
    REQUIRE(system.solve(x) == Outcome::success);
    CAPTURE(again);
    CHECK((W * x - b).norm() <= 1e-14 * W.norm() * x.norm());
  }
}
