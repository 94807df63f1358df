// Linear combinations of states: the bits of the same formula block by block, for every kind of state.
#include <phistep/base/state/combination.hpp>
#include <phistep/base/state/motion.hpp>

#include <array>
#include <limits>

#include "support/catch.hpp"

using namespace phistep;

namespace {

struct Spray {
  Eigen::VectorXf r, v, T;
  static constexpr bool drifts = true;
  static auto blocks(auto& y) { return std::tie(y.r, y.v, y.T); }
  struct Rate {
    Eigen::VectorXf force, heat;
    static auto blocks(auto& rate) { return std::tie(rate.force, rate.heat); }
  };
};

struct Table {
  static constexpr long double a[2][4] = {{}, {0.3L, 0, -1.7L, 5}};
};
using Row = TableRow<Table::a, 1, 3>;

}  // namespace

TEST_CASE("a combination is its formula, block by block, to the bit") {
  using Vector = Eigen::Vector3d;
  const Motion<Vector> a{{1, 2, 3}, {0.1, 0.2, 0.3}}, b{{-4, 5, 0.6}, {7, 8, -0.9}};
  Motion<Vector> to{Vector::Zero(), Vector::Zero()};
  const double h = 0.3;
  assign<Motion<Vector>>(to, in<Motion<Vector>>(a) + h * (in<Motion<Vector>>(b) - in<Motion<Vector>>(a)) / 7.0);
  CHECK(to.r == Vector(a.r + h * (b.r - a.r) / 7.0));
  CHECK(to.v == Vector(a.v + h * (b.v - a.v) / 7.0));
  add<Motion<Vector>>(to, 2.0 * in<Motion<Vector>>(b));
  CHECK(to.v == Vector(Vector(a.v + h * (b.v - a.v) / 7.0) + 2.0 * b.v));
}

TEST_CASE("the state assigned to may occur in its own combination") {
  Eigen::VectorXd y = Eigen::VectorXd::LinSpaced(9, 1, 2);
  const Eigen::VectorXd kept = y, x = Eigen::VectorXd::LinSpaced(9, -3, 5);
  assign<Eigen::VectorXd>(y, in<Eigen::VectorXd>(x) - 0.5 * in<Eigen::VectorXd>(y));
  CHECK(y == Eigen::VectorXd(x - 0.5 * kept));
}

TEST_CASE("assign_solved leaves the positions alone") {
  const auto vector = [](float x) { return Eigen::VectorXf::Constant(2, x); };
  Spray to{vector(1), vector(2), vector(3)};
  const Spray from{vector(4), vector(5), vector(6)};
  assign_solved<Spray>(to, 2.0F * in<Spray>(from));
  CHECK((to.r == vector(1) && to.v == vector(10) && to.T == vector(12)));
}

TEST_CASE("a weighted sum over stages is summed from the left, without its zeros") {
  using Vector = Eigen::Vector2d;
  using Y = Motion<Vector>;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::array<Y, 4> k{Y{{11, 2}, {3, 4}}, Y{{nan, nan}, {nan, nan}}, Y{{5, 6.3}, {7, 8}}, Y{{1, 1}, {1, 1}}};
  const Y y{{1e16, 0.1}, {0.2, 0.3}};
  Y to = y;
  assign<Y>(to, weighted_sum<Y, Row>(k));
  CHECK(to.v == Vector(0.3 * k[0].v + -1.7 * k[2].v));
  assign<Y>(to, in<Y>(y) + weighted_sum<Y, Row>(k));
  CHECK(to.r == Vector((y.r + 0.3 * k[0].r) + -1.7 * k[2].r));
  CHECK(to.r != Vector(y.r + (0.3 * k[0].r + -1.7 * k[2].r)));
}

TEST_CASE("a rate in an expression stands for the solved blocks") {
  const auto vector = [](float x) { return Eigen::VectorXf::Constant(2, x); };
  Spray to{vector(1), vector(2), vector(3)};
  const Spray::Rate psi{vector(10), vector(20)};
  add_solved<Spray>(to, 0.5F * in_rate<Spray>(psi));
  CHECK((to.r == vector(1) && to.v == vector(7) && to.T == vector(13)));
  assign_solved<Spray>(to, in_rate<Spray>(psi) - in<Spray>(to));
  CHECK((to.r == vector(1) && to.v == vector(3) && to.T == vector(7)));
}
