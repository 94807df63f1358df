// How far a run has come: an observer that writes a line for each tenth done, with the time left.
#pragma once

#include <chrono>
#include <cstdio>

/// `integrate(…, progress(t1))` of a run from 0 to t1
inline auto progress(double t1) {
  using Clock = std::chrono::steady_clock;
  return [t1, began = Clock::now(), tenths = 0](double t, const auto& /*state*/) mutable {
    const double done = t / t1 + 1e-9;  // a step that ends at a tenth may miss it by its last bits
    if (10 * done < tenths + 1) return;
    tenths = static_cast<int>(10 * done);
    const double seconds = std::chrono::duration<double>(Clock::now() - began).count();
    std::fprintf(stderr, "%4d %%  t = %.4g, %.0f s left\n", 10 * tenths, t, seconds * (t1 - t) / t);
  };
}
