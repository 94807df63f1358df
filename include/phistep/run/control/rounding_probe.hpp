/// @file
/// Whether an error is rounding, which no step does better. A probe tells: the same step from a state that is a rounding away. By what
/// the two ends differ is noise of a component, below which no error shows (run/errors/automatic_atol.hpp). There is a
/// probe where errors rule Δt or a solve has stalled, after more and more steps while probes change nothing.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include "phistep/base/state/blocks.hpp"
#include "phistep/run/errors/error_norm.hpp"
#include "phistep/run/errors/tolerance.hpp"
#include "phistep/step/transaction/trace.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The probe of a run whose scales are the components' own.
template <State Plain>
class RoundingProbe {
 public:
  using Scalar = ScalarOf<Plain>;

  void begin() {
    course_ = {};
    has_end_ = false;
  }
  void resize(const Plain& y) { end_ = error_before_ = y; }
  /// @param damps  the scheme makes of no error more than it was   @param allowed  ‖e‖ that a step may have
  void obey(bool damps, double rtol, double allowed) { damps_ = damps, rtol_ = rtol, allowed_ = allowed; }

  /// Whether a step within the tolerance is given up for a probe.
  [[nodiscard]] bool is_due(bool is_ruled_by_error) {
    return course_.is_wanted = (is_ruled_by_error && course_.tries >= 4 * course_.wait) ||
                               (course_.has_stalled && 4 * course_.tries >= course_.wait);
  }
  /// A try has failed by its error, of that size. Whether a probe is due.
  [[nodiscard]] bool has_failed(double dt, double size) {
    const bool falls = !(course_.dt > 0) || dt > 0.7 * course_.dt || size * course_.dt <= 0.5 * course_.size * dt;
    course_.dt = dt, course_.size = size;
    ++course_.tries;
    // A million times what the state is has blown up: if a shorter try has less, that was no rounding.
    if (falls && rtol_ * size > 1e6) return false;
    return course_.is_wanted || course_.tries >= (falls ? course_.wait : std::min(course_.wait, soon));
  }
  /// A try has failed otherwise.
  void has_stalled() {
    course_.has_stalled = true;
    ++course_.tries;
  }
  void end_step() {
    ++course_.tries;
    course_.dt = 0;
  }
  /// The next try is a probe. @param iterates  steps are solved by iteration   @return its number
  [[nodiscard]] std::uint64_t start(bool iterates, const Measured& error, const Trace<Plain>& trace) {
    course_.iterates = iterates;
    before_ = error, proposed_ = trace.proposed;
    copy_blocks<Plain>(error_before_, trace.error);
    course_.is_probing = true;
    course_.has_learned = false;
    course_.is_hidden = trace.has_hidden;
    return ++course_.probes;
  }
  [[nodiscard]] bool is_probing() const { return course_.is_probing; }
  /// How far its start is moved, relative: some roundings, or about as far as errors may be.
  [[nodiscard]] Scalar moved_by() const {
    return asks_others() ? static_cast<Scalar>(rtol_ / 4) : std::numeric_limits<Scalar>::epsilon();
  }
  /// It has been tried, whatever came of it: error and trace are again those of the try before.
  void end(Measured& error, Trace<Plain>& trace) {
    course_.wait = course_.has_learned ? 2 : asks_others() ? course_.wait : std::min(2 * course_.wait, seldom);
    course_.is_probing = course_.is_wanted = course_.has_stalled = false;
    course_.tries = 0;
    error = before_, trace.proposed = proposed_;
  }
  /// Whether the last probe has found noise: the step may be tried again as it was. Asked once.
  [[nodiscard]] bool takes_back() { return std::exchange(course_.has_learned, false); }

