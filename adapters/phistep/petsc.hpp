/// @file
/// phistep on PETSc: a Vec spread over ranks as the state, a KSP with any preconditioner as the linear solver.
///
///     PetscField y{vec};                                                          // owns vec from now on
///     PetscSolver solver{J, [&](double t, Vec y, Mat J) { … }};                   // fills J = ∂Ψ/∂y
///     PhiStepper stepper{y, PetscForce{[&](double t, Vec y, Vec rate) { … }}, rodas4, newton(solver)};
///     integrate(stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-4, .atol = 1e-6});  // on all ranks of vec
///
/// KSP and PC are those of the command line: -ksp_type, -pc_type, -pc_hypre_type …
#pragma once

#include <petscksp.h>

#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "phistep/mpi_field.hpp"

// PETSc exports and documents it, but declares it in a private header.
PETSC_EXTERN PetscErrorCode PetscObjectStateGet(PetscObject, PetscObjectState*);

namespace phistep { inline namespace PHISTEP_ABI {

static_assert(std::is_floating_point_v<PetscScalar>, "phistep: complex PETSc builds are not supported");

/// @throws std::runtime_error with PETSc's own words
inline void check_petsc(PetscErrorCode code) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  throw std::runtime_error("PETSc: " + std::string(text != nullptr ? text : "error " + std::to_string(code)));
}

/// What the library does with a Vec (phistep/base/state/field.hpp).
struct PetscOps : MpiFieldOps<PetscOps, PetscScalar> {
  using Handle = Vec;

  static Vec clone(Vec x) {
    Vec y = nullptr;
    check_petsc(VecDuplicate(x, &y));
    return y;
  }
  static void release(Vec x) { VecDestroy(&x); }
  static std::ptrdiff_t size(Vec x) {
    PetscInt n = 0;
    check_petsc(VecGetSize(x, &n));
    return n;
  }
  static void fill(Vec y, Scalar a) { check_petsc(VecSet(y, a)); }
  // Inlined where there is one term, it makes g++ 12 warn of the second, which isn't read.
  [[gnu::noinline]] static void combine(Vec y, int terms, const Scalar* a, const Vec* x) {
    int done = 1;
    if (x[0] != y && terms > 1 && a[0] != 1) {
      check_petsc(VecAXPBYPCZ(y, a[0], a[1], 0, x[0], x[1]));
      done = 2;
    } else {
      if (x[0] != y) check_petsc(VecCopy(x[0], y));
      if (a[0] != 1) check_petsc(VecScale(y, a[0]));
    }
    // VecMAXPY changes nothing of x, whatever its signature says.
    if (terms > done) check_petsc(VecMAXPY(y, terms - done, a + done, const_cast<Vec*>(x + done)));
  }
  static void read(auto&& f, auto... x) {
    [&f](const auto& first, const auto&... more) { f(first.n, first.x, more.x...); }(Local<const Scalar>{x}...);
  }
  static void write(auto&& f, Vec y, auto... x) {
    [&f](const auto& to, const auto&... from) { f(to.n, to.x, from.x...); }(Local<Scalar>{y},
                                                                            Local<const Scalar>{x}...);
  }
  static std::uint64_t fingerprint(Vec x) {
    PetscObjectState state = 0;
    PetscObjectId id = 0;
    check_petsc(PetscObjectStateGet(reinterpret_cast<PetscObject>(x), &state));
    check_petsc(PetscObjectGetId(reinterpret_cast<PetscObject>(x), &id));
    return (static_cast<std::uint64_t>(id) << 40) ^ static_cast<std::uint64_t>(state);
  }
  static void check(PetscErrorCode code) { check_petsc(code); }
  [[nodiscard]] static MPI_Comm communicator(Vec x) { return PetscObjectComm(reinterpret_cast<PetscObject>(x)); }

