// A Jacobian that was supplied, or a pattern that was declared, is checked where nothing iterates on it.
#include <phistep/phistep.hpp>
#include <phistep/schemes/radau/radau.hpp>
#include <phistep/sparse.hpp>

#include <cmath>
#include <functional>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace {

using Vec = Eigen::VectorXd;
using Plane = Eigen::Vector2d;

/// Van der Pol, stiff, with a Jacobian that is `by` times the right one.
struct Relaxing {
  double by = 1;
  Plane operator()(const Plane& y) const { return {y[1], 50 * (1 - y[0] * y[0]) * y[1] - y[0]}; }
  Eigen::Matrix2d jacobian(const Plane& y) const {
    Eigen::Matrix2d J;
    J << 0, 1, -100 * y[0] * y[1] - 1, 50 * (1 - y[0] * y[0]);
    return by * J;
  }
};
/// A chain of cells with diffusion, and a coupling to the cell after next.
struct Cells {
  double far = 0;
  Vec operator()(const Vec& y) const {
    const Index n = y.size();
    Vec f(n);
    for (Index i = 0; i < n; ++i) {
      f[i] = -200 * y[i] - y[i] * y[i];
      if (i > 0) f[i] += 100 * y[i - 1];
      if (i + 1 < n) f[i] += 100 * y[i + 1];
      if (i + 2 < n) f[i] += far * y[i + 2];
    }
    return f;
  }
};
/// A pendulum with drag; K and C may be wrong.
struct Pendulum {
  double K = 1, C = 1;
  Plane operator()(const Plane& r, const Plane& v) const {
    return Plane(-9 * std::sin(r[0]) - v[0], -4 * r[1] - 2 * v[1]);
  }
  struct Tangents {
    Eigen::Matrix2d K, C;
  };
  Tangents jacobian(const Plane& r, const Plane&) const {
    return {K * Plane(-9 * std::cos(r[0]), -4).asDiagonal().toDenseMatrix(),
            C * Plane(-1, -2).asDiagonal().toDenseMatrix()};
  }
};

/// The outcome of a hundred steps, or of the first that fails, and where.
template <class Stepper, class S>
std::pair<Outcome, int> march(Stepper& stepper, S& y, double dt, int steps = 100) {
  for (int n = 0; n < steps; ++n)
    if (const StepReport report = stepper.step(y, n * dt, dt); !report) return {report.outcome(), n};
  return {Outcome::success, steps};
}

}  // namespace

TEST_CASE("a supplied Jacobian that is wrong ends the first step that is made with it, whose state stays") {
  const auto check = [](auto scheme, std::int64_t calls) {
    for (const double by : {0.5, 2.0, 0.0, -1.0, 1.01}) {
      Plane y(2, 0.3);
      PhiStepper stepper{y, Relaxing{by}, scheme};
      CAPTURE(by);
      CHECK(march(stepper, y, 1e-3) == std::pair{Outcome::wrong_jacobian, 0});
      CHECK(y == Plane(2, 0.3));
      CHECK(march(stepper, y, 1e-3) == std::pair{Outcome::wrong_jacobian, 0});  // and the next one, too
    }
    Plane y(2, 0.3);
    PhiStepper stepper{y, Relaxing{}, scheme};
    CHECK(march(stepper, y, 1e-3) == std::pair{Outcome::success, 100});
    CHECK(stepper.statistics().checks == calls);
    CHECK(stepper.statistics().jacobians == 100);
  };
  check(rodas4p2, 13);  // steps 1, 2, 3, 4, 6, 8 … 64, 96, one call each
  check(rodas5p, 13);
  check(radau(3), 26);  // Ψ at the step's start is one more
  check(radau(7), 26);
}

