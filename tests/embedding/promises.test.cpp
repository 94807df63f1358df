// What docs/embedding.md says of forces, steppers and an existing program's own arrays. The products are in promises.full.cpp.
#include "embedding/promises_cases.hpp"
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
