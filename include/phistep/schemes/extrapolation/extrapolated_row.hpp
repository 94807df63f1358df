/// @file
/// A step by extrapolation, whatever its base: rows of the table until the error is small enough, and what the next step
/// takes (P. Deuflhard, SIAM Rev. 27 (1985) 505). A base method offers
///
///     static constexpr int power;                     its error goes as h^power, h^{2 power}, …
///     numbers<columns>                                n_j
///     row_work                                        what a row costs beside its substeps, in substeps
///     resize(y), begin(kernel, step)                  before the first row
///     rows(kernel, step, ends, numbers, from, to, θ, inside)  ends[j] = T_{j,1}; θ > 1: given up. The last increments
///                                                     of each row go into `inside`, unless that is null
///     static constexpr bool interpolates;             … and tell of the solution between the ends
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "phistep/control/trace.hpp"
#include "phistep/core/outcome.hpp"
#include "phistep/core/version.hpp"
#include "phistep/schemes/extrapolation/extrapolated_inside.hpp"
#include "phistep/schemes/extrapolation/extrapolated_lanes.hpp"
#include "phistep/schemes/extrapolation/extrapolation.hpp"
#include "phistep/schemes/extrapolation/extrapolation_order.hpp"
#include "phistep/schemes/extrapolation/extrapolation_table.hpp"
#include "phistep/schemes/scheme_on.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <State S, class Base>
class ExtrapolatedRow : public SchemeDefaults {
  static_assert(!FieldState<S>, "phistep: extrapolation takes no fields: take tsit5, dop853 or rodas5p");

 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  static constexpr int columns = most_columns, power = Base::power;
  using Order = ExtrapolationOrder<power, columns>;
  template <class Rhs>
  static constexpr KernelNeeds needs{.stages = Base::template needs_stages<Rhs>};

  template <class Scheme>
  ExtrapolatedRow(const Scheme& scheme, const Plain& y) : fixed_{scheme.columns} {
    resize(y);
  }
  void resize(const Plain& y) {
    if constexpr (!on_stack) {
      table_.fill(y);
      base_.resize(y);
    }
  }
  [[nodiscard]] int order() const { return power * (fixed_ > 0 ? fixed_ : past_.target > 0 ? past_.target : 2); }
  [[nodiscard]] int error_order() const { return order(); }

  template <class Step>
  [[nodiscard]] Outcome step(auto& kernel, Step& step) {
    if constexpr (Step::is_traced) return controlled(kernel, step);
    else return fixed(kernel, step);
  }
  /// As many columns as were asked for, or as the last step with error control took.
  template <class Kernel>
  [[nodiscard]] Outcome fixed(Kernel& kernel, typename Kernel::Data& step) {
    copy_blocks<S>(step.next, step.y);  // kept for the failure message
    RowData<Kernel> data{step, nullptr};
    return with_workspace([&](Table& table, Base& base) {
      if (const Outcome bad = base.begin(kernel, data); failed(bad)) return bad;
      const int k = fixed_ > 0 ? fixed_ : columns_ > 0 ? columns_ : usual_columns;
      double theta = 0;
      if (const Outcome outcome = base.rows(kernel, data, table, numbers, 1, k, theta, no_inside);
          outcome != Outcome::success)
        return outcome;
      for (int j = 2; j <= k; ++j) extend_table<S>(table, j, weights[at(j)]);
      return finish<Kernel>(step, table[at(k)]);
    });
  }

  static constexpr bool traces = true, reads_weights = true;
  /// One column alone has nothing to be compared with.
  [[nodiscard]] bool estimates(const auto&) const { return fixed_ != 1; }

  template <class Kernel>
  [[nodiscard]] Outcome controlled(Kernel& kernel, typename Kernel::TracedData& step) {
    copy_blocks<S>(step.next, step.y);  // kept for the failure message
    RowData<Kernel> data{step, &step.trace};
    return with_workspace([&](Table& table, Base& base) {
      if (const Outcome bad = base.begin(kernel, data); failed(bad)) return bad;
      Inside* inside = nullptr;
      if constexpr (Base::interpolates) {
        inside_.forget();
        if (step.trace.wants_dense) {
          inside_.begin(step.y);
          inside = &inside_;
        }
      }
      Order order{rows, past_, std::abs(static_cast<double>(step.dt)), step.trace.rtol, fixed_};
      RowVerdict verdict = RowVerdict::more;
      double theta = 0;
      int done = 0;
      for (int last = order.first_batch(); verdict == RowVerdict::more; last = done + 1) {
        const Outcome outcome = base.rows(kernel, data, table, numbers, done + 1, last, theta, inside);
        if (outcome != Outcome::success || theta > 1) {
          give_up(step, order, true);
          return outcome == Outcome::success ? Outcome::error_too_large : outcome;
        }
        while (done < last && verdict == RowVerdict::more) {
          if (++done < 2) continue;
          extend_table<S>(table, done, weights[at(done)]);
          if (order.asks(done)) verdict = order.judge(done, error(step, table, done));
        }
      }
      if (verdict != RowVerdict::accept) {
        give_up(step, order, verdict == RowVerdict::diverged);
        return Outcome::error_too_large;
      }
      // Where row k+1 brought nothing, T_{k+1,k}, of the same order as T_{k,k}.
      const Outcome outcome = finish<Kernel>(step, table[at(order.column())]);
      if (outcome != Outcome::success) {
        give_up(step, order, true);
        return outcome;
      }
      double most = std::numeric_limits<double>::infinity();
      if constexpr (Base::interpolates)
        if (inside != nullptr) {
          inside->end(order.column(), numbers, weights);
          // Differences of the table leave some million roundings: where the tolerance is of that size, no step would be
          // short enough, and the inside is as good as it comes.
          constexpr double least = 2e7 * static_cast<double>(std::numeric_limits<Scalar>::epsilon());
          if (step.trace.rtol > least) most = order.limit(inside_error(step), inside->degree());
          if (most < 0.8 * std::abs(static_cast<double>(step.dt))) {
            past_ = order.shortened(most);
            step.trace.proposed = past_.wanted;
            return Outcome::error_too_large;
          }
        }
      past_ = order.accepted(most);
      columns_ = order.column();
      step.trace.proposed = past_.wanted;
      step.trace.has_error = true;
      return Outcome::success;
    });
  }

