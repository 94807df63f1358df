/// @file
/// DOP853 (E. Hairer's Fortran, in Jacob Williams' edition) and LSODA (a translation to C++), with compiled callbacks.
#include "../numbalsoda.hpp"

#include <utility>

#include "tables.hpp"

namespace work_precision::smooth {
namespace {

/// What the callback is given.
struct Data {
  const System* system;
  long calls;
};
void rate(double t, double* y, double* out, double* user) {
  auto& data = *reinterpret_cast<Data*>(user);
  ++data.calls;
  static_cast<void>(data.system->rate(t, y, out, data.system->legs.front().self.get()));
}

Answer run(bench::Numbalsoda solver, const System& system, double rtol) {
  const int n = system.size();
  Eigen::VectorXd y = system.start;
  Eigen::MatrixXd out(n, 2);
  double times[] = {0, system.end()};
  Data data{&system, 0};
  int success = 0;
  solver(rate, n, y.data(), reinterpret_cast<double*>(&data), 2, times, out.data(), rtol, system.a * rtol,
         static_cast<int>(system.most_steps()), &success);
  if (success != 1) return {};
  return {out.col(1), 0, data.calls};
}

}  // namespace

bool numbalsoda(Table& table) {
  static const std::pair<const char*, bench::Numbalsoda> rivals[] = {{"DOP853", bench::load_numbalsoda("dop853")},
                                                                     {"LSODA", bench::load_numbalsoda("lsoda")}};
  bool any = false;
  for (const auto& [name, solver] : rivals) {
    if (solver == nullptr) continue;
    any = true;
    table.methods.push_back(
        {name, name, "rtol", tolerances(), [system = table.system, solver = solver](double rtol, Film* film) {
           return film != nullptr ? Answer{} : run(solver, system, rtol);
         }});
  }
  return any;
}

}  // namespace work_precision::smooth
