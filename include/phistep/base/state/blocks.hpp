/// @file
/// A state is a few blocks of numbers: an Eigen vector is one, Motion is (r, v), a user's own struct may couple more.
///
/// `Blocks<S>` is the only thing the steppers know of a state. It names
///   Scalar   the number type,
///   Plain    the owning twin of S in which the stepper works (S itself, or VectorXd for a Map<VectorXd>),
///   Rate     what the force fills: one member per solved block,
///   drifts   whether the first block r obeys r' = v, v being the second; every other block is solved for,
/// and ties of references to all blocks, to the solved blocks and to the rates.
#pragma once

#include <Eigen/Core>

#include <concepts>
#include <cstddef>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/numbers/fingerprint.hpp"
#include "phistep/base/numbers/finite_witness.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

using Index = Eigen::Index;

/// An Eigen dense vector or matrix: Matrix, Array, Map, Ref.
template <class T>
concept EigenDense = std::is_base_of_v<Eigen::DenseBase<T>, T> && requires(T& x) {
  x.data();
};

/// A vector whose numbers only its own operations see (field.hpp).
template <class T>
concept FieldBlock = requires {
  requires std::remove_cvref_t<T>::is_field;
};

/// Whether `size` is known at compile time, and small enough for registers and loops of known length.
[[nodiscard]] constexpr bool few_numbers(int size) { return size != Eigen::Dynamic && size <= 64; }
/// The width of packs for the numbers of a block: those of a few were written one by one, and packs of them would be waited for.
template <class Block>
inline constexpr int pack_width = few_numbers(Block::SizeAtCompileTime) ? 1 : native_width<typename Block::Scalar>;
/// to = from, for blocks of any kind.
template <class To, class From>
[[gnu::always_inline]] inline void assign_block(To& to, const From& from) {
  to = from;
}
/// x has the shape of another block, and any numbers.
template <class Block>
void set_shape_like(Block& x, const auto& other) {
  if constexpr (FieldBlock<Block>) x.take_shape(other);
  else x.resize(other.rows(), other.cols());
}
/// x has the shape of another block, and is zero.
template <class Block>
void set_zero_like(Block& x, const auto& other) {
  set_shape_like(x, other);
  x.setZero();
}
/// max |x_i| of a field, as base/numbers/arithmetic.hpp has it of numbers.
template <FieldBlock Block>
[[nodiscard]] auto max_abs(const Block& x) {
  double all = Block::Ops::largest_here(x.handle());
  Block::Ops::greatest(x.handle(), std::span<double>{&all, 1});
  return static_cast<typename Block::Scalar>(all);
}
/// Whether all numbers of a block without gaps are finite.
template <class Block>
[[nodiscard]] bool is_finite_block(const Block& x) {
  if constexpr (FieldBlock<Block>) return Block::Ops::is_finite(x.handle());
  else return all_finite<pack_width<Block>>(x.data(), x.size());
}
/// Whether two blocks of one shape hold the same bits.
template <class Block>
  requires(EigenDense<Block> || FieldBlock<Block>)
[[nodiscard]] bool equal_bits(const Block& a, const Block& b) {
  if constexpr (FieldBlock<Block>) return Block::Ops::equal(a.handle(), b.handle());
  else return same_bits(a.data(), b.data(), a.size());
}

/// A state of the user's own: blocks of any names, the first being r and the second v where it drifts.
///
///     struct Spray {
///       Eigen::VectorXd r, v, T;
///       static constexpr bool drifts = true;                                     // r' = v; without this word nothing drifts
///       static auto blocks(auto& y) { return std::tie(y.r, y.v, y.T); }
///       struct Rate {
///         Eigen::VectorXd force, heat;                                           // rates of v and T
///         static auto blocks(auto& rate) { return std::tie(rate.force, rate.heat); }
///       };
///     };
template <class S>
concept BlockStruct = requires(S& y, typename S::Rate& rate) {
  S::blocks(y);
  S::Rate::blocks(rate);
};

/// What a force sees of a first-order state.
template <class Vector, class Mass>
struct FirstOrderView {
  const Vector& y;   ///< the unknowns
  const Mass& mass;  ///< the capacity M in M y' = Ψ
};

