/// @file
/// The books of an energy ledger: its accounts, what they leave unexplained, and how they are printed.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <type_traits>

#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/unknowns.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A sum that keeps what rounding takes from it (Neumaier, ZAMM 54 (1974) 39).
template <class Scalar>
class CompensatedSum {
 public:
  void add(Scalar x) {
    const Scalar sum = sum_ + x;
    lost_ += std::abs(sum_) >= std::abs(x) ? (sum_ - sum) + x : (x - sum) + sum_;
    sum_ = sum;
  }
  [[nodiscard]] Scalar value() const { return sum_ + lost_; }
  void archive(auto& ar) { ar("sum", sum_, "lost", lost_); }

 private:
  Scalar sum_{0}, lost_{0};
};

/// @tparam scheme_is_rest  the scheme's account is ΔE less all other accounts
template <class Scalar, bool scheme_is_rest>
class EnergyBooks {
 public:
  /// At least double precision. [energy]
  using Energy = std::conditional_t<(sizeof(Scalar) > sizeof(double)), Scalar, double>;

  [[nodiscard]] Energy energy() const { return books_.kinetic + books_.potential; }  ///< E at the end of the last step
  [[nodiscard]] Energy kinetic() const { return books_.kinetic; }
  [[nodiscard]] Energy potential() const { return books_.potential; }
  [[nodiscard]] Energy start() const { return books_.start; }                ///< E where the books were opened
  [[nodiscard]] Energy scheme() const { return books_.scheme.value(); }      ///< put in by the scheme (< 0: taken)
  [[nodiscard]] Energy damping() const { return books_.damping.value(); }    ///< put in by forces that use the velocity
  [[nodiscard]] Energy external() const { return books_.external.value(); }  ///< put in by forces without potential
  [[nodiscard]] Energy solver() const { return books_.solver.value(); }      ///< put in by the solver's tolerance
  [[nodiscard]] Energy edits() const { return books_.edits.value(); }        ///< between steps: a bounce, a thermostat
  /// What all accounts together leave unexplained: rounding.
  [[nodiscard]] Energy closure() const {
    CompensatedSum<Energy> rest;
    for (const Energy x : {energy(), -start(), -scheme(), -damping(), -external(), -solver(), -edits()}) rest.add(x);
    return rest.value();
  }
  [[nodiscard]] Energy largest_closure() const { return books_.largest_closure; }  ///< in magnitude, of all steps
  /// The largest |E| met: what the accounts are printed relative to.
  [[nodiscard]] Energy largest_energy() const { return books_.largest; }
  [[nodiscard]] std::int64_t steps() const { return books_.steps; }
  [[nodiscard]] std::int64_t force_calls() const { return books_.force_calls; }  ///< the ledger's own

  friend auto& operator<<(TextStream auto& out, const EnergyBooks& ledger) {
    char line[128];
    const auto print = [&](const char* name, Energy x) {
      const double energy = static_cast<double>(x), scale = static_cast<double>(ledger.books_.largest);
      std::snprintf(line, sizeof line, "  %-20s%16.8e%14.1e\n", name, energy, scale > 0 ? energy / scale : 0.0);
      out << line;
    };
    std::snprintf(line, sizeof line, "energy over %lld steps      [energy]   of max |E|\n",
                  static_cast<long long>(ledger.books_.steps));
    out << line;
    print("at the start", ledger.start());
    print(scheme_is_rest ? "scheme (the rest)" : "scheme", ledger.scheme());
    print("damping", ledger.damping());
    print("external work", ledger.external());
    print("solver", ledger.solver());
    print("edits", ledger.edits());
    print("at the end", ledger.energy());
    print("closure", ledger.closure());
    print("largest closure", ledger.largest_closure());
    return out;
  }

 protected:
  /// What begins anew with each run.
  struct Books {
    Energy kinetic{0}, potential{0}, start{0}, largest{0}, largest_closure{0};
    CompensatedSum<Energy> scheme, damping, external, solver, edits;
    Scalar t{};
    std::int64_t steps = 0, force_calls = 0;
    bool begun = false, known = false;

