/// @file
/// A text read line by line and word by word; errors name the line.
#pragma once

#include <algorithm>
#include <charconv>
#include <clocale>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstdlib>
#include <istream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>

#include "phistep/core/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

namespace detail {

/// std::from_chars where the library lacks it (libc++ 14 has it for whole numbers only): by strtod, which accepts more and
/// depends on the locale.
template <std::floating_point Number>
std::from_chars_result from_chars_by_strtod(const char* first, const char* last, Number& x) {
  std::string text(first, last);
  // No hexadecimals, no decimal point but '.', and neither a plus nor blanks in front.
  text.resize(std::min(text.find_first_not_of("+-.0123456789aefintyAEFINTY"), text.size()));
  if (text.empty() || text[0] == '+') return {first, std::errc::invalid_argument};
  const std::string point = std::localeconv()->decimal_point;
  const std::size_t dot = text.find('.');
  if (dot != text.npos) text.replace(dot, 1, point);
  char* end = nullptr;
  if constexpr (std::is_same_v<Number, float>) x = std::strtof(text.c_str(), &end);
  else if constexpr (std::is_same_v<Number, double>) x = std::strtod(text.c_str(), &end);
  else x = std::strtold(text.c_str(), &end);
  auto read = static_cast<std::size_t>(end - text.c_str());
  if (read == 0) return {first, std::errc::invalid_argument};
  const bool too_large = std::isinf(x) && text.find_first_of("iI") == text.npos;
  if (dot != text.npos && read > dot) read -= point.size() - 1;
  return {first + read, too_large ? std::errc::result_out_of_range : std::errc{}};
}

template <class Number>
std::from_chars_result from_chars(const char* first, const char* last, Number& x) {
#if defined(_LIBCPP_VERSION)
  if constexpr (std::is_floating_point_v<Number>) return from_chars_by_strtod(first, last, x);
  else
#endif
    return std::from_chars(first, last, x);
}

}  // namespace detail

/// The words of one line after the other. Every error is a std::runtime_error "phistep: NAME, line 12: …".
class TextReader {
 public:
  /// @param name  of the file or stream, for errors
  TextReader(std::istream& in, std::string name) : in_{&in}, name_{std::move(name)} {}

  /// False where the text ends.
  [[nodiscard]] bool next_line() {
    if (!std::getline(*in_, line_)) {
      if (in_->bad()) fail("reading failed");
      return false;
    }
    ++number_;
    if (line_.ends_with('\r')) line_.pop_back();
    rest_ = line_;
    return true;
  }
  /// What of the line is still to be read.
  [[nodiscard]] std::string_view rest() const { return rest_; }
  void set_rest(std::string_view rest) { rest_ = rest; }
  [[nodiscard]] std::int64_t line_number() const { return number_; }
  [[nodiscard]] const std::string& name() const { return name_; }

  /// True where no word is left.
  [[nodiscard]] bool skip_blanks() {
    while (!rest_.empty() && is_blank(rest_.front())) rest_.remove_prefix(1);
    return rest_.empty();
  }
  /// The next word; empty where there is none.
  std::string_view word() {
    if (skip_blanks()) return {};
    std::size_t n = 1;
    while (n < rest_.size() && !is_blank(rest_[n])) ++n;
    const std::string_view found = rest_.substr(0, n);
    rest_.remove_prefix(n);
    return found;
  }
  /// The next word as a number: whole where Number is, finite otherwise.
  template <class Number>
  [[nodiscard]] Number number(const char* what) {
    const std::string_view text = word();
    if (text.empty()) fail(std::string("the line ends where ") + what + " should be");
    return as_number<Number>(text, what);
  }
  /// No word may be left.
  void end_line() {
    const std::string_view text = word();
    if (!text.empty()) fail("nothing should follow, but \"" + shown(text) + "\" does");
  }

  template <class Number>
  [[nodiscard]] Number as_number(std::string_view text, const char* what) const {
    Number x{};
    const char* first = text.data();
    const char* const last = first + text.size();
    if (text.size() > 1 && text[0] == '+' && text[1] != '-') ++first;  // from_chars takes no plus
    auto [end, error] = detail::from_chars(first, last, x);
    if constexpr (std::is_floating_point_v<Number>) {
      // A number too small for its type is 0, as it is everywhere else.
      if (error == std::errc::result_out_of_range && (text.find("e-") != text.npos || text.find("E-") != text.npos)) {
        x = 0;
        error = {};
      }
      if (error == std::errc{} && !std::isfinite(x))
        fail(std::string(what) + " is \"" + shown(text) + "\", not finite");
    }
    if (error == std::errc::result_out_of_range) fail(std::string(what) + ": " + shown(text) + " is too large");
    if (error != std::errc{} || end != last)
      fail(std::string(what) + " should be a " + (std::is_integral_v<Number> ? "whole " : "") + "number, not \"" +
           shown(text) + '"');
    return x;
  }

  [[noreturn]] void fail(const std::string& why) const { fail_at(number_, why); }
  [[noreturn]] void fail_at(std::int64_t line, const std::string& why) const {
    throw std::runtime_error("phistep: " + name_ + ", line " + std::to_string(line) + ": " + why);
  }

 private:
  [[nodiscard]] static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
  /// Enough of a word to find it; a file that is no text may have very long ones.
  [[nodiscard]] static std::string shown(std::string_view text) {
    std::string some{text.substr(0, 40)};
    for (char& c : some)
      if (static_cast<unsigned char>(c) < ' ') c = '?';
    return text.size() > 40 ? some + "…" : some;
  }

  std::istream* in_;
  std::string name_, line_;
  std::string_view rest_;
  std::int64_t number_ = 0;
};

}}  // namespace phistep::PHISTEP_ABI
