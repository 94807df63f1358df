/// @file
/// Counts of the work done, so that "skipped" is a number that a test can assert.
#pragma once

#include <cstdint>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// What a stepper has done since it was made (or, in a RunReport, during one run).
struct Statistics {
  std::int64_t steps = 0;              ///< steps that succeeded
  std::int64_t failed_steps = 0;       ///< steps that failed and left the state as it was
  std::int64_t force_calls = 0;        ///< evaluations of Ψ, those for difference Jacobians included
  std::int64_t jacobians = 0;          ///< evaluations of ∂Ψ/∂y
  std::int64_t factorizations = 0;     ///< of the step's matrix M − γC − γ²K
  std::int64_t analyses = 0;           ///< symbolic analyses of a sparse pattern
  std::int64_t solves = 0;             ///< linear solves
  std::int64_t iterations = 0;         ///< Newton iterations
  std::int64_t linear_iterations = 0;  ///< iterations of an iterative linear solver
  std::int64_t fallbacks = 0;          ///< solves whose indefinite tangent was clamped or solved by LU instead

  friend constexpr Statistics operator-(Statistics a, const Statistics& b) {
    a.steps -= b.steps;
    a.failed_steps -= b.failed_steps;
    a.force_calls -= b.force_calls;
    a.jacobians -= b.jacobians;
    a.factorizations -= b.factorizations;
    a.analyses -= b.analyses;
    a.solves -= b.solves;
    a.iterations -= b.iterations;
    a.linear_iterations -= b.linear_iterations;
    a.fallbacks -= b.fallbacks;
    return a;
  }
  friend constexpr bool operator==(const Statistics&, const Statistics&) = default;

  /// One line a count. A template, so that the core needs no stream header.
  template <class OStream>
    requires requires(OStream& out) { out << "" << std::int64_t{}; }
  friend OStream& operator<<(OStream& out, const Statistics& s) {
    out << "  steps           " << s.steps;
    if (s.failed_steps != 0) out << "  (and " << s.failed_steps << " failed)";
    out << "\n  force calls     " << s.force_calls << "\n  Jacobians       " << s.jacobians << "\n  factorizations  "
        << s.factorizations << "\n  linear solves   " << s.solves << "\n  iterations      " << s.iterations << '\n';
    if (s.linear_iterations != 0) out << "  linear iterations " << s.linear_iterations << '\n';
    if (s.fallbacks != 0) out << "  fallbacks       " << s.fallbacks << '\n';
    if (s.analyses != 0) out << "  pattern analyses " << s.analyses << '\n';
    return out;
  }
};

}  // namespace phistep::inline PHISTEP_ABI
