// Generalized-α: order 2 in r, v and M⁻¹Ψ, the closed form of its modes, starts, steps that change.
#include <Eigen/Eigenvalues>
#include <phistep/phistep.hpp>

#include <cmath>
#include <complex>
#include <functional>
#include <stdexcept>
#include <vector>

#include "accuracy/observed_order.hpp"
#include "problems/forced.hpp"
#include "problems/march.hpp"
#include "problems/step_matrix.hpp"
#include "schemes/error_estimate_cases.hpp"
#include "support/catch.hpp"

namespace generalized_alpha_cases {

using convergence::check_order;
using convergence::errors;
using problems::march;
using problems::step_matrix;

/// r'' of the forced motion
inline Vec acceleration(double t) { return {-std::cos(t), -1.125 * std::sin(1.5 * t)}; }

/// Distances to the truth at t = 2 after n steps, the first `ratio` times as long as the second, and so on: of (r, v), of M⁻¹Ψ.
struct Errors {
  double state, slope;
};
inline Errors errors_of_motion(auto scheme, int n, double ratio = 1) {
  auto y = Swing::exact(0);
  PhiStepper stepper{y, Swing{}, scheme, mass(Swing::mass)};
  const double h = 4 / (n * (1 + ratio));
  double t = 0;
  for (int k = 0; k < n; ++k) {
    const double dt = k % 2 == 0 ? ratio * h : h;
    problems::step(stepper, y, t, dt);
    t += dt;
  }
  return {distance(y, Swing::exact(2)), (stepper.working().slope().force - acceleration(2)).norm()};
}
inline double error_of_flow(auto scheme, int n) {
  const auto y = Flow::exact(0);
  return distance(march(PhiStepper{y, Flow{}, scheme, capacity(Flow::capacity)}, y, 0.0, 2.0, n), Flow::exact(2));
}
inline void check_orders_of_motion(auto scheme, double order, double ratio = 1) {
  check_order(errors(80, [&](int n) { return errors_of_motion(scheme, n, ratio).state; }), order);
  check_order(errors(80, [&](int n) { return errors_of_motion(scheme, n, ratio).slope; }), order);
}

/// The largest root of (1+ρ)²(λ−1)²((2−ρ)λ+2ρ−1) + Ω²(λ+ρ)³, in long double.
inline long double closed_form(long double rho, long double omega) {
  const long double q = (1 + rho) * (1 + rho), a = 2 - rho, b = 2 * rho - 1, w = omega * omega;
  // (λ²−2λ+1)(aλ+b)
  const long double p3 = q * a + w, p2 = q * (b - 2 * a) + 3 * w * rho, p1 = q * (a - 2 * b) + 3 * w * rho * rho,
                    p0 = q * b + w * rho * rho * rho;
  Eigen::Matrix<long double, 3, 3> companion;
  companion << -p2 / p3, -p1 / p3, -p0 / p3, 1, 0, 0, 0, 1, 0;
  return companion.eigenvalues().cwiseAbs().maxCoeff();
}
template <class T>
double off_closed_form(double rho, double omega) {
  const auto radius = step_matrix<T>(generalized_alpha(rho), T(omega)).eigenvalues().cwiseAbs().maxCoeff();
  return static_cast<double>(std::abs(static_cast<long double>(radius) - closed_form(rho, omega)));
}
/// A spring, and a load that jumps at 1 and 2.
struct Pulled : ForceTerm {
  static constexpr bool uses_velocity = false;
  void add(double t, const auto& y, auto& out) const { out.force += Vec(t < 1 ? 1 : t < 2 ? -3 : 5, 0) - 4 * y.r; }
};
/// The same pull with a history, which nothing reads.
struct Remembering : ForceTerm {
  struct Memory {};
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(double, const auto& y, const Memory&, auto& out) const { out.force -= 4 * y.r; }
  void commit(double, const auto&, Memory&) const {}
};
/// |r| of a mode far above 1/Δt at most and at the end, from a start at rest, where Δt changes by `ratio` to and fro
inline std::pair<double, double> high_mode(double rho, double ratio, int n) {
  using V = Eigen::Matrix<double, 1, 1>;
  Motion<V> y{V(1), V(0)};
  PhiStepper stepper{y, [](const V& r) -> V { return -1e12 * r; }, generalized_alpha(rho)};
  double t = 0, most = 0;
  for (int k = 0; k < n; ++k) {
    const double dt = k % 2 == 0 ? 1 : ratio;
    problems::step(stepper, y, t, dt);
    t += dt;
    most = std::max(most, std::abs(y.r[0]));
  }
  return {most, std::abs(y.r[0])};
}

}  // namespace generalized_alpha_cases

