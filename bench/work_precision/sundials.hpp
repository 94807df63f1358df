/// @file
/// What CVODE's and ARKODE's rows share: the callbacks, and a linear solver that suits the problem.
///
/// What SUNDIALS can't do for itself is not on its clock: the pattern of a sparse matrix, and where each entry goes.
#pragma once

#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_band.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunlinsol/sunlinsol_spgmr.h>
#include <sunmatrix/sunmatrix_band.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunmatrix/sunmatrix_sparse.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "accuracy/reference/sundials.hpp"
#include "table.hpp"

namespace work_precision::sundials {

using namespace reference::detail;

/// How Newton's linear equations are solved. GMRES: on products by differences, as SUNDIALS makes them; no preconditioner.
enum class Linear { dense, band, klu, gmres };

[[nodiscard]] inline const char* name(Linear linear) {
  const char* const names[] = {"dense", "band", "KLU", "GMRES"};
  return names[static_cast<int>(linear)];
}
[[nodiscard]] inline std::vector<Linear> linear_solvers_for(const System& system) {
  switch (system.shape) {
    case Shape::dense:
      return system.size() < 15 ? std::vector{Linear::dense} : std::vector{Linear::dense, Linear::klu};
    case Shape::banded:
      return {Linear::band, Linear::klu};
    case Shape::sparse:
      return {Linear::klu, Linear::gmres};
    case Shape::explicit_:
      break;
  }
  return {};
}

/// Where in the matrix each entry is added, and a sparse matrix's pattern: column by column, the diagonal included.
struct Places {
  Linear linear;
  std::vector<sunindextype> start, row;
  std::vector<std::size_t> slot;

  Places(const System& system, Linear solver) : linear{solver} {
    const auto n = static_cast<std::size_t>(system.size());
    if (linear == Linear::dense) {
      for (const auto& [i, j] : system.pattern)
        slot.push_back(static_cast<std::size_t>(i) + n * static_cast<std::size_t>(j));
    } else if (linear == Linear::klu) {
      std::vector<std::pair<std::size_t, std::size_t>> places;  // column by column, and who emits there
      for (const auto& [i, j] : system.pattern)
        places.emplace_back(static_cast<std::size_t>(j) * n + static_cast<std::size_t>(i), places.size());
      const std::size_t emitted = places.size();
      for (std::size_t i = 0; i < n; ++i) places.emplace_back(i * n + i, emitted);
      std::sort(places.begin(), places.end());
      slot.resize(emitted + 1);
      start.assign(n + 1, 0);
      std::size_t last = n * n;
      for (const auto& [place, who] : places) {
        if (place != last) {
          row.push_back(static_cast<sunindextype>(place % n));
          ++start[place / n + 1];
        }
        last = place;
        slot[who] = row.size() - 1;
      }
      slot.pop_back();
      for (std::size_t j = 0; j < n; ++j) start[j + 1] += start[j];
    }
  }
};

/// What the callbacks are given.
struct Data {
  const System& system;
  const Places* places;
  void* self;
  long calls = 0;
  std::vector<double> values{};
};
inline int rate(sunrealtype t, N_Vector y, N_Vector out, void* user) {
  auto& data = *static_cast<Data*>(user);
  ++data.calls;
  return data.system.rate(t, NV_DATA_S(y), NV_DATA_S(out), data.self);
}
inline int jacobian(sunrealtype t, N_Vector y, N_Vector, SUNMatrix J, void* user, N_Vector, N_Vector, N_Vector) {
  auto& data = *static_cast<Data*>(user);
  const Places& places = *data.places;
  const auto& pattern = data.system.pattern;
  data.system.entries(t, NV_DATA_S(y), data.values.data(), data.self);
  const double* value = data.values.data();
  if (places.linear == Linear::band) {
    sunrealtype* const to = SM_DATA_B(J);
    const auto leading = SM_LDIM_B(J), diagonal = SM_SUBAND_B(J);
    for (const auto& [i, j] : pattern) to[i - j + diagonal + j * leading] += *value++;
    return 0;
  }
  sunrealtype* to = nullptr;
  if (places.linear == Linear::dense) {
    to = SM_DATA_D(J);
  } else {
    std::copy(places.start.begin(), places.start.end(), SM_INDEXPTRS_S(J));
    std::copy(places.row.begin(), places.row.end(), SM_INDEXVALS_S(J));
    to = SM_DATA_S(J);
    std::fill(to, to + places.row.size(), 0.0);
  }
  for (const std::size_t slot : places.slot) to[slot] += *value++;
  return 0;
}

/// The handles of one run.
struct Handles {
  Context context = make_context();
  State y;
  Matrix J;
  LinearSolver solver;

  explicit Handles(const System& system) : y{N_VNew_Serial(static_cast<sunindextype>(system.size()), context.get())} {
    view(y.get()) = system.start;
  }
  void make_solver(const System& system, const Places& places) {
    const sunindextype n = system.size();
    const auto [lower, upper] = system.bandwidths();
    switch (places.linear) {
      case Linear::dense:
        J.reset(SUNDenseMatrix(n, n, context.get()));
        solver.reset(SUNLinSol_Dense(y.get(), J.get(), context.get()));
        break;
      case Linear::band:
        J.reset(SUNBandMatrix(n, upper, lower, context.get()));
        solver.reset(SUNLinSol_Band(y.get(), J.get(), context.get()));
        break;
      case Linear::klu:
        J.reset(SUNSparseMatrix(n, n, static_cast<sunindextype>(places.row.size()), CSC_MAT, context.get()));
        solver.reset(SUNLinSol_KLU(y.get(), J.get(), context.get()));
        SUNLinSol_KLUSetOrdering(solver.get(),
                                 0);  // AMD: COLAMD, the default, fills twice as much on symmetric patterns
        break;
      case Linear::gmres:
        solver.reset(SUNLinSol_SPGMR(y.get(), SUN_PREC_NONE, 20, context.get()));
        break;
    }
  }
};

/// From leg to leg, and where there is a film, from time to time: the solver interpolates there, and steps as it would.
/// @param restart   restart(t) starts again at t
/// @param advance   advance(t, stop) goes to t, and no step beyond `stop`; false where that fails
[[nodiscard]] bool go(Data& data, N_Vector y, Film* film, auto&& restart, auto&& advance) {
  double from = 0;
  std::size_t k = 0;
  for (const System::Leg& leg : data.system.legs) {
    data.self = leg.self.get();
    if (from > 0) restart(from);
    if (film)
      for (; k < film->times.size() && film->times[k] < leg.end; ++k) {
        if (!advance(film->times[k], leg.end)) return false;
        film->put(k, NV_DATA_S(y));
      }
    if (!advance(leg.end, leg.end)) return false;
    if (film && k < film->times.size() && film->times[k] == leg.end) film->put(k++, NV_DATA_S(y));
    from = leg.end;
  }
  return true;
}

}  // namespace work_precision::sundials
