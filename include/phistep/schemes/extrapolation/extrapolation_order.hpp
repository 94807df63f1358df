/// @file
/// How many columns an extrapolated step takes and how long it is: arithmetic alone (P. Deuflhard, Numer. Math. 41 (1983)
/// 399; Hairer, Nørsett & Wanner, Solving ODEs I, sect. II.9, eqs. 9.22-9.30; Hairer & Wanner, Solving ODEs II, sect. IV.9).
///
/// With ‖e_j‖ the difference of the last two entries of row j, A_j the work of rows 1 … j,
///
///     H_j = Δt 0.93 (0.6/‖e_j‖)^{1/(p(j−1)+1)},     W_j = A_j/H_j                                               (1)
///
/// (p = 1, or 2 where the error has even powers of Δt alone) are the step that column j would allow, and its work per unit of time. A step aims at the column k of least work and
/// ends in one of k−1, k, k+1. What the books' rule can't see is a column that it never computes: where ‖e_3‖ ≈ ‖e_2‖, as
/// in very stiff phases, W_3 > W_2 keeps k = 3 for good, though W_5 be a tenth of it. So a run that has stayed in one
/// column for a while looks one further, the less often the less it found.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "phistep/core/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What is to be done about a row.
enum class RowVerdict { more, accept, reject, diverged };

/// @tparam power    e_j goes as Δt^{power·j}: 1, or 2 where the expansion is even
/// @tparam columns  most of them
template <int power, int columns>
class ExtrapolationOrder {
 public:
  /// Of each row: substeps n_j and the work A_j of all up to it; index 0 is unused.
  struct Rows {
    std::array<int, columns + 1> substeps{};
    std::array<double, columns + 1> work{};
  };
  /// Carried from step to step.
  struct Past {
    int target = 0;    ///< k, 0 before the first step
    int last = 0;      ///< the column aimed at by the step before
    int steady = 0;    ///< steps that have stayed in it
    int patience = 4;  ///< as many make it worth a look at the next one
    bool rejected = false;
    bool limited = false;  ///< the length was not the error's to say: a lower column would shorten it further
    int unlimited = 0;     ///< steps that don't look at their inside
    double inside = 0;     ///< error inside the last step that did
    double inside_h = 0;   ///< [time] its |Δt|
    double wanted = 0;     ///< [time] |Δt| proposed
    double below = 0;      ///< log₂ of ‖e_{k−1}‖ and
    double below_h = 0;    ///< [time] the |Δt| that had it, 0: unknown
    int below_column = 0;

    void archive(auto& ar) {
      ar("target", target, "last", last, "steady", steady, "patience", patience, "rejected", rejected, "limited",
         limited, "unlimited", unlimited, "inside", inside, "inside_h", inside_h, "wanted", wanted, "below", below,
         "below_h", below_h, "below_column", below_column);
      for (const int column : {target, last, below_column}) ar.check(0 <= column && column <= columns);
      ar.check(0 <= steady && steady < 1 << 30 && 1 <= patience && patience <= 64 && 0 <= unlimited && unlimited <= 16);
    }
  };

  /// A step of length h > 0. @param rtol  tells where to begin  @param fixed  0, or the only column there is
  ExtrapolationOrder(const Rows& rows, const Past& past, double h, double rtol, int fixed)
      : rows_{rows}, past_{past}, fixed_{fixed} {
    h_ = h;
    first_ = past_.target == 0;
    if (first_) {
      // ⌊0.6 digits + 1.5⌋ for h, half as many columns for h².
      const double digits = std::min(-std::log10(rtol), 20.0);
      past_.target = std::clamp(static_cast<int>(0.6 / power * digits + 1.5), 2, columns - 2);
    }
    // A step cut short by a time to stop at is done as soon as its error allows.
    eager_ = first_ || h < 0.7 * past_.wanted;
    probes_ =
        !eager_ && !past_.rejected && !past_.limited && past_.steady >= past_.patience && past_.target + 1 < columns;
    known_ = 0;
  }
  /// The rows to compute before anything is asked.
  [[nodiscard]] int first_batch() {
    if (fixed_ > 0) return batch_ = fixed_;
    const int k = past_.target;
    if (eager_ || k <= 2) return batch_ = 2;
    if (past_.rejected || past_.limited || probes_) return batch_ = k;
    // Where row k−1 is not expected to be enough, row k may be computed beside it.
    const bool falls_short = past_.below_h > 0 && past_.below_column == k - 1 &&
                             past_.below + exponent(past_.below_column) * std::log2(h_ / past_.below_h) > 0;
    return batch_ = falls_short ? k : k - 1;
  }
  /// Whether ‖e_j‖ is needed.
  [[nodiscard]] bool asks(int j) const {
    if (fixed_ > 0) return j == fixed_;
    return j >= 2 && (eager_ || j >= past_.target - 2);
  }

