// What docs/embedding.md says of forces, steppers and an existing program's own arrays. The products are in the full
// tier.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "support/catch.hpp"

namespace promises_cases {

using namespace phistep;
using Vec = Eigen::Vector3d;
using Y = Motion<Vec>;

inline const Y start{Vec{1, 0.5, -0.3}, Vec{0, 0.2, 0.1}};

[[nodiscard]] inline bool same(const Vec& a, const Vec& b) { return equal_bits(std::tie(a), std::tie(b)); }
[[nodiscard]] inline bool same(const Y& a, const Y& b) { return same(a.r, b.r) && same(a.v, b.v); }
[[nodiscard]] inline double distance(const Vec& a, const Vec& b) { return (a - b).cwiseAbs().maxCoeff(); }
[[nodiscard]] inline double distance(const Y& a, const Y& b) {
  return std::max(distance(a.r, b.r), distance(a.v, b.v));
}

/// What a force has been through, and what it is to do.
struct Diary {
  int calls = 0, not_finite = 0;
  int nan_from = -1, throw_at = -1;  // from which call on it returns NaN; at which it throws
};
struct Struck : std::runtime_error {
  Struck() : std::runtime_error("struck") {}
};

/// A nonlinear spring that couples all components.
struct Anchored {
  Diary* diary;
  Vec operator()(const Vec& r) const {
    ++diary->calls;
    diary->not_finite += r.allFinite() ? 0 : 1;
    if (diary->calls == diary->throw_at) throw Struck();
    if (diary->nan_from >= 0 && diary->calls >= diary->nan_from)
      return Vec::Constant(std::numeric_limits<double>::quiet_NaN());
    return -4 * r.array().sin() - 3 * r.array().cube() - 0.5 * (r[0] - r[1]);
  }
};
/// The same with friction.
struct Damped : Anchored {
  Vec operator()(const Vec& r, const Vec& v) const {
    if (!v.allFinite() && r.allFinite()) ++diary->not_finite;
    return Anchored::operator()(r) - (0.3 * v.array().cube()).matrix();
  }
};
/// The same with a force that swings.
struct Driven {
  static constexpr bool uses_velocity = false;
  Diary* diary;
  void add(double t, const auto& y, auto& out) const {
    out.force += Anchored{diary}(y.r);
    out.force.array() += std::sin(5 * t);
  }
};

/// Calls of the force in each of twelve steps; they agree with the statistics.
template <class F>
std::vector<int> calls_of_steps(auto scheme, const auto&... more) {
  Diary diary;
  Y y = start;
  PhiStepper stepper{y, F{&diary}, scheme, more...};
  std::vector<int> calls;
  for (int n = 0; n < 12; ++n) {
    const int before = diary.calls;
    REQUIRE(stepper.step(y, n * 0.0625, 0.0625));
    calls.push_back(diary.calls - before);
  }
  CHECK(stepper.statistics().force_calls + stepper.statistics().checks == diary.calls);
  return calls;
}
/// `first` in the first step, `later` in the other eleven.
[[nodiscard]] inline std::vector<int> steps_of(int first, int later) {
  std::vector<int> all(12, later);
  all[0] = first;
  return all;
}

struct Continued {
  int same_bits = 0;  ///< of 28 steps, those that end in the same bits
  double apart = 0;   ///< and how far apart the others end, at most
};
/// Twelve steps; then a program that goes on, beside one that makes a new stepper from r, v and t. `resets`: the first calls
/// reset() there.
template <class F>
Continued continued(double dt, int saved_after, bool resets, auto scheme, const auto&... more) {
  Diary diary;
  Y a = start;
  PhiStepper goes_on{a, F{&diary}, scheme, more...};
  for (int n = 0; n < saved_after; ++n) REQUIRE(goes_on.step(a, n * dt, dt));
  Y b = a;
  if (resets) goes_on.reset();
  PhiStepper restarted{b, F{&diary}, scheme, more...};
  Continued all;
  for (int n = saved_after; n < saved_after + 28; ++n) {
    REQUIRE((goes_on.step(a, n * dt, dt) && restarted.step(b, n * dt, dt)));
    all.same_bits += same(a, b) ? 1 : 0;
    all.apart = std::max(all.apart, distance(a, b));
  }
  return all;
}
template <class F = Anchored>
void check_same_bits(auto scheme, const auto&... more) {
  for (const double dt : {0.0625, 0.1}) CHECK(continued<F>(dt, 12, false, scheme, more...).same_bits == 28);
}
/// Rounding apart, and with reset() where the state is saved not even that.
template <class F = Anchored>
void check_rounding(auto scheme, const auto&... more) {
  int all = 0;
  for (const double dt : {0.0625, 0.1}) {
    const Continued plain = continued<F>(dt, 12, false, scheme, more...);
    CHECK(plain.apart < 2e-14);
    all += plain.same_bits;
    CHECK(continued<F>(dt, 12, true, scheme, more...).same_bits == 28);
  }
  CHECK(all < 56);
}

/// A fault in every call, and steps that overflow: what the force was called with, and whether the state kept its bits.
template <class F>
void check_never_called_with_nan(auto scheme, const auto&... more) {
  int failed_steps = 0, kept = 0, bad = 0;
  const auto step = [&](auto& stepper, Y& y, double t, double dt) {
    const Y before = y;
    if (stepper.step(y, t, dt)) return;
    ++failed_steps;
    kept += same(y, before) ? 1 : 0;
  };
  for (int at = 1; at <= 30; ++at) {
    Diary diary{.nan_from = at};
    Y y = start;
    PhiStepper stepper{y, F{&diary}, scheme, more...};
    for (int n = 0; n < 4; ++n) step(stepper, y, n * 0.1, 0.1);
    bad += diary.not_finite;
  }
  for (const double dt : {1e60, 1e150, 1e300}) {
    Diary diary;
    Y y = start;
    PhiStepper stepper{y, F{&diary}, scheme, more...};
    step(stepper, y, 0, dt);
    bad += diary.not_finite;
  }
  CHECK(bad == 0);
  CHECK(failed_steps > 5);
  CHECK(kept == failed_steps);
}

/// The same in runs under a tolerance.
template <class F>
void check_runs_never_call_with_nan(auto scheme, const auto&... more) {
  int failed_runs = 0, bad = 0;
  for (int at = 1; at <= 40; ++at) {
    Diary diary{.nan_from = at};
    Y y = start;
    PhiStepper stepper{y, F{&diary}, scheme, more...};
    failed_runs += integrate(stepper, y, {0, 5}, tolerance{.rtol = 1e-4, .atol = 1e-6}) ? 0 : 1;
    bad += diary.not_finite;
  }
  CHECK(bad == 0);
  CHECK(failed_runs == 40);
}

}  // namespace promises_cases

