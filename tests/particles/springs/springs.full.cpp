// springs: the full product and what is dear to compile. The quick half is springs.test.cpp.
#include "particles/springs/springs_cases.hpp"

using namespace springs_cases;

TEMPLATE_TEST_CASE_SIG("pairs are the entries, without what dashpots add to the tangent in r", "", ((int dim), dim), 1,
                       2, 3) {
  check_pairs<dim>();
}
