// The contract of a stepper, for every scheme and several kinds of state.
#include <phistep/phistep.hpp>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "contract/states.hpp"
#include "contract/stepper_battery.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

namespace {

template <class Case>
void check_explicit_and_implicit() {
  check_contract<Case>(forward_euler, 1);
  check_contract<Case>(trapezoidal, 2);
}

}  // namespace

TEST_CASE("every scheme on a dynamic motion") {
  for_each_motion_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    check_contract<SecondOrder<Dynamic>>(scheme, scheme.order());
  });
}
TEST_CASE("every first-order scheme on a fixed vector") {
  for_each_first_order_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    check_contract<FirstOrder<Fixed>>(scheme, scheme.order());
  });
}
TEST_CASE("Verlet on every kind of motion") {
  check_contract<SecondOrder<Fixed>>(velocity_verlet, 2);
  check_contract<SecondOrder<Columns>>(velocity_verlet, 2);
  check_contract<SecondOrder<Strided>>(velocity_verlet, 2);
  check_contract<SecondOrder<Structs>>(velocity_verlet, 2);
}
TEST_CASE("Rannacher's start, and TR-BDF2 on other states") {
  check_contract<SecondOrder<Dynamic>>(rannacher, 2);
  check_contract<FirstOrder<Fixed>>(rannacher(2), 2);
  check_contract<SecondOrder<Strided>>(tr_bdf2, 2);
  check_contract<FirstOrder<RowMajor>>(tr_bdf2, 2);
}
TEST_CASE("a split scene: trouble in the kicks, trouble in the rest") {
  const auto plain = [](auto stepper) { return stepper; };
  const auto kicks = [](Moody moody) { return term(Pull{}) + at(forward_euler, moody); };
  const auto rest = [](Moody moody) { return at(forward_euler, Pull{}) + term(moody); };
  check_contract<SecondOrder<Dynamic>>(trapezoidal, 2, kicks, plain);
  check_contract<SecondOrder<Dynamic>>(trapezoidal, 2, rest, plain);
  check_contract<SecondOrder<Strided>>(tr_bdf2, 2, kicks, plain);
  check_contract<SecondOrder<Columns>>(velocity_verlet, 2, kicks, plain);
  check_contract<FirstOrder<Fixed>>(midpoint, 2, kicks, plain);
  check_contract<FirstOrder<Dynamic>>(backward_euler, 1, kicks, plain);
}
TEST_CASE("halving keeps the contract of what it halves") {
  const auto plain = [](Moody force) { return force; };
  const auto halve = [](auto stepper) { return Halving{std::move(stepper), 3}; };
  check_contract<SecondOrder<Dynamic>>(trapezoidal, 2, plain, halve);
  check_contract<SecondOrder<Fixed>>(velocity_verlet, 2, plain, halve);
  check_contract<FirstOrder<Strided>>(tr_bdf2, 2, plain, halve);
  check_contract<FirstOrder<Dynamic>>(rannacher, 2, plain, halve);
}
TEST_CASE("a matrix, a strided view, a reference") {
  check_explicit_and_implicit<FirstOrder<RowMajor>>();
  check_explicit_and_implicit<FirstOrder<Strided>>();
  check_contract<FirstOrder<Reference>>(phi(0.7), 1);
}

TEST_CASE("dt < 0 undoes a step with the adjoint scheme") {
  // endpoint φ(h), then endpoint 1−φ(−h)
  SecondOrder<Dynamic> c;
  const Eigen::VectorXd before = numbers(c.state);
  PhiStepper forth{c.state, DampedPull{}, phi(0.3)};
  PhiStepper back{c.state, DampedPull{}, phi(0.7)};
  REQUIRE(forth.step(c.state, 0, 0.1));
  CHECK(distance(numbers(c.state), before) > 0.01);
  REQUIRE(back.step(c.state, 0.1, -0.1));
  CHECK(distance(numbers(c.state), before) <= 1e-14);

  PhiStepper verlet{c.state, Pull{}, velocity_verlet};
  REQUIRE(verlet.step(c.state, 0, 0.1));
  REQUIRE(verlet.step(c.state, 0.1, -0.1));
  CHECK(distance(numbers(c.state), before) <= 1e-14);
}

