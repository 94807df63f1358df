#pragma once

// Smooth problems that are not DETEST's, of the same form (problems/detest/problem.hpp).

#include <array>
#include <cmath>

#include "problems/detest/problem.hpp"

namespace problems::smooth {

using detest::Problem;

/// Prey and predators over two periods (A. J. Lotka; V. Volterra).
struct LotkaVolterra : Problem<2> {
  static constexpr const char *name = "lotka_volterra", *title = "Lotka-Volterra";
  static constexpr double end = 10;
  static std::array<double, 2> start() { return {1, 1}; }
  template <class T>
  static void rate(const T&, const T* y, T* out) {
    const T met = y[0] * y[1];
    out[0] = 1.5 * y[0] - met;
    out[1] = met - 3 * y[1];
  }
  static std::array<double, 2> exact() { return {1.0263447675750894, 0.90969107813604166}; }
};

/// Euler's equations for moments of inertia 1/2, 2, 3, without the torque that jumps (Hairer, Nørsett & Wanner, Solving
/// ODEs I, sect. II.10, EULR).
struct RigidBody : Problem<3> {
  static constexpr const char *name = "rigid_body", *title = "rigid body";
  static std::array<double, 3> start() { return {1, 0, 0.9}; }
  template <class T>
  static void rate(const T&, const T* y, T* out) {
    out[0] = -2 * y[1] * y[2];
    out[1] = 1.25 * y[0] * y[2];
    out[2] = -0.5 * y[0] * y[1];
  }
  static std::array<double, 3> exact() { return {0.60620385396481158, 0.62874721045017834, 0.80738514857560251}; }
};

/// A = 1, B = 3, about three rounds of the limit cycle (Hairer, Nørsett & Wanner, Solving ODEs I, sect. II.4).
struct Brusselator : Problem<2> {
  static constexpr const char *name = "brusselator", *title = "Brusselator";
  static std::array<double, 2> start() { return {1.5, 3}; }
  template <class T>
  static void rate(const T&, const T* y, T* out) {
    const T q = y[0] * y[0] * y[1];
    out[0] = 1 + q - 4 * y[0];
    out[1] = 3 * y[0] - q;
  }
  static std::array<double, 2> exact() { return {0.49863707126834783, 4.5967803494520112}; }
};

/// Restricted three bodies, Arenstorf's orbit of period `end` (Hairer, Nørsett & Wanner, Solving ODEs I, eq. II.0.1).
struct Arenstorf : Problem<4> {
  static constexpr const char *name = "arenstorf", *title = "restricted three bodies";
  static constexpr double end = 17.0652165601579625588917206249;
  static std::array<double, 4> start() { return {0.994, 0, 0, -2.00158510637908252240537862224}; }
  template <class T>
  static void acceleration(const T* r, const T* v, T* a) {
    using std::sqrt;
    constexpr double mu = 0.012277471, rest = 1 - mu;
    const T x1 = r[0] + mu, x2 = r[0] - rest, square = r[1] * r[1], s1 = x1 * x1 + square, s2 = x2 * x2 + square;
    const T w1 = rest / (s1 * sqrt(s1)), w2 = mu / (s2 * sqrt(s2));
    a[0] = r[0] + 2 * v[1] - w1 * x1 - w2 * x2;
    a[1] = r[1] - 2 * v[0] - (w1 + w2) * r[1];
  }
  template <class T>
  static void rate(const T&, const T* y, T* out) {
    out[0] = y[2], out[1] = y[3];
    acceleration(y, y + 2, out + 2);
  }
  static std::array<double, 4> exact() {
    return {0.99399999999990885, -3.0309430229824518e-13, -4.9285365810551075e-11, -2.0015851063932701};
  }
};

/// E. N. Lorenz, J. Atmos. Sci. 20 (1963) 130: on the attractor, until errors have grown 2e4-fold.
struct Lorenz : Problem<3> {
  static constexpr const char *name = "lorenz", *title = "Lorenz";
  static std::array<double, 3> start() { return {1, 1, 1}; }
  template <class T>
  static void rate(const T&, const T* y, T* out) {
    constexpr double b = 8.0 / 3;
    out[0] = 10 * (y[1] - y[0]);
    out[1] = y[0] * (28 - y[2]) - y[1];
    out[2] = y[0] * y[1] - b * y[2];
  }
  static std::array<double, 3> exact() { return {13.793195995130381, 12.951803936192500, 34.901608681136812}; }
};

/// A satellite 400 km above the Earth for 22 h: its oblateness (J₂) and the drag of a rotating exponential atmosphere (D. A.
/// Vallado, Fundamentals of Astrodynamics and Applications, sect. 8.6). Lengths in Earth radii R, times in √(R³/GM).
struct Satellite : Problem<6> {
  static constexpr const char *name = "satellite", *title = "satellite, J2 and drag";
  static constexpr double end = 100;
  static std::array<double, 6> start() { return {1.07, 0, 0, 0, 0.62, 0.75}; }
  template <class T>
  static void acceleration(const T* r, const T* v, T* a) {
    using std::exp;
    using std::sqrt;
    constexpr double J2 = 1.08262668e-3, turn = 0.058834, height = 0.0627145, scale = 0.0091743, drag = 2.6e-7;
    const T per_square = 1 / (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]), per_r = sqrt(per_square);
    const T w = -per_square * per_r, bulge = 1.5 * J2 * per_square, z = 5 * r[2] * r[2] * per_square;
    const T x = v[0] + turn * r[1], y = v[1] - turn * r[0];  // against the air
    const T slow = -drag * exp(T((1 + height - 1 / per_r) / scale)) * sqrt(T(x * x + y * y + v[2] * v[2]));
    a[0] = w * r[0] * (1 + bulge * (1 - z)) + slow * x;
    a[1] = w * r[1] * (1 + bulge * (1 - z)) + slow * y;
    a[2] = w * r[2] * (1 + bulge * (3 - z)) + slow * v[2];
  }
  template <class T>
  static void rate(const T&, const T* y, T* out) {
    out[0] = y[3], out[1] = y[4], out[2] = y[5];
    acceleration(y, y + 3, out + 3);
  }
  static std::array<double, 6> exact() {
    return {0.77517782559140491,  0.43731081038203001, 0.59991585235431044,
            -0.66251977224131275, 0.48204474831490224, 0.51861602892020375};
  }
};

}  // namespace problems::smooth

namespace problems {

/// f(P{}) for a problem P of each.
template <class F>
void for_each_smooth(F&& f) {
  using namespace smooth;
  f(LotkaVolterra{}), f(RigidBody{}), f(Brusselator{}), f(Arenstorf{}), f(Lorenz{}), f(Satellite{});
}

}  // namespace problems
