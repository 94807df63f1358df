/// @file
/// The stage equations of a Radau IIA step in the variables in which they fall apart (Hairer & Wanner, Solving ODEs II,
/// sect. IV.8). With Z_i = Y_i − y, w = T⁻¹ Z (radau_tableau.hpp), λ_l = 1/μ_l and h = Δt, each lane's Newton correction is
///
///     (λ_l/h M − C − h/λ_l K) δ_l = (T⁻¹ Ψ(Y))_l − λ_l/h M w_l,      w_l ← w_l + δ_l                             (1)
///
/// one real and (s−1)/2 complex systems of n equations. T and T⁻¹ magnify rounding (their entries' product goes up to 2e3 for
/// s = 7), so that Z is kept beside w, and the right side of (1) is T⁻¹ of what the stage equations themselves leave,
///
///     Ψ(Y_i) − M/h Σ_j (A⁻¹)_ij Z_j,      Z ← Z + T δ:                                                          (2)
///
/// as the iteration converges, T and T⁻¹ work on numbers that vanish. First order: K = 0, C = Ψ_y. For motion the positions follow,
/// Z^r_i = c_i h v + (h/λ w)_i, so that these are n equations for v, and not 2n.
///
/// All four lanes are worked on at once (linear/lanes/lane_system.hpp); a method with fewer leaves the others zero.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <type_traits>
#include <vector>

#include "phistep/linear/lanes/lane_system.hpp"
#include "phistep/schemes/radau/radau_tableau.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The unknowns of (1), and what its matrices are made of. @tparam n  unknowns, or Eigen::Dynamic
template <class Scalar, int n_static>
class RadauStages {
 public:
  static constexpr int lanes = 4, most = 8;
  using Shift = LaneShift<Scalar, lanes>;
  using Number = typename Shift::Number;
  using Real = typename Number::Real;
  /// A number a stage, or a coefficient a power.
  using Row = std::array<Scalar, most>;
  static constexpr bool is_fixed = n_static != Eigen::Dynamic;
  template <class T>
  using Each =
      std::conditional_t<is_fixed, std::array<T, static_cast<std::size_t>(is_fixed ? n_static : 1)>, std::vector<T>>;

  /// Room for n of each.
  static void make([[maybe_unused]] std::size_t n, [[maybe_unused]] auto&... all) {
    if constexpr (!is_fixed) (all.assign(n, {}), ...);
  }

  void resize(std::size_t n) { make(n, w_, delta_, z_, psi_, r_, left_); }
  [[nodiscard]] std::size_t n() const { return w_.size(); }

  /// What makes the matrices of (1); masses(put) calls put(i, j, m) for each entry of M. All is multiplied by a power of two
  /// near h/M, so that squares of entries stay in range in any units.
  template <int s>
  [[nodiscard]] const Shift& shift(Scalar h, const auto& masses) {
    constexpr auto& k = radau_constants<Scalar, s>;
    Scalar heaviest{0};
    masses([&heaviest](auto, auto, auto m) {
      heaviest = std::max(heaviest, static_cast<Scalar>(std::abs(static_cast<Scalar>(m))));
    });
    int exponent = 0;
    static_cast<void>(std::frexp(h / heaviest, &exponent));
    shift_.force = std::ldexp(Scalar{1}, exponent);
    per_h_ = 1 / h;
    shift_.drift = {load(k.mu.re) * Real{-h * shift_.force}, load(k.mu.im) * Real{-h * shift_.force}};
    shift_.mass = {load(k.lambda.re) * Real{shift_.force / h}, load(k.lambda.im) * Real{shift_.force / h}};
    return shift_;
  }

  /// Z = 0
  void clear() { std::fill(w_.begin(), w_.end(), Number{Real{Scalar{0}}, Real{Scalar{0}}}); }
  /// Z_j = Σ_m a_m (q c_j)^{m+1}: another polynomial, continued over a step q times as long.
  template <int s>
  void predict(const auto& powers, int terms, Scalar q) {
    for (std::size_t i = 0; i < n(); ++i) {
      Row z{};
      for (std::size_t j = 0; j < s; ++j)
        for (auto m = static_cast<std::size_t>(terms); m-- > 0;)
          z[j] = q * radau_constants<Scalar, s>.c[j] * (z[j] + powers[i][m]);
      w_[i] = to_lanes<s>(z);
    }
  }
  /// Z = T w, before the iteration: z(i) holds component i of Z_1 … Z_s.
  template <int s>
  void to_stages() {
    for (std::size_t i = 0; i < n(); ++i) apply(w_[i], radau_constants<Scalar, s>.into_stages, z_[i]);
  }
  [[nodiscard]] const Row& z(std::size_t i) const { return z_[i]; }
  /// Component i of Ψ at the stages, to be filled.
  [[nodiscard]] Row& psi(std::size_t i) { return psi_[i]; }
  /// For motion: r(i) holds component i of Z^r_1 … Z^r_s, where v is the velocity at the step's start.
  template <int s>
  void to_positions(Scalar h, const auto& v) {
    constexpr auto& k = radau_constants<Scalar, s>;
    for (std::size_t i = 0; i < static_cast<std::size_t>(v.size()); ++i) {
      apply(drifted<s>(h, i), k.into_stages, r_[i]);
      const Scalar by = h * v.data()[i];
      for (std::size_t j = 0; j < s; ++j) r_[i][j] += k.c[j] * by;
    }
  }
  [[nodiscard]] const Row& r(std::size_t i) const { return r_[i]; }

