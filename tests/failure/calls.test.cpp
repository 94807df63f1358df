// Failures around the schemes: of events, handlers and observers, of stages, of a solver's analysis, of half a rejected
// step. The long version of this is runs.test.cpp.
#include <phistep/phistep.hpp>

#include <vector>

#include "failure/faults.hpp"

using namespace faults;
using Vec = Eigen::VectorXd;

namespace calls_cases {

inline const auto motion = [] { return states::SecondOrder<Vec>{}.state; };
inline const auto flow = [] { return states::FirstOrder<Vec>{}.state; };
inline const std::vector<Kind> kinds{Kind::nan, Kind::exception};

struct Pull {
  Vec operator()(const Vec& r) const { return struck<Vec>(Site::force, states::Pull{}(r)); }
};
struct Driven {
  Vec operator()(const Vec& y, double t) const { return struck<Vec>(Site::force, states::DrivenPull{}(y, t)); }
};
inline auto with(auto f, auto... more) {
  return [=](auto& y) { return PhiStepper{y, f, more...}; };
}
inline void check(const Tally& tally) {
  INFO(tally.first);
  CHECK(tally.changed == 0);
  CHECK(tally.untold == 0);
  CHECK(tally.stuck == 0);
  CHECK(tally.otherwise == 0);
}

/// The state seen, and bounces where r_0 passes a wall.
struct Bounces {
  static auto make() {
    return std::tuple{event(
                          [](const auto& y) {
                            const double g = y.r[0] - 0.35;
                            return fault.strikes(Site::event) ? fault.bad() : g;
                          },
                          {},
                          [](double, auto& y) {
                            y.v[0] *= -0.9;
                            static_cast<void>(fault.strikes(Site::handler));
                          }),
                      [](double, const auto&) { static_cast<void>(fault.strikes(Site::observer)); }};
  }
};

}  // namespace calls_cases

#if PHISTEP_QUICK

using namespace calls_cases;

TEST_CASE("an event's g, its handler, an observer that fail at any call: a step stands or it doesn't") {
  const Make make = machine(motion, with(Pull{}, velocity_verlet), 0.5, fixed(0.1), &Bounces::make);
  // A new run from an event on has another grid of steps.
  const Promise behind{.same_end = 1e-13, .renewed = 1e-3, .moves_on = true};
  check(every_call("force", make, Site::force, kinds, behind));  // slopes for the interpolant
  check(every_call("event", make, Site::event, kinds, behind));
  check(every_call("handler", make, Site::handler, {Kind::exception}, behind));
  check(every_call("observer", make, Site::observer, {Kind::exception}, behind));
}

#elif PHISTEP_FULL

//
#include <phistep/sparse.hpp>

using namespace calls_cases;

TEST_CASE("a stage that is not finite is the force's fault, not the matrix's") {
  check(every_call("rodas4", machine(flow, with(Driven{}, rodas4), 0.3, fixed(0.1)), Site::force, kinds,
                   {.same_end = 1e-10}));
}

TEST_CASE("times that an exception kept from being shown are left out, not extrapolated") {
  Eigen::Matrix<double, 1, 1> y(1.0);
  PhiStepper stepper{y, [](const auto& x) -> Eigen::Matrix<double, 1, 1> { return -x; }, backward_euler};
  std::vector<double> seen;
  int calls = 0;
  Run run{stepper, y, {0.0, 3.0}, fixed(1.0), sampled({1.2, 1.5, 1.8, 2.5}, [&](double t, const auto& x) {
            if (++calls == 1) throw Struck();
            seen.push_back(t);
            CHECK(x[0] == Approx(1 / (4 * 1.5)));  // two steps of 1, then one of ½
          })};
  int thrown = 0;
  for (bool more = true; more;) {
    try {
      more = run.advance();
    } catch (const Struck&) {
      ++thrown;
    }
  }
  CHECK(thrown == 1);
  CHECK(seen == std::vector<double>{2.5});
}

