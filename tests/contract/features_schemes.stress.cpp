// Features in company: the schemes that choose their order, that are explicit, that have two stages.
#include "contract/features.hpp"

TEST_CASE("features in company: collocation") { property::check("radau with features", 150, features::collocation); }
TEST_CASE("features in company: explicit") {
  property::check("forward Euler with features", 100, features::explicit_euler);
}
TEST_CASE("features in company: two stages") { property::check("TR-BDF2 with features", 100, features::one_step); }
