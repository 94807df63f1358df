// Bodies at rest, and bodies that come to rest: what a run costs there with rtol alone.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cstdint>
#include <string>

#include "support/battery.hpp"
#include "support/catch.hpp"

namespace {

using Vec = Eigen::VectorXd;

/// M r'' = K r − c r' + F: a chain of n equal springs, fixed at one end.
struct Chain {
  Eigen::MatrixXd stiffness;
  Vec load;
  double drag;
  Vec operator()(const Vec& r, const Vec& v) const { return stiffness * r - drag * v + load; }
};
Chain chain(int n, double k, double load, double drag) {
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(n, n);
  for (int i = 0; i < n; ++i) {
    stiffness(i, i) -= i + 1 < n ? 2 * k : k;
    if (i > 0) stiffness(i, i - 1) = stiffness(i - 1, i) = k;
  }
  return {stiffness, Vec::Constant(n, load), drag};
}
void for_each_scheme(auto&& f) {
  f("radau", phistep::radau);
  f("rodas5p", phistep::rodas5p);
  f("tr_bdf2", phistep::tr_bdf2);
  f("dop853", phistep::dop853);
}
constexpr std::int64_t limit = 10'000;
/// Rtol alone may cost this many tries where those with an atol of 1e-9 are `with_atol`.
std::int64_t allowed(std::int64_t with_atol) { return 300 + 6 * with_atol; }
std::int64_t tries(const phistep::RunReport& report) { return report.statistics.steps + report.statistics.rejections; }

/// A bar of 1, 5 or 20 elements hangs at rest under its weight, for five periods.
battery::Tally resting() {
  battery::Tally all;
  all.name = "a bar at rest, rtol alone: more tries than due";
  for (const int n : {1, 5, 20}) {
    const double area = 0.01, length = 10.0 / n, weight = 1000 * area * length;
    const Chain force = chain(n, 1e9 * area / length, 9.81 * weight, 0);
    const Vec rest = (-force.stiffness).llt().solve(force.load);
    for_each_scheme([&](const char* name, auto scheme) {
      const auto cost = [&](const phistep::AbsoluteTolerance& atol) {
        phistep::Motion body{rest, Vec(Vec::Zero(n))};
        phistep::PhiStepper stepper{body, force, scheme, phistep::mass(Vec(Vec::Constant(n, weight)))};
        return tries(phistep::integrate(stepper, body, {0, 0.2},
                                        phistep::tolerance{.rtol = 1e-6, .atol = atol, .max_steps = limit}));
      };
      const std::int64_t with_atol = cost(1e-9), alone = cost({});
      all.count(alone <= allowed(with_atol),
                std::string(name) + ", " + std::to_string(n) + " unknowns: " + std::to_string(alone) +
                    (alone < limit ? "" : " or more") + ", with an atol " + std::to_string(with_atol));
    });
  }
  return all;
}

/// One or ten masses settle under their weight; from t = 40 they rest. Runs to 5, 20, 40, 60, 100, 200.
battery::Tally settling() {
  battery::Tally all;
  all.name = "settled masses, run in pieces, rtol alone: more tries than due";
  for (const int n : {1, 10}) {
    const Chain force = chain(n, 400, 9.81, 4);
    for_each_scheme([&](const char* name, auto scheme) {
      const auto cost = [&](const phistep::AbsoluteTolerance& atol) {
        phistep::Motion body{Vec(Vec::Zero(n)), Vec(Vec::Zero(n))};
        phistep::PhiStepper stepper{body, force, scheme, phistep::mass(Vec(Vec::Ones(n)))};
        double t = 0;
        std::int64_t late = 0;
        for (const double end : {5.0, 20.0, 40.0, 60.0, 100.0, 200.0}) {
          const bool rests = t >= 40;
          const phistep::RunReport report =
              phistep::integrate(stepper, body, {t, end},
                                 phistep::tolerance{.rtol = 1e-6, .atol = atol, .max_steps = rests ? limit : 100'000});
          if (rests) late += tries(report);
          if (!report) return rests ? std::max(late, limit) : std::int64_t{1'000'000};
          t = end;
        }
        return late;
      };
      const std::int64_t with_atol = cost(1e-9), alone = cost({});
      all.count(alone <= allowed(with_atol), std::string(name) + ", masses " + std::to_string(n) + ": " +
                                                 std::to_string(alone) + (alone < limit ? "" : " or more") +
                                                 ", with an atol " + std::to_string(with_atol));
    });
  }
  return all;
}

const battery::Tally& rest() {
  static const battery::Tally all = resting();
  return all;
}
const battery::Tally& settled() {
  static const battery::Tally all = settling();
  return all;
}

}  // namespace

TEST_CASE("a bar at rest: none costs too much") { battery::at_most(0, rest()); }

TEST_CASE("settled masses: none costs too much") { battery::at_most(0, settled()); }
