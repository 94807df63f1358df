/// @file
/// What a run leaves behind beside the state, and what kept its steps from being longer.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <string>

#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/run/errors/tolerance.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// An option that can't work.
struct Refused {
  const char* option = nullptr;  ///< null: there is none
  std::optional<double> is{};    ///< its value
  double least = 0;              ///< the least that works, where that is known
};

enum class LimitedBy : std::uint8_t {
  nothing,
  error,       ///< the error of the component named
  iterations,  ///< the implicit solve: too many, or it failed
  max_step,
  stop,       ///< a time at which the run was to stop
  not_finite  ///< a longer step met a force or a state that isn't
};

/// One reason, and the number of steps that it shortened.
struct Limit {
  LimitedBy by = LimitedBy::nothing;
  Component where;  ///< of an error: a component that ruled, that of more than half of the steps if there is one
  std::int64_t steps = 0;
};

/// Of the components that some steps named, that of more than half of them, if there is one (the majority vote of R. S. Boyer &
/// J S. Moore, 1981).
class MostNamed {
 public:
  void name(const Component& one) {
    if (votes_ == 0) where_ = one;
    votes_ += one == where_ ? 1 : -1;
    ++steps_;
  }
  [[nodiscard]] const Component& where() const { return where_; }
  [[nodiscard]] std::int64_t steps() const { return steps_; }
  void archive(auto& ar) {
    ar("block", where_.block, "index", where_.index, "votes", votes_, "named", steps_);
    ar.check(can_be_count(steps_) && 0 <= votes_ && votes_ <= steps_);
  }

 private:
  Component where_;
  std::int64_t votes_ = 0, steps_ = 0;  // for where_, less those against; of all
};

/// Counts the steps by reason, and what a run without atol has seen of its components.
class Limits {
 public:
  void count(LimitedBy by, Component where = {}) {
    ++steps_[static_cast<std::size_t>(by)];
    if (by == LimitedBy::error) worst_.name(where);
  }
  /// The most frequent reason.
  [[nodiscard]] Limit most() const {
    const auto most = std::max_element(steps_.begin(), steps_.end());
    if (*most == 0) return {};
    const auto by = static_cast<LimitedBy>(most - steps_.begin());
    return {by, by == LimitedBy::error ? worst_.where() : Component{}, *most};
  }
  [[nodiscard]] std::int64_t steps() const { return std::accumulate(steps_.begin(), steps_.end(), std::int64_t{0}); }

  /// The component that ruled by its error.
  [[nodiscard]] const Component& worst() const { return worst_.where(); }
  /// Without atol: components with fewer digits than rtol asks for; those that grew 10³ times in one step.
  MostNamed below, leapt;
  bool has_own_scales = false;

  /// "  dt limited by       the error, e.g. of component 3 of block 0, in 71 % of the steps"
  friend auto& operator<<(TextStream auto& out, const Limits& limits) {
    const Limit most = limits.most();
    if (most.by == LimitedBy::nothing) return out;
    static constexpr const char* names[]{
        "nothing",  "the error, e.g. of component ", "the iterations of the implicit solve",
        "max_step", "the times to stop at",          "a force or a state that is not finite"};
    out << "  dt limited by       " << names[static_cast<std::size_t>(most.by)];
    if (most.by == LimitedBy::error) out << most.where.index << " of block " << most.where.block;
    out << ", in " << 100 * most.steps / limits.steps() << " % of the steps\n";
    if (!limits.has_own_scales) return out;
    out << "  atol                none given";
    if (limits.below.steps() > 0)
      out << ": component " << limits.below.where().index << " of block " << limits.below.where().block
          << ", or another, had fewer digits than rtol in " << 100 * limits.below.steps() / limits.steps()
          << " % of the steps";
    out << '\n';
    return out;
  }

  void archive(auto& ar) {
    ar("steps", steps_, "worst", worst_, "below", below, "leapt", leapt, "own_scales", has_own_scales);
    for (const std::int64_t steps : steps_) ar.check(can_be_count(steps));
  }

