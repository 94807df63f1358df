// banded_system: motions, and what is solved by dense LU beside it. In short: banded_system.test.cpp.
#include "linear/banded/banded_system_cases.hpp"

using namespace banded_cases;

namespace {

Vec by_hand(Vec u, int count) {
  const Eigen::Index n = u.size();
  Mat W = 11 * Mat::Identity(n, n);
  W.diagonal(1).setConstant(-5), W.diagonal(-1).setConstant(-5);
  for (int k = 0; k < count; ++k) u = W.partialPivLu().solve(u).eval();
  return u;
}

}  // namespace

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
