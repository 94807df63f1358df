/// @file
/// phistep on SUNDIALS 6: an N_Vector as the state, any SUNLinearSolver for its implicit steps.
///
///     SundialsField y{vector};                                          // owns the N_Vector from now on
///     SundialsForce rate{[&](double t, N_Vector y, N_Vector rate) { … }};
///     SundialsSolver solver{SUNLinSol_SPGMR(vector, SUN_PREC_NONE, 0, context),
///                           [&](double t, N_Vector y, N_Vector x, N_Vector Jx) { … }};  // ∂Ψ/∂y x
///     PhiStepper stepper{y, rate, rodas4, newton(solver)};
///     integrate(stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-4, .atol = 1e-6});  // on all ranks of the vector
#pragma once

#include <nvector/nvector_manyvector.h>
#include <nvector/nvector_mpimanyvector.h>
#include <nvector/nvector_mpiplusx.h>
#include <nvector/nvector_parallel.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>
#include <sundials/sundials_nvector.h>

#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "phistep/mpi_field.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What the library does with an N_Vector whose numbers lie in this process's memory: serial, of threads, of MPI's ranks, a
/// ManyVector of such.
struct SundialsOps : MpiFieldOps<SundialsOps, realtype> {
  using Handle = N_Vector;

  static N_Vector clone(N_Vector x) {
    read([](auto...) {}, x);  // all ranks are refused together what can't be read
    if (const N_Vector y = N_VClone(x)) return y;
    throw std::runtime_error("SUNDIALS: an N_Vector can't be cloned");
  }
  static void release(N_Vector x) { N_VDestroy(x); }
  static std::ptrdiff_t size(N_Vector x) { return static_cast<std::ptrdiff_t>(N_VGetLength(x)); }
  static void fill(N_Vector y, Scalar a) { N_VConst(a, y); }
  static void combine(N_Vector y, int terms, const Scalar* a, const N_Vector* x) {
    // It changes nothing of a and x, whatever its signature says.
    check(N_VLinearCombination(terms, const_cast<Scalar*>(a), const_cast<N_Vector*>(x), y));
  }
  /// f(how many, their addresses…) for this rank's numbers, part by part.
  static void read(auto&& f, N_Vector x, auto... more) {
    if (const Parts parts = parts_of(x); parts.x != nullptr) {
      for (sunindextype k = 0; k < parts.n; ++k) read(f, parts.x[k], parts_of(more).x[k]...);
    } else {
      f(local_size(x), array(x), static_cast<const Scalar*>(array(more))...);
    }
  }
  static void write(auto&& f, N_Vector y, auto... x) {
    read([&f](std::size_t n, Scalar* to, const auto*... from) { f(n, to, from...); }, y, x...);
  }
  static void check(int code) {
    if (code != 0) throw std::runtime_error("SUNDIALS: error code " + std::to_string(code));
  }
  [[nodiscard]] static MPI_Comm communicator(N_Vector x) {
    const void* its = N_VGetCommunicator(x);
    return its != nullptr ? *static_cast<const MPI_Comm*>(its) : MPI_COMM_NULL;
  }

