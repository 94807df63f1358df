/// @file
/// States that live in the arrays of an existing code, forces included: MotionInPlace{r, v, f} for m v' = Ψ, r' = v, and
/// VectorInPlace{y, rate} for M y' = Ψ. The code's own routine, which reads positions and writes forces there, is the
/// force:
///
///     phistep::MotionInPlace state{places(beads, &Bead::x), places(beads, &Bead::v), places(beads, &Bead::f)};
///     phistep::PhiStepper stepper{state, state.force_of_r([&] { compute_forces(beads); }), phistep::velocity_verlet,
///                                 phistep::mass(places(beads, &Bead::m))};
///     stepper.step(state, t, dt);
///
/// When the routine is called, the trial state is in the arrays. After a step that fails, by an outcome or by an
/// exception, r, v and f hold every bit that they held before it.
#pragma once

#include <Eigen/Core>

#include <stdexcept>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/motion.hpp"
#include "phistep/base/version.hpp"
#include "phistep/embed/places.hpp"
#include "phistep/force/routine.hpp"
#include "phistep/step/mass/mass.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

namespace detail {
/// @throws std::invalid_argument where the blocks differ in shape or share memory
template <class First, class... More>
void check_places(const First& first, const More&... more) {
  if (((more.count != first.count) || ...))
    throw std::invalid_argument("phistep: the arrays of a state in place differ in length");
  if (!have_own_places(first, more...))
    throw std::invalid_argument(
        "phistep: the arrays of a state in place share memory: each number, of the forces too, needs a place of its "
        "own");
}
}  // namespace detail

/// What both kinds of states in place do with their arrays. `Self` has `blocks(y)`, a tie of its blocks, `rate()` and
/// `has_length(n)`.
template <class Self, class Plain, class Rate>
class ArraysInPlace {
 public:
  ArraysInPlace() = default;
  ArraysInPlace(const ArraysInPlace&) = delete;  // forces refer to it
  ArraysInPlace& operator=(const ArraysInPlace&) = delete;

  /// Keeps a copy of what the arrays hold.
  const Plain& hold() {
    is_held_ = true;
    note_length();
    reserve();
    return y_;
  }
  /// Makes room for it, by a copy.
  void reserve() const {
    copy_blocks<Self>(y_, static_cast<const Self&>(*this));
    assign_block(rate_, static_cast<const Self&>(*this).rate());
  }
  /// A step begins, or a call outside of steps.
  void note_length() { length_ = self().rate().count; }
  /// Whether all arrays are as long as they were then.
  [[nodiscard]] bool has_kept_length() const noexcept {
    try {
      return static_cast<const Self&>(*this).has_length(length_);
    } catch (...) {  // the arrays of the components differ
      return false;
    }
  }
  /// The arrays hold what they held, every bit. Where their lengths have changed they stay as they are.
  void put_back() {
    if (!has_kept_length()) return;
    copy_blocks<Self>(self(), std::as_const(y_));
    auto rate = self().rate();
    assign_block(rate, std::as_const(rate_));
  }
  void release() { is_held_ = false; }
  [[nodiscard]] bool is_held() const { return is_held_; }

 private:
  [[nodiscard]] Self& self() { return static_cast<Self&>(*this); }
  mutable Plain y_;
  mutable Rate rate_;
  Index length_ = 0;
  bool is_held_ = false;
};