  /// ‖e_j‖, after which the step goes on with row j+1, or ends.
  [[nodiscard]] RowVerdict judge(int j, double error) {
    const int k = past_.target;
    error_[at(j)] = error;
    length_[at(j)] = 0;
    if (known_ == 0) known_ = j;
    // Also where it's NaN.
    if (!(error < 1e15) || (j > 2 && known_ < j && error >= std::max(4 * error_[at(j - 1)], 1.0)))
      return RowVerdict::diverged;
    column_ = j;
    const bool enough = error <= 1;
    if (fixed_ > 0) return enough ? RowVerdict::accept : RowVerdict::reject;
    if (eager_) {
      if (enough) return RowVerdict::accept;
      return j >= std::min(k + 1, columns) ? RowVerdict::reject : RowVerdict::more;
    }
    if (j < k - 1) return RowVerdict::more;
    const auto n = [this](int i) { return static_cast<double>(rows_.substeps[at(std::min(i, columns))]); };
    const double n1 = n(1);
    if (j == k - 1) {
      if (k == 2 || past_.rejected || batch_ >= k) return RowVerdict::more;
      if (enough) return RowVerdict::accept;
      // Beyond hope for row k+1; the stiff expansion's constants deserve a larger allowance.
      const double hope = power == 1 ? 4 * n(k + 1) * n(k) : std::pow(n(k + 1) * n(k) / (n1 * n1), 2);
      return error > hope ? RowVerdict::reject : RowVerdict::more;
    }
    if (j == k) {
      if (enough && !probes_) return RowVerdict::accept;
      const double hope = power == 1 ? 2 * n(k + 1) : std::pow(n(k + 1) / n1, 2);
      return error > hope || k + 1 > columns ? RowVerdict::reject : RowVerdict::more;
    }
    if (enough) return RowVerdict::accept;
    if (probes_ && error_[at(k)] <= 1) {
      column_ = k;  // the look one further brought nothing: row k stands
      return RowVerdict::accept;
    }
    return RowVerdict::reject;
  }
  /// The column whose T_jj is the result.
  [[nodiscard]] int column() const { return column_; }

