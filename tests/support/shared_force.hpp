#pragma once

// Forces of a few types that tests share. Each lambda has a type of its own, and each type of force is a stepper that is
// compiled anew (0.4 s and more); `OfState<Vec> f = [](const Vec& y) -> Vec { return -y; };` makes them one.

#include <functional>

namespace shared_force {

template <class V>
using OfState = std::function<V(const V&)>;  ///< Ψ(y) or Ψ(r)
template <class V, class T = double>
using OfStateAndTime = std::function<V(const V&, T)>;  ///< Ψ(y, t)
template <class V>
using OfMotion = std::function<V(const V&, const V&)>;  ///< Ψ(r, v)
template <class V, class T = double>
using OfMotionAndTime = std::function<V(const V&, const V&, T)>;  ///< Ψ(r, v, t)

}  // namespace shared_force
