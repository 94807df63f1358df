/// @file
/// The books of an energy ledger: its accounts, what they leave unexplained, and how they are printed.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <type_traits>

#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/version.hpp"

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

/// @tparam scheme_is_rest  the scheme's account is what the others leave
template <class Scalar, bool scheme_is_rest>
class EnergyBooks {
 public:
  /// In at least double precision. [energy]
  using Energy = std::conditional_t<(sizeof(Scalar) > sizeof(double)), Scalar, double>;

  [[nodiscard]] Energy energy() const { return books_.kinetic + books_.potential; }  ///< E at the end of the last step
  [[nodiscard]] Energy kinetic() const { return books_.kinetic; }
  [[nodiscard]] Energy potential() const { return books_.potential; }
  [[nodiscard]] Energy start() const { return books_.start; }                ///< E where the books were opened
  [[nodiscard]] Energy scheme() const { return books_.scheme.value(); }      ///< put in by the scheme (< 0: taken)
  [[nodiscard]] Energy damping() const { return books_.damping.value(); }    ///< … by forces that use the velocity
  [[nodiscard]] Energy external() const { return books_.external.value(); }  ///< … by forces without potential
  [[nodiscard]] Energy solver() const { return books_.solver.value(); }      ///< … by what the solver left unsolved
  [[nodiscard]] Energy edits() const { return books_.edits.value(); }  ///< … between steps: a bounce, a thermostat
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

  template <class OStream>
    requires requires(OStream& out) { out << ""; }
  friend OStream& operator<<(OStream& out, const EnergyBooks& ledger) {
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

}}  // namespace phistep::PHISTEP_ABI
