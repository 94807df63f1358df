// A rate that falls: the error that a large L has hidden is carried on, and the estimate must have seen it.
#include "accuracy/falling_rates_cases.hpp"
#include "support/catch.hpp"

// Beside each number a few more are let pass: rounding decides some members.
#if PHISTEP_STRESS
constexpr int members = 400, known_unknown = 8, known_samples = 26;
#elif PHISTEP_FULL
constexpr int members = 100, known_unknown = 2, known_samples = 14;
#endif

using falling_rates::Answers;

namespace {

const Answers& answers() {
  static const Answers all = [] {
    Answers of{"falling rates"};
    falling_rates::ask(of, members, "radau", falling_rates::by(phistep::radau));
    falling_rates::ask(of, members, "rodas5p", falling_rates::by(phistep::rodas5p));
    falling_rates::ask(of, members, "rodas4p2", falling_rates::by(phistep::rodas4p2));
    falling_rates::ask(of, members, "tr_bdf2", falling_rates::by(phistep::tr_bdf2));
    return of;
  }();
  return all;
}

}  // namespace

TEST_CASE("falling rates: hardly any is wrong") {
  falling_rates::tell_calls(answers());
  battery::at_most(known_unknown, answers().unknown);
}
TEST_CASE("falling rates: none is wrong where steps end on the jumps") { battery::at_most(0, answers().known); }
// Where the run without samples succeeds.
TEST_CASE("falling rates: samples make no run fail") { battery::at_most(0, answers().sampled_runs); }

// Where the ends of all steps are right.
TEST_CASE("falling rates, samples: no more are wrong than known") {
  battery::at_most(known_samples, answers().samples);
}
TEST_CASE("falling rates, samples: none is wrong", "[!shouldfail][48]") { battery::none(answers().samples); }

// y₁' = −k (y₁ − cos t) with k = 1e14: the filtered error of y₁ is less than a rounding of it.
TEST_CASE("a rate that stays is none that falls, however large") {
  const auto steps = [](auto scheme, double k) {
    const auto rate = [k](const Eigen::Vector2d& y, double t) -> Eigen::Vector2d {
      return {-k * (y[0] - std::cos(t)), y[0] - y[1] + std::sin(3 * t)};
    };
    Eigen::Vector2d y{0, 1};
    phistep::PhiStepper stepper{y, rate, scheme};
    const auto report =
        phistep::integrate(stepper, y, {0, 10}, phistep::tolerance{.rtol = 1e-5, .atol = 1e-8, .max_steps = 20000});
    CHECK(std::abs(y[0] - std::cos(10.0)) <= 1e-4);
    return report ? static_cast<double>(report.statistics.steps + report.statistics.rejections) : 1e300;
  };
  const auto compare = [&](auto scheme) {
    for (const double k : {1e10, 1e12, 1e14}) CHECK(steps(scheme, k) <= 1.5 * steps(scheme, 1e6) + 10);
  };
  compare(phistep::tr_bdf2);
  compare(phistep::trapezoidal);
  compare(phistep::radau);
  compare(phistep::rodas5p);
  compare(phistep::rodas4);
}

TEST_CASE("a motion whose drag falls by seven decades: v = cos t all the same") {
  const auto drag = [](const Eigen::VectorXd&, const Eigen::VectorXd& v, double t) -> Eigen::VectorXd {
    const double rate = std::sin(t) > 0 ? 1e6 : 0.1;
    return Eigen::VectorXd::Constant(v.size(), -std::sin(t)) - rate * (v.array() - std::cos(t)).matrix();
  };
  const auto worst = [&](auto scheme, double rtol) {
    phistep::Motion<Eigen::VectorXd> y{Eigen::VectorXd::Constant(2, std::sin(0.1)),
                                       Eigen::VectorXd::Constant(2, std::cos(0.1))};
    phistep::PhiStepper stepper{y, drag, scheme};
    double off = 0;
    const auto look = [&](double t, const auto& now) {
      off = std::max(off, (now.v.array() - std::cos(t)).abs().maxCoeff());
    };
    const bool done{phistep::integrate(stepper, y, {0.1, 12}, phistep::tolerance{.rtol = rtol, .atol = rtol}, look)};
    return done ? off / rtol : 1e300;
  };
  for (const double rtol : {1e-3, 1e-5}) {
    CAPTURE(rtol);
    CHECK(worst(phistep::radau, rtol) <= 100);
    CHECK(worst(phistep::rodas5p, rtol) <= 100);
    CHECK(worst(phistep::tr_bdf2, rtol) <= 100);
  }
}
