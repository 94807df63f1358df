// What extrapolated steps carry, for flows and motions, by every base and in every scalar; the quick half is
// extrapolation_order.test.cpp.
#include <phistep/phistep.hpp>
#include <phistep/schemes/extrapolation/extrapolated.hpp>

#include <cmath>
#include <sstream>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "contract/restart.hpp"
#include "problems/damped_pendulum.hpp"
#include "problems/hires.hpp"
#include "problems/kepler.hpp"
#include "problems/march.hpp"
#include "problems/pendulum_flow.hpp"
#include "support/catch.hpp"

#pragma GCC diagnostic ignored "-Wdeprecated-declarations"  // of two kinds, which leave in 0.3

using namespace phistep;
using problems::distance;
using problems::march;
using problems::PendulumFlow;

TEST_CASE("a run taken up again anywhere ends in the bits of the unbroken one") {
  const auto check = [](auto start, auto force, auto scheme, double t1) {
    const tolerance control{.rtol = 1e-7, .atol = 1e-9};
    auto y = start;
    PhiStepper stepper{y, force, scheme};
    Run run{stepper, y, {0.0, t1}, control};
    std::vector<std::string> saved{restart::bytes(run)};
    while (run.advance()) saved.push_back(restart::bytes(run));
    REQUIRE(run.report());
    const std::string end = restart::bytes(run);
    for (std::size_t k = 0; k + 1 < saved.size(); k += 3) {
      auto again = start;
      PhiStepper fresh{again, force, scheme};
      Run rest{fresh, again, {0.0, t1}, control};
      std::istringstream in(saved[k]);
      load_checkpoint(in, rest);
      while (rest.advance()) {
      }
      REQUIRE(rest.report());
      CHECK((restart::bytes(rest) == end));
    }
  };
  check(problems::Hires::start(), problems::Hires{}, extrapolated(backward_euler), 50.0);
  const problems::Kepler kepler;
  check(kepler.start(), kepler, extrapolated(velocity_verlet), 6.0);
  check(problems::DampedPendulum::start(), problems::DampedPendulum{}, extrapolated(forward_euler), 6.0);
}

TEST_CASE("units of length and time that are powers of two change no bit") {
  const auto run = [](auto scheme, int length, int time) {
    // r'' = −k sin(r/l)·l, in units of 2^length and 2^time
    using One = Eigen::Matrix<double, 1, 1>;
    const double l = std::ldexp(1.0, length), k = std::ldexp(2.0, -2 * time), v = std::ldexp(0.5, length - time);
    Motion<One> y{One{l}, One{v}};
    PhiStepper stepper{y, [=](const One& r) -> One { return One{-k * l * std::sin(r[0] / l)}; }, scheme};
    const double atol = std::ldexp(1e-9, length);
    const auto report = integrate(stepper, y, {0.0, std::ldexp(5.0, time)},
                                  tolerance{.rtol = 1e-8, .atol = {atol, std::ldexp(atol, -time)}});
    REQUIRE(report);
    return std::pair{std::ldexp(y.r[0], -length), std::ldexp(y.v[0], time - length)};
  };
  for (const auto& [length, time] : {std::pair{20, 0}, {0, -31}, {-40, 17}}) {
    CAPTURE(length, time);
    CHECK(run(extrapolated(backward_euler), length, time) == run(extrapolated(backward_euler), 0, 0));
    CHECK(run(extrapolated(forward_euler), length, time) == run(extrapolated(forward_euler), 0, 0));
    CHECK(run(extrapolated(velocity_verlet), length, time) == run(extrapolated(velocity_verlet), 0, 0));
  }
}

TEMPLATE_TEST_CASE("every scalar, at tolerances that fit it", "", float, long double) {
  using T = TestType;
  const double rtol = std::is_same_v<T, float> ? 1e-4 : 1e-15;
  const auto end = [&](auto scheme, double wanted) {
    typename PendulumFlow<T>::Two y{T(1), T(0.5)};
    PhiStepper stepper{y, PendulumFlow<T>{}, scheme};
    const auto report = integrate(stepper, y, {T(0), T(2)}, tolerance{.rtol = wanted, .atol = wanted});
    CAPTURE(report.message());
    REQUIRE(report);
    return y;
  };
  const auto exact =
      march(PhiStepper{typename PendulumFlow<T>::Two{T(1), T(0.5)}, PendulumFlow<T>{}, extrapolated(forward_euler, 8)},
            typename PendulumFlow<T>::Two{T(1), T(0.5)}, T(0), T(2), 60);
  CHECK(distance(end(extrapolated(backward_euler), rtol), exact) <= 10 * rtol);
  CHECK(distance(end(extrapolated(forward_euler), rtol), exact) <= 10 * rtol);
}
