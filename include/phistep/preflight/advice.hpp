/// @file
/// The rules by which a stepper is advised, and the advice as text.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "phistep/core/structure.hpp"
#include "phistep/core/version.hpp"
#include "phistep/preflight/report.hpp"
#include "phistep/preflight/stiffness.hpp"

namespace phistep::inline PHISTEP_ABI {

/// What the choice depends on, beside the stiffness.
struct Scene {
  std::int64_t unknowns = 0;  ///< solved for: n for a motion, whose r and v are 2n numbers
  bool is_motion = false, uses_velocity = false, uses_time = false, is_affine = false, has_history = false;
  bool has_jacobian = false, has_pattern = false, has_matrix_mass = false, is_fixed_size = false;
  Structure structure = Structure::dense;
  double rtol = 1e-4;
  double span = 0;  ///< [time]
  int digits = 15;  ///< of the scalar
};

/// A stepper to take, and why.
struct Advice {
  std::string scheme;                 ///< "rodas5p", …
  std::string control;                ///< "phistep::tolerance{.rtol = 1e-06}" or "phistep::fixed(dt)"
  std::vector<std::string> reasons;   ///< a sentence each
  std::vector<std::string> warnings;  ///< what the tolerance or the scene does not bear
  Stiffness stiffness;

  /// The lines of code.
  [[nodiscard]] std::string code() const {
    return "phistep::PhiStepper stepper{state, force, phistep::" + scheme +
           "};\nphistep::integrate(stepper, state, {t0, t1}, " + control + ");\n";
  }
  [[nodiscard]] std::string message() const {
    std::string text = code();
    for (const std::string& reason : reasons) text += "  because " + reason + "\n";
    for (const std::string& warning : warnings) text += "  but " + warning + "\n";
    return text;
  }
  template <class OStream>
    requires requires(OStream& out, const std::string& text) { out << text; }
  friend OStream& operator<<(OStream& out, const Advice& advice) {
    out << advice.message();
    return out;
  }
};

}  // namespace phistep::inline PHISTEP_ABI
