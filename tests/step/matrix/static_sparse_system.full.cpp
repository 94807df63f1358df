// static_sparse_system: whole runs, with masses, every way to name a pattern.
// The quick half is static_sparse_system.test.cpp.
#include "step/matrix/static_sparse_system_cases.hpp"

using namespace static_sparse_cases;

namespace {

template <class F, class Scheme, class... More>
Vec end(F f, Scheme scheme, More... more) {
  Vec y = start();
  PhiStepper stepper{y, f, scheme, more...};
  const auto report = integrate(stepper, y, {0.0, 2.0}, tolerance{.rtol = 1e-6, .atol = 1e-9});
  REQUIRE(report);
  return y;
}

}  // namespace

TEST_CASE("a force that names its Jacobian's pattern is solved by it, and to the same answer") {
  const auto check = [](auto scheme, auto... mass) {
    const Vec dense = end(Dense{}, scheme, mass...);
    // The same steps but for rounding, which 100 steps and a condition of 1e3 make 1e-11 at most.
    CHECK((end(Returned{}, scheme, mass...) - dense).cwiseAbs().maxCoeff() < 1e-11);
    CHECK((end(Added{}, scheme, mass...) - dense).cwiseAbs().maxCoeff() < 1e-11);
  };
  check(rodas4, capacity(Vec(Vec::LinSpaced(n, 0.5, 2))));
  check(backward_euler);
  Vec y = start();
  CHECK(std::string_view(PhiStepper{y, Returned{}, rodas4}.solver_name()) == "LU by a pattern known at compile time");
  CHECK(std::string_view(PhiStepper{y, Added{}, tr_bdf2}.solver_name()) == "LU by a pattern known at compile time");
  CHECK(std::string_view(PhiStepper{y, Dense{}, rodas4}.solver_name()) == "dense LU");
  // A matrix mass fills the pattern up.
  CHECK(std::string_view(PhiStepper{y, Returned{}, rodas4, capacity(Mat(Mat::Identity()))}.solver_name()) ==
        "dense LU");
}

TEST_CASE("a Jacobian with entries outside of its pattern is refused, the state untouched") {
  const auto check = [](auto force) {
    Vec y = start();
    const Vec before = y;
    PhiStepper stepper{y, force, backward_euler};
    CHECK_THROWS_WITH(stepper.step(y, 0.0, 0.1), contains("jacobian_pattern"));
    CHECK(y == before);
  };
  check(Forgotten{});
  check(ForgottenWhenAdded{});
}