template <class S>
struct Blocks;

template <class S>
  requires(FieldBlock<S> || (EigenDense<S> && std::is_floating_point_v<typename S::Scalar>))
struct Blocks<S> {
  using Scalar = typename S::Scalar;
  using Plain = typename S::PlainObject;
  struct Rate {
    Plain rate;  ///< Ψ(y, t), shaped like y
    static auto blocks(auto& psi) { return std::tie(psi.rate); }
  };
  static constexpr bool drifts = false;
  static auto all(auto& y) { return std::tie(y); }
  static auto solved(auto& y) { return std::tie(y); }
  template <class Masses>
  static auto view(const Plain& y, const Masses& masses) {
    return FirstOrderView<Plain, std::tuple_element_t<0, Masses>>{y, std::get<0>(masses)};
  }
};

template <class S>
struct OwningTwin {
  using type = S;
};
template <class S>
  requires requires { typename S::Plain; }
struct OwningTwin<S> {
  using type = typename S::Plain;
};

template <BlockStruct S>
struct Blocks<S> {
  using Plain = typename OwningTwin<S>::type;
  using Rate = typename Plain::Rate;
  static constexpr bool drifts = [] {
    if constexpr (requires { S::drifts; }) return bool{S::drifts};
    else return false;
  }();
  static auto all(auto& y) { return std::remove_cvref_t<decltype(y)>::blocks(y); }
  static auto solved(auto& y) {
    return []<std::size_t... K>(auto tie, std::index_sequence<K...>) {
      return std::tie(std::get<K + (drifts ? 1 : 0)>(tie)...);
    }
    (all(y), std::make_index_sequence<std::tuple_size_v<decltype(all(y))> - (drifts ? 1 : 0)>{});
  }
  static_assert(std::tuple_size_v<decltype(solved(std::declval<S&>()))> ==
                    std::tuple_size_v<decltype(Rate::blocks(std::declval<Rate&>()))>,
                "phistep: the state's Rate needs a block for each of its blocks, but for the first where that drifts "
                "(static constexpr bool drifts = true; r' = v)");
  using Scalar = typename std::remove_cvref_t<std::tuple_element_t<0, decltype(all(std::declval<Plain&>()))>>::Scalar;
  /// What a force's `add` sees: the state's own view (with masses) if it defines one, else the state.
  template <class Masses>
  static decltype(auto) view(const Plain& y, const Masses& masses) {
    if constexpr (requires { Plain::view(y, masses); }) return Plain::view(y, masses);
    else return (y);
  }
};

/// It would be a state but for its numbers, which are no reals, nor made of them (embed/number_parts.hpp).
template <class S>
inline constexpr bool has_other_numbers = EigenDense<S>;
template <class S>
  requires requires { typename Blocks<S>::Scalar; }
inline constexpr bool has_other_numbers<S> = !std::is_floating_point_v<typename Blocks<S>::Scalar>;

/// A state the steppers can advance.
template <class S>
concept State = (EigenDense<S> || FieldBlock<S> || BlockStruct<S>)&&!has_other_numbers<S>;

/// Whether S, the type of an argument, is a state that can be stepped.
template <class S>
concept MutableState = State<std::remove_reference_t<S>> && std::is_lvalue_reference_v<S>;

/// Base of a class template made of static_asserts. A static_assert of its member `is_said` instantiates it, and the compiler shows
/// the messages of those that fail.
struct Refuses {
  static constexpr bool is_said = true;
};

/// Says what a state may be.
template <bool is_state, class S>
struct StateRefusal : Refuses {
  static_assert(
      is_state || !has_other_numbers<S>,
      "phistep: the state's numbers must be float, double or long double; in a vector, a matrix or a Motion of them "
      "also std::complex of these, or AutoDiffScalar with a fixed number of derivatives");
  static_assert(
      is_state || has_other_numbers<S>,
      "phistep: the state must be an Eigen vector or matrix that can be changed, a Map of your array "
      "(Eigen::Map<Eigen::VectorXd> y{x.data(), n} of a std::vector), Motion{r, v}, Particles or a struct with "
      "blocks; give an expression a name (Eigen::VectorXd y = ...), make one number an Eigen::Vector<double, 1>");
};

