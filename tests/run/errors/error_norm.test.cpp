#include <phistep/base/state/motion.hpp>
#include <phistep/run/errors/error_norm.hpp>

#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Columns = Eigen::Matrix3Xd;
using RowMajor = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;

namespace {

const double NaN = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();

template <class Plain>
ErrorNorm<Plain> norm_of(const tolerance& wanted, const Plain& y) {
  ErrorNorm<Plain> norm;
  REQUIRE(norm.begin(wanted, y));
  return norm;
}
template <class Plain>
bool works(const tolerance& wanted, const Plain& y) {
  return ErrorNorm<Plain>{}.begin(wanted, y);
}

}  // namespace

TEST_CASE("rms over all components, weighted by the larger of both ends") {
  const Vec y = Eigen::Vector3d(1, -2, 0), next = Eigen::Vector3d(-3, 1, 0.5), e = Eigen::Vector3d(1e-3, 2e-3, -3e-3);
  auto norm = norm_of<Vec>({.rtol = 1e-2, .atol = 1e-3}, y);
  const double a = 1e-3 / (1e-3 + 3e-2), b = 2e-3 / (1e-3 + 2e-2), c = 3e-3 / (1e-3 + 0.5e-2);
  const Measured got = norm(e, y, next);
  CHECK(got.size() == Approx(std::sqrt((a * a + b * b + c * c) / 3)).epsilon(1e-15));
  CHECK(got.worst == Component{0, 2});
}

TEST_CASE("absolute tolerances: everywhere, per block, per component in storage order") {
  Motion<Vec> y{Eigen::Vector2d(1, -4), Eigen::Vector2d(0, 200)}, weight = y;
  const double rtol = 0.01;
  const auto weights = [&](const AbsoluteTolerance& atol) {
    auto norm = norm_of<Motion<Vec>>({.rtol = rtol, .atol = atol}, y);
    norm.weigh(y, weight);
    return Eigen::Vector4d(weight.r[0], weight.r[1], weight.v[0], weight.v[1]).cwiseInverse().eval();
  };
  const Eigen::Vector4d relative(0.01, 0.04, 0, 2);
  CHECK((weights(0.5) - relative).isApproxToConstant(0.5, 1e-14));
  CHECK((weights({0.5, 3.0}) - relative).isApprox(Eigen::Vector4d(0.5, 0.5, 3, 3), 1e-14));
  const Eigen::Vector4d each(1, 2, 3, 4);
  CHECK((weights(each) - relative).isApprox(each, 1e-14));
  CHECK((weights(std::vector<double>{1, 2, 3, 4}) - relative).isApprox(each, 1e-14));
}

TEST_CASE("tolerances that can't work are refused") {
  const Motion<Vec> y{Vec::Ones(2), Vec::Ones(2)};
  for (const double rtol : {0.0, -1e-3, 1.0, 2.0, NaN, inf}) CHECK_FALSE(works({.rtol = rtol}, y));
  for (const double atol : {-1.0, NaN, inf}) {
    CHECK_FALSE(works({.atol = atol}, y));
    CHECK_FALSE(works({.atol = {1.0, atol}}, y));
    CHECK_FALSE(works({.atol = Vec(Eigen::Vector4d(1, 1, atol, 1))}, y));
  }
  CHECK_FALSE(works({.atol = {1.0, 1.0, 1.0}}, y));
  CHECK_FALSE(works({.atol = Vec(Vec::Ones(3))}, y));
  CHECK_FALSE(works({.atol = Vec(Vec::Ones(5))}, y));
  CHECK_FALSE(works({.atol = Vec(0)}, y));
  CHECK(works({.atol = 0.0}, y));
  CHECK(works({.atol = {0.0, 1.0}}, y));
  CHECK(works({.atol = Vec(Vec::Zero(4))}, y));
}

