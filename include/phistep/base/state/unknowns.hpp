/// @file
/// The unknowns of an implicit solve: a state's solved blocks, one after the other, each in storage order.
#pragma once

#include <Eigen/Core>

#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/state/blocks.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A plain block as one column, in storage order; a field as it is.
template <class Block>
[[nodiscard]] decltype(auto) flat(Block& block) {
  using Column = Eigen::Matrix<typename Block::Scalar, std::remove_const_t<Block>::SizeAtCompileTime, 1>;
  if constexpr (FieldBlock<Block>) return (block);
  else return Eigen::Map<std::conditional_t<std::is_const_v<Block>, const Column, Column>>(block.data(), block.size());
}

/// All unknowns in one vector; of fields there is one.
template <State S>
struct UnknownsOf {
  using type = Eigen::Matrix<ScalarOf<S>, static_unknowns<S>, 1>;
};
template <FieldState S>
struct UnknownsOf<S> {
  static_assert(solved_blocks<S> == 1,
                "phistep: an implicit step solves for one field; join those of a state in one vector (PETSc's "
                "DMComposite, SUNDIALS' ManyVector)");
  using type =
      std::remove_cvref_t<std::tuple_element_t<0, decltype(Blocks<S>::solved(std::declval<PlainState<S>&>()))>>;
};

/// One block's unknowns within a vector of all unknowns.
template <class Vector, class Block>
[[nodiscard]] decltype(auto) part(Vector& all, [[maybe_unused]] Index at, const Block& block) {
  if constexpr (FieldBlock<Vector>) return (all);
  else return all.template segment<Block::SizeAtCompileTime>(at, block.size());
}

/// f(offset of block k among the unknowns, block k of each tie) for every k; of masses, that of block k.
template <class... Ties>
void for_each_part(auto&& f, const Ties&... ties) {
  Index at = 0;
  for_each_block(
      [&](auto, auto& first, auto&... rest) {
        f(at, first, rest...);
        at += first.size();
      },
      ties...);
}
/// The same for the solved blocks of each state.
template <State S, class... Plains>
void for_each_solved(auto&& f, Plains&... states) {
  for_each_part(f, Blocks<S>::solved(states)...);
}

/// x = the unknowns of y, one after the other; and back.
template <State S>
void take_unknowns(auto& x, const PlainState<S>& y) {
  for_each_solved<S>([&x](Index at, const auto& block) { part(x, at, block) = flat(block); }, y);
}
template <State S>
void put_unknowns(const auto& x, PlainState<S>& y) {
  for_each_solved<S>([&x](Index at, auto& block) { flat(block) = part(x, at, block); }, y);
}

/// y.solved += factor x
template <State S>
void add_unknowns(PlainState<S>& y, ScalarOf<S> factor, const auto& x) {
  for_each_solved<S>([&](Index at, auto& block) { flat(block) += factor * part(x, at, block); }, y);
}

template <State S>
[[nodiscard]] auto& position_of(auto& y) {
  return std::get<0>(Blocks<S>::all(y));
}
template <State S>
[[nodiscard]] auto& velocity_of(auto& y) {
  return std::get<1>(Blocks<S>::all(y));
}

}}  // namespace phistep::PHISTEP_ABI
