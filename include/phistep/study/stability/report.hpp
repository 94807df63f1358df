/// @file
/// What preflight found, as numbers and as text.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "phistep/run/control/run_report.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What will become of a run with this Δt.
enum class Verdict : std::uint8_t {
  fine,      ///< stable and, at the rates that were asked about, accurate
  coarse,    ///< stable, but too long for what it is to show
  unstable,  ///< errors grow where the exact solution doesn't
  unknown,   ///< nothing is guaranteed: no Jacobian, not finite, or no bound for this scheme
  invalid    ///< Δt isn't positive and finite
};

[[nodiscard]] constexpr const char* describe(Verdict verdict) {
  constexpr const char* texts[] = {"fine", "stable, but too coarse", "unstable", "not known",
                                   "dt is not positive and finite"};
  return texts[static_cast<std::size_t>(verdict)];
}

/// What preflight judges.
struct PreflightOptions {
  double period = 0;  ///< [time] of the motion that you want to see; first order: its time constant. 0: the fastest
  double contact_time = 0;  ///< [time] of the shortest impact; 0: what the force's terms say, if they know
  double accuracy = 0.01;   ///< allowed relative error of that motion's rate: of its period, and damping ratio added
  double t = 0;             ///< [time] where the force is linearized
};

/// How stiff a term of the force is, or all of it. Upper bounds; the very values where `exact`.
struct PreflightTerm {
  double frequency = 0;         ///< ω of ∂Ψ/∂r [1/time]
  double damping = 0;           ///< c of ∂Ψ/∂v [1/time]
  double rate = 0;              ///< |λ| of both together, of ∂Ψ/∂y for a first-order state [1/time]
  bool exact = false;           ///< eigenvalues, not bounds
  bool known = true;            ///< false: no bound
  bool finite = true;           ///< false: Ψ or its Jacobian isn't
  bool is_kick = false;         ///< at(forward_euler, term)
  int k = 1;                    ///< seldom(k, term): called once in k inner steps
  std::int64_t component = -1;  ///< where it is stiffest, in storage order of the unknowns
  std::int64_t particle = -1;   ///< whose component that is, where particles are known
};

/// What to write instead.
struct PreflightAdvice {
  std::string scheme;  ///< "velocity_verlet", …
  double dt = 0;       ///< [time]
  std::string reason;
  /// The line of code.
  [[nodiscard]] std::string code() const {
    return "PhiStepper stepper{state, force, " + scheme + ", mass};  integrate(stepper, state, span, fixed(" +
           number_text(dt, 3) + "))";
  }
};

/// What preflight found. Contextually true where the step asked about is fine.
struct PreflightReport {
  Verdict verdict = Verdict::unknown;  ///< of the step asked about
  double dt = 0;                       ///< [time] the one asked about
  double stable_dt =
      std::numeric_limits<double>::quiet_NaN();  ///< [time] stable up to here (a thousandth below the limit);
                                                 ///< infinite: always, 0: never, NaN: not known
  double accurate_dt = std::numeric_limits<double>::quiet_NaN();  ///< [time] what the accuracy asked for takes
  PreflightTerm whole;                                            ///< of Ψ
  std::vector<PreflightTerm> terms;                               ///< of each term of a sum; empty where Ψ is none
  int stiffest = -1;                                              ///< which term is, −1: no sum
  double growth = 0;  ///< [1/time] of the exact solution's fastest growing mode, where known

  // The motion asked about, else the fastest one:
  double period = 0;             ///< [time] (first order: time constant)
  double steps_per_period = 0;   ///< period / dt
  double phase_error = 0;        ///< relative error of its rate: of the period, with the sign of the frequency's error
  double added_damping = 0;      ///< damping ratio that the scheme adds
  double energy_per_period = 1;  ///< factor on its energy in one period, by the scheme alone
  // The fastest one:
  double fastest_factor = 1;  ///< |factor| of one step
  bool rings = false;         ///< the factor is negative or complex although the exact one is positive (first order)
  double unringing_dt = 0;    ///< [time] first order: up to which no mode changes sign from step to step, 0: not known