TEMPLATE_TEST_CASE("without atol each component is measured by its own size, whatever the others are", "", Vec,
                   Eigen::Vector3d) {
  const double rtol = 1e-3;
  const auto scale = [](ErrorNorm<TestType>& norm, const TestType& y, const TestType& next, int i) {
    TestType e = TestType::Zero(3);
    e[i] = 1;
    return 1 / (std::sqrt(3.0) * norm(e, y, next).size());
  };
  TestType y = Eigen::Vector3d(2, 1e-9, 0.5), weight = y;
  auto norm = norm_of<TestType>({.rtol = rtol}, y);
  norm.weigh(y, weight);
  for (int i = 0; i < 3; ++i) {
    CHECK(scale(norm, y, y, i) == Approx(rtol * y[i]));
    CHECK(1 / weight[i] == Approx(rtol * y[i]));
  }
  // What y⁺ becomes counts up to ten times what y was: a step that runs away doesn't loosen the test that it is to fail.
  const TestType next = Eigen::Vector3d(-4, 1, 0.1);
  CHECK(scale(norm, y, next, 0) == Approx(rtol * 4));
  CHECK(scale(norm, y, next, 1) == Approx(rtol * 1e-8));
  CHECK(scale(norm, y, next, 2) == Approx(rtol * 0.5));
}

TEST_CASE("a size fades by a factor of 5 in the longest step of late, and never below 1e-9 of the largest") {
  const double rtol = 1e-3;
  Vec y = Eigen::Vector2d(1, 7);
  auto norm = norm_of<Vec>({.rtol = rtol}, y);
  Vec weight = y;
  const auto size_after = [&](double dt, double of_next) {
    norm.weigh(y, weight);
    norm.automatic().begin_try(dt);
    norm.automatic().accepted();
    y[0] = of_next;
    norm.weigh(y, weight);
    return 1 / (rtol * weight[0]);
  };
  CHECK(size_after(0.1, 0) == Approx(0.2));
  CHECK(size_after(0.05, 0) == Approx(0.2 * std::pow(0.2, 0.05 / 0.08)));  // the longest counts 0.8 a step later
  CHECK(size_after(0.2, 0.5) == Approx(0.5));
  for (int k = 0; k < 30; ++k) static_cast<void>(size_after(1, 0));
  CHECK(size_after(1, 0) == Approx(1e-9));
  // A try that is rejected doesn't fade it, however often.
  y[0] = 1;
  norm.weigh(y, weight);
  for (int k = 0; k < 5; ++k) {
    norm.automatic().begin_try(std::ldexp(1.0, -k));
    norm.weigh(y, weight);
  }
  CHECK(size_after(0.01, 0) == Approx(std::pow(0.2, 0.01)));  // the longest was 1
}

TEST_CASE("numbers of one kind: no size is below 1e-3 of the largest in a matrix' row, a motion's matrix, a quantity") {
  const double rtol = 0.01;
  const Columns one = (Columns(3, 2) << 1, 0, 0.5, 1e-12, 0, 0).finished();
  Columns weight = one;
  auto rows = norm_of<Columns>({.rtol = rtol}, one);
  rows.weigh(one, weight);
  CHECK(1 / weight(0, 1) == Approx(rtol * 1e-3));
  CHECK(1 / weight(1, 1) == Approx(rtol * 5e-4));
  CHECK(weight(2, 0) == 0);

  const Motion<Columns> moving{one, 1e6 * one};
  Motion<Columns> weights = moving;
  auto motion = norm_of<Motion<Columns>>({.rtol = rtol}, moving);
  motion.weigh(moving, weights);
  CHECK(1 / weights.r(2, 0) == Approx(rtol * 1e-3));
  CHECK(1 / weights.v(2, 1) == Approx(rtol * 1e3));

  const Vec y = Eigen::Vector4d(3, 0, 0, 5);
  Vec of_parts = y;
  const tolerance first_two{.rtol = rtol, .atol = quantity(0, 2)},
      each_second{.rtol = rtol, .atol = {quantity(0, 2, 2), quantity(1, 2, 2)}};
  auto parts = norm_of<Vec>(first_two, y);
  parts.weigh(y, of_parts);
  CHECK(1 / of_parts[1] == Approx(rtol * 3e-3));
  CHECK(of_parts[2] == 0);
  auto strided = norm_of<Vec>(each_second, y);
  strided.weigh(y, of_parts);
  CHECK(1 / of_parts[2] == Approx(rtol * 3e-3));
  CHECK(1 / of_parts[1] == Approx(rtol * 5e-3));
  for (const Quantity& bad :
       {quantity(0, 5), quantity(3, 2), quantity(-1, 1), quantity(0, -1), quantity(0, 2, 0), quantity(0, 3, 2)})
    CHECK_FALSE(works({.atol = bad}, y));
  CHECK(works({.atol = quantity(4, 0)}, y));
}