/// How many of a tie's blocks are fields.
template <class Tie>
inline constexpr std::size_t count_of_fields = 0;
template <class... Block>
inline constexpr std::size_t count_of_fields<std::tuple<Block...>> = (std::size_t{0} + ... +
                                                                      (FieldBlock<Block> ? 1 : 0));
/// A state of fields (base/state/field.hpp).
template <class S>
concept FieldState = State<S> &&(count_of_fields<decltype(Blocks<S>::all(std::declval<S&>()))> > 0);

template <State S>
using PlainState = typename Blocks<S>::Plain;
template <State S>
using RateOf = typename Blocks<S>::Rate;
template <State S>
using ScalarOf = typename Blocks<S>::Scalar;
template <State S>
inline constexpr std::size_t solved_blocks =
    std::tuple_size_v<decltype(Blocks<S>::solved(std::declval<PlainState<S>&>()))>;

/// Calls f(k, block k of each tie) for every k.
template <std::size_t k = 0, class F, class First, class... Rest>
[[gnu::always_inline]] constexpr void for_each_block(F&& f, First&& first, Rest&&... rest) {
  f(std::integral_constant<std::size_t, k>{}, std::get<k>(first), std::get<k>(rest)...);
  if constexpr (k + 1 < std::tuple_size_v<std::remove_cvref_t<First>>) for_each_block<k + 1>(f, first, rest...);
}

/// Sum of the blocks' compile-time sizes, or Eigen::Dynamic.
template <class Tie>
inline constexpr int static_size = []<std::size_t... K>(std::index_sequence<K...>) {
  constexpr int sizes[] = {std::remove_cvref_t<std::tuple_element_t<K, Tie>>::SizeAtCompileTime...};
  int total = 0;
  for (const int n : sizes) {
    if (n == Eigen::Dynamic) return static_cast<int>(Eigen::Dynamic);
    total += n;
  }
  return total;
}
(std::make_index_sequence<std::tuple_size_v<Tie>>{});

/// Number of unknowns known at compile time, or Eigen::Dynamic.
template <State S>
inline constexpr int static_unknowns = static_size<decltype(Blocks<S>::solved(std::declval<PlainState<S>&>()))>;
/// How many numbers a state has if the types fix it, else Eigen::Dynamic.
template <State S>
inline constexpr int static_numbers = static_size<decltype(Blocks<S>::all(std::declval<PlainState<S>&>()))>;

/// Whether all numbers of a state fit into registers.
template <State S>
inline constexpr bool fits_registers = few_numbers(static_numbers<S>);

template <class Tie>
void set_zero(const Tie& blocks) {
  for_each_block([](auto, auto& block) { block.setZero(); }, blocks);
}
/// How many numbers they hold.
template <class Tie>
[[nodiscard]] Index count_of(const Tie& blocks) {
  Index n = 0;
  for_each_block([&n](auto, const auto& block) { n += block.size(); }, blocks);
  return n;
}
/// Whether all numbers of all blocks are finite.
template <class Tie>
[[nodiscard]] bool all_finite(const Tie& blocks) {
  bool finite = true;
  if constexpr (0 < count_of_fields<Tie>) {  // one reduction
    for_each_block(
        [&finite](auto, const auto& x) {
          finite = std::remove_cvref_t<decltype(x)>::Ops::is_finite_here(x.handle()) && finite;
        },
        blocks);
    const auto& first = std::get<0>(blocks);
    return std::remove_cvref_t<decltype(first)>::Ops::most(first.handle(), finite ? 0 : 1) == 0;
  } else {
    for_each_block([&finite](auto, const auto& x) { finite = is_finite_block(x) && finite; }, blocks);
    return finite;
  }
}
/// f(i, number i of each tie) for all numbers, one block after the other, each in storage order.
template <class... Ties>
[[gnu::always_inline]] inline void for_each_number(auto&& f, const Ties&... ties) {
  std::size_t at = 0;
  for_each_block(
      [&f, &at](auto, auto& first, auto&... rest) {
        const auto n = static_cast<std::size_t>(first.size());
        for (std::size_t i = 0; i < n; ++i) f(at + i, first.data()[i], rest.data()[i]...);
        at += n;
      },
      ties...);
}

