// No heap allocation of ours in `step` after construction. Counts every allocation that Eigen or the library could make.
#define EIGEN_RUNTIME_NO_MALLOC  // a second, independent witness: Eigen asserts where it allocates
#include <phistep/autodiff.hpp>
#include <phistep/krylov.hpp>
#include <phistep/sparse.hpp>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <new>
#include <string>

#include "contract/states.hpp"
#include "support/catch.hpp"

namespace heap {
// Counting is on for the duration of a step alone.
inline bool counting = false;
inline std::int64_t count = 0;
}  // namespace heap

// Eigen allocates by malloc, posix_memalign or the like, everything else by new. glibc lets a program put itself in front of
// malloc; elsewhere new alone is counted, and Eigen's own check (below) stands in for malloc.
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define __SANITIZE_ADDRESS__ 1  // as g++ says it
#endif
#endif
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
#define PHISTEP_TEST_COUNTS_MALLOC 1
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void* malloc(std::size_t n) noexcept {
  heap::count += heap::counting;
  return __libc_malloc(n);
}
void* calloc(std::size_t n, std::size_t size) noexcept {
  heap::count += heap::counting;
  return __libc_calloc(n, size);
}
void* realloc(void* p, std::size_t n) noexcept {
  heap::count += heap::counting;
  return __libc_realloc(p, n);
}
void* aligned_alloc(std::size_t alignment, std::size_t n) noexcept {
  heap::count += heap::counting;
  return __libc_memalign(alignment, n);
}
int posix_memalign(void** p, std::size_t alignment, std::size_t n) noexcept {
  heap::count += heap::counting;
  *p = __libc_memalign(alignment, n);
  return *p == nullptr;
}
}
#else
#define PHISTEP_TEST_COUNTS_MALLOC 0
void* operator new(std::size_t n) {
  heap::count += heap::counting;
  if (void* p = std::malloc(n)) return p;
  throw std::bad_alloc();
}
void* operator new(std::size_t n, const std::nothrow_t&) noexcept {
  heap::count += heap::counting;
  return std::malloc(n);
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
#endif

using namespace phistep;
using states::Dynamic;

namespace {

/// Accumulates, and allocates nothing. Nonlinear enough that the Jacobian is renewed in every step.
struct Chain : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = false;
  static void add_to(const auto& x, auto& f) {
    const Eigen::Index n = x.size();
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto left = i > 0 ? x.data()[i - 1] - x.data()[i] : -x.data()[i];
      const auto right = i + 1 < n ? x.data()[i + 1] - x.data()[i] : -x.data()[i];
      f.data()[i] += left + right + 3 * (left * left * left + right * right * right);
    }
  }
  void add(double, const auto& y, auto& out) const {
    if constexpr (requires { out.force; }) add_to(y.r, out.force);
    else add_to(y.y, out.rate);
  }
};
struct DampedChain : Chain {
  static constexpr bool uses_velocity = true;
  void add(double t, const auto& y, auto& out) const {
    Chain::add(t, y, out);
    if constexpr (requires { out.force; }) out.force -= 0.1 * y.v;
  }
};
struct AnalyticChain : Chain {
  void add_jacobian(double, const auto& y, auto& sink) const {
    const auto& x = y.y;
    const Eigen::Index n = x.size();
    for (Eigen::Index i = 0; i < n; ++i) {
      const double left = i > 0 ? x[i - 1] - x[i] : -x[i], right = i + 1 < n ? x[i + 1] - x[i] : -x[i];
      const double kl = 1 + 9 * left * left, kr = 1 + 9 * right * right;
      if (i > 0) sink.rate(i, i - 1, kl);
      sink.rate(i, i, -kl - kr);
      if (i + 1 < n) sink.rate(i, i + 1, kr);
    }
  }
};
struct SparseChain : AnalyticChain {
  [[maybe_unused]] static constexpr Structure structure = Structure::sparse;  // a solver of one's own implies it
};
static_assert(ForceTraits<SparseChain, FirstOrderView<Dynamic, UnitMass>, RateOf<Dynamic>>::has_jacobian);