/// Positions, velocities and forces in a code's own arrays. It refers to them, and can't be copied; it must live as long as
/// a stepper uses its forces. Lengths may change between steps, those of masses and steppers follow.
template <PlacesSource R, PlacesSource V, PlacesSource F>
class MotionInPlace
    : public ArraysInPlace<MotionInPlace<R, V, F>, Motion<typename decltype(std::declval<R>().now())::Plain>,
                           typename decltype(std::declval<R>().now())::Plain> {
  using Block = decltype(std::declval<R>().now());
  static_assert(
      std::is_same_v<Block, decltype(std::declval<V>().now())> &&
          std::is_same_v<Block, decltype(std::declval<F>().now())>,
      "phistep: positions, velocities and forces in place are vectors of the same numbers, as many a particle");

 public:
  using Scalar = typename Block::Scalar;
  using Plain = Motion<typename Block::Plain>;
  using Rate = typename Plain::Rate;
  static constexpr bool drifts = true;
  static constexpr auto block_names = Plain::block_names;

  /// @throws std::invalid_argument where the arrays differ in length, or share memory
  MotionInPlace(R r, V v, F f) { point_at(r, v, f); }
  /// The arrays lie elsewhere now. @throws std::invalid_argument likewise
  void point_at(R r, V v, F f) {
    detail::check_places(r.now(), v.now(), f.now());
    r_source_ = r, v_source_ = v, f_source_ = f;
    look();
  }

  /// The force of a routine that computes Ψ(r), or Ψ(r, t): void() or void(Scalar t).
  template <class Routine>
  [[nodiscard]] auto force_of_r(Routine routine) {
    return RoutineForce<MotionInPlace, Routine, false>{*this, std::move(routine)};
  }
  /// The force of a routine that reads the velocities, too: Ψ(r, v), or Ψ(r, v, t).
  template <class Routine>
  [[nodiscard]] auto force_of_rv(Routine routine) {
    return RoutineForce<MotionInPlace, Routine, true>{*this, std::move(routine)};
  }

  static auto blocks(auto& y) {
    y.look();
    return std::tie(y.r_, y.v_);
  }
  /// Where the forces are.
  [[nodiscard]] Block rate() const { return f_source_.now(); }
  [[nodiscard]] bool has_length(Index n) const {
    return r_source_.now().count == n && v_source_.now().count == n && f_source_.now().count == n;
  }

 private:
  /// Where the arrays are now. @throws std::invalid_argument where they differ in length
  void look() const {
    r_ = r_source_.now(), v_ = v_source_.now();
    if (r_.count != v_.count || r_.count != f_source_.now().count)
      throw std::invalid_argument("phistep: the arrays of a state in place differ in length");
  }

  R r_source_{};
  V v_source_{};
  F f_source_{};
  mutable Block r_, v_;
};

/// Unknowns and their rates Ψ in a code's own arrays: M y' = Ψ. As MotionInPlace.
template <PlacesSource Y, PlacesSource F>
class VectorInPlace : public ArraysInPlace<VectorInPlace<Y, F>, typename decltype(std::declval<Y>().now())::Plain,
                                           typename decltype(std::declval<Y>().now())::Plain> {
  using Block = decltype(std::declval<Y>().now());
  static_assert(std::is_same_v<Block, decltype(std::declval<F>().now())>,
                "phistep: unknowns and rates in place are vectors of the same numbers");

 public:
  using Scalar = typename Block::Scalar;
  using Plain = typename Block::Plain;
  using Rate = RateOf<Plain>;
  static constexpr bool drifts = false;

  /// @throws std::invalid_argument where the arrays differ in length, or share memory
  VectorInPlace(Y y, F rate) { point_at(y, rate); }
  /// The arrays lie elsewhere now. @throws std::invalid_argument likewise
  void point_at(Y y, F rate) {
    detail::check_places(y.now(), rate.now());
    y_source_ = y, f_source_ = rate;
    look();
  }

  /// The force of a routine that computes Ψ(y), or Ψ(y, t): void() or void(Scalar t).
  template <class Routine>
  [[nodiscard]] auto force(Routine routine) {
    return RoutineForce<VectorInPlace, Routine, true>{*this, std::move(routine)};
  }

  static auto blocks(auto& y) {
    y.look();
    return std::tie(y.y_);
  }
  /// Where the rates are.
  [[nodiscard]] Block rate() const { return f_source_.now(); }
  [[nodiscard]] bool has_length(Index n) const { return y_source_.now().count == n && f_source_.now().count == n; }

 private:
  void look() const {
    y_ = y_source_.now();
    if (y_.count != f_source_.now().count)
      throw std::invalid_argument("phistep: the arrays of a state in place differ in length");
  }

  Y y_source_{};
  F f_source_{};
  mutable Block y_;
};

template <class Y, class F>
struct Blocks<VectorInPlace<Y, F>> : Blocks<typename VectorInPlace<Y, F>::Plain> {
  static auto all(auto& y) {
    if constexpr (requires { y.rate(); }) return std::remove_cvref_t<decltype(y)>::blocks(y);
    else return std::tie(y);
  }
  static auto solved(auto& y) { return all(y); }
};

/// Masses of particles where a code keeps them; read when a stepper is made, and when the number of particles changes.
template <PlacesSource P>
struct MassInPlace {
  P source;
  template <class Scalar, class Block>
  [[nodiscard]] auto bind(const Block& block) const {
    const auto now = source.now();
    static_assert(now.dim == 1, "phistep: a mass is one number a particle");
    Eigen::Matrix<Scalar, Eigen::Dynamic, 1> all(now.count);
    for (Index i = 0; i < now.count; ++i) all[i] = static_cast<Scalar>(now(i, 0));
    return DiagonalMass<Scalar>{std::move(all)}.template bind<Scalar>(block);
  }
};
template <PlacesSource P>
struct MassKind<P> {
  using type = MassInPlace<P>;
  static type make(const P& source) { return {source}; }
};

}}  // namespace phistep::PHISTEP_ABI
