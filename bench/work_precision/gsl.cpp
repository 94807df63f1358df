/// @file
/// GSL's rows: BDF of variable order, Bader-Deuflhard extrapolation (bsimp), Prince-Dormand 8(9), Adams.
#ifdef BENCH_HAS_GSL
#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "table.hpp"

namespace work_precision {
namespace {

/// What the callbacks are given.
struct Data {
  const System& system;
  void* self;
  long most_calls, calls = 0, jacobians = 0;
  std::vector<double> values{};
};
int rate(double t, const double y[], double out[], void* user) {
  auto& data = *static_cast<Data*>(user);
  if (++data.calls > data.most_calls) return GSL_EBADFUNC;  // GSL never gives up by itself
  return data.system.rate(t, y, out, data.self);
}
int jacobian(double t, const double y[], double* J, double by_time[], void* user) {
  auto& data = *static_cast<Data*>(user);
  ++data.jacobians;
  const auto n = static_cast<std::size_t>(data.system.size());
  std::fill(J, J + n * n, 0.0);
  std::fill(by_time, by_time + n, 0.0);
  data.system.entries(t, y, data.values.data(), data.self);
  const double* value = data.values.data();
  for (const auto& [i, j] : data.system.pattern)
    J[static_cast<std::size_t>(i) * n + static_cast<std::size_t>(j)] += *value++;
  return GSL_SUCCESS;
}

Answer run(const System& system, const gsl_odeiv2_step_type* type, double rtol, Film* film) {
  gsl_set_error_handler_off();
  Eigen::VectorXd y = system.start;
  Data data{system, system.legs.front().self.get(), 5000000};
  data.values.resize(system.pattern.size());
  gsl_odeiv2_system callbacks{rate, jacobian, static_cast<std::size_t>(system.size()), &data};
  const double end = system.end();
  const std::unique_ptr<gsl_odeiv2_driver, decltype(&gsl_odeiv2_driver_free)> driver{
      gsl_odeiv2_driver_alloc_y_new(&callbacks, type, 1e-6 * std::min(end, 1000.0), system.a * rtol, rtol),
      gsl_odeiv2_driver_free};
  double t = 0;
  if (film)
    for (std::size_t k = 0; k < film->times.size(); ++k) {
      if (gsl_odeiv2_driver_apply(driver.get(), &t, film->times[k], y.data()) != GSL_SUCCESS) return {};
      film->put(k, y.data());
    }
  else if (gsl_odeiv2_driver_apply(driver.get(), &t, end, y.data()) != GSL_SUCCESS) return {};
  return {y, static_cast<std::int64_t>(driver->n), data.calls, data.jacobians, data.jacobians};
}

}  // namespace

/// Large problems are left out: GSL knows dense matrices only.
void gsl(Table& table) {
  const auto add = [&table](const char* name, const gsl_odeiv2_step_type* type) {
    table.add("GSL", name, tolerances(),
              [system = table.system, type](double rtol, Film* film) { return run(system, type, rtol, film); });
  };
  if (table.system.shape == Shape::dense) {
    add("msbdf", gsl_odeiv2_step_msbdf);
    if (!table.system.is_driven) add("bsimp", gsl_odeiv2_step_bsimp);  // needs df/dt
  }
  if (table.system.shape == Shape::explicit_) {
    add("rk8pd", gsl_odeiv2_step_rk8pd);
    add("msadams", gsl_odeiv2_step_msadams);
  }
}

}  // namespace work_precision
#endif