/// Allocations in ten steps of growing dt (so that Jacobian and factors are renewed), after `warm` steps.
template <class S>
std::int64_t allocations(S& state, auto& stepper, int warm = 0) {
  std::int64_t total = 0;
  for (int n = 0; n < 10 + warm; ++n) {
    heap::count = 0;
    heap::counting = n >= warm;
    const StepReport step = stepper.step(state, 0.1 * n, 0.02 + 0.001 * n);
    heap::counting = false;
    total += heap::count;
    REQUIRE(step);
  }
  return total;
}
/// The same with Eigen's own witness, which ends the program where Eigen allocates.
template <class S>
void check_none(S state, auto force, auto scheme, const auto&... more) {
  PhiStepper stepper{state, force, scheme, more...};
  Eigen::internal::set_is_malloc_allowed(false);
  const std::int64_t count = allocations(state, stepper);
  Eigen::internal::set_is_malloc_allowed(true);
  CHECK(count == 0);
}

Motion<Dynamic> motion(Eigen::Index n) { return {Dynamic::LinSpaced(n, -1, 1), Dynamic::LinSpaced(n, 0.5, -0.5)}; }

}  // namespace

#if PHISTEP_TEST_COUNTS_MALLOC
TEST_CASE("the counter counts") {
  static Dynamic* volatile kept;  // or the compiler removes the pair
  heap::count = 0, heap::counting = true;
  kept = new Dynamic(100);
  heap::counting = false;
  delete kept;
  CHECK(heap::count == 2);
}
#endif