TEST_CASE(
    "linearly_implicit() has one correction: a wrong Jacobian, or a pattern that is too narrow, ends its first step") {
  for (const double by : {0.5, 0.0, -1.0, 1.01, 1.0}) {
    CAPTURE(by);
    const auto check = [by](auto scheme) {
      Plane y(2, 0.3);
      PhiStepper stepper{y, Relaxing{by}, scheme, linearly_implicit()};
      if (by != 1) {
        CHECK(march(stepper, y, 1e-3) == std::pair{Outcome::wrong_jacobian, 0});
        CHECK(y == Plane(2, 0.3));
        return;
      }
      CHECK(march(stepper, y, 1e-3).first == Outcome::success);
      CHECK(stepper.statistics().force_calls == 100);
      CHECK(stepper.statistics().checks == 13);
    };
    check(backward_euler);
    check(trapezoidal);
    check(phi_stage(0.7));
    Motion<Plane> y{Plane(1, 0.5), Plane(0.2, -0.3)};
    PhiStepper motion{y, Pendulum{1, by}, trapezoidal, linearly_implicit()};
    CHECK((march(motion, y, 0.1).first == Outcome::success) == (by == 1));
    Motion<Plane> z{Plane(1, 0.5), Plane(0.2, -0.3)};
    PhiStepper pair{z, Pendulum{by, 1}, phi(0.6, 0.9), linearly_implicit()};  // γ of Ψ and of v differ
    CHECK((march(pair, z, 0.1).first == Outcome::success) == (by == 1));
  }
  for (const double far : {0.0, 40.0}) {
    Vec y = Vec::LinSpaced(40, 0.5, 1.5);
    PhiStepper stepper{y, banded(Cells{far}, 1, 1), backward_euler, linearly_implicit()};
    CHECK(march(stepper, y, 1e-2, 3).first == (far > 0 ? Outcome::wrong_jacobian : Outcome::success));
  }
}

TEST_CASE("a Jacobian that goes wrong late is told, at less than 1 % of the force calls") {
  struct Turning {
    const bool* is_wrong;
    Plane operator()(const Plane& y) const { return {y[1], -std::sin(y[0]) - 0.01 * y[1]}; }
    Eigen::Matrix2d jacobian(const Plane& y) const {
      Eigen::Matrix2d J;
      J << 0, 1, -std::cos(y[0]), (*is_wrong ? -1 : -0.01);
      return J;
    }
  };
  const auto found_after = [](int changes, auto scheme, const auto&... solver) {
    bool is_wrong = false;
    Plane y(1, 0);
    PhiStepper stepper{y, Turning{&is_wrong}, scheme, solver...};
    CHECK(march(stepper, y, 0.01, changes).first == Outcome::success);
    const Statistics& done = stepper.statistics();
    if (changes >= 10000) CHECK(100 * done.checks < done.force_calls);
    is_wrong = true;
    const auto [outcome, steps] = march(stepper, y, 0.01, changes + 200);
    CHECK(outcome == Outcome::wrong_jacobian);
    return steps;
  };
  for (const int changes : {100, 10000}) {
    const int most = changes == 100 ? 50 : 128;
    CHECK(found_after(changes, rodas4) <= most);
    CHECK(found_after(changes, radau(5)) <= most);
    CHECK(found_after(changes, backward_euler, linearly_implicit()) <= most);
  }
}

TEST_CASE("radau under a tolerance tells a wrong Jacobian, which would damp its estimate") {
  for (const double by : {0.5, 2.0, 100.0, 1.01, 1.0}) {
    Plane y(2, 0.3);
    PhiStepper stepper{y, Relaxing{by}, radau};
    CAPTURE(by);
    const RunReport report = integrate(stepper, y, {0, 1}, tolerance{.rtol = 1e-6});
    CHECK(report.outcome == (by == 1 ? Outcome::success : Outcome::wrong_jacobian));
  }
}

TEST_CASE("a band that is too narrow is told, one that is not passes") {
  for (const double far : {0.0, 1.0, 40.0}) {
    Vec y(40);
    for (Index i = 0; i < y.size(); ++i) y[i] = std::sin(0.3 * static_cast<double>(i)) + 1.2;
    PhiStepper stepper{y, banded(Cells{far}, 1, 1), rodas4};
    CAPTURE(far);
    CHECK(march(stepper, y, 1e-2).first == (far > 0 ? Outcome::wrong_jacobian : Outcome::success));
    PhiStepper implicit{y, banded(Cells{far}, 1, 1), radau};
    CHECK(march(implicit, y, 1e-2, 3).first == (far > 0 ? Outcome::wrong_jacobian : Outcome::success));
  }
}

