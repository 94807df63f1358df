/// @file
/// Whether a matrix W = M − γJ that nothing iterates on has the force's own J. A Jacobian that the user supplied, or a
/// pattern that was declared, is a promise, and an error in it shows in no residual: a Rosenbrock step made with it is a
/// wrong one that says success. So the force is asked. For a random b,
///
///     W x = b   gives   γ J x = M x − b,   to be compared with   γ [Ψ(t, y + εx) − Ψ(t, y)]/ε                   (1)
///
/// in one force call, whatever solves with W; an iterative solver that can multiply with W takes the x of its preconditioner, and
/// b = W x. Where they disagree, in a second one on the other side, since Ψ may bend or
/// have a kink there, and in a third that tells how much of it is rounding. For motion x = (γ_d x_v, x_v), γ is γ_f, and Jx is Cx_v + γ_d Kx_v.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "phistep/base/facts/implicit_solver.hpp"
#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/step/equation/right_hand_side.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Checks some of the matrices (`is_looked_at`), and each whose pattern is new.
template <State S, class Rhs>
class TangentCheck {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;

  void resize(const Plain& y) {
    size_ = direction_ = probe_ = y;
    rate_ = make_rate<S>(y);
    tangent_.setZero(unknowns<S>(y));
    measured_ = tangent_;
    begin();
  }
  /// Begins anew for another force, or another pattern.
  void begin() { seen_ = 0, due_ = false; }
  /// Counts another Jacobian.
  void count() { due_ = due_ || is_looked_at(++seen_); }
  void want() { due_ = true; }
  [[nodiscard]] bool is_due() const { return due_; }

  /// (1) at (t, y), where Ψ is psi, with the factors at hand. Counted as `checks`, and as nothing else.
  [[nodiscard]] Outcome look(Rhs& rhs, auto& matrix, const NewtonOptions& options, const Gamma<Scalar>& gamma, Scalar t,
                             const Plain& y, const Rate& psi) {
    due_ = !choose_sizes(rhs, gamma, y, psi);
    if (due_) return Outcome::success;  // nothing can be checked until something moves
    Statistics uncounted;
    Unknown& b = measured_;  // before anything is measured
    tangent_ = b;
    double rest = 0;
    if constexpr (requires { matrix.approximate(tangent_, b); }) {
      matrix.approximate(tangent_, b);
    } else {
      if (const Outcome bad = matrix.solve(tangent_, options, uncounted); failed(bad)) return bad;
      rest = options.linear_rtol * std::sqrt(static_cast<double>(b.size())) * largest(b);
    }
    const double size_of_b = largest(b);
    put_unknowns<S>(tangent_, direction_);  // the direction that was solved for
    if constexpr (Rhs::drifts) position_of<S>(direction_) = gamma.drift * velocity_of<S>(direction_);
    multiply(rhs, direction_, tangent_);
    const double cancelled = largest(tangent_) + size_of_b;
    tangent_ -= b;
    leave_out_held(rhs, tangent_);
    const Scalar step = step_length();
    if (!(step > 0)) return Outcome::success;  // nothing moves: nothing can be checked
    const Rounding rounding{16 * unit * cancelled + rest,
                            16 * unit * std::abs(static_cast<double>(gamma.force / step))};
    const bool right = measure(rhs, gamma.force, t, y, psi, step);
    if (right && agrees(measured_, 0, psi, rounding, measured_)) return Outcome::success;
    const auto first = measured_;
    const bool left = measure(rhs, gamma.force, t, y, psi, -step);
    if (!left && !right) return Outcome::success;  // Ψ isn't defined on either side
    if (!left) measured_ = first;
    else if (right) measured_ = (first + measured_) / 2;
    const double bend = left && right ? 1.0 : 0.0;
    if (agrees(measured_, bend, psi, rounding, first)) return Outcome::success;
    // A stiff force may be a small rest of large terms: what it makes of a rounding of y tells how well it can be known.
    const double noise = noise_of(rhs, t, y, psi);
    const Rounding blurred{rounding.product + 16 * noise * std::abs(static_cast<double>(gamma.force / step)),
                           rounding.difference};
    if (!(noise >= 0) || agrees(measured_, bend, psi, blurred, first)) return Outcome::success;
    return Rhs::Traits::is_affine ? Outcome::not_affine : Outcome::wrong_jacobian;
  }

 private:
  static constexpr double unit = static_cast<double>(std::numeric_limits<Scalar>::epsilon());
  using Unknown = Eigen::Matrix<Scalar, static_unknowns<S>, 1>;
  /// What rounding leaves of W's product, and of a difference of Ψ, by Ψ's size.
  struct Rounding {
    double product, difference;
  };

