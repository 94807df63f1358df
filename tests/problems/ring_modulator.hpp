#pragma once

#include <Eigen/Core>

#include <array>
#include <cmath>

namespace problems {

/// The ring modulator: seven voltages, eight currents, four diodes, stray capacitances of 2 pF, to t = 1 ms (test set for IVP
/// solvers, II-7; Hairer & Wanner, Solving ODEs II, sect. IV.10).
struct RingModulator {
  using State = Eigen::Matrix<double, 15, 1>;
  static constexpr double end = 1e-3;

  [[nodiscard]] static State start() { return State::Zero(); }
  template <class Y, class Out>
  static void rate(double t, const Y& y, Out&& out) {
    const double u1 = 0.5 * std::sin(w1 * t);
    const auto q = diodes(t, y);
    out[0] = (y[7] - 0.5 * y[9] + 0.5 * y[10] + y[13] - y[0] / R) / C;
    out[1] = (y[8] - 0.5 * y[11] + 0.5 * y[12] + y[14] - y[1] / R) / C;
    out[2] = (y[9] - (q[0] - g) + (q[3] - g)) / Cs;
    out[3] = (-y[10] + (q[1] - g) - (q[2] - g)) / Cs;
    out[4] = (y[11] + (q[0] - g) - (q[2] - g)) / Cs;
    out[5] = (-y[12] - (q[1] - g) + (q[3] - g)) / Cs;
    out[6] = (-y[6] / Rp + (q[0] - g) + (q[1] - g) - (q[2] - g) - (q[3] - g)) / Cp;
    out[7] = -y[0] / Lh;
    out[8] = -y[1] / Lh;
    out[9] = (0.5 * y[0] - y[2] - Rg2 * y[9]) / Ls2;
    out[10] = (-0.5 * y[0] + y[3] - Rg2 * y[10]) / Ls2;
    out[11] = (0.5 * y[1] - y[4] - Rg2 * y[11]) / Ls2;
    out[12] = (-0.5 * y[1] + y[5] - Rg2 * y[12]) / Ls2;
    out[13] = (-y[0] + u1 - (Ri + Rg1) * y[13]) / Ls1;
    out[14] = (-y[1] - (Rc + Rg1) * y[14]) / Ls1;
  }
  template <class Y, class Put>
  static void entries(double t, const Y& y, Put&& put) {
    const auto q = diodes(t, y);
    const double a = delta * q[0], b = delta * q[1], c = delta * q[2], d = delta * q[3];
    put(0, 0, -1 / (R * C)), put(0, 7, 1 / C), put(0, 9, -0.5 / C), put(0, 10, 0.5 / C), put(0, 13, 1 / C);
    put(1, 1, -1 / (R * C)), put(1, 8, 1 / C), put(1, 11, -0.5 / C), put(1, 12, 0.5 / C), put(1, 14, 1 / C);
    put(2, 9, 1 / Cs), put(2, 2, -(a + d) / Cs), put(2, 4, a / Cs), put(2, 6, (a + d) / Cs), put(2, 5, -d / Cs);
    put(3, 10, -1 / Cs), put(3, 3, -(b + c) / Cs), put(3, 5, b / Cs), put(3, 6, -(b + c) / Cs), put(3, 4, -c / Cs);
    put(4, 11, 1 / Cs), put(4, 2, a / Cs), put(4, 4, -(a + c) / Cs), put(4, 6, -(a + c) / Cs), put(4, 3, -c / Cs);
    put(5, 12, -1 / Cs), put(5, 3, b / Cs), put(5, 5, -(b + d) / Cs), put(5, 6, (b + d) / Cs), put(5, 2, -d / Cs);
    put(6, 6, (-1 / Rp - a - b - c - d) / Cp), put(6, 2, (a + d) / Cp), put(6, 3, -(b + c) / Cp);
    put(6, 4, -(a + c) / Cp), put(6, 5, (b + d) / Cp);
    put(7, 0, -1 / Lh), put(8, 1, -1 / Lh);
    put(9, 0, 0.5 / Ls2), put(9, 2, -1 / Ls2), put(9, 9, -Rg2 / Ls2);
    put(10, 0, -0.5 / Ls2), put(10, 3, 1 / Ls2), put(10, 10, -Rg2 / Ls2);
    put(11, 1, 0.5 / Ls2), put(11, 4, -1 / Ls2), put(11, 11, -Rg2 / Ls2);
    put(12, 1, -0.5 / Ls2), put(12, 5, 1 / Ls2), put(12, 12, -Rg2 / Ls2);
    put(13, 0, -1 / Ls1), put(13, 13, -(Ri + Rg1) / Ls1), put(14, 1, -1 / Ls1), put(14, 14, -(Rc + Rg1) / Ls1);
  }

  /// In quadruple precision.
  [[nodiscard]] static State exact() {
    return State{{-2.33905735843722221e-02, -7.36748548600810269e-03, 2.58295670999160398e-01, -4.06446572058832001e-01,
                  -4.03945566445575388e-01, 2.60796676612417122e-01, 1.10676186127337470e-01, 2.93990434243299931e-07,
                  -2.84002993306648366e-08, 7.26719826729208657e-04, 7.92948719702412600e-04, -7.25528349576674489e-04,
                  -7.94140196854946768e-04, 7.08849541687559367e-05, 2.39005907527713995e-05}};
  }

 private:
  static constexpr double C = 1.6e-8, Cs = 2e-12, Cp = 1e-8, Lh = 4.45, Ls1 = 2e-3, Ls2 = 5e-4, g = 40.67286402e-9;
  static constexpr double R = 25000, Rp = 50, Rg1 = 36.3, Rg2 = 17.3, Ri = 50, Rc = 600, delta = 17.7493332;
  static constexpr double w1 = 6283.185307179586, w2 = 62831.85307179586;
  /// γ exp(δ U) of the four diodes
  template <class Y>
  static std::array<double, 4> diodes(double t, const Y& y) {
    const double u2 = 2 * std::sin(w2 * t);
    return {g * std::exp(delta * (y[2] - y[4] - y[6] - u2)), g * std::exp(delta * (-y[3] + y[5] - y[6] - u2)),
            g * std::exp(delta * (y[3] + y[4] + y[6] + u2)), g * std::exp(delta * (-y[2] - y[5] + y[6] + u2))};
  }
};

}  // namespace problems
