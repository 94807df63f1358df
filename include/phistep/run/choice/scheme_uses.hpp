/// @file
/// Which schemes a run took, when, and why: as numbers while it runs, as words when it is printed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "phistep/base/outcome/statistics.hpp"
#include "phistep/run/choice/suitable_scheme.hpp"
#include "phistep/run/control/run_report.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Why a scheme was taken.
enum class SchemeCause : std::uint8_t {
  start,        ///< the run begins, nothing is known of its stiffness
  stiff_start,  ///< the first step that the error allows is far beyond what an explicit scheme bears, or the whole run is
  algebraic,    ///< M is singular
  stiff,        ///< stability, not the error, limited Δt
  eased,        ///< an explicit scheme would do it for less
  unsolved,     ///< Krylov iterations failed
  stays_explicit  ///< it is stiff, but an implicit scheme can't serve: no Jacobian, no pattern, too many unknowns
};

/// A scheme that a run took.
struct SchemeUse {
  SuitableScheme scheme = SuitableScheme::dormand_prince_8;
  SchemeCause cause = SchemeCause::start;
  double t = 0;           ///< [time] from there on
  std::int64_t step = 0;  ///< after so many steps of the run
  double rate = 0;        ///< [1/time] |λ|max of ∂y'/∂y there, 0: not estimated
  double dt = 0;          ///< [time] of the steps there
  double entries = -1;    ///< of L an unknown, where a factorization's fill was counted; at least, by Krylov iterations

  /// "rodas5p from t = 0.012, step 34: stiff, …"
  [[nodiscard, gnu::cold]] std::string message() const {
    const bool goes_on = cause == SchemeCause::stays_explicit, is_direct = cause == SchemeCause::unsolved;
    std::string all = name_of(scheme);
    all += (goes_on     ? " goes on at t = "
            : is_direct ? " by a direct solver from t = "
                        : " from t = ") +
           number_text(t, 6);
    if (cause >= SchemeCause::stiff) all += ", step " + std::to_string(step);
    all += why();
    if (entries < 0) return all;
    return all +
           (is_by_krylov(scheme) ? "; Krylov iterations, a factorization has at least "
                                 : "; direct solver, a factorization has ") +
           number_text(entries, 3) + " entries of L an unknown";
  }

 private:
  [[nodiscard, gnu::cold]] std::string why() const {
    const std::string lambda = "|lambda| = " + number_text(rate, 3);
    switch (cause) {
      case SchemeCause::algebraic:
        return ": some equations are algebraic (M is singular)";
      case SchemeCause::stiff_start:
        return ": stiff from the start, " + lambda + ", where the error allows dt = " + number_text(dt, 3);
      case SchemeCause::stiff:
        return ": stiff, the fastest mode held dt at " + number_text(dt, 3) + ", " + lambda;
      case SchemeCause::eased:
        return ": not stiff any more, |lambda| dt = " + number_text(rate * dt, 3) + " is cheaper by explicit steps";
      case SchemeCause::unsolved:
        return ": Krylov iterations failed";
      case SchemeCause::stays_explicit:
        return ", although it is stiff (" + lambda +
               "): a Jacobian of so many unknowns takes a member jacobian(...) or sparsity(force, pattern)";
      case SchemeCause::start:
        break;
    }
    return {};
  }
};

/// The uses of a run, the first of them one by one.
class SchemeUses {
 public:
  static constexpr std::size_t kept = 50;

  void add(const SchemeUse& use) {
    if (uses_.size() < kept) uses_.push_back(use);
    ++count_;
  }
  [[nodiscard]] const std::vector<SchemeUse>& list() const { return uses_; }
  [[nodiscard]] std::int64_t count() const { return count_; }  ///< also of those that are not in the list
  /// A line each.
  [[nodiscard, gnu::cold]] std::string message() const {
    std::string all;
    for (const SchemeUse& use : uses_) all += "  " + use.message() + '\n';
    const auto left = count_ - static_cast<std::int64_t>(uses_.size());
    if (left > 0) all += "  ... and " + std::to_string(left) + " more\n";
    return all;
  }

  void archive(auto& ar) {
    ar.columns("uses", uses_, "scheme", &SchemeUse::scheme, "cause", &SchemeUse::cause, "t", &SchemeUse::t, "step",
               &SchemeUse::step, "rate", &SchemeUse::rate, "dt", &SchemeUse::dt, "entries", &SchemeUse::entries);
    ar("count", count_);
    ar.check(uses_.size() <= kept && can_be_count(count_));
    for (const SchemeUse& use : uses_)
      ar.check(use.scheme <= SuitableScheme::rodas_5p_krylov && use.cause <= SchemeCause::stays_explicit &&
               can_be_count(use.step));
  }

 private:
  std::vector<SchemeUse> uses_;
  std::int64_t count_ = 0;
};

/// A RunReport, and which schemes the run took.
struct [[nodiscard]] AutomaticReport : RunReport {
  SchemeUses schemes;

  friend auto& operator<<(TextStream auto& out, const AutomaticReport& report) {
    out << static_cast<const RunReport&>(report) << "  schemes\n" << report.schemes.message();
    return out;
  }
};

}}  // namespace phistep::PHISTEP_ABI
