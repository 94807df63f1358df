/// @file
/// Counts of the work done, so that "skipped" is a number that a test can assert.
#pragma once

#include <cstdint>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// What a stepper has done since it was made (or, in a RunReport, during one run).
struct Statistics {
  std::int64_t steps = 0;           ///< steps that succeeded
  std::int64_t failed_steps = 0;    ///< steps that failed and left the state as it was
  std::int64_t force_calls = 0;     ///< evaluations of Ψ, those for difference Jacobians included
  std::int64_t jacobians = 0;       ///< evaluations of ∂Ψ/∂y
  std::int64_t factorizations = 0;  ///< of the step's matrix M − γC − γ²K
  std::int64_t analyses = 0;        ///< symbolic analyses of a sparse pattern
  std::int64_t solves = 0;          ///< linear solves
  std::int64_t iterations = 0;      ///< Newton iterations
  std::int64_t kick_calls = 0;      ///< evaluations of the terms at φ = 0 of a split scene, beside force_calls
  std::int64_t halvings = 0;        ///< steps replaced by two half steps

  friend constexpr Statistics operator-(Statistics a, const Statistics& b) {
    a.steps -= b.steps;
    a.failed_steps -= b.failed_steps;
    a.force_calls -= b.force_calls;
    a.jacobians -= b.jacobians;
    a.factorizations -= b.factorizations;
    a.analyses -= b.analyses;
    a.solves -= b.solves;
    a.iterations -= b.iterations;
    a.kick_calls -= b.kick_calls;
    a.halvings -= b.halvings;
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
    if (s.analyses != 0) out << "  pattern analyses " << s.analyses << '\n';
    if (s.kick_calls != 0) out << "  kick calls      " << s.kick_calls << '\n';
    if (s.halvings != 0) out << "  halvings        " << s.halvings << '\n';
    return out;
  }
};

}  // namespace phistep::inline PHISTEP_ABI