#if PHISTEP_QUICK

//
#include <array>
#include <functional>
#include <memory>
#include <thread>
#include <type_traits>
#include <utility>

using namespace promises_cases;

// ---- how a force is kept --------------------------------------------------------------------------------------------

namespace {

struct Elastic {
  double k;
  Vec operator()(const Vec& r) const { return -k * r; }
};

/// Where a stepper with the force it was given, one with std::ref and one moved end, when the original changes on the way.
template <class F>
Y five_steps(F force, auto scheme, auto change) {
  Y y = start;
  PhiStepper stepper{y, force, scheme};
  for (int n = 0; n < 5; ++n) {
    if (n == 2) change(stepper);
    REQUIRE(stepper.step(y, 0.1 * n, 0.1));
  }
  return y;
}

struct Counting {
  int *copies, *moves;
  Counting(int* c, int* m) : copies{c}, moves{m} {}
  Counting(const Counting& o) : copies{o.copies}, moves{o.moves} { ++*copies; }
  Counting(Counting&& o) noexcept : copies{o.copies}, moves{o.moves} { ++*moves; }
  Counting& operator=(const Counting& o) {
    ++*o.copies;
    return *this;
  }
  Counting& operator=(Counting&& o) noexcept {
    ++*o.moves;
    return *this;
  }
  ~Counting() = default;
  Vec operator()(const Vec& r) const { return -r; }
};

struct MoveOnly {
  std::unique_ptr<double> k;
  Vec operator()(const Vec& r) const { return -*k * r; }
};

}  // namespace

TEST_CASE("a force is stored by value: a change of the original changes nothing, with std::ref it does") {
  Elastic force{2};
  const auto nothing = [](auto&) {};
  const auto stiffen = [&force](auto&) { force.k = 5; };
  const Y as_it_was = five_steps(force, symplectic_euler, nothing);
  CHECK(same(five_steps(force, symplectic_euler, stiffen), as_it_was));
  force.k = 2;
  const Y by_reference = five_steps(std::ref(force), symplectic_euler, stiffen);
  CHECK(!same(by_reference, as_it_was));
  CHECK(same(by_reference, five_steps(Elastic{2}, symplectic_euler, [](auto& s) { s.force().k = 5; })));
}