using namespace error_estimate_cases;
using namespace generalized_alpha_cases;

#if PHISTEP_QUICK

TEST_CASE("order 2 in r, v and M⁻¹Ψ: a motion, nonlinear, damped, driven") {
  check_orders_of_motion(generalized_alpha(0.5), 2);
  check_order(errors(80, [](int n) { return error_of_flow(generalized_alpha(0.5), n); }), 2);
}

TEST_CASE("what makes no sense is refused") {
  for (const double rho : {-0.1, 1.1, std::nan("")}) CHECK_THROWS_WITH(generalized_alpha(rho), contains("[0, 1]"));
  for (const auto& [beta, gamma] :
       {std::pair{0.0, 0.5}, {-0.1, 0.5}, {0.25, 0.49}, {std::nan(""), 0.5}, {HUGE_VAL, 1.0}})
    CHECK_THROWS_WITH(newmark(beta, gamma), contains("velocity_verlet"));
  for (const double alpha : {0.1, -0.34, std::nan("")}) CHECK_THROWS_WITH(hht(alpha), contains("-1/3 <= alpha <= 0"));
  for (const double alpha : {0.1, -1.1, std::nan("")}) CHECK_THROWS_WITH(bossak(alpha), contains("-1 <= alpha <= 0"));
  CHECK(hht(-1.0 / 3).order() == 2);
  CHECK(newmark(0.3025, 0.6).order() == 1);
}

TEST_CASE("ρ∞ = 1, newmark(¼, ½), hht(0) and bossak(0) are the trapezoidal rule") {
  const auto end = [](auto scheme) {
    const auto y = Swing::exact(0);
    return march(PhiStepper{y, Swing{}, scheme, mass(Swing::mass)}, y, 0.0, 2.0, 40);
  };
  const auto rule = end(trapezoidal);
  // Both solve to rounding, 40 times.
  CHECK(distance(end(generalized_alpha(1)), rule) <= 1e-13);
  CHECK(distance(end(newmark(0.25, 0.5)), rule) <= 1e-13);
  CHECK(distance(end(hht(0)), rule) <= 1e-13);
  CHECK(distance(end(bossak(0)), rule) <= 1e-13);
}

TEST_CASE("the second step is (1) to (3) by hand, r'' = −k r") {
  const double k = 1.5, h = 0.3;
  const auto check = [=](auto scheme) {
    using One = Eigen::Matrix<double, 1, 1>;
    Motion<One> y{One(0.7), One(-0.4)};
    PhiStepper stepper{y, [=](const One& x) -> One { return -k * x; }, scheme};
    const double k0 = -k * y.r[0];
    problems::step(stepper, y, 0.0, h);
    const AlphaWeights w = scheme.weights(true);
    const double r = y.r[0], v = y.v[0], a = -k * r - w.lag() * (-k * r - k0), m = w.alpha_m, f = w.alpha_f;
    const double r_free = r + h * v + h * h * (0.5 - w.beta) * a;
    const double a2 = (-k * ((1 - f) * r_free + f * r) - m * a) / (1 - m + (1 - f) * k * h * h * w.beta);
    problems::step(stepper, y, h, h);
    CHECK(y.r[0] == Approx(r_free + h * h * w.beta * a2).epsilon(1e-14));
    CHECK(y.v[0] == Approx(v + h * ((1 - w.gamma) * a + w.gamma * a2)).epsilon(1e-14));
  };
  check(generalized_alpha(0)), check(generalized_alpha(0.5)), check(generalized_alpha(0.9));
  check(hht(-0.2)), check(bossak(-0.2)), check(newmark(0.3, 0.5));
}