TEST_CASE("every scheme, dynamic motion, Newton by differences: nothing") {
  states::for_each_motion_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    check_none(motion(30), Chain{}, scheme);
  });
}
TEST_CASE("every scheme, fixed motion: nothing, by value too") {
  const auto by_value = [](const states::Fixed& r, const states::Fixed& v) -> states::Fixed {
    return -r.array().cube() - v.array();
  };
  states::for_each_motion_scheme([&](const char* name, auto scheme) {
    CAPTURE(name);
    check_none(states::SecondOrder<states::Fixed>{}.state, by_value, scheme);
  });
}
TEST_CASE("schemes of high order, dynamic: nothing") {
  const Dynamic y = Dynamic::LinSpaced(30, -1, 1);
  check_none(motion(30), Chain{}, rodas5p);
  check_none(y, AnalyticChain{}, rodas4);
  check_none(y, AnalyticChain{}, radau);
  check_none(y, AnalyticChain{}, extrapolated(backward_euler));
  check_none(y, Chain{}, extrapolated(forward_euler));
  check_none(motion(30), Chain{}, extrapolated(velocity_verlet));
  check_none(motion(30), Chain{}, rkn86);
  check_none(motion(30), Chain{}, srkn11b);
  check_none(motion(30), DampedChain{}, composed(velocity_verlet));
}
TEST_CASE("first order, dynamic, up to 300 unknowns: nothing") {
  for (const Eigen::Index n : {1, 17, 100, 300}) {
    CAPTURE(n);
    check_none(Dynamic(Dynamic::LinSpaced(n, -1, 1)), Chain{}, trapezoidal);
    check_none(Dynamic(Dynamic::LinSpaced(n, -1, 1)), AnalyticChain{}, midpoint);
  }
}
TEST_CASE("velocities, masses of every kind, a sum, a tolerance: nothing") {
  check_none(motion(30), DampedChain{}, velocity_verlet);
  check_none(motion(30), DampedChain{}, phi(0.7), mass(2.0));
  check_none(motion(30), Chain{}, trapezoidal, mass(Dynamic::LinSpaced(30, 1, 2)));
  check_none(motion(30), Chain{}, forward_euler, mass(Eigen::MatrixXd(2 * Eigen::MatrixXd::Identity(30, 30))));
  check_none(motion(30), Chain{}, trapezoidal, mass(Eigen::MatrixXd(2 * Eigen::MatrixXd::Identity(30, 30))));
  check_none(motion(30), Chain{} + LinearDrag{0.1} + Gravity{Eigen::Vector3d(0, 0, -1)}, trapezoidal);
  check_none(motion(30), Chain{}, backward_euler, newton({.rtol = 1e-6, .atol = 1e-9}));
}
TEST_CASE("each particle by itself, by differences or with a Jacobian: nothing") {
  struct Well {
    Eigen::Vector3d operator()(const Eigen::Vector3d& r, const Eigen::Vector3d& v) const {
      return -r - r.squaredNorm() * r - 0.1 * v;
    }
  };
  struct Known : Well {
    [[nodiscard]] static MotionJacobian<Eigen::Matrix3d> jacobian(const Eigen::Vector3d& r, const Eigen::Vector3d&) {
      const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
      return {-I - r.squaredNorm() * I - 2 * r * r.transpose(), -0.1 * I};
    }
  };
  check_none(motion(30), local<3>(Well{}), trapezoidal);
  check_none(motion(30), local<3>(Well{}), velocity_verlet, mass(Dynamic::LinSpaced(30, 1, 2)));
  check_none(motion(30), local<3>(Known{}) + LinearDrag{0.1} + Gravity{Eigen::Vector3d(0, 0, -1)}, phi(0.7));
  const auto harmonic = [](const Eigen::Vector3d& r) -> Eigen::Vector3d { return -4 * r; };
  check_none(motion(30), affine(local<3>(harmonic)), trapezoidal);
}
TEST_CASE("affine forces, one solve a step: nothing") {
  const Eigen::MatrixXd K = -4 * Eigen::MatrixXd::Identity(30, 30), C = 0.1 * K;
  check_none(motion(30), linear(K), trapezoidal);
  check_none(motion(30), linear(K, C), midpoint, mass(Dynamic::LinSpaced(30, 1, 2)));
  check_none(Dynamic(Dynamic::LinSpaced(30, 1, 2)), linear(K), backward_euler);
}
TEST_CASE("fixed-point iteration, plain and accelerated: nothing") {
  check_none(motion(30), Chain{}, trapezoidal, fixed_point({.depth = 0}));
  check_none(motion(30), Chain{}, trapezoidal, fixed_point({.depth = 5}));
  check_none(motion(30), DampedChain{}, velocity_verlet, fixed_point());
  check_none(motion(3000), DampedChain{}, velocity_verlet);
}
TEST_CASE("views, matrices, arrays of structs: nothing") {
  states::SecondOrder<states::Structs> structs;
  PhiStepper one{structs.state, Chain{}, trapezoidal};
  CHECK(allocations(structs.state, one) == 0);
  states::FirstOrder<states::Strided> strided;
  PhiStepper two{strided.state, Chain{}, forward_euler};
  CHECK(allocations(strided.state, two) == 0);
  states::SecondOrder<states::Columns> columns;
  PhiStepper three{columns.state, Chain{}, velocity_verlet};
  CHECK(allocations(columns.state, three) == 0);
}
TEST_CASE("a reference-returning force: nothing") {
  Dynamic kept(30);
  const auto force = [&kept](const Dynamic& r) -> const Dynamic& {
    kept = -r;
    return kept;
  };
  check_none(motion(30), force, forward_euler);
  check_none(motion(30), force, velocity_verlet);
}
TEST_CASE("automatic differentiation of a fixed state: nothing") {
  const auto force = autodiff([](const auto& y) {
    std::remove_cvref_t<decltype(y)> f = y;
    for (Eigen::Index i = 0; i < y.size(); ++i) f[i] = -y[i] * y[i] * y[i];
    return f;
  });
  check_none(states::Fixed(states::Fixed::LinSpaced(1, 2)), force, trapezoidal);
}
TEST_CASE("springs by Verlet: nothing") {
  check_none(motion(30), spring_network<3>({{0, 1, 5, 0.1}, {1, 2, 5, 0.1}}), velocity_verlet);
}
TEST_CASE("springs row by row: nothing once they are in order") {
  std::vector<Spring> chain;
  for (int i = 0; i < 12'000; ++i) chain.push_back({i, i + 1, 5, 0.1});
  auto y = motion(36'003);
  PhiStepper stepper{y, spring_network<3>(chain), velocity_verlet};
  CHECK(allocations(y, stepper, 1) == 0);
}
TEST_CASE("split terms, Rannacher's start, a step around a step: nothing") {
  const auto kicks = at(forward_euler, Chain{}) + at(forward_euler, Gravity{Eigen::Vector3d(0, 0, -1)});
  check_none(motion(30), Chain{} + kicks, trapezoidal);
  check_none(motion(30), Chain{} + kicks + LinearDrag{0.1}, tr_bdf2, mass(Dynamic::LinSpaced(30, 1, 2)));
  check_none(motion(30), Chain{} + at(forward_euler, DampedChain{}), midpoint,
             mass(Eigen::MatrixXd(2 * Eigen::MatrixXd::Identity(30, 30))));
  check_none(motion(30), Chain{}, rannacher(3));
  auto y = motion(30);
  Halving halving{PhiStepper{y, Chain{}, trapezoidal}};
  CHECK(allocations(y, halving) == 0);
}
TEST_CASE("springs, implicitly: nothing once the net is known, in a clamped step neither") {
  const auto check = [](double length) {
    auto y = motion(30);
    PhiStepper stepper{y, spring_network<3>({{0, 1, 5, length}, {1, 2, 5, length}}) + LinearDrag{0.1}, backward_euler};
    REQUIRE(stepper.step(y, 0, 0.1));
    heap::count = 0, heap::counting = true;
    for (int n = 0; n < 10; ++n) static_cast<void>(stepper.step(y, 0, 3.0));
    heap::counting = false;
    CHECK(heap::count == 0);
    return stepper.statistics().fallbacks;
  };
  CHECK(check(0.01) == 0);
  CHECK(check(50) > 0);
}
TEST_CASE("a step that fails: nothing") {
  auto y = motion(30);
  PhiStepper stepper{y, Chain{}, trapezoidal};
  REQUIRE(stepper.step(y, 0, 0.1));
  y.r[3] = std::nan("");
  heap::count = 0, heap::counting = true;
  const StepReport report = stepper.step(y, 0, 0.1);
  heap::counting = false;
  CHECK_FALSE(report);
  CHECK(heap::count == 0);
}
TEST_CASE("integrate: nothing but what observers do") {
  auto y = motion(30);
  PhiStepper stepper{y, Chain{}, velocity_verlet};
  heap::count = 0, heap::counting = true;
  const RunReport report = integrate(stepper, y, {0, 1}, fixed(0.01), [](double, const Motion<Dynamic>&) {});
  heap::counting = false;
  CHECK(report);
  CHECK(heap::count == 0);
}

struct BandedChain : AnalyticChain {
  [[maybe_unused]] static constexpr Structure structure = Structure::banded;
};
struct BlockChain : AnalyticChain {
  [[maybe_unused]] static constexpr Structure structure = Structure::block_tridiagonal;
  [[maybe_unused]] static constexpr int block = 3;
};
struct PatternedChain : Chain {
  static constexpr Structure structure = Structure::banded;
  [[nodiscard]] static ColumnPattern pattern(Eigen::Index n) { return band_pattern(n, 1, 1); }
};
TEST_CASE("bands, blocks and differences by colour: nothing after the first step, which finds the band") {
  const auto check = [](auto force, Eigen::Index n) {
    Dynamic y = Dynamic::LinSpaced(n, -1, 1);
    PhiStepper stepper{y, force, trapezoidal};
    CHECK(allocations(y, stepper, 1) == 0);
    CHECK(stepper.statistics().factorizations >= 11);
  };
  check(BandedChain{}, 500);
  check(BlockChain{}, 499);
  check(BlockChain{}, 501);
  check(PatternedChain{}, 500);
  auto y = motion(500);
  PhiStepper stepper{y, PatternedChain{}, trapezoidal};
  CHECK(allocations(y, stepper, 1) == 0);
}

TEST_CASE("LDLᵀ: solves, and checks of symmetry, allocate nothing; Eigen's factorisations do") {
  const auto check = [](auto system) {
    constexpr int n = 100;
    const auto masses = [](auto&& put) {
      for (int i = 0; i < n; ++i) put(i, i, 1.0);
    };
    Statistics counts;
    Dynamic x = Dynamic::LinSpaced(n, -1, 1);
    std::int64_t in_factors = 0, in_solves = 0;
    system.resize(n);
    for (int k = 0; k < 10; ++k) {
      heap::count = 0, heap::counting = k > 0;
      system.clear();
      AnalyticChain{}.add_jacobian(0, FirstOrderView<Dynamic, UnitMass>{x, {}}, system);
      const Outcome factorized = system.factorize(masses, 0.1 + 0.01 * k, 0.0, counts);
      in_factors += heap::count;
      heap::count = 0, heap::counting = k > 0;
      const Outcome solved = system.solve(x);
      heap::counting = false;
      in_solves += heap::count;
      REQUIRE((factorized == Outcome::success && solved == Outcome::success));
    }
    CHECK(counts.analyses == 1);
    CHECK(in_solves == 0);
    std::cout << "LDLT, LLT           : " << in_factors << " allocations in 9 factorizations of n = 100\n";
    CHECK(in_factors <= 9 * 5);
  };
  using Sparse = Eigen::SparseMatrix<double>;
  check(SymmetricSparseSystem<double, false>{});
  check(SparseSystem<double, Eigen::SimplicialLDLT<Sparse>>{});
  check(SparseSystem<double, Eigen::SimplicialLLT<Sparse>>{});
  check(SparseSystem<double, Eigen::SimplicialLDLT<Sparse, Eigen::Upper, Eigen::NaturalOrdering<int>>>{});
}

// Not ours: printed, so that a reader knows; only the order of magnitude is asserted.
TEST_CASE("what Eigen's sparse solvers allocate") {
  const auto print = [](const std::string& name, auto solver) {
    Dynamic y = Dynamic::LinSpaced(100, -1, 1);
    PhiStepper stepper{y, SparseChain{}, trapezoidal, solver};
    const std::int64_t count = allocations(y, stepper);
    std::cout << name << ": " << count << " allocations in 10 steps of n = 100 (" << stepper.statistics().factorizations
              << " factorizations, " << stepper.statistics().solves << " solves)\n";
    if (PHISTEP_TEST_COUNTS_MALLOC) CHECK(count > 0);
    CHECK(count < 10000);
  };
  print("SparseLU            ", newton<Eigen::SparseLU<Eigen::SparseMatrix<double>>>());
  print("SimplicialLDLT      ", newton<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>>());
  print("conjugate gradients ",
        newton<Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper>>());
}
TEST_CASE("what Eigen's Krylov solvers allocate without a matrix") {
  Dynamic y = Dynamic::LinSpaced(100, -1, 1);
  PhiStepper stepper{y, AnalyticChain{}, trapezoidal, newton<MatrixFree<Eigen::BiCGSTAB>>()};
  const std::int64_t count = allocations(y, stepper);
  const Statistics& s = stepper.statistics();
  std::cout << "matrix-free BiCGSTAB : " << count << " allocations in 10 steps of n = 100 (" << s.solves << " solves, "
            << s.linear_iterations << " iterations)\n";
  // Its vectors, made in every solve, and what its preconditioner returns: two vectors an iteration, none by a product.
  CHECK(count <= 20 * s.solves + 2 * s.linear_iterations);
}
TEST_CASE("what automatic differentiation of a dynamic state allocates") {
  const auto force = autodiff([](const auto& y) {
    std::remove_cvref_t<decltype(y)> f = y;
    for (Eigen::Index i = 0; i < y.size(); ++i) f[i] = -y[i] * y[i] * y[i];
    return f;
  });
  Dynamic y = Dynamic::LinSpaced(30, 1, 2);
  PhiStepper stepper{y, force, trapezoidal};
  const std::int64_t count = allocations(y, stepper);
  const Statistics& s = stepper.statistics();
  std::cout << "autodiff, n = 30    : " << count << " allocations in 10 steps (" << s.jacobians << " Jacobians, "
            << s.force_calls << " force calls, which return by value)\n";
  // One a call is the user's; the rest are the dual vectors (argument and result, four chunks of eight) and J.
  CHECK(count - s.force_calls <= 12 * s.jacobians);
}

// Steps that are watched, rejected or doubled, and whole controlled runs between their first steps.
namespace {

template <class S>
void check_none_watched(S state, auto force, auto scheme, const auto&... more) {
  PhiStepper stepper{state, force, scheme, more...};
  StepDoubling<decltype(stepper), S> doubling;
  doubling.resize(state);
  Trace<S> trace;
  trace.resize(state);
  std::int64_t total = 0;
  for (int n = 0; n < 12; ++n) {
    heap::count = 0;
    heap::counting = n > 1;
    const auto judge = [n](const auto&...) { return n % 3 != 2; };
    StepReport step;
    bool direct = false;
    if constexpr (can_trace<decltype(stepper)>) {
      direct = stepper.estimates(trace);
      if (direct) step = stepper.attempt(state, 0.1 * n, 0.02 + 0.001 * n, Origin::unknown, trace, judge);
    }
    if (!direct) step = doubling.attempt(stepper, state, 0.1 * n, 0.02 + 0.001 * n, Origin::unknown, trace, judge);
    if (step) trace.advance();
    heap::counting = false;
    total += heap::count;
    REQUIRE((step || step.outcome() == Outcome::error_too_large));
  }
  CHECK(total == 0);
}

template <class S>
void check_none_run(S state, auto force, auto scheme, const auto& control) {
  PhiStepper stepper{state, force, scheme};
  Run run{stepper, state, {0.0, 2.0}, control};
  for (int n = 0; n < 3; ++n) REQUIRE(run.advance());
  heap::count = 0;
  heap::counting = true;
  while (run.advance()) {
  }
  heap::counting = false;
  CHECK(heap::count == 0);
  CHECK(run.report());
  CHECK(run.report().statistics.steps > 10);
}

}  // namespace

TEST_CASE("watched, rejected and doubled steps: nothing") {
  states::for_each_motion_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    check_none_watched(motion(30), Chain{}, scheme);
    check_none_watched(motion(30), DampedChain{}, scheme);
  });
  check_none_watched(Dynamic(Dynamic::LinSpaced(100, -1, 1)), AnalyticChain{}, tr_bdf2);
  check_none_watched(motion(30), Chain{}, trapezoidal, mass(Dynamic::LinSpaced(30, 1, 2)));
  check_none_watched(motion(30), Chain{}, tr_bdf2, mass(Eigen::MatrixXd(2 * Eigen::MatrixXd::Identity(30, 30))));
  check_none_watched(motion(30), Chain{}, trapezoidal, fixed_point({.depth = 3}));
}
TEST_CASE("high order for motion: nothing") {
  check_none(motion(30), Chain{}, srkn11b);
  check_none(motion(30), DampedChain{}, composed(velocity_verlet));
  check_none(motion(30), Chain{}, compensated(rkn1210), mass(Eigen::MatrixXd(2 * Eigen::MatrixXd::Identity(30, 30))));
  check_none_watched(motion(30), Chain{}, rkn86, mass(Dynamic::LinSpaced(30, 1, 2)));
  check_none_run(motion(30), Chain{}, rkn86, tolerance{.rtol = 1e-11});
}
TEST_CASE("controlled runs, after their first steps: nothing") {
  for (const auto filter : {StepFilter::automatic, StepFilter::H312PID}) {
    const tolerance control{.rtol = 1e-4, .filter = filter};
    check_none_run(motion(30), Chain{}, velocity_verlet, control);
    check_none_run(motion(30), DampedChain{}, trapezoidal, control);
    check_none_run(motion(30), DampedChain{}, midpoint, control);
    check_none_run(Dynamic(Dynamic::LinSpaced(100, -1, 1)), Chain{}, tr_bdf2, control);
  }
  check_none_run(motion(30), Chain{}, velocity_verlet,
                 tolerance{.rtol = 1e-4, .atol = Dynamic(Dynamic::Ones(60) * 1e-4)});
  check_none_run(motion(30), Chain{}, trapezoidal, iteration_control{.first_step = 0.01, .max_step = 0.05});
}
