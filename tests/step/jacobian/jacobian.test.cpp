#include <phistep/step/jacobian/analytic.hpp>
#include <phistep/step/jacobian/autodiff.hpp>
#include <phistep/step/jacobian/differences.hpp>
#include <phistep/study/checks/check_force.hpp>

#include <cmath>
#include <vector>

#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;

namespace jacobian_cases {

/// ∂Ψ/∂y of a force whose entries the test sets.
struct Given {
  Mat J;
  Vec operator()(const Vec& y) const { return Mat(true_J()) * y; }
  static Mat true_J() { return (Mat(3, 3) << 1, 2, 0, -4, 5, 6, 0, 0, 1e-3).finished(); }
  Mat jacobian(const Vec&) const { return J; }
};
struct Timed {
  auto operator()(const auto& y, double t) const {
    return typename std::remove_cvref_t<decltype(y)>::PlainObject(t * y);
  }
  Mat jacobian(const auto& y, double t) const { return t * Mat::Identity(y.size(), y.size()); }
};

inline auto damped_by_autodiff() {
  return autodiff([](const auto& r, const auto& v, double t) {
    std::remove_cvref_t<decltype(r)> f = r;
    for (Eigen::Index i = 0; i < r.size(); ++i) f[i] = -r[i] * r[i] * t - 0.5 * v[i];
    return f;
  });
}

}  // namespace jacobian_cases

using namespace jacobian_cases;

#if PHISTEP_QUICK

TEST_CASE("check_jacobian agrees with a right Jacobian and says so") {
  const JacobianCheck check = check_jacobian(Given{Given::true_J()}, Vec(Vec::Ones(3)));
  CHECK(check);
  CHECK_THAT(check.message(), contains("agrees"));
}

TEST_CASE("check_jacobian names any entry that is off") {
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = 0; j < 3; ++j)
      for (const double off : {0.01, -3.0}) {
        Given force{Given::true_J()};
        force.J(i, j) += off;
        const JacobianCheck check = check_jacobian(force, Vec(Vec::Ones(3)));
        CAPTURE(i, j, check.message());
        CHECK_FALSE(check);
        CHECK(check.row == i);
        CHECK(check.column == j);
        CHECK(check.given - check.differenced == Approx(off).epsilon(1e-6));
        CHECK_THAT(check.message(), contains("differs"));
      }
}

TEST_CASE("check_jacobian refuses an entry that is not a number, wherever it stands") {
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = 0; j < 3; ++j)
      for (const double bad : {std::nan(""), HUGE_VAL}) {
        Given force{Given::true_J()};
        force.J(i, j) = bad;
        const JacobianCheck check = check_jacobian(force, Vec(Vec::Ones(3)));
        CAPTURE(i, j, bad);
        CHECK_FALSE(check);
        CHECK(check.row == i);
        CHECK(check.column == j);
      }
}

TEST_CASE("check_jacobian tells K from C") {
  struct Swapped {
    Vec operator()(const Vec& r, const Vec& v) const { return -3 * r - 0.5 * v; }
    MotionJacobian<Mat> jacobian(const Vec&, const Vec&) const {
      return {-3 * Mat::Identity(2, 2), -0.7 * Mat::Identity(2, 2)};
    }
  };
  const JacobianCheck check = check_jacobian(Swapped{}, Motion<Vec>{Vec::Ones(2), Vec::Ones(2)});
  CHECK_FALSE(check);
  CHECK(check.matrix == 'C');
  CHECK(check.given == -0.7);
}

TEST_CASE("check_jacobian knows no units") {
  struct Cube {
    double unit;
    Vec operator()(const Vec& y) const { return (y.array() / unit).cube(); }
    Mat jacobian(const Vec& y) const { return (3 * (y.array() / unit).square() / unit).matrix().asDiagonal(); }
  };
  for (const double unit : {1e-12, 1.0, 1e19})
    CHECK(check_jacobian(Cube{unit}, Vec(unit * Eigen::Vector3d(1, -2, 0.5))));
}

