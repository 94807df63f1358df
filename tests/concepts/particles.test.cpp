// Programs about particles as a user writes them.
#include "concepts/particles_cases.hpp"

TEST_CASE("stars") {
  phistep::Particles<float, 2> stars{Eigen::Matrix2Xf::Random(2, 5)};
  phistep::PhiStepper stepper{stars, phistep::AllPairs{phistep::SoftenedGravity{1, 0.1}}, phistep::velocity_verlet};
  REQUIRE(stepper.step(stars, 0.0f, 0.01f));
  CHECK(phistep::momentum(stars).norm() < 1e-6f);
}
