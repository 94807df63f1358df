#pragma once

#include <petscsys.h>

/// PETSc starts once; it must not take the signals.
inline void start_petsc() {
  static const bool once = [] {
    PetscOptionsSetValue(nullptr, "-no_signal_handler", "1");
    return PetscInitialize(nullptr, nullptr, nullptr, nullptr) == 0;
  }();
  static_cast<void>(once);
}
