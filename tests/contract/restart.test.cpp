// First-order problems, restarted anywhere: every scheme and every way to solve.
#include <phistep/autodiff.hpp>
#include <phistep/krylov.hpp>
#include <phistep/sparse.hpp>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>

#include <memory>
#include <vector>

#include "contract/restart.hpp"
#include "contract/states.hpp"

using namespace phistep;
using restart::check;
using restart::Steps;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;
using Sparse = Eigen::SparseMatrix<double>;

namespace {

constexpr Eigen::Index n = 7;

/// y_i' = −3 y_i + 1.2 y_{i−1} + y_{i+1} − 0.2 y_i³, in any scalar.
struct Chain {
  template <class V>
  auto operator()(const V& y) const {
    std::remove_cvref_t<decltype(y.eval())> rate(y.size());
    for (Eigen::Index i = 0; i < y.size(); ++i) {
      rate[i] = -3.0 * y[i] - 0.2 * y[i] * y[i] * y[i];
      if (i > 0) rate[i] += 1.2 * y[i - 1];
      if (i + 1 < y.size()) rate[i] += y[i + 1];
    }
    return rate;
  }
};
Mat tangent(const Vec& y, double below = 1.2) {
  Mat J = Mat::Zero(y.size(), y.size());
  for (Eigen::Index i = 0; i < y.size(); ++i) {
    J(i, i) = -3 - 0.6 * y[i] * y[i];
    if (i > 0) J(i, i - 1) = below;
    if (i + 1 < y.size()) J(i, i + 1) = 1;
  }
  return J;
}
const auto chain = [](const Vec& y) -> Vec { return Chain{}(y); };
struct WithJacobian {
  Vec operator()(const Vec& y) const { return Chain{}(y); }
  [[nodiscard]] Mat jacobian(const Vec& y) const { return tangent(y); }
};
struct WithSparseJacobian {
  Vec operator()(const Vec& y) const { return Chain{}(y); }
  [[nodiscard]] Sparse jacobian(const Vec& y) const { return tangent(y).sparseView(); }
};
/// Symmetric; driven apart by `push` > 0, so that W loses its definiteness.
struct Even {
  double push = 0;
  Vec operator()(const Vec& y) const {
    Vec rate = Chain{}(y) + push * y;
    for (Eigen::Index i = 1; i < y.size(); ++i) rate[i] -= 0.2 * y[i - 1];
    return rate;
  }
  [[nodiscard]] Sparse jacobian(const Vec& y) const {
    return (tangent(y, 1.0) + push * Mat::Identity(y.size(), y.size())).sparseView();
  }
};
/// With entries that come and go: the pattern changes during the run.
struct Thinning : WithSparseJacobian {
  [[nodiscard]] Sparse jacobian(const Vec& y) const {
    Mat J = tangent(y);
    if (y[0] < 0.6) J(0, 1) = 0;
    return J.sparseView();
  }
};

Vec start_of(Eigen::Index size) { return Vec::LinSpaced(size, 0, 4).array().cos(); }
Vec start() { return start_of(n); }

/// A tolerance, so that factors serve steps of other lengths too, with scaled corrections.
template <class Solver = void>
auto tolerant() {
  return newton<Solver>({.rtol = 1e-4, .atol = 1e-6});
}
const Steps even{0.05}, uneven{0.05, false};

/// A stepper maker.
template <class F, class... More>
auto steps(F f, More... more) {
  return [=](const auto& y) { return PhiStepper{y, f, more...}; };
}

}  // namespace

TEST_CASE("explicit and implicit schemes restart to the same bits") {
  states::for_each_first_order_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    check(even, start, steps(chain, scheme));
    check(uneven, start, steps(states::DrivenPull{}, scheme));
  });
}

TEST_CASE("a carried force is carried over a restart") {
  // φ > ½ and TR-BDF2 recover Ψ from the resolve: evaluated again it would have other bits.
  const Statistics s = check(even, start, steps(chain, phi(0.7), linearly_implicit()));
  // n columns a step, and the first step's Ψ; all others are carried.
  CHECK(s.force_calls == 1 + 60 * n);
  check(uneven, start, steps(WithJacobian{}, tr_bdf2));
}

