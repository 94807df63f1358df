/// @file
/// From a linearized problem, a scheme and Δt to the report: what is stable, what is accurate, what to do instead.
///
/// Accuracy is that of the exponent: a step multiplies e^{iωt} by g, and log(g)/(iωΔt) − 1 holds the relative error of the
/// frequency and the damping ratio added by the scheme. φ = ½: −a²/12 and 0; velocity Verlet: +a²/24 and 0; φ: (φ−½) a
/// to first order, a = ωΔt.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "phistep/study/stability/method.hpp"
#include "phistep/study/stability/report.hpp"
#include "phistep/study/stability/spectrum.hpp"
#include "phistep/study/stability/stable_step.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

[[nodiscard]] inline PreflightTerm term_report(const Tangent& tangent, const Spectrum& s, int block) {
  PreflightTerm term;
  term.finite = tangent.finite;
  term.known = s.bounded && tangent.known;
  term.exact = s.exact;
  if (tangent.K.cols() > 0) {
    term.frequency = std::sqrt(s.stiffness);
    term.damping = s.damping;
  }
  term.rate = s.radius;
  term.component = s.component;
  if (block > 1 && s.component >= 0) term.particle = s.component / block;
  return term;
}

/// A thousandth below the limit: at it, schemes that neither damp nor grow still let errors grow, in proportion to time.
[[nodiscard]] inline double below(double limit) { return std::isfinite(limit) ? 0.999 * limit : limit; }

template <class = void>
class Assessment {
 public:
  Assessment(const LinearizedProblem& problem, const Method& method, std::string scheme,
             const PreflightOptions& options, PreflightReport& report)
      : problem_{problem}, method_{method}, scheme_{std::move(scheme)}, options_{options}, report_{report} {}

  void run() {
    report_.whole = term_report(problem_.whole, spectrum_, problem_.block);
    report_.growth = spectrum_.growth;
    if (!problem_.whole.finite) {
      report_.finding = "The force or its Jacobian is not finite at this state: no step can start from it.";
      return;
    }
    report_.stable_dt = below(stable_step(method_, problem_, spectrum_));
    // Before the first touch, too: of half an oscillation, whose Verlet limit is ωΔt = 2.
    if (options_.contact_time > 0 && !method_.is_a_stable())
      report_.stable_dt = std::min(report_.stable_dt, 2 / std::numbers::pi * options_.contact_time);
    judge_accuracy();
    judge_decay();
    report_.verdict = verdict();
    find();
    advise();
  }

 private:
  static constexpr double always = std::numeric_limits<double>::infinity();

  /// The rate λ that accuracy is judged at; 0 where nothing moves.
  [[nodiscard]] std::complex<double> asked() const {
    if (options_.period > 0)
      return motion_ ? std::complex<double>{0, 2 * std::numbers::pi / options_.period} : -1 / options_.period;
    return fastest();
  }
  [[nodiscard]] std::complex<double> fastest() const {
    if (!spectrum_.bounded) return 0;
    // Overdamped, the fastest is a decay.
    if (motion_ && spectrum_.damping * spectrum_.damping < 4 * spectrum_.stiffness)
      return {0, std::sqrt(spectrum_.stiffness)};
    if (motion_) return -spectrum_.damping;
    std::complex<double> top = -spectrum_.radius;
    for (const auto lambda : spectrum_.eigenvalues)
      if (std::abs(lambda) >= spectrum_.radius) top = lambda.imag() < 0 ? std::conj(lambda) : lambda;
    return top;
  }
  [[nodiscard]] double contact_dt() const { return options_.contact_time > 0 ? options_.contact_time / 10 : always; }
  [[nodiscard]] bool has_dt() const { return report_.dt > 0 && std::isfinite(report_.dt); }

