#pragma once

#include <array>
#include <cmath>

#include "problems/detest/problem.hpp"

// Class B: small systems.

namespace problems::detest {

struct B1 : Problem<2> {
  static constexpr const char *name = "b1", *title = "B1, two populations in conflict";
  static std::array<double, 2> start() { return {1, 3}; }
  template <class T>
  static void rate(const T&, const T* y, T* out) {
    const T met = y[0] * y[1];
    out[0] = 2 * (y[0] - met);
    out[1] = met - y[1];
  }
  static std::array<double, 2> exact() { return {0.67618760085766061, 0.18608160996400297}; }
};

struct B2 : Problem<3> {
  static constexpr const char *name = "b2", *title = "B2, a linear reaction";
  static std::array<double, 3> start() { return {2, 0, 1}; }
  template <class T>
  static void rate(const T&, const T* y, T* out) {
    out[0] = -y[0] + y[1];
    out[1] = y[0] - 2 * y[1] + y[2];
    out[2] = y[1] - y[2];
  }
  static std::array<double, 3> exact() { return {1.0000000010305767, 1, 0.99999999896942315}; }
};

struct B3 : Problem<3> {
  static constexpr const char *name = "b3", *title = "B3, a nonlinear reaction";
  static std::array<double, 3> start() { return {1, 0, 0}; }
  template <class T>
  static void rate(const T&, const T* y, T* out) {
    const T square = y[1] * y[1];
    out[0] = -y[0];
    out[1] = y[0] - square;
    out[2] = square;
  }
  static std::array<double, 3> exact() { return {2.0611536224385579e-09, 0.052572280220485122, 0.94742771771836121}; }
};

struct B4 : Problem<3> {
  static constexpr const char *name = "b4", *title = "B4, the integral surface of a torus";
  static std::array<double, 3> start() { return {3, 0, 0}; }
  template <class T>
  static void rate(const T&, const T* y, T* out) {
    using std::sqrt;
    const T per_r = 1 / sqrt(y[0] * y[0] + y[1] * y[1]);
    out[0] = -y[1] - y[0] * y[2] * per_r;
    out[1] = y[0] - y[1] * y[2] * per_r;
    out[2] = y[0] * per_r;
  }
  static std::array<double, 3> exact() { return {0.98269509280065304, 2.1984470816949298, 0.91294525072762767}; }
};

struct B5 : Problem<3> {
  static constexpr const char *name = "b5", *title = "B5, a rigid body without forces";
  static std::array<double, 3> start() { return {0, 1, 1}; }
  template <class T>
  static void rate(const T&, const T* y, T* out) {
    out[0] = y[1] * y[2];
    out[1] = -y[0] * y[2];
    out[2] = -0.51 * y[0] * y[1];
  }
  static std::array<double, 3> exact() { return {-0.93965707987292035, -0.34211777540007499, 0.74141265961999536}; }
};

}  // namespace problems::detest
