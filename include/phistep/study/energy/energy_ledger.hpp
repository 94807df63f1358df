/// @file
/// Where the energy E = ½ vᵀMv + V(r) went: what the scheme took, what the physics took, what was put in, what the
/// solver's tolerance took; each account by its own formula, none as the remainder, but for the schemes of (4).
///
/// With Ψ_φ the force by which a step of length h kicks (φΨ⁺ + (1−φ)Ψ of real force calls at both ends, or Ψ at the stage),
/// v_φ = φ_d v⁺ + (1−φ_d) v the velocity by which it drifts, and ρ and δ what the solver left,
///
///     M Δv = h Ψ_φ + ρ,   Δr = h v_φ + δ,                                                                       (1)
///
/// v̄ = ½(v+v⁺) = v_φ − (φ_d−½)Δv turns ΔT = v̄ᵀMΔv (M symmetric) into
///
///     ΔT = ΔrᵀΨ_φ − (φ_d−½) Δvᵀ(hΨ_φ) + v̄ᵀρ − δᵀΨ_φ                                                            (2)
///
/// and with Ψ = F + D + X, F the force of the potential, D that of the terms that use the velocity, X the others,
///
///     scheme    (ΔV − W + ΔrᵀF_φ) − (φ_d−½) Δvᵀ(hΨ_φ)     quadrature of F, and the φ_d-weighted drift            (3)
///     damping   ΔrᵀD_φ                                      of a damped spring: its force less that at v = 0
///     external  ΔrᵀX_φ + W                                  W: what an explicit t in V does
///     solver    v̄ᵀρ − δᵀΨ_φ
///
/// add up to ΔE. For a linear undamped force and φ_f = φ_d, (3) is −(φ−½)(Δvᵀ M Δv − Δrᵀ K Δr), K = ∂Ψ/∂r. Velocity Verlet
/// kicks with Ψ̄ = ½(Ψ+Ψ⁺) and drifts with v + ½hM⁻¹Ψ: in its (3), (h²/4)(Ψ⁺−Ψ)ᵀM⁻¹Ψ̄ stands for the second part, and
/// ½hρᵀM⁻¹Ψ̄ joins the solver's.
///
/// For any other scheme, and for a split step, (1) is not known. There
///
///     damping   ∫ vᵀD dt,     external  ∫ vᵀX dt + W,   W = ΔV + ∫ vᵀF dt where V depends on t                   (4)
///     scheme    ΔE less these: what is left
///
/// by Gauss and Lobatto's rule on the way through the step (energy_books.hpp), of order 6, at two force calls more a
/// step, none where there is neither D nor X. Where a step doesn't resolve a part, the work of its mean counts, Δrᵀ(D₀+D₁)/2.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "phistep/base/archive/archive.hpp"
#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/study/energy/energy_books.hpp"
#include "phistep/study/energy/force_parts.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <class Stepper>
using EnergyBooksOf =
    EnergyBooks<ScalarOf<typename Stepper::StateType>, ForceSplitter<Stepper>::balance == EnergyBalance::rest>;

/// An observer of completed steps:
///
///     EnergyLedger ledger{stepper};
///     integrate(stepper, state, {0.0, 10.0}, fixed(0.01), ledger);
///     std::cout << ledger;
///
/// Terms have an energy by a member `energy(t, y)` or by `with_energy(f, V)`; one without that ignores the velocity counts
/// as external. One force call a step (two where a term with an energy also uses the velocity), counted here and not in
/// the stepper's statistics; by (4) three (six), or none.
/// @tparam Stepper  a PhiStepper of a motion; it must outlive the ledger and stay where it is
template <class Stepper>
class EnergyLedger : public EnergyBooksOf<Stepper> {
  static_assert(
      requires { typename Stepper::SchemeType; } && !requires(Stepper & outer) { outer.stepper(); },
      "phistep: EnergyLedger takes a PhiStepper, not a stepper around one");
  using S = typename Stepper::StateType;
  using Scheme = typename Stepper::SchemeType;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  using Scalar = ScalarOf<S>;
  using Splitter = ForceSplitter<Stepper>;
  using Force = typename Splitter::Force;
  using Parts = ForceParts<Rate>;
  using Block = typename Parts::Block;
  static constexpr EnergyBalance balance = Splitter::balance;
  using Books = EnergyBooksOf<Stepper>;
  using Books::books_;

