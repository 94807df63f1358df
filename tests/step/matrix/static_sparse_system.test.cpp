// Systems whose pattern is known at compile time.
#include <phistep/phistep.hpp>

#include <stdexcept>
#include <string_view>

#include "support/catch.hpp"

namespace static_sparse_cases {

using namespace phistep;

inline constexpr int n = 10;
using Vec = Eigen::Matrix<double, n, 1>;
using Mat = Eigen::Matrix<double, n, n>;

/// A chain of reactions, the last species turning back to the first at a rate that grows with the middle one.
struct Reactions {
  double rate = 30;
  Vec operator()(const Vec& y) const {
    Vec out = Vec::Zero();
    for (int i = 0; i + 1 < n; ++i) out[i] -= rate * (i + 1) * y[i], out[i + 1] += rate * (i + 1) * y[i];
    const double back = y[n - 1] * (1 + y[4]);
    out[n - 1] -= back, out[0] += back;
    return out;
  }
  Mat derivative(const Vec& y) const {
    Mat J = Mat::Zero();
    for (int i = 0; i + 1 < n; ++i) J(i, i) -= rate * (i + 1), J(i + 1, i) += rate * (i + 1);
    J(n - 1, n - 1) -= 1 + y[4], J(0, n - 1) += 1 + y[4];
    J(n - 1, 4) -= y[n - 1], J(0, 4) += y[n - 1];
    return J;
  }
};
struct Dense : Reactions {
  Mat jacobian(const Vec& y) const { return derivative(y); }
};
struct Named {
  static constexpr auto jacobian_pattern =
      entries({{0, 0}, {1, 0}, {1, 1}, {2, 1}, {2, 2}, {3, 2}, {3, 3}, {4, 3}, {4, 4}, {5, 4}, {5, 5},
               {6, 5}, {6, 6}, {7, 6}, {7, 7}, {8, 7}, {8, 8}, {9, 8}, {9, 9}, {0, 9}, {9, 4}, {0, 4}});
};
struct Returned : Dense, Named {};
struct Added : Named {
  Reactions law;
  static constexpr bool uses_time = false;
  void add(auto, const auto& y, auto& out) const { out.rate += law(y.y); }
  void add_jacobian(auto, const auto& y, auto& sink) const {
    const Mat J = law.derivative(y.y);
    for (const MatrixEntry& e : jacobian_pattern) sink.rate(e.row, e.column, J(e.row, e.column));
  }
};
struct Forgotten : Dense {
  static constexpr auto jacobian_pattern = entries({{1, 0}, {9, 4}});
};
struct ForgottenWhenAdded : Added {
  static constexpr auto jacobian_pattern = Forgotten::jacobian_pattern;
};

struct Conserving : Named {
  static constexpr bool is_affine = true, uses_time = false;
  double error = 0;
  void add(auto, const auto& y, auto& out) const {
    for (int i = 0; i + 1 < n; ++i) out.rate[i] -= y.y[i], out.rate[i + 1] += y.y[i];
  }
  void add_jacobian(auto, const auto&, auto& sink) const {
    for (int i = 0; i + 1 < n; ++i) sink.rate(i, i, -1), sink.rate(i + 1, i, 1 + error);
  }
};

inline Vec start() {
  Vec y = Vec::Constant(0.1);
  y[0] = 1;
  return y;
}

}  // namespace static_sparse_cases

using namespace static_sparse_cases;

#if PHISTEP_QUICK

namespace {

template <class F>
Vec end(F f) {
  Vec y = start();
  PhiStepper stepper{y, f, backward_euler};
  for (int k = 0; k < 50; ++k)
    if (const auto report = stepper.step(y, 0.02 * k, 0.02); !report) throw std::runtime_error(report.message());
  return y;
}

}  // namespace

