// Controlled runs of other scalars and states, restarted anywhere. In short: restart_run.test.cpp.
#include <phistep/phistep.hpp>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "contract/restart_run.hpp"
#include "contract/restart_run_cases.hpp"
#include "contract/states.hpp"
#include "problems/hires.hpp"
#include "problems/van_der_pol.hpp"
#include "support/catch.hpp"

using namespace phistep;
using restart_run::check;
using namespace restart_run;

TEST_CASE("other scalars, borrowed states, forces with memory, halving") {
  const auto single = [] { return Eigen::VectorXf(positive().cast<float>()); };
  const auto gentle = [](const Eigen::VectorXf& y) -> Eigen::VectorXf { return -2 * y; };
  check(single, steps(gentle, tr_bdf2), 1, tolerance{.rtol = 1e-2});
  const auto wide = [] { return Eigen::Vector<long double, 3>(positive().cast<long double>()); };
  const auto wide_decay = [](const Eigen::Vector<long double, 3>& y) -> Eigen::Vector<long double, 3> {
    return -2 * y - y.cwiseProduct(y);
  };
  check(wide, steps(wide_decay, trapezoidal), 1, tolerance{.rtol = 1e-5});
  std::vector<std::unique_ptr<states::Home<states::Mapped>>> homes;
  const auto mapped = [&homes] {
    homes.push_back(std::make_unique<states::Home<states::Mapped>>());
    return homes.back()->block(states::positions);
  };
  check(mapped, steps([](const Vec& y) -> Vec { return -2 * y; }, tr_bdf2), 1, tolerance{});
  check(pair, steps(Slider{}, tr_bdf2), 2, tolerance{.rtol = 1e-3});
  check(pair, steps(Slider{}, velocity_verlet), 2, tolerance{.rtol = 1e-3});
  check(
      positive,
      [](auto& y) {
        return Halving{PhiStepper{y, decay, trapezoidal}, 3};
      },
      1, fixed(0.05));
}