  static_assert(Blocks<S>::drifts, "phistep: EnergyLedger needs a motion (r, v): a first-order state has no energy");
  static_assert(!has_history<Force>, "phistep: EnergyLedger knows no energy balance of a force with a history");

 public:
  static constexpr bool looks_at_ends_alone = true;  // of steps
  using Energy = typename Books::Energy;
  using Books::energy, Books::closure;

  /// @throws std::invalid_argument where terms are called seldom and others have no energy: the work of these is done within
  ///         outer steps, of which the ledger has the ends alone
  explicit EnergyLedger(Stepper& stepper) : stepper_{&stepper}, force_{stepper} {
    if constexpr (facts_of<Stepper>.has_inner_steps)
      if (!force_.is_conservative())
        throw std::invalid_argument(
            "phistep: with seldom(k, term), EnergyLedger takes forces with an energy alone: what drag and driving do, "
            "they do within the outer steps, of which it sees the ends");
    set_zero(Blocks<S>::all(end_));  // a copy may be made before the books are opened
    allocate();
  }

  /// Opens the books: called by a run at its start.
  template <class State>
  void begin(Scalar t0, const State& state) {
    books_ = {};
    copy_blocks<S>(end_, state);
    allocate();
    look(t0, end_);
    books_.start = energy();
    books_.largest = std::abs(books_.start);
    books_.begun = true;
  }

  /// Books one step: a CompletedStep, or anything with its t0(), t1(), dt(), start() and end().
  template <class Step>
    requires requires(const Step& step) { step.start(), step.end(), step.dt(); }
  void operator()(const Step& step) {
    if (!books_.begun) begin(step.t0(), step.start());
    else if (!same_shape<S>(end_, step.start()) || !equal_blocks<S>(end_, step.start()) || !same_time(step.t0()))
      book_change(books_.edits, step.t0(), step.start());
    Scalar t0 = step.t0(), t1 = step.t1();
    if constexpr (requires { step.inside(t0); }) t0 = step.inside(t0), t1 = step.inside(t1);
    if (t0 != step.t0()) book_change(books_.external, t0, step.start());  // the force may have jumped there
    if (!books_.known) evaluate_start(t0, step.start());
    const Plain* middle = nullptr;
    if constexpr (requires { step.middle(); }) middle = step.middle();
    if (middle == nullptr) {
      book(t0, t1, step.dt(), step.start(), step.end());
    } else {
      const Scalar half = step.dt() / 2, t = step.t0() + half;
      book(t0, t, half, step.start(), *middle);
      book(t, t1, half, *middle, step.end());
    }
    copy_blocks<S>(end_, step.end());
    books_.t = step.t1();
    ++books_.steps;
    books_.largest = std::max(books_.largest, std::abs(energy()));
    books_.largest_closure = std::max(books_.largest_closure, std::abs(closure()));
  }

  /// After a change of the force's parameters: nothing of the old ones is used, and what it did to E counts as an edit.
  void forget() {
    books_.known = false;
    books_.t = std::numeric_limits<Scalar>::quiet_NaN();
  }

  /// What a checkpoint holds: the books, the end of the last step, and Ψ there.
  template <class Ar>
  void archive(Ar& ar) {
    ar("books", books_, "end", end_);
    if constexpr (Ar::reading) allocate();
    ar.in_place("conservative", before_.conservative, "damping", before_.damping, "external", before_.external);
  }