  // If terms are called seldom(k, term); dt is the outer step:
  int inner_steps = 1;  ///< how many inner steps an outer step has
  int most_k = 0;       ///< the most inner steps of length dt/inner_steps in a stable outer step; 0: not known

  double steps_per_contact = 0;  ///< 0: no contact time given
  double penetration = 0;        ///< how far the fastest body sinks in, over where it would be through; 0: not known
  bool is_lossless = false;      ///< an impact keeps its energy
  std::string finding;           ///< what will happen, in a sentence or two
  PreflightAdvice recommended, otherwise;  ///< what to write instead; `otherwise`: if the fastest modes don't matter

  [[nodiscard]] explicit operator bool() const { return verdict == Verdict::fine; }

  /// All of it as text; times in the units of Δt.
  [[nodiscard]] std::string text() const {
    std::string all = std::string("preflight: ") + describe(verdict) + '\n';
    const auto line = [&all](const char* name, const std::string& value) {
      std::string head = "  " + std::string(name);
      head.resize(22, ' ');
      all += head + value + '\n';
    };
    const auto limit = [](double x) {
      return std::isnan(x)   ? std::string("not known")
             : x == 0        ? "never"
             : std::isinf(x) ? "always"
                             : "to " + number_text(x, 3);
    };
    line("dt", number_text(dt, 3) + "; stable " + limit(stable_dt) + ", accurate " + limit(accurate_dt));
    line("fastest", rates(whole));
    for (std::size_t k = 0; k < terms.size(); ++k)
      line(("term " + std::to_string(k)).c_str(),
           rates(terms[k]) + (static_cast<int>(k) == stiffest ? "  <- stiffest" : ""));
    if (inner_steps > 1)
      line("inner steps", std::to_string(inner_steps) + " of " + number_text(dt / inner_steps, 3) +
                              (most_k > 0 ? "; stable to k = " + std::to_string(most_k) + " of these" : ""));
    if (period > 0) {
      line("steps per period", number_text(steps_per_period, 3) + " of " + number_text(period, 3));
      line("period's error", number_text(-100 * phase_error, 3) + " %");
      line("energy per period", "times " + number_text(energy_per_period, 3) + " by the scheme alone");
    }
    if (unringing_dt > 0) line("no mode rings", limit(unringing_dt));
    if (steps_per_contact > 0) line("steps per contact", number_text(steps_per_contact, 3));
    if (!finding.empty()) line("finding", finding);
    for (const PreflightAdvice* advice : {&recommended, &otherwise})
      if (!advice->scheme.empty()) {
        line(advice == &recommended ? "recommended" : "or", advice->code());
        line("", advice->reason);
      }
    return all;
  }
  friend auto& operator<<(TextStream auto& out, const PreflightReport& report) {
    out << report.text();
    return out;
  }

 private:
  [[nodiscard]] static std::string rates(const PreflightTerm& term) {
    if (!term.finite) return "not finite";
    if (!term.known) return "no bound";
    const char* sign = term.exact ? " = " : " <= ";
    std::string text;
    if (term.frequency > 0) text += "omega" + (sign + number_text(term.frequency, 3)) + "  ";
    if (term.damping > 0) text += "damping" + (sign + number_text(term.damping, 3)) + "  ";
    if (term.frequency == 0 && term.damping == 0)
      text += term.rate > 0 ? "rate" + (sign + number_text(term.rate, 3)) + "  " : "0  ";
    if (term.rate > 0 && term.particle >= 0) text += "at particle " + std::to_string(term.particle);
    else if (term.rate > 0 && term.component >= 0) text += "at component " + std::to_string(term.component);
    if (term.is_kick) text += "  (kicks)";
    if (term.k > 1) text += "  (once in " + std::to_string(term.k) + " inner steps)";
    return text;
  }
};

}}  // namespace phistep::PHISTEP_ABI