  /// After RowVerdict::accept: what the next step takes, |Δt| ≤ most.
  [[nodiscard]] const Past& accepted(double most) {
    most_ = most;
    if (fixed_ > 0) {
      const double h = past_.rejected ? std::min(h_, length(fixed_)) : length(fixed_);
      past_.rejected = false;
      return remember(fixed_, h);
    }
    const int c = column_, k = past_.target;
    int next = 0;
    const bool probed = probes_ && known_ <= k && has(k + 1);
    if (c == 2) {
      next = past_.rejected ? 2 : std::min(3, columns - 1);
    } else if (probed) {
      next = has(k - 1) && work(k - 1) < 0.7 * work(k) ? k - 1 : k;
      const bool found = work(k + 1) < 0.9 * work(next);
      if (found) next = std::min(k + 1, columns - 1);
      past_.patience = found ? 4 : std::min(2 * past_.patience, 64);
      past_.steady = 0;
    } else if (c <= k) {
      next = c;
      if (has(c - 1) && work(c - 1) < 0.7 * work(c)) next = c - 1;
      if (has(c - 1) && work(c) < 0.9 * work(c - 1)) next = std::min(c + 1, columns - 1);
    } else {
      next = c - 1;
      if (c > 3 && has(c - 2) && work(c - 2) < 0.7 * work(c - 1)) next = c - 2;
      if (work(c) < 0.9 * work(next)) next = std::min(c, columns - 1);
    }
    if (next == past_.last && !past_.rejected) ++past_.steady;
    else past_.steady = 0;
    past_.last = next;
    double h = 0;
    if (past_.rejected) {
      next = std::min(next, c);
      h = std::min(h_, length(c));
    } else if (has(next)) {
      h = length(next);
    } else {
      const bool rising = c < k && has(c - 1) && work(c) < 0.9 * work(c - 1);
      h = length(c) * rows_.work[at(rising ? std::min(next + 1, columns) : next)] / rows_.work[at(c)];
    }
    past_.rejected = false;
    past_.limited = h > most_;
    return remember(past_.limited ? std::max(next, k) : next, h);
  }
  /// |Δt| that what lies inside the step allows, its error being `error` and going as Δt^degree. Where stiff components
  /// spoil the table's derivatives, shorter steps don't help: then none are asked for, for a while.
  [[nodiscard]] double limit(double error, int degree) {
    const bool in_vain = past_.inside_h > 0 && h_ < 0.9 * past_.inside_h && error > 0.5 * past_.inside;
    if (in_vain && error > 1) past_.unlimited = 16;
    past_.inside = error;
    past_.inside_h = 0;
    if (past_.unlimited > 0) {
      --past_.unlimited;
      return std::numeric_limits<double>::infinity();
    }
    return h_ * std::pow(std::max(error, 1e-10), -1.0 / degree);
  }
  /// After RowVerdict::accept of a step that was too long for another reason.
  [[nodiscard]] const Past& shortened(double h) {
    past_.limited = true;
    past_.inside_h = h_;
    return remember(std::max(past_.target, column_), std::min(h, 0.9 * h_));
  }
  /// After RowVerdict::reject and diverged. @param halved  nothing can be said of the errors
  [[nodiscard]] const Past& rejected(bool halved) {
    past_.rejected = true;
    past_.steady = 0;
    past_.patience = 4;
    if (halved) return remember(past_.target, h_ / 2);
    if (fixed_ > 0) return remember(fixed_, std::min(length(fixed_), 0.9 * h_));
    int k = std::min({past_.target, column_, columns - 1});
    if (k > 2 && has(k - 1) && work(k - 1) < 0.7 * work(k)) --k;
    return remember(k, std::min(length(has(k) ? k : column_), 0.9 * h_));
  }

 private:
  static constexpr std::size_t at(int j) { return static_cast<std::size_t>(j); }
  /// e_j, the error of T_{j,j−1}, goes as Δt to this power.
  static constexpr int exponent(int j) { return power * (j - 1) + 1; }
  [[nodiscard]] bool has(int j) const { return known_ > 0 && j >= known_ && j <= last_known(); }
  [[nodiscard]] int last_known() const { return std::max(column_, probes_ ? std::min(past_.target + 1, columns) : 0); }

  /// H_j of (1), within 10^{1/j} of h and a quarter of its reciprocal (Hairer & Wanner's program)
  [[nodiscard]] double length(int j) {
    double& length = length_[at(j)];
    if (length == 0) {
      const double least = shares[at(exponent(j))];
      const double by = std::exp2(std::log2(std::max(error_[at(j)], 1e-30) / safety) / exponent(j)) / 0.93;
      length = h_ / std::min(4 / least, std::max(least, by));
    }
    return length;
  }
  [[nodiscard]] double work(int j) { return rows_.work[at(j)] / length(j); }
  const Past& remember(int target, double h) {
    past_.target = target;
    past_.wanted = std::min(h, most_);
    past_.below_h = 0;
    if (target > 2 && has(target - 1)) {
      past_.below = std::log2(std::max(error_[at(target - 1)], 1e-30));
      past_.below_h = h_;
      past_.below_column = target - 1;
    }
    return past_;
  }
  static constexpr double safety = 0.6;
  /// 0.1^{1/j}
  static constexpr double shares[] = {0,        0.1,      0.316228, 0.464159, 0.562341, 0.630957, 0.681292,
                                      0.719686, 0.749894, 0.774264, 0.794328, 0.811131, 0.825404, 0.837678,
                                      0.848343, 0.857696, 0.865964, 0.873326, 0.879923, 0.885867, 0.891251,
                                      0.896151, 0.900628, 0.904736, 0.908518};
  static_assert(power * columns < static_cast<int>(std::size(shares)));

  const Rows& rows_;
  Past past_;
  int fixed_;
  double h_ = 0, most_ = std::numeric_limits<double>::infinity();
  bool first_ = true, eager_ = true, probes_ = false;
  int column_ = 0, known_ = 0, batch_ = 0;
  std::array<double, columns + 2> error_{}, length_{};
};

}}  // namespace phistep::PHISTEP_ABI
