/// @file
/// Numbers as text that looks the same in every locale, and named columns of tables and frames.
#pragma once

#include <array>
#include <charconv>
#include <string>
#include <type_traits>
#include <utility>

#include "phistep/core/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Appends x by the fewest digits that read back to its bits; NaN and infinities are nan, inf, -inf.
template <class Number>
  requires std::is_arithmetic_v<Number>
void append_number(std::string& text, Number x) {
  std::array<char, 64> digits;
  text.append(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), x).ptr);
}
/// Appends x rounded to so many significant digits, at most 40.
template <class Number>
  requires std::is_floating_point_v<Number>
void append_number(std::string& text, Number x, int significant) {
  std::array<char, 64> digits;
  text.append(
      digits.data(),
      std::to_chars(digits.data(), digits.data() + digits.size(), x, std::chars_format::general, significant).ptr);
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

}}  // namespace phistep::PHISTEP_ABI
