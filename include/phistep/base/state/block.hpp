/// @file
/// One block of a state: an Eigen vector or matrix, or a field whose numbers only its own operations see (field.hpp).
#pragma once

#include <Eigen/Core>

#include <span>
#include <type_traits>

#include "phistep/base/numbers/fingerprint.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/base/version.hpp"

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
/// … and is zero.
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
template <EigenDense Block>
[[nodiscard]] bool is_finite_block(const Block& x) {
  return all_finite(x.data(), x.size());
}
template <FieldBlock Block>
[[nodiscard]] bool is_finite_block(const Block& x) {
  return Block::Ops::is_finite(x.handle());
}
/// Whether two blocks of one shape hold the same bits.
template <EigenDense Block>
[[nodiscard]] bool equal_bits(const Block& a, const Block& b) {
  return same_bits(a.data(), b.data(), a.size());
}
template <FieldBlock Block>
[[nodiscard]] bool equal_bits(const Block& a, const Block& b) {
  return Block::Ops::equal(a.handle(), b.handle());
}

}}  // namespace phistep::PHISTEP_ABI
