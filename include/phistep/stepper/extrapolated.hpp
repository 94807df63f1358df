/// @file
/// Extrapolated linearly implicit Euler steps of variable order and length (P. Deuflhard, SIAM Rev. 27 (1985) 505; Hairer
/// & Wanner, Solving ODEs II, sect. IV.9). Row j is n_j substeps h = Δt/n_j with one Jacobian for the whole step,
///
///     (M − hJ) δ = h Ψ(t + (i+1)h, y_i),     y_{i+1} = y_i + δ                                                  (1)
///
/// its end T_{j,1} = y_n − y, extrapolated by extrapolation_table.hpp; column k has order k and is A(α)-stable with
/// α > 89.7°. For motion, (1) is n equations, not 2n (linear_stages.hpp). Which k and Δt: extrapolation_order.hpp.
///
/// In the stiff limit the expansion needs T_{2,1} and T_{2,2} to be contractive: where in rows 1 and 2 Newton's correction
/// to the first substep is no smaller than the substep, Δt is halved.
#pragma once

#include <array>
#include <cmath>
#include <type_traits>
#include <utility>

#include "phistep/control/trace.hpp"
#include "phistep/core/outcome.hpp"
#include "phistep/core/phi.hpp"
#include "phistep/core/version.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/unknowns.hpp"
#include "phistep/stepper/extrapolated_lanes.hpp"
#include "phistep/stepper/extrapolation.hpp"
#include "phistep/stepper/extrapolation_order.hpp"
#include "phistep/stepper/extrapolation_table.hpp"
#include "phistep/stepper/kernel.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Rows of (1), one after the other, by the kernel's linear stages.
template <State S, class Kernel>
class ImplicitEulerRows {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Data = typename Kernel::Data;

  ImplicitEulerRows(Kernel& kernel, Data& step, Plain& delta, RateOf<S>& start)
      : kernel_{kernel}, step_{step}, delta_{delta}, start_{start} {}

  /// ends[j] = T_{j,1} for from ≤ j ≤ to
  [[nodiscard]] Outcome run(auto& ends, const auto& substeps, int from, int to, double& theta) {
    for (int j = from; j <= to && theta <= 1; ++j) {
      const auto index = static_cast<std::size_t>(j);
      if (const Outcome outcome = row(ends[index], substeps[index], j, theta); outcome != Outcome::success)
        return outcome;
    }
    return Outcome::success;
  }

 private:
  [[nodiscard]] Outcome row(Plain& moved, int substeps, int j, double& theta) {
    const Scalar h = step_.dt / static_cast<Scalar>(substeps);
    if (const Outcome outcome = kernel_.factorise(h); outcome != Outcome::success) return outcome;
    for_each_block([](auto, auto& to) { to.setZero(); }, Blocks<S>::all(moved));
    bool known = !Kernel::has_time;
    if (known) copy_rate(step_.psi, start_);
    for (int i = 0; i < substeps; ++i) {
      for_each_block([](auto, auto& to, const auto& y, const auto& by) { to = y + by; }, Blocks<S>::all(step_.next),
                     Blocks<S>::all(step_.y), Blocks<S>::all(moved));
      if (!std::exchange(known, false))
        kernel_.evaluate(step_.t + static_cast<Scalar>(i + 1) * h, step_.next, step_.psi);
      right_hand_side(h);
      if (const Outcome outcome = kernel_.solve(h, delta_); outcome != Outcome::success) return outcome;
      for_each_block([](auto, auto& to, const auto& by) { to += by; }, Blocks<S>::all(moved),
                     Blocks<S>::all(std::as_const(delta_)));
      if (i == 0 && j <= 2 && step_.trace != nullptr) {
        if (const Outcome outcome = contraction(moved, h, theta); outcome != Outcome::success) return outcome;
        if (theta > 1) return Outcome::success;
        known = !Kernel::has_time;
      }
    }
    if (Kernel::Rhs::is_finite(moved)) return Outcome::success;
    return Outcome::non_finite_state;
  }
  void right_hand_side(Scalar h) {
    if constexpr (Blocks<S>::drifts) position_of<S>(delta_) = h * velocity_of<S>(std::as_const(step_.next));
    for_each_block([h](auto, auto& to, const auto& psi) { to = h * psi; }, Blocks<S>::solved(delta_),
                   RateOf<S>::blocks(std::as_const(step_.psi)));
  }
  /// What Newton's second correction would be, beside the first, δ.
  [[nodiscard]] Outcome contraction(const Plain& moved, Scalar h, double& theta) {
    for_each_block([](auto, auto& to, const auto& y, const auto& by) { to = y + by; }, Blocks<S>::all(step_.next),
                   Blocks<S>::all(step_.y), Blocks<S>::all(moved));
    kernel_.evaluate(step_.t + h, step_.next, step_.psi);
    const double first = weighted_rms(delta_, step_.trace->weight);
    if constexpr (Blocks<S>::drifts) position_of<S>(delta_).setZero();
    for_each_block([h](auto, auto& to, const auto& psi) { to = h * psi; }, Blocks<S>::solved(delta_),
                   RateOf<S>::blocks(std::as_const(step_.psi)));
    kernel_.add_mass_product(delta_, Scalar{-1}, moved);
    if (const Outcome outcome = kernel_.solve(h, delta_); outcome != Outcome::success) return outcome;
    const double rate = weighted_rms(delta_, step_.trace->weight) / std::max(1.0, first);
    if (!(rate <= theta)) theta = rate <= 1 ? rate : 2;
    return Outcome::success;
  }
  static void copy_rate(RateOf<S>& to, const RateOf<S>& from) {
    for_each_block([](auto, auto& a, const auto& b) { a = b; }, RateOf<S>::blocks(to), RateOf<S>::blocks(from));
  }