TEST_CASE("the spectral radius is the closed form's") {
  // Three roots draw near to one as Ω^(−2/3): double leaves of them 1e-16·Ω^(4/3). (ρ∞ = 1 has no memory, see above.)
  for (const double rho : {0.0, 0.5, 0.8})
    for (const double omega : {0.1, 1.0, 3.0, 10.0, 100.0}) {
      CAPTURE(rho, omega);
      CHECK(off_closed_form<double>(rho, omega) <= 1e-12);
    }
  CHECK(static_cast<double>(closed_form(0.5L, 1)) == Approx(0.9893128).margin(1e-7));
}

TEST_CASE("exact counts: one call where a run starts, then residuals alone; one Jacobian, two factorizations") {
  const auto linear_pull = [](const Vec& r) -> Vec { return -4 * r; };
  Motion<Vec> y{Vec(1, 2), Vec(0, 1)};
  PhiStepper stepper{y, linear_pull, generalized_alpha(0.5)};
  for (int n = 0; n < 20; ++n) problems::step(stepper, y, 0.0, 0.01);
  const Statistics s = stepper.statistics();
  CHECK(s.steps == 20);
  CHECK(s.jacobians == 1);
  CHECK(s.factorizations == 2);                  // the first step is the trapezoidal rule's
  CHECK(s.force_calls == 1 + 2 + s.iterations);  // two for the Jacobian

  // A force with a history may be another one by the next step: it is asked again, and a goes on.
  Motion<Vec> z{Vec(1, 2), Vec(0, 1)};
  PhiStepper other{z, Remembering{}, generalized_alpha(0.5)};
  for (int n = 0; n < 20; ++n) problems::step(other, z, 0.0, 0.01);
  CHECK(other.statistics().force_calls >= 20 + other.statistics().iterations);
  CHECK(distance(y, z) <= 1e-14);
}

TEST_CASE(
    "after an edit, a reset, at another time: as a new stepper, to the bit; else by what the last step has left") {
  const auto next = [](const std::function<void(Swing::State&, double&, std::function<void()>)>& meddle) {
    auto y = Swing::exact(0);
    PhiStepper stepper{y, Swing{}, generalized_alpha(0.2), mass(Swing::mass)};
    for (int n = 0; n < 3; ++n) problems::step(stepper, y, 0.1 * n, 0.1);
    double t = 0.30000000000000004;
    meddle(y, t, [&] { stepper.reset(); });
    auto z = y;
    PhiStepper fresh{z, Swing{}, generalized_alpha(0.2), mass(Swing::mass)};
    problems::step(stepper, y, t, 0.1);
    problems::step(fresh, z, t, 0.1);
    return distance(y, z);
  };
  // Newton's old Jacobian ends elsewhere within rounding; a = k instead of a differs by 0.1³.
  CHECK(next([](auto& y, double&, auto) { y.v[1] += 1e-9; }) <= 1e-14);
  CHECK(next([](auto& y, double&, auto) { y.r[0] = -y.r[0]; }) <= 1e-14);
  CHECK(next([](auto&, double& t, auto) { t += 0.01; }) <= 1e-14);
  CHECK(next([](auto&, double&, auto reset) { reset(); }) <= 1e-14);
  CHECK(next([](auto&, double&, auto) {}) >= 1e-4);
}

#elif PHISTEP_FULL

