// The energy ledger of schemes whose balance is not known: damping and external work by quadrature, the scheme's the rest.
#include <utility>

#include "study/energy/energy_ledger_cases.hpp"

using namespace energy_ledger_cases;

namespace {

/// The ledger's accounts after n steps of h.
struct Accounts {
  double start, energy, damping, external, scheme, solver, largest_closure, largest;
  std::int64_t force_calls;
};
template <class Force, class Scheme>
Accounts booked(const Force& force, Scheme scheme, Motion<One> y, double h, int n) {
  PhiStepper stepper{y, force, scheme};
  EnergyLedger ledger{stepper};
  march(stepper, y, h, n, ledger);
  return {ledger.start(),  ledger.energy(),          ledger.damping(),        ledger.external(),   ledger.scheme(),
          ledger.solver(), ledger.largest_closure(), ledger.largest_energy(), ledger.force_calls()};
}

}  // namespace

TEST_CASE("the rest: without damping and external forces it is all of the change, at no force call") {
  const auto check = [](auto scheme, double h) {
    const int n = 100;
    const Accounts b = booked(pendulum, scheme, {One{2.0}, One{0.0}}, h, n);
    CHECK(b.scheme == Approx(b.energy - b.start).margin(1e-15 * b.largest));
    CHECK(std::abs(b.scheme) > 1e-12 * b.largest);
    CHECK(b.damping == 0);
    CHECK(b.external == 0);
    CHECK(b.solver == 0);
    CHECK(b.force_calls == 0);
    CHECK(b.largest_closure <= rounding(n) * b.largest);
  };
  check(tr_bdf2, 0.05);
  check(generalized_alpha(0.2), 0.05);
  check(rodas4, 0.05);
  check(rkn86, 0.5);
  check(composed(velocity_verlet), 0.2);
}

TEST_CASE("the rest: of generalized-alpha it is the algorithmic damping, as its formula has it") {
  // Of a step, with means v̄, r̄ and changes Δ: (α_f − ½) Δt v̄ (Δa + ω² Δr) + Δt² (β − ½γ) r̄ ω² Δa.
  for (const double rho : {0.0, 0.5, 0.9}) {
    const double h = 0.3;
    const AlphaWeights w = generalized_alpha(rho).weights(true);
    Motion<One> y{One{2.0}, One{0.5}};
    PhiStepper stepper{y, spring, generalized_alpha(rho)};
    EnergyLedger ledger{stepper};
    march(stepper, y, h, 1, ledger);  // whose a at the start is not kept
    double damped = 0, a = stepper.working().a().force[0];
    const double before = ledger.scheme(), start = ledger.energy();
    DenseOutput<Motion<One>> dense;
    for (int n = 1; n <= 100; ++n) {
      const auto from = y;
      REQUIRE(stepper.step(y, n * h, h));
      ledger(CompletedStep<Motion<One>>{n * h, h, (n + 1) * h, from, y, dense});
      const double change = stepper.working().a().force[0] - std::exchange(a, stepper.working().a().force[0]);
      const double v = (from.v[0] + y.v[0]) / 2, r = (from.r[0] + y.r[0]) / 2, dr = y.r[0] - from.r[0];
      damped += (w.alpha_f - 0.5) * h * v * (change + omega_squared * dr) +
                h * h * (w.beta - w.gamma / 2) * r * omega_squared * change;
    }
    CAPTURE(rho, before, damped);
    CHECK(ledger.scheme() - before == Approx(damped).margin(100 * 1e-15 * start));
    CHECK(ledger.scheme() - before < -1e-3 * start);
    CHECK(ledger.damping() == 0);
  }
}

