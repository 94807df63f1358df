// The solvers' part of answers.cpp, in a program of its own because it takes as long to compile: chains, bands, sparse
// matrices, springs, derivatives, and what is advised.
#include <phistep/all.hpp>

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <vector>

#include "compatibility/answer.hpp"
#include "problems/robertson.hpp"

using namespace phistep;
using namespace answers;
using Vec = Eigen::VectorXd;
using Eigen::Vector2d;
using problems::Robertson;

namespace {

/// u_t = u_xx on n points between two zeros, from a parabola's discrete counterpart.
constexpr Index points = 40;
auto heat() {
  return [](const auto& u) {
    std::remove_cvref_t<decltype(u)> rate(u.size());
    const double k = 41.0 * 41.0;
    for (Index i = 0; i < points; ++i) {
      rate[i] = -2 * k * u[i];
      if (i > 0) rate[i] += k * u[i - 1];
      if (i + 1 < points) rate[i] += k * u[i + 1];
    }
    return rate;
  };
}
Vec parabola() {
  Vec u(points);
  for (Index i = 0; i < points; ++i) {
    const double x = static_cast<double>(i + 1) / (points + 1);
    u[i] = 4 * x * (1 - x);
  }
  return u;
}
/// By the eigenvectors of the second difference.
double hottest(double t) {
  const double pi = 3.14159265358979323846, n = points + 1;
  double sum = 0;
  for (Index k = 1; k <= points; ++k) {
    double part = 0;
    const Vec u = parabola();
    for (Index i = 0; i < points; ++i) part += u[i] * std::sin(pi * static_cast<double>(k * (i + 1)) / n);
    const double s = std::sin(pi * static_cast<double>(k) / (2 * n));
    sum += 2 / n * part * std::exp(-4 * n * n * s * s * t) * std::sin(pi * static_cast<double>(k * points / 2) / n);
  }
  return sum;
}
/// Dynamic, first order, one problem by several solvers: banded, dense by automatic differentiation, affine and sparse.
void diffusion() {
  const double t1 = 0.05, exact = hottest(t1);
  const auto after = [&](const char* name, auto force, auto scheme, auto control, double allowed, auto... more) {
    Vec u = parabola();
    PhiStepper stepper{u, std::move(force), scheme, mass(1.0), more...};
    good(integrate(stepper, u, {0, t1}, control));
    answer(name, u[points / 2 - 1], exact, allowed);
    return u;
  };
  const tolerance six{.rtol = 1e-6};
  after("heat, banded, tr_bdf2", banded(heat(), 1, 1), tr_bdf2, six, 1e-5);
  after("heat, banded, Radau", banded(heat(), 1, 1), radau, six, 1e-5);
  const Vec b = after("heat, autodiff, trapezoidal", autodiff(heat()), trapezoidal, fixed(1e-3), 1e-4);
  Eigen::SparseMatrix<double> pattern(points, points);
  for (Index i = 0; i < points; ++i)
    for (Index j = std::max<Index>(0, i - 1); j < std::min(points, i + 2); ++j) pattern.insert(i, j) = 1;
  const Vec c =
      after("heat, sparse, affine, trapezoidal", affine(sparsity(heat(), pattern)), trapezoidal, fixed(1e-3), 1e-4);
  answer("heat: sparse and dense agree", (b - c).cwiseAbs().maxCoeff(), 0, 1e-12);
}

/// A chain that falls: springs by conjugate gradients. (preflight is left out: Eigen's eigenvalues alone take as long to compile
/// as all of the rest.)
void chain() {
  constexpr Index n = 12;
  Eigen::Matrix2Xd r(2, n);
  std::vector<Spring> springs;
  for (Index i = 0; i < n; ++i) r.col(i) << static_cast<double>(i), 0;
  for (Index i = 0; i + 1 < n; ++i) springs.push_back({i, i + 1, 1e4, 1});
  Motion<Eigen::Matrix2Xd> y{r, Eigen::Matrix2Xd::Zero(2, n)};
  PhiStepper stepper{y, spring_network<2>(springs) + Gravity{Vector2d{0, -10}}, backward_euler, mass(0.5)};
  y.v(1, 0) = 1;
  good(integrate(stepper, y, {0, 0.5}, fixed(0.01)));
  // Springs between particles change no momentum: the centre of mass falls as it should, by this scheme's own sum.
  const double fall = 0.5 * 10 * 0.5 * (0.5 + 0.01), start = 0.5 / static_cast<double>(n);
  answer("chain, backward_euler: the centre's fall", y.r.row(1).mean(), start - fall, 1e-10);
  answer("chain, backward_euler: first x", y.r(0, 0), 0, 0.5);
}

}  // namespace

int main() {
  diffusion();
  chain();
  const Advice advice = advise(Robertson::start(), Robertson{}, {0, 40}, {.rtol = 1e-6});
  answer("advise: Robertson is stiff", advice.scheme.starts_with("rodas") || advice.scheme.starts_with("radau"));
  return result();
}