TEST_CASE("order 2 in r, v and M⁻¹Ψ: a motion, nonlinear, damped, driven; and of first order") {
  for (const double rho : {0.0, 0.5, 0.8, 1.0}) {
    CAPTURE(rho);
    check_orders_of_motion(generalized_alpha(rho), 2);
    check_order(errors(80, [&](int n) { return error_of_flow(generalized_alpha(rho), n); }), 2);
  }
  check_orders_of_motion(hht(-0.3), 2), check_orders_of_motion(bossak(-0.3), 2);
  check_orders_of_motion(newmark(0.3, 0.5), 2), check_orders_of_motion(newmark(0.3025, 0.6), 1);
}

TEST_CASE("order 2 where the step changes to and fro: a moves with it") {
  for (const double rho : {0.0, 0.5, 0.8}) {
    CAPTURE(rho);
    check_orders_of_motion(generalized_alpha(rho), 2, 2);
    check_order(errors(80,
                       [&](int n) {
                         Vec y = Flow::exact(0);
                         PhiStepper stepper{y, Flow{}, generalized_alpha(rho), capacity(Flow::capacity)};
                         for (int k = 0; k < n; ++k)
                           problems::step(stepper, y, k / 2 * 4.0 / n + (k % 2) * 8.0 / 3 / n,
                                          (k % 2 ? 4 : 8) / 3.0 / n);
                         return distance(y, Flow::exact(2));
                       }),
                2);
  }
}

TEST_CASE("order 2: a mass matrix, a nonlinear spring and a dashpot, against a run of 40 times the steps") {
  const Eigen::MatrixXd M = Eigen::Matrix2d{{2, 0.5}, {0.5, 1}};
  const auto force = [](const Vec& r, const Vec& v, double t) -> Vec {
    return -(4 + r.squaredNorm()) * r - 0.3 * v + Vec(std::cos(3 * t), 0);
  };
  for (const double rho : {0.0, 0.8}) {
    const auto run = [&](int n) {
      const Motion<Vec> y{Vec(1, 0.2), Vec(0, 0.8)};
      return march(PhiStepper{y, force, generalized_alpha(rho), mass(M)}, y, 0.0, 2.0, n);
    };
    const auto reference = run(40 * 1600);
    check_order(errors(200, [&](int n) { return distance(run(n), reference); }), 2);
  }
}

TEST_CASE("order 2 where a run stops at every third step: each start is a step of order 2") {
  const auto error = [](auto scheme, int n) {
    const double h = 2.0 / n;
    std::vector<double> stops;
    for (int k = 3; k < n; k += 3) stops.push_back(k * h);
    auto y = Swing::exact(0);
    PhiStepper stepper{y, Swing{}, scheme, mass(Swing::mass)};
    REQUIRE(integrate(stepper, y, {0.0, 2.0}, fixed(h), at_times(stops, [](double, const auto&) {})));
    return distance(y, Swing::exact(2));
  };
  const auto check = [&](auto scheme) { check_order(errors(80, [&](int n) { return error(scheme, n); }), 2); };
  check(generalized_alpha(0)), check(generalized_alpha(0.5)), check(hht(-0.3)), check(bossak(-0.3));
}

TEST_CASE("high modes do not grow where the last step before each restart is short") {
  for (const double rho : {0.2, 0.5, 0.8})
    for (const int steps : {2, 4, 10}) {
      Motion<Eigen::Matrix<double, 1, 1>> y{Eigen::Matrix<double, 1, 1>(1), Eigen::Matrix<double, 1, 1>(0)};
      PhiStepper stepper{y, [](const auto& r) -> Eigen::Matrix<double, 1, 1> { return -1e6 * r; },
                         generalized_alpha(rho)};
      double t = 0, most = 0;
      for (int k = 0; k < 200; ++k) {
        const double dt = k % steps == steps - 1 ? 0.1 : 1;
        if (k % steps == 0) stepper.reset();
        problems::step(stepper, y, t, dt);
        t += dt, most = std::max(most, std::abs(y.r[0]));
      }
      CAPTURE(rho, steps);
      CHECK(most <= 1);
    }
}