TEST_CASE("a force that names its Jacobian's pattern is solved by it, and to the same answer") {
  const Vec dense = end(Dense{});
  // The same steps but for rounding, which 50 steps and a condition of 1e3 make 1e-11 at most.
  CHECK((end(Returned{}) - dense).cwiseAbs().maxCoeff() < 1e-11);
  CHECK((end(Added{}) - dense).cwiseAbs().maxCoeff() < 1e-11);
  Vec y = start();
  const std::string_view by_pattern = "LU by a pattern known at compile time";
  CHECK(std::string_view(PhiStepper{y, Returned{}, backward_euler}.solver_name()) == by_pattern);
  CHECK(std::string_view(PhiStepper{y, Added{}, backward_euler}.solver_name()) == by_pattern);
  CHECK(std::string_view(PhiStepper{y, Dense{}, backward_euler}.solver_name()) == "dense LU");
}

TEST_CASE("an affine force with a pattern: one factorization, and a wrong matrix shows") {
  Vec y = start();
  PhiStepper stepper{y, Conserving{}, backward_euler};
  for (int k = 0; k < 4; ++k) REQUIRE(stepper.step(y, 0.1 * k, 0.1));
  CHECK(stepper.statistics().factorizations == 1);
  CHECK(y.sum() == Approx(start().sum()).epsilon(1e-14));
  const Vec before = y;
  Conserving wrong;
  wrong.error = 1e-3;
  PhiStepper other{y, wrong, backward_euler};
  CHECK(other.step(y, 0.0, 0.1).outcome() == Outcome::not_affine);
  CHECK(y == before);
}

TEST_CASE("a Jacobian with entries outside of its pattern is refused, the state untouched") {
  Vec y = start();
  const Vec before = y;
  PhiStepper stepper{y, Forgotten{}, backward_euler};
  CHECK_THROWS_WITH(stepper.step(y, 0.0, 0.1), contains("jacobian_pattern"));
  CHECK(y == before);
}

#elif PHISTEP_FULL
// static_sparse_system: whole runs, with masses, every way to name a pattern.

namespace {

template <class F, class Scheme, class... More>
Vec end(F f, Scheme scheme, More... more) {
  Vec y = start();
  PhiStepper stepper{y, f, scheme, more...};
  const auto report = integrate(stepper, y, {0.0, 2.0}, tolerance{.rtol = 1e-6, .atol = 1e-9});
  REQUIRE(report);
  return y;
}

}  // namespace

TEST_CASE("a force that names its Jacobian's pattern is solved by it, and to the same answer") {
  const auto check = [](auto scheme, auto... mass) {
    const Vec dense = end(Dense{}, scheme, mass...);
    // The same steps but for rounding, which 100 steps and a condition of 1e3 make 1e-11 at most.
    CHECK((end(Returned{}, scheme, mass...) - dense).cwiseAbs().maxCoeff() < 1e-11);
    CHECK((end(Added{}, scheme, mass...) - dense).cwiseAbs().maxCoeff() < 1e-11);
  };
  check(rodas4, capacity(Vec(Vec::LinSpaced(n, 0.5, 2))));
  check(backward_euler);
  Vec y = start();
  CHECK(std::string_view(PhiStepper{y, Returned{}, rodas4}.solver_name()) == "LU by a pattern known at compile time");
  CHECK(std::string_view(PhiStepper{y, Added{}, tr_bdf2}.solver_name()) == "LU by a pattern known at compile time");
  CHECK(std::string_view(PhiStepper{y, Dense{}, rodas4}.solver_name()) == "dense LU");
  // A matrix mass fills the pattern up.
  CHECK(std::string_view(PhiStepper{y, Returned{}, rodas4, capacity(Mat(Mat::Identity()))}.solver_name()) ==
        "dense LU");
}

TEST_CASE("a Jacobian with entries outside of its pattern is refused, the state untouched") {
  const auto check = [](auto force) {
    Vec y = start();
    const Vec before = y;
    PhiStepper stepper{y, force, backward_euler};
    CHECK_THROWS_WITH(stepper.step(y, 0.0, 0.1), contains("jacobian_pattern"));
    CHECK(y == before);
  };
  check(Forgotten{});
  check(ForgottenWhenAdded{});
}

#endif
