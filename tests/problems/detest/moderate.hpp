#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "problems/detest/problem.hpp"

// Class C: systems of moderate size.

namespace problems::detest {

struct C1 : Problem<10> {
  static constexpr const char *name = "c1", *title = "C1, a chain of decays";
  static std::array<double, 10> start() { return {1}; }
  template <class T>
  static void rate(const T&, const T* y, T* out) {
    out[0] = -y[0];
    for (std::size_t i = 1; i < 9; ++i) out[i] = y[i - 1] - y[i];
    out[9] = y[8];
  }
  static std::array<double, 10> exact() {
    return {2.0611536224385579e-09, 4.1223072448771159e-08, 4.1223072448771158e-07, 2.7482048299180773e-06,
            1.3741024149590386e-05, 5.4964096598361543e-05, 0.0001832136553278718,  0.00052346758665106226,
            0.0013086689666276558,  0.99791274095086502};
  }
};

struct C2 : Problem<10> {
  static constexpr const char *name = "c2", *title = "C2, a chain of ever faster decays";
  static std::array<double, 10> start() { return {1}; }
  template <class T>
  static void rate(const T&, const T* y, T* out) {
    out[0] = -y[0];
    for (int i = 1; i < 9; ++i) out[i] = i * y[i - 1] - (i + 1) * y[i];
    out[9] = 9 * y[8];
  }
  static std::array<double, 10> exact() {
    return {2.0611536224385579e-09, 2.0611536181902037e-09, 2.0611536139418492e-09, 2.0611536096934951e-09,
            2.0611536054451409e-09, 2.0611536011967868e-09, 2.0611535969484323e-09, 2.0611535927000781e-09,
            2.061153588451724e-09,  0.99999998144961755};
  }
};

/// y_i' = y_{i−1} − 2 y_i + y_{i+1}
template <std::size_t points>
struct Diffusion : Problem<points> {
  static std::array<double, points> start() { return {1}; }
  template <class T>
  static void rate(const T&, const T* y, T* out) {
    out[0] = y[1] - 2 * y[0];
    for (std::size_t i = 1; i + 1 < points; ++i) out[i] = y[i - 1] - 2 * y[i] + y[i + 1];
    out[points - 1] = y[points - 2] - 2 * y[points - 1];
  }
};

struct C3 : Diffusion<10> {
  static constexpr const char *name = "c3", *title = "C3, diffusion on 10 points";
  static std::array<double, 10> exact() {
    return {0.0029481192110226992, 0.005635380154845296,  0.0078290725159270384, 0.0093482579085955968,
            0.010079436103019805,  0.0099826741714294891, 0.0090886933327653328, 0.0074891151951850853,
            0.0053229641309526753, 0.0027624343790295146};
  }
};

struct C4 : Diffusion<51> {
  static constexpr const char *name = "c4", *title = "C4, diffusion on 51 points";
  static std::array<double, 51> exact() {
    return {0.003124111453722103,   0.0060154168421513226,  0.0084700218348436104,  0.010336829317333924,
            0.011532495728739203,   0.012045495257379123,   0.011929570680152192,   0.011288832071111289,
            0.010258045013909881,   0.0089820175819341694,  0.0075975009024927282,  0.0062199205568253674,
            0.0049359163410094622,  0.0038014325442563049,  0.0028442136775879202,  0.0020691233942225834,
            0.0014646872828437804,  0.001009545263941004,   0.00067793543302262455, 0.00044378152691182426,
            0.00028332645429390634, 0.00017650057987970974, 0.000107334259269755,   6.3744976017795547e-05,
            3.6986453097054486e-05, 2.0974668326441009e-05, 1.1629567104123481e-05, 6.3067104057789836e-06,
            3.3462864308642114e-06, 1.7377600741811661e-06, 8.8353669042576301e-07, 4.3995204111202298e-07,
            2.1461818971516788e-07, 1.0259812116573905e-07, 4.8078640688164997e-08, 2.2091751525026646e-08,
            9.9562512633320337e-09, 4.4021936538630749e-09, 1.9101493822598891e-09, 8.1358929216748103e-10,
            3.4024771185674608e-10, 1.3974856174900842e-10, 5.6385753023372392e-11, 2.2354597073415191e-11,
            8.7104980319035062e-12, 3.3365542723879094e-12, 1.2566795659787626e-12, 4.6543590427571278e-13,
            1.6935591399749388e-13, 5.9965937883867124e-14, 1.8913306910279898e-14};
  }
};

/// Jupiter, Saturn, Uranus, Neptune and Pluto about the sun: the constants of 1972. Five times (x, y, z), then their
/// velocities.
struct C5 : Problem<30> {
  static constexpr const char *name = "c5", *title = "C5, five planets";
  static std::array<double, 30> start() {
    return {3.42947415189,    3.35386959711,   1.35494901715,   6.64145542550,   5.97156957878,   2.18231499728,
            11.2630437207,    14.6952576794,   6.27960525067,   -30.1552268759,  1.65699966404,   1.43785752721,
            -21.1238353380,   28.4465098142,   15.3882659679,   -0.557160570446, 0.505696783289,  0.230578543901,
            -0.415570776342,  0.365682722812,  0.169143213293,  -0.325325669158, 0.189706021964,  0.0877265322780,
            -0.0240476254170, -0.287659532608, -0.117219543175, -0.176860753121, -0.216393453025, -0.0148647893090};
  }
  /// r_j'' = k₂ (−(m₀ + m_j) r_j/|r_j|³ + Σ_{k≠j} m_k ((r_k − r_j)/|r_k − r_j|³ − r_k/|r_k|³))
  template <class T>
  static void acceleration(const T* r, T* a) {
    using std::sqrt;
    constexpr double k2 = 2.95912208286, m0 = 1.00000597682;
    constexpr std::array<double, 5> m{0.000954786104043, 0.000285583733151, 0.0000437273164546, 0.0000517759138449,
                                      0.00000277777777778};
    std::array<T, 3> sun{};  // Σ m_k r_k/|r_k|³, which every planet is taken along with
    for (std::size_t j = 0; j < 5; ++j) {
      const T* x = r + 3 * j;
      const T square = x[0] * x[0] + x[1] * x[1] + x[2] * x[2], w = 1 / (square * sqrt(square));
      for (std::size_t i = 0; i < 3; ++i) {
        sun[i] += m[j] * w * x[i];
        a[3 * j + i] = -m0 * w * x[i];
      }
    }
    for (std::size_t j = 0; j < 5; ++j)
      for (std::size_t k = j + 1; k < 5; ++k) {
        const T *x = r + 3 * j, *y = r + 3 * k;
        const T dx = y[0] - x[0], dy = y[1] - x[1], dz = y[2] - x[2], square = dx * dx + dy * dy + dz * dz;
        const T w = 1 / (square * sqrt(square)), to_j = m[k] * w, to_k = m[j] * w;
        a[3 * j] += to_j * dx, a[3 * j + 1] += to_j * dy, a[3 * j + 2] += to_j * dz;
        a[3 * k] -= to_k * dx, a[3 * k + 1] -= to_k * dy, a[3 * k + 2] -= to_k * dz;
      }
    for (std::size_t i = 0; i < 15; ++i) a[i] = k2 * (a[i] - sun[i % 3]);
  }
  template <class T>
  static void rate(const T&, const T* y, T* out) {
    std::copy(y + 15, y + 30, out);
    acceleration(y, out + 15);
  }
  static std::array<double, 30> exact() {
    return {
        -4.7927302243236358,   -2.4205507254490213,  -0.92125093060151153, -4.2173104040352136,  7.3562029474989687,
        3.2237859854212112,    4.0355594432622715,   17.198655286705549,   7.4789107942337028,   -29.987593263248442,
        -4.1073109375509294,   -0.92770083217544075, -24.421253025184829,  23.814590457465542,   14.920963069513588,
        0.34992089630639961,   -0.57484876879128033, -0.25516940208791444, -0.52370409789033256, -0.24930004635796629,
        -0.080453416420444707, -0.38752892373341097, 0.056486032887678908, 0.030236064721433416, 0.041338565467124472,
        -0.28623930298413791,  -0.11830324051362069, -0.15119864573592057, -0.24600688943187654, -0.031896874113238771};
  }
};

}  // namespace problems::detest
