#pragma once

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace problems {

/// Plate: a rectangular plate of 8 × 5 points under the load of a car that crosses it, friction 1000, to t = 7 (Hairer & Wanner,
/// Solving ODEs II, sect. IV.10). Unknowns: 40 displacements, then 40 velocities.
struct Plate {
  using State = Eigen::VectorXd;
  static constexpr int columns = 8, rows = 5, points = columns * rows;
  static constexpr double end = 7, friction = 1000;

  [[nodiscard]] static State start() { return State::Zero(2 * points); }
  template <class Y, class Out>
  static void rate(double t, const Y& y, Out&& out) {
    std::array<double, columns> load{};
    for (int i = 0; i < columns; ++i) {
      const double x = t - (i + 1) * 2.0 / 9;
      load[static_cast<std::size_t>(i)] = 200 * (std::exp(-5 * (x - 2) * (x - 2)) + std::exp(-5 * (x - 5) * (x - 5)));
    }
    for (int i = 0; i < points; ++i) {
      double sum = -friction * y[points + i];
      for (const auto& [j, k] : stiffness()[static_cast<std::size_t>(i)]) sum += k * y[j];
      const int row = i / columns;
      if (row == 1 || row == 3) sum += load[static_cast<std::size_t>(i % columns)];
      out[i] = y[points + i], out[points + i] = sum;
    }
  }
  template <class Y, class Put>
  static void entries(double /*t*/, const Y& /*y*/, Put&& put) {
    for (int i = 0; i < points; ++i) {
      put(i, points + i, 1.0), put(points + i, points + i, -friction);
      for (const auto& [j, k] : stiffness()[static_cast<std::size_t>(i)]) put(points + i, j, k);
    }
  }

  /// Two codes at tight tolerances, which agree to 2e-12.
  [[nodiscard]] static State exact() {
    return State{{0.00049014381385133557, 0.00098008148556061043, 0.0014628938114821892,  0.0019158224644119347,
                  0.0022851525337270018,  0.002461353376688547,   0.0022545974130971213,  0.0014383125919335989,
                  0.00084902514922840209, 0.0016978850056257569,  0.0025352398860688462,  0.0033239895521817706,
                  0.0039779021935606651,  0.0043202317360829879,  0.0040256799550838929,  0.0026432063561238396,
                  0.00098028762770267113, 0.0019601629711212209,  0.0029257876229643784,  0.0038316449288238693,
                  0.0045703050674540035,  0.004922706753377094,   0.0045091948261942426,  0.0028766251838671978,
                  0.0008490251492284022,  0.0016978850056257569,  0.0025352398860688462,  0.0033239895521817706,
                  0.0039779021935606651,  0.0043202317360829879,  0.0040256799550838929,  0.0026432063561238396,
                  0.00049014381385133567, 0.00098008148556061065, 0.0014628938114821894,  0.0019158224644119347,
                  0.0022851525337270018,  0.002461353376688547,   0.0022545974130971213,  0.0014383125919335989,
                  -0.0011775903045453914, -0.0024090058279921554, -0.0037221408316565076, -0.0050787800560481563,
                  -0.0063026618110984265, -0.0069733999429266568, -0.0063945751204154055, -0.0039604645513107569,
                  -0.0020401482440404709, -0.0041748298779536158, -0.0064565103375162558, -0.0088325032767380372,
                  -0.011029624807176897,  -0.012352389570141358,  -0.011524177328690915,  -0.007253301886025975,
                  -0.0023551806090907758, -0.0048180116559842917, -0.007444281663313037,  -0.010157560112096273,
                  -0.012605323622196843,  -0.013946799885853255,  -0.012789150240830736,  -0.0079209291026215087,
                  -0.0020401482440405359, -0.0041748298779535438, -0.0064565103375162835, -0.0088325032767380372,
                  -0.011029624807176838,  -0.012352389570141353,  -0.011524177328690892,  -0.0072533018860259915,
                  -0.0011775903045453541, -0.0024090058279922473, -0.0037221408316564807, -0.0050787800560482691,
                  -0.0063026618110983701, -0.0069733999429266134, -0.0063945751204155009, -0.0039604645513106815}};
  }

 private:
  /// −100 ΔΔ, row by row, what isn't zero
  static const std::array<std::vector<std::pair<int, double>>, points>& stiffness() {
    static const auto all = [] {
      constexpr double g = 20.25;  // 1/Δx²
      Eigen::MatrixXd A = Eigen::MatrixXd::Zero(points, points);
      for (int i = 0; i < points; ++i) {
        A(i, i) = -4 * g;
        if (i % columns > 0) A(i, i - 1) = g;
        if (i % columns < columns - 1) A(i, i + 1) = g;
        if (i >= columns) A(i, i - columns) = g;
        if (i + columns < points) A(i, i + columns) = g;
      }
      const Eigen::MatrixXd K = -100 * A * A;
      std::array<std::vector<std::pair<int, double>>, points> of;
      for (int i = 0; i < points; ++i)
        for (int j = 0; j < points; ++j)
          if (K(i, j) != 0) of[static_cast<std::size_t>(i)].emplace_back(j, K(i, j));
      return of;
    }();
    return all;
  }
};

}  // namespace problems