TEST_CASE("Verlet remembers Psi: a force changed from outside counts from the next call on, with reset() at once") {
  Elastic force{2};
  const Y told = five_steps(Elastic{2}, velocity_verlet, [](auto& s) { s.force().k = 5; });
  const Y with_reset = five_steps(std::ref(force), velocity_verlet, [&](auto& s) { force.k = 5, s.reset(); });
  CHECK(same(with_reset, told));
  force.k = 2;
  CHECK(!same(five_steps(std::ref(force), velocity_verlet, [&](auto&) { force.k = 5; }), told));
}

TEST_CASE(
    "a force is copied once where it is given by name, never where it is moved or by std::ref, and never in a step") {
  int copies = 0, moves = 0;
  const auto counts = [&] { return std::pair{std::exchange(copies, 0), std::exchange(moves, 0)}; };
  Y y = start;
  Counting force{&copies, &moves};
  PhiStepper named{y, force, velocity_verlet};
  CHECK(counts() == std::pair{1, 4});
  PhiStepper referred{y, std::ref(force), velocity_verlet};
  CHECK(counts() == std::pair{0, 0});
  PhiStepper moved{y, std::move(force), velocity_verlet};
  CHECK(counts() == std::pair{0, 5});
  PhiStepper made{y, Counting{&copies, &moves}, velocity_verlet};
  CHECK(counts() == std::pair{0, 4});
  for (int n = 0; n < 5; ++n) REQUIRE(named.step(y, 0.1 * n, 0.1));
  CHECK(counts() == std::pair{0, 0});
  REQUIRE(integrate(named, y, {0, 1}, fixed(0.1), [](double, const Y&) {}));
  CHECK(counts() == std::pair{0, 0});
  [[maybe_unused]] const auto copy = named;
  CHECK(counts() == std::pair{1, 0});
  [[maybe_unused]] const auto other = std::move(made);
  CHECK(counts() == std::pair{0, 1});
}

TEST_CASE("a stepper can be moved, with a force that can only move, and copied where its force can be") {
  Y y = start, z = start;
  PhiStepper first{y, MoveOnly{std::make_unique<double>(3)}, velocity_verlet};
  using Movable = decltype(first);
  static_assert(std::is_move_constructible_v<Movable> && std::is_move_assignable_v<Movable>);
  static_assert(!std::is_copy_constructible_v<Movable>);
  PhiStepper stays{z, Elastic{3}, velocity_verlet};
  REQUIRE((first.step(y, 0, 0.1) && stays.step(z, 0, 0.1)));
  std::vector<Movable> members;
  members.push_back(std::move(first));
  auto copy = stays;
  Y x = z;
  for (int n = 1; n < 5; ++n) {
    REQUIRE((members[0].step(y, 0.1 * n, 0.1) && stays.step(z, 0.1 * n, 0.1) && copy.step(x, 0.1 * n, 0.1)));
    CHECK((same(y, z) && same(x, z)));
  }
}

// ---- what a force is called with, and how often -----------------------------------------------------------------------

namespace {

using Coordinates = Eigen::Map<Eigen::VectorXd>;

/// An existing program's arrays, and a routine that works on them.
struct Program {
  std::array<double, 3> x{1, 0.5, -0.3}, v{0, 0.2, 0.1}, f{};
  Motion<Coordinates> state{Coordinates{x.data(), 3}, Coordinates{v.data(), 3}};

  void compute_forces() {
    for (std::size_t i = 0; i < 3; ++i) f[i] = -4 * x[i];
  }
  [[nodiscard]] double energy() const {
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) sum += v[i] * v[i] / 2 + 2 * x[i] * x[i];
    return sum;
  }
};
/// Ψ of the argument.
const std::function<Eigen::VectorXd(const Eigen::VectorXd&)> honest = [](const Eigen::VectorXd& r) -> Eigen::VectorXd {
  return -4 * r;
};

/// 400 steps of Δt = 0.05: of a routine that reads the program's own arrays, and of one that reads its argument.
struct Trap {
  bool same_bits;
  double energy_of_one, energy_of_other, energy_at_start;  // of the one that reads the arrays, of the honest one
};
Trap read_in_place(auto scheme) {
  Program one, other;
  const std::function<Eigen::VectorXd(const Eigen::VectorXd&)> own_arrays = [&one](const Eigen::VectorXd&) {
    one.compute_forces();
    return Eigen::VectorXd(Coordinates{one.f.data(), 3});
  };
  Trap trap{true, 0, 0, one.energy()};
  PhiStepper a{one.state, own_arrays, scheme}, b{other.state, honest, scheme};
  for (int n = 0; n < 400; ++n) {
    REQUIRE((a.step(one.state, 0.05 * n, 0.05) && b.step(other.state, 0.05 * n, 0.05)));
    trap.same_bits = trap.same_bits && one.x == other.x && one.v == other.v;
  }
  trap.energy_of_one = one.energy(), trap.energy_of_other = other.energy();
  return trap;
}

}  // namespace

