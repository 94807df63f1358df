#include <phistep/base/state/motion.hpp>
#include <phistep/run/inside/dense_output.hpp>
#include <phistep/run/observers/completed_step.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "accuracy/observed_order.hpp"
#include "support/catch.hpp"

using namespace phistep;

namespace {

template <class Scalar>
using One = Eigen::Matrix<Scalar, 1, 1>;
template <class Scalar>
using Motion1 = Motion<One<Scalar>>;

/// A step of y = sin t from t0 over dt with exact data, its slopes counted.
template <class Scalar>
struct SineStep {
  SineStep(Scalar start, Scalar length) : t0{start}, dt{length}, y0{std::sin(t0)}, y1{std::sin(t0 + dt)} {
    dense.begin(t0, dt, t0 + dt, y0, y1, *this);
  }
  void operator()(One<Scalar>& slope0, One<Scalar>& slope1) {
    slope0(0) = std::cos(t0);
    slope1(0) = std::cos(t0 + dt);
    ++asked;
  }
  Scalar t0, dt;
  One<Scalar> y0, y1;
  int asked = 0;
  DenseOutput<One<Scalar>> dense;
};

/// A step of r = sin t, v = cos t with exact data.
template <class Scalar>
struct SineMotion {
  using S = Motion1<Scalar>;
  SineMotion(Scalar start, Scalar length) : t0{start}, dt{length}, y0{exact(t0)}, y1{exact(t0 + dt)} {
    dense.begin(t0, dt, t0 + dt, y0, y1, *this);
  }
  void operator()(S& slope0, S& slope1) const {
    slope0.v(0) = -std::sin(t0);
    slope1.v(0) = -std::sin(t0 + dt);
  }
  static S exact(Scalar t) { return {One<Scalar>{std::sin(t)}, One<Scalar>{std::cos(t)}}; }
  Scalar t0, dt;
  S y0, y1;
  DenseOutput<S> dense;
};

/// Largest error over all steps of a run through [0, 2], n steps.
template <class Step>
double largest(int n, auto&& error_of) {
  double worst = 0;
  for (int k = 0; k < n; ++k) {
    const double h = 2.0 / n;
    Step step(k * h, h);
    for (int i = 1; i < 40; ++i) {
      const double t = step.t0 + h * i / 40;
      worst = std::max(worst, error_of(step.dense.at(t), t));
    }
  }
  return worst;
}
const auto error_of_y = [](const auto& y, double t) { return std::abs(y(0) - std::sin(t)); };
const auto error_of_r = [](const auto& y, double t) { return std::abs(y.r(0) - std::sin(t)); };
const auto error_of_v = [](const auto& y, double t) { return std::abs(y.v(0) - std::cos(t)); };

}  // namespace

TEST_CASE("dense output: order 4, order 6 for the positions of a motion") {
  convergence::check_order(convergence::errors(4, [](int n) { return largest<SineStep<double>>(n, error_of_y); }), 4);
  convergence::check_order(convergence::errors(4, [](int n) { return largest<SineMotion<double>>(n, error_of_v); }), 4);
  // 16 steps at the finest: 0.125⁶/46080 = 8e-11 stands well above rounding.
  convergence::check_order(convergence::errors(2, [](int n) { return largest<SineMotion<double>>(n, error_of_r); }), 6);
}

TEST_CASE("dense output: the error's constants are h⁴/384 and h⁶/46080") {
  // In the middle of a step centred on π/2 every even derivative of sin t is ±1 up to h²/8 = 0.1 % or less.
  const double h = 0.1, middle = std::acos(0.0), t0 = middle - h / 2;
  SineStep<double> step(t0, h);
  CHECK(std::abs(step.dense.at(middle)(0) - 1) == Approx(std::pow(h, 4) / 384).epsilon(0.05));
  const double wide = 0.3;
  SineMotion<double> motion(middle - wide / 2, wide);
  CHECK(std::abs(motion.dense.at(middle).r(0) - 1) == Approx(std::pow(wide, 6) / 46080).epsilon(0.05));
}