  Kernel& kernel_;
  Data& step_;
  Plain& delta_;
  RateOf<S>& start_;
};

/// Linearly implicit Euler as the base: φ = 1.
template <State S>
class Row<Extrapolated<SinglePhi<FixedPhi<1>>>, S> : public RowDefaults {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Scheme = Extrapolated<SinglePhi<FixedPhi<1>>>;
  static constexpr int columns = most_columns;
  using Order = ExtrapolationOrder<1, columns>;
  template <class Rhs>
  static constexpr KernelNeeds needs{.stages = true};

  Row(const Scheme& scheme, const Plain& y) : fixed_{scheme.columns} { resize(y); }
  void resize(const Plain& y) {
    if constexpr (!on_stack) table_.fill(y), delta_ = y, start_ = make_rate<S>(y);
  }
  [[nodiscard]] int order() const { return fixed_ > 0 ? fixed_ : past_.target > 0 ? past_.target : 2; }
  [[nodiscard]] int error_order() const { return order(); }

  /// As many columns as were asked for, or as the last step with error control took.
  template <class Kernel>
  [[nodiscard]] Outcome advance(Kernel& kernel, typename Kernel::Data& step) {
    return with_table([&](auto& table, Plain& delta, RateOf<S>& start) {
      if (const Outcome outcome = begin(kernel, step, start); outcome != Outcome::success) return outcome;
      const int k = fixed_ > 0 ? fixed_ : columns_ > 0 ? columns_ : usual_columns;
      double theta = 0;
      const Outcome outcome = rows(kernel, step, table, delta, start, 1, k, theta);
      if (outcome != Outcome::success) return outcome;
      for (int j = 2; j <= k; ++j) extend_table<S>(table, j, weights[at(j)]);
      return finish(kernel, step, table[at(k)]);
    });
  }

  static constexpr bool traces = true, chooses_step = true;
  [[nodiscard]] static bool estimates(const auto&) { return true; }

  template <class Kernel>
  [[nodiscard]] Outcome trace(Kernel& kernel, typename Kernel::Data& step) {
    return with_table([&](auto& table, Plain& delta, RateOf<S>& start) {
      const double h = std::abs(static_cast<double>(step.dt));
      auto& trace = *step.trace;
      if (const Outcome outcome = begin(kernel, step, start); outcome != Outcome::success) return outcome;
      order_.begin(past_, rows_of<Kernel>, h, trace.rtol);
      RowVerdict verdict = RowVerdict::more;
      double theta = 0;
      int done = 0;
      for (int last = order_.first_batch(); verdict == RowVerdict::more; last = done + 1) {
        const Outcome outcome = rows(kernel, step, table, delta, start, done + 1, last, theta);
        if (outcome != Outcome::success) {
          // Whatever it was, half the way it may not be met.
          order_.rejected(true);
          past_ = order_.past();
          trace.proposed = order_.proposed();
          return outcome;
        }
        if (theta > 1) {
          verdict = RowVerdict::diverged;
          break;
        }
        while (done < last) {
          ++done;
          if (done < 2) continue;
          extend_table<S>(table, done, weights[at(done)]);
          if (!order_.asks(done)) continue;
          verdict = order_.judge(done, error(step, table, done));
          if (verdict != RowVerdict::more) break;
        }
      }
      if (verdict != RowVerdict::accept) {
        order_.rejected(verdict == RowVerdict::diverged);
        past_ = order_.past();
        trace.proposed = order_.proposed();
        return Outcome::error_too_large;
      }
      order_.accepted();
      past_ = order_.past();
      trace.proposed = order_.proposed();
      trace.has_error = true;
      // Where row k+1 brought nothing, T_{k+1,k}: of the same order as T_{k,k}.
      columns_ = order_.column();
      return finish(kernel, step, table[at(columns_)]);
    });
  }

