#pragma once

// Catch2 2.13 and 3.x under one include. Use `Approx`, and `contains(text)` for strings: version 3 gave the matcher
// Contains another meaning.

#include <string>
#include <utility>

#if __has_include(<catch2/catch_test_macros.hpp>)

#include <catch2/catch_approx.hpp>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/generators/catch_generators_adapters.hpp>
#include <catch2/generators/catch_generators_random.hpp>
#include <catch2/generators/catch_generators_range.hpp>
#include <catch2/matchers/catch_matchers.hpp>
#include <catch2/matchers/catch_matchers_exception.hpp>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <catch2/matchers/catch_matchers_vector.hpp>

[[nodiscard]] inline auto contains(std::string text) { return Catch::Matchers::ContainsSubstring(std::move(text)); }

using Catch::Approx;

#else

#include <catch2/catch.hpp>

using Approx = Catch::Detail::Approx;  // Catch::Approx is a matcher there

[[nodiscard]] inline auto contains(const std::string& text) { return Catch::Matchers::Contains(text); }

#endif