  void judge_accuracy() {
    const std::complex<double> lambda = asked();
    report_.accurate_dt = lambda == 0.0 && !spectrum_.bounded ? std::numeric_limits<double>::quiet_NaN()
                                                              : method_.accurate_dt(lambda, options_.accuracy);
    report_.accurate_dt = std::min(report_.accurate_dt, contact_dt());
    if (!has_dt()) return;
    if (options_.contact_time > 0) report_.steps_per_contact = options_.contact_time / report_.dt;
    if (lambda == 0.0) return;
    const bool oscillates = lambda.real() == 0;
    report_.period = (oscillates ? 2 * std::numbers::pi : 1) / std::abs(lambda);
    report_.steps_per_period = report_.period / report_.dt;
    const std::complex<double> error = method_.exponent_error(report_.dt * lambda);
    report_.phase_error = error.real();
    if (oscillates) {
      report_.added_damping = error.imag();
      report_.energy_per_period = std::exp(-4 * std::numbers::pi * error.imag());
    }
  }
  void judge_decay() {
    const std::complex<double> lambda = fastest();
    if (!has_dt() || lambda == 0.0) return;
    const std::complex<double> z = report_.dt * lambda;
    const std::complex<double> g = z.real() == 0 ? method_.oscillation(z.imag()) : method_.factor(z);
    report_.fastest_factor = std::abs(g);
    report_.rings = lambda.imag() == 0 && g.real() < 0;
    if (!motion_ && (spectrum_.real_decay > 0 || spectrum_.exact) && is_real())
      report_.unringing_dt = method_.sign_limit() / spectrum_.radius;
  }
  [[nodiscard]] bool is_real() const {
    for (const auto lambda : spectrum_.eigenvalues)
      if (std::abs(lambda.imag()) > 1e-10 * spectrum_.radius) return false;
    return spectrum_.exact || spectrum_.up == 0;
  }

  [[nodiscard]] Verdict verdict() const {
    if (!has_dt()) return Verdict::invalid;
    if (std::isnan(report_.stable_dt)) return Verdict::unknown;
    if (report_.dt > report_.stable_dt) return Verdict::unstable;
    if (std::isnan(report_.accurate_dt)) return Verdict::unknown;
    return report_.dt <= report_.accurate_dt ? Verdict::fine : Verdict::coarse;
  }

  void find() {
    std::string& text = report_.finding;
    const double dt = report_.dt;
    const auto say = [&text](const std::string& sentence) { text += (text.empty() ? "" : " ") + sentence; };
    if (report_.verdict == Verdict::unknown)
      say(problem_.whole.known ? "No bound of the stiffness is known that would guarantee this scheme."
                               : "The force has no Jacobian, and there are too many unknowns for differences: give it "
                                 "jacobian(...) or add_jacobian(...).");
    if (report_.verdict == Verdict::unstable)
      say(!problem_.slow.empty()
              ? "The outer step is " + number_text(dt / report_.stable_dt, 3) +
                    " times what is stable: it comes to half a period of the fast motion, which the slow "
                    "terms then drive."
          : report_.stable_dt == 0
              ? "Never stable without damping: phi < 1/2 adds energy to every vibration, at any dt."
              : "The stiffest mode grows without bound: dt is " + number_text(dt / report_.stable_dt, 3) +
                    " times what is stable.");
    if (!has_dt()) return;
    const bool stable = dt <= report_.stable_dt;
    const bool is_short_of_impacts = report_.steps_per_contact > 0 && report_.steps_per_contact < 10;
    const double fast = std::abs(fastest()) * dt / report_.inner_steps;
    if (stable && fast > 1) {
      const std::string factor = number_text(report_.fastest_factor, 3);
      if (report_.fastest_factor > 0.9)
        say("Stable, but what the fastest modes do will be wrong: they are not resolved (rate x dt = " +
            number_text(fast, 3) + ") and not damped either, they ring on by a factor " + factor + " a step.");
      else
        say("The fastest modes are not resolved (rate x dt = " + number_text(fast, 3) +
            "): the scheme damps them by a factor " + factor + " a step" +
            (report_.rings ? ", with alternating sign" : "") + ", right only if they don't matter.");
    } else if (report_.verdict == Verdict::coarse && report_.period > 0 && !is_short_of_impacts) {
      say("Stable, but the motion looked at is off by " + number_text(100 * std::abs(report_.phase_error), 3) +
          " % of its rate" +
          (std::abs(report_.added_damping) > std::abs(report_.phase_error)
               ? ", and the scheme damps it by a ratio of " + number_text(report_.added_damping, 3)
               : "") +
          ".");
    }
    if ((motion_ ? stable : report_.verdict == Verdict::coarse) && method_.kind == Method::Kind::single &&
        method_.force > 0.5)
      say("Its damping makes it a scheme of order 1: generalized_alpha(" +
          number_text((1 - method_.force) / method_.force, 3) + ") damps the fastest modes as much, at order 2.");
    if (is_short_of_impacts)
      say("Impacts need ten steps a contact, whatever the scheme: this creates or destroys energy.");
    else if (report_.is_lossless && report_.steps_per_contact > 0 && report_.steps_per_contact < 100)
      say("Nothing is lost in an impact: below a hundred steps a contact each bounce gains or loses some energy by "
          "chance.");
    if (report_.penetration > 1)
      say("At these speeds a body sinks in " + number_text(report_.penetration, 2) +
          " times as far as where it comes out on the other side of what it hits: take a stiffer law or a thicker "
          "wall.");
    if (report_.growth > 0 && method_.is_a_stable() && std::abs(method_.factor(report_.growth * dt)) < 1)
      say("The exact solution grows at the rate " + number_text(report_.growth, 3) + ", and this step would hide it.");
    else if (report_.growth > 0)
      say("The exact solution itself has a mode that grows, at the rate " + number_text(report_.growth, 3) + ".");
  }