TEST_CASE("the tangents of a motion: either may be wrong") {
  for (const auto& [K, C] : {std::pair{1.0, 1.0}, std::pair{0.5, 1.0}, std::pair{1.0, 0.5}, std::pair{1.0, 0.0}}) {
    for (const bool rests : {false, true}) {
      Motion<Plane> y{Plane(1, 0.5), rests ? Plane(0, 0) : Plane(0.2, -0.3)};
      PhiStepper stepper{y, Pendulum{K, C}, rodas4};
      CAPTURE(K, C, rests);
      const bool right = K == 1 && C == 1;
      CHECK(march(stepper, y, 0.1).first == (right ? Outcome::success : Outcome::wrong_jacobian));
      Motion<Plane> z{Plane(1, 0.5), rests ? Plane(0, 0) : Plane(0.2, -0.3)};
      PhiStepper implicit{z, Pendulum{K, C}, radau};
      CHECK(march(implicit, z, 0.1).first == (right ? Outcome::success : Outcome::wrong_jacobian));
    }
  }
}

TEST_CASE("a force that has a kink, or bends strongly, keeps its right Jacobian") {
  struct Kink {
    Plane operator()(const Plane& y) const { return {-3 * std::abs(y[0]) - y[0], y[0] - 20 * std::max(y[1], 0.5)}; }
    Eigen::Matrix2d jacobian(const Plane& y) const {
      Eigen::Matrix2d J;
      J << (y[0] > 0 ? -4 : 2), 0, 1, (y[1] > 0.5 ? -20 : 0);
      return J;
    }
  };
  for (const Plane& start : {Plane(0, 0.5), Plane(1e-9, 0.5 + 1e-9), Plane(1, 0.5)}) {
    Plane y = start;
    PhiStepper stepper{y, Kink{}, rodas4};
    CHECK(march(stepper, y, 1e-3).first == Outcome::success);
  }
  struct Burning {
    Plane operator()(const Plane& y) const {
      const double rate = 1e8 * y[0] * std::exp(-2e4 / y[1]);
      return {-rate, 1000 * rate};
    }
    Eigen::Matrix2d jacobian(const Plane& y) const {
      const double k = 1e8 * std::exp(-2e4 / y[1]), bend = k * y[0] * 2e4 / (y[1] * y[1]);
      Eigen::Matrix2d J;
      J << -k, -bend, 1000 * k, 1000 * bend;
      return J;
    }
  };
  Plane y(1, 900);
  PhiStepper stepper{y, Burning{}, rodas4};
  const RunReport report = integrate(stepper, y, {0, 100}, tolerance{.rtol = 1e-6});
  CHECK(report);
  CHECK(y[1] == Approx(1900));
}

TEST_CASE("a root that ends at zero is no fault of the Jacobian") {
  struct Draining {
    Plane operator()(const Plane& y) const { return {-std::sqrt(y[0]), std::sqrt(y[0])}; }
    Eigen::Matrix2d jacobian(const Plane& y) const {
      Eigen::Matrix2d J;
      J << -0.5 / std::sqrt(y[0]), 0, 0.5 / std::sqrt(y[0]), 0;
      return J;
    }
  };
  Plane y(1e-12, 1);  // half of the differences would look where Ψ isn't defined
  PhiStepper stepper{y, Draining{}, rodas4};
  CHECK(march(stepper, y, 1e-9).first == Outcome::success);
}

TEST_CASE("an affine promise that is broken is told by linear stages, too") {
  Plane y(1, 0.5);
  PhiStepper stepper{y, affine([](const Plane& x) -> Plane { return {-x[0] * x[0], -30 * x[1]}; }), rodas4};
  CHECK(march(stepper, y, 0.05).first == Outcome::not_affine);
  Plane z(1, 0.5);
  PhiStepper kept{z, affine([](const Plane& x) -> Plane { return {-x[0] + 3 * x[1], -30 * x[1]}; }), rodas4};
  CHECK(march(kept, z, 0.05).first == Outcome::success);
  CHECK(kept.statistics().jacobians == 1);
}

TEST_CASE("what promises nothing is not checked, and costs nothing") {
  Plane y(2, 0.3);
  PhiStepper stepper{y, [](const Plane& x) { return Relaxing{}(x); }, rodas4};
  CHECK(march(stepper, y, 1e-3).first == Outcome::success);
  CHECK(stepper.statistics().checks == 0);
  PhiStepper newton{y, Relaxing{}, trapezoidal};  // an iteration notices by itself
  CHECK(march(newton, y, 1e-3).first == Outcome::success);
  CHECK(newton.statistics().checks == 0);
}
