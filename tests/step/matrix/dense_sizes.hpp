// The sizes at which something changes in a small dense solver: rows held in registers (1 … 3), packets full, short by
// one, over by one. The scalar that is used most gets the most; the quick half has one of each kind.
#pragma once

#include <type_traits>
#include <utility>

namespace dense {

template <class Scalar>
using Sizes =
    std::conditional_t<std::is_same_v<Scalar, double>, std::integer_sequence<int, 1, 2, 3, 4, 5, 7, 8, 9, 12, 20, 32>,
                       std::integer_sequence<int, 1, 2, 3, 4, 9>>;
template <class Scalar>
using QuickSizes = std::conditional_t<
    std::is_same_v<Scalar, double>, std::integer_sequence<int, 9>,
    std::conditional_t<std::is_same_v<Scalar, float>, std::integer_sequence<int, 4>, std::integer_sequence<int, 3>>>;

}  // namespace dense