TEST_CASE("what rounding makes of a component is no error of it") {
  const Vec y = Eigen::Vector2d(1, 1e-20), e = Eigen::Vector2d(0, 1e-20);
  auto norm = norm_of<Vec>({.rtol = 0.01}, y);
  Vec weight = y;
  norm.weigh(y, weight);
  CHECK(norm(e, y, y).size() == Approx(100 / std::sqrt(2.0)));
  norm.automatic().learn_noise(1, 1e-17);
  CHECK(norm(e, y, y).size() == Approx(1e-3 / std::sqrt(2.0)).epsilon(1e-4));
  norm.weigh(y, weight);
  CHECK(1 / weight[0] == Approx(0.01));
}

TEST_CASE("a try that overshot and was rejected leaves no mark on an automatic atol") {
  const Vec y = Eigen::Vector3d(1, 0.5, 0), wild = Eigen::Vector3d(1e30, -1e30, 1e30),
            e = Eigen::Vector3d(1e-3, 1e-3, 1e-3);
  auto norm = norm_of<Vec>({.rtol = 0.01}, y), fresh = norm;
  Vec weight = y, expected = y;
  norm.weigh(y, weight);
  fresh.weigh(y, expected);
  CHECK(norm(wild, y, wild).size() > 1);
  norm.weigh(y, weight);
  CHECK(weight == expected);
  CHECK(norm(e, y, y).size() == fresh(e, y, y).size());
}

TEST_CASE("a state that starts at zero is measured by what it becomes, or by what a try has shown") {
  const Vec zero = Vec::Zero(2), next = Eigen::Vector2d(0.5, 2), e = Eigen::Vector2d(0.01, 0.01);
  auto norm = norm_of<Vec>({.rtol = 0.01}, zero);
  Vec weight = zero;
  norm.weigh(zero, weight);
  CHECK(weight == zero);
  CHECK(norm(e, zero, next).size() == Approx(std::hypot(0.01 / 0.005, 0.01 / 0.02) / std::sqrt(2.0)));
  norm.automatic().bear(0, 3);
  CHECK(norm(e, zero, next).size() == Approx(std::hypot(0.01 / 0.03, 0.01 / 0.02) / std::sqrt(2.0)));
  // No error is none, an error in nothing is infinite.
  CHECK(norm_of<Vec>({.rtol = 0.01, .atol = 0.0}, zero)(zero, zero, zero).size() == 0);
  CHECK(norm_of<Vec>({.rtol = 0.01, .atol = 0.0}, zero)(e, zero, zero).size() == inf);
}

TEST_CASE("one bad particle of ten thousand shows in the particle norm alone") {
  const Index n = 10'000;
  const Motion<Columns> y{Columns::Ones(3, n), Columns::Ones(3, n)};
  Motion<Columns> e{Columns::Constant(3, n, 1e-9), Columns::Constant(3, n, 1e-9)};
  e.v(1, 777) = 1;
  e.v(2, 777) = 0.5;
  auto rms = norm_of<Motion<Columns>>({.rtol = 0.01, .atol = 0.0}, y);
  auto particle = norm_of<Motion<Columns>>({.rtol = 0.01, .atol = 0.0, .norm = Norm::particle}, y);
  CHECK(rms(e, y, y).size() < 0.5);
  const Measured got = particle(e, y, y);
  CHECK(got.size() == Approx(std::sqrt((1e4 + 0.25e4) / 3)).epsilon(1e-6));
  CHECK(got.worst == Component{1, 3 * 777 + 1});
}

