// Programs whose handlers switch something, as users write them, each with its right answer: closed forms, or bisection of
// one.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "support/catch.hpp"
#include "support/shared_force.hpp"

using namespace phistep;

namespace {

using Two = Eigen::Vector2d;
using Rate = shared_force::OfStateAndTime<Two>;

/// f(scheme) for one explicit and one implicit scheme.
void with_schemes(const auto& f) {
  f("tsit5", tsit5);
  f("radau", radau);
}

}  // namespace

TEST_CASE("a narrow window between two levels: its opening is seen, whatever the step") {
  with_schemes([](const char* name, auto scheme) {
    CAPTURE(name);
    Two y{0, 0};
    PhiStepper stepper{y, Rate{[](const Two&, double) -> Two { return {0.4, 0}; }}, scheme};
    std::vector<double> seen;
    auto window = event([](const Two& c) { return (c[0] - 0.18) * (0.19 - c[0]); }, {},
                        [&](double t, Two&) { seen.push_back(t); });
    REQUIRE(integrate(stepper, y, {0, 1}, tolerance{.rtol = 1e-6}, window));
    REQUIRE(seen.size() == 2);
    CHECK(seen[0] == Approx(0.45).epsilon(1e-12));
    CHECK(seen[1] == Approx(0.475).epsilon(1e-12));
  });
}

namespace {
/// At t = 5 a handler sets y from −1 to 1; two more events lie at y = 0 and y = 1/2, on the way up.
struct Carried {
  int set = 0, at_zero = 0, at_half = 0;
  double worst = 0;  ///< [time] of the others from t = 5
};
Carried carry(auto scheme) {
  Carried count;
  Two y{-1, 0};
  PhiStepper stepper{y, Rate{[](const Two&, double) -> Two { return {0, 0}; }}, scheme};
  const auto note = [&](int& what) {
    return [&](double t, Two&) {
      ++what;
      count.worst = std::max(count.worst, std::abs(t - 5));
    };
  };
  auto sets = event([](double t, const Two&) { return t - 5; }, {}, [&](double, Two& u) { u[0] = 1, ++count.set; });
  auto zero = event([](const Two& u) { return u[0]; }, {.direction = Direction::rising}, note(count.at_zero));
  auto half = event([](const Two& u) { return u[0] - 0.5; }, {.direction = Direction::rising}, note(count.at_half));
  REQUIRE(integrate(stepper, y, {0, 10}, tolerance{.rtol = 1e-6}, sets, zero, half));
  REQUIRE(y[0] == 1);
  return count;
}
}  // namespace
TEST_CASE("a handler that sets the state is called once, and no event happens but with it") {
  const Carried count = carry(tsit5);
  CHECK(count.set == 1);
  CHECK(count.worst <= 1e-12);
}
// What a handler changes is no event: it knows what it did (docs/output.md).
TEST_CASE("a handler that sets the state beyond other events' zeros calls none of theirs") {
  const Carried count = carry(tsit5);
  CHECK(std::pair{count.at_zero, count.at_half} == std::pair{0, 0});
}

TEST_CASE("a ball from 50 m and 5 m for 500 s: all bounces, no loss of energy") {
  with_schemes([](const char* name, auto scheme) {
    for (const double h : {50.0, 5.0}) {
      CAPTURE(name, h);
      Two y{h, 0};
      PhiStepper stepper{y, Rate{[](const Two& u, double) -> Two { return {u[1], -9.8}; }}, scheme};
      int bounces = 0;
      double lowest = 0;
      auto floor = event([](const Two& u) { return u[0]; }, {.direction = Direction::falling},
                         [&](double, Two& u) { u[1] = -u[1], ++bounces; });
      const auto look = [&](double, const Two& u) { lowest = std::min(lowest, u[0]); };
      REQUIRE(integrate(stepper, y, {0, 500}, tolerance{.rtol = 1e-6}, floor, look));
      const double drop = std::sqrt(2 * h / 9.8);
      CHECK(bounces == 1 + static_cast<int>((500 - drop) / (2 * drop)));
      CHECK(lowest >= -1e-9);
      CHECK((y[1] * y[1] / 2 + 9.8 * y[0]) / (9.8 * h) == Approx(1).epsilon(1e-9));
    }
  });
}

