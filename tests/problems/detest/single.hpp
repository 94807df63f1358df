#pragma once

#include <array>
#include <cmath>

#include "problems/detest/problem.hpp"

// Class A: single equations.

namespace problems::detest {

struct A1 : Problem<1> {
  static constexpr const char *name = "a1", *title = "A1, decay";
  static std::array<double, 1> start() { return {1}; }
  template <class T>
  static void rate(const T&, const T* y, T* out) {
    out[0] = -y[0];
  }
  static std::array<double, 1> exact() { return {2.0611536224385579e-09}; }
};

struct A2 : Problem<1> {
  static constexpr const char *name = "a2", *title = "A2, a special case of Riccati's equation";
  static std::array<double, 1> start() { return {1}; }
  template <class T>
  static void rate(const T&, const T* y, T* out) {
    out[0] = -y[0] * y[0] * y[0] / 2;
  }
  static std::array<double, 1> exact() { return {0.21821789023599239}; }
};

struct A3 : Problem<1> {
  static constexpr const char *name = "a3", *title = "A3, an oscillation";
  static std::array<double, 1> start() { return {1}; }
  template <class T>
  static void rate(const T& t, const T* y, T* out) {
    using std::cos;
    out[0] = y[0] * cos(t);
  }
  static std::array<double, 1> exact() { return {2.4916502718504145}; }
};

struct A4 : Problem<1> {
  static constexpr const char *name = "a4", *title = "A4, a logistic curve";
  static std::array<double, 1> start() { return {1}; }
  template <class T>
  static void rate(const T&, const T* y, T* out) {
    out[0] = y[0] * (1 - y[0] / 20) / 4;
  }
  static std::array<double, 1> exact() { return {17.730166481314839}; }
};

struct A5 : Problem<1> {
  static constexpr const char *name = "a5", *title = "A5, a spiral";
  static std::array<double, 1> start() { return {4}; }
  template <class T>
  static void rate(const T& t, const T* y, T* out) {
    out[0] = (y[0] - t) / (y[0] + t);
  }
  static std::array<double, 1> exact() { return {-0.78878266889640147}; }
};

}  // namespace problems::detest
