// A force with memory: its history is a value beside the state, and only an accepted step changes it.
#include <phistep/phistep.hpp>

#include <cmath>
#include <stdexcept>
#include <tuple>

#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using states::Dynamic;

namespace memory_cases {

/// A slider: it pulls back to an anchor that follows once the stretch exceeds `slip`.
struct Slider : ForceTerm {
  struct Memory {
    Dynamic anchor;
    double begun_at = -1, begun_dt = 0;
    int begins = 0, commits = 0;
  };
  double k = 30, slip = 0.2, poison = HUGE_VAL;  // |r| beyond `poison` gives NaN
  bool armed = false;                            // to throw at the end of a step
  static constexpr bool uses_velocity = false, uses_time = false;

  void begin(double t, double dt, const auto& y, Memory& m) const {
    if (m.anchor.size() == 0) m.anchor = y.r;
    m.begun_at = t, m.begun_dt = dt, ++m.begins;
  }
  void add(double, const auto& y, const Memory& m, auto& out) const {
    out.force -= k * (y.r - m.anchor);
    if (y.r.cwiseAbs().maxCoeff() > poison) out.force[0] = std::nan("");
  }
  void commit(double, const auto& y, Memory& m) const {
    for (Eigen::Index i = 0; i < y.r.size(); ++i) m.anchor[i] = std::clamp(m.anchor[i], y.r[i] - slip, y.r[i] + slip);
    ++m.commits;
    if (armed) throw std::runtime_error("commit");
  }
};

using Vec = Eigen::Vector2d;
inline Motion<Vec> start() { return {Vec(0.1, 0.1), Vec(1.0, -2.0)}; }

/// After five steps.
inline void check_fifth(const char* name, const Slider::Memory& memory) {
  CAPTURE(name);
  CHECK(memory.begins == 5);
  CHECK(memory.commits == 5);
  CHECK(memory.begun_at == 0.4);
  CHECK(memory.begun_dt == 0.1);
}
inline void for_each_quick_scheme(auto&& f) { f("trapezoidal", trapezoidal), f("velocity_verlet", velocity_verlet); }
inline bool same(const Slider::Memory& a, const Slider::Memory& b) {
  return a.anchor == b.anchor && a.begins == b.begins && a.commits == b.commits && a.begun_at == b.begun_at;
}

inline const auto begin_and_commit_once = [](const char* name, auto scheme) {
  auto y = start();
  PhiStepper stepper{y, Slider{}, scheme};
  REQUIRE(stepper.memory().commits == 0);
  for (int n = 0; n < 5; ++n) REQUIRE(stepper.step(y, 0.1 * n, 0.1));
  check_fifth(name, stepper.memory());
};

inline const auto fail_and_keep = [](const char* name, auto scheme) {
  auto y = start();
  PhiStepper stepper{y, Slider{}, scheme};
  REQUIRE(stepper.step(y, 0, 0.1));
  const Slider::Memory before = stepper.memory();
  y.v[1] = 1e3;
  stepper.force().poison = 0.01;  // the start is out of bounds already
  CAPTURE(name);
  CHECK_FALSE(stepper.step(y, 0.1, 0.1));
  CHECK(same(stepper.memory(), before));
  CHECK_FALSE(stepper.step(y, 0.1, std::nan("")));
  CHECK(same(stepper.memory(), before));
};

void check_exception(auto scheme) {
  auto y = start();
  PhiStepper stepper{y, Slider{}, scheme};
  REQUIRE(stepper.step(y, 0, 0.1));
  const Slider::Memory before = stepper.memory();
  const Motion<Vec> kept = y;
  stepper.force().armed = true;
  CHECK_THROWS_AS(stepper.step(y, 0.1, 0.1), std::runtime_error);
  CHECK(same(stepper.memory(), before));
  CHECK((y.r == kept.r && y.v == kept.v));
}

void check_sum(auto scheme) {
  auto y = start();
  PhiStepper stepper{y, Slider{} + LinearDrag{0.1} + Slider{}, scheme};
  for (int n = 0; n < 3; ++n) REQUIRE(stepper.step(y, 0, 0.2));
  const auto& [first, none, second] = stepper.memory();
  CHECK(same(first, second));
  CHECK(first.commits == 3);
  static_assert(std::is_same_v<std::remove_cvref_t<decltype(none)>, NoMemory>);
}

}  // namespace memory_cases

