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

/// As reports print it.
[[nodiscard]] inline std::string number_text(double x, int digits) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, x);
  return text;
}

/// How a run ended, and what it did. Contextually true where it reached t1.
struct [[nodiscard]] RunReport {
  Outcome outcome = Outcome::success;      ///< why the run ended; success: at t1
  double t = 0;                            ///< [time] where the state stands now
  Statistics statistics;                   ///< of this run alone
  Failure failure;                         ///< of the step that ended the run, if one did
  double smallest_dt = 0, largest_dt = 0;  ///< [time] the shortest and the longest step taken
  Refused refused;                         ///< the option that can't work, where one ended the run
  Limits limits;                           ///< what kept a controlled run's steps from being longer

  [[nodiscard]] explicit operator bool() const { return outcome == Outcome::success; }
  void archive(auto& ar) {
    ar("outcome", outcome, "t", t, "counts", statistics, "failure", failure, "smallest_dt", smallest_dt, "largest_dt",
       largest_dt, "limits", limits);
  }
  /// What happened, where, and what to try.
  [[nodiscard]] std::string message() const {
    if (outcome == Outcome::success) return explain(outcome) + doubts();
    if (failure.outcome == outcome) return failure.message() + doubts();
    // No step failed: there is none to describe.
    std::string where = refused.option != nullptr ? std::string(": ") + refused.option : "";
    if (refused.is)
      where += " (" + number_text(*refused.is, 6) +
               (refused.least > 0 ? "; it works from " + number_text(refused.least, 3) + " on)" : std::string(")"));
    where += "; at t = " + number_text(t, 9);
    return explain(outcome, where + of_component(", for the error of", limits.worst()), advice()) + doubts();
  }
  /// What is odd about a run, whatever its outcome. Empty where nothing is.
  [[nodiscard]] std::string doubts() const {
    std::string text;
    const std::int64_t failed = statistics.rejections + statistics.failed_steps;
    if (failed > 100 && failed > statistics.steps && !has_shrunk())
      text += " More tries failed (" + std::to_string(failed) + ") than steps were done (" +
              std::to_string(statistics.steps) +
              "): another scheme, or an .atol for what is small, may do with far fewer.";
    if (limits.leapt.steps() > 0)
      text += " In " + std::to_string(limits.leapt.steps()) + " steps a component grew more than a thousandfold" +
              of_component(":", limits.leapt.where()) + ". Look whether that is so, with a smaller rtol.";
    return text;
  }

 private:
  [[nodiscard]] bool has_shrunk() const { return outcome == Outcome::too_many_steps && 1e3 * smallest_dt < largest_dt; }
  /// What to try where this run says more than its outcome; else empty.
  [[nodiscard]] std::string advice() const {
    if (has_shrunk())
      return "look for a jump of the force (a sign, a switch, friction): dt fell from " + number_text(largest_dt, 3) +
             " to " + number_text(smallest_dt, 3) +
             ", and the state may be held on such a jump, which switches back and forth (chattering): no dt is short "
             "enough there; smooth the jump, or step along it with the force that holds there. Else another scheme";
    if (outcome == Outcome::invalid_tolerance && refused.least > 0)
      return "rtol >= " + number_text(refused.least, 3) + ", which this scheme's rounding allows, or a wider scalar";
    if (outcome == Outcome::step_too_small && refused.option != nullptr)
      return "measure time from the start of the run: numbers near t = " + number_text(t, 3) +
             " are too far apart for this dt";
    return failure.is_singular ? advise_on_index(outcome) : "";
  }
  [[nodiscard]] static std::string of_component(const char* what, const Component& where) {
    if (where.block < 0) return {};
    return std::string{what} + " component " + std::to_string(where.index) + " of block " + std::to_string(where.block);
  }

 public:
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
