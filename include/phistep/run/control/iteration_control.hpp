/// @file
/// Δt from the iterations of the implicit solve (T. I. Zohdi, Comput. Methods Appl. Mech. Engrg. 196 (2007) 3927): a solve
/// that contracts by q = S Δt^p an iteration reaches its tolerance TOL = ε_K/ε_0 in K of them; Δt is to be such that K_d do,
///
///     Λ_K = (TOL/ε_0)^{1/(p K_d)} / (ε_K/ε_0)^{1/(p K)},      Δt ← Λ_K Δt,                                       (1)
///
/// with ε_k the size of the k-th correction, so that ε_K/ε_0 is what the iteration itself stopped at. It rules the algebraic
/// error alone: where the force is weak Δt grows at any accuracy. Hence smaller_of(tolerance{…}, iteration_control{…}).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/run/control/run_clock.hpp"
#include "phistep/run/control/run_report.hpp"
#include "phistep/run/control/variable_step.hpp"
#include "phistep/run/errors/step_filter.hpp"
#include "phistep/run/errors/tolerance.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A run controlled by the number of iterations of its implicit solves (`fixed_point({.depth = 0})` above all).
struct iteration_control {
  double first_step = 0;  ///< [time] needed
  int desired = 6;        ///< K_d, iterations a step
  double order = 2;       ///< p, the power of Δt in the contraction: 2 for a motion, 1 for first order or strong drag
  double min_step = 0;    ///< [time]
  double max_step = std::numeric_limits<double>::infinity();  ///< [time]
  std::int64_t max_steps = 10'000'000;                        ///< tries
};

/// The option that can mean nothing, or null; first_step = 0 can, beside a tolerance.
[[nodiscard]] inline const char* what_cannot_work(const iteration_control& wanted) {
  if (!(wanted.first_step >= 0)) return "first_step of the iteration_control";
  if (wanted.desired < 1) return "desired";
  if (!(wanted.order > 0)) return "order";
  if (!(wanted.min_step >= 0)) return "min_step of the iteration_control";
  if (!(wanted.max_step > 0)) return "max_step of the iteration_control";
  return wanted.max_steps < 0 ? "max_steps of the iteration_control" : nullptr;
}

/// Both: the smaller Δt counts.
struct SmallerOf {
  tolerance error;
  iteration_control iterations;
};
/// Both controllers: each step is the shorter of the two that they ask for.
[[nodiscard]] inline SmallerOf smaller_of(tolerance error, iteration_control iterations) { return {error, iterations}; }

/// Λ_K after a solve in K corrections of the sizes in `history`, within [0.1, 2]. Rounding must not pass for slow
/// convergence: only corrections that still fell count.
[[nodiscard]] inline double iteration_factor(const SolveRecord& record, const iteration_control& wanted) {
  const int corrections = std::min(record.iterations, static_cast<int>(SolveRecord::history_length));
  if (corrections < 2) return 2;
  const auto size = [&](int k) { return record.increments[static_cast<std::size_t>(k)]; };
  if (!(size(0) > 0)) return 2;
  const double reached = size(corrections - 1) / size(0);
  if (!(reached > 0)) return 2;
  if (reached >= 1) return 0.1;  // diverging, or a plateau from the start
  const double K = corrections - 1, desired = std::max(1, wanted.desired - 1);
  return std::clamp(std::pow(reached, (1 / desired - 1 / K) / wanted.order), 0.1, 2.0);
}

/// `iteration_control{…}` alone.
template <State S>
class IterationPace : public VariableStep<ScalarOf<S>> {
  using Length = VariableStep<ScalarOf<S>>;

 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  static constexpr bool sees_error = false;

  explicit IterationPace(const iteration_control& wanted) : wanted_{wanted} {}
  [[nodiscard]] Outcome begin(const Plain&, const ErrorLaw&) {
    if (!(wanted_.first_step > 0)) return Length::refuse({"first_step of the iteration_control", wanted_.first_step});
    if (const char* bad = what_cannot_work(wanted_)) return Length::refuse({bad});
    return Length::bound(wanted_.min_step, wanted_.max_step, wanted_.max_steps);
  }
  [[nodiscard]] Outcome start(TimeSpan<Scalar> span, const Plain&, int, auto&&) {
    Length::set(std::min(wanted_.first_step, std::abs(static_cast<double>(span.t1 - span.t0))));
    return Outcome::success;
  }
  void accepted(const Landing<Scalar>& to, const SolveRecord& record, Limits& limits) {
    const bool was_capped = Length::is_capped();
    const double next = iteration_factor(record, wanted_) * std::abs(static_cast<double>(to.dt));
    Length::set(to.clipped ? std::max(Length::propose(), next) : next);
    limits.count(to.clipped ? LimitedBy::stop : was_capped ? LimitedBy::max_step : LimitedBy::iterations);
  }
  [[nodiscard]] Outcome failed(Outcome why, const Landing<Scalar>& to, const SolveRecord& record, Limits&) {
    if (!may_be_cured(why)) return why;
    return Length::shorten(why, std::abs(static_cast<double>(to.dt)), std::min(0.5, iteration_factor(record, wanted_)));
  }

 private:
  iteration_control wanted_;
};

}}  // namespace phistep::PHISTEP_ABI
