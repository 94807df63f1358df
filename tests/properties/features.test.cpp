// Features in company, a few of them: features.full.cpp has more schemes and the wrappers, features.stress.cpp more cases.
#include "properties/features.hpp"

TEST_CASE("features in company: the trapezoidal rule") {
  property::check("trapezoidal with features", 150, features::trapezoidal_rule<false>);
}