TEST_CASE("a force that reads the program's arrays in place is right with both Eulers, wrong with Verlet") {
  CHECK(read_in_place(symplectic_euler).same_bits);
  CHECK(read_in_place(forward_euler).same_bits);
  const Trap verlet = read_in_place(velocity_verlet);
  CHECK(!verlet.same_bits);
  CHECK(std::abs(verlet.energy_of_other / verlet.energy_at_start - 1) < 0.003);
  CHECK(verlet.energy_of_one > 2 * verlet.energy_at_start);  // silently: each step succeeded
}

TEST_CASE(
    "a force is called with memory of the stepper's; during the step the program's arrays hold the step's start") {
  Program program;
  const auto x0 = program.x, v0 = program.v;
  int calls = 0;
  const std::function<Eigen::VectorXd(const Eigen::VectorXd&)> watching = [&](const Eigen::VectorXd& r) {
    ++calls;
    CHECK(r.data() != program.x.data());
    CHECK((program.x == x0 && program.v == v0));
    return Eigen::VectorXd(-4 * r);
  };
  PhiStepper stepper{program.state, watching, velocity_verlet};
  REQUIRE(stepper.step(program.state, 0, 0.1));
  CHECK(calls == 2);
  CHECK((program.x != x0 && program.v != v0));
}

TEST_CASE("calls a step: one for the Eulers and Verlet, and one more in Verlet's first") {
  CHECK(calls_of_steps<Anchored>(symplectic_euler) == steps_of(1, 1));
  CHECK(calls_of_steps<Anchored>(velocity_verlet) == steps_of(2, 1));
}

TEST_CASE("Verlet calls anew for a state whose positions were edited, not for edited velocities") {
  Diary diary;
  Y y = start;
  PhiStepper stepper{y, Anchored{&diary}, velocity_verlet};
  const auto calls = [&] {
    const int before = diary.calls;
    REQUIRE(stepper.step(y, 0, 0.1));
    return diary.calls - before;
  };
  CHECK(calls() == 2);
  y.v *= 0.9;
  CHECK(calls() == 1);
  y.r[0] += 0.001;
  CHECK(calls() == 2);
}

namespace {
struct OneOfTwo : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = false;
  Diary* diary;
  explicit OneOfTwo(Diary* d) : diary{d} {}
  void add(double, const auto& y, auto& out) const { out.force += Anchored{diary}(y.r); }
};
}  // namespace

TEST_CASE(
    "the message of a failure calls a single force no more, each term of a sum at most twice, and counts neither") {
  Diary diary{.nan_from = 2};
  Y y = start;
  PhiStepper single{y, Anchored{&diary}, velocity_verlet};
  CHECK(!single.step(y, 0, 0.1));
  CHECK(diary.calls == 2);

  Diary good, bad{.nan_from = 2};
  PhiStepper sum{y, OneOfTwo{&good} + OneOfTwo{&bad}, velocity_verlet};
  const StepReport report = sum.step(y, 0, 0.1);
  CHECK(report.failure().term == 1);
  CHECK(sum.statistics().force_calls == 2);
  CHECK((2 < good.calls && good.calls <= 4));
  CHECK((2 < bad.calls && bad.calls <= 4));
}

// ---- failures ---------------------------------------------------------------------------------------------------------

TEST_CASE("an exception of the force passes through, the program's arrays keep every bit, the next step goes on") {
  Program program, never;
  int calls = 0, strike = 0;
  const std::function<Eigen::VectorXd(const Eigen::VectorXd&)> striking = [&](const Eigen::VectorXd& r) {
    if (++calls == strike) throw Struck();
    return Eigen::VectorXd(-4 * r);
  };
  PhiStepper stepper{program.state, striking, velocity_verlet}, other{never.state, honest, velocity_verlet};
  for (int n = 0; n < 6; ++n) {
    const auto x0 = program.x, v0 = program.v;
    strike = calls + 1;
    CHECK_THROWS_AS(stepper.step(program.state, 0.1 * n, 0.1), Struck);
    CHECK((program.x == x0 && program.v == v0));
    REQUIRE(stepper.step(program.state, 0.1 * n, 0.1));
    REQUIRE(other.step(never.state, 0.1 * n, 0.1));
    CHECK((program.x == never.x && program.v == never.v));
  }
}