 private:
  struct Parts {
    N_Vector* x = nullptr;
    sunindextype n = 0;
  };
  [[nodiscard]] static Parts parts_of(N_Vector x) {
    const N_Vector_ID kind = N_VGetVectorID(x);
    if (kind == SUNDIALS_NVEC_MANYVECTOR) {
      const auto* its = static_cast<N_VectorContent_ManyVector>(x->content);
      return {its->subvec_array, its->num_subvectors};
    }
    if (kind == SUNDIALS_NVEC_MPIMANYVECTOR || kind == SUNDIALS_NVEC_MPIPLUSX) {  // the latter is one of one part
      const auto* its = static_cast<N_VectorContent_MPIManyVector>(x->content);
      return {its->subvec_array, its->num_subvectors};
    }
    return {};
  }
  /// How many numbers this rank has.
  /// @throws std::invalid_argument where a vector of the user's own kind, spread over ranks, doesn't tell
  [[nodiscard]] static std::size_t local_size(N_Vector x) {
    if (N_VGetVectorID(x) == SUNDIALS_NVEC_PARALLEL)
      return static_cast<std::size_t>(static_cast<N_VectorContent_Parallel>(x->content)->local_length);
    if (x->ops->nvgetlocallength != nullptr) return static_cast<std::size_t>(x->ops->nvgetlocallength(x));
    if (ranks(x) > 1)
      throw std::invalid_argument(
          "phistep: this kind of N_Vector is spread over ranks and doesn't say how many numbers each has: set its "
          "ops->nvgetlocallength");
    return static_cast<std::size_t>(N_VGetLength(x));
  }
  /// @throws std::invalid_argument where they lie on a device: an array beside them may be older
  [[nodiscard]] static Scalar* array(N_Vector x) {
    const bool is_here = x->ops->nvgetdevicearraypointer == nullptr && !is_on_device(N_VGetVectorID(x));
    Scalar* const its = is_here && x->ops->nvgetarraypointer != nullptr ? N_VGetArrayPointer(x) : nullptr;
    if (its == nullptr && (!is_here || local_size(x) > 0))
      throw std::invalid_argument(
          "phistep: the numbers of this kind of N_Vector are not in this process's memory: take a serial, OpenMP, "
          "Pthreads or parallel one, or a ManyVector of these");
    return its;
  }
  [[nodiscard]] static bool is_on_device(N_Vector_ID kind) {
    return kind == SUNDIALS_NVEC_CUDA || kind == SUNDIALS_NVEC_HIP || kind == SUNDIALS_NVEC_SYCL ||
           kind == SUNDIALS_NVEC_RAJA || kind == SUNDIALS_NVEC_KOKKOS || kind == SUNDIALS_NVEC_OPENMPDEV;
  }
};

/// An N_Vector as a state, or as one of several blocks of one. It owns the N_Vector; after a step `handle()` may be another.
using SundialsField = Field<SundialsOps>;

/// A right-hand side in SUNDIALS' manner, f(t, y, rate) or f(y, rate); of a motion f(t, r, v, force).
template <class F>
struct SundialsForce : HandleForce<SundialsOps, F> {
  using HandleForce<SundialsOps, F>::HandleForce;
};
template <class F>
SundialsForce(F) -> SundialsForce<F>;

/// W = m − γJ of a first-order field, solved by a SUNLinearSolver: an iterative one with products J x, or one with a SUNMatrix.
/// W/m = 1 − γ' J with γ' = γ/m is what it sees. Copies share all of it.
class SundialsSolver {
 public:
  static constexpr bool is_field_solver = true;
  using Setup = std::function<void(double t, N_Vector y, double gamma)>;
  using Precondition = std::function<void(double gamma, N_Vector r, N_Vector z)>;

  /// @param method   SPGMR, SPBCGS, PCG …, owned from here on
  /// @param product  (t, y, x, Jx): sets all numbers of Jx = ∂Ψ/∂y(t, y) x; like every function here it may return an error
  /// @param mass     m in m y' = Ψ, as given to the stepper
  template <std::invocable<double, N_Vector, N_Vector, N_Vector> F>
  SundialsSolver(SUNLinearSolver method, F product, double mass = 1) : SundialsSolver{method, mass} {
    all_->product = [f = std::move(product)](double t, N_Vector y, N_Vector x, N_Vector Jx) mutable {
      call_checked<SundialsOps>(f, t, y, x, Jx);
    };
    check(SUNLinSolSetATimes(method, all_.get(), [](void* all, N_Vector x, N_Vector Wx) {
      return static_cast<All*>(all)->multiply(x, Wx);
    }));
  }
  /// @param method    made for W
  /// @param W         owned from here on
  /// @param jacobian  (t, y, J): sets all numbers of J = ∂Ψ/∂y, a matrix like W
  template <std::invocable<double, N_Vector, SUNMatrix> F>
  SundialsSolver(SUNLinearSolver method, SUNMatrix W, F jacobian, double mass = 1) : SundialsSolver{method, mass} {
    all_->jacobian = [f = std::move(jacobian)](double t, N_Vector y, SUNMatrix J) mutable {
      call_checked<SundialsOps>(f, t, y, J);
    };
    all_->W = W, all_->J = SUNMatClone(W);
  }
  /// A preconditioner of the user's; `method` was made with SUN_PREC_RIGHT or SUN_PREC_LEFT.
  /// @param setup  (t, y, γ'): for later calls of `solve`, once for each γ'
  /// @param solve  (γ', r, z): z ≈ (1 − γ'J)⁻¹ r
  void precondition(Setup setup, Precondition solve) {
    all_->setup = std::move(setup), all_->precondition = std::move(solve);
    check(SUNLinSolSetPreconditioner(
        all_->method, all_.get(), nullptr, [](void* all, N_Vector r, N_Vector z, realtype, int) {
          All& its = *static_cast<All*>(all);
          its.held.run([&] { its.precondition(its.gamma, r, z); }, [z] { SundialsOps::poison(z); });
          return 0;
        }));
  }

