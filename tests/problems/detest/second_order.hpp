#pragma once

#include <array>
#include <cmath>

#include "problems/detest/problem.hpp"

// Class E: equations of second order as systems of first order.

namespace problems::detest {

struct E1 : Problem<2> {
  static constexpr const char *name = "e1", *title = "E1, Bessel's equation of order 1/2";
  static std::array<double, 2> start() { return {0.6713967071418030, 0.09540051444747446}; }
  template <class T>
  static void rate(const T& t, const T* y, T* out) {
    const T w = 1 / (t + 1);
    out[0] = y[1];
    out[1] = -(y[1] * w + (1 - 0.25 * w * w) * y[0]);
  }
  static std::array<double, 2> exact() { return {0.14567236007282466, -0.09883500195574578}; }
};

struct E2 : Problem<2> {
  static constexpr const char *name = "e2", *title = "E2, Van der Pol's equation";
  static std::array<double, 2> start() { return {2, 0}; }
  template <class T>
  static void rate(const T&, const T* y, T* out) {
    out[0] = y[1];
    out[1] = (1 - y[0] * y[0]) * y[1] - y[0];
  }
  static std::array<double, 2> exact() { return {2.0081497621749484, -0.04250887527320215}; }
};

struct E3 : Problem<2> {
  static constexpr const char *name = "e3", *title = "E3, Duffing's equation";
  static std::array<double, 2> start() { return {0, 0}; }
  template <class T>
  static void rate(const T& t, const T* y, T* out) {
    using std::sin;
    out[0] = y[1];
    out[1] = y[0] * y[0] * y[0] / 6 - y[0] + 2 * sin(T(2.78535 * t));
  }
  static std::array<double, 2> exact() { return {-0.10041788586472507, 0.24114001320959341}; }
};

struct E4 : Problem<2> {
  static constexpr const char *name = "e4", *title = "E4, a falling body";
  static std::array<double, 2> start() { return {30, 0}; }
  template <class T>
  static void rate(const T&, const T* y, T* out) {
    out[0] = y[1];
    out[1] = 0.032 - 0.4 * y[1] * y[1];
  }
  static std::array<double, 2> exact() { return {33.950914446465561, 0.27678226596728678}; }
};

struct E5 : Problem<2> {
  static constexpr const char *name = "e5", *title = "E5, linear pursuit";
  static std::array<double, 2> start() { return {0, 0}; }
  template <class T>
  static void rate(const T& t, const T* y, T* out) {
    using std::sqrt;
    out[0] = y[1];
    out[1] = sqrt(T(1 + y[1] * y[1])) / (25 - t);
  }
  static std::array<double, 2> exact() { return {14.117973905426254, 2.3999999999999999}; }
};

}  // namespace problems::detest