TEST_CASE("dense output: cubics, and quintics of a motion, are met exactly") {
  // u times the number of roundings, a dozen of terms no larger than 6.
  const double bound = 12 * 6 * std::numeric_limits<double>::epsilon();
  for (const double dt : {0.5, -0.5}) {
    const auto cubic = [](double t) { return 1 + t - 2 * t * t + 3 * t * t * t; };
    const auto quintic = [](double t) { return 1 + t - t * t + t * t * t - t * t * t * t + t * t * t * t * t; };
    const auto speed = [](double t) { return 1 - 2 * t + 3 * t * t - 4 * t * t * t + 5 * t * t * t * t; };
    const auto bend = [](double t) { return -2 + 6 * t - 12 * t * t + 20 * t * t * t; };
    const double t0 = 0.25, t1 = t0 + dt;
    const One<double> y0{cubic(t0)}, y1{cubic(t1)};
    const auto slopes = [=](auto& s0, auto& s1) {
      s0(0) = 1 - 4 * t0 + 9 * t0 * t0;
      s1(0) = 1 - 4 * t1 + 9 * t1 * t1;
    };
    DenseOutput<One<double>> dense;
    dense.begin(t0, dt, t0 + dt, y0, y1, slopes);
    const Motion1<double> m0{One<double>{quintic(t0)}, One<double>{speed(t0)}},
        m1{One<double>{quintic(t1)}, One<double>{speed(t1)}};
    const auto accelerations = [=](auto& s0, auto& s1) {
      s0.v(0) = bend(t0);
      s1.v(0) = bend(t1);
    };
    DenseOutput<Motion1<double>> motion;
    motion.begin(t0, dt, t0 + dt, m0, m1, accelerations);
    for (int i = 1; i < 16; ++i) {
      const double t = t0 + dt * i / 16;
      CHECK(std::abs(dense.at(t)(0) - cubic(t)) <= bound);
      CHECK(std::abs(motion.at(t).r(0) - quintic(t)) <= bound);
    }
  }
}

TEMPLATE_TEST_CASE("dense output: both ends bit for bit, and smoothly into them", "", float, double, long double) {
  const auto u = std::numeric_limits<TestType>::epsilon();
  for (const TestType t0 : {TestType(0), TestType(0.1), TestType(-0.7), TestType(1000.1)})
    for (const TestType dt : {TestType(0.3), TestType(-0.3)}) {
      SineMotion<TestType> step(t0, dt);
      const TestType t1 = t0 + dt;
      CHECK(equal_blocks<Motion1<TestType>>(step.dense.at(t0), step.y0));
      CHECK(equal_blocks<Motion1<TestType>>(step.dense.at(t1), step.y1));
      // One time further in, r differs by v times that little time, no more than roundings of r ≤ 1.
      for (const auto& [t, end] : {std::pair{t0, step.y0}, std::pair{t1, step.y1}}) {
        const TestType in = std::nextafter(t, t == t0 ? t1 : t0);
        CHECK(std::abs(step.dense.at(in).r(0) - end.r(0)) <= std::abs(in - t) + 2 * u);
      }
    }
}

TEST_CASE("dense output: near an end of small values it is as accurate as they are") {
  // r falls from 1 to 0, where an event may look: r is v times the time left, to a few roundings of itself.
  for (const double dt : {1.0, -1.0}) {
    const Motion1<double> y0{One<double>{1.0}, One<double>{-1 / dt}}, y1{One<double>{0.0}, One<double>{-1 / dt}};
    const auto slopes = [](auto& s0, auto& s1) { s0.v(0) = s1.v(0) = 0; };
    DenseOutput<Motion1<double>> dense;
    dense.begin(0, dt, dt, y0, y1, slopes);
    for (const double left : {0x1p-10, 0x1p-30, 0x1p-50})
      CHECK(std::abs(dense.at(dt * (1 - left)).r(0) - left) <= 4 * std::numeric_limits<double>::epsilon() * left);
  }
}

