// spring_rows: the full product and what is dear to compile. The quick half is spring_rows.test.cpp.
#include "particles/springs/spring_rows_cases.hpp"

using namespace spring_rows_cases;

TEMPLATE_TEST_CASE_SIG("rows are the loop over springs, but for rounding", "", ((class Scalar, int dim), Scalar, dim),
                       (double, 3), (double, 2), (double, 1), (float, 3)) {
  check_rows<Scalar, dim>();
}
