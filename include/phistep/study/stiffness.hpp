/// @file
/// How stiff a problem is along its solution: what a pilot of coarse implicit steps meets on its way, against the rate
/// ρ = |λ|max of ∂y'/∂y at each of them. An explicit scheme bears about ρΔt ≤ 3 a step, whatever its order, so that it needs
/// ∫ρ dt / 3 steps; where that is many times what the pilot needs, the problem is stiff. Looking at the start alone would miss
/// what becomes stiff after a transient (Robertson's reaction: ρ = 0.04 at t = 0, 2400 a moment later).
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "phistep/control/trace.hpp"
#include "phistep/core/version.hpp"
#include "phistep/core/xorshift.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/combination.hpp"

namespace phistep::inline PHISTEP_ABI {

/// What a pilot found.
struct Stiffness {
  double rate = 0;          ///< largest |λ| met [1/time]
  double turns = 0;         ///< ∫ρ dt over the whole span, extrapolated where the pilot didn't reach its end
  double steps = 0;         ///< the pilot's steps over the whole span, likewise
  double covered = 0;       ///< share of the span that it saw
  double tolerance = 1e-2;  ///< relative, of its steps
  bool known = false;

  /// Steps of an explicit scheme for each of an implicit one, both at the pilot's accuracy: 1 where nothing is stiff.
  [[nodiscard]] double ratio() const { return steps > 0 ? std::max(1.0, turns / 3 / steps) : 1; }
};

/// |λ|max of ∂y'/∂y by the nonlinear power method (B. P. Sommeijer, L. F. Shampine & J. G. Verwer, J. Comput. Appl. Math. 88
/// (1998) 315), two products at a time, so that a pair ±iω counts like a real λ. An estimate from below.
template <State Plain>
class SpectralRadius {
 public:
  using Scalar = ScalarOf<Plain>;
  explicit SpectralRadius(const Plain& y) : direction_{y}, slope_{y}, moved_{y} {
    Xorshift random{88172645463325252u};
    for_each_number([&random](auto, Scalar& x) { x = static_cast<Scalar>(random.number() - 0.5); },
                    Blocks<Plain>::all(direction_));
  }

  /// At (t, y). @param f  f(t, y, out) → bool: out = y'. @param weight  1/(atol + rtol|y|), whose rtol is `rtol`
  /// @return 0 where y' is not finite
  [[nodiscard]] double operator()(auto&& f, Scalar t, const Plain& y, const Plain& weight, double rtol, int pairs = 4) {
    if (!f(t, y, slope_)) return 0;
    // Directions are measured in weights; a probe moves y by √u of |y| + atol/rtol.
    const double u = static_cast<double>(std::numeric_limits<Scalar>::epsilon()), reach = std::sqrt(u) / rtol;
    double rho = 0;
    scale_by_weights(weight);
    for (int k = 0; k < pairs; ++k) {
      double grown = 1;
      for (int half = 0; half < 2; ++half) {
        const double size = weighted_rms(direction_, weight);
        if (!(size > 0) || !std::isfinite(size)) return rho;
        const auto by = static_cast<Scalar>(reach / size), back = static_cast<Scalar>(1 / reach);
        assign<Plain>(moved_, in<Plain>(y) + by * in<Plain>(direction_));
        if (!f(t, moved_, direction_)) return rho;
        // the product with a direction of size 1
        assign<Plain>(direction_, back * (in<Plain>(direction_) - in<Plain>(slope_)));
        grown *= weighted_rms(direction_, weight);
      }
      rho = std::sqrt(grown);
    }
    return rho;
  }

 private:
  /// The first direction is random in every component's own scale.
  void scale_by_weights(const Plain& weight) {
    if (scaled_) return;
    scaled_ = true;
    for_each_number(
        [](auto, Scalar& d, Scalar w) {
          if (w > 0) d /= w;
        },
        Blocks<Plain>::all(direction_), Blocks<Plain>::all(weight));
  }

  Plain direction_, slope_, moved_;
  bool scaled_ = false;
};

}  // namespace phistep::inline PHISTEP_ABI
