// run: views, observers, states that grow. In short: run.test.cpp.
#include "run/run_cases.hpp"

using namespace run_cases;

TEST_CASE("a state that grows while the run goes on") {
  const auto fall = [](const Eigen::VectorXd& r) -> Eigen::VectorXd { return -r; };
  check_growing(trapezoidal, fall), check_growing(tr_bdf2, fall);
  check_growing(velocity_verlet, fall), check_growing(midpoint, fall);
}

TEST_CASE("observers that stop a controlled run, of both kinds, in order") {
  Vec y = decayed(0);
  PhiStepper stepper{y, decay, trapezoidal};
  check_observers_that_stop(stepper, y);
}

TEST_CASE("dense output through a controlled run: order 4 for y, 6 for the positions of a motion") {
  // Steps of about one length (max_step rules), of a scheme so accurate that interpolation errors alone would show: the
  // interpolant's own ends are compared with it.
  const auto worst = [](double dt) {
    // What lies between the ends, against a run with 8 times as many steps, which has the same error at the ends up to
    // a factor that doesn't matter: both errors are O(Δt²) of a smooth function, its interpolation error is what kinks.
    Vec y = Flow::exact(0);
    PhiStepper stepper{y, Flow{}, tr_bdf2, capacity(Flow::capacity)};
    double off = 0;
    REQUIRE(integrate(stepper, y, {0, 2}, tolerance{.rtol = 0.5, .atol = 1e3, .first_step = dt, .max_step = dt},
                      [&](const auto& step) {
                        for (const double x : {0.25, 0.5, 0.75}) {
                          const double t = step.t0() + x * step.dt();
                          // errors at both ends, carried over linearly
                          const Vec e0 = step.start() - Flow::exact(step.t0()),
                                    e1 = step.end() - Flow::exact(step.t1());
                          off = std::max(off, (step.at(t) - Flow::exact(t) - (1 - x) * e0 - x * e1).norm());
                        }
                      }));
    return off;
  };
  const double a = worst(0.1), b = worst(0.05);
  CAPTURE(a, b);
  CHECK(std::log2(a / b) > 2.7);  // slopes of a solution of order 2, off by O(Δt²), times Δt: order 3 at least
}

TEST_CASE("views of the user's own memory, controlled") {
  double memory[4] = {1, 2, 0, 1}, r2[2] = {1, 2}, v2[2] = {0, 1};
  Motion<Eigen::Map<Vec>> mapped{Eigen::Map<Vec>(memory), Eigen::Map<Vec>(memory + 2)};
  Moving owned{Vec(r2[0], r2[1]), Vec(v2[0], v2[1])};
  const auto spring = [](const Vec& r) -> Vec { return -9 * r - r.squaredNorm() * r; };
  const auto both = [&](auto scheme) {
    PhiStepper a{mapped, spring, scheme};
    PhiStepper b{owned, spring, scheme};
    const RunReport one = integrate(a, mapped, {0, 1}, tolerance{.rtol = 1e-4});
    const RunReport two = integrate(b, owned, {0, 1}, tolerance{.rtol = 1e-4});
    REQUIRE(one);
    CHECK(one.statistics == two.statistics);
    CHECK((mapped.r == owned.r && mapped.v == owned.v));
  };
  both(trapezoidal), both(velocity_verlet), both(midpoint), both(tr_bdf2);
  Eigen::VectorXd home = Eigen::VectorXd::Ones(3);
  Eigen::Ref<Eigen::VectorXd> ref(home);
  PhiStepper stepper{ref, [](const Eigen::VectorXd& y) -> Eigen::VectorXd { return -y; }, tr_bdf2};
  CHECK(integrate(stepper, ref, {0, 1}, tolerance{.rtol = 1e-5}));
  CHECK(home[2] == Approx(std::exp(-1)).epsilon(1e-4));
}

TEST_CASE("one particle that needs short steps rules them in the particle norm") {
  using Columns = Eigen::Matrix3Xd;
  const Index n = 2000;
  const auto force = [](const Columns& r) -> Columns {
    Columns f = -r;
    f.col(1234) *= 400;  // ω = 20
    return f;
  };
  const auto run = [&](Norm norm) {
    Motion<Columns> y{Columns::Ones(3, n), Columns::Zero(3, n)};
    PhiStepper stepper{y, force, velocity_verlet};
    const RunReport report = integrate(stepper, y, {0, 1}, tolerance{.rtol = 1e-3, .norm = norm});
    REQUIRE(report);
    return std::pair{report, std::abs(y.r(1, 1234) - std::cos(20.0))};
  };
  const auto [mean, poor] = run(Norm::rms);
  const auto [each, good] = run(Norm::particle);
  // rms dilutes it by √2000 = 45.
  CHECK(each.statistics.steps > 2 * mean.statistics.steps);
  CHECK(good <= 0.02);
  CHECK(each.limits.most().by == LimitedBy::error);
  CHECK(each.limits.most().where.index / 3 == 1234);
  std::ostringstream out;
  out << each;
  CHECK_THAT(out.str(), contains("dt limited by       the error, e.g. of component 37") && contains("of block") &&
                            contains("% of the steps"));
}

TEST_CASE("the particle norm rules the steps of every scheme") {
  using Columns = Eigen::Matrix2Xd;
  const auto force = [](const Columns& r) -> Columns {
    Columns f = -r;
    f.col(7) *= 400;  // ω = 20, and 24 others with ω = 1
    return f;
  };
  const auto check = [&](const char* name, auto scheme, double rtol) {
    const auto run = [&](Norm norm) {
      Motion<Columns> y{Columns::Ones(2, 25), Columns::Zero(2, 25)};
      PhiStepper stepper{y, force, scheme};
      const RunReport report = integrate(stepper, y, {0, 5}, tolerance{.rtol = rtol, .norm = norm});
      REQUIRE(report);
      return std::pair{static_cast<double>(report.statistics.force_calls), std::abs(y.r(1, 7) - std::cos(100.0))};
    };
    const auto [few, poor] = run(Norm::rms);
    const auto [many, good] = run(Norm::particle);
    CAPTURE(name, few, many, poor, good);
    CHECK(many > 1.05 * few);
    CHECK(good < poor);
  };
  check("velocity_verlet", velocity_verlet, 1e-3);
  check("trapezoidal", trapezoidal, 1e-3);
  check("rodas4", rodas4, 1e-4);
  check("radau", radau, 1e-5);
  check("rkn86", rkn86, 1e-5);
  check("tsit5", tsit5, 1e-5);
  check("dop853", dop853, 1e-5);
}