 private:
  /// This rank's numbers, to read or, where Number isn't const, to write.
  template <class Number>
  struct Local {
    Vec vec;
    Number* x = nullptr;
    std::size_t n = 0;
    explicit Local(Vec of) : vec{of} {
      PetscInt size = 0;
      check_petsc(VecGetLocalSize(vec, &size));
      n = static_cast<std::size_t>(size);
      if constexpr (std::is_const_v<Number>) check_petsc(VecGetArrayRead(vec, &x));
      else check_petsc(VecGetArray(vec, &x));
    }
    Local(const Local&) = delete;
    Local& operator=(const Local&) = delete;
    ~Local() {
      if constexpr (std::is_const_v<Number>) VecRestoreArrayRead(vec, &x);
      else VecRestoreArray(vec, &x);
    }
  };
};

/// A Vec as a state, or as one of several blocks of one. It owns the Vec; after a step `handle()` may be another one.
using PetscField = Field<PetscOps>;

/// A right-hand side in PETSc's manner, f(t, y, rate) or f(y, rate); of a motion f(t, r, v, force).
template <class F>
struct PetscForce : HandleForce<PetscOps, F> {
  using HandleForce<PetscOps, F>::HandleForce;
};
template <class F>
PetscForce(F) -> PetscForce<F>;

/// W = m − γJ in a Mat, solved by a KSP: for first-order fields J(t, y, Mat J); for motions J(t, r, v, Mat K, Mat C), and
/// W = m − γ_f C − γ_f γ_d K. Copies share all of it.
class PetscSolver {
 public:
  static constexpr bool is_field_solver = true;

  /// @param like      a matrix of J's layout and pattern, its diagonal in it, which stays the caller's. One that isn't assembled
  ///                  yet, and a MATSHELL, are J themselves; of the latter W is a product, too, and has no preconditioner but
  ///                  what the options or ksp() name
  /// @param jacobian  (t, y, J) or (t, r, v, K, C): sets all of their numbers and assembles them; it may return a
  ///                  PetscErrorCode
  /// @param mass      m in m y' = Ψ, as given to the stepper
  template <std::invocable<double, Vec, Mat> F>
  PetscSolver(Mat like, F jacobian, double mass = 1) : PetscSolver{like, mass} {
    all_->jacobian = [f = std::move(jacobian)](double t, Vec y, Mat J) mutable { call_checked<PetscOps>(f, t, y, J); };
  }
  template <std::invocable<double, Vec, Vec, Mat, Mat> F>
  PetscSolver(Mat like, F jacobian, double mass = 1) : PetscSolver{like, mass} {
    all_->motion_jacobian = [f = std::move(jacobian)](double t, Vec r, Vec v, Mat K, Mat C) mutable {
      call_checked<PetscOps>(f, t, r, v, K, C);
    };
    if (all_->is_shell) throw std::invalid_argument("phistep: K and C of a motion can't be one MATSHELL");
    check_petsc(MatDuplicate(like, MAT_DO_NOT_COPY_VALUES, &all_->K));
  }
  /// The application's own KSP, with its prefix, options and DM, solves from here on; it stays the caller's, too.
  void use(KSP own) {
    check_petsc(PetscObjectReference(reinterpret_cast<PetscObject>(own)));
    check_petsc(KSPDestroy(&all_->ksp));
    all_->ksp = own;
    check_petsc(KSPGetTolerances(own, &all_->rtol, nullptr, nullptr, nullptr));
  }

