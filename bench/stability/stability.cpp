// The atlas of stability as pictures: |y⁺|/|y| of one step of y' = λy and the spectral radius of one step of an oscillation,
// found by taking the steps. tests/accuracy/stability/ compares the same with theory, cell by cell.
//
//     bench_stability [DIR, default out]     writes DIR/stability_*.csv, for bench/stability/plot.py
#include <Eigen/Eigenvalues>
#include <phistep/phistep.hpp>

#include <cmath>
#include <complex>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "problems/dahlquist.hpp"
#include "problems/oscillator.hpp"
#include "problems/step_matrix.hpp"

namespace {

using Point = std::complex<double>;

/// |y⁺|/|y| at λΔt = z; NaN where the step is refused: on a pole.
struct Decaying {
  std::string name;
  std::function<double(Point z)> amplification;
  double left, right, top;  ///< of the picture
};
/// Spectral radius at ωΔt = a and damping ratio 0.
struct Swinging {
  std::string name;
  std::function<double(double a)> radius;
};

[[nodiscard]] std::function<double(Point)> decay(auto scheme) {
  Eigen::Vector2d y{1, 0};
  return [stepper = phistep::PhiStepper{y, problems::ComplexDahlquist{}, scheme}](Point z) mutable {
    Eigen::Vector2d y1{1, 0};
    stepper.force().lambda = z;
    stepper.reset();
    return stepper.step(y1, 0, 1) ? y1.norm() : std::numeric_limits<double>::quiet_NaN();
  };
}
[[nodiscard]] double radius_of(const Eigen::Matrix2d& P) {
  const double half = P.trace() / 2, det = P.determinant(), d = half * half - det;
  return d <= 0 ? std::sqrt(det) : std::abs(half) + std::sqrt(d);
}
/// From the images of (1, 0) and (0, ω).
[[nodiscard]] std::function<double(double)> swing(auto scheme) {
  using problems::Oscillator;
  const Oscillator::State rest{Oscillator::Vector{0}, Oscillator::Vector{0}};
  return [stepper = phistep::PhiStepper{rest, Oscillator{1}, scheme}](double a) mutable {
    stepper.force().omega_squared = a * a;
    Eigen::Matrix2d P;
    for (const int column : {0, 1}) {
      Oscillator::State y{Oscillator::Vector{column == 0 ? 1 : 0}, Oscillator::Vector{column == 0 ? 0 : a}};
      stepper.reset();
      if (!stepper.step(y, 0, 1)) return std::numeric_limits<double>::quiet_NaN();
      P.col(column) << y.r[0], y.v[0] / a;
    }
    return radius_of(P);
  };
}

/// With a memory, |y⁺|/|y| and the spectral radius are those of later steps.
[[nodiscard]] double largest_of(const Eigen::MatrixXcd& P) {
  return P.allFinite() ? P.eigenvalues().cwiseAbs().maxCoeff() : std::numeric_limits<double>::quiet_NaN();
}
[[nodiscard]] std::function<double(Point)> decay(phistep::GeneralizedAlpha scheme) {
  return [scheme](Point z) { return largest_of(problems::step_matrix(scheme, z)); };
}
[[nodiscard]] std::function<double(double)> swing(phistep::GeneralizedAlpha scheme) {
  return [scheme](double a) { return largest_of(problems::step_matrix(scheme, a).cast<Point>()); };
}

[[nodiscard]] std::vector<Decaying> decaying() {
  using namespace phistep;
  return {{"forward_euler", decay(forward_euler), -4, 2, 3},
          {"phi(0.25)", decay(phi(0.25)), -6, 6, 6},
          {"trapezoidal, midpoint", decay(trapezoidal), -6, 6, 6},
          {"phi(0.75)", decay(phi(0.75)), -6, 6, 6},
          {"backward_euler", decay(backward_euler), -6, 6, 6},
          {"tr_bdf2", decay(tr_bdf2), -6, 12, 9},
          {"rodas4", decay(rodas4), -8, 16, 12},
          {"rodas5p", decay(rodas5p), -8, 16, 12},
          {"radau, order 5", decay(radau(3)), -8, 16, 12},
          {"generalized_alpha(0.5)", decay(generalized_alpha(0.5)), -6, 12, 9},
          {"tsit5", decay(tsit5), -7, 3, 5},
          {"dop853", decay(dop853), -7, 3, 5}};
}
[[nodiscard]] std::vector<Swinging> swinging() {
  using namespace phistep;
  return {{"forward_euler", swing(forward_euler)},
          {"velocity_verlet", swing(velocity_verlet)},
          {"srkn6b", swing(srkn6b)},
          {"srkn11b", swing(srkn11b)},
          {"composed(velocity_verlet)", swing(composed(velocity_verlet))},
          {"rkn86", swing(rkn86)},
          {"rkn1210", swing(rkn1210)},
          {"midpoint", swing(midpoint)},
          {"phi(0.6)", swing(phi(0.6))},
          {"backward_euler", swing(backward_euler)},
          {"tr_bdf2", swing(tr_bdf2)},
          {"generalized_alpha(0.5)", swing(generalized_alpha(0.5))},
          {"rodas4", swing(rodas4)},
          {"radau, order 5", swing(radau(3))}};
}

/// ωΔt up to which a pair doesn't let an undamped oscillation grow: by its determinant and trace, to 1e-9.
[[nodiscard]] double limit(double phi_force, double phi_drift) {
  const auto radius = swing(phistep::phi(phi_force, phi_drift));
  const auto grows = [&](double a) { return !(radius(a) <= 1 + 1e-9); };
  double still = 0;
  for (double a = 0.05; a <= 1e3; a *= 1.02) {
    if (!grows(a)) {
      still = a;
      continue;
    }
    if (still == 0) return 0;
    double beyond = a;
    for (int n = 0; n < 40; ++n) {
      const double middle = (still + beyond) / 2;
      (grows(middle) ? beyond : still) = middle;
    }
    return still;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace

int main(int count, char** arguments) {
  const std::filesystem::path out = count > 1 ? arguments[1] : "out";
  std::filesystem::create_directories(out);

  std::ofstream regions(out / "stability_regions.csv"), axes(out / "stability_axes.csv");
  regions << "scheme,re,im,amplification\n";
  axes << "scheme,axis,size,amplification\n";
  for (const Decaying& scheme : decaying()) {
    // Half a cell off the axes, where the poles are. The lower half is the mirror image.
    constexpr int n = 160;
    const double cell = (scheme.right - scheme.left) / n;
    for (int i = 0; i < n; ++i)
      for (int k = 0; k < static_cast<int>(scheme.top / cell); ++k) {
        const Point z{scheme.left + (i + 0.5) * cell, (k + 0.5) * cell};
        regions << '"' << scheme.name << "\"," << z.real() << ',' << z.imag() << ',' << scheme.amplification(z) << '\n';
      }
    for (int k = -40; k <= 120; ++k) {
      const double size = std::pow(10.0, k / 20.0);
      axes << '"' << scheme.name << "\",real," << size << ',' << scheme.amplification({-size, 0}) << '\n';
      axes << '"' << scheme.name << "\",imaginary," << size << ',' << scheme.amplification({0, size}) << '\n';
    }
    std::printf("%s\n", scheme.name.c_str());
  }

  std::ofstream motion(out / "stability_motion.csv");
  motion << "scheme,a,radius\n";
  motion.precision(12);
  for (const Swinging& scheme : swinging()) {
    for (int k = 0; k <= 800; ++k) {
      const double a = std::pow(10.0, -1.5 + k / 200.0);
      motion << '"' << scheme.name << "\"," << a << ',' << scheme.radius(a) << '\n';
    }
    std::printf("%s\n", scheme.name.c_str());
  }

  std::ofstream pairs(out / "stability_pairs.csv");
  pairs << "phi_force,phi_drift,limit\n";
  constexpr int n = 80;
  for (int i = 0; i <= n; ++i)
    for (int k = 0; k <= n; ++k)
      pairs << static_cast<double>(i) / n << ',' << static_cast<double>(k) / n << ','
            << limit(static_cast<double>(i) / n, static_cast<double>(k) / n) << '\n';
  std::printf("%s\n", (out / "stability_*.csv").c_str());
}