    void archive(auto& ar) {
      ar("kinetic", kinetic, "potential", potential, "start", start, "largest", largest, "largest_closure",
         largest_closure, "scheme", scheme, "damping", damping, "external", external, "solver", solver, "edits", edits);
      ar("t", t, "steps", steps, "force_calls", force_calls, "begun", begun, "known", known);
      ar.check(can_be_count(steps) && can_be_count(force_calls));
    }
  };
  Books books_;
};

// The way of a motion through one step, from what is known at its ends: with x = (t − t0)/h and D0 … D2 what Taylor's
// polynomial from t0 leaves of r1, h v1 and h² a1,
//
// r(x)   = r0 + h v0 x + ½h² a0 x² + x³ (c3 + c4 x + c5 x²),                                                 (1)
// c3 = 10 D0 − 4 D1 + ½D2,   c4 = −15 D0 + 7 D1 − D2,   c5 = 6 D0 − 3 D1 + ½D2
//
// the polynomial of degree 5 through r, v and a at both ends, off by O(h⁶). Integrals over the step by the rule of Gauss
// and Lobatto with four nodes, exact to degree 5:
//
// ∫f dt ≈ h (f(0) + 5 f(½−√5/10) + 5 f(½+√5/10) + f(1))/12                                                  (2)

/// ∫ f(x, y) dt over the step, for each f of an array, by (2) on (1). Where the rule is off `mean` by more than half of ∫ |f| dt,
/// the step doesn't resolve it, and that counts.
/// @param a0, a1  the accelerations at the ends, shaped like v
/// @param place   scratch
template <State S, class Block, class Number, std::size_t n>
[[nodiscard]] std::array<Number, n> integrate_on_path(ScalarOf<S> h, const PlainState<S>& y0, const Block& a0,
                                                      const PlainState<S>& y1, const Block& a1, PlainState<S>& place,
                                                      const std::array<Number, n>& mean, auto&& f) {
  using Scalar = ScalarOf<S>;
  std::array<Number, n> integral{}, size{};
  const auto add = [&](double weight, const std::array<Number, n>& values) {
    const Number share = static_cast<Number>(h) * static_cast<Number>(weight);
    for (std::size_t k = 0; k < n; ++k) integral[k] += share * values[k], size[k] += std::abs(share * values[k]);
  };
  const auto &r0 = position_of<S>(y0), &v0 = velocity_of<S>(y0), &r1 = position_of<S>(y1), &v1 = velocity_of<S>(y1);
  auto &r = position_of<S>(place), &v = velocity_of<S>(place);
  const Scalar half{0.5}, square = h * h;
  add(1.0 / 12, f(0, y0));
  add(1.0 / 12, f(1, y1));
  for (const double node : {0.27639320225002103036, 0.72360679774997896964}) {
    const auto x = static_cast<Scalar>(node);
    for (Index i = 0; i < r0.size(); ++i) {
      const Scalar hv = h * v0.data()[i], ha = square * a0.data()[i];
      const Scalar d0 = r1.data()[i] - r0.data()[i] - hv - half * ha, d1 = h * v1.data()[i] - hv - ha,
                   d2 = square * a1.data()[i] - ha;
      const Scalar c3 = 10 * d0 - 4 * d1 + half * d2, c4 = -15 * d0 + 7 * d1 - d2, c5 = 6 * d0 - 3 * d1 + half * d2;
      r.data()[i] = r0.data()[i] + x * (hv + x * (half * ha + x * (c3 + x * (c4 + x * c5))));
      v.data()[i] = (hv + x * (ha + x * (3 * c3 + x * (4 * c4 + x * (5 * c5))))) / h;
    }
    add(5.0 / 12, f(node, place));
  }
  for (std::size_t k = 0; k < n; ++k)
    if (!(std::abs(integral[k] - mean[k]) <= size[k] / 2)) integral[k] = mean[k];
  return integral;
}

}}  // namespace phistep::PHISTEP_ABI
