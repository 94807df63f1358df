// No heap allocation of ours in `step` after construction: bands, sparse and Krylov solvers. In short:
// step.test.cpp.
#define EIGEN_RUNTIME_NO_MALLOC  // a second, independent witness: Eigen asserts where it allocates
#include "allocation/step_cases.hpp"

#include <phistep/autodiff.hpp>
#include <phistep/krylov.hpp>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>

#include <iostream>
#include <string>

struct PatternedChain : Chain {
  static constexpr Structure structure = Structure::banded;
  [[nodiscard]] static ColumnPattern pattern(Eigen::Index n) { return band_pattern(n, 1, 1); }
};
TEST_CASE("bands and differences by colour: nothing after the first step, which finds the band") {
  const auto check = [](auto force, Eigen::Index n) {
    Dynamic y = Dynamic::LinSpaced(n, -1, 1);
    PhiStepper stepper{y, force, trapezoidal};
    CHECK(allocations(y, stepper, 1) == 0);
    CHECK(stepper.statistics().factorizations >= 11);
  };
  check(BandedChain{}, 500);
  check(PatternedChain{}, 500);
  auto y = motion(500);
  PhiStepper stepper{y, PatternedChain{}, trapezoidal};
  CHECK(allocations(y, stepper, 1) == 0);
}

TEST_CASE("Radau over bands and sparse matrices: nothing after the first step, which finds the pattern") {
  const auto check = [](auto force, Eigen::Index n) {
    Dynamic y = Dynamic::LinSpaced(n, -1, 1);
    PhiStepper stepper{y, force, radau};
    CHECK(allocations(y, stepper, 1) == 0);
    CHECK(stepper.statistics().factorizations >= 11);
  };
  check(BandedChain{}, 200);
  check(PatternedChain{}, 200);
  check(SparseChain{}, 200);
}

TEST_CASE("LDLᵀ and LU: solves, and checks of symmetry, allocate nothing; Eigen's factorizations do") {
  const auto check = [](auto system, std::int64_t most = 9 * 5) {
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
    std::cout << "LDLT, LLT, LU       : " << in_factors << " allocations in 9 factorizations of n = 100\n";
    CHECK(in_factors <= most);
  };
  using Sparse = Eigen::SparseMatrix<double>;
  check(SymmetricSparseSystem<double, Symmetry::promised, false>{});
  check(SymmetricSparseSystem<double, Symmetry::sought, false>{});
  check(SparseSystem<double, SparseLu<double>>{}, 0);
  check(SparseSystem<double, Eigen::SimplicialLDLT<Sparse>>{});
  check(SparseSystem<double, Eigen::SimplicialLLT<Sparse>>{});
  check(SparseSystem<double, Eigen::SimplicialLDLT<Sparse, Eigen::Upper, Eigen::NaturalOrdering<int>>>{});
}

TEST_CASE("preconditioned Krylov methods: nothing after the first step") {
  const auto check = [](auto solver, std::int64_t factorizations = 1) {
    Dynamic y = Dynamic::LinSpaced(100, -1, 1);
    PhiStepper stepper{y, SparseChain{}, trapezoidal, solver};
    CHECK(allocations(y, stepper, 1) == 0);
    CHECK(stepper.statistics().linear_iterations > 0);
    CHECK(stepper.statistics().factorizations == factorizations);
  };
  check(newton<PreconditionedCg<IncompleteCholesky>>());
  check(newton<PreconditionedBySymmetry>(), 11);  // one for each W
  check(newton<PreconditionedBicgstab<>>());
  check(newton<PreconditionedGmres<>>());
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
TEST_CASE("Krylov iterations without a matrix allocate nothing") {
  Dynamic y = Dynamic::LinSpaced(100, -1, 1);
  PhiStepper stepper{y, AnalyticChain{}, trapezoidal, newton<MatrixFree<>>()};
  CHECK(allocations(y, stepper) == 0);
  CHECK(stepper.statistics().linear_iterations > 0);
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
