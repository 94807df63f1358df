/// @file
/// Carries an exception out of an OpenMP region, where it would end the program.
#pragma once

#include <exception>

#include "phistep/core/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Threads run their shares of the work through it; behind the region, rethrow() throws the first exception of all, if
/// there was one. Compiled without OpenMP, an exception just passes.
class Relay {
 public:
  void run(auto&& share) {
#ifdef _OPENMP
    try {
      share();
    } catch (...) {
#pragma omp critical(phistep_relay)
      if (!first_) first_ = std::current_exception();
    }
#else
    share();
#endif
  }
  void rethrow() const {
    if (first_) std::rethrow_exception(first_);
  }

 private:
  std::exception_ptr first_;
};

}}  // namespace phistep::PHISTEP_ABI
