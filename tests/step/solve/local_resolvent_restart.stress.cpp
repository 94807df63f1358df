// Restarts of particles solved one by one; in short: local_resolvent.test.cpp.
#include <phistep/io/checkpoint.hpp>

#include "step/solve/local_resolvent_cases.hpp"

using namespace local_resolvent_cases;

TEST_CASE("saving forgets the pace of each particle's solves, as a restart does: the next step's bits are the same") {
  const auto check = [](auto go) {
    Motion<Matrix3Xd> y = crowd(14), z = y;
    PhiStepper stepper{y, local<3>(WellWithJacobian{}), backward_euler},
        other{z, local<3>(WellWithJacobian{}), backward_euler};
    go(stepper, y, 0.0);
    std::stringstream bytes;
    save_checkpoint(bytes, stepper, y);
    load_checkpoint(bytes, other, z);
    go(stepper, y, 1.0);
    go(other, z, 1.0);
    CHECK((y.r.array() == z.r.array()).all());
    CHECK((y.v.array() == z.v.array()).all());
    CHECK(stepper.statistics() == other.statistics());
  };
  check([](auto& stepper, auto& y, double t) {
    for (int k = 0; k < 10; ++k) REQUIRE(stepper.step(y, t, 1e-4));
  });
  check([](auto& stepper, auto& y, double t) {
    REQUIRE(integrate(stepper, y, {t, t + 1}, tolerance{.rtol = 1e-5, .atol = 1e-7}));
  });
}
