// Features in company, wrappers among them: schemes that look back, that linearise.
#include "properties/features.hpp"

TEST_CASE("features in company: the trapezoidal rule, wrapped") {
  property::check("trapezoidal with features, wrapped", 150, features::trapezoidal_rule<true>);
}
TEST_CASE("features in company: Rosenbrock's scheme") {
  property::check("rodas4 with features", 150, features::rosenbrock);
}
