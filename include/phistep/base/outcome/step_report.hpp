/// @file
/// What `step` returns: 16 bytes; the story of a failure stays in the stepper and becomes text on demand.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <string>
#include <type_traits>

#include "phistep/base/outcome/outcome.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// As reports print it. (Texts are cold: then compilers make them short, which is a quarter of a small program.)
[[nodiscard, gnu::cold]] inline std::string number_text(double x, int digits) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, x);
  return text;
}
/// The outcome as a paragraph: what happened, the details known, what to try.
/// @param advice  in place of what helps in general
[[nodiscard, gnu::cold]] inline std::string explain(Outcome outcome, const std::string& details = {},
                                                    const std::string& advice = {}) {
  std::string text = std::string("phistep: ") + describe(outcome) + details;
  if (!advice.empty()) text += ". Try: " + advice;
  else if (*advise(outcome) != '\0') text += std::string(". Try: ") + advise(outcome);
  return text + '.';
}
/// What to try where M is singular, of outcomes that its index may explain; else empty.
[[nodiscard]] inline const char* advise_on_index(Outcome outcome) {
  using enum Outcome;
  if (outcome != newton_diverged && outcome != newton_stalled && outcome != singular_matrix &&
      outcome != step_too_small)
    return "";
  return "look at the algebraic equations (M is singular): one that doesn't contain an unknown of its own (index 2 or "
         "more) fails at any dt, until it is differentiated in time; else check the Jacobian (check_jacobian), and the "
         "force for jumps";
}

/// What the solves of a step did.
struct SolveRecord {
  static constexpr std::size_t history_length = 24;

  int iterations = 0;                               ///< Newton or fixed-point iterations done
  std::array<double, history_length> increments{};  ///< relative size of each one's correction δ
  std::int64_t particle = -1;                       ///< whose own equations failed, where each has its own
  bool is_singular = false;                         ///< the mass matrix is

  void add(double increment) {
    if (static_cast<std::size_t>(iterations) < history_length)
      increments[static_cast<std::size_t>(iterations)] = increment;
    ++iterations;
  }
  void begin() {
    iterations = 0;
    particle = -1;
  }
};

/// A component of a state.
struct ComponentLocation {
  std::int64_t block = -1;   ///< which block of the state (motion: 0 = r, 1 = v), −1 = unknown
  std::int64_t index = -1;   ///< which component of that block, in storage order
  std::int64_t row = -1;     ///< of a matrix-shaped block: the component
  std::int64_t column = -1;  ///< of a matrix-shaped block: the particle
  [[nodiscard]] explicit operator bool() const { return block >= 0; }
};

/// The details of the last failed step, kept by the stepper.
struct Failure : SolveRecord, ComponentLocation {
  Outcome outcome = Outcome::success;
  double t = 0;                        ///< [time] start of the step
  double dt = 0;                       ///< [time] its length
  int term = -1;                       ///< which term of a sum, −1 = unknown or not a sum
  std::int64_t returned_rows = -1;     ///< of a result of the wrong size, −1 = there was none
  std::int64_t returned_columns = -1;  ///< likewise

  void archive(auto& ar) {
    ar("outcome", outcome, "t", t, "dt", dt, "block", block, "index", index, "row", row, "column", column, "particle",
       particle, "term", term, "returned_rows", returned_rows, "returned_columns", returned_columns, "is_singular",
       is_singular, "iterations", iterations, "increments", increments);
    ar.check(0 <= iterations && iterations < 1 << 30);
  }

  /// Everything known, as one paragraph.
  [[nodiscard, gnu::cold]] std::string message() const {
    std::string text;
    if (index >= 0) {
      text += ", component " + std::to_string(index);
      if (block >= 0) text += " of block " + std::to_string(block);
      if (column >= 0) text += " (particle " + std::to_string(column) + ", row " + std::to_string(row) + ")";
    }
    if (particle >= 0 && column < 0) text += ", particle " + std::to_string(particle);
    if (term >= 0) text += ", from term " + std::to_string(term) + " of the sum";
    if (returned_rows >= 0)
      text += ": it is " + std::to_string(returned_rows) + " x " + std::to_string(returned_columns);
    text += "; at t = " + number_text(t, 9) + ", dt = " + number_text(dt, 9);
    if (iterations > 0) {
      const bool newton = outcome != Outcome::iteration_diverged && outcome != Outcome::iteration_stalled;
      text += newton ? "; relative Newton increments" : "; relative increments";
      const auto shown = std::min(static_cast<std::size_t>(iterations), history_length);
      for (std::size_t k = 0; k < shown; ++k) text += ' ' + number_text(increments[k], 2);
    }
    return explain(outcome, text, is_singular ? advise_on_index(outcome) : "");
  }
};

/// The result of one step. Contextually true on success; on failure the state is bit for bit what it was.
class [[nodiscard]] StepReport {
 public:
  constexpr StepReport() = default;
  constexpr StepReport(Outcome outcome, int iterations, const Failure* failure)
      : failure_{failure}, iterations_{iterations}, outcome_{outcome} {}

  [[nodiscard]] constexpr explicit operator bool() const { return outcome_ == Outcome::success; }
  [[nodiscard]] constexpr Outcome outcome() const { return outcome_; }
  [[nodiscard]] constexpr int iterations() const { return iterations_; }  ///< Newton iterations of this step

  /// The details of a failure. Valid, like message(), until the stepper's next step, move or end of life.
  [[nodiscard]] Failure failure() const { return failure_ != nullptr ? *failure_ : Failure{}; }
  /// What happened, where, and what to try. Valid until the stepper's next step, move or end of life.
  [[nodiscard]] std::string message() const { return failure_ != nullptr ? failure_->message() : explain(outcome_); }

 private:
  const Failure* failure_ = nullptr;
  std::int32_t iterations_ = 0;
  Outcome outcome_ = Outcome::success;
};
static_assert(sizeof(StepReport) <= 16 && std::is_trivially_copyable_v<StepReport>);

}}  // namespace phistep::PHISTEP_ABI
