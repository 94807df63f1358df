// What strangers found where components begin at exactly zero, or begin again, and no atol is given.
#include <phistep/automatic.hpp>
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;

namespace {

struct Problem {
  std::function<Vec(const Vec&, double)> rate;
  Vec start;
  double end;
  Vec mass = {};                                // none: 1
  std::vector<double> times = {};               // when …
  std::function<void(double, Vec&)> edit = {};  // … this is done
};

/// The largest error beside the largest number of each component, in units of rtol; 1e300 where the run fails.
class Errors {
 public:
  explicit Errors(Problem problem) : problem_{std::move(problem)} {
    Vec y = problem_.start, most = y.cwiseAbs();
    const auto look = [&most](double, const Vec& now) { most = most.cwiseMax(now.cwiseAbs()); };
    REQUIRE(run(y, radau, tolerance{.rtol = 1e-11, .atol = 1e-18}, look));
    exact_ = y, size_ = most;
  }
  [[nodiscard]] double operator()(auto scheme, double rtol) const {
    Vec y = problem_.start;
    if (!run(y, scheme, tolerance{.rtol = rtol, .max_steps = 200000}, [](double, const Vec&) {})) return 1e300;
    return of(y) / rtol;
  }
  [[nodiscard]] double by_automatic(double rtol) const {
    Vec y = problem_.start;
    auto edits = at_times(problem_.times, [this](double t, Vec& now) { problem_.edit(t, now); });
    if (!integrate(y, problem_.rate, {0, problem_.end}, tolerance{.rtol = rtol}, edits)) return 1e300;
    return of(y) / rtol;
  }

 private:
  [[nodiscard]] bool run(Vec& y, auto scheme, const tolerance& wanted, auto&& look) const {
    const auto go = [&](auto&& stepper) {
      auto edits = at_times(problem_.times, [this](double t, Vec& now) { problem_.edit(t, now); });
      return static_cast<bool>(integrate(stepper, y, {0, problem_.end}, wanted, edits, look));
    };
    if (problem_.mass.size() > 0) return go(PhiStepper{y, problem_.rate, scheme, capacity(problem_.mass)});
    return go(PhiStepper{y, problem_.rate, scheme});
  }
  [[nodiscard]] double of(const Vec& y) const { return ((y - exact_).array() / size_.array()).abs().maxCoeff(); }

  Problem problem_;
  Vec exact_, size_;
};

void check_damped(const Errors& judge) {
  for (const double rtol : {1e-2, 1e-4, 1e-6, 1e-8}) {
    CAPTURE(rtol);
    CHECK(judge(rodas4, rtol) < 100);
    CHECK(judge(rodas4p2, rtol) < 100);
    CHECK(judge(rodas5p, rtol) < 100);
    CHECK(judge(radau, rtol) < 100);
    if (rtol > 1e-5) CHECK(judge(tr_bdf2, rtol) < 100);
  }
}
void check_explicit(const Errors& judge) {
  for (const double rtol : {1e-2, 1e-4, 1e-6, 1e-8}) {
    CAPTURE(rtol);
    CHECK(judge(tsit5, rtol) < 100);
    CHECK(judge(dop853, rtol) < 100);
    CHECK(judge.by_automatic(rtol) < 100);
  }
}

}  // namespace

TEST_CASE("births: a sink that saturates holds no y⁺ that has blown up") {
  for (const double k : {10.0, 1e3})
    for (const double K : {1.0, 1e-3}) {
      const auto rate = [k, K](const Vec& y, double) {
        return Vec{{-y[0], y[0] - k * y[1] / (1 + std::max(0.0, y[1]) / K)}};
      };
      const Errors judge{{rate, Vec{{1, 0}}, 2}};
      check_explicit(judge);
      check_damped(judge);
    }
}

TEST_CASE("births under a singular M: a radical, and what an algebraic equation makes of it") {
  const auto idle = [](const Vec& y, double) { return Vec{{-y[0], y[0] - 2e3 * y[1] * y[1], 2 - y[2]}}; };
  check_damped(Errors{{idle, Vec{{1, 0, 2}}, 1, Vec{{1, 1, 0}}}});
  // A → B, 2 B → C → D, and C → D by z = k B C/(1 + k + z)
  for (const double k : {1e2, 1e5}) {
    const auto rate = [k](const Vec& y, double) {
      const double a = y[0], b = 1e3 * y[1] * y[1], d = k * y[4];
      return Vec{{-a, a - 2 * b, b - y[2] - d, y[2] + d, k * y[1] * y[2] - y[4] * (1 + k + y[4])}};
    };
    check_damped(Errors{{rate, Vec::Unit(5, 0), 0.7, Vec{{1, 1, 1, 1, 0}}}});
  }
}

TEST_CASE("births after an edit: a reversible chain set back to its start") {
  const auto rate = [](const Vec& y, double) {
    const double v = 500.392 * y[0] - 0.339527 * y[1];
    const double w = 0.400284 * y[1] - 370.98 * y[2] + 500.392 * y[1] * y[1];
    return Vec{{-v, v - w, w}};
  };
  const auto reset = [](double, Vec& y) { y = Vec::Unit(3, 0); };
  const Errors judge{{rate, Vec::Unit(3, 0), 24.4, {}, {9.8575, 19.715}, reset}};
  check_damped(judge);
  check_explicit(judge);
}

TEST_CASE("births after an edit: doses, and the integral of a product") {
  const auto rate = [](const Vec& y, double) {
    return Vec{{-6626 * y[0], 6626 * y[0] - 12.6 * y[1], 12.6 * y[1] - 0.21 * y[2], y[1] * y[2]}};
  };
  const auto dose = [](double, Vec& y) { y[0] += 0.2; };
  check_damped(Errors{{rate, Vec::Unit(4, 0) * 0.2, 7.0, {}, {3.18, 6.36}, dose}});
}

TEST_CASE("births faster than any power: exp(−1/t), and what follows it") {
  const auto rate = [](const Vec& y, double t) {
    return Vec{{t > 0 ? std::exp(-1 / t) / (t * t) : 0, 1e3 * (y[0] - y[1]), y[1] * y[0]}};
  };
  check_damped(Errors{{rate, Vec::Zero(3), 0.12}});
}

// An iteration's or a difference's errors aren't rounding, however small rtol is.
TEST_CASE("births: a rectifier from rest, to many digits") {
  const auto rate = [](const Vec& y, double t) {
    const double x = (y[0] - y[1]) / 0.0259, i = 1e-12 * (x < 80 ? std::expm1(x) : std::exp(80.0) * (x - 79) - 1);
    return Vec{{((5 * std::sin(314.159 * t) - y[0]) / 1e3 - i) / 1e-7, (i - y[1] / 1e4) / 1e-6}};
  };
  const Errors judge{{rate, Vec::Zero(2), 0.03}};
  for (const double rtol : {1e-6, 1e-8, 1e-9}) {
    CHECK(judge(rodas4, rtol) < 1000);
    CHECK(judge(rodas4p2, rtol) < 1000);
    CHECK(judge(rodas5p, rtol) < 1000);
    CHECK(judge(radau, rtol) < 1000);
  }
}
