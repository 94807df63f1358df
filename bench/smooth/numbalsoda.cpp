/// @file
/// DOP853 (E. Hairer's Fortran, in Jacob Williams' edition) and LSODA (a translation to C++), with compiled callbacks.
#include "tables.hpp"

#if __has_include(<dlfcn.h>)
#include <dlfcn.h>

#include <cstdlib>
#include <string>
#include <utility>

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

using Wrapper = void (*)(void (*)(double, double*, double*, double*), int n, double* y0, double* user, int times,
                         double* t, double* out, double rtol, double atol, int most_steps, int* success);

Wrapper load(const char* library, const char* symbol) {
  const char* const folder = std::getenv("NUMBALSODA");
  if (folder == nullptr) return nullptr;
  void* const handle = dlopen((std::string(folder) + '/' + library).c_str(), RTLD_NOW);
  return handle == nullptr ? nullptr : reinterpret_cast<Wrapper>(dlsym(handle, symbol));
}

Answer run(Wrapper wrapper, const System& system, double rtol) {
  const int n = system.size();
  Eigen::VectorXd y = system.start;
  Eigen::MatrixXd out(n, 2);
  double times[] = {0, system.end()};
  Data data{&system, 0};
  int success = 0;
  wrapper(rate, n, y.data(), reinterpret_cast<double*>(&data), 2, times, out.data(), rtol, system.a * rtol,
          static_cast<int>(system.most_steps()), &success);
  if (success != 1) return {};
  return {out.col(1), 0, data.calls};
}

}  // namespace

bool numbalsoda(Table& table) {
  static const std::pair<const char*, Wrapper> rivals[] = {{"DOP853", load("libdop853.so", "dop853_wrapper")},
                                                           {"LSODA", load("liblsoda.so", "lsoda_wrapper")}};
  bool any = false;
  for (const auto& [name, wrapper] : rivals) {
    if (wrapper == nullptr) continue;
    any = true;
    table.methods.push_back(
        {name, name, "rtol", tolerances(), [system = table.system, wrapper = wrapper](double rtol, Film* film) {
           return film != nullptr ? Answer{} : run(wrapper, system, rtol);
         }});
  }
  return any;
}

}  // namespace work_precision::smooth
#else
bool work_precision::smooth::numbalsoda(Table&) { return false; }
#endif