TEST_CASE("a particle is a column, however the block is stored") {
  const Index n = 5;
  const RowMajor y = RowMajor::Ones(3, n);
  RowMajor e = RowMajor::Zero(3, n);
  e.col(2) << 0.03, 0.04, 0;
  e(0, 4) = 0.045;
  auto norm = norm_of<RowMajor>({.rtol = 0.01, .atol = 0.0, .norm = Norm::particle}, y);
  const Measured got = norm(e, y, y);
  CHECK(got.size() == Approx(5 / std::sqrt(3.0)));
  CHECK(got.worst == Component{0, 1 * n + 2});  // storage order
}

TEST_CASE("a single particle is one, in a matrix; in a vector each component stands for itself") {
  const Columns one = Columns::Ones(3, 1);
  const Columns e = (Columns(3, 1) << 0.03, 0.04, 0).finished();
  CHECK(norm_of<Columns>({.rtol = 0.01, .atol = 0.0, .norm = Norm::particle}, one)(e, one, one).size() ==
        Approx(5 / std::sqrt(3.0)));
  const Vec y = Vec::Ones(3), d = e.col(0);
  CHECK(norm_of<Vec>({.rtol = 0.01, .atol = 0.0, .norm = Norm::particle}, y)(d, y, y).size() == Approx(4));
}

TEST_CASE("an error that is no number is never small") {
  const Columns y = Columns::Ones(3, 4);
  for (const Norm which : {Norm::rms, Norm::particle})
    for (Index k = 0; k < y.size(); ++k) {
      Columns e = Columns::Constant(3, 4, 1e-9);
      e.data()[k] = NaN;
      auto norm = norm_of<Columns>({.rtol = 0.01, .atol = 0.0, .norm = which}, y);
      CHECK_FALSE(norm(e, y, y).size() <= 1);
    }
  const Columns all = Columns::Constant(3, 4, NaN);
  CHECK_FALSE(norm_of<Columns>({.norm = Norm::particle}, y)(all, y, y).size() <= 1);
}

TEST_CASE("many numbers by packs: the same norm, worst component, weights and sizes as one by one") {
  for (const bool has_atol : {true, false})
    for (int n = 1; n <= 41; ++n) {
      const Vec y = Vec::Random(n), next = Vec::Random(n);
      Vec error = 1e-3 * Vec::Random(n);
      const int bad = 7 * n / 11;
      error[bad] = 0.1;
      tolerance wanted{.rtol = 1e-3};
      if (has_atol) wanted.atol = 1e-4;
      ErrorNorm<Vec> norm;
      REQUIRE(norm.begin(wanted, y));
      Vec weight(n);
      CHECK(norm.weigh(y, weight));
      double sum = 0, most = -1;
      int worst = 0;
      for (int i = 0; i < n; ++i) {
        const double size = std::max(std::abs(y[i]), std::abs(next[i])), own = std::abs(y[i]);
        const double scale = has_atol ? 1e-4 + 1e-3 * size : 1e-3 * std::max(own, std::min(size, 10 * own));
        const double x = std::pow(error[i] / scale, 2);
        sum += x;
        if (x > most) most = x, worst = i;
        CHECK(weight[i] == Approx(1 / ((has_atol ? 1e-4 : 0) + 1e-3 * own)).epsilon(1e-14));
      }
      const Measured found = norm(error, y, next);
      CHECK(found.square == Approx(sum / n).epsilon(1e-13));
      CHECK(found.worst.index == worst);
      Vec twice = error;
      twice[n / 2] = NaN;
      CHECK(std::isnan(norm(twice, y, next).square));
    }
}

TEST_CASE("an empty state has no error") {
  const Vec none(0);
  CHECK(norm_of<Vec>({}, none)(none, none, none).size() == 0);
  CHECK(norm_of<Vec>({.norm = Norm::particle}, none)(none, none, none).size() == 0);
}

TEST_CASE("floats far from one neither overflow nor vanish") {
  // Weighted squares of 1e25 do not fit a float, those of 1e-25 are nothing in one.
  using V = Eigen::VectorXf;
  const V y = V::Constant(2, 1);
  auto norm = norm_of<V>({.rtol = 0.01, .atol = 0.0}, y);
  CHECK(norm(V::Constant(2, 1e23f), y, y).size() == Approx(1e25).epsilon(1e-5));
  CHECK(norm(V::Constant(2, 1e-27f), y, y).size() == Approx(1e-25).epsilon(1e-5));
}