  static constexpr bool interpolates = Base::interpolates;
  void interpolate(Scalar x, Scalar, const Plain& y0, const Plain& y1, Plain& out) const requires interpolates {
    inside_.interpolate(x, y0, y1, out);
  }

  using Progress = typename Order::Past;
  [[nodiscard]] const Progress& progress() const { return past_; }
  void resume(const Progress& progress) { past_ = progress; }
  void archive(auto& ar) {
    ar("order", past_, "columns", columns_);
    ar.check(0 <= columns_ && columns_ <= columns);
  }
  void reset() {
    past_ = {};
    columns_ = 0;
  }

 private:
  static constexpr int size = static_size<decltype(Blocks<S>::all(std::declval<Plain&>()))>;
  static constexpr bool on_stack = size != Eigen::Dynamic && size <= 64;
  static constexpr std::size_t at(int j) { return static_cast<std::size_t>(j); }
  using Table = std::array<Plain, at(columns + 1)>;

  static constexpr auto numbers = Base::template numbers<columns>;
  static constexpr auto weights = neville_weights<Scalar, power, columns>(numbers);
  static constexpr typename Order::Rows rows = [] {
    typename Order::Rows all;
    all.work[0] = 1;
    for (std::size_t j = 1; j <= columns; ++j) {
      all.substeps[j] = numbers[j];
      all.work[j] = all.work[j - 1] + Base::row_work + numbers[j];
    }
    return all;
  }();

  struct Nothing {};
  using Inside = std::conditional_t<Base::interpolates, ExtrapolatedInside<S, columns>, Nothing>;
  static constexpr Inside* no_inside = nullptr;
  /// f(table, base): a small state's lie in registers and on the stack.
  [[nodiscard]] Outcome with_workspace(auto&& f) {
    if constexpr (on_stack) {
      Table table;
      Base base;
      return f(table, base);
    } else {
      return f(table_, base_);
    }
  }
  void give_up(auto& step, Order& order, bool halve) {
    past_ = order.rejected(halve);
    step.trace.proposed = past_.wanted;
  }
  /// Error inside the step, in units of ten tolerances: with dense output it must not exceed 1. (Hairer & Wanner's
  /// program ODEX, too, shortens steps for its dense output.)
  [[nodiscard]] double inside_error(auto& step) const {
    Plain& e = step.trace.predicted;
    inside_.error(step.y, step.next, e);
    return step.trace.size_of(e, step.y, step.next) / 10;
  }
  /// ‖T_{j,j} − T_{j,j−1}‖
  [[nodiscard]] static double error(auto& step, Table& table, int j) {
    for_each_block(
        [](auto, auto& e, auto& next, const auto& y, const auto& a, const auto& b) {
          e = a - b;
          next = y + a;
        },
        Blocks<S>::all(step.trace.error), Blocks<S>::all(step.next), Blocks<S>::all(step.y),
        Blocks<S>::all(table[at(j)]), Blocks<S>::all(table[at(j - 1)]));
    return step.trace.size_of(step.trace.error, step.y, step.next);
  }
  template <class Kernel>
  [[nodiscard]] static Outcome finish(typename Kernel::Data& step, const Plain& moved) {
    for_each_block([](auto, auto& to, const auto& y, const auto& by) { to = y + by; }, Blocks<S>::all(step.next),
                   Blocks<S>::all(step.y), Blocks<S>::all(moved));
    return Kernel::Rhs::is_finite(step.next) ? Outcome::success : Outcome::non_finite_state;
  }

  int fixed_;
  typename Order::Past past_;
  int columns_ = 0;
  [[no_unique_address]] Inside inside_;
  [[no_unique_address]] std::conditional_t<on_stack, Nothing, Table> table_;
  [[no_unique_address]] std::conditional_t<on_stack, Nothing, Base> base_;
};

}}  // namespace phistep::PHISTEP_ABI
