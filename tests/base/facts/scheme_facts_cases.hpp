#pragma once

// What the tests of the schemes' facts share: all schemes, each with the name that users write.
#include <phistep/phistep.hpp>

namespace scheme_facts_cases {

using namespace phistep;

/// f(scheme, as users write it)
void for_each_scheme(auto&& f) {
  f(forward_euler, "forward_euler");
  f(trapezoidal, "trapezoidal");
  f(midpoint, "midpoint");
  f(backward_euler, "backward_euler");
  f(phi(0.7), "phi(0.7)");
  f(symplectic_euler, "symplectic_euler");
  f(symplectic_euler_adjoint, "symplectic_euler_adjoint");
  f(phi(0.6, 0.4), "phi(0.6, 0.4)");
  f(velocity_verlet, "velocity_verlet");
  f(srkn6b, "srkn6b");
  f(srkn11b, "srkn11b");
  f(composed(velocity_verlet), "composed(velocity_verlet)");
  f(rkn86, "rkn86");
  f(rkn1210, "rkn1210");
  f(tsit5, "tsit5");
  f(dop853, "dop853");
  f(tr_bdf2, "tr_bdf2");
  f(rannacher, "rannacher");
  f(rodas4, "rodas4");
  f(rodas4p2, "rodas4p2");
  f(rodas5p, "rodas5p");
  f(radau, "radau");
}

}  // namespace scheme_facts_cases
