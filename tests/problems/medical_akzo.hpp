#pragma once

#include <Eigen/Core>
#include <phistep/phistep.hpp>

#include <array>
#include <cstddef>
#include <type_traits>
#include <vector>

namespace problems {

/// Medical Akzo Nobel: a radioactively labelled antibody diffuses into a tissue and binds there (test set for IVP solvers, 2.3),
/// at 200 points, to t = 20. Unknowns u₁ v₁ u₂ v₂ …: u diffuses, v is bound, u v is lost at the rate k = 100. With z = jΔz − 1,
///     u_j' = z³/8·(u_{j+1} − u_{j−1})/(2Δz) + z⁴/16·(u_{j+1} − 2u_j + u_{j−1})/Δz² − k u_j v_j,   v_j' = −k u_j v_j,
/// u₀ = 2 until t = 5 and 0 from there on: two legs, one force each.
struct MedicalAkzo : phistep::ForceTerm {
  using State = Eigen::VectorXd;
  static constexpr int points = 200;
  static constexpr double end = 20, change = 5;
  double inflow = 2;  // u₀

  static constexpr bool uses_time = false;
  static constexpr phistep::Structure structure = phistep::Structure::banded;

  explicit MedicalAkzo(double u0) : inflow{u0} {}
  [[nodiscard]] static State start() {
    State y(2 * points);
    for (int j = 0; j < points; ++j) y[2 * j] = 0, y[2 * j + 1] = 1;
    return y;
  }
  void add(auto /*t*/, const auto& state, auto& out) const {
    const auto* const y = state.y.data();
    auto* const rate = out.rate.data();
    using Scalar = std::remove_cvref_t<decltype(*rate)>;
    const auto at = [&](int j, Scalar before, Scalar after) {
      const Scalar u = y[2 * j], lost = 100 * u * y[2 * j + 1];
      rate[2 * j] += drift(j) * (after - before) + spread(j) * (before - 2 * u + after) - lost;
      rate[2 * j + 1] -= lost;
    };
    constexpr int last = points - 1;
    at(0, inflow, y[2]);
    for (int j = 1; j < last; ++j) at(j, y[2 * j - 2], y[2 * j + 2]);
    at(last, y[2 * last - 2], y[2 * last]);
  }
  void add_jacobian(auto /*t*/, const auto& state, auto& sink) const {
    for (int j = 0; j < points; ++j) {
      const int a = 2 * j, b = a + 1;
      const auto by_u = 100 * state.y[b], by_v = 100 * state.y[a];
      const bool inner = j + 1 < points;
      if (j > 0) sink.rate(a, a - 2, spread(j) - drift(j));
      sink.rate(a, a, (inner ? -2 * spread(j) : drift(j) - spread(j)) - by_u);
      if (inner) sink.rate(a, a + 2, spread(j) + drift(j));
      sink.rate(a, b, -by_v);
      sink.rate(b, a, -by_u);
      sink.rate(b, b, -by_v);
    }
  }

  /// u and v at every tenth point …
  [[nodiscard]] static std::vector<Eigen::Index> samples() {
    std::vector<Eigen::Index> indices;
    for (Eigen::Index i = 4; i < points; i += 10)
      for (const Eigen::Index component : {2 * i, 2 * i + 1}) indices.push_back(component);
    return indices;
  }
  /// … at t = 20, by Radau IIA in extended precision; the published values agree to 8 digits (where v is 0 it is below 1e-300).
  [[nodiscard]] static Eigen::VectorXd exact() {
    return Eigen::VectorXd{
        {2.60727361674914721e-05,  0.00000000000000000e+00,  8.18051181527033129e-05,  0.00000000000000000e+00,
         1.41511683765509064e-04,  0.00000000000000000e+00,  2.03310337661038049e-04,  6.33900005835093161e-286,
         2.63736728293300813e-04,  7.57556425831454279e-239, 3.16916048853991151e-04,  1.90554926505489715e-190,
         3.53495152096014226e-04,  1.15750158519316985e-141, 3.59561602577915728e-04,  3.64946715907279685e-94,
         3.16424807593857177e-04,  7.30315145321846370e-51,  2.03787327989693543e-04,  7.42499602493775131e-17,
         2.00315276668835305e-05,  4.02698053074567075e-01,  1.83561037174403652e-09,  9.99927540932510905e-01,
         1.31570668327156178e-14,  9.99999999494142755e-01,  4.10017992864704876e-21,  9.99999999999999889e-01,
         1.73953282477710030e-29,  1.00000000000000000e+00,  2.03349003750205401e-40,  1.00000000000000000e+00,
         7.43937660219373966e-55,  1.00000000000000000e+00,  3.80252101445680861e-74,  1.00000000000000000e+00,
         1.40757722046339633e-100, 1.00000000000000000e+00,  6.67114915239277061e-140, 1.00000000000000000e+00}};
  }

 private:
  struct Coefficients {
    std::array<double, points> drift, spread;  // z³/(16Δz), z⁴/(16Δz²)
  };
  static constexpr Coefficients coefficients = [] {
    Coefficients c{};
    for (int j = 0; j < points; ++j) {
      const double z = (j + 1.0) / points - 1;
      c.drift[static_cast<std::size_t>(j)] = z * z * z / 8 * points / 2;
      c.spread[static_cast<std::size_t>(j)] = z * z * z * z / 16 * points * points;
    }
    return c;
  }();
  [[nodiscard]] static double drift(int j) { return coefficients.drift[static_cast<std::size_t>(j)]; }
  [[nodiscard]] static double spread(int j) { return coefficients.spread[static_cast<std::size_t>(j)]; }
};

}  // namespace problems
