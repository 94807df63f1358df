// Features in company, over thousands of generated runs.
#include "properties/features.hpp"

TEST_CASE("features in company, for long") {
  property::report("trapezoidal with features: the plain run's bits, or its error", 10000,
                   features::trapezoidal_rule<true>);
  property::report("rodas4 with features: the plain run's bits, or its error", 10000, features::rosenbrock);
  property::report("radau with features: the plain run's bits, or its error", 10000, features::collocation);
}
