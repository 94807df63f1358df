#pragma once

#include <Eigen/Core>

#include "problems/entries.hpp"

namespace problems {

/// Air pollution: 25 reactions of 20 species, rates from 1e-4 to 4e11, to t = 60 (Verwer 1994; test set for IVP solvers, 2.4:
/// "Pollution problem"; r₂₄ is y₁₉ y₁, r₂₅ is y₂₀, where some copies have them exchanged).
struct Pollution {
  using State = Eigen::Matrix<double, 20, 1>;
  static constexpr double end = 60;

  [[nodiscard]] static State start() {
    State y = State::Zero();
    y[1] = 0.2, y[3] = 0.04, y[6] = 0.1, y[7] = 0.3, y[8] = 0.01, y[16] = 0.007;
    return y;
  }
  template <class Y, class Out>
  static void rate(const Y& y, Out&& out) {
    const auto r1 = 0.35 * y[0];
    const auto r2 = 26.6 * y[1] * y[3];
    const auto r3 = 1.23e4 * y[4] * y[1];
    const auto r4 = 8.6e-4 * y[6];
    const auto r5 = 8.2e-4 * y[6];
    const auto r6 = 1.5e4 * y[6] * y[5];
    const auto r7 = 1.3e-4 * y[8];
    const auto r8 = 2.4e4 * y[8] * y[5];
    const auto r9 = 1.65e4 * y[10] * y[1];
    const auto r10 = 9e3 * y[10] * y[0];
    const auto r11 = 0.022 * y[12];
    const auto r12 = 1.2e4 * y[9] * y[1];
    const auto r13 = 1.88 * y[13];
    const auto r14 = 1.63e4 * y[0] * y[5];
    const auto r15 = 4.8e6 * y[2];
    const auto r16 = 3.5e-4 * y[3];
    const auto r17 = 0.0175 * y[3];
    const auto r18 = 1e8 * y[15];
    const auto r19 = 4.44e11 * y[15];
    const auto r20 = 1240.0 * y[16] * y[5];
    const auto r21 = 2.1 * y[18];
    const auto r22 = 5.78 * y[18];
    const auto r23 = 0.0474 * y[0] * y[3];
    const auto r24 = 1780.0 * y[18] * y[0];
    const auto r25 = 3.12 * y[19];
    out[0] = r2 + r3 + r9 + r11 + r12 + r22 + r25 - r1 - r10 - r14 - r23 - r24;
    out[1] = r1 + r21 - r2 - r3 - r9 - r12;
    out[2] = r1 + r17 + r19 + r22 - r15;
    out[3] = r15 - r2 - r16 - r17 - r23;
    out[4] = 2 * r4 + r6 + r7 + r13 + r20 - r3;
    out[5] = r3 + 2 * r18 - r6 - r8 - r14 - r20;
    out[6] = r13 - r4 - r5 - r6;
    out[7] = r4 + r5 + r6 + r7;
    out[8] = -r7 - r8;
    out[9] = r7 + r9 - r12;
    out[10] = r8 + r11 - r9 - r10;
    out[11] = r9;
    out[12] = r10 - r11;
    out[13] = r12 - r13;
    out[14] = r14;
    out[15] = r16 - r18 - r19;
    out[16] = -r20;
    out[17] = r20;
    out[18] = r23 + r25 - r21 - r22 - r24;
    out[19] = r24 - r25;
  }
  template <class Y, class Put>
  static constexpr void entries(const Y& y, Put&& put) {
    // r2_1 is ∂r₂/∂y₁, and so on.
    const auto r2_1 = 26.6 * y[3], r2_3 = 26.6 * y[1], r3_4 = 1.23e4 * y[1], r3_1 = 1.23e4 * y[4], r6_6 = 1.5e4 * y[5],
               r6_5 = 1.5e4 * y[6], r8_8 = 2.4e4 * y[5], r8_5 = 2.4e4 * y[8], r9_10 = 1.65e4 * y[1],
               r9_1 = 1.65e4 * y[10], r10_10 = 9e3 * y[0], r10_0 = 9e3 * y[10], r12_9 = 1.2e4 * y[1],
               r12_1 = 1.2e4 * y[9], r14_0 = 1.63e4 * y[5], r14_5 = 1.63e4 * y[0], r20_16 = 1240.0 * y[5],
               r20_5 = 1240.0 * y[16], r23_0 = 0.0474 * y[3], r23_3 = 0.0474 * y[0], r24_18 = 1780.0 * y[0],
               r24_0 = 1780.0 * y[18];
    put(0, 0, -0.35 - r10_0 - r14_0 - r23_0 - r24_0);
    put(1, 0, 0.35);
    put(2, 0, 0.35);
    put(3, 0, -r23_0);
    put(5, 0, -r14_0);
    put(10, 0, -r10_0);
    put(12, 0, r10_0);
    put(14, 0, r14_0);
    put(18, 0, r23_0 - r24_0);
    put(19, 0, r24_0);
    put(0, 1, r2_1 + r3_1 + r9_1 + r12_1);
    put(1, 1, -r2_1 - r3_1 - r9_1 - r12_1);
    put(3, 1, -r2_1);
    put(4, 1, -r3_1);
    put(5, 1, r3_1);
    put(9, 1, r9_1 - r12_1);
    put(10, 1, -r9_1);
    put(11, 1, r9_1);
    put(13, 1, r12_1);
    put(2, 2, -4.8e6);
    put(3, 2, 4.8e6);
    put(0, 3, r2_3 - r23_3);
    put(1, 3, -r2_3);
    put(2, 3, 0.0175);
    put(3, 3, -r2_3 - 3.5e-4 - 0.0175 - r23_3);
    put(15, 3, 3.5e-4);
    put(18, 3, r23_3);
    put(0, 4, r3_4);
    put(1, 4, -r3_4);
    put(4, 4, -r3_4);
    put(5, 4, r3_4);
    put(0, 5, -r14_5);
    put(4, 5, r6_5 + r20_5);
    put(5, 5, -r6_5 - r8_5 - r14_5 - r20_5);
    put(6, 5, -r6_5);
    put(7, 5, r6_5);
    put(8, 5, -r8_5);
    put(10, 5, r8_5);
    put(14, 5, r14_5);
    put(16, 5, -r20_5);
    put(17, 5, r20_5);
    put(4, 6, 2 * 8.6e-4 + r6_6);
    put(5, 6, -r6_6);
    put(6, 6, -8.6e-4 - 8.2e-4 - r6_6);
    put(7, 6, 8.6e-4 + 8.2e-4 + r6_6);

    put(4, 8, 1.3e-4);
    put(5, 8, -r8_8);
    put(7, 8, 1.3e-4);
    put(8, 8, -1.3e-4 - r8_8);
    put(9, 8, 1.3e-4);
    put(10, 8, r8_8);
    put(0, 9, r12_9);
    put(1, 9, -r12_9);
    put(9, 9, -r12_9);
    put(13, 9, r12_9);
    put(0, 10, r9_10 - r10_10);
    put(1, 10, -r9_10);
    put(9, 10, r9_10);
    put(10, 10, -r9_10 - r10_10);
    put(11, 10, r9_10);
    put(12, 10, r10_10);

    put(0, 12, 0.022);
    put(10, 12, 0.022);
    put(12, 12, -0.022);
    put(4, 13, 1.88);
    put(6, 13, 1.88);
    put(13, 13, -1.88);

    put(2, 15, 4.44e11);
    put(5, 15, 2 * 1e8);
    put(15, 15, -1e8 - 4.44e11);
    put(4, 16, r20_16);
    put(5, 16, -r20_16);
    put(16, 16, -r20_16);
    put(17, 16, r20_16);

    put(0, 18, 5.78 - r24_18);
    put(1, 18, 2.1);
    put(2, 18, 5.78);
    put(18, 18, -2.1 - 5.78 - r24_18);
    put(19, 18, r24_18);
    put(0, 19, 3.12);
    put(18, 19, 3.12);
    put(19, 19, -3.12);
  }
  State operator()(const State& y) const {
    State out;
    rate(y, out);
    return out;
  }
  [[nodiscard]] Eigen::Matrix<double, 20, 20> jacobian(const State& y) const { return dense_jacobian<Pollution>(y); }

  /// At t = 60, by Radau IIA in quadruple precision; the published values agree.
  [[nodiscard]] static State exact() {
    return State{{5.64625548002276947e-02, 1.34248413042233866e-01, 4.13973433109942663e-09, 5.52314020748435885e-03,
                  2.01897726230219596e-07, 1.46454186349396573e-07, 7.78424911899796429e-02, 3.24507535339601805e-01,
                  7.49401338388040565e-03, 1.62229315730156020e-08, 1.13586383325707477e-08, 2.23050597572135986e-03,
                  2.08716288279863020e-04, 1.39692101684015788e-05, 8.96488485689829473e-03, 4.35284636933010302e-18,
                  6.89921969626340528e-03, 1.00780303736594599e-04, 1.77214651396998423e-06, 5.68294329231639256e-05}};
  }
};

}  // namespace problems
