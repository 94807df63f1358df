// The rate of the fastest mode, and whether it decays or turns: of matrices whose eigenvalues are known.
#include <phistep/run/choice/spectral_radius.hpp>

#include <cmath>
#include <limits>

#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;

namespace {

const Vec y = Vec::LinSpaced(2, 1, 2), weight = Vec::Constant(2, 1e6);
double estimate(SpectralRadius<Vec>& radius, const Mat& A, int pairs = 40) {
  return radius([&A](double, const Vec& x, Vec& out) { return (out = A * x).allFinite(); }, 0.0, y, weight, 1e-6,
                pairs);
}
const Mat turning = (Mat(2, 2) << 0, 7, -7, 0).finished(), decaying = (Mat(2, 2) << -3, 1, 1, -2).finished();

}  // namespace

TEST_CASE("a decay and an oscillation are told apart, with their rates") {
  SpectralRadius<Vec> radius{y};
  CHECK(std::abs(estimate(radius, turning) - 7) <= 1e-5);
  CHECK(radius.turn() <= -1 + 1e-5);
  const double fastest = (5 + std::sqrt(5.0)) / 2;
  CHECK(std::abs(estimate(radius, decaying) - fastest) <= 1e-5);
  CHECK(radius.turn() >= 1 - 1e-5);
}

TEST_CASE("an estimate that ends early tells nothing of the one before") {
  for (const Mat& A : {Mat(Mat::Zero(2, 2)), Mat(Mat::Constant(2, 2, std::numeric_limits<double>::quiet_NaN()))}) {
    SpectralRadius<Vec> radius{y};
    REQUIRE(estimate(radius, turning) > 1);
    REQUIRE(radius.turn() < -0.9);
    CHECK(estimate(radius, A) == 0);
    CHECK(radius.turn() == 1);
  }
}

TEST_CASE("a trifling estimate is not refined, and one fast mode among many is not trifling") {
  constexpr Eigen::Index n = 10000;
  const Vec at = Vec::LinSpaced(n, 1, 2), equal = Vec::Constant(n, 1e6);
  for (const Eigen::Index fast : {Eigen::Index{0}, n / 3, n - 1}) {
    int calls = 0;
    double rate = 0;  // of that mode; of the others 1
    const auto slope = [&](double, const Vec& x, Vec& out) {
      ++calls;
      out = -x;
      out[fast] *= rate;
      return true;
    };
    const auto look = [&] { return SpectralRadius<Vec>{at}(slope, 0.0, at, equal, 1e-6, 2, 10); };
    rate = 1;
    CHECK(std::abs(look() - 1) <= 1e-5);
    CHECK(calls == 3);
    // Its share of a random direction is 1/100 or so, and two products see a tenth of its rate.
    rate = 1e6, calls = 0;
    CHECK(look() >= 0.9e6);
    CHECK(calls == 5);
  }
}