/// Number of unknowns of the implicit solve.
template <State S, class Y>
[[nodiscard]] Index unknowns(const Y& y) {
  return count_of(Blocks<S>::solved(y));
}

/// The rate has the right shape for y, and is zero.
template <State S>
void reset_rate(RateOf<S>& rate, const PlainState<S>& y) {
  for_each_block([](auto, auto& psi, const auto& block) { set_zero_like(psi, block); }, RateOf<S>::blocks(rate),
                 Blocks<S>::solved(y));
}
template <State S>
[[nodiscard]] RateOf<S> make_rate(const PlainState<S>& y) {
  RateOf<S> rate;
  reset_rate<S>(rate, y);
  return rate;
}

template <State S, class A, class B>
[[nodiscard]] bool same_shape(const A& a, const B& b) {
  bool same = true;
  for_each_block([&same](auto, const auto& x, const auto& y) { same &= x.rows() == y.rows() && x.cols() == y.cols(); },
                 Blocks<S>::all(a), Blocks<S>::all(b));
  return same;
}

/// Properties beside the blocks that a state's copies share (see particles/bodies/particles.hpp).
template <class S>
concept HasProperties = requires(S& to, const S& from) {
  S::share_properties(to, from);
  { S::same_properties(from, from) } -> std::convertible_to<bool>;
};

/// A state in arrays that the force reads by itself: trial states are shown there, and taken back unless the step is done.
template <class S>
concept ShowsTrials = State<S> && requires(S& state) {
  { state.hold() } -> std::same_as<const PlainState<S>&>;  // a copy of what the arrays hold now
  state.reserve();                                         // room for it
  state.put_back();                                        // the arrays hold that again
  state.release();                                         // the step is over
};

/// to = from, block by block; allocates only where the sizes differ.
template <State S, class To, class From>
void copy_blocks(To& to, const From& from) {
  if constexpr (HasProperties<S>) S::share_properties(to, from);
  for_each_block([](auto, auto& x, const auto& y) { assign_block(x, y); }, Blocks<S>::all(to), Blocks<S>::all(from));
}

/// The state as a plain one: itself, or a view's numbers, gathered.
template <State S>
[[nodiscard]] const PlainState<S>& gathered(const S& state, [[maybe_unused]] auto& numbers) {
  if constexpr (std::is_same_v<S, PlainState<S>>) {
    return state;
  } else {
    copy_blocks<S>(numbers, state);
    return numbers;
  }
}

/// A plain state as forces, events and observers see it.
template <State S>
[[nodiscard]] decltype(auto) shown(const PlainState<S>& y) {
  if constexpr (requires { Blocks<S>::shown(y); }) return Blocks<S>::shown(y);
  else return (y);
}

/// Makes `next` the state: by swapping buffers where the state owns dynamic ones, else by copying.
template <State S>
[[gnu::always_inline]] inline void commit_blocks(S& state, PlainState<S>& next) {
  for_each_block(
      [](auto, auto& x, auto& y) PHISTEP_DETAIL_INLINED {
        using Block = std::remove_cvref_t<decltype(x)>;
        if constexpr (std::is_same_v<Block, std::remove_cvref_t<decltype(y)>> &&
                      Block::SizeAtCompileTime == Eigen::Dynamic)
          x.swap(y);
        else assign_block(x, std::as_const(y));
      },
      Blocks<S>::all(state), Blocks<S>::all(next));
}

/// Whether all blocks of two ties of one shape hold the same bits.
template <class... A, class... B>
[[nodiscard]] bool equal_bits(const std::tuple<A...>& a, const std::tuple<B...>& b) {
  bool equal = true;
  for_each_block([&equal](auto, const auto& x, const auto& y) { equal = equal && equal_bits(x, y); }, a, b);
  return equal;
}
template <State S>
[[nodiscard]] bool equal_blocks(const PlainState<S>& a, const PlainState<S>& b) {
  return equal_bits(Blocks<S>::all(a), Blocks<S>::all(b));
}

}}  // namespace phistep::PHISTEP_ABI