 private:
  [[nodiscard]] bool same_time(Scalar t) const {
    return std::abs(t - books_.t) <=
           8 * std::numeric_limits<Scalar>::epsilon() * std::max(std::abs(t), std::abs(books_.t));
  }
  [[nodiscard]] static Energy dot(const Block& a, const Block& b) {
    return flat(a).template cast<Energy>().dot(flat(b).template cast<Energy>());
  }

  /// aᵀF, aᵀD and aᵀX
  [[nodiscard]] static std::array<Energy, 3> products(const Block& a, Parts& parts) {
    return {dot(a, parts.F()), dot(a, parts.D()), dot(a, parts.X())};
  }

  void allocate() {
    const Block& v = velocity_of<S>(end_);
    for (Parts* parts : {&before_, &after_, &mean_})
      parts->conservative = parts->damping = parts->external = make_rate<S>(end_);
    force_.resize(end_);
    for (Block* block : {&psi_, &residual_, &dr_, &dv_, &middle_, &slack_}) block->setZero(v.rows(), v.cols());
  }
  /// Kinetic and potential energy of a state at t.
  void look(Scalar t, const Plain& y) {
    books_.kinetic = force_.template kinetic<Energy>(y);
    books_.potential = potential_at(t, y);
    books_.t = t;
  }
  [[nodiscard]] Energy potential_at(Scalar t, const Plain& y) { return static_cast<Energy>(force_.potential(t, y)); }
  /// What E changed by between two steps goes to that account.
  void book_change(auto& account, Scalar t, const Plain& y) {
    const Energy before = energy();
    if (!same_shape<S>(end_, y)) copy_blocks<S>(end_, y), allocate();
    look(t, y);
    account.add(energy() - before);
    books_.known = false;
  }

  void evaluate_start(Scalar t, const Plain& y) {
    if constexpr (balance == EnergyBalance::rest)
      if (force_.is_conservative()) return;
    if constexpr (balance != EnergyBalance::stage) evaluate(t, y, before_);
  }
  void evaluate(Scalar t, const Plain& y, Parts& to) { books_.force_calls += force_.evaluate(t, y, to); }
  /// mean = a·after + (1−a)·before
  void blend(Scalar a) {
    mean_.F() = a * after_.F() + (1 - a) * before_.F();
    mean_.D() = a * after_.D() + (1 - a) * before_.D();
    mean_.X() = a * after_.X() + (1 - a) * before_.X();
  }

