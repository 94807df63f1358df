/// @file
/// What a scheme is: a text over the kernel (problem/kernel.hpp), `SchemeOn<Scheme, S>` for states of type S, with
///
///     template <class Rhs> static constexpr KernelNeeds needs;   what it asks of the kernel
///     SchemeOn(scheme, y)                                        y gives the sizes of what it keeps
///     int order() const;
///     Outcome step(kernel, step);                                fills step.next, leaves step.y; where `step` is
///                                                                traced, also the trace: its slopes and its error
///     static constexpr bool traces;                              it takes traced steps
///     bool estimates(trace);                                     … with an estimate of the error, given this past
///     int error_order() const;                                   … which goes as this power of Δt
///                                                                (or step() judges it, and sets trace.proposed)
///     static constexpr bool interpolates;                        it knows the solution inside the step just accepted:
///     interpolate(x, dt, y0, y1, out) const;                     out = y(t + x dt), 0 < x < 1
///     static constexpr std::array<double, 2> doubtful_at;        two x where that is worst, to be checked by real steps
///
/// and what it inherits from SchemeDefaults, where it keeps nothing from step to step.
#pragma once

#include <array>

#include "phistep/core/stepper_facts.hpp"
#include "phistep/core/version.hpp"
#include "phistep/problem/kernel.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep::inline PHISTEP_ABI {

/// A scheme on states of type S, each in a header of its own (phistep.hpp includes all).
template <class Scheme, State S>
class SchemeOn {
  static_assert(!sizeof(Scheme), "phistep: this is no scheme, or the header that defines it is not included");
};

/// Of a scheme that keeps nothing from step to step.
struct SchemeDefaults {
  /// How far a scheme has come since its start: part of a checkpoint.
  struct Progress {};
  [[nodiscard]] static Progress progress() { return {}; }
  static void resume(Progress) {}
  static void resize(const auto& /*y*/) {}
  static void archive(auto& /*ar*/) {}
  static void forget() {}    ///< nothing carried from step to step may be trusted
  static void reset() {}     ///< the next step is the first
  static void accepted() {}  ///< the step just advanced has become the state
  static constexpr bool traces = false, interpolates = false;
  static constexpr std::array<double, 2> doubtful_at = usually_doubtful;
};

}  // namespace phistep::inline PHISTEP_ABI
