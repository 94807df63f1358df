#pragma once

// What CVODE's and ARKODE's runs share: owners of SUNDIALS' objects, its callback, its errors. For SUNDIALS 6 and 7.

#include <nvector/nvector_serial.h>
#include <sundials/sundials_config.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <Eigen/Core>

#include <exception>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace reference {

using Vector = Eigen::VectorXd;
using RightHandSide = std::function<Vector(double, const Vector&)>;
/// ∂f/∂y at (t, y), column by column.
using JacobianFunction = std::function<void(double t, const double* y, double* J)>;

namespace detail {

/// Owns a SUNDIALS object. Release: a function that takes the handle or its address.
template <auto release>
struct Release {
  template <class Pointer>
  void operator()(Pointer p) const {
    if constexpr (std::is_invocable_v<decltype(release), Pointer>) release(p);
    else release(&p);
  }
};
template <class Object, auto release>
using Handle = std::unique_ptr<Object, Release<release>>;

using Context = Handle<std::remove_pointer_t<SUNContext>, SUNContext_Free>;
using State = Handle<std::remove_pointer_t<N_Vector>, N_VDestroy>;
using Matrix = Handle<std::remove_pointer_t<SUNMatrix>, SUNMatDestroy>;
using LinearSolver = Handle<std::remove_pointer_t<SUNLinearSolver>, SUNLinSolFree>;

/// An integrator's memory is a void*, of which unique_ptr can't be the owner by type alone.
template <auto release>
struct ReleaseMemory {
  void operator()(void* memory) const { release(&memory); }
};
template <auto release>
using Memory = std::unique_ptr<void, ReleaseMemory<release>>;

inline Context make_context() {
  SUNContext context = nullptr;
#if SUNDIALS_VERSION_MAJOR >= 7
  const int flag = SUNContext_Create(SUN_COMM_NULL, &context);
#else
  const int flag = SUNContext_Create(nullptr, &context);
#endif
  if (flag != 0) throw std::runtime_error("SUNContext_Create failed");
#if SUNDIALS_VERSION_MAJOR >= 7
  SUNContext_ClearErrHandlers(context);
#endif
  return Context{context};
}

#if SUNDIALS_VERSION_MAJOR < 7
/// Failures are told by exceptions and outcomes, not on the terminal.
inline void ignore(int, const char*, const char*, char*, void*) {}
#endif

inline void check(int flag, const char* call) {
  if (flag < 0) throw std::runtime_error(std::string(call) + " failed with flag " + std::to_string(flag));
}
template <class Owner>
Owner check(Owner owner, const char* call) {
  if (!owner) throw std::runtime_error(std::string(call) + " returned nothing");
  return owner;
}

inline Eigen::Map<Vector> view(N_Vector x) { return {N_VGetArrayPointer(x), N_VGetLength(x)}; }

/// What the callback needs. An exception must not pass through C: it is kept, and thrown again outside.
struct Problem {
  const RightHandSide& f;
  const JacobianFunction& jacobian;
  std::exception_ptr thrown{};
  long calls = 0;
};
inline int evaluate(sunrealtype t, N_Vector y, N_Vector rate, void* user) {
  auto& problem = *static_cast<Problem*>(user);
  try {
    ++problem.calls;
    view(rate) = problem.f(t, view(y));
    return 0;
  } catch (...) {
    problem.thrown = std::current_exception();
    return -1;  // unrecoverable
  }
}
inline int evaluate_jacobian(sunrealtype t, N_Vector y, N_Vector, SUNMatrix J, void* user, N_Vector, N_Vector,
                             N_Vector) {
  static_cast<Problem*>(user)->jacobian(t, N_VGetArrayPointer(y), SUNDenseMatrix_Data(J));
  return 0;
}

}  // namespace detail

/// A run at a tolerance: where its steps ended, and what they took.
struct Run {
  std::vector<double> times;  ///< t = 0 and the end of every step (of every output, where steps aren't asked for)
  Vector y;
  long steps = 0, force_calls = 0, jacobians = 0, factorizations = 0, iterations = 0;
};

}  // namespace reference
