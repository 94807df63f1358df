/// @file
/// One particle's vector, repeated over a state.
#pragma once

#include <Eigen/Core>

#include <stdexcept>
#include <string>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Which coordinate the i-th number of a block in storage order is: its row in a matrix of particles as columns; i itself
/// in a flat vector, where coordinates follow one another particle by particle.
template <class Block>
[[nodiscard]] constexpr Eigen::Index component_of(Eigen::Index i, Eigen::Index rows, Eigen::Index cols) {
  if (Block::IsVectorAtCompileTime || cols == 1) return i;
  return Block::IsRowMajor ? i / cols : i % rows;
}

/// @throws std::invalid_argument where the vector isn't one particle's: its size must divide the block's (or be the number of
/// rows of a matrix).
void check_pattern(const auto& vector, const auto& block, const char* name) {
  if (vector.size() == 0 || block.size() % vector.size() != 0)
    throw std::invalid_argument(std::string("phistep: ") + name + " has " + std::to_string(vector.size()) +
                                " components, which does not fit a state of " + std::to_string(block.size()));
}

}}  // namespace phistep::PHISTEP_ABI
