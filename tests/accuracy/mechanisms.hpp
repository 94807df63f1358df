#pragma once

// A family of random rate equations whose components differ in size: mass-action mechanisms, a small oscillation beside large
// constants, reactions beside a temperature. The exact end of a member is that of radau at a tight tolerance, with which rodas5p
// agrees; the same run gives the largest size of each component.
//
// A result is judged by component: |y_i − exact_i| in units of κ rtol times the component's largest size. κ tells how the end
// moves, in the same units, where the start values, the constants and the state at three times on the way change by rtol.

#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "accuracy/truth/random.hpp"
#include "problems/hires.hpp"
#include "problems/oregonator.hpp"
#include "problems/robertson.hpp"
#include "support/battery.hpp"

namespace mechanisms {

using Vec = Eigen::VectorXd;
using Constants = std::vector<double>;

/// y' = rate(constants, y) in plain units; the state holds y_i × unit_i.
struct Rates {
  std::function<void(const Constants& k, const double* y, double* out)> rate = {};
  Constants constants = {};
  Vec unit = {};

  Vec operator()(const Vec& y) const {
    const Vec plain = y.cwiseQuotient(unit);
    Vec out(y.size());
    rate(constants, plain.data(), out.data());
    return out.cwiseProduct(unit);
  }
};

/// An observer: the largest size of each component.
struct Largest {
  Vec size = {};
  void operator()(double /*t*/, const Vec& y) { size = size.cwiseMax(y.cwiseAbs()); }
};

struct End {
  phistep::RunReport report;
  Vec y, largest;  ///< in plain units
};
/// From `start` (in plain units) over a time by a stepper of the scheme.
[[nodiscard]] End run(const Rates& rates, const Vec& start, double time, auto scheme,
                      const phistep::tolerance& control) {
  Vec y = start.cwiseProduct(rates.unit);
  Largest seen{y.cwiseAbs()};
  phistep::PhiStepper stepper{y, rates, scheme};
  const phistep::RunReport report = phistep::integrate(stepper, y, {0, time}, control, std::ref(seen));
  return {report, y.cwiseQuotient(rates.unit), seen.size.cwiseQuotient(rates.unit)};
}

struct Member {
  std::string name = {};
  Rates rates = {};
  Vec start = {};
  double time = 1, rtol = 1e-3;
  std::vector<bool> stays_zero = {};  ///< components that nothing makes
  // by the references
  Vec exact = {}, largest = {};
  double kappa = 1, kappa_atol = 1;  ///< for rtol alone; where errors of atol() may happen, too