TEST_CASE("forward and backward Euler undo each other, and so do the two symplectic ones") {
  SecondOrder<Dynamic> c;
  const Eigen::VectorXd before = numbers(c.state);
  const auto there_and_back = [&](auto one, auto other) {
    PhiStepper forth{c.state, Pull{}, one};
    PhiStepper back{c.state, Pull{}, other};
    REQUIRE(forth.step(c.state, 0, 0.1));
    REQUIRE(back.step(c.state, 0.1, -0.1));
    CHECK(distance(numbers(c.state), before) <= 1e-14);
  };
  there_and_back(forward_euler, backward_euler);
  there_and_back(symplectic_euler, symplectic_euler_adjoint);
}

TEST_CASE("named schemes are their formulas") {
  // m v' = −k r, one step from (r, v), φ by φ, against the source's two lines solved by hand.
  const double k = 3, m = 2, h = 0.3, r = 0.7, v = -0.4, w = k / m;
  const auto one_step = [&](auto scheme) {
    using V = Eigen::Matrix<double, 1, 1>;
    Motion<V> y{V(r), V(v)};
    PhiStepper stepper{y, [k](const V& x) -> V { return -k * x; }, scheme, mass(m)};
    REQUIRE(stepper.step(y, 0, h));
    return Eigen::Vector2d(y.r[0], y.v[0]);
  };
  const auto formula = [&](double pf, double pd) {
    // v⁺ = v − h w (pf r⁺ + (1−pf) r),  r⁺ = r + h (pd v⁺ + (1−pd) v)
    const double v1 = (v - h * w * (r + pf * h * (1 - pd) * v)) / (1 + h * h * w * pf * pd);
    return Eigen::Vector2d(r + h * (pd * v1 + (1 - pd) * v), v1);
  };
  const auto check = [&](auto scheme, const Eigen::Vector2d& expected) {
    CHECK((one_step(scheme) - expected).norm() <= 1e-15);
  };
  check(forward_euler, formula(0, 0));
  check(trapezoidal, formula(0.5, 0.5));
  check(backward_euler, formula(1, 1));
  check(midpoint, formula(0.5, 0.5));
  check(symplectic_euler, formula(0, 1));
  check(symplectic_euler_adjoint, formula(1, 0));
  check(phi(0.7), formula(0.7, 0.7));
  check(phi(0.2, 0.9), formula(0.2, 0.9));
  check(phi_stage(0.3), formula(0.3, 0.3));
  // (I − aA)(r⁺, v⁺) = b with A(r, v) = (v, −w r)
  const auto resolved = [&](double a, const Eigen::Vector2d& b) {
    const double v1 = (b[1] - a * w * b[0]) / (1 + a * a * w);
    return Eigen::Vector2d(b[0] + a * v1, v1);
  };
  const auto advanced = [&](double a, const Eigen::Vector2d& y) {
    return Eigen::Vector2d(y[0] + a * y[1], y[1] - a * w * y[0]);
  };
  const Eigen::Vector2d y{r, v};
  const double g = 2 - std::sqrt(2.0);
  const Eigen::Vector2d Y = resolved(g / 2 * h, advanced(g / 2 * h, y));
  check(tr_bdf2, resolved((1 - g) / (2 - g) * h, Y / (g * (2 - g)) - y * (1 - g) * (1 - g) / (g * (2 - g))));
  check(rannacher, resolved(h / 2, resolved(h / 2, y)));
  check(rannacher(0), resolved(h / 2, advanced(h / 2, y)));
  const double half = v - h / 2 * w * r, r1 = r + h * half;
  check(velocity_verlet, Eigen::Vector2d(r1, half - h / 2 * w * r1));
}

