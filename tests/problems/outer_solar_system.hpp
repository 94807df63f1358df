#pragma once

#include <Eigen/Core>

#include <array>

#include "problems/ring_pairs.hpp"

namespace problems {

/// Sun with the inner planets, Jupiter, Saturn, Uranus, Neptune, Pluto over 200,000 days (Hairer, Lubich & Wanner, Geometric
/// Numerical Integration, sect. I.2.4; copies with -3.5025653 and -0.0017072 are misprinted). Astronomical units, days,
/// solar masses. Positions: six x, six y, six z.
struct OuterSolarSystem {
  using Vector = Eigen::Matrix<double, 18, 1>;
  static constexpr double end = 200000;  // [d]
  static constexpr double G = 2.95912208286e-4;
  static constexpr std::array<double, 6> masses{1.00000597682,      0.000954786104043,  0.000285583733151,
                                                0.0000437273164546, 0.0000517759138449, 1 / 1.3e8};

  [[nodiscard]] static Vector positions() {
    return Vector{{0, -3.5023653, 9.0755314, 8.3101420, 11.4707666, -15.5387357, 0, -3.8169847, -3.0458353, -16.2901086,
                   -25.7294829, -25.2225594, 0, -1.5507963, -1.6483708, -7.2521278, -10.8169456, -3.1902382}};
  }
  [[nodiscard]] static Vector velocities() {
    return Vector{{0, 0.00565429, 0.00168318, 0.00354178, 0.00288930, 0.00276725, 0, -0.00412490, 0.00483525,
                   0.00137102, 0.00114527, -0.00170702, 0, -0.00190589, 0.00192462, 0.00055029, 0.00039677,
                   -0.00136504}};
  }
  template <class T>
  static void acceleration(const T* r, T* a) {
    attract<6, 3>(pulls, r, a);
  }
  Vector operator()(const Vector& r) const {
    Vector a;
    acceleration(r.data(), a.data());
    return a;
  }

  /// At t = 200,000 d, by a symmetric composition of order 8 (Kahan & Li) in quadruple precision.
  [[nodiscard]] static Vector exact_positions() {
    return Vector{{1.23584254235460866e+00, 2.61107957011290504e+00, -7.66913624739120436e+00, -5.82474394984775401e+00,
                   2.06639802475150347e+01, 3.65669506988225024e+01, -4.89943821144274927e-01, -5.07952549678797372e+00,
                   -4.05205224548808829e+00, 1.53371737535725181e+01, 2.05829560424598554e+01, -1.37676844012597730e+01,
                   -2.46105361814321272e-01, -2.24472067785305285e+00, -1.33111566971149453e+00,
                   6.78246340991760643e+00, 7.89479541474819690e+00, -1.50434692218232779e+01}};
  }
  [[nodiscard]] static Vector exact_velocities() {
    return Vector{{-9.13437558160835769e-07, 7.17887892837591572e-03, 1.84479095624688204e-03, -3.65895005716157474e-03,
                   -2.39287456607262120e-03, 1.62992924842465629e-03, -3.23773810609494084e-06, 2.23357952607035337e-03,
                   -4.77280688348912571e-03, -1.55480383369646798e-03, 1.89046968181190672e-03, 2.10801156027822607e-03,
                   -1.40208020312685013e-06, 7.83748342939335585e-04, -2.05657904992822757e-03,
                   -6.29514555304220538e-04, 8.33321369757218373e-04, 1.68504842994412216e-04}};
  }

 private:
  static constexpr std::array<double, 6> pulls{G * masses[0], G* masses[1], G* masses[2],
                                               G* masses[3],  G* masses[4], G* masses[5]};
};

}  // namespace problems
