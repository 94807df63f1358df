// A force that jumps in time where steps end: everything that asks it for a step asks it on the step's own side, whichever way the
// jump is written: states inside of steps, Jacobians, slow terms, the energy ledger.
#include <phistep/autodiff.hpp>
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>

#include "support/catch.hpp"

using namespace phistep;
using One = Eigen::Matrix<double, 1, 1>;

namespace {

/// `before` up to t = 1, which belongs to it or not, then `behind`.
struct Switch {
  bool with_end;
  double before, behind;
  [[nodiscard]] double operator()(double t) const { return (with_end ? t <= 1 : t < 1) ? before : behind; }
};

/// y' = −k(t) (y − sin t), with its Jacobian.
struct Relaxes {
  Switch k;
  [[nodiscard]] auto operator()(const auto& y, double t) const {
    return std::remove_cvref_t<decltype(y)>((y.array() - std::sin(t)) * -k(t));
  }
};
struct WithJacobian : Relaxes {
  [[nodiscard]] One jacobian(const One&, double t) const { return One{-k(t)}; }
};

constexpr auto nothing = [](double, const auto&) {};

struct Push : ForceTerm {
  Switch load;
  static constexpr bool uses_velocity = false;
  void add(double t, const auto&, auto& out) const { out.force[0] += load(t); }
};

}  // namespace

TEST_CASE("states inside the step behind a stop, and inside a run's first step, know the load behind the jump") {
  const auto worst = [](const auto& scheme, bool with_end, double t0) {
    One y{0};
    PhiStepper stepper{y, [load = Switch{with_end, 0, 1}](const One&, double t) -> One { return One{load(t)}; },
                       scheme};
    double off = 0;
    auto look =
        sampled(0.05, [&off](double t, const One& at) { off = std::max(off, std::abs(at[0] - std::max(t - 1, 0.0))); });
    REQUIRE(integrate(stepper, y, {t0, 2}, fixed(0.25), at_times({1.0}, nothing), look));
    return off;
  };
  for (const bool with_end : {false, true})
    for (const double t0 : {0.0, 1.0}) {
      CAPTURE(with_end, t0);
      CHECK(worst(trapezoidal, with_end, t0) <= 1e-14);
      CHECK(worst(dop853, with_end, t0) <= 1e-14);
      CHECK(worst(rodas4p2, with_end, t0) <= 1e-14);
    }
}

TEST_CASE("a Jacobian that jumps with its force is the force's, at a stop and where a run begins") {
  const auto error = [](const auto& force, const auto& scheme, auto... solver) {
    One y{0};
    PhiStepper stepper{y, force, scheme, solver...};
    REQUIRE(integrate(stepper, y, {0, 2}, fixed(1.0 / 7), at_times({1.0}, nothing)));
    return std::abs(y[0] - 0.906199633246);  // closed form, and 400,000 steps of Runge and Kutta's scheme
  };
  for (const bool with_end : {false, true}) {
    const Relaxes force{{with_end, 20, 1}};
    CAPTURE(with_end);
    CHECK(error(WithJacobian{force}, rodas5p) <= 5e-8);
    CHECK(error(autodiff(force), rodas5p) <= 5e-8);
    CHECK(error(WithJacobian{force}, radau) <= 1e-7);
    CHECK(error(WithJacobian{force}, trapezoidal, linearly_implicit()) <= 2e-3);
  }
}

TEST_CASE("a slow term that jumps at a stop keeps its order, and the ledger books its work where it was done") {
  for (const bool with_end : {false, true}) {
    CAPTURE(with_end);
    const Push push{{}, {with_end, 1, -2}};
    Motion y{One{0}, One{0}};  // v' = 1, then −2
    const auto fast = term([](const One& r) -> One { return 0 * r; });
    PhiStepper slow{y, fast + seldom(4, push), velocity_verlet};
    REQUIRE(integrate(slow, y, {0, 2}, fixed(0.02), at_times({1.0}, nothing)));
    CHECK(std::abs(y.v[0] + 1) <= 1e-13);

    for (const double of_field : {0.0, 1.0}) {  // the load as a force, or a part of it as a potential
      Motion z{One{0}, One{0.5}};
      const Switch field{with_end, of_field, -2 * of_field}, rest{with_end, 1 - of_field, 2 * of_field - 2};
      const auto potential = with_energy([field](const One&, const One&, double t) -> One { return One{field(t)}; },
                                         [field](const One& r, double t) { return -field(t) * r[0]; });
      PhiStepper stepper{z, term(potential) + Push{{}, rest}, trapezoidal};
      EnergyLedger ledger{stepper};
      REQUIRE(integrate(stepper, z, {0, 2}, fixed(0.25), at_times({1.0}, nothing), std::ref(ledger)));
      // Straight lines: v from 0.5 to 1.5, then to −0.5; r(1) = 1, r(2) = 1.5. V jumps by 3 r(1) of the field.
      CHECK(std::abs(static_cast<double>(ledger.solver())) <= 1e-14);
      CHECK(std::abs(static_cast<double>(ledger.scheme())) <= 1e-14);
      CHECK(std::abs(static_cast<double>(ledger.external()) - (of_field == 0 ? 0.0 : 3.0)) <= 1e-14);
    }
  }
}
