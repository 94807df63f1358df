#pragma once

// How the error of controlled runs follows the tolerance: what both halves of accuracy/tolerance need.

#include <phistep/phistep.hpp>

#include <cmath>
#include <functional>
#include <string>
#include <type_traits>
#include <utility>

#include "problems/show_digits.hpp"
#include "problems/ten.hpp"
#include "support/catch.hpp"

namespace {

/// Slope of y over x, by least squares.
class Regression {
 public:
  void add(double x, double y) {
    n_ += 1;
    x_ += x;
    y_ += y;
    xx_ += x * x;
    xy_ += x * y;
  }
  [[nodiscard]] double slope() const { return (n_ * xy_ - x_ * y_) / (n_ * xx_ - x_ * x_); }

 private:
  double n_ = 0, x_ = 0, y_ = 0, xx_ = 0, xy_ = 0;
};

/// From rtol = 10^−coarsest to 10^−finest; the slope from 10^−straight on.
struct Range {
  int coarsest = 2, straight = 2, finest = 8;
  double least = 0.8, most = 1.1;
};

/// How a run ends, and its error. Checks stand outside of the template.
struct Ending {
  std::string trouble;
  double error;
};
[[maybe_unused]] void check_law(const std::string& name, const std::function<Ending(double rtol)>& run, double kappa,
                                const Range& range = {}) {
  Regression regression;
  for (int digits = range.coarsest; digits <= range.finest; ++digits) {
    const double rtol = std::pow(10.0, -digits);
    const auto [trouble, error] = run(rtol);
    CAPTURE(name, rtol, kappa, trouble);
    REQUIRE(trouble.empty());
    CHECK(error <= 10 * kappa * rtol);  // a hundred times that would be a wrong answer called a success
    if (digits >= range.straight) regression.add(std::log(rtol), std::log(error));
  }
  CAPTURE(name, regression.slope());
  CHECK(regression.slope() >= range.least);
  CHECK(regression.slope() <= range.most);
}
template <class Problem>
void check(const Problem& problem, const std::string& name, auto scheme, double kappa, const Range& range = {}) {
  check_law(
      name,
      [&](double rtol) {
        auto y = problem.start;
        phistep::PhiStepper stepper{y, problem.force, scheme};
        const auto report = phistep::integrate(stepper, y, {0, problem.end},
                                               phistep::tolerance{.rtol = rtol, .atol = rtol * problem.a});
        return Ending{report ? "" : "failed: " + report.message(), problems::relative_error(y, problem)};
      },
      kappa, range);
}

// Order 5 needs a dozen steps for few digits, too few for a law; and where it is a thousand times better than asked (heat,
// HIRES), errors of single steps cancel or don't: found there, slopes of 0.82 and 1.17, elsewhere 0.92 … 1.04.
constexpr Range high_order{1, 4, 11, 0.8, 1.2};

// All ten are too much for one compiler: five and five.
template <class Problem>
using ForceOf = std::remove_cvref_t<decltype(std::declval<Problem>().force)>;
template <class Problem>
constexpr bool is_chain = std::is_same_v<ForceOf<Problem>, problems::DrivenChain>;
template <class Problem>
constexpr bool is_stiff =
    std::is_same_v<ForceOf<Problem>, problems::Hires> || std::is_same_v<ForceOf<Problem>, problems::Robertson> ||
    std::is_same_v<ForceOf<Problem>, problems::Oregonator> ||
    std::is_same_v<ForceOf<Problem>, problems::Heat<Eigen::MatrixXd>>;
/// Prothero-Robinson, Brusselator, Kepler, the pendulum, Van der Pol.
template <class Problem>
constexpr bool is_of_first_five = !is_stiff<Problem> && !is_chain<Problem>;

}  // namespace