TEST_CASE("check_jacobian works on views, matrices and at a time") {
  states::FirstOrder<states::Columns> columns;
  CHECK(check_jacobian(Timed{}, columns.state, 3.0));
}

TEST_CASE("automatic differentiation equals the exact derivative, in more than one chunk of directions") {
  auto coupled = autodiff([](const auto& y) {
    std::remove_cvref_t<decltype(y)> f = y;
    for (Eigen::Index i = 0; i < y.size(); ++i) f[i] = sin(y[i]) * y[(i + 1) % y.size()];
    return f;
  });
  for (const Eigen::Index n : {1, 7, 8, 9, 20}) {
    std::srand(3);
    const Vec y = Vec::Random(n);
    const Mat J = coupled.jacobian(y);
    Mat exact = Mat::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      exact(i, i) += std::cos(y[i]) * y[(i + 1) % n];
      exact(i, (i + 1) % n) += std::sin(y[i]);
    }
    CAPTURE(n);
    CHECK((J - exact).cwiseAbs().maxCoeff() <= 1e-15);
  }
}

TEST_CASE("automatic differentiation of a motion gives K and C at t") {
  auto force = damped_by_autodiff();
  const Eigen::Vector2d r(1, 2), v(3, 4);
  const auto J = force.jacobian(r, v, 10.0);
  CHECK(J.K.isApprox(Eigen::Matrix2d(Eigen::Vector2d(-20, -40).asDiagonal())));
  CHECK(J.C.isApprox(Eigen::Matrix2d(-0.5 * Eigen::Matrix2d::Identity())));
}

TEST_CASE("a difference is taken with the increment really made") {
  Vec y(4);
  y << 1e19, -3e-10, 0, 7;
  const Vec kept = y;
  std::vector<double> moved;
  for (Eigen::Index j = 0; j < y.size(); ++j) {
    const double delta = move_by_increment<false>(y[j], 16.0);
    CHECK(y[j] - kept[j] == delta);
    CHECK(delta != 0);
    moved.push_back(delta);
  }
  REQUIRE(moved.size() == 4);
  CHECK(moved[2] == Approx(std::sqrt(std::numeric_limits<double>::epsilon())).epsilon(1e-6));
}

TEST_CASE("increments for differences follow the unit that the numbers are in") {
  for (const double unit : {0x1p-80, 0x1p70}) {
    Vec y(3);
    y << 2, 0, -1e-4;
    Vec scaled = unit * y;
    std::vector<double> moved, moved_scaled;
    for (double& x : y) moved.push_back(move_by_increment<false>(x, 2.0));
    for (double& x : scaled) moved_scaled.push_back(move_by_increment<false>(x, 2.0 * unit) / unit);
    CHECK(moved_scaled == moved);
  }
}

TEST_CASE("entries are emitted once each, and a matrix of the wrong size throws") {
  Mat seen = Mat::Zero(3, 3);
  for_each_entry<Eigen::Dynamic>(Given::true_J(), 3,
                                 [&seen](Eigen::Index i, Eigen::Index j, double x) { seen(i, j) += x; });
  CHECK(seen == Given::true_J());
  CHECK_THROWS_AS((for_each_entry<Eigen::Dynamic>(Given::true_J(), 4, [](auto, auto, double) {})),
                  std::invalid_argument);
}

#elif PHISTEP_FULL

TEST_CASE("check_jacobian works on views, matrices and at a time") {
  states::FirstOrder<states::Strided> strided;
  CHECK(check_jacobian(Timed{}, strided.state, 3.0));
}

TEST_CASE("automatic differentiation of a motion gives K and C at t") {
  CHECK(check_jacobian(damped_by_autodiff(), Motion<Eigen::Vector2d>{{1, 2}, {3, 4}}, 10.0));
}

#endif