  [[nodiscard]] Outcome linearize(double t, const SundialsField& y) {
    all_->t = t, all_->at = y;
    if (all_->J != nullptr) {
      check(SUNMatZero(all_->J));
      all_->jacobian(t, y.handle(), all_->J);
    }
    return Outcome::success;
  }
  [[nodiscard]] Outcome factorize(const Gamma<double>& gamma) {
    All& its = *all_;
    its.gamma = gamma.force / its.mass;
    if (its.setup) its.setup(its.t, its.at.handle(), its.gamma);
    if (its.W != nullptr) {
      check(SUNMatCopy(its.J, its.W));
      check(SUNMatScaleAddI(-its.gamma, its.W));
    }
    check(SUNLinSolInitialize(its.method));  // its functions are known by now
    return SUNLinSolSetup(its.method, its.W) == 0 ? Outcome::success : Outcome::singular_matrix;
  }
  /// @param rtol  of the residual's 2-norm, that of the preconditioned one under SUN_PREC_LEFT
  [[nodiscard]] Outcome solve(SundialsField& x, double rtol) {
    All& its = *all_;
    its.right.take_shape(x);
    its.right = x;
    const N_Vector b = its.right.handle();
    const double norm = std::sqrt(N_VDotProd(b, b));
    x.setZero();
    check(SUNLinSolSetZeroGuess(its.method, SUNTRUE));
    const int code = norm == 0 ? 0 : SUNLinSolSolve(its.method, its.W, x.handle(), b, (rtol > 0 ? rtol : 1e-5) * norm);
    if (code == 0 && !its.held) x *= 1 / its.mass;
    else x = its.right;
    its.held.rethrow();
    return code == 0 ? Outcome::success : Outcome::linear_solver_failed;
  }
  [[nodiscard]] std::int64_t iterations() const { return SUNLinSolNumIters(all_->method); }
  [[nodiscard]] static const char* name() { return "a SUNLinearSolver"; }

 private:
  struct All {
    SUNLinearSolver method;
    double mass;
    std::function<void(double t, N_Vector y, N_Vector x, N_Vector Jx)> product;
    std::function<void(double t, N_Vector y, SUNMatrix J)> jacobian;
    Setup setup;
    Precondition precondition;
    SUNMatrix J = nullptr, W = nullptr;
    SundialsField at, right;
    double t = 0, gamma = 0;  // where J is taken, and γ'
    HeldException held;       // must not pass through SUNDIALS' C, nor leave other ranks waiting in it

    All(SUNLinearSolver of, double m) : method{of}, mass{m} {}
    All(const All&) = delete;
    All& operator=(const All&) = delete;
    ~All() {
      SUNLinSolFree(method);
      SUNMatDestroy(J);
      SUNMatDestroy(W);
    }
    int multiply(N_Vector x, N_Vector Wx) {
      held.run(
          [&] {
            product(t, at.handle(), x, Wx);
            N_VLinearSum(1, x, -gamma, Wx, Wx);
          },
          [Wx] { SundialsOps::poison(Wx); });
      return 0;
    }
  };
  SundialsSolver(SUNLinearSolver method, double mass) : all_{std::make_shared<All>(method, mass)} {}
  static void check(int code) { SundialsOps::check(code); }

  std::shared_ptr<All> all_;
};

}}  // namespace phistep::PHISTEP_ABI
