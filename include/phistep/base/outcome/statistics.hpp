/// @file
/// Counts of the work done, so that "skipped" is a number that a test can assert.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <string_view>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What reports are printed to. A concept, so that the core needs no stream header.
template <class Out>
concept TextStream = requires(Out& out) {
  out << "" << 0.0 << std::int64_t{};
};
/// Whether this may be a count: from there it can go on for as long as there is time.
[[nodiscard]] constexpr bool can_be_count(std::int64_t n) { return 0 <= n && n < std::int64_t{1} << 56; }

/// Whether the n-th use of a promise is checked: 1, 2, 3, 4, 6, 8, 12, 16 … 128, 192, 256 and each 128th from there. A
/// promise that is broken for a third of all uses, or for 128 of them, is found out, and the checks cost less than 1 % of a long run.
[[nodiscard]] constexpr bool is_looked_at(std::uint64_t n) {
  const std::uint64_t half = std::bit_floor(n) / 2;
  return n % (half < 1 ? 1 : half > 128 ? 128 : half) == 0;
}

/// What a stepper has done since it was made (or, in a RunReport, during one run).
struct Statistics {
  std::int64_t steps = 0;           ///< steps that succeeded
  std::int64_t failed_steps = 0;    ///< steps that failed and left the state as it was
  std::int64_t force_calls = 0;     ///< evaluations of Ψ, those for difference Jacobians included
  std::int64_t jacobians = 0;       ///< evaluations of ∂Ψ/∂y
  std::int64_t factorizations = 0;  ///< of the step's matrix M − γC − γ²K
  std::int64_t analyses = 0;        ///< symbolic analyses of a sparse pattern
  std::int64_t solves = 0;          ///< linear solves
  std::int64_t iterations = 0;      ///< Newton or fixed-point iterations
  /// Where each particle is solved by itself: Newton iterations summed over the particles. Every other count is then that
  /// of the particle that needed most, as in sweeps over those still at work.
  std::int64_t active_iterations = 0;
  std::int64_t linear_iterations = 0;  ///< iterations of an iterative linear solver
  std::int64_t fallbacks = 0;          ///< solves whose indefinite tangent was clamped or solved by LU instead
  std::int64_t kick_calls = 0;  ///< evaluations of terms that enter as kicks (at φ = 0, seldom), beside force_calls
  std::int64_t halvings = 0;    ///< steps replaced by two half steps
  std::int64_t checks = 0;      ///< evaluations of Ψ to check a supplied Jacobian or pattern, beside force_calls
  std::int64_t rejections = 0;  ///< steps that were solved but whose error was too large
  std::int64_t sleeping = 0;    ///< particle-steps not computed, because the particle slept

  friend constexpr Statistics operator-(Statistics a, const Statistics& b) {
    for_each([&](const char*, Count count, bool) { a.*count -= b.*count; });
    return a;
  }
  friend constexpr Statistics operator+(Statistics a, const Statistics& b) {
    for_each([&](const char*, Count count, bool) { a.*count += b.*count; });
    return a;
  }
  /// Each count the larger of two.
  [[nodiscard]] friend constexpr Statistics largest_of(Statistics a, const Statistics& b) {
    for_each([&](const char*, Count count, bool) { a.*count = std::max(a.*count, b.*count); });
    return a;
  }
  friend constexpr bool operator==(const Statistics&, const Statistics&) = default;

  void archive(auto& ar) {
    for_each([&](std::string_view name, Count count, bool) {
      ar.value(name.substr(0, name.find_last_not_of(' ') + 1), this->*count);
      ar.check(can_be_count(this->*count));
    });
  }

  /// One line a count, those that most scenes don't have only where they aren't zero.
  friend auto& operator<<(TextStream auto& out, const Statistics& s) {
    for_each([&](const char* name, Count count, bool is_special) {
      if (count == &Statistics::failed_steps || (is_special && s.*count == 0)) return;
      out << "  " << name << s.*count;
      if (count == &Statistics::steps && s.failed_steps != 0) out << "  (and " << s.failed_steps << " failed)";
      out << '\n';
    });
    return out;
  }

 private:
  using Count = std::int64_t Statistics::*;
  /// f(name padded to a column, which, whether most scenes don't have it)
  static constexpr void for_each(auto&& f) {
    f("steps               ", &Statistics::steps, false);
    f("failed steps        ", &Statistics::failed_steps, false);
    f("force calls         ", &Statistics::force_calls, false);
    f("Jacobians           ", &Statistics::jacobians, false);
    f("factorizations      ", &Statistics::factorizations, false);
    f("pattern analyses    ", &Statistics::analyses, true);
    f("linear solves       ", &Statistics::solves, false);
    f("iterations          ", &Statistics::iterations, false);
    f("particle iterations ", &Statistics::active_iterations, true);
    f("linear iterations   ", &Statistics::linear_iterations, true);
    f("fallbacks           ", &Statistics::fallbacks, true);
    f("kick calls          ", &Statistics::kick_calls, true);
    f("halvings            ", &Statistics::halvings, true);
    f("Jacobian checks     ", &Statistics::checks, true);
    f("rejected steps      ", &Statistics::rejections, true);
    f("sleeping            ", &Statistics::sleeping, true);
  }
};

}}  // namespace phistep::PHISTEP_ABI
