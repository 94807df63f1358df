#pragma once

#include <Eigen/Core>
#include <phistep/phistep.hpp>

#include <cmath>
#include <type_traits>
#include <vector>

namespace problems {

/// The Brusselator with diffusion in one dimension (Hairer & Wanner, Solving ODEs II, sect. IV.10, BRUSS), A = 1, B = 3,
/// α = 1/50, at 500 inner points: u_t = A + u²v − (B+1) u + α u_xx, v_t = B u − u²v + α v_xx; u = 1 and v = 3 at both
/// ends. Unknowns u₀ v₀ u₁ v₁ …: a band.
struct Brusselator1D : phistep::ForceTerm {
  using State = Eigen::VectorXd;
  static constexpr int points = 500;
  static constexpr double end = 10;
  static constexpr double diffusion = 0.02 * (points + 1) * (points + 1);  // α/Δx²

  static constexpr bool uses_time = false;
  static constexpr phistep::Structure structure = phistep::Structure::banded;

  [[nodiscard]] static State start() {
    State y(2 * points);
    for (int i = 0; i < points; ++i) {
      y[2 * i] = 1 + std::sin(6.283185307179586 * (i + 1.0) / (points + 1));
      y[2 * i + 1] = 3;
    }
    return y;
  }
  void add(auto /*t*/, const auto& state, auto& out) const {
    const auto* const y = state.y.data();
    auto* const rate = out.rate.data();
    using Scalar = std::remove_cvref_t<decltype(*rate)>;
    const auto at = [&](int i, Scalar ul, Scalar vl, Scalar ur, Scalar vr) {
      const Scalar u = y[2 * i], v = y[2 * i + 1], q = u * u * v;
      rate[2 * i] += 1 + q - 4 * u + diffusion * (ul - 2 * u + ur);
      rate[2 * i + 1] += 3 * u - q + diffusion * (vl - 2 * v + vr);
    };
    constexpr int last = points - 1;
    at(0, 1, 3, y[2], y[3]);
    for (int i = 1; i < last; ++i) at(i, y[2 * i - 2], y[2 * i - 1], y[2 * i + 2], y[2 * i + 3]);
    at(last, y[2 * last - 2], y[2 * last - 1], 1, 3);
  }
  void add_jacobian(auto /*t*/, const auto& state, auto& sink) const {
    for (int i = 0; i < points; ++i) {
      const auto u = state.y[2 * i], v = state.y[2 * i + 1];
      const int a = 2 * i, b = a + 1;
      sink.rate(a, a, 2 * u * v - 4 - 2 * diffusion);
      sink.rate(a, b, u * u);
      sink.rate(b, a, 3 - 2 * u * v);
      sink.rate(b, b, -u * u - 2 * diffusion);
      for (const int k : {a, b}) {
        if (i > 0) sink.rate(k, k - 2, diffusion);
        if (i + 1 < points) sink.rate(k, k + 2, diffusion);
      }
    }
  }

  /// u and v at every 25th point …
  [[nodiscard]] static std::vector<Eigen::Index> samples() {
    std::vector<Eigen::Index> indices;
    for (Eigen::Index i = 12; i < points; i += 25)
      for (const Eigen::Index component : {2 * i, 2 * i + 1}) indices.push_back(component);
    return indices;
  }
  /// … at t = 10, by Radau IIA in extended precision.
  [[nodiscard]] static Eigen::VectorXd exact() {
    return Eigen::VectorXd{
        {9.33038352074037070e-01, 3.08442239116850647e+00, 8.10646604454006492e-01, 3.23846673978008104e+00,
         7.04242352410113570e-01, 3.37143186568509323e+00, 6.18267290049411611e-01, 3.47709454808165441e+00,
         5.52750116066601072e-01, 3.55521107555161286e+00, 5.05128010757994406e-01, 3.60940298961540273e+00,
         4.71959958824717973e-01, 3.64491641816022360e+00, 4.50016189421099833e-01, 3.66699091374786779e+00,
         4.36780102577561780e-01, 3.67992300322622601e+00, 4.30591867110607707e-01, 3.68662964360568157e+00,
         4.30641038980477120e-01, 3.68849023702712575e+00, 4.36935067865618032e-01, 3.68531298168380239e+00,
         4.50298688750177145e-01, 3.67535179202486262e+00, 4.72402870779578821e-01, 3.65537460199057040e+00,
         5.05765834620418242e-01, 3.62085785322276266e+00, 5.53597880886930516e-01, 3.56646013986838772e+00,
         6.19285201654636408e-01, 3.48698963989347899e+00, 7.05294923851211175e-01, 3.37904348595579718e+00,
         8.11488073516821951e-01, 3.24320675019195281e+00, 9.33378184444551562e-01, 3.08605430578792017e+00}};
  }
};

}  // namespace problems