TEST_CASE("Jacobians that are kept to rounding survive a restart") {
  // A near start for a slow run: θ ≤ 1e-3.
  const Steps slow{1e-3};
  const Statistics s = check(slow, start, steps(chain, trapezoidal));
  CHECK(s.jacobians < 10);
  check(slow, start, steps(WithJacobian{}, trapezoidal));
  check({1e-3, false}, start, steps(autodiff(Chain{}), backward_euler));
}

TEST_CASE("Jacobians and scaled factors that are kept to a tolerance survive a restart") {
  const auto differences = check(uneven, start, steps(chain, tr_bdf2, tolerant()));
  const auto analytic = check(uneven, start, steps(WithJacobian{}, tr_bdf2, tolerant()));
  const auto automatic = check(uneven, start, steps(autodiff(Chain{}), tr_bdf2, tolerant()));
  for (const Statistics& s : {differences, analytic, automatic}) {
    CHECK(s.jacobians < s.steps);
    CHECK(s.factorizations < s.steps);  // of 60 lengths, two resolves each
  }
}

TEST_CASE("Rannacher's start goes on where it was") {
  check(even, start, steps(chain, rannacher(3)));
  check(uneven, start, steps(WithJacobian{}, rannacher(2), tolerant()));
}

TEST_CASE("banded, block tridiagonal and sparse systems restart to the same bits") {
  for (const Steps& s : {even, uneven}) {
    check(s, start, steps(banded(chain, 1, 1), tr_bdf2, tolerant()));
    check(s, start, steps(block_tridiagonal<2>(chain), tr_bdf2, tolerant()));
    check(s, start, steps(sparsity(chain, tangent(start()).sparseView().eval()), tr_bdf2, tolerant()));
    const Statistics lu = check(s, start, steps(WithSparseJacobian{}, tr_bdf2, tolerant()));
    CHECK(lu.analyses == 1);
    CHECK(lu.factorizations < lu.steps);
  }
  CHECK(check(even, start, steps(Thinning{}, trapezoidal)).analyses > 1);
  check({1e-3}, start, steps(WithSparseJacobian{}, trapezoidal));
}

TEST_CASE("a chain whose blocks need pivoting restarts to the same bits") {
  // W = 1 − Δt A has zeros where block elimination wants pivots.
  Mat W = Mat::Identity(6, 6);
  W(0, 0) = W(1, 1) = 0, W(0, 1) = 2, W(1, 0) = -1, W(2, 2) = 1e-13, W(2, 4) = W(4, 2) = 1;
  const Mat A = Mat::Identity(6, 6) - W;
  const auto force = block_tridiagonal<2>([A](const Vec& y) -> Vec { return A * y - 1e-3 * y.cwiseProduct(y); });
  const auto s = check(
      {1.0, true, 12}, [] { return start_of(6); }, steps(force, backward_euler, tolerant()));
  CHECK(s.fallbacks > 0);
}

TEST_CASE("symmetric systems restart to the same bits, and so do the users' own solvers") {
  const Statistics ldlt = check(uneven, start, steps(symmetric(Even{}), tr_bdf2, tolerant()));
  CHECK(ldlt.fallbacks == 0);
  CHECK(ldlt.analyses == 1);
  // Growth at rates about 6, until the cubes catch it: W is indefinite at first, and definite later.
  const Statistics lu = check({0.3, false, 40}, start, steps(symmetric(Even{9}), backward_euler, linearly_implicit()));
  CHECK(lu.fallbacks > 0);
  CHECK(lu.fallbacks < lu.factorizations);
  CHECK(lu.analyses == 2);
  check(uneven, start, steps(symmetric(Even{}), tr_bdf2, tolerant<Eigen::SimplicialLDLT<Sparse>>()));
  check(uneven, start, steps(WithSparseJacobian{}, tr_bdf2, tolerant<Eigen::BiCGSTAB<Sparse>>()));
}

TEST_CASE("affine forces go on with their factors and their checks") {
  for (const Steps& s : {even, uneven}) {
    const Statistics dense = check(s, start, steps(linear(tangent(start())), trapezoidal));
    CHECK(dense.jacobians == 1);
    CHECK(dense.factorizations == (s.even ? 1 : 60));
    check(s, start, steps(linear(Sparse(tangent(start()).sparseView())), trapezoidal));
    check(s, start, steps(affine([](const Vec& y) -> Vec { return -2 * y; }), tr_bdf2));
  }
}

