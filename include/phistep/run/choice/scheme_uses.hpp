/// @file
/// Which schemes a run took, when, and why: as numbers while it runs, as words when it is printed.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/version.hpp"
#include "phistep/run/choice/suitable_scheme.hpp"

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
  double rate = 0;        ///< [1/time] |λ|max of ∂y'/∂y there, 0: not looked at
  double dt = 0;          ///< [time] of the steps there
  double entries = -1;    ///< of L an unknown, where a factorization's fill was counted; at least, by Krylov iterations

  /// "rodas5p from t = 0.012, step 34: stiff, …"
  [[nodiscard]] std::string message() const {
    std::string all = reason();
    if (entries < 0) return all;
    char text[120];
    std::snprintf(text, sizeof text, "; %s, a factorization has %s%.1f entries of L an unknown",
                  is_by_krylov(scheme) ? "Krylov iterations" : "direct solver", is_by_krylov(scheme) ? "at least " : "",
                  entries);
    return all + text;
  }

 private:
  [[nodiscard]] std::string reason() const {
    char text[320];
    const char* const name = name_of(scheme);
    switch (cause) {
      case SchemeCause::start:
        std::snprintf(text, sizeof text, "%s from t = %.6g", name, t);
        break;
      case SchemeCause::algebraic:
        std::snprintf(text, sizeof text, "%s from t = %.6g: some equations are algebraic (M is singular)", name, t);
        break;
      case SchemeCause::stiff_start:
        std::snprintf(text, sizeof text,
                      "%s from t = %.6g: stiff from the start, |lambda| = %.3g, where the error allows dt = %.3g", name,
                      t, rate, dt);
        break;
      case SchemeCause::stiff:
        std::snprintf(text, sizeof text,
                      "%s from t = %.6g, step %lld: stiff, the fastest mode held dt at %.3g, |lambda| = %.3g", name, t,
                      static_cast<long long>(step), dt, rate);
        break;
      case SchemeCause::eased:
        std::snprintf(
            text, sizeof text,
            "%s from t = %.6g, step %lld: not stiff any more, |lambda| dt = %.3g is cheaper by explicit steps", name, t,
            static_cast<long long>(step), rate * dt);
        break;
      case SchemeCause::unsolved:
        std::snprintf(text, sizeof text, "%s by a direct solver from t = %.6g, step %lld: Krylov iterations failed",
                      name, t, static_cast<long long>(step));
        break;
      case SchemeCause::stays_explicit:
        std::snprintf(
            text, sizeof text,
            "%s goes on at t = %.6g, step %lld, although it is stiff (|lambda| = %.3g): a Jacobian of so many "
            "unknowns takes a member jacobian(...) or sparsity(force, pattern)",
            name, t, static_cast<long long>(step), rate);
        break;
    }
    return text;
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
  [[nodiscard]] std::string message() const {
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

}}  // namespace phistep::PHISTEP_ABI