  /// Keeps `next`, the end of a try that was no probe.
  void remember_end(const Plain& next) {
    copy_blocks<Plain>(end_, next);
    has_end_ = true;
  }
  /// The state isn't what the last try led to.
  void edited(AutomaticAtol<Plain>& atol, const Plain& y) const {
    if (has_end_) atol.edited(end_, y);
  }
  /// What the probe's end and error say. Less does no harm, and may be what an iteration has left. More is rounding, where the error
  /// isn't far more, of what an iteration has solved is far less, or isn't the same.
  [[gnu::noinline]] void learn(ErrorNorm<Plain>& norm, const Trace<Plain>& told, const Plain& y, const Plain& next) {
    if (told.has_hidden != course_.is_hidden) return;
    const Plain& error = told.error;
    auto& atol = norm.automatic();
    const double n = static_cast<double>(count_of(Blocks<Plain>::all(y)));
    // An iteration leaves 0.03 of what is allowed.
    const auto least = static_cast<Scalar>((course_.iterates ? 0.3 : 0.03) * allowed_ * std::sqrt(n)),
               rtol = static_cast<Scalar>(rtol_), many = static_cast<Scalar>(std::clamp(0.01 / rtol_, 1.0, 32.0));
    const auto is_only_error = [&](Index i, Scalar moved, Scalar before) {
      return many * moved > std::max(atol.most(i), std::abs(before));
    };
    // It alone must have failed: all others are within the tolerance, and go no further than they were moved.
    const auto others_are_right = [&] {
      double others = 0, rest = 0;
      for_each_number(
          [&](std::size_t at, Scalar e, Scalar from, Scalar now, Scalar before) {
            const auto i = static_cast<Index>(at);
            const Scalar moved = std::abs(now - before);
            if (is_only_error(i, moved, before)) return;
            const auto x = static_cast<double>(e / norm.scale(0, i, std::max(std::abs(from), std::abs(before))));
            others += moved <= 16 * rtol * atol.most(i) ? x * x : std::numeric_limits<double>::infinity();
            ++rest;
          },
          Blocks<Plain>::all(error_before_), Blocks<Plain>::all(y), Blocks<Plain>::all(next), Blocks<Plain>::all(end_));
      return rest > 0 && others <= allowed_ * allowed_ * n;
    };
    if (asks_others() && !others_are_right()) return;
    for_each_number(
        [&](std::size_t at, Scalar e, Scalar e_before, Scalar from, Scalar now, Scalar before) {
          const auto i = static_cast<Index>(at);
          const Scalar apart = std::abs(e - e_before), size = std::max(std::abs(from), std::abs(now));
          // An estimate's own rounding may be more than what is left of it in y⁺.
          const Scalar moved = std::max(std::abs(now - before), apart / 16);
          const bool is_noise = asks_others() ? is_only_error(i, moved, before)
                                              : (course_.iterates ? Scalar{8} : Scalar(1e-3L)) * std::abs(e) <= moved ||
                                                    4 * apart >= std::abs(e_before);
          if (!std::isfinite(moved) || !is_noise || moved <= least * norm.scale(0, i, size)) return;
          atol.learn_noise(i, asks_others() ? moved / 2 : static_cast<Scalar>(64 / allowed_) * moved);
          course_.has_learned = true;
        },
        Blocks<Plain>::all(error), Blocks<Plain>::all(error_before_), Blocks<Plain>::all(y), Blocks<Plain>::all(next),
        Blocks<Plain>::all(end_));
  }
  /// `rate` is y' where a solve has failed, `moved` the same after some roundings of y. What these make of y⁺ in a step of dt [time]
  /// is noise of a component that has hardly been more, nor is about to be.
  void learn_rates(AutomaticAtol<Plain>& atol, const Plain& rate, const Plain& moved, Scalar dt) const {
    for_each_number(
        [&](std::size_t at, Scalar a, Scalar b) {
          const auto i = static_cast<Index>(at);
          const Scalar made = 4 * std::abs(dt * (a - b)), size = std::max(atol.most(i), std::abs(dt * a));
          if (32 * made > size && std::isfinite(made)) atol.learn_noise(i, made / static_cast<Scalar>(allowed_));
        },
        Blocks<Plain>::all(rate), Blocks<Plain>::all(moved));
  }
  /// Whether failed solves teach (learn_rates).
  [[nodiscard]] bool knows_rates() const { return damps_; }

  void archive(auto& ar) {
    ar("stalled", course_.has_stalled, "tries", course_.tries, "wait", course_.wait, "probes", course_.probes,
       "has_end", has_end_);
    ar.check(course_.tries >= 0 && 2 <= course_.wait && course_.wait <= seldom);
    if (has_end_) ar.in_place("end", end_);
  }

 private:
  static constexpr int soon = 8, seldom = 1024;
  struct Course {
    bool is_probing = false, is_wanted = false, has_learned = false, has_stalled = false;
    bool is_hidden = false;      // in the error before were rates that fall
    bool iterates = false;       // steps are solved by iteration
    std::uint64_t probes = 0;    // that have been
    double dt = 0, size = 0;     // [time] of the last try of this step; its ‖e‖
    int tries = 0, wait = soon;  // since the last probe; until the next
  };
  /// True: the probe moves y by about what errors may be, to see what those of others make of one component. Each second probe
  /// does; none of iterations, nor of an explicit step that failed: an unstable one amplifies any change.
  [[nodiscard]] bool asks_others() const {
    return (damps_ || course_.is_wanted) && !course_.iterates && course_.probes % 2 == 0;
  }

  Course course_;
  bool damps_ = false, has_end_ = false;
  double rtol_ = 1, allowed_ = 1;
  Measured before_;           // the error of the try before a probe, and …
  double proposed_ = 0;       // [time] … what it proposed
  Plain end_, error_before_;  // of the last try, of that before a probe
};

}}  // namespace phistep::PHISTEP_ABI