 private:
  std::array<std::int64_t, static_cast<std::size_t>(LimitedBy::not_finite) + 1> steps_{};
  MostNamed worst_;
};

/// How a run ended, and what it did. Contextually true where it reached t1.
struct [[nodiscard]] RunReport {
  Outcome outcome = Outcome::success;      ///< why the run ended; success: at t1
  double t = 0;                            ///< [time] where the state stands now
  Statistics statistics;                   ///< of this run alone
  Failure failure;                         ///< of the step that ended the run, if one did
  double smallest_dt = 0, largest_dt = 0;  ///< [time] the shortest and the longest step taken
  double last_dt = 0;                      ///< [time] the last step
  Refused refused;                         ///< the option that can't work, where one ended the run
  Limits limits;                           ///< what kept a controlled run's steps from being longer

  [[nodiscard]] explicit operator bool() const { return outcome == Outcome::success; }
  void archive(auto& ar) {
    ar("outcome", outcome, "t", t, "counts", statistics, "failure", failure, "smallest_dt", smallest_dt, "largest_dt",
       largest_dt, "last_dt", last_dt, "limits", limits);
  }
  /// What happened, where, and what to try.
  [[nodiscard, gnu::cold]] std::string message() const {
    if (outcome == Outcome::success) return explain(outcome) + doubts();
    if (failure.outcome == outcome) return failure.message() + doubts();
    // No step failed: there is none to describe.
    std::string where = refused.option != nullptr ? std::string(": ") + refused.option : "";
    if (refused.is)
      where += " (" + number_text(*refused.is, 6) +
               (refused.least > 0 ? "; it works from " + number_text(refused.least, 3) + " on)" : std::string(")"));
    where += "; at t = " + number_text(t, 9);
    const bool is_for_error = outcome == Outcome::too_many_steps || outcome == Outcome::step_too_small;
    if (is_for_error) where += of_component(", for the error of", limits.worst());
    return explain(outcome, where, advice()) + doubts();
  }
  /// What is odd about a run, whatever its outcome. Empty where nothing is.
  [[nodiscard, gnu::cold]] std::string doubts() const {
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
  [[nodiscard]] bool has_shrunk() const { return outcome == Outcome::too_many_steps && 1e3 * last_dt < largest_dt; }
  /// What to try, where the run knows more than its outcome says; else empty.
  [[nodiscard, gnu::cold]] std::string advice() const {
    if (has_shrunk())
      return "look for a jump of the force (a sign, a switch, friction): dt fell from " + number_text(largest_dt, 3) +
             " to " + number_text(last_dt, 3) +
             ", and the state may be held on such a jump, which switches back and forth (chattering): no dt is short "
             "enough there; smooth the jump, or step along it with the force that holds there. Else another scheme";
    if (outcome == Outcome::invalid_tolerance && refused.least > 0)
      return "rtol >= " + number_text(refused.least, 3) + ", which this scheme's rounding allows, or a wider scalar";
    if (outcome == Outcome::step_too_small && refused.option != nullptr)
      return "measure time from the start of the run: numbers near t = " + number_text(t, 3) +
             " are too far apart for this dt";
    return failure.is_singular ? advise_on_index(outcome) : "";
  }
  [[nodiscard, gnu::cold]] static std::string of_component(const char* what, const Component& where) {
    if (where.block < 0) return {};
    return std::string{what} + " component " + std::to_string(where.index) + " of block " + std::to_string(where.block);
  }

 public:
  friend auto& operator<<(TextStream auto& out, const RunReport& report) {
    out << report.message() << "\n  reached t           " << report.t << '\n' << report.statistics;
    if (report.largest_dt > report.smallest_dt)
      out << "  dt                  " << report.smallest_dt << " ... " << report.largest_dt << '\n';
    out << report.limits;
    return out;
  }
};

}}  // namespace phistep::PHISTEP_ABI
