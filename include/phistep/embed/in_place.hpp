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

#include <algorithm>
#include <array>
#include <cstddef>
#include <stdexcept>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/motion.hpp"
#include "phistep/embed/places.hpp"
#include "phistep/force/routine.hpp"
#include "phistep/force/sum.hpp"
#include "phistep/step/mass/mass.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The base of both states in place. @tparam Sources  the arrays of the unknowns, and last the array of their rates
template <class Self, class Plain, PlacesSource... Sources>
class ArraysInPlace {
  static constexpr std::size_t blocks_count = sizeof...(Sources) - 1;

 protected:
  using Block = decltype(std::declval<std::tuple_element_t<0, std::tuple<Sources...>>>().now());
  static constexpr bool is_of_one_kind = (std::is_same_v<Block, decltype(std::declval<Sources>().now())> && ...);

  /// @throws std::invalid_argument where the arrays differ in length, or share memory
  void set_sources(Sources... sources) {
    check_lengths(sources.now()...);
    if (!have_own_places(sources.now()...))
      throw std::invalid_argument(
          "phistep: the arrays of a state in place share memory: each number, of the forces too, needs a place of its "
          "own");
    sources_ = {sources...};
  }

 public:
  ArraysInPlace() = default;
  ArraysInPlace(const ArraysInPlace&) = delete;  // forces refer to it
  ArraysInPlace& operator=(const ArraysInPlace&) = delete;

  /// Where the unknowns are now. @throws std::invalid_argument where the arrays differ in length
  static auto blocks(auto& y) {
    std::apply([&y](const auto&... source) { y.look(source.now()...); }, y.sources_);
    return std::apply([](auto&... block) { return std::tie(block...); }, y.blocks_);
  }
  /// Where the rates are.
  [[nodiscard]] Block rate() const { return std::get<blocks_count>(sources_).now(); }

  /// Keeps a copy of what the arrays hold.
  const Plain& hold() {
    is_held_ = true;
    note_length();
    reserve();
    return y_;
  }
  /// Allocates the copy that hold() fills, by making one.
  void reserve() const {
    copy_blocks<Self>(y_, static_cast<const Self&>(*this));
    assign_block(rate_, rate());
  }
  /// A step begins, or a call outside of steps.
  void note_length() { length_ = rate().count; }
  /// Whether all arrays are as long as they were then.
  [[nodiscard]] bool has_kept_length() const noexcept {
    try {
      return std::apply([this](const auto&... source) { return ((source.now().count == length_) && ...); }, sources_);
    } catch (...) {  // the arrays of the components differ
      return false;
    }
  }
  /// The arrays hold what they held, every bit. Where their lengths have changed they stay as they are.
  void put_back() {
    if (!has_kept_length()) return;
    copy_blocks<Self>(static_cast<Self&>(*this), std::as_const(y_));
    auto rates = rate();
    assign_block(rates, std::as_const(rate_));
  }
  void release() { is_held_ = false; }
  [[nodiscard]] bool is_held() const { return is_held_; }

 private:
  static void check_lengths(const auto& first, const auto&... more) {
    if (((more.count != first.count) || ...))
      throw std::invalid_argument("phistep: the arrays of a state in place differ in length");
  }
  void look(const auto&... now) const {
    check_lengths(now...);
    const Block all[] = {now...};
    std::copy_n(all, blocks_count, blocks_.begin());
  }

  std::tuple<Sources...> sources_;
  mutable std::array<Block, blocks_count> blocks_;
  mutable Plain y_;
  mutable typename Block::Plain rate_;
  Index length_ = 0;
  bool is_held_ = false;
};

/// Positions, velocities and forces in a code's own arrays. It refers to them, and can't be copied; it must live as long as
/// a stepper uses its forces. Lengths may change between steps, those of masses and steppers follow.
template <PlacesSource R, PlacesSource V, PlacesSource F>
class MotionInPlace
    : public ArraysInPlace<MotionInPlace<R, V, F>, Motion<typename decltype(std::declval<R>().now())::Plain>, R, V, F> {
  using Arrays = ArraysInPlace<MotionInPlace, Motion<typename decltype(std::declval<R>().now())::Plain>, R, V, F>;
  static_assert(
      Arrays::is_of_one_kind,
      "phistep: positions, velocities and forces in place are vectors of the same numbers, as many a particle");
  static_assert(!is_a<BareNumbers, R> && !is_a<BareNumbers, V> && !is_a<BareNumbers, F>,
                "phistep: places(x, n) of plain numbers may mean x(n) or x(3, n): write places<1>(x, n) or "
                "places<3>(x, n) for n particles");

 public:
  using Scalar = typename Arrays::Block::Scalar;
  using Plain = Motion<typename Arrays::Block::Plain>;
  using Rate = typename Plain::Rate;
  static constexpr bool drifts = true;
  static constexpr auto block_names = Plain::block_names;

  /// @throws std::invalid_argument where the arrays differ in length, or share memory
  MotionInPlace(R r, V v, F f) { point_at(r, v, f); }
  /// Sets other arrays. @throws std::invalid_argument as the constructor does
  void point_at(R r, V v, F f) { this->set_sources(r, v, f); }

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
};

/// Unknowns and their rates Ψ in a code's own arrays: M y' = Ψ. As MotionInPlace.
template <PlacesSource Y, PlacesSource F>
class VectorInPlace
    : public ArraysInPlace<VectorInPlace<Y, F>, typename decltype(std::declval<Y>().now())::Plain, Y, F> {
  using Arrays = ArraysInPlace<VectorInPlace, typename decltype(std::declval<Y>().now())::Plain, Y, F>;
  static_assert(Arrays::is_of_one_kind, "phistep: unknowns and rates in place are vectors of the same numbers");

 public:
  using Scalar = typename Arrays::Block::Scalar;
  using Plain = typename Arrays::Block::Plain;
  using Rate = RateOf<Plain>;
  static constexpr bool drifts = false;

  /// @throws std::invalid_argument where the arrays differ in length, or share memory
  VectorInPlace(Y y, F rate) { point_at(y, rate); }
  /// Sets other arrays. @throws std::invalid_argument as the constructor does
  void point_at(Y y, F rate) { this->set_sources(y, rate); }

  /// The force of a routine that computes Ψ(y), or Ψ(y, t): void() or void(Scalar t).
  template <class Routine>
  [[nodiscard]] auto force(Routine routine) {
    return RoutineForce<VectorInPlace, Routine, true>{*this, std::move(routine)};
  }
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