  void advise() {
    if (!problem_.slow.empty() && report_.verdict != Verdict::fine) {
      const double dt = std::min(report_.accurate_dt, 0.9 * report_.stable_dt);
      if (std::isfinite(dt))
        report_.recommended = {scheme_, dt,
                               "The outer step, of " + std::to_string(report_.inner_steps) +
                                   " inner steps; a smaller k leaves them longer."};
      return;
    }
    if (report_.verdict == Verdict::fine && report_.penetration > 1) return;
    if (report_.verdict == Verdict::fine) {
      const bool rings = std::abs(fastest()) * report_.dt / report_.inner_steps > 1 && report_.fastest_factor > 0.9;
      report_.recommended = {
          scheme_, report_.dt,
          rings ? "Keep it, if nothing excites the fastest modes; generalized_alpha(0.5) or tr_bdf2 would damp them."
                : "Keep it."};
      return;
    }
    const std::complex<double> lambda = asked();
    const Method explicit_method =
                     motion_ ? Method{Method::Kind::verlet, 0.5, 0.5} : Method{Method::Kind::single, 0, 0},
                 stiff = method_of(tr_bdf2);
    const LinearizedProblem by_one_scheme{problem_.whole,  problem_.whole, {},
                                          problem_.masses, problem_.block, problem_.tolerance};
    const double bears = below(stable_step(explicit_method, by_one_scheme, spectrum_));
    const double accurate = explicit_method.accurate_dt(lambda, options_.accuracy);
    const double explicit_dt = std::min({accurate, 0.9 * bears, contact_dt()});  // NaN bears: see below
    const double large = std::min(stiff.accurate_dt(lambda, options_.accuracy), contact_dt());
    const std::string explicit_name = motion_ ? "velocity_verlet" : "forward_euler";
    const bool can_be_explicit = bears > 0 && std::isfinite(explicit_dt);
    if (options_.period > 0 && std::isfinite(large)) {
      const double wanted = has_dt() ? std::min(report_.dt, large) : large;
      if (can_be_explicit && wanted < 10 * explicit_dt)
        report_.recommended = {
            explicit_name, explicit_dt,
            "One force call a step, and dt follows the fastest mode at a step that is not much shorter."};
      else
        report_.recommended = {"tr_bdf2", wanted,
                               "Resolves the motion that you want to see and damps what is faster than dt."};
      return;
    }
    if (can_be_explicit)
      report_.recommended = {explicit_name, explicit_dt, "Resolves the fastest mode, if that is what you want to see."};
    const double wanted = std::min(has_dt() ? report_.dt : always, contact_dt());
    if (std::isfinite(wanted)) {
      const PreflightAdvice damped{
          "tr_bdf2", wanted,
          "Damps what dt can't resolve, if the fastest modes don't matter; name the motion that "
          "does by PreflightOptions::period."};
      (can_be_explicit ? report_.otherwise : report_.recommended) = damped;
    }
  }

  const LinearizedProblem& problem_;
  Method method_;
  std::string scheme_;
  PreflightOptions options_;
  PreflightReport& report_;
  bool motion_ = problem_.whole.K.cols() > 0;
  Spectrum spectrum_ = spectrum_of(problem_.whole, problem_.masses, problem_.block, problem_.tolerance);
};

}}  // namespace phistep::PHISTEP_ABI