namespace {

struct SparseDecay {
  Vec operator()(const Vec& y) const { return -y; }
  Eigen::SparseMatrix<double> jacobian(const Vec& y) const {
    Eigen::SparseMatrix<double> J(y.size(), y.size());
    J.setIdentity();
    return -J;
  }
};
/// LU whose analysis, factorization or solve fails when told so.
struct Fragile : Eigen::SparseLU<Eigen::SparseMatrix<double>> {
  using Base = Eigen::SparseLU<Eigen::SparseMatrix<double>>;
  bool refuses = false;
  void analyzePattern(const Eigen::SparseMatrix<double>& W) {
    static_cast<void>(fault.strikes(Site::solver));
    Base::analyzePattern(W);
  }
  void factorize(const Eigen::SparseMatrix<double>& W) {
    refuses = fault.strikes(Site::solver);
    Base::factorize(W);
  }
  [[nodiscard]] Eigen::ComputationInfo info() const { return refuses ? Eigen::NoConvergence : Base::info(); }
  [[nodiscard]] Vec solve(const auto& b) {
    refuses = refuses || fault.strikes(Site::solver);
    return Base::solve(b);
  }
};

}  // namespace

TEST_CASE("a linear solver that throws or refuses is made anew") {
  const Make make = machine(flow, with(SparseDecay{}, backward_euler, newton<Fragile>()), 0.3, fixed(0.1));
  check(every_call("solver", make, Site::solver, {Kind::refuses, Kind::exception},
                   {.same_end = 1e-14, .renewed = 1e-14}));
}

namespace {

/// A spring whose anchor follows: a history.
struct Slider : ForceTerm {
  static constexpr const char* name = "slider";
  struct Memory {
    Vec anchor;
    int commits = 0;
    void archive(auto& ar) { ar(anchor, commits); }
  };
  static constexpr bool uses_velocity = false, uses_time = false;
  static void begin(double, double, const auto& y, Memory& m) {
    if (m.anchor.size() == 0) m.anchor = y.r;
  }
  static void add(double, const auto& y, const Memory& m, auto& out) { out.force -= 30 * (y.r - m.anchor); }
  static void commit(double, const auto& y, Memory& m) {
    ++m.commits;
    for (Index i = 0; i < y.r.size(); ++i) m.anchor[i] = std::clamp(m.anchor[i], y.r[i] - 0.01, y.r[i] + 0.01);
  }
};

}  // namespace

TEST_CASE("who rejects a step of Halving takes back the force's history") {
  auto y = motion();
  Halving stepper{PhiStepper{y, Slider{}, velocity_verlet}, 2};
  Run run{stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-4, .first_step = 0.5}};
  REQUIRE(run.finish());
  const RunReport report = run.report();
  CHECK(report.statistics.rejections > 0);
  CHECK(stepper.stepper().memory().commits == report.statistics.steps + 1);  // the first by two halves
}

TEST_CASE("a run that fails before its first step says when") {
  auto y = flow();
  PhiStepper stepper{y, [](const Vec& x) -> Vec { return x * NAN; }, trapezoidal};
  CHECK_THAT(integrate(stepper, y, {2.5, 3.0}, tolerance{}).message(), contains("t = 2.5") && contains("Try: "));
}

TEST_CASE("a size that can't be is refused, and the old one goes on") {
  Vec y = Vec::Ones(3);
  PhiStepper stepper{y, [](const Vec& x) -> Vec { return -x.array().cube(); }, backward_euler};
  REQUIRE(stepper.step(y, 0, 0.1));
  Vec z = y;
  PhiStepper other{z, [](const Vec& x) -> Vec { return -x.array().cube(); }, backward_euler};
  y = Vec::Ones(2000);  // no dense differences of so many
  CHECK_THROWS_AS(stepper.step(y, 0.1, 0.1), std::invalid_argument);
  CHECK(y == Vec::Ones(2000));
  y = z;
  REQUIRE(stepper.step(y, 0.1, 0.1));
  REQUIRE(other.step(z, 0.1, 0.1));
  CHECK(y == z);
}

#endif