TEST_CASE("forces are asked at the times of the formulas") {
  std::vector<double> times;
  const auto force = [&times](const Dynamic& r, const Dynamic& v, double t) -> Dynamic {
    if (times.empty() || times.back() != t) times.push_back(t);
    return -r - v;
  };
  const auto asked = [&](auto scheme) {
    SecondOrder<Dynamic> c;
    PhiStepper stepper{c.state, force, scheme};
    times.clear();
    REQUIRE(stepper.step(c.state, 1.0, 0.5));
    return times;
  };
  using Times = std::vector<double>;
  CHECK(asked(forward_euler) == Times{1.0});
  CHECK(asked(symplectic_euler) == Times{1.0});
  CHECK(asked(symplectic_euler_adjoint) == Times{1.5});
  CHECK(asked(trapezoidal) == Times{1.0, 1.5});
  CHECK(asked(backward_euler) == Times{1.5});
  CHECK(asked(midpoint) == Times{1.25});
  CHECK(asked(phi_stage(0.7)) == Times{1.0 + 0.7 * 0.5});
  CHECK(asked(velocity_verlet) == Times{1.0, 1.5});
  CHECK(asked(tr_bdf2) == Times{1.0, 1.0 + (2 - std::sqrt(2.0)) * 0.5, 1.5});
  CHECK(asked(rannacher) == Times{1.25, 1.5});
  CHECK(asked(rannacher(0)) == Times{1.0, 1.5});
}

