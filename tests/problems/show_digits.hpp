#pragma once

// Catch prints a double with ten fixed digits, in which the errors measured here are 0.0. Included, this shows twenty.

#include "support/catch.hpp"

namespace problems {

inline const int shown_digits = Catch::StringMaker<double>::precision = 20;

}  // namespace problems
