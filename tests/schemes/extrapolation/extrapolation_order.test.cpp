// What extrapolated steps carry from one to the next: restarts, units and scalars.
#include <phistep/phistep.hpp>
#include <phistep/schemes/extrapolation/extrapolated.hpp>

#include <cmath>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "contract/restart.hpp"
#include "support/catch.hpp"
#include "support/shared_force.hpp"

#pragma GCC diagnostic ignored "-Wdeprecated-declarations"  // of two kinds, which leave in 0.3

using namespace phistep;

namespace {

using One = Eigen::Matrix<double, 1, 1>;

/// r'' = −k sin(r/l)·l, in units of 2^length and 2^time
shared_force::OfState<One> pendulum(int length, int time) {
  const double l = std::ldexp(1.0, length), k = std::ldexp(2.0, -2 * time);
  return [=](const One& r) -> One { return One{-k * l * std::sin(r[0] / l)}; };
}

}  // namespace

TEST_CASE("a run taken up again anywhere ends in the bits of the unbroken one") {
  const tolerance control{.rtol = 1e-7, .atol = 1e-9};
  const Motion<One> start{One{1}, One{0.5}};
  auto y = start;
  PhiStepper stepper{y, pendulum(0, 0), extrapolated(backward_euler)};
  Run run{stepper, y, {0.0, 6.0}, control};
  std::vector<std::string> saved{restart::bytes(run)};
  while (run.advance()) saved.push_back(restart::bytes(run));
  REQUIRE(run.report());
  const std::string end = restart::bytes(run);
  for (std::size_t k = 0; k + 1 < saved.size(); k += 3) {
    auto again = start;
    PhiStepper fresh{again, pendulum(0, 0), extrapolated(backward_euler)};
    Run rest{fresh, again, {0.0, 6.0}, control};
    std::istringstream in(saved[k]);
    load_checkpoint(in, rest);
    while (rest.advance()) {
    }
    REQUIRE(rest.report());
    CHECK((restart::bytes(rest) == end));
  }
}

TEST_CASE("units of length and time that are powers of two change no bit") {
  const auto run = [](int length, int time) {
    Motion<One> y{One{std::ldexp(1.0, length)}, One{std::ldexp(0.5, length - time)}};
    PhiStepper stepper{y, pendulum(length, time), extrapolated(backward_euler)};
    const double atol = std::ldexp(1e-9, length);
    const tolerance control{.rtol = 1e-8, .atol = {atol, std::ldexp(atol, -time)}};
    Run all{stepper, y, {0.0, std::ldexp(5.0, time)}, control};
    while (all.advance()) {
    }
    REQUIRE(all.report());
    return std::pair{std::ldexp(y.r[0], -length), std::ldexp(y.v[0], time - length)};
  };
  for (const auto& [length, time] : {std::pair{20, 0}, {0, -31}, {-40, 17}}) {
    CAPTURE(length, time);
    CHECK(run(length, time) == run(0, 0));
  }
}
