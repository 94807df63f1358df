// Features in company: some schemes and the wrappers; in the stress tier more cases.
#include "contract/features.hpp"

#if PHISTEP_FULL
// Features in company, wrappers among them: schemes that look back, that linearize.

TEST_CASE("features in company: the trapezoidal rule, wrapped") {
  property::check("trapezoidal with features, wrapped", 150, features::trapezoidal_rule<true>);
}
TEST_CASE("features in company: Rosenbrock's scheme") {
  property::check("rodas4 with features", 150, features::rosenbrock);
}

#elif PHISTEP_STRESS
// Features in company, over thousands of generated runs.

TEST_CASE("features in company, for long") {
  property::report("trapezoidal with features: the plain run's bits, or its error", 10000,
                   features::trapezoidal_rule<true>);
  property::report("rodas4 with features: the plain run's bits, or its error", 10000, features::rosenbrock);
  property::report("radau with features: the plain run's bits, or its error", 10000, features::collocation);
}

#endif