namespace {
/// NaN of its own where |r| is past a bound: a state that has left the domain.
struct Walled : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = false;
  int* not_finite;
  double wall;
  Walled(int* bad, double w) : not_finite{bad}, wall{w} {}
  void add(double, const auto& y, auto& out) const {
    *not_finite += y.r.allFinite() ? 0 : 1;
    if (y.r[0] > wall) out.force[0] = std::numeric_limits<double>::quiet_NaN();
    else out.force -= y.r;
  }
};
}  // namespace

TEST_CASE(
    "no force is called with a state that isn't finite, for a failure's message neither, and no term blamed for it") {
  check_never_called_with_nan<Anchored>(velocity_verlet);
  int good = 0, bad = 0;
  Y y{Vec{0.5, 0, 0}, Vec{3, 0, 0}};
  // The third of six stages goes past the wall: the state there is NaN, whatever is asked.
  PhiStepper stepper{y, Walled{&good, 100} + Walled{&bad, 1}, srkn6b};
  const StepReport report = stepper.step(y, 0, 1.0);
  CHECK(report.outcome() == Outcome::non_finite_force);
  CHECK(report.failure().term != 0);
  CHECK((good == 0 && bad == 0));
}

// ---- checkpoints of the state alone, output, threads --------------------------------------------------------------------

TEST_CASE("from r, v and t alone: Euler and Verlet go on with the same bits, Newton's schemes to rounding") {
  check_same_bits(symplectic_euler);
  check_same_bits(velocity_verlet);
  check_rounding(midpoint);
}

TEST_CASE("from r, v and t alone, Verlet under a force that uses t: the same bits, but for the rounding of t") {
  // Ψ was evaluated at 5Δt + Δt, and is evaluated at 6Δt: of 0.1 these differ by a rounding, of 1/16 they don't.
  CHECK(continued<Driven>(0.0625, 6, false, velocity_verlet).same_bits == 28);
  const Continued tenths = continued<Driven>(0.1, 6, false, velocity_verlet);
  CHECK(tenths.same_bits < 28);
  CHECK(tenths.apart < 1e-14);
  CHECK(continued<Driven>(0.1, 6, true, velocity_verlet).same_bits == 28);
}

TEST_CASE("a loop by hand, integrate and Run with the program's own output between steps: the same bits") {
  Diary diary;
  Y a = start, b = start, c = start;
  PhiStepper by_hand{a, Anchored{&diary}, velocity_verlet}, whole{b, Anchored{&diary}, velocity_verlet},
      in_steps{c, Anchored{&diary}, velocity_verlet};
  std::vector<double> one, other, third;
  for (int n = 0; n < 20; ++n) {
    REQUIRE(by_hand.step(a, 0.1 * n, 0.1));
    one.push_back(a.r[0]);
  }
  REQUIRE(integrate(whole, b, {0, 2}, fixed(0.1), [&](double, const Y& y) { other.push_back(y.r[0]); }));
  Run run{in_steps, c, {0, 2}, fixed(0.1)};
  while (run.advance()) third.push_back(c.r[0]);
  REQUIRE(run.report());
  other.erase(other.begin(), other.end() - 20);  // an observer may also see the start
  CHECK(one == other);
  CHECK(one == third);
}

TEST_CASE("two steppers in two threads: the bits of one after the other") {
  struct Ends {
    Y verlet, newton;
  };
  const auto steps = [](Diary& diary) {
    Ends end{start, start};
    PhiStepper a{end.verlet, Anchored{&diary}, velocity_verlet};
    PhiStepper b{end.newton, Anchored{&diary}, midpoint};
    bool good = true;
    for (int n = 0; n < 2000; ++n)
      good = a.step(end.verlet, 0.01 * n, 0.01) && b.step(end.newton, 0.01 * n, 0.01) && good;
    return good ? end : Ends{};
  };
  Diary alone;
  const Ends expected = steps(alone);
  std::array<Ends, 2> found;
  std::array<Diary, 2> diaries;
  {
    std::array<std::thread, 2> threads;
    for (std::size_t k = 0; k < 2; ++k) threads[k] = std::thread([&, k] { found[k] = steps(diaries[k]); });
    for (auto& thread : threads) thread.join();
  }
  for (std::size_t k = 0; k < 2; ++k) {
    CHECK((same(found[k].verlet, expected.verlet) && same(found[k].newton, expected.newton)));
    CHECK(diaries[k].calls == alone.calls);
  }
}