TEST_CASE("order 2: a motion with a temperature") {
  const auto run = [](int n) {
    states::Coupled c;
    return numbers(march(PhiStepper{c.state, states::WarmPull{}, generalized_alpha(0.2)}, c.state, 0.0, 1.0, n));
  };
  const Eigen::VectorXd reference = run(40 * 1600);
  check_order(errors(200, [&](int n) { return (run(n) - reference).norm(); }), 2);
}

TEMPLATE_TEST_CASE("every scalar: order 2 above the floor of its rounding", "", float, long double) {
  using T = TestType;
  using FlowOf = problems::ForcedFlow<T>;
  check_order(errors(12,
                     [](int n) {
                       const auto y = FlowOf::exact(0);
                       PhiStepper stepper{y, FlowOf{}, generalized_alpha(0.6), capacity(T(FlowOf::capacity))};
                       return distance(march(stepper, y, T(0), T(2), n), FlowOf::exact(2));
                     }),
              2, 0.1);
}

TEST_CASE("the spectral radius is the closed form's, to 1e-12 up to 1e3, to rounding's cube root beyond") {
  for (const double rho : {0.0, 0.2, 0.5, 0.8}) {
    for (const double omega : {0.01, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0, 1000.0}) {
      CAPTURE(rho, omega);
      CHECK(off_closed_form<long double>(rho, omega) <= 1e-12);
    }
    for (const double omega : {1e5, 1e8}) {
      CAPTURE(rho, omega);
      CHECK(off_closed_form<long double>(rho, omega) <= 1e-5);
    }
  }
}

TEST_CASE("y' = zy: the roots of Jansen's form") {
  // (1+ρ)(μ−1)((3−ρ)μ+3ρ−1) = 2z(μ+ρ)²: three values in a row of a run obey it.
  using One = Eigen::Matrix<double, 1, 1>;
  for (const double rho : {0.0, 0.5, 0.8, 1.0})
    for (const double z : {-0.1, -3.0, -1e3, 0.5}) {
      One y(1);
      PhiStepper stepper{y, [z](const One& x) -> One { return z * x; }, generalized_alpha(rho)};
      std::vector<double> at{1};
      for (int n = 0; n < 6; ++n) problems::step(stepper, y, double(n), 1.0), at.push_back(y[0]);
      const double p2 = (1 + rho) * (3 - rho) - 2 * z, p1 = (1 + rho) * (4 * rho - 4) - 4 * z * rho,
                   p0 = (1 + rho) * (1 - 3 * rho) - 2 * z * rho * rho;
      for (std::size_t n = 1; n + 2 < at.size(); ++n) {
        const double a = p2 * at[n + 2], b = p1 * at[n + 1], c = p0 * at[n];
        CAPTURE(rho, z, n, a, b, c);
        CHECK(std::abs(a + b + c) <= 1e-13 * (std::abs(a) + std::abs(b) + std::abs(c)));
      }
    }
}

TEST_CASE("high modes die out where the step changes to and fro, fivefold as well") {
  for (const double rho : {0.0, 0.5, 0.8})
    for (const double ratio : {1.0, 2.0, 5.0}) {
      CAPTURE(rho, ratio);
      const auto [most, end] = high_mode(rho, ratio, ratio > 2 ? 1200 : 300);  // then every other step is a start
      CHECK(most <= 8);
      CHECK(end <= 1e-6);
    }
}

