/// @file
/// Numbers as text that is the same in every locale, named columns of tables and frames, positions in space.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <charconv>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Appends x by the fewest digits that read back to its bits, or as std::to_chars(…, x, format…); NaN and infinities are nan,
/// inf, -inf.
template <class Number, class... Format>
  requires std::is_arithmetic_v<Number>
void append_number(std::string& text, Number x, Format... format) {
  std::array<char, 64> digits;
  text.append(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), x, format...).ptr);
}

/// A column of one's own: a name, and a function of (t, state) or fixed values.
template <class Content>
struct NamedColumn {
  std::string name;
  Content content;
};
/// `column("energy", [](double t, const auto& y) { … })`, `column("radius", radii)`
template <class Content>
[[nodiscard]] NamedColumn<Content> column(std::string name, Content content) {
  return {std::move(name), std::move(content)};
}
/// A column with its values at time t: those that it has, or what its function returns.
template <class Content, class Scalar, class S>
[[nodiscard]] auto column_at(const NamedColumn<Content>& own, Scalar t, const S& state) {
  // Asks for cols(), not for a call: a matrix can be "called" too, with anything for its indices.
  if constexpr (requires { own.content.cols(); }) return own;
  else return column(own.name, own.content(t, state).eval());
}

/// Positions or velocities as 3 × N, missing coordinates 0. @param dimensions  of a flat vector; 0: it is one particle
template <class Block>
[[nodiscard]] auto in_space(const Block& block, Eigen::Index dimensions) {
  const Eigen::Index rows = Block::ColsAtCompileTime == 1 && dimensions > 0 ? dimensions : block.rows();
  const Eigen::Index particles = block.size() / std::max<Eigen::Index>(rows, 1);
  if (rows > 3 || particles * rows != block.size())
    throw std::invalid_argument(
        "phistep: a file of particles needs positions dim x N with dim <= 3, or a flat vector and its .dimensions");
  using Vectors = Eigen::Matrix<typename Block::Scalar, 3, Eigen::Dynamic>;
  Vectors x = Vectors::Zero(3, particles);
  x.topRows(rows) = block.reshaped(rows, particles);
  return x;
}

}}  // namespace phistep::PHISTEP_ABI