  /// A usual size for each component, what it is or how far a step moves it, and b = M s with these and random signs: in measured_.
  /// False where nothing moves.
  [[nodiscard]] bool choose_sizes(const Rhs& rhs, const Gamma<Scalar>& gamma, const Plain& y, const Rate& psi) {
    for_each_block(
        [&](auto, auto& size, const auto& now, const auto& rate, const auto& mass) {
          const auto factor = mass.h_over_mass(gamma.force);
          for (Index i = 0; i < size.size(); ++i)
            size.data()[i] = std::max(std::abs(now.data()[i]), std::abs(factor(i) * rate.data()[i]));
          // One that is zero and stays there moves by a little of what the others are.
          const Scalar little = static_cast<Scalar>(largest(size)) / 1024 / 1024;
          for (Index i = 0; i < size.size(); ++i)
            if (size.data()[i] == 0) size.data()[i] = little;
        },
        Blocks<S>::solved(size_), Blocks<S>::solved(y), Rate::blocks(psi), rhs.masses());
    if constexpr (Rhs::drifts) {
      auto& r = position_of<S>(size_);
      auto& v = velocity_of<S>(size_);
      const auto fastest = static_cast<Scalar>(largest(v)), farthest = static_cast<Scalar>(largest(position_of<S>(y)));
      // All rest in balance, but for rounding.
      if (std::abs(gamma.drift) * fastest <= 64 * std::numeric_limits<Scalar>::epsilon() * farthest) return false;
      for (Index i = 0; i < r.size(); ++i) {
        v.data()[i] = std::max(v.data()[i], fastest / 1024);  // one that rests beside others
        r.data()[i] = std::max(std::abs(position_of<S>(y).data()[i]), std::abs(gamma.drift) * v.data()[i]);
      }
    }
    Xorshift random{0x9e3779b97f4a7c15u * (seen_ + 1)};
    for_each_number([&random](auto, Scalar& to, Scalar size) { to = random.sign(size); }, Blocks<S>::solved(direction_),
                    Blocks<S>::solved(size_));
    multiply(rhs, direction_, measured_);
    return true;
  }
  /// out = M x
  void multiply(const Rhs& rhs, const Plain& x, Unknown& out) {
    for_each_block(
        [](auto, auto& to, const auto& of, const auto& mass) {
          to.setZero();
          mass.add_product([&](Index i) { return of.data()[i]; }, to);
        },
        Blocks<S>::solved(probe_), Blocks<S>::solved(x), rhs.masses());
    take_unknowns<S>(out, probe_);
  }
  /// Zeros for what is held still: no force moves it, and in W its mass is not the one in M x.
  void leave_out_held(const Rhs& rhs, Unknown& x) const {
    for_each_part(
        [&](Index at, const auto& block, const auto& mass) {
          const auto factor = mass.h_over_mass(Scalar{1});
          for (Index i = 0; i < block.size(); ++i)
            if (factor(i) == 0) x[at + i] = 0;
        },
        Blocks<S>::solved(direction_), rhs.masses());
  }
  /// ε: the component that moves farthest, for its size, moves by the cube root of a rounding.
  [[nodiscard]] Scalar step_length() const {
    Scalar most{0};
    for_each_number(
        [&most](auto, Scalar x, Scalar size) {
          if (size > 0) most = std::max(most, std::abs(x) / size);
        },
        Blocks<S>::all(direction_), Blocks<S>::all(size_));
    return most > 0 && std::isfinite(most) ? std::cbrt(std::numeric_limits<Scalar>::epsilon()) / most : Scalar{0};
  }
  /// The largest change of Ψ where every component of y is a rounding or two off.
  [[nodiscard]] double noise_of(Rhs& rhs, Scalar t, const Plain& y, const Rate& psi) {
    Xorshift random{0x2545f4914f6cdd1du * (seen_ + 1)};
    const Scalar u = std::numeric_limits<Scalar>::epsilon();
    for_each_number([&random, u](auto, Scalar& to, Scalar from) { to = from * (1 + random.sign(u)); },
                    Blocks<S>::all(probe_), Blocks<S>::all(y));
    ask(rhs, t);
    double most = 0;
    for_each_number(
        [&most](auto, Scalar there, Scalar here) {
          const double change = std::abs(static_cast<double>(there - here));
          most = std::isnan(change) ? change : std::max(most, change);
        },
        Rate::blocks(rate_), Rate::blocks(psi));
    return most;
  }
  /// rate = Ψ at the probe, counted as a check.
  void ask(Rhs& rhs, Scalar t) {
    rhs.evaluate_into(t, probe_, rate_);
    --rhs.statistics().force_calls;
    ++rhs.statistics().checks;
  }
  /// measured = γ [Ψ(t, y + εx) − Ψ(t, y)]/ε. False where Ψ isn't finite there.
  [[nodiscard]] bool measure(Rhs& rhs, Scalar gamma, Scalar t, const Plain& y, const Rate& psi, Scalar step) {
    assign<S>(probe_, in<S>(y) + step * in<S>(direction_));
    ask(rhs, t);
    auto* to = measured_.data();
    for_each_number([to, by = gamma / step](auto i, Scalar there, Scalar here) { to[i] = by * (there - here); },
                    Rate::blocks(rate_), Rate::blocks(psi));
    leave_out_held(rhs, measured_);
    return all_finite(measured_.data(), measured_.size());
  }
  /// Block by block, to a thousandth of the largest component, and to what rounding and a bend of Ψ leave.
  [[nodiscard]] bool agrees(const Unknown& found, double bend, const Rate& psi, const Rounding& rounding,
                            const Unknown& one_side) const {
    bool good = true;
    for_each_part(
        [&](Index at, const auto& rate) {
          double off = 0, size = 0, curve = 0;
          for (Index i = at; i < at + rate.size(); ++i) {
            off = std::max(off, std::abs(static_cast<double>(found[i] - tangent_[i])));
            size =
                std::max({size, std::abs(static_cast<double>(found[i])), std::abs(static_cast<double>(tangent_[i]))});
            if (bend > 0) curve = std::max(curve, std::abs(static_cast<double>(one_side[i] - found[i])));
          }
          good = good && off <= 1e-3 * size + bend * curve + rounding.product + rounding.difference * largest(rate);
        },
        Rate::blocks(psi));
    return good;
  }

  Plain size_, direction_, probe_;
  Rate rate_;
  Unknown tangent_, measured_;
  std::uint64_t seen_ = 0;
  bool due_ = false;
};

}}  // namespace phistep::PHISTEP_ABI