TEST_CASE("order 2 where the step grows threefold and tenfold, to and fro") {
  using V = Eigen::Matrix<double, 1, 1>;
  const auto error = [](double rho, double ratio, int pairs) {
    Motion<V> y{V(1), V(0)};
    PhiStepper stepper{y, [](const V& r) -> V { return -4 * r; }, generalized_alpha(rho)};
    const double h = 2 / (pairs * (1 + ratio));
    double t = 0;
    for (int k = 0; k < 2 * pairs; ++k) {
      const double dt = k % 2 == 0 ? h : ratio * h;
      problems::step(stepper, y, t, dt);
      t += dt;
    }
    return std::hypot(y.r[0] - std::cos(4.0), y.v[0] / 2 + std::sin(4.0));
  };
  for (const double rho : {0.0, 0.5, 0.8})
    for (const double ratio : {3.0, 10.0}) {
      const double order = std::log2(error(rho, ratio, 100) / error(rho, ratio, 200));
      CAPTURE(rho, ratio, order);
      CHECK(order >= 1.9);
      CHECK(order <= 2.1);
    }
}

TEST_CASE("the estimate tends to the error of a step, where steps are equal") {
  const auto misjudged_after = [](auto scheme, double h) {
    const double t = 0.3;
    auto y = Swing::exact(t - 40 * h);
    PhiStepper stepper{y, Swing{}, scheme, mass(Swing::mass)}, slopes{y, Swing{}, scheme, mass(Swing::mass)};
    Trace<Swing::State> trace;
    trace.resize(y);
    auto before = y;
    for (int n = 40; n > 0; --n) {
      before = y;
      REQUIRE(stepper.attempt(y, t - n * h, h, Origin::unknown, trace, yes));
      if (n > 1) trace.advance();
    }
    REQUIRE(trace.has_error);
    return misjudgement(
        trace.error, y,
        solution<Swing::State>([&](double at, const auto& from, auto& out) { return slopes.slope(at, from, out); },
                               before, t - h, h));
  };
  const auto both = [&](auto scheme) {
    check_judgement(misjudged_after(scheme, 0.02), misjudged_after(scheme, 0.005), 0.5);
  };
  for (const double rho : {0.0, 0.5, 0.8, 1.0}) {
    CAPTURE(rho);
    both(generalized_alpha(rho));
  }
  both(hht(-0.3)), both(bossak(-0.3)), both(newmark(0.3, 0.5));
}

TEST_CASE("under a tolerance: errors in proportion, also where a load jumps at times that are known") {
  const auto exact = [] {
    Motion<Vec> y{Vec(1, 0.2), Vec(0, 0.8)};
    for (const double load : {1.0, -3.0, 5.0}) {
      const Vec level(load / 4, 0), r = y.r - level;
      y = {Vec(level + r * std::cos(2) + y.v * std::sin(2) / 2), Vec(y.v * std::cos(2) - 2 * r * std::sin(2))};
    }
    return y;
  }();
  for (const double rho : {0.0, 0.5, 0.8})
    for (const double rtol : {1e-3, 1e-5, 1e-6}) {
      Motion<Vec> y{Vec(1, 0.2), Vec(0, 0.8)};
      PhiStepper stepper{y, Pulled{}, generalized_alpha(rho)};
      const RunReport report = integrate(stepper, y, {0.0, 3.0}, tolerance{.rtol = rtol, .atol = rtol},
                                         at_times({1.0, 2.0}, [](double, const auto&) {}));
      CAPTURE(rho, rtol);
      REQUIRE(report);
      CHECK(distance(y, exact) <= 20 * rtol);
      CHECK(distance(y, exact) >= 0.02 * rtol);
    }
}

TEST_CASE("a step taken back leaves what was known where it began") {
  const auto end = [](bool back) {
    auto y = Swing::exact(0);
    PhiStepper stepper{y, Swing{}, generalized_alpha(0.2), mass(Swing::mass)};
    for (int n = 0; n < 4; ++n) {
      const auto start = y;
      const auto past = stepper.checkpoint();
      problems::step(stepper, y, 0.1 * n, 0.1);
      if (!back) continue;
      y = start;
      stepper.restore(past);
      problems::step(stepper, y, 0.1 * n, 0.1);
    }
    return y;
  };
  CHECK(distance(end(true), end(false)) <= 1e-15);
}

#endif