  /// The corrections δ of (1), by (2), added to w and to Z. Returns Σ |w_i δ_il|², w_i the weight of component i: squares of
  /// what has a unit would leave the range.
  template <int s>
  [[nodiscard]] auto correct(auto& matrices, const auto& masses, const auto& weight) {
    for (std::size_t i = 0; i < n(); ++i) left_[i] = psi_[i];
    masses([this](auto i, auto j, auto m) {
      subtract_slopes<s>(static_cast<Scalar>(m) * per_h_, z_[static_cast<std::size_t>(j)],
                         left_[static_cast<std::size_t>(i)]);
    });
    for (std::size_t i = 0; i < n(); ++i) {
      const Number left = to_lanes<s>(left_[i]);
      delta_[i] = {left.re * Real{shift_.force}, left.im * Real{shift_.force}};
    }
    matrices.solve_in_place(delta_.data());
    using Wide = std::common_type_t<Scalar, double>;
    Wide all{0};
    for (std::size_t i = 0; i < n(); ++i) {
      w_[i].re = w_[i].re + delta_[i].re;
      w_[i].im = w_[i].im + delta_[i].im;
      apply<true>(delta_[i], radau_constants<Scalar, s>.into_stages, z_[i]);
      const Real by{weight[i]};
      all += static_cast<Wide>(sum(Number{delta_[i].re * by, delta_[i].im * by}.norm()));
    }
    return all;
  }

  /// w of component i; and h/λ w, which for motion is Z^r but for c h v.
  [[nodiscard]] const Number& w(std::size_t i) const { return w_[i]; }
  template <int s>
  [[nodiscard]] Number drifted(Scalar h, std::size_t i) const {
    constexpr auto& k = radau_constants<Scalar, s>;
    const Number by{load(k.mu.re) * Real{h}, load(k.mu.im) * Real{h}};
    return by * w_[i];
  }
  /// Of these, what the step adds; h u'(0); the collocation polynomial about the step's end.
  [[nodiscard]] static Scalar increment(const Number& w) { return sum(w.re); }
  template <int s>
  [[nodiscard]] static Scalar slope_at_start(const Number& w) {
    constexpr auto& by = radau_constants<Scalar, s>.start;
    return sum(w.re * load(by.re) + w.im * load(by.im));
  }
  template <int s>
  static void to_powers(const Number& w, Row& powers) {
    apply(w, radau_constants<Scalar, s>.into_powers, powers);
  }

 private:
  template <std::size_t count>
  [[nodiscard]] static Real load(const std::array<Scalar, count>& x) {
    return Real::load(x.data());
  }
  /// T⁻¹ z, of one component
  template <int s>
  [[nodiscard]] static Number to_lanes(const Row& z) {
    constexpr auto& k = radau_constants<Scalar, s>;
    Real re{Scalar{0}}, im{Scalar{0}};
    for (std::size_t j = 0; j < s; ++j) {
      re = re + Real{z[j]} * load(k.into_lanes[j].re);
      im = im + Real{z[j]} * load(k.into_lanes[j].im);
    }
    return {re, im};
  }
  /// left −= by A⁻¹ z, of one component
  template <int s>
  static void subtract_slopes(Scalar by, const Row& z, Row& left) {
    constexpr auto& k = radau_constants<Scalar, s>;
    using Part = WidePack<Scalar, 4>;
    for (std::size_t at = 0; at < static_cast<std::size_t>(k.rows); at += 4) {
      Part sum = Part{z[0]} * Part::load(k.slopes[0].data() + at);
      for (std::size_t j = 1; j < s; ++j) sum = sum + Part{z[j]} * Part::load(k.slopes[j].data() + at);
      (Part::load(left.data() + at) - Part{by} * sum).store(left.data() + at);
    }
  }
  /// out = Σ_l (Re w_l re_l + Im w_l im_l), one number for each stage. @tparam adds  to what is in out
  template <bool adds = false, class ByStage>
  static void apply(const Number& w, const std::array<ByStage, lanes>& by, Row& out) {
    constexpr std::size_t rows = std::tuple_size_v<decltype(ByStage::re)>;
    constexpr std::size_t used = rows == 4 ? 2 : lanes;
    using Part = WidePack<Scalar, 4>;
    Scalar re[lanes], im[lanes];
    w.re.store(re);
    w.im.store(im);
    for (std::size_t at = 0; at < rows; at += 4) {
      Part x = Part{re[0]} * Part::load(by[0].re.data() + at);
      for (std::size_t l = 1; l < used; ++l) {
        x = x + Part{re[l]} * Part::load(by[l].re.data() + at);
        x = x + Part{im[l]} * Part::load(by[l].im.data() + at);
      }
      if constexpr (adds) x = x + Part::load(out.data() + at);
      x.store(out.data() + at);
    }
  }

  Each<Number> w_, delta_;
  Each<Row> z_{}, psi_{}, r_{}, left_{};
  Shift shift_{};
  Scalar per_h_{1};  // [1/time]
};

}}  // namespace phistep::PHISTEP_ABI