TEST_CASE("iterations without a matrix restart to the same bits") {
  check(uneven, start, steps(chain, tr_bdf2, fixed_point()));
  check(uneven, start, steps(chain, phi(0.8), fixed_point({.rtol = 1e-5, .atol = 1e-7})));
  check(uneven, start, steps(chain, tr_bdf2, newton<MatrixFree<Eigen::BiCGSTAB>>()));
}

TEST_CASE("masses of all kinds") {
  const Vec one_each = Vec::LinSpaced(n, 1, 2);
  const Mat full = Mat::Identity(n, n) * 2 + Mat::Constant(n, n, 0.1);
  check(uneven, start, steps(chain, phi(0.7), capacity(one_each), tolerant()));
  check(uneven, start, steps(chain, phi(0.7), capacity(full), tolerant()));
  check(uneven, start, steps(WithSparseJacobian{}, tr_bdf2, capacity(one_each), tolerant()));
}

TEST_CASE("other scalars") {
  const auto run = [](auto zero, double rtol) {
    using T = decltype(zero);
    using V = Eigen::Matrix<T, Eigen::Dynamic, 1>;
    const auto force = [](const V& y) -> V { return -T(3) * y - (y.array().cube() / T(7)).matrix(); };
    const auto from = [] { return V(start().cast<T>() / T(3)); };
    check(uneven, from, steps(force, phi(0.7), newton({.rtol = rtol, .atol = rtol / 100})));
    check(uneven, from, steps(force, tr_bdf2));
    using Fixed = Eigen::Matrix<T, 3, 1>;
    const auto fixed = [](const Fixed& y) -> Fixed { return -T(3) * y - (y.array().cube() / T(7)).matrix(); };
    check(
        uneven,
        [] {
          return Fixed{T(1) / T(3), T(-2) / T(7), T(1)};
        },
        steps(fixed, tr_bdf2));
  };
  run(0.0f, 1e-3);
  run(0.0, 1e-6);
  run(0.0L, 1e-9);
}

TEST_CASE("states that live in somebody's own memory") {
  // The unbroken run and each restart have a home of their own.
  std::vector<std::unique_ptr<states::Home<states::Mapped>>> homes;
  const auto mapped = [&homes] {
    homes.push_back(std::make_unique<states::Home<states::Mapped>>());
    return homes.back()->block(states::positions);
  };
  const auto force = [](const Vec& y) -> Vec { return Chain{}(y); };
  check(uneven, mapped, steps(force, tr_bdf2, tolerant()));
  std::vector<std::unique_ptr<states::Home<states::Strided>>> strided_homes;
  const auto strided = [&strided_homes] {
    strided_homes.push_back(std::make_unique<states::Home<states::Strided>>());
    return strided_homes.back()->block(states::positions);
  };
  check(uneven, strided, steps(force, phi(0.7)));
  check(
      uneven, [] { return states::RowMajor(states::RowMajor::Random(3, 2)); }, steps(states::Pull{}, tr_bdf2));
}

TEST_CASE("halving goes on with its counts") {
  // Newton may take two iterations: long steps stall, and are halved.
  const auto stiff = [](const Vec& y) -> Vec { return (-20 * y.array().cube() + 10).matrix(); };
  const auto make = [&](const auto& y) {
    return Halving{PhiStepper{y, stiff, phi(0.7), newton({.max_iterations = 6})}, 8};
  };
  const Statistics s = check({0.2, false, 20}, start, make);
  CHECK(s.halvings > 0);
}

TEST_CASE("a stepper that is moved takes its factors along, whatever the solver") {
  const auto run = [](auto solver) {
    Vec y = start(), moved_y = start();
    const auto make = steps(WithSparseJacobian{}, tr_bdf2, solver);
    auto stepper = make(y);
    auto first = make(moved_y);
    for (int k = 0; k < 5; ++k) {
      REQUIRE(stepper.step(y, k * 0.05, 0.05));
      REQUIRE(first.step(moved_y, k * 0.05, 0.05));
    }
    auto second = std::move(first);
    for (int k = 5; k < 10; ++k) {
      REQUIRE(stepper.step(y, k * 0.05, 0.05));
      REQUIRE(second.step(moved_y, k * 0.05, 0.05));
    }
    CHECK(states::same_bits(y, moved_y));
    CHECK(stepper.statistics() == second.statistics());
  };
  run(tolerant());
  run(tolerant<Eigen::BiCGSTAB<Sparse>>());  // refers to the matrix
}