  [[nodiscard]] Outcome linearize(double t, const PetscField& y) {
    all_->jacobian(t, y.handle(), all_->J);
    return Outcome::success;
  }
  [[nodiscard]] Outcome linearize(double t, const PetscField& r, const PetscField& v) {
    all_->motion_jacobian(t, r.handle(), v.handle(), all_->K, all_->J);
    return Outcome::success;
  }
  [[nodiscard]] Outcome factorize(const Gamma<double>& gamma) {
    all_->gamma = gamma.force;
    if (!all_->is_shell) assemble(gamma);
    check_petsc(KSPSetOperators(all_->ksp, all_->W, all_->W));
    return KSPSetUp(all_->ksp) == 0 ? Outcome::success : Outcome::singular_matrix;
  }
  [[nodiscard]] Outcome solve(PetscField& x, double rtol) {
    all_->right.take_shape(x);
    all_->right = x;
    check_petsc(KSPSetTolerances(all_->ksp, rtol > 0 ? rtol : all_->rtol, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
    check_petsc(KSPSolve(all_->ksp, all_->right.handle(), x.handle()));
    KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
    check_petsc(KSPGetConvergedReason(all_->ksp, &reason));
    if (reason > 0) return Outcome::success;
    x = all_->right;
    return Outcome::linear_solver_failed;
  }
  [[nodiscard]] std::int64_t iterations() const {
    PetscInt n = 0;
    check_petsc(KSPGetIterationNumber(all_->ksp, &n));
    return n;
  }
  [[nodiscard]] const char* name() const { return "a KSP of PETSc's"; }
  /// For options that the command line doesn't give.
  [[nodiscard]] KSP ksp() const { return all_->ksp; }

 private:
  struct All {
    Mat J = nullptr, K = nullptr, W = nullptr;  // J: C of a motion
    KSP ksp = nullptr;
    std::function<void(double t, Vec y, Mat J)> jacobian;
    std::function<void(double t, Vec r, Vec v, Mat K, Mat C)> motion_jacobian;
    PetscField right;
    double mass = 1, rtol = 1e-5, made_for = 0;  // made_for: |γ| of the preconditioner's set-up
    double gamma = 0;
    bool is_shell = false;  // J is a product, and W is
    All() = default;
    All(const All&) = delete;
    All& operator=(const All&) = delete;
    ~All() {
      MatDestroy(&J);
      MatDestroy(&K);
      MatDestroy(&W);
      KSPDestroy(&ksp);
    }
    static PetscErrorCode multiply(Mat W, Vec x, Vec Wx) {
      All* its = nullptr;
      PetscCall(MatShellGetContext(W, &its));
      PetscCall(MatMult(its->J, x, Wx));
      return VecAXPBY(Wx, its->mass, -its->gamma, x);
    }
  };
  /// W = m − γ_f C − γ_f γ_d K in numbers.
  void assemble(const Gamma<double>& gamma) {
    if (all_->W == nullptr) check_petsc(MatDuplicate(all_->J, MAT_DO_NOT_COPY_VALUES, &all_->W));
    check_petsc(MatCopy(all_->J, all_->W, SAME_NONZERO_PATTERN));
    check_petsc(MatScale(all_->W, -gamma.force));
    if (all_->K != nullptr) check_petsc(MatAXPY(all_->W, -gamma.force * gamma.drift, all_->K, SAME_NONZERO_PATTERN));
    check_petsc(MatShift(all_->W, all_->mass));
    // PETSc's own multigrid keeps its coarse spaces as long as the pattern stays: those of a matrix that is nearly the identity
    // serve no other.
    const double size = std::abs(gamma.force);
    const bool is_similar = size <= 4 * all_->made_for && 4 * size >= all_->made_for;
    if (!is_similar) all_->made_for = size;
    PC pc = nullptr;
    check_petsc(KSPGetPC(all_->ksp, &pc));
    check_petsc(PCGAMGSetReuseInterpolation(pc, is_similar ? PETSC_TRUE : PETSC_FALSE));
  }
  PetscSolver(Mat like, double mass) : all_{std::make_shared<All>()} {
    all_->mass = mass;
    PetscBool is_shell = PETSC_FALSE, is_assembled = PETSC_FALSE;
    check_petsc(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(like), MATSHELL, &is_shell));
    check_petsc(MatAssembled(like, &is_assembled));
    all_->is_shell = is_shell == PETSC_TRUE;
    if (all_->is_shell || is_assembled == PETSC_FALSE) {
      check_petsc(PetscObjectReference(reinterpret_cast<PetscObject>(like)));
      all_->J = like;
    } else {
      check_petsc(MatDuplicate(like, MAT_DO_NOT_COPY_VALUES, &all_->J));
    }
    const MPI_Comm ranks = PetscObjectComm(reinterpret_cast<PetscObject>(like));
    check_petsc(KSPCreate(ranks, &all_->ksp));
    if (all_->is_shell) {
      PetscInt rows = 0, columns = 0;
      check_petsc(MatGetLocalSize(like, &rows, &columns));
      check_petsc(MatCreateShell(ranks, rows, columns, PETSC_DETERMINE, PETSC_DETERMINE, all_.get(), &all_->W));
      check_petsc(MatShellSetOperation(all_->W, MATOP_MULT, reinterpret_cast<void (*)()>(&All::multiply)));
      PC pc = nullptr;
      check_petsc(KSPGetPC(all_->ksp, &pc));
      check_petsc(PCSetType(pc, PCNONE));
    }
    check_petsc(KSPSetFromOptions(all_->ksp));
    check_petsc(KSPGetTolerances(all_->ksp, &all_->rtol, nullptr, nullptr, nullptr));
  }

  std::shared_ptr<All> all_;
};

}}  // namespace phistep::PHISTEP_ABI
