#include <phistep/run/errors/step_filter.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace {

constexpr std::array filters{StepFilter::PI42, StepFilter::H211b};

double limited(double rho) { return std::max(0.2, 1 + std::atan(rho - 1)); }

/// Lengths of the steps of a run whose steps err by c(n) h^k, 1 being allowed.
std::vector<double> run(StepFilter filter, int k, double dead_band, double h, int steps, auto&& c) {
  StepSize size{filter, k, dead_band};
  std::vector<double> lengths;
  for (int n = 0; static_cast<int>(lengths.size()) < steps; ++n) {
    REQUIRE(n < 10 * steps);  // rejections may not go on for ever
    const double error = c(static_cast<int>(lengths.size())) * std::pow(h, k);
    if (error > 1) {
      h *= size.rejected(error);
      continue;
    }
    lengths.push_back(h);
    h *= size.accepted(error);
  }
  return lengths;
}

}  // namespace

TEST_CASE("the filters are their formulas") {
  // Söderlind 2003, table III, with ε = 0.8/‖e‖ (0.8: the margin) and k = 3.
  const double k = 3;
  const std::array errors{0.5, 0.7, 0.3, 0.9, 0.6};
  const auto eps = [&](int n) { return 0.8 / errors[static_cast<std::size_t>(n)]; };
  const auto check = [&](StepFilter filter, int first, auto&& formula) {
    StepSize size{filter, 3, 1};
    double before = 1;
    for (int n = 0; n < 5; ++n) {
      const double got = size.accepted(errors[static_cast<std::size_t>(n)]);
      const double expected = limited(n < first ? std::pow(eps(n), 1 / k) : formula(n, before));
      CHECK(got == Approx(expected).epsilon(1e-14));
      before = got;
    }
  };
  check(StepFilter::PI42, 1,
        [&](int n, double) { return std::pow(eps(n), 3 / (5 * k)) * std::pow(eps(n - 1), -1 / (5 * k)); });
  check(StepFilter::H211b, 1, [&](int n, double before) {
    return std::pow(eps(n), 1 / (4 * k)) * std::pow(eps(n - 1), 1 / (4 * k)) * std::pow(before, -0.25);
  });
}

TEST_CASE("an error that goes as h^k brings every filter to rest, from above and from below") {
  for (const auto filter : filters)
    for (const int k : {2, 3})
      for (const double start : {1e-4, 0.03, 3.0}) {
        CAPTURE(static_cast<int>(filter), k, start);
        const double c = 700, rest = std::pow(0.8 / c, 1.0 / k);
        const auto h = run(filter, k, 1, start, 400, [&](int) { return c; });
        CHECK(h.back() == Approx(rest).epsilon(1e-8));
        for (std::size_t n = h.size() - 100; n < h.size(); ++n) CHECK(h[n] == Approx(rest).epsilon(1e-6));
      }
}

TEST_CASE("a slowly varying error is followed without oscillation or rejections") {
  for (const auto filter : filters)
    for (const int k : {2, 3}) {
      CAPTURE(static_cast<int>(filter), k);
      // c grows and falls by 1e3 within 600 steps: by 1.2 % a step at most.
      const auto c = [](int n) { return 100 * std::pow(10, 1.5 * std::sin(n / 190.0)); };
      const auto h = run(filter, k, 1, std::pow(0.8 / 100, 1.0 / k), 2400, c);
      int turns = 0;
      for (std::size_t n = 600; n + 2 < h.size(); ++n) turns += (h[n + 1] - h[n]) * (h[n + 2] - h[n + 1]) < 0;
      CHECK(turns <= 4);  // those of c alone: at n/190 = 3.5π/2·…, 1800 steps hold 3.02 half periods
      for (std::size_t n = 600; n < h.size(); ++n) {
        const double error = c(static_cast<int>(n)) * std::pow(h[n], k);
        CHECK(error <= 1);
        CHECK(error >= 0.4);
      }
    }
}

TEST_CASE("a random error of 20 % is passed on smaller than it came, by the calm filters") {
  const auto roughness = [](const std::vector<double>& h) {
    double sum = 0;
    for (std::size_t n = 1000; n + 1 < h.size(); ++n) sum += std::pow(std::log(h[n + 1] / h[n]), 2);
    return std::sqrt(sum / static_cast<double>(h.size() - 1001));
  };
  const auto noise = [] {
    return [seed = std::uint64_t{12345}](int) mutable {
      seed = seed * 6364136223846793005u + 1442695040888963407u;
      return 100 * std::exp(0.2 * (static_cast<double>(seed >> 11) / 9007199254740992.0 - 0.5));
    };
  };
  // Spectra of Söderlind 2003, fig. 3: Δt ← Δt ε^{1/k} passes all of it on, H211b a fraction.
  std::vector<double> direct{0.2};
  for (auto c = noise(); direct.size() < 4000;) {
    const double h = direct.back();
    direct.push_back(h * limited(std::cbrt(0.8 / (c(0) * std::pow(h, 3)))));
  }
  const double all = roughness(direct);
  CHECK(roughness(run(StepFilter::PI42, 3, 1, 0.2, 4000, noise())) < 0.8 * all);
  CHECK(roughness(run(StepFilter::H211b, 3, 1, 0.2, 4000, noise())) < 0.3 * all);
}

TEST_CASE("within the dead band a growth keeps the length, to the bit") {
  StepSize size{StepFilter::PI42, 3, 1.2};
  for (const double error : {0.8, 0.75, 0.7, 0.62, 0.6, 0.55}) CHECK(size.accepted(error) == 1.0);
  CHECK(size.accepted(0.2) > 1.2);
  StepSize other{StepFilter::PI42, 3, 1.2};
  CHECK(other.accepted(0.99) < 1);  // it never keeps a length that is too large
  // In a closed loop: once there, no bit moves, though the error wanders by 20 %.
  const auto h = run(StepFilter::PI42, 3, 1.2, 1e-3, 200, [](int n) { return 400 * (1 + 0.1 * std::sin(n)); });
  for (std::size_t n = 100; n + 1 < h.size(); ++n) CHECK(h[n + 1] == h[n]);
}

TEST_CASE("growth is limited smoothly, whatever the error") {
  for (const auto filter : filters) {
    StepSize size{filter, 2, 1};
    for (const double error : {0.0, 1e-300, 1e-10, 0.0}) {
      const double ratio = size.accepted(error);
      CHECK(ratio > 1);
      CHECK(ratio <= 1 + std::acos(-1.0) / 2);
    }
  }
}

TEST_CASE("a rejection shrinks by 0.2 to 0.9, and the step after it does not grow") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const auto filter : filters) {
    StepSize size{filter, 3, 1};
    CHECK(size.accepted(0.5) > 1);
    CHECK(size.rejected(2) == Approx(std::cbrt(0.4)));
    CHECK(size.rejected(1.0001) == 0.9);
    CHECK(size.rejected(1e9) == 0.2);
    CHECK(size.rejected(nan) == 0.2);
    CHECK(size.rejected(inf) == 0.2);
    CHECK(size.accepted(0.01) == 1.0);
    CHECK(size.accepted(0.01) > 1.0);  // … but the one after that does
  }
}

TEST_CASE("after forget() the past counts no more") {
  for (const auto filter : filters) {
    StepSize old{filter, 3, 1}, fresh{filter, 3, 1};
    for (const double error : {0.9, 0.1, 0.4}) static_cast<void>(old.accepted(error));
    old.forget();
    for (const double error : {0.5, 0.6, 0.3, 0.7}) CHECK(old.accepted(error) == fresh.accepted(error));
  }
}
