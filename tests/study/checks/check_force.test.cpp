// Whether a force is told from one that reads arrays of its own, or changes from call to call.
#include <phistep/particles.hpp>
#include <phistep/phistep.hpp>

#include <cmath>
#include <limits>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace {

using Vec = Eigen::VectorXd;
const Motion<Vec> at_rest{Vec::LinSpaced(6, 1, 2), Vec::Zero(6)};

/// An existing code: its arrays, and a routine that reads and writes them.
struct OldCode {
  std::vector<double> x = std::vector<double>(6, 1.0), f = std::vector<double>(6);
  void compute_forces() {
    for (std::size_t i = 0; i < x.size(); ++i) f[i] = -4 * x[i];
  }
};

}  // namespace

TEST_CASE("check_force: a force that reads its argument passes, and what it depends on is said") {
  const auto spring = check_force([](const Vec& r) -> Vec { return -r; }, at_rest);
  CHECK(spring);
  CHECK(spring.depends_on == std::array{true, false});
  CHECK_THAT(spring.message(), contains("depends on r") && !contains("v"));
  const auto damped = check_force([](const Vec& r, const Vec& v) -> Vec { return -r - 0.1 * v; }, at_rest);
  CHECK(damped.depends_on == std::array{true, true});
  CHECK(check_force(LinearDrag{0.3}, at_rest).depends_on == std::array{false, true});
  const auto first_order = check_force([](const Vec& y) -> Vec { return -y; }, Vec(Vec::Zero(3)));
  CHECK(first_order);
  CHECK_THAT(first_order.message(), contains("depends on y"));
}

TEST_CASE("check_force and check_jacobian take a force that is const: a sum, a local one") {
  const auto sum = linear(-Eigen::MatrixXd::Identity(6, 6)) + LinearDrag{0.3};
  CHECK(check_force(sum, at_rest).depends_on == std::array{true, true});
  CHECK(check_jacobian(sum, at_rest));
  const auto wells = local<3>([](const Eigen::Vector3d& r) -> Eigen::Vector3d { return -r.squaredNorm() * r; });
  CHECK(check_force(wells, at_rest));
}

TEST_CASE("check_force: a force that reads the arrays of the code around it is told") {
  OldCode code;
  const auto its_own = [&code](const Vec&) -> Vec {
    code.compute_forces();
    return Eigen::Map<const Vec>(code.f.data(), 6);
  };
  const auto check = check_force(its_own, at_rest);
  CHECK_FALSE(check);
  CHECK(check.is_repeatable);
  CHECK_FALSE(check.sees_state());
  CHECK_THAT(check.message(), contains("arrays of its own"));
  // With what it is called with in them it passes.
  CHECK(check_force(
      [&code](const Vec& r) -> Vec {
        Eigen::Map<Vec>(code.x.data(), 6) = r;
        code.compute_forces();
        return Eigen::Map<const Vec>(code.f.data(), 6);
      },
      at_rest));
  // A constant force can't be told from it.
  CHECK_FALSE(check_force(Gravity{Eigen::Vector2d(0, -1)}, at_rest));
}

TEST_CASE("check_force: a force that is another one at each call is told") {
  int calls = 0;
  const auto drifting = check_force([&calls](const Vec& r) -> Vec { return -(1 + 1e-12 * ++calls) * r; }, at_rest);
  CHECK_FALSE(drifting);
  CHECK_THAT(drifting.message(), contains("called again"));
  // One that keeps what it saw last: right at once, wrong after other states.
  Vec last = Vec::Zero(6);
  const auto remembering = [&last](const Vec& r) -> Vec {
    Vec f = last.isZero() || r == last ? Vec(-r) : Vec(-(r + last) / 2);
    last = r;
    return f;
  };
  CHECK_FALSE(check_force(remembering, at_rest).is_repeatable);
}

TEST_CASE("check_force: a force that isn't finite, one of pairs with its lists, one of float") {
  CHECK_FALSE(check_force([](const Vec& r) -> Vec { return r.array().log() - std::numeric_limits<double>::infinity(); },
                          at_rest)
                  .is_finite);
  const Particles<double, 2> atoms{(Eigen::Matrix2Xd(2, 3) << 0, 1.1, 2.3, 0, 0.1, -0.1).finished()};
  CHECK(check_force(Pairs{LennardJones{}, 2.5}, atoms));
  const Eigen::Vector2f y(1, 0);
  CHECK(check_force([](const Eigen::Vector2f& x) -> Eigen::Vector2f { return -x; }, y));
}

namespace {
/// Springs to where the step began.
struct Anchored : ForceTerm {
  struct Memory {
    Vec anchor;
  };
  static constexpr bool uses_velocity = false;
  static void begin(double, double, const auto& y, Memory& m) { m.anchor = y.r; }
  static void add(double, const auto& y, const Memory& m, auto& out) {
    out.force -= (y.r - m.anchor).array().sinh().matrix();
  }
  static void add_jacobian(double, const auto& y, const Memory& m, auto& sink) {
    for (Eigen::Index i = 0; i < y.r.size(); ++i) sink.position(i, i, -std::cosh(y.r[i] - m.anchor[i]));
  }
  static void commit(double, const auto&, Memory&) {}
};
}  // namespace

TEST_CASE("check_jacobian begins a step of a force with a history") {
  const JacobianCheck check = check_jacobian(Anchored{}, at_rest);
  CHECK(check);
  CHECK(check.given == -1);
}
