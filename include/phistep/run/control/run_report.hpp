/// @file
/// What a run leaves behind beside the state.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/version.hpp"
#include "phistep/run/control/limits.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// How a run ended, and what it did. Contextually true where it reached t1.
struct [[nodiscard]] RunReport {
  Outcome outcome = Outcome::success;      ///< why the run ended; success: at t1
  double t = 0;                            ///< [time] where the state stands now
  Statistics statistics;                   ///< of this run alone
  Failure failure;                         ///< of the step that ended the run, if one did
  double smallest_dt = 0, largest_dt = 0;  ///< [time] the shortest and the longest step taken
  const char* refused = nullptr;           ///< the option that can't work, where the outcome is invalid_tolerance
  Limits limits;                           ///< what kept a controlled run's steps from being longer

  [[nodiscard]] explicit operator bool() const { return outcome == Outcome::success; }
  void archive(auto& ar) {
    ar("outcome", outcome, "t", t, "counts", statistics, "failure", failure, "smallest_dt", smallest_dt, "largest_dt",
       largest_dt, "limits", limits);
  }
  /// What happened, where, and what to try.
  [[nodiscard]] std::string message() const {
    if (outcome == Outcome::success) return explain(outcome);
    if (failure.outcome == outcome) return failure.message();
    char where[96];  // no step failed, so that there is no more to tell
    std::snprintf(where, sizeof where, "%s%s; at t = %.9g", refused != nullptr ? ": " : "",
                  refused != nullptr ? refused : "", t);
    return explain(outcome, where);
  }

  template <class OStream>
    requires requires(OStream& out) { out << "" << 0.0 << std::int64_t{}; }
  friend OStream& operator<<(OStream& out, const RunReport& report) {
    out << report.message() << "\n  reached t           " << report.t << '\n' << report.statistics;
    if (report.largest_dt > report.smallest_dt)
      out << "  dt                  " << report.smallest_dt << " ... " << report.largest_dt << '\n';
    out << report.limits;
    return out;
  }
};

}}  // namespace phistep::PHISTEP_ABI
