// The oscillator r'' = −ω²r for up to 10⁸ steps, in units of Δt: a = ωΔt.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "endurance/drift.hpp"
#include "problems/oscillator.hpp"
#include "support/catch.hpp"

namespace {

template <class T>
using One = Eigen::Matrix<T, 1, 1>;
template <class T>
constexpr double u = static_cast<double>(std::numeric_limits<T>::epsilon()) / 2;

template <class T>
struct Spring {
  T k;
  One<T> operator()(const One<T>& r) const { return -k * r; }
  One<T> jacobian(const One<T>& /*r*/) const { return One<T>{-k}; }
};

/// v² + share ω²r², relative to the start, over the run.
template <class T>
endurance::Trend follow(const std::string& name, auto force, auto scheme, T a, double steps, long double share = 1) {
  phistep::Motion<One<T>> y{One<T>(T{1}), One<T>(T(0.3) * a)};
  phistep::PhiStepper stepper{y, force, scheme};
  const auto energy = [&] {
    const long double r = y.r[0], v = y.v[0];
    return v * v + share * static_cast<long double>(a * a) * r * r;
  };
  const long double start = energy();
  const auto series = endurance::follow(
      {name}, static_cast<std::int64_t>(steps),
      [&](std::int64_t from, std::int64_t to) {
        const auto report = phistep::integrate(stepper, y, {T{0}, static_cast<T>(to - from)}, phistep::fixed(1));
        if (!report) FAIL(report.message());
      },
      [&] { return std::array{energy() / start - 1}; });
  return series[0].trend();
}

/// An affine oscillator: energy by a random walk alone, of what one step rounds.
template <class T>
void keeps_energy(const std::string& name, auto scheme, T a, double steps) {
  const auto trend = follow(name, phistep::linear(One<T>(-a * a)), scheme, a, steps);
  const std::string which = "a = " + figures::text(static_cast<double>(a)) + ", " + figures::text(steps) + " steps";
  // Half a dozen roundings of up to u of the larger of v and γv, γ = Δt/2: no more than 2u·max(1, a/2) a step, rms. √n of
  // them, and five times that has a probability of 1e-6.
  const double walk = 2 * u<T> * std::max(1.0, static_cast<double>(a) / 2);
  figures::at_most(5 * walk * std::sqrt(steps), trend.worst, name + " keeps the energy", which + ": max |dE/E|");
  figures::at_most(5, std::abs(trend.t), name + " does not drift", which + ": |t| of Student's test");
}

}  // namespace

TEST_CASE("an affine oscillator at phi = 1/2 keeps its energy for 1e8 steps: a random walk, no drift") {
  keeps_energy("trapezoidal", phistep::trapezoidal, 0.1, 1e8);
  keeps_energy("midpoint", phistep::midpoint, 0.1, 1e8);
  keeps_energy("midpoint, stiff", phistep::midpoint, 3.0, 1e8);
  keeps_energy("trapezoidal, stiff", phistep::trapezoidal, 30.0, 1e7);
}

TEST_CASE("in float it is the same walk") {
  keeps_energy("trapezoidal, float", phistep::trapezoidal, 0.1F, 1e7);
  keeps_energy("midpoint, float", phistep::midpoint, 0.1F, 1e7);
  keeps_energy("midpoint, float, stiff", phistep::midpoint, 3.0F, 1e7);
}

TEST_CASE("what drifts: beyond a = 32, and under Newton") {
  // The one rounding in 1/W, the same each step, counts twice; W's own two besides.
  for (const double a : {100.0, 1e3, 1e6}) {
    const auto trend = follow("affine midpoint", phistep::linear(One<double>(-a * a)), phistep::midpoint, a, 1e7);
    const std::string which = "a = " + figures::text(a) + ": |drift| [u/step]";
    figures::at_most(4, std::abs(trend.slope) / u<double>, "affine, a > 32: up to four roundings a step", which);
  }
  // Newton's last correction is rounding, correlated with the iterate's own.
  for (const double a : {0.1, 0.7, 3.0, 1e3}) {
    const auto trend = follow("midpoint by Newton", Spring<double>{a * a}, phistep::midpoint, a, 1e7);
    const std::string which = "a = " + figures::text(a) + ": |drift| [u/step]";
    figures::at_most(0.1, std::abs(trend.slope) / u<double>, "Newton: up to a tenth of a rounding a step", which);
  }
}

TEST_CASE("Verlet keeps its own energy v^2 + (1 - a^2/4) w^2 r^2 to rounding, and so the energy within a^2/4") {
  const double a = 0.1;
  const auto own = follow("Verlet, its own energy", Spring<double>{a * a}, phistep::velocity_verlet, a, 1e8,
                          1 - static_cast<long double>(a * a) / 4);
  figures::at_most(5 * 2 * u<double> * 1e4, own.worst, "Verlet keeps its own energy", "1e8 steps: max |dE/E|");
  figures::at_most(5, std::abs(own.t), "Verlet does not drift", "1e8 steps: |t| of Student's test");
  const auto energy = follow("Verlet", Spring<double>{a * a}, phistep::velocity_verlet, a, 1e7);
  // E = E' + a²/4 ω²r²: at the start r² is 1/1.09 of its largest, and E' + … swings between that and 0.
  figures::at_most(a * a / 4 * 1.01, energy.worst, "Verlet's energy error is bounded",
                   "1e7 steps: max |dE/E|, a = 0.1");
  figures::at_most(5, std::abs(energy.t), "Verlet's energy does not drift", "1e7 steps: |t| of Student's test");
}

TEST_CASE("backward Euler's decay is its formula's, 1/(1 + a^2) a step, over a million of them") {
  const double a = 1e-2;
  phistep::Motion<One<double>> y{One<double>(1), One<double>(0.3 * a)};
  const problems::Oscillator oscillator{a * a};
  for (const bool affine : {true, false}) {
    auto x = y;
    phistep::PhiStepper once{x, phistep::linear(One<double>(-a * a)), phistep::backward_euler};
    phistep::PhiStepper newton{x, Spring<double>{a * a}, phistep::backward_euler};
    const long double start = oscillator.energy(x);
    const auto report = affine ? phistep::integrate(once, x, {0.0, 1e6}, phistep::fixed(1))
                               : phistep::integrate(newton, x, {0.0, 1e6}, phistep::fixed(1));
    REQUIRE(report);
    const long double expected = -1e6L * std::log1p(static_cast<long double>(a * a));
    const auto error = static_cast<double>(std::abs(std::expm1(std::log(oscillator.energy(x) / start) - expected)));
    // e⁻¹⁰⁰ of it is left. A rounding of ω²Δt² = 1e-4, always the same, is 1e-4 u of the rate: 1e6 of those, and a walk.
    figures::at_most(5 * 2 * u<double> * 1e3 + 1e2 * u<double>, error, "backward Euler decays by its own formula",
                     std::string(affine ? "affine" : "Newton") + ", 1e6 steps: relative error of E");
  }
}