  /// The worst component's |a − b| over its largest size. What stays 0 has no size, and isn't judged.
  [[nodiscard]] double distance(const Vec& a, const Vec& b) const {
    double worst = 0;
    for (Eigen::Index i = 0; i < a.size(); ++i) {
      if (largest[i] == 0) continue;
      const double apart = std::abs(a[i] - b[i]) / largest[i];
      worst = apart <= worst ? worst : std::isfinite(apart) ? apart : 1e300;
    }
    return worst;
  }
  /// A sensible .atol by component, in plain units: a thousandth of rtol of its largest size.
  [[nodiscard]] Vec atol() const { return 1e-3 * rtol * largest.cwiseMax(1e-9 * largest.maxCoeff()); }
};

[[nodiscard]] inline phistep::tolerance tight(double rtol, const Vec& atol) {
  return {.rtol = rtol, .atol = atol, .max_steps = 50'000};
}

/// How far the end moves, in units of rtol of the largest sizes, where constants and states change by ± rtol and ± floor.
[[nodiscard]] inline double condition(const Member& m, const Vec& atol, const Vec& floor) {
  truth::Random random{977};
  double worst = 1;
  for (int k = 0; k < 2; ++k) {
    const auto sign = [&random] { return random.chance(0.5) ? 1.0 : -1.0; };
    Rates moved = m.rates;
    for (double& c : moved.constants) c *= 1 + sign() * m.rtol;
    Vec y = m.start;
    double t = 0;
    for (const double share : {1e-3, 0.03, 0.3, 1.0}) {
      for (Eigen::Index i = 0; i < y.size(); ++i) y[i] += sign() * (m.rtol * std::abs(y[i]) + floor[i]);
      const End next = run(moved, y, share * m.time - t, phistep::radau, tight(1e-9, atol));
      if (!next.report) return 1e300;
      y = next.y, t = share * m.time;
    }
    worst = std::max(worst, m.distance(y, m.exact) / m.rtol);
  }
  return worst;
}

/// Fills what the references tell. False where they cannot judge: they differ, or κ is so large that nothing is asked.
[[nodiscard]] inline bool refer(Member& m) {
  const Eigen::Index n = m.start.size();
  m.rates.unit = Vec::Ones(n);
  const End rough =
      run(m.rates, m.start, m.time, phistep::radau, tight(1e-7, Vec::Constant(n, 1e-22 * m.start.maxCoeff())));
  if (!rough.report) return false;
  const Vec atol = 1e-13 * rough.largest.cwiseMax(1e-9 * rough.largest.maxCoeff());
  const End first = run(m.rates, m.start, m.time, phistep::radau, tight(1e-11, atol));
  const End second = run(m.rates, m.start, m.time, phistep::rodas5p, tight(1e-10, atol));
  if (!first.report || !second.report) return false;
  m.exact = first.y, m.largest = first.largest;
  for (std::size_t i = 0; i < m.stays_zero.size(); ++i)
    if (m.stays_zero[i]) {
      double& size = m.largest[static_cast<Eigen::Index>(i)];
      if (size > 1e-12 * m.largest.maxCoeff()) return false;  // rounding has grown
      size = 0;
    }
  if (m.distance(first.y, second.y) > 0.1 * m.rtol) return false;
  m.kappa = condition(m, atol, Vec::Zero(n));
  m.kappa_atol = std::max(m.kappa, condition(m, atol, m.atol()));
  return m.kappa < 1000;
}

// ---- the family -----------------------------------------------------------------------------------------------------

/// One or two reactants, one or two products.
struct Reaction {
  int from[2], to[2];
  int reactants, products;

  [[nodiscard]] double speed(double k, const double* y) const {
    return k * y[from[0]] * (reactants == 2 ? y[from[1]] : 1);
  }
  /// Adds to d y/dt; the sum of all species stays.
  void add(double speed, double* out) const {
    for (int j = 0; j < reactants; ++j) out[from[j]] -= speed;
    for (int j = 0; j < products; ++j) out[to[j]] += speed * reactants / products;
  }
};
[[nodiscard]] inline std::vector<Reaction> random_reactions(truth::Random& random, int species) {
  std::vector<Reaction> all;
  for (int r = 0; r < 2 * species; ++r) {
    Reaction q{};
    const auto pair = [&](int(&two)[2]) {
      two[0] = random.integer(0, species - 1);
      two[1] = (two[0] + random.integer(1, species - 1)) % species;
      return random.integer(1, 2);
    };
    q.reactants = pair(q.from), q.products = pair(q.to);
    all.push_back(q);
  }
  return all;
}
[[nodiscard]] inline std::vector<bool> never_made(const std::vector<Reaction>& reactions, const Vec& start,
                                                  int species) {
  std::vector<bool> zero(static_cast<std::size_t>(start.size()));
  for (std::size_t i = 0; i < zero.size(); ++i) zero[i] = start[static_cast<Eigen::Index>(i)] == 0;
  for (int round = 0; round < species; ++round)
    for (const Reaction& q : reactions) {
      bool happens = true;
      for (int j = 0; j < q.reactants; ++j) happens = happens && !zero[static_cast<std::size_t>(q.from[j])];
      for (int j = 0; happens && j < q.products; ++j) zero[static_cast<std::size_t>(q.to[j])] = false;
    }
  return zero;
}

/// 3 to 8 species, constants from 1e-3 to 1e6; half of the start values are 0.
[[nodiscard]] inline Member mechanism(truth::Random& random) {
  Member m;
  m.name = "mechanism";
  const int n = random.integer(3, 8);
  const std::vector<Reaction> reactions = random_reactions(random, n);
  for (int r = 0; r < 2 * n; ++r) m.rates.constants.push_back(random.power_of_ten(-3, 6));
  m.rates.rate = [reactions, n](const Constants& k, const double* y, double* out) {
    std::fill(out, out + n, 0.0);
    for (std::size_t r = 0; r < reactions.size(); ++r) reactions[r].add(reactions[r].speed(k[r], y), out);
  };
  m.start = Vec::Zero(n);
  for (double& y : m.start) y = random.chance(0.5) ? random.power_of_ten(-4, 0) : 0;
  m.start[0] = 1;
  m.stays_zero = never_made(reactions, m.start, n);
  m.time = random.power_of_ten(-1, 2);
  return m;
}

/// Van der Pol's oscillator (μ = 0: a harmonic one) of amplitude 1e-6 … 0.1 beside one to three values of 100 to 10,000
/// that rest or settle.
[[nodiscard]] inline Member oscillator(truth::Random& random) {
  Member m;
  m.name = "oscillator beside constants";
  const double amplitude = random.power_of_ten(-6, -1), mu = random.chance(0.3) ? 0 : random.uniform(0.2, 5);
  const int others = random.integer(1, 3);
  m.rates.constants = {mu, 1};
  m.start = Vec::Zero(2 + others);
  m.start[0] = 2 * amplitude;
  std::vector<double> level;
  for (int j = 0; j < others; ++j) {
    level.push_back(random.power_of_ten(2, 4));
    m.rates.constants.push_back(random.chance(0.5) ? random.power_of_ten(-1, 1) : 0);
    m.start[2 + j] = level.back() * (random.chance(0.5) ? 1 : 0.9);
  }
  m.rates.rate = [amplitude, level](const Constants& k, const double* y, double* out) {
    const double x = y[0] / amplitude, v = y[1] / amplitude;
    out[0] = y[1];
    out[1] = amplitude * (k[0] * (1 - x * x) * v - k[1] * x);
    for (std::size_t j = 0; j < level.size(); ++j) out[2 + j] = k[2 + j] * (level[j] - y[2 + j]);
  };
  m.time = random.power_of_ten(0.3, 1.3);
  return m;
}

/// A mechanism of 3 to 5 species at 1e-6 … 0.1 whose constants follow a temperature; a species' energy is at most 500 K.
[[nodiscard]] inline Member heated(truth::Random& random) {
  Member m;
  m.name = "reactions beside a temperature";
  const int n = random.integer(3, 5);
  const double size = random.power_of_ten(-6, -1), cold = random.uniform(600, 2000);
  const std::vector<Reaction> reactions = random_reactions(random, n);
  std::vector<double> activation, energy;
  for (const Reaction& r : reactions) {
    m.rates.constants.push_back(random.power_of_ten(-2, 5) / (r.reactants == 2 ? size : 1));
    activation.push_back(random.uniform(0, 12'000));
  }
  for (int i = 0; i < n; ++i) energy.push_back(random.uniform(0, 500) / size);
  m.rates.constants.push_back(random.power_of_ten(-2, 1));  // cooling
  m.rates.rate = [=](const Constants& k, const double* y, double* out) {
    std::fill(out, out + n, 0.0);
    for (std::size_t r = 0; r < reactions.size(); ++r)
      reactions[r].add(reactions[r].speed(k[r] * std::exp(activation[r] * (1 / cold - 1 / y[n])), y), out);
    out[n] = -k.back() * (y[n] - cold);
    for (int i = 0; i < n; ++i) out[n] -= energy[static_cast<std::size_t>(i)] * out[i];
  };
  m.start = Vec::Zero(n + 1);
  for (double& y : m.start) y = random.chance(0.5) ? size * random.power_of_ten(-3, 0) : 0;
  m.start[0] = size, m.start[n] = cold;
  m.stays_zero = never_made(reactions, m.start, n);
  m.time = random.power_of_ten(-2, 1);
  return m;
}

/// A member of the family: six mechanisms, two oscillators and two with a temperature in ten; rtol 1e-2 … 1e-6.
[[nodiscard]] inline Member member(int number) {
  truth::Random random{static_cast<std::uint64_t>(4600 + number)};
  const int kind = number % 10;
  Member m = kind < 6 ? mechanism(random) : kind < 8 ? oscillator(random) : heated(random);
  m.rtol = std::pow(10.0, -random.integer(2, 6));
  m.name += " " + std::to_string(number);
  return m;
}
/// Other units: each component's number is 1e-9 to 1e9 times what it was.
[[nodiscard]] inline Vec other_units(int number, Eigen::Index n) {
  truth::Random random{static_cast<std::uint64_t>(9'000'000 + number)};
  Vec unit(n);
  for (double& u : unit) u = random.power_of_ten(-9, 9);
  return unit;
}

// ---- problems with a name -------------------------------------------------------------------------------------------

template <class Problem>
[[nodiscard]] Member known_problem(const std::string& name, double time) {
  Member m;
  m.name = name, m.start = Problem::start(), m.time = time;
  m.rates.rate = [](const Constants&, const double* y, double* out) { Problem::rate(y, out); };
  return m;
}
/// x'' = μ (1 − x²) x' − x from (2, 0)
[[nodiscard]] inline Member van_der_pol(double mu, double time) {
  Member m;
  m.name = "Van der Pol, mu " + figures::text(mu), m.start = Vec{{2, 0}}, m.time = time;
  m.rates.constants = {mu};
  m.rates.rate = [](const Constants& k, const double* y, double* out) {
    out[0] = y[1], out[1] = k[0] * (1 - y[0] * y[0]) * y[1] - y[0];
  };
  return m;
}
/// Chain branching: fuel F, oxygen O, a radical X from 0, a product P, the temperature.
/// F + O → 2X, F + O + X → 2X, X → P, 2X → P
[[nodiscard]] inline Member ignition() {
  Member m;
  m.name = "ignition", m.start = Vec{{0.02, 0.01, 0, 0, 1000}}, m.time = 0.002;
  m.rates.constants = {1e9, 2e10, 3e3, 1e8};
  m.rates.rate = [](const Constants& k, const double* y, double* out) {
    const double temperature = y[4];
    const double start = k[0] * std::exp(-24000 / temperature) * y[0] * y[1];
    const double branch = k[1] * std::exp(-8300 / temperature) * y[2] * y[1], loss = k[2] * y[2],
                 join = k[3] * y[2] * y[2];
    out[0] = out[1] = -start - branch;
    out[2] = 2 * start + branch - loss - 2 * join;
    out[3] = loss + join;
    out[4] = 8e3 * branch + 2e4 * join + 1e4 * loss - 0.5 * (temperature - 1000);
  };
  return m;
}
[[nodiscard]] inline std::vector<Member> named_problems() {
  std::vector<Member> all;
  for (const double time : {40.0, 4e2, 4e4, 4e6, 4e8, 1e11})
    all.push_back(known_problem<problems::Robertson>("Robertson to " + figures::text(time), time));
  all.push_back(known_problem<problems::Hires>("HIRES", problems::Hires::end));
  all.push_back(known_problem<problems::Oregonator>("Oregonator", problems::Oregonator::end));
  all.push_back(ignition());
  all.push_back(van_der_pol(5, 8));
  all.push_back(van_der_pol(1000, 2000));
  return all;
}

// ---- the batteries --------------------------------------------------------------------------------------------------

struct Tallies {
  battery::Tally alone, units, refused, by_component, by_component_units;
  int skipped = 0;
};

/// Each member four times: with rtol alone and with an atol by component, in plain and in other units.
/// @param run  End run(number, member, tolerance)
[[nodiscard]] Tallies judge(const std::string& who, int members, auto run) {
  Tallies all;
  all.alone.name = who + ", rtol alone: beyond 100 kappa rtol";
  all.units.name = who + ", rtol alone: moved by other units";
  all.refused.name = who + ", rtol alone: refused";
  all.by_component.name = who + ", atol by component: beyond 100 kappa rtol, or refused";
  all.by_component_units.name = who + ", atol by component: the same in other units";
  for (int number = 0, used = 0; used < members; ++number) {
    Member m = member(number);
    if (!refer(m)) {
      ++all.skipped;
      continue;
    }
    ++used;
    const auto go = [&](const phistep::AbsoluteTolerance& atol) {
      return run(number, m, phistep::tolerance{.rtol = m.rtol, .atol = atol, .max_steps = 20'000});
    };
    const auto error = [&m](const End& end) { return m.distance(end.y, m.exact) / (m.kappa * m.rtol); };
    const auto told = [&](const End& end, double measured) {
      return m.name + ", rtol " + figures::text(m.rtol) + ": " + figures::text(measured) + " kappa rtol, kappa " +
             figures::text(m.kappa) + "; " + std::to_string(end.report.statistics.steps) + " steps, " +
             end.report.message().substr(0, 60);
    };
    const End own = go({}), own_atol = go(m.atol());
    m.rates.unit = other_units(number, m.start.size());
    const End other = go({}), other_atol = go(Vec(m.atol().cwiseProduct(m.rates.unit)));

    const bool own_wrong = own.report && !(error(own) <= 100), other_wrong = other.report && !(error(other) <= 100);
    all.alone.count(!own_wrong && !other_wrong, own_wrong ? told(own, error(own)) : told(other, error(other)));
    const double moved = m.distance(own.y, other.y) / (m.kappa * m.rtol);
    all.units.count(bool(own.report) == bool(other.report) && (!own.report || moved <= 3), told(other, moved));
    all.refused.count(own.report && other.report, told(own.report ? other : own, 0));
    if (m.kappa_atol > 1000) continue;
    const auto error_atol = [&m](const End& end) { return m.distance(end.y, m.exact) / (m.kappa_atol * m.rtol); };
    all.by_component.count(own_atol.report && error_atol(own_atol) <= 100, told(own_atol, error_atol(own_atol)));
    all.by_component_units.count(other_atol.report && error_atol(other_atol) <= 100,
                                 told(other_atol, error_atol(other_atol)));
  }
  return all;
}

/// The named problems at rtol 1e-2 and 1e-3 alone. Wrong: refused, or beyond 100 κ rtol.
/// @param run  End run(scheme, member, tolerance); scheme < schemes
[[nodiscard]] battery::Tally judge_named(const std::string& who, int schemes, auto run) {
  battery::Tally all;
  all.name = who + ", rtol alone: beyond 100 kappa rtol, or refused";
  for (Member& m : named_problems())
    for (const double rtol : {1e-2, 1e-3}) {
      m.rtol = rtol;
      if (!refer(m)) {
        all.wrong_one(m.name + ": no reference");
        continue;
      }
      for (int scheme = 0; scheme < schemes; ++scheme) {
        const End end = run(scheme, m, phistep::tolerance{.rtol = rtol, .max_steps = 50'000});
        const double error = m.distance(end.y, m.exact) / (m.kappa * rtol);
        all.count(end.report && error <= 100, m.name + ", scheme " + std::to_string(scheme) + ", rtol " +
                                                  figures::text(rtol) + ": " + figures::text(error) + " kappa rtol; " +
                                                  end.report.message().substr(0, 60));
      }
    }
  return all;
}

}  // namespace mechanisms
