#pragma once

// Runs of equal or given steps, straight through stepper.step, and the distance between two states.

#include <Eigen/Core>
#include <phistep/phistep.hpp>

#include <cmath>
#include <stdexcept>
#include <vector>

namespace problems {

/// One step that has to succeed: a failed one must not pass for an inaccurate one.
template <class Stepper, class S, class T>
void step(Stepper& stepper, S& y, T t, T h) {
  if (const auto done = stepper.step(y, t, h); !done) throw std::runtime_error(done.message());
}

/// n equal steps from t0 to t1.
template <class Stepper, class S, class T>
[[nodiscard]] S march(Stepper&& stepper, S y, T t0, T t1, int n) {
  const T h = (t1 - t0) / static_cast<T>(n);
  for (int k = 0; k < n; ++k) step(stepper, y, t0 + static_cast<T>(k) * h, h);
  return y;
}

/// Steps from each time to the next.
template <class Stepper, class S>
[[nodiscard]] S march(Stepper&& stepper, S y, const std::vector<double>& times) {
  for (std::size_t k = 1; k < times.size(); ++k) step(stepper, y, times[k - 1], times[k] - times[k - 1]);
  return y;
}

template <class A, class B>
[[nodiscard]] double distance(const Eigen::DenseBase<A>& a, const Eigen::DenseBase<B>& b) {
  return static_cast<double>((a.derived() - b.derived()).norm());
}
template <class V>
[[nodiscard]] double distance(const phistep::Motion<V>& a, const phistep::Motion<V>& b) {
  return std::hypot(distance(a.r, b.r), distance(a.v, b.v));
}

}  // namespace problems
