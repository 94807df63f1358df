#pragma once

#include <array>
#include <cmath>

#include "problems/detest/problem.hpp"

// Class D: a planet's orbit of eccentricity 0.1 … 0.9, about three rounds from its pericentre.

namespace problems::detest {

/// Eccentricity: tenths/10.
template <int tenths>
struct Orbit : Problem<4> {
  static std::array<double, 4> start() {
    constexpr double e = tenths / 10.0;
    return {1 - e, 0, 0, std::sqrt((1 + e) / (1 - e))};
  }
  template <class T>
  static void acceleration(const T* r, T* a) {
    using std::sqrt;
    const T square = r[0] * r[0] + r[1] * r[1], w = T(-1) / (square * sqrt(square));
    a[0] = w * r[0], a[1] = w * r[1];
  }
  template <class T>
  static void rate(const T&, const T* y, T* out) {
    out[0] = y[2], out[1] = y[3];
    acceleration(y, out + 2);
  }
};

struct D1 : Orbit<1> {
  static constexpr const char *name = "d1", *title = "D1, an orbit of eccentricity 0.1";
  static std::array<double, 4> exact() {
    return {0.21988353520084955, 0.9427076846341782, -0.97876598410581506, 0.32879779909621432};
  }
};
struct D2 : Orbit<3> {
  static constexpr const char *name = "d2", *title = "D2, an orbit of eccentricity 0.3";
  static std::array<double, 4> exact() {
    return {-0.17770273571403278, 0.9467784719905884, -1.0302941631929712, 0.12110748900540413};
  }
};
struct D3 : Orbit<5> {
  static constexpr const char *name = "d3", *title = "D3, an orbit of eccentricity 0.5";
  static std::array<double, 4> exact() {
    return {-0.57804329530354559, 0.86338400091941836, -0.95950837303806757, -0.065049151267128819};
  }
};
struct D4 : Orbit<7> {
  static constexpr const char *name = "d4", *title = "D4, an orbit of eccentricity 0.7";
  static std::array<double, 4> exact() {
    return {-0.95389902934161708, 0.69074090242194797, -0.82126742708775957, -0.15395742591257025};
  }
};
struct D5 : Orbit<9> {
  static constexpr const char *name = "d5", *title = "D5, an orbit of eccentricity 0.9";
  static std::array<double, 4> exact() {
    return {-1.2952662509875885, 0.40039389637922912, -0.67753909247074517, -0.12708381542787231};
  }
};

}  // namespace problems::detest