namespace {
/// Two neurons that inhibit each other: u' = X − u + Σ g (t − t_k) exp(−(t − t_k)) over the other's spikes; u = 1 is a spike
/// and sets u to 0.
struct Neurons {
  static constexpr double g = -0.4, drive = 1.3, end = 200;
  using Spikes = std::array<std::vector<double>, 2>;

  static double kick(double t, const std::vector<double>& spikes) {
    double sum = 0;
    for (const double e : spikes)
      if (t >= e && t - e < 60) sum += g * (t - e) * std::exp(-(t - e));
    return sum;
  }
  /// By the closed form between two spikes, and bisection.
  static Spikes exact() {
    Spikes spikes;
    double t = 0;
    std::array<double, 2> u{0, 0.001};
    const auto value = [&](std::size_t i, double s) {
      double v = drive + (u[i] - drive) * std::exp(-s);
      for (const double e : spikes[1 - i]) {
        const double age = t - e;
        if (age < 60) v += g * std::exp(-(s + age)) * (age * s + s * s / 2);
      }
      return v;
    };
    while (t < end) {
      double next = end - t;
      std::size_t who = 2;
      for (std::size_t i = 0; i < 2; ++i)
        for (double s = 0; s < next; s += 1e-3) {
          double low = s, high = std::min(s + 1e-3, next);
          if (value(i, high) < 1) continue;
          for (int k = 0; k < 60; ++k) {
            const double middle = (low + high) / 2;
            (value(i, middle) >= 1 ? high : low) = middle;
          }
          if (high < next) {
            next = high;
            who = i;
          }
          break;
        }
      u = {value(0, next), value(1, next)};
      t += next;
      if (who == 2) break;
      u[who] = 0;
      spikes[who].push_back(t);
    }
    return spikes;
  }
};
}  // namespace
TEST_CASE("two neurons that inhibit each other: all spikes, each at its time") {
  const Neurons::Spikes exact = Neurons::exact();
  REQUIRE(exact[0].size() > 20);
  with_schemes([&](const char* name, auto scheme) {
    CAPTURE(name);
    Neurons::Spikes spikes;
    Two y{0, 0.001};
    const Rate rate{[&](const Two& u, double t) -> Two {
      return {Neurons::drive - u[0] + Neurons::kick(t, spikes[1]), Neurons::drive - u[1] + Neurons::kick(t, spikes[0])};
    }};
    PhiStepper stepper{y, rate, scheme};
    const auto neuron = [&](int i) {
      return event([i](const Two& u) { return u[i] - 1; }, {.direction = Direction::rising},
                   [&spikes, i](double t, Two& u) {
                     u[i] = 0;
                     spikes[static_cast<std::size_t>(i)].push_back(t);
                   });
    };
    auto first = neuron(0), second = neuron(1);
    REQUIRE(integrate(stepper, y, {0, Neurons::end}, tolerance{.rtol = 1e-8}, second, first));
    for (std::size_t i = 0; i < 2; ++i) {
      REQUIRE(spikes[i].size() == exact[i].size());
      for (std::size_t k = 0; k < exact[i].size(); ++k) REQUIRE(std::abs(spikes[i][k] - exact[i][k]) <= 1e-4);
    }
  });
}

TEST_CASE("a tank that empties at a steady rate ends the run at t = 100, a parachute on the ground") {
  with_schemes([](const char* name, auto scheme) {
    CAPTURE(name);
    const auto landing = [&](Two y, const Rate& rate, double t1) {
      PhiStepper stepper{y, rate, scheme};
      auto ground = event([](const Two& u) { return u[0]; }, EventOptions{.terminal = true});
      const RunReport report = integrate(stepper, y, {0, t1}, tolerance{.rtol = 1e-6}, ground);
      CHECK(report.outcome == Outcome::stopped_by_event);
      CHECK(std::abs(y[0]) <= 1e-9);
      return report.t;
    };
    CHECK(landing(
              {1, 0},
              [](const Two&, double) -> Two {
                return {-0.01, 0};
              },
              200) == Approx(100).epsilon(1e-12));
    // y'' = −10 + 0.01 v² from 1000 m at rest
    const double limit = std::sqrt(1000.0), exact = limit / 10 * std::acosh(std::exp(1000 * 10 / (limit * limit)));
    const double t = landing(
        {1000, 0},
        [](const Two& u, double) -> Two {
          return {u[1], -10 + 0.01 * u[1] * u[1]};
        },
        40);
    CHECK(t == Approx(exact).epsilon(1e-5));
  });
}
