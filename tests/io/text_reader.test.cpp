// Numbers read without std::from_chars, as some standard libraries have to, are those that it reads.
#include <phistep/io/text_reader.hpp>

#include <charconv>
#include <clocale>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "support/catch.hpp"

using namespace phistep;

namespace {
template <class Number>
struct Read {
  Number x{};
  std::ptrdiff_t length;
  std::errc error;
  explicit Read(const std::string& text) {
    const auto [end, code] = detail::from_chars_by_strtod(text.data(), text.data() + text.size(), x);
    length = end - text.data();
    error = code;
  }
};
}  // namespace

TEST_CASE("numbers by strtod: those of from_chars, from the same characters") {
  for (const char* locale : {"C", "de_DE.UTF-8", "fr_FR.UTF-8"}) {  // those there are
    std::setlocale(LC_NUMERIC, locale);
    for (const std::string text : {"1",
                                   "-1.5",
                                   ".5",
                                   "5.",
                                   "-.25e1",
                                   "1e-3x",
                                   "1.7976931348623157e308",
                                   "0.1",
                                   "2.2250738585072011e-308",
                                   "5e-324",
                                   "0x1p3",
                                   "1e",
                                   "1e+",
                                   "1,5",
                                   "1.5.2",
                                   "+1",
                                   "++1",
                                   "-+1",
                                   "--1",
                                   "",
                                   "-",
                                   ".",
                                   "e5",
                                   "x",
                                   "\xe9",
                                   "\r1",
                                   " 1",
                                   "inf",
                                   "-inf",
                                   "nan",
                                   "123456789012345678901234567890",
                                   "-0"}) {
      const Read<double> own{text};
      const char* const first = text.data();
      CAPTURE(locale, text, own.x, own.length);
#if defined(__cpp_lib_to_chars)
      double x = 0;
      const auto [end, error] = std::from_chars(first, first + text.size(), x);
      CHECK(own.error == error);
      CHECK(own.length == end - first);
      if (error == std::errc{} && !std::isnan(x)) CHECK(std::memcmp(&own.x, &x, sizeof x) == 0);
#else
      CHECK(own.length <= static_cast<std::ptrdiff_t>(std::strlen(first)));
#endif
    }
    CHECK(Read<double>{"1e999"}.error == std::errc::result_out_of_range);
    CHECK(Read<float>{"1e39"}.error == std::errc::result_out_of_range);
    CHECK(Read<double>{"1e-999"}.x == 0);
    CHECK(Read<float>{"0.1"}.x == 0.1f);
    CHECK(Read<long double>{"0.5"}.x == 0.5L);
  }
  std::setlocale(LC_NUMERIC, "C");
}