#elif PHISTEP_FULL
// What docs/embedding.md says of each scheme: how often it calls the force, what goes on from r, v and t alone, and which
// schemes never call it with a state that isn't finite.

//
#include <phistep/io.hpp>
#include <phistep/krylov.hpp>

#include <sstream>

using namespace promises_cases;

TEST_CASE("calls a step: one for the Eulers and Verlet, and one more in Verlet's first") {
  CHECK(calls_of_steps<Anchored>(forward_euler) == steps_of(1, 1));
  CHECK(calls_of_steps<Anchored>(symplectic_euler) == steps_of(1, 1));
  CHECK(calls_of_steps<Anchored>(symplectic_euler_adjoint) == steps_of(1, 1));
  CHECK(calls_of_steps<Anchored>(velocity_verlet) == steps_of(2, 1));
  CHECK(calls_of_steps<Damped>(forward_euler) == steps_of(1, 1));
  CHECK(calls_of_steps<Damped>(symplectic_euler) == steps_of(1, 1));
  CHECK(calls_of_steps<Driven>(velocity_verlet) == steps_of(2, 1));
}

TEST_CASE(
    "a force that reads the state that the program steps, not its argument, is wrong with midpoint, and told on "
    "request") {
  Y y = start, right = start;
  const auto own = [&y](const Vec&) -> Vec { return -4 * y.r; };
  CHECK(!check_force(own, y).sees_state());
  PhiStepper stepper{y, own, midpoint, fixed_point()};
  PhiStepper other{right, [](const Vec& r) -> Vec { return -4 * r; }, midpoint, fixed_point()};
  const auto energy = [](const Y& at) { return at.v.squaredNorm() / 2 + 2 * at.r.squaredNorm(); };
  for (int n = 0; n < 400; ++n) REQUIRE((stepper.step(y, 0.05 * n, 0.05) && other.step(right, 0.05 * n, 0.05)));
  CHECK(energy(right) == Approx(energy(start)).epsilon(1e-12));
  CHECK(energy(y) > 1.5 * energy(start));
}

TEST_CASE("calls a step: compositions and Nystrom pairs") {
  CHECK(calls_of_steps<Anchored>(srkn6b) == steps_of(7, 6));
  CHECK(calls_of_steps<Anchored>(srkn11b) == steps_of(12, 11));
  CHECK(calls_of_steps<Anchored>(composed(velocity_verlet)) == steps_of(18, 17));
  CHECK(calls_of_steps<Anchored>(rkn86) == steps_of(9, 8));
  CHECK(calls_of_steps<Anchored>(tsit5) == steps_of(6, 6));
  CHECK(calls_of_steps<Anchored>(dop853) == steps_of(12, 12));
  CHECK(calls_of_steps<Anchored>(rkn1210) == steps_of(17, 17));
}

namespace {
/// A Jacobian that is right.
struct Pendulums {
  Diary* diary;
  Vec operator()(const Vec& r) const {
    ++diary->calls;
    return -r.array().sin();
  }
  [[nodiscard]] static Eigen::Matrix3d jacobian(const Vec& r) {
    return Eigen::Matrix3d((-r.array().cos()).matrix().asDiagonal());
  }
};
/// … that a force which swings comes with.
struct DrivenPendulums : Pendulums {
  Vec operator()(const Vec& r, const Vec&, double t) const { return Pendulums::operator()(r).array() + std::sin(t); }
  [[nodiscard]] static MotionJacobian<Eigen::Matrix3d> jacobian(const Vec& r, const Vec&, double) {
    return {Pendulums::jacobian(r), Eigen::Matrix3d::Zero()};
  }
};
}  // namespace

TEST_CASE(
    "calls a step: linear stages, with a Jacobian by three differences or supplied, and checked at 1, 2, 3, 4, 6") {
  CHECK(calls_of_steps<Anchored>(rodas4) == steps_of(6 + 3, 6 + 3));
  CHECK(calls_of_steps<Anchored>(rodas5p) == steps_of(8 + 3, 8 + 3));
  CHECK(calls_of_steps<Pendulums>(rodas4) == std::vector{7, 7, 7, 7, 6, 7, 6, 7, 6, 6, 6, 7});
  CHECK(calls_of_steps<Pendulums>(rodas5p) == std::vector{9, 9, 9, 9, 8, 9, 8, 9, 8, 8, 8, 9});
  CHECK(calls_of_steps<DrivenPendulums>(rodas4) == std::vector{9, 9, 9, 9, 8, 9, 8, 9, 8, 8, 8, 9});
}