TEST_CASE(
    "the rest: of a nonlinear, damped, driven motion with a mass matrix the books close, the scheme's part is O(h²)") {
  using Two = Eigen::Vector2d;
  const auto spring = with_energy([](const Two& r) -> Two { return -(4 + r.squaredNorm()) * r; },
                                  [](const Two& r) { return (2 + r.squaredNorm() / 4) * r.squaredNorm(); });
  const Eigen::MatrixXd M = Eigen::Matrix2d{{2, 0.5}, {0.5, 1}};
  const auto scheme_after = [&](auto scheme, int n) {
    Motion<Two> y{Two{1, 0.2}, Two{0, 0.8}};
    PhiStepper stepper{y, term(spring) + LinearDrag{0.7} + Drive{}, scheme, mass(M)};
    EnergyLedger ledger{stepper};
    march(stepper, y, 2.0 / n, n, ledger);
    CHECK(ledger.largest_closure() <= rounding(n) * ledger.largest_energy());
    CHECK(ledger.solver() == 0);
    CHECK(ledger.damping() < -0.1);
    CHECK(std::abs(ledger.external()) > 0.1);
    return ledger.scheme();
  };
  const auto check = [&](auto scheme) {
    const double ratio = scheme_after(scheme, 200) / scheme_after(scheme, 400);
    CHECK(ratio >= 3.2);
    CHECK(ratio <= 4.8);
  };
  check(generalized_alpha(0.3)), check(hht(-0.2)), check(bossak(-0.2)), check(newmark(0.3, 0.5));
}

TEST_CASE("the rest: drag takes what the motion says, to order 6 of the step") {
  // v = v0 e^{-ct}: by t = 2 the drag has taken v0^2 (1 - e^{-4c})/2. rodas5p is of order 5: its own error is the larger.
  const double c = 0.8, v0 = 3, exact = -0.5 * v0 * v0 * (1 - std::exp(-4 * c));
  double before = 0;
  for (const int n : {4, 8, 16}) {
    const Accounts b = booked(LinearDrag{c}, rodas5p, {One{0.0}, One{v0}}, 2.0 / n, n);
    const double error = std::abs(b.damping - exact);
    if (n > 4) CHECK(before / error > 24);  // 2^5 in the limit
    before = error;
    CHECK(std::abs(b.scheme) <= 4 * error + 1e-14);
    CHECK(b.external == 0);
    CHECK(b.force_calls == 3 * n + 1);
  }
  CHECK(before <= 1e-6 * -exact);
}

TEST_CASE("the rest: a driving force and a potential that depends on time do external work") {
  // A spring in resonance, r = t sin(t)/2: by t = 2 pi, E = pi^2/2, put in from outside. Driven by a force, and by the
  // potential of the same force.
  const double pi = 3.14159265358979323846, E = pi * pi / 2;
  const auto resonance =
      with_energy([](const One& r) -> One { return -r; }, [](const One& r) { return r.squaredNorm() / 2; });
  const auto pulled = with_energy([](const One& r, const One&, double t) -> One { return One{-r[0] + std::cos(t)}; },
                                  [](const One& r, double t) { return r.squaredNorm() / 2 - r[0] * std::cos(t); });
  const int n = 64;
  const Accounts force = booked(term(resonance) + Drive{}, rodas4, {One{0.0}, One{0.0}}, 2 * pi / n, n);
  CHECK(force.external == Approx(E).epsilon(1e-5));
  CHECK(std::abs(force.scheme) <= 1e-5 * E);
  CHECK(force.damping == 0);
  // V is -r cos t + r^2/2 here, so that at the end E is what it was before less r cos t = 0.
  const Accounts potential = booked(pulled, rodas4, {One{0.0}, One{0.0}}, 2 * pi / n, n);
  CHECK(potential.external + potential.damping == Approx(potential.energy).margin(1e-4));
  CHECK(std::abs(potential.scheme) <= 1e-4 * E);
}

TEST_CASE("the rest: drag that a step does not resolve takes no more than there was") {
  const double start = 0.5 * 9;
  for (const double c : {1e2, 1e4, 1e6}) {
    const Accounts b = booked(LinearDrag{c}, rodas4, {One{0.0}, One{3.0}}, 0.1, 10);
    CAPTURE(c);
    CHECK(b.start == start);
    CHECK(b.damping <= 0);
    CHECK(b.damping >= -1.5 * start);
    CHECK(std::abs(b.scheme) <= start);
  }
}

TEST_CASE("the rest: a split step is booked with its kicks") {
  const auto resonance =
      with_energy([](const One& r) -> One { return -r; }, [](const One& r) { return r.squaredNorm() / 2; });
  const int n = 1000;
  const Accounts b =
      booked(term(resonance) + at(forward_euler, Drive{}), trapezoidal, {One{0.0}, One{0.0}}, 6.0 / n, n);
  const double t = 6, r = t * std::sin(t) / 2, v = (std::sin(t) + t * std::cos(t)) / 2;
  CHECK(b.external == Approx((r * r + v * v) / 2).epsilon(1e-4));
  CHECK(std::abs(b.scheme) <= 1e-4 * b.largest);
}
