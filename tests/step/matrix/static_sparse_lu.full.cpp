// static_sparse_lu: the full product and what is dear to compile. The quick half is static_sparse_lu.test.cpp.
#include "step/matrix/static_sparse_lu_cases.hpp"

using namespace static_sparse_lu_cases;

TEMPLATE_TEST_CASE("any matrix is solved as well as by dense LU", "", float, double, long double) {
  dense::for_sizes<Static<TestType>::template OfSize>(solves_well, Sizes<TestType>{});
}

TEMPLATE_TEST_CASE("a singular matrix or a bad entry is refused", "", float, double, long double) {
  dense::for_sizes<Static<TestType>::template OfSize>(refuses, Sizes<TestType>{});
}

TEMPLATE_TEST_CASE("it solves in place", "", float, double, long double) {
  dense::for_sizes<Static<TestType>::template OfSize>(dense::solves_where_x_lies, Sizes<TestType>{});
}