TEST_CASE("calls a step: Newton's, one an iteration, three a Jacobian by differences; a supplied one is not checked") {
  const auto check = [](auto scheme, int before, auto force, int differences) {
    Diary diary;
    Y y = start;
    PhiStepper stepper{y, decltype(force){&diary}, scheme};
    for (int n = 0; n < 12; ++n) REQUIRE(stepper.step(y, 0.1 * n, 0.1));
    const Statistics s = stepper.statistics();
    CHECK(s.checks == 0);
    CHECK(diary.calls == 12 * before + s.iterations + differences * s.jacobians);
  };
  check(backward_euler, 0, Anchored{}, 3);
  check(midpoint, 0, Anchored{}, 3);
  check(trapezoidal, 1, Anchored{}, 3);
  check(backward_euler, 0, Pendulums{}, 0);
  check(midpoint, 0, Pendulums{}, 0);
}

namespace {
int calls_of_run(auto scheme, const auto& control, auto&&... observers) {
  Diary diary;
  Y y = start;
  PhiStepper stepper{y, Anchored{&diary}, scheme};
  const RunReport report = integrate(stepper, y, {0, 1}, control, observers...);
  REQUIRE(report);
  CHECK(report.statistics.force_calls == diary.calls);
  return diary.calls;
}
int calls_of_first_step(const auto& control) {
  Diary diary;
  Y y = start;
  PhiStepper stepper{y, Anchored{&diary}, rkn86};
  Run run{stepper, y, {0, 1}, control};
  REQUIRE(run.advance());
  return diary.calls;
}
}  // namespace

TEST_CASE(
    "calls of a run: two to find its first step; looks inside steps cost two a step, where the scheme leaves no "
    "slopes") {
  CHECK(calls_of_first_step(tolerance{.rtol = 1e-6, .first_step = 0.01}) == 9);
  CHECK(calls_of_first_step(tolerance{.rtol = 1e-6}) == 9 + 2);
  CHECK(calls_of_run(velocity_verlet, fixed(0.1)) == 11);
  CHECK(calls_of_run(velocity_verlet, fixed(0.1), [](double, const Y&) {}) == 11);
  CHECK(calls_of_run(velocity_verlet, fixed(0.1), sampled(0.03, [](double, const Y&) {})) == 11 + 20);
  auto never = event([](const Y& y) { return y.r[0] - 5; }, {}, [](double, Y&) {});
  CHECK(calls_of_run(velocity_verlet, fixed(0.1), never) == 11 + 20);
}

TEST_CASE(
    "a look inside of the steps of a scheme that solves or has a high order copies the stepper, and the force with "
    "it") {
  struct Copied : Anchored {
    int* copies;
    Copied(Diary* d, int* c) : Anchored{d}, copies{c} {}
    Copied(const Copied& o) : Anchored{o}, copies{o.copies} { ++*copies; }
    Copied& operator=(const Copied& o) {
      ++*o.copies;
      return *this;
    }
    Copied(Copied&&) noexcept = default;
    Copied& operator=(Copied&&) noexcept = default;
    ~Copied() = default;
  };
  Diary diary;
  int copies = 0;
  const auto run = [&](auto scheme, auto force) {
    Y y = start;
    PhiStepper stepper{y, force, scheme};
    const int before = copies;
    REQUIRE(integrate(stepper, y, {0, 1}, fixed(0.1), sampled(0.03, [](double, const Y&) {})));
    return copies - before;
  };
  Copied force{&diary, &copies};
  CHECK(run(velocity_verlet, force) == 0);
  CHECK(run(backward_euler, force) == 10);
  CHECK(run(rkn86, force) == 10);
  CHECK(run(backward_euler, std::ref(force)) == 0);
}

TEST_CASE("from r, v and t alone, with the same bits: schemes that iterate nothing from step to step") {
  check_same_bits(forward_euler);
  check_same_bits(symplectic_euler);
  check_same_bits(symplectic_euler_adjoint);
  check_same_bits(velocity_verlet);
  check_same_bits<Damped>(symplectic_euler);
  check_same_bits(srkn6b);
  check_same_bits(srkn11b);
  check_same_bits(composed(velocity_verlet));
  check_same_bits(rkn86);
  check_same_bits(rkn1210);
  check_same_bits(rodas4);
  check_same_bits(rodas5p);
  check_same_bits(radau);
}