  void book(Scalar t0, Scalar t1, Scalar h, const Plain& y0, const Plain& y1) {
    if constexpr (balance == EnergyBalance::rest) book_rest(t0, t1, h, y0, y1);
    else book_balance(t0, t1, h, y0, y1);
    std::swap(before_, after_);
    books_.known = true;
  }
  /// (2) and (3)
  void book_balance(Scalar t0, Scalar t1, Scalar h, const Plain& y0, const Plain& y1) {
    const Block &v0 = velocity_of<S>(y0), &v1 = velocity_of<S>(y1);
    const auto [phi, drift] = weights();
    if constexpr (balance == EnergyBalance::stage) {
      assign<S>(end_, phi * in<S>(y1) + (1 - phi) * in<S>(y0));
      evaluate(t0 + phi * h, end_, mean_);
    } else {
      evaluate(t1, y1, after_);
      blend(phi);
    }
    psi_ = mean_.sum();
    dr_ = position_of<S>(y1) - position_of<S>(y0);
    dv_ = v1 - v0;
    middle_ = (v0 + v1) / 2;
    residual_ = -h * psi_;
    force_.mass().subtract_product(-flat(dv_), flat(residual_));  // ρ
    const Energy carried = take_carried(h);

    Energy scheme, solver = dot(middle_, residual_);
    if constexpr (balance == EnergyBalance::verlet) {
      force_.accelerate(before_.sum(), slack_);
      slack_ = dr_ - h * v0 - h * (h / 2 * slack_);  // δ of (1)
      solver -= dot(slack_, psi_);
      force_.accelerate(psi_, slack_);
      solver += static_cast<Energy>(h) / 2 * dot(residual_, slack_);
      residual_ = after_.sum() - before_.sum();
      scheme = static_cast<Energy>(h) * static_cast<Energy>(h) / 4 * dot(residual_, slack_);
    } else {
      slack_ = dr_ - h * (drift * v1 + (1 - drift) * v0);  // δ of (1)
      solver -= dot(slack_, psi_);
      scheme = -(static_cast<Energy>(drift) - Energy{0.5}) * static_cast<Energy>(h) * dot(dv_, psi_);
    }

    const Energy before = books_.potential;
    look(t1, y1);
    Energy timed{0};
    if constexpr (Splitter::uses.time)
      timed = ((potential_at(t1, y0) - before) + (books_.potential - potential_at(t0, y1))) / 2;
    const auto [F, D, X] = products(dr_, mean_);
    books_.scheme.add(books_.potential - before - timed + F);
    books_.scheme.add(scheme);
    books_.damping.add(D);
    books_.external.add(X);
    books_.external.add(timed);
    books_.external.add(carried);
    books_.solver.add(solver);
  }
  /// The work on bodies that are held at a velocity by what carries them: −h v̄ᵀΨ_φ. There, ρ is not an error.
  [[nodiscard]] Energy take_carried(Scalar h) {
    Energy work{0};
    if constexpr (!std::remove_cvref_t<decltype(force_.mass())>::is_matrix) {
      const auto factor = force_.mass().h_over_mass(Scalar{1});
      for (Index i = 0; i < residual_.size(); ++i)
        if (factor(i) == 0) {
          work -= static_cast<Energy>(h) * static_cast<Energy>(middle_.data()[i]) * static_cast<Energy>(psi_.data()[i]);
          residual_.data()[i] = 0;
        }
    }
    return work;
  }
  /// (4)
  void book_rest(Scalar t0, Scalar t1, Scalar h, const Plain& y0, const Plain& y1) {
    const Energy before = energy(), potential_before = books_.potential;
    look(t1, y1);
    Energy damping{0}, external{0};
    if (!force_.is_conservative()) {
      evaluate(t1, y1, after_);
      const auto [F, D, X] = work(t0, h, y0, y1);
      damping = D;
      external = X;
      if constexpr (Splitter::uses.time) external += books_.potential - potential_before + F;
    }
    books_.damping.add(damping);
    books_.external.add(external);
    for (const Energy x : {energy(), -before, -damping, -external}) books_.scheme.add(x);
  }
  /// ∫ vᵀF dt, ∫ vᵀD dt and ∫ vᵀX dt
  [[nodiscard]] std::array<Energy, 3> work(Scalar t0, Scalar h, const Plain& y0, const Plain& y1) {
    force_.accelerate(before_.sum(), middle_);
    force_.accelerate(after_.sum(), slack_);
    blend(Scalar{0.5});
    dr_ = position_of<S>(y1) - position_of<S>(y0);
    const auto mean = products(dr_, mean_);
    return integrate_on_path<S>(h, y0, middle_, y1, slack_, end_, mean, [&](double x, const Plain& y) {
      if (x != 0 && x != 1) evaluate(t0 + static_cast<Scalar>(x) * h, y, mean_);
      return products(velocity_of<S>(y), x == 0 ? before_ : x == 1 ? after_ : mean_);
    });
  }
  /// (φ_f, φ_d)
  [[nodiscard]] std::pair<Scalar, Scalar> weights() const {
    if constexpr (balance == EnergyBalance::verlet) return {Scalar{1} / 2, Scalar{1} / 2};
    else {
      const Scheme& scheme = stepper_->working().scheme();
      return {scheme.force.template value<Scalar>(), scheme.drift.template value<Scalar>()};
    }
  }

  Stepper* stepper_;
  Splitter force_;
  Plain end_;  // the last step's end, and (while a step is booked) a place inside it
  Parts before_, after_, mean_;
  Block psi_, residual_, dr_, dv_, middle_, slack_;
};

}}  // namespace phistep::PHISTEP_ABI
