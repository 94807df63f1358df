// Steps with a banded matrix: phistep.hpp alone, no sparse matrix anywhere.
#include <phistep/phistep.hpp>

#include <cmath>

#include "support/catch.hpp"

#ifdef EIGEN_SPARSECORE_MODULE_H
#error "phistep.hpp reaches Eigen/SparseCore"
#endif

using namespace phistep;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;

namespace {

Vec wave(Eigen::Index n) { return Vec::LinSpaced(n, 0, 7).array().sin(); }

/// u_t = Δ_h u, linear or with a sink u³; into an array that is there already.
struct Heat {
  double sink = 0;
  void add(double, const auto& y, auto& out) const {
    const auto& u = y.y;
    const Eigen::Index n = u.size();
    out.rate -= 100 * u;
    out.rate.head(n - 1) += 50 * u.tail(n - 1);
    out.rate.tail(n - 1) += 50 * u.head(n - 1);
    out.rate.array() -= sink * u.array().cube();
  }
};
struct BandedHeat : Heat {
  static constexpr Structure structure = Structure::banded;
  [[nodiscard]] static ColumnPattern pattern(Eigen::Index n) { return band_pattern(n, 1, 1); }
};
/// Its own Jacobian, row by row.
struct AnalyticHeat : Heat {
  static constexpr Structure structure = Structure::banded;
  void add_jacobian(double, const auto& y, auto& to) const {
    const Eigen::Index n = y.y.size();
    for (Eigen::Index i = 0; i < n; ++i) {
      if (i > 0) to.rate(i, i - 1, 50.0);
      to.rate(i, i, -100 - 3 * sink * y.y[i] * y.y[i]);
      if (i + 1 < n) to.rate(i, i + 1, 50.0);
    }
  }
};
static_assert(ForceTraits<AnalyticHeat, FirstOrderView<Vec, UnitMass>, RateOf<Vec>>::has_jacobian);

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
Vec by_hand(Vec u, int count) {
  const Eigen::Index n = u.size();
  Mat W = 11 * Mat::Identity(n, n);
  W.diagonal(1).setConstant(-5), W.diagonal(-1).setConstant(-5);
  for (int k = 0; k < count; ++k) u = W.partialPivLu().solve(u).eval();
  return u;
}

}  // namespace

TEST_CASE("banded(f, 1, 1) just works: three force calls a Jacobian, one factorisation, no analysis") {
  constexpr int n = 200;
  const auto heat = [](const Vec& u) -> Vec {
    Vec rate = -100 * u;
    rate.head(n - 1) += 50 * u.tail(n - 1);
    rate.tail(n - 1) += 50 * u.head(n - 1);
    return rate;
  };
  Vec u = wave(n);
  const Statistics s = steps(u, banded(heat, 1, 1), backward_euler, 3);
  CHECK(s.force_calls == s.iterations + 3);
  CHECK(s.jacobians == 1);
  CHECK(s.factorizations == 1);
  CHECK(s.analyses == 0);
  CHECK(s.fallbacks == 0);
  // κ(W) = 21, to rounding in each of three steps.
  CHECK((u - by_hand(wave(n), 3)).cwiseAbs().maxCoeff() <= 3 * 21 * 8 * 2.3e-16);
}

TEST_CASE("a wider promise than needed changes no digit that counts, and costs its calls") {
  constexpr int n = 100;
  Vec u = wave(n), v = u;
  const auto heat = [](const Vec& y) -> Vec {
    Vec rate = -100 * y;
    rate.head(y.size() - 1) += 50 * y.tail(y.size() - 1);
    rate.tail(y.size() - 1) += 50 * y.head(y.size() - 1);
    return rate;
  };
  const Statistics s = steps(u, banded(heat, 4, 2), backward_euler, 2);
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

TEST_CASE("a motion: K and C in one band, with masses") {
  constexpr int n = 40;
  const auto chain = [](const Vec& r, const Vec& v) -> Vec {
    Vec force = -0.3 * v;
    for (Eigen::Index i = 0; i + 1 < r.size(); ++i) {
      const double stretch = r[i + 1] - r[i], f = stretch + 4 * stretch * stretch * stretch + 0.1 * (v[i + 1] - v[i]);
      force[i] += f;
      force[i + 1] -= f;
    }
    return force;
  };
  const Motion<Vec> start{wave(n), wave(n).reverse()};
  const Vec m = Vec::LinSpaced(n, 1, 3);
  Motion<Vec> dense = start, band = start;
  const Statistics s = steps(dense, chain, trapezoidal, 5, mass(m));
  const Statistics few = steps(band, banded(chain, 1, 1), trapezoidal, 5, mass(m));
  CHECK(few.force_calls == 5 + few.iterations + 6 * few.jacobians);
  CHECK(few.iterations == s.iterations);
  CHECK((dense.r - band.r).cwiseAbs().maxCoeff() <= 5 * 8 * 2.3e-16);
  CHECK((dense.v - band.v).cwiseAbs().maxCoeff() <= 5 * 8 * 2.3e-16);
}

TEST_CASE("a pivot that vanishes: rows change places") {
  // W = 1 − Δt J with Δt J_ii = 1: zeros on the diagonal, −Δt J_ij beside it.
  constexpr int n = 6;
  const auto swap = [](const Vec& y) -> Vec {
    Vec rate = 10 * y;
    for (Eigen::Index i = 0; i + 1 < n; i += 2) rate[i] += 5 * y[i + 1], rate[i + 1] += 7 * y[i];
    return rate;
  };
  Vec y = wave(n);
  Mat W = Mat::Zero(n, n);
  for (int i = 0; i + 1 < n; i += 2) W(i, i + 1) = -0.5, W(i + 1, i) = -0.7;
  const Vec exact = W.fullPivLu().solve(y);
  steps(y, banded(swap, 1, 1), backward_euler, 1);
  CHECK((y - exact).cwiseAbs().maxCoeff() <= 1e-14 * exact.cwiseAbs().maxCoeff());
}

TEST_CASE("a singular matrix is named, and the state keeps every bit") {
  Vec y = wave(6);
  const Vec before = y;
  const auto grow = [](const Vec& u) -> Vec { return u; };
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
    CHECK(system.tangent().lower() == lower);
    CHECK(system.tangent().upper() == upper);
    const Mat W = 2 * Mat::Identity(n, n) - 0.5 * (C + 0.25 * K);
    const Vec b = Vec::LinSpaced(n, -1, 3);
    Vec x = b;
    REQUIRE(system.solve(x) == Outcome::success);
    CHECK((W * x - b).norm() <= 1e-14 * W.norm() * x.norm());
    CHECK(system.drift_share() == Approx(0.125 * K.cwiseAbs().maxCoeff() / W.cwiseAbs().maxCoeff()));
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
