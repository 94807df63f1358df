/// @file
/// Solvers as the Python package numbalsoda has them compiled, with C interfaces. The environment variable NUMBALSODA names the
/// folder of its libraries.
#pragma once

#if __has_include(<dlfcn.h>)
#include <dlfcn.h>
#endif

#include <cstdlib>
#include <string>

namespace bench {

/// A solver. `out`: the states at all times, one a column.
using Numbalsoda = void (*)(void (*rate)(double t, double* y, double* out, double* user), int n, double* y0,
                            double* user, int times, double* t, double* out, double rtol, double atol, int most_steps,
                            int* success);

/// @param name  "lsoda" or "dop853". @return null where it isn't found
[[nodiscard]] inline Numbalsoda load_numbalsoda([[maybe_unused]] const std::string& name) {
#if __has_include(<dlfcn.h>)
  if (const char* const folder = std::getenv("NUMBALSODA"))
    if (void* const handle = dlopen((std::string(folder) + "/lib" + name + ".so").c_str(), RTLD_NOW))
      return reinterpret_cast<Numbalsoda>(dlsym(handle, (name + "_wrapper").c_str()));
#endif
  return nullptr;
}

}  // namespace bench