TEST_CASE("from r, v and t alone, with the same bits: by fixed_point, without a matrix, by one correction") {
  check_same_bits(backward_euler, fixed_point());
  check_same_bits(midpoint, fixed_point());
  check_same_bits(trapezoidal, fixed_point());
  check_same_bits(phi(0.7), fixed_point());
  check_same_bits(backward_euler, newton<MatrixFree<>>());
  check_same_bits(backward_euler, linearly_implicit());
}

TEST_CASE(
    "from r, v and t alone, to rounding; with reset() where it is saved to the bit: Newton's schemes, and phi > 1/2") {
  check_rounding(backward_euler);
  check_rounding(midpoint);
  check_rounding(trapezoidal);
  check_rounding(phi(0.7));
  check_rounding(tr_bdf2);
}

TEST_CASE("from r, v and t alone, Rannacher's scheme begins anew with its two half steps: another solution") {
  CHECK(continued<Anchored>(0.0625, 12, false, rannacher).apart > 1e-4);
  CHECK(continued<Anchored>(0.0625, 12, true, rannacher).same_bits == 28);  // reset() begins anew, too
}

TEST_CASE("from r, v and t alone, a run under a tolerance ends elsewhere, within it; save_checkpoint keeps its bits") {
  const auto check = [](auto scheme, double apart) {
    const tolerance control{.rtol = 1e-6, .atol = 1e-9};
    Diary diary;
    Y a = start;
    PhiStepper goes_on{a, Anchored{&diary}, scheme};
    Run run{goes_on, a, {0, 10}, control};
    for (int k = 0; k < 20; ++k) REQUIRE(run.advance());
    const double t = run.time();
    std::stringstream file;
    save_checkpoint(file, run);
    Y b = a, c = start;
    REQUIRE(run.finish());

    PhiStepper fresh{b, Anchored{&diary}, scheme};
    REQUIRE(integrate(fresh, b, {t, 10}, control));
    CHECK(!same(a, b));
    CHECK(distance(a, b) < apart);

    PhiStepper loading{c, Anchored{&diary}, scheme};
    Run loaded{loading, c, {0, 10}, control};
    load_checkpoint(file, loaded);
    REQUIRE(loaded.finish());
    CHECK(same(a, c));
  };
  check(velocity_verlet, 1e-5), check(rkn86, 1e-5), check(rodas5p, 1e-5), check(radau, 1e-5);
}

TEST_CASE("no force is called with a state that isn't finite: explicit schemes, Newton's, fixed-point iteration") {
  check_never_called_with_nan<Anchored>(forward_euler);
  check_never_called_with_nan<Anchored>(symplectic_euler);
  check_never_called_with_nan<Damped>(symplectic_euler);
  check_never_called_with_nan<Anchored>(symplectic_euler_adjoint);
  check_never_called_with_nan<Anchored>(velocity_verlet);
  check_never_called_with_nan<Damped>(velocity_verlet);
  check_never_called_with_nan<Anchored>(srkn6b);
  check_never_called_with_nan<Anchored>(srkn11b);
  check_never_called_with_nan<Anchored>(composed(velocity_verlet));
  check_never_called_with_nan<Anchored>(rkn86);
  check_never_called_with_nan<Anchored>(rkn1210);
  check_never_called_with_nan<Anchored>(tsit5);
  check_never_called_with_nan<Damped>(dop853);
  check_never_called_with_nan<Anchored>(backward_euler);
  check_never_called_with_nan<Damped>(backward_euler);
  check_never_called_with_nan<Anchored>(midpoint);
  check_never_called_with_nan<Anchored>(trapezoidal);
  check_never_called_with_nan<Anchored>(phi(0.7));
  check_never_called_with_nan<Anchored>(tr_bdf2);
  check_never_called_with_nan<Anchored>(backward_euler, fixed_point());
  check_never_called_with_nan<Anchored>(midpoint, fixed_point());
  check_never_called_with_nan<Damped>(midpoint, fixed_point());
}

TEST_CASE("no force is called with a state that isn't finite: runs under a tolerance") {
  check_runs_never_call_with_nan<Anchored>(forward_euler);
  check_runs_never_call_with_nan<Anchored>(velocity_verlet);
  check_runs_never_call_with_nan<Damped>(velocity_verlet);
  check_runs_never_call_with_nan<Anchored>(symplectic_euler);
  check_runs_never_call_with_nan<Anchored>(rkn86);
  check_runs_never_call_with_nan<Damped>(tsit5);
  check_runs_never_call_with_nan<Anchored>(dop853);
  check_runs_never_call_with_nan<Anchored>(backward_euler);
  check_runs_never_call_with_nan<Damped>(trapezoidal);
  check_runs_never_call_with_nan<Anchored>(midpoint);
}

#endif