using namespace memory_cases;

#if PHISTEP_QUICK

TEST_CASE("one begin and one commit a step, whatever the scheme iterates") {
  for_each_quick_scheme(begin_and_commit_once);
}

TEST_CASE("commit sees the accepted state") {
  auto y = start();
  PhiStepper stepper{y, Slider{}, trapezoidal};
  const Dynamic anchor = y.r;
  REQUIRE(stepper.step(y, 0, 0.3));
  for (Eigen::Index i = 0; i < 2; ++i)
    CHECK(stepper.memory().anchor[i] == std::clamp(anchor[i], y.r[i] - 0.2, y.r[i] + 0.2));
  CHECK((stepper.memory().anchor != anchor));  // it slipped
}

TEST_CASE("a failed step leaves the history") { for_each_quick_scheme(fail_and_keep); }

TEST_CASE("an exception leaves the history") { check_exception(velocity_verlet); }

TEST_CASE("history set by value makes a rejected step as if it never was") {
  // An implicit stepper may solve with another Jacobian afterwards, which moves the last bit.
  const auto check = [](auto scheme, double tolerance) {
    auto y = start(), z = start();
    PhiStepper stepper{y, Slider{}, scheme}, never{z, Slider{}, scheme};
    REQUIRE(stepper.step(y, 0, 0.1));
    REQUIRE(never.step(z, 0, 0.1));
    const Slider::Memory checkpoint = stepper.memory();
    const Motion<Vec> kept = y;
    REQUIRE(stepper.step(y, 0.1, 0.4));  // an outer stepper tries, and rejects
    CHECK_FALSE(same(stepper.memory(), checkpoint));
    y = kept;
    stepper.set_memory(checkpoint);
    REQUIRE(stepper.step(y, 0.1, 0.1));
    REQUIRE(never.step(z, 0.1, 0.1));
    CHECK(states::distance(states::numbers(y), states::numbers(z)) <= tolerance);
    CHECK(states::distance(stepper.memory().anchor, never.memory().anchor) <= tolerance);
    CHECK(stepper.memory().commits == never.memory().commits);
  };
  check(velocity_verlet, 0);
  check(trapezoidal, 1e-15);
}

TEST_CASE("a copied stepper has a history of its own") {
  auto y = start();
  PhiStepper stepper{y, Slider{}, velocity_verlet};
  REQUIRE(stepper.step(y, 0, 0.1));
  auto copy = stepper;
  auto z = y;
  REQUIRE(copy.step(z, 0.1, 0.3));
  CHECK(copy.memory().commits == 2);
  CHECK(stepper.memory().commits == 1);
  CHECK((stepper.memory().anchor != copy.memory().anchor));
}

TEST_CASE("in a sum each term keeps its own history") { check_sum(forward_euler); }

TEST_CASE("a force without memory remembers nothing") {
  static_assert(!remembers<LinearDrag> && remembers<Slider>);
  static_assert(remembers<Sum<LinearDrag, Slider>> && !remembers<Sum<LinearDrag, Term<states::Pull>>>);
  static_assert(remembers<std::reference_wrapper<Slider>> && remembers<Term<Slider>>);
}

#elif PHISTEP_FULL

TEST_CASE("one begin and one commit a step, whatever the scheme iterates") {
  states::for_each_motion_scheme(begin_and_commit_once);
}

TEST_CASE("a failed step leaves the history") { states::for_each_motion_scheme(fail_and_keep); }

TEST_CASE("an exception leaves the history") { check_exception(backward_euler); }

TEST_CASE("two runs from the same state and history agree to the bit") {
  const auto run = [] {
    auto y = start();
    PhiStepper stepper{y, Slider{} + LinearDrag{0.1}, velocity_verlet};
    for (int n = 0; n < 50; ++n) REQUIRE(stepper.step(y, 0.05 * n, 0.05));
    return y;
  };
  const auto a = run(), b = run();
  CHECK((a.r == b.r && a.v == b.v));
}

TEST_CASE("in a sum each term keeps its own history") { check_sum(trapezoidal); }

#endif