TEST_CASE("dense output: an end that is not t0 + dt to the last bit, and times beyond the ends") {
  SineStep<double> step(0.1, 0.2);
  const double t1 = 0.3;  // 0.1 + 0.2 is the next number
  REQUIRE(t1 != 0.1 + 0.2);
  step.dense.begin(0.1, 0.2, t1, step.y0, step.y1, step);
  CHECK(&step.dense.at(t1) == &step.y1);
  CHECK(&step.dense.at(0.4) == &step.y1);
  CHECK(&step.dense.at(0.0) == &step.y0);
}

TEST_CASE("dense output: slopes are asked for once a step, and only by a look inside") {
  SineStep<double> step(0, 1);
  (void)step.dense.at(0), (void)step.dense.at(1);
  CHECK(step.asked == 0);
  for (int i = 1; i < 10; ++i) (void)step.dense.at(0.1 * i);
  CHECK(step.asked == 1);
  step.dense.begin(0, 1, 1, step.y0, step.y1, step);
  (void)step.dense.at(0.5);
  CHECK(step.asked == 2);
}

TEST_CASE("dense output: units of length and time that are powers of two change no bit") {
  const double length = 0x1p-40, time = 0x1p30;
  SineMotion<double> step(0.1, 0.3);
  Motion1<double> y0{step.y0.r * length, step.y0.v * (length / time)};
  Motion1<double> y1{step.y1.r * length, step.y1.v * (length / time)};
  const auto slopes = [&](auto& s0, auto& s1) {
    step(s0, s1);
    s0.v *= length / time / time;
    s1.v *= length / time / time;
  };
  DenseOutput<Motion1<double>> dense;
  dense.begin(0.1 * time, 0.3 * time, 0.1 * time + 0.3 * time, y0, y1, slopes);
  for (int i = 0; i <= 16; ++i) {
    const double t = 0.1 + 0.3 * i / 16;
    CHECK(dense.at(t * time).r(0) == step.dense.at(t).r(0) * length);
    CHECK(dense.at(t * time).v(0) == step.dense.at(t).v(0) * (length / time));
  }
}

TEST_CASE("dense output: dynamic sizes, which may change from step to step; a Map's plain twin") {
  using Map = Eigen::Map<Eigen::VectorXd>;
  DenseOutput<Map> dense;
  for (const Index n : {3, 3, 5, 2}) {
    const Eigen::VectorXd y0 = Eigen::VectorXd::Zero(n), y1 = Eigen::VectorXd::Ones(n);
    const auto slopes = [n](Eigen::VectorXd& s0, Eigen::VectorXd& s1) {
      REQUIRE(s0.size() == n);
      s0.setOnes();
      s1.setOnes();
    };
    dense.begin(0, 1, 1, y0, y1, slopes);
    CHECK((dense.at(0.25).array() - 0.25).abs().maxCoeff() < 1e-15);
  }
}

TEST_CASE("a completed step shows its ends and what lies between") {
  SineStep<double> step(0.1, 0.2);
  step.dense.begin(0.1, 0.2, 0.3, step.y0, step.y1, step);
  const CompletedStep<One<double>> done(0.1, 0.2, 0.3, step.y0, step.y1, step.dense);
  CHECK(done.t0() == 0.1);
  CHECK(done.t1() == 0.3);
  CHECK(done.dt() == 0.2);
  CHECK(&done.start() == &step.y0);
  CHECK(&done.end() == &step.y1);
  CHECK(&done.at(done.t1()) == &step.y1);
  CHECK(done.at(0.2)(0) == Approx(std::sin(0.2)).epsilon(1e-5));
}