// Steps that are watched.
namespace {

template <class S>
struct Watched {
  Trace<PlainState<S>> trace;
  explicit Watched(const S& state) {
    PlainState<S> y;
    copy_blocks<S>(y, state);
    trace.resize(y);
  }
  StepReport attempt(auto& stepper, S& state, double t, double dt, bool accept) {
    const StepReport done =
        stepper.attempt(state, t, dt, Origin::unknown, trace, [accept](const auto&...) { return accept; });
    if (done) trace.advance();
    return done;
  }
};

template <class Case>
void check_watched(auto scheme, const auto& force) {
  using S = typename Case::State;
  Case c, d;
  PhiStepper watched{c.state, force, scheme}, plain{d.state, force, scheme};
  if constexpr (decltype(watched)::traces) {
    Watched<S> watch{c.state};
    // By rounding alone: r and v are of order one, and slopes by (y⁺ − b)/φΔt are off by 1e-16/0.01, times Δt.
    const auto agree = [&] { return distance(numbers(c.state), numbers(d.state)) <= 1e-13; };
    double t = 0;
    const auto both = [&](double dt) {
      const Eigen::VectorXd before = numbers(c.state);
      const Statistics counted = watched.statistics();
      for (const double longer : {3 * dt, dt}) {
        CHECK(watch.attempt(watched, c.state, t, longer, false).outcome() == Outcome::error_too_large);
        CHECK(same_bits(numbers(c.state), before));
      }
      CHECK(watched.statistics().rejections == counted.rejections + 2);
      CHECK(watched.statistics().steps == counted.steps);
      CHECK(watched.statistics().failed_steps == counted.failed_steps);
      REQUIRE(watch.attempt(watched, c.state, t, dt, true));
      REQUIRE(plain.step(d.state, t, dt));
      CHECK(agree());
      t += dt;
    };
    for (const double dt : {0.01, 0.02, 0.015, -0.01, 0.03}) both(dt);

    // An edit, told to the trace.
    for (auto* state : {&c.state, &d.state})
      for_each_block([](auto, auto& block) { block = block * -1.5; }, Blocks<S>::all(*state));
    watch.trace.forget();
    for (const double dt : {0.02, 0.01}) both(dt);

    // Plain steps in between: the trace is to forget, the stepper notices by itself.
    REQUIRE(watched.step(c.state, t, 0.01));
    REQUIRE(plain.step(d.state, t, 0.01));
    CHECK(agree());
    t += 0.01;
    watch.trace.forget();
    for (const double dt : {0.01, 0.02}) both(dt);

    // What can't be stepped is refused as by step().
    const Eigen::VectorXd before = numbers(c.state);
    CHECK(watch.attempt(watched, c.state, t, 0, true).outcome() == Outcome::invalid_step);
    CHECK(watch.attempt(watched, c.state, 1.0, 1e-17, true).outcome() == Outcome::step_too_small);
    CHECK(same_bits(numbers(c.state), before));
  }
}

/// Trouble at every single force call of a watched step: nothing moves, and the next step is as if nothing had been.
template <class Case>
void check_watched_trouble(auto scheme) {
  using S = typename Case::State;
  Case c, d;
  int calls = 0, fatal = 0;
  Trouble mood = Trouble::none;
  const auto force = [&](const auto& y) {
    auto f = Pull{}(y);
    if (++calls == fatal && mood == Trouble::exception) throw std::runtime_error("moody");
    if (calls == fatal) component(f, 2) = std::nan("");
    return f;
  };
  const auto wrapped = [&force](const Dynamic& y) -> Dynamic { return force(y); };
  PhiStepper watched{c.state, wrapped, scheme};
  PhiStepper good{d.state, Pull{}, scheme};
  if constexpr (decltype(watched)::traces) {
    Watched<S> watch{c.state}, other{d.state};
    for (int n = 0; n < 2; ++n) {
      REQUIRE(watch.attempt(watched, c.state, 0.05 * n, 0.05, true));
      REQUIRE(other.attempt(good, d.state, 0.05 * n, 0.05, true));
    }
    double t = 0.1;
    for (const Trouble trouble : {Trouble::nan, Trouble::exception})
      for (int k = 1; k <= 8; ++k) {
        CAPTURE(k);
        const Eigen::VectorXd before = numbers(c.state);
        mood = trouble, calls = 0, fatal = k;
        bool done = false;
        try {
          done = static_cast<bool>(watch.attempt(watched, c.state, t, 0.05, false));
        } catch (const std::runtime_error&) {
        }
        CHECK_FALSE(done);
        CHECK(same_bits(numbers(c.state), before));
        fatal = 0;
        REQUIRE(watch.attempt(watched, c.state, t, 0.05, true));
        REQUIRE(other.attempt(good, d.state, t, 0.05, true));
        CHECK(distance(numbers(c.state), numbers(d.state)) <= 1e-13);
        t += 0.05;
      }
  }
}

}  // namespace

TEST_CASE("a watched step is the step, a rejected one is none: every scheme on motions") {
  for_each_motion_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    check_watched<SecondOrder<Dynamic>>(scheme, Pull{});
    check_watched<SecondOrder<Dynamic>>(scheme, DampedPull{});
    check_watched_trouble<SecondOrder<Dynamic>>(scheme);
  });
  check_watched<Coupled>(trapezoidal, WarmPull{});
  check_watched<Coupled>(tr_bdf2, WarmPull{});
  check_watched<Coupled>(velocity_verlet, WarmPull{});
}
TEST_CASE("a watched step is the step, a rejected one is none: every scheme on first-order states") {
  for_each_first_order_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    check_watched<FirstOrder<Fixed>>(scheme, DrivenPull{});
    check_watched<FirstOrder<Strided>>(scheme, Pull{});
    check_watched_trouble<FirstOrder<Dynamic>>(scheme);
  });
  check_watched<FirstOrder<RowMajor>>(tr_bdf2, Pull{});
  check_watched<FirstOrder<Columns>>(phi(0.7), Pull{});
  check_watched<SecondOrder<Structs>>(velocity_verlet, Pull{});
  check_watched<SecondOrder<Fixed>>(velocity_verlet, DampedPull{});
}