  using Progress = typename Order::Past;
  [[nodiscard]] const Progress& progress() const { return past_; }
  void resume(const Progress& progress) { past_ = progress; }
  void archive(auto& ar) { ar(past_, columns_); }

  void reset() {
    past_ = {};
    columns_ = 0;
  }

 private:
  static constexpr int size = static_size<decltype(Blocks<S>::all(std::declval<Plain&>()))>;
  static constexpr bool on_stack = size != Eigen::Dynamic && size <= 64;
  static constexpr std::size_t at(int j) { return static_cast<std::size_t>(j); }
  using Table = std::array<Plain, at(columns + 1)>;

  static constexpr auto numbers = bulirsch_numbers<columns>();
  static constexpr auto weights = neville_weights<Scalar, 1, columns>(numbers);
  /// Work in units of a substep: a force call and a solve. A factorisation is worth 2 to 10 of them (bench/small_dense).
  template <class Kernel>
  static constexpr typename Order::Rows rows_of = [] {
    constexpr int n = static_unknowns<S>;
    const double factorisation = n == Eigen::Dynamic ? 8 : n <= 2 ? 2 : n <= 8 ? 4 : 10;
    typename Order::Rows all;
    all.work[0] = 1;
    for (std::size_t j = 0; j <= columns; ++j) {
      all.substeps[j] = numbers[j];
      if (j > 0) all.work[j] = all.work[j - 1] + factorisation + numbers[j];
    }
    return all;
  }();

  struct Nothing {};
  [[nodiscard]] Outcome with_table(auto&& f) {
    if constexpr (on_stack) {
      Table table;
      Plain delta;
      RateOf<S> start;
      return f(table, delta, start);
    } else {
      return f(table_, delta_, start_);
    }
  }
  template <class Kernel>
  [[nodiscard]] static Outcome begin(Kernel& kernel, typename Kernel::Data& step, RateOf<S>& start) {
    const Outcome outcome = kernel.linearise(step);
    for_each_block([](auto, auto& a, const auto& b) { a = b; }, RateOf<S>::blocks(start),
                   RateOf<S>::blocks(std::as_const(step.psi)));
    return outcome;
  }
  template <class Kernel>
  [[nodiscard]] static Outcome rows(Kernel& kernel, typename Kernel::Data& step, Table& table, Plain& delta,
                                    RateOf<S>& start, int from, int to, double& theta) {
    if constexpr (runs_in_lanes<S, Kernel>)
      return ImplicitEulerLanes<S, Kernel>{kernel, step, start}.run(table, numbers, from, to, theta);
    else return ImplicitEulerRows<S, Kernel>{kernel, step, delta, start}.run(table, numbers, from, to, theta);
  }
  /// ‖T_{j,j} − T_{j,j−1}‖
  [[nodiscard]] static double error(auto& step, Table& table, int j) {
    auto& e = step.trace->error;
    for_each_block(
        [](auto, auto& to, auto& next, const auto& y, const auto& a, const auto& b) {
          to = a - b;
          next = y + a;
        },
        Blocks<S>::all(e), Blocks<S>::all(step.next), Blocks<S>::all(step.y), Blocks<S>::all(table[at(j)]),
        Blocks<S>::all(table[at(j - 1)]));
    return weighted_rms(e, step.y, step.next, *step.trace);
  }
  template <class Kernel>
  [[nodiscard]] static Outcome finish(Kernel&, typename Kernel::Data& step, const Plain& moved) {
    for_each_block([](auto, auto& to, const auto& y, const auto& by) { to = y + by; }, Blocks<S>::all(step.next),
                   Blocks<S>::all(step.y), Blocks<S>::all(moved));
    return Kernel::Rhs::is_finite(step.next) ? Outcome::success : Outcome::non_finite_state;
  }

  int fixed_;
  typename Order::Past past_;
  Order order_;
  int columns_ = 0;
  [[no_unique_address]] std::conditional_t<on_stack, Nothing, Table> table_;
  [[no_unique_address]] std::conditional_t<on_stack, Nothing, Plain> delta_;
  [[no_unique_address]] std::conditional_t<on_stack, Nothing, RateOf<S>> start_;
};

}  // namespace phistep::inline PHISTEP_ABI
