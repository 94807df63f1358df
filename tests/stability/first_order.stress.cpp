// The atlas, first order, the φ-method and its kin: 200 × 200 cells of complex λΔt, |λΔt| from 1e-12 to 1e12, the
// neighbourhood of every pole; sectors, far ends, axes and orders. first_order_high.stress.cpp has the schemes of high order.

#include <phistep/phistep.hpp>

#include <cmath>
#include <vector>

#include "stability/survey.hpp"

using namespace stability;

namespace {

const std::vector<Entry>& all() {
  static const std::vector<Entry> entries = [] {
    std::vector<Entry> made;
    subjects::add_phis(made);
    subjects::add_pairs_of_solves(made);
    return made;
  }();
  return entries;
}

}  // namespace

TEST_CASE("atlas, first order, phi-method: no cell is unexplained") {
  survey(all(), "atlas, phi-method: every cell as theory says");
}

TEST_CASE("atlas, first order, phi-method: sectors, far ends, axes, orders") {
  const auto of = [](const char* name) -> const Subject& { return named(all(), name); };
  // HW II, IV.3: the θ-method is A-stable from ½ on, |R(∞)| = (1 − φ)/φ.
  read_off(of("forward_euler"), {0, NAN, 1});
  read_off(of("trapezoidal"), {90, 1, 2});
  read_off(of("midpoint"), {90, 1, 2});
  read_off(of("backward_euler"), {90, 0, 1});
  read_off(of("phi(0.250000)"), {0, 3, 1});
  read_off(of("phi_stage(0.250000)"), {0, 3, 1});
  read_off(of("phi(0.750000)"), {90, 1.0 / 3, 1});
  read_off(of("from_spectral_radius(0.800000)"), {90, 0.8, 1});
  read_off(of("tr_bdf2"), {90, 0, 2});
  read_off(of("rannacher, first step"), {90, 0, 1});
  read_off(of("rannacher(0), later steps"), {90, 1, 2});
  read_off(of("split, phi = 0.500000"));
  figures::at_most(1e-6, std::abs(reach(of("phi(0.250000)"), 0) - 4), "atlas: phi < 1/2 is stable to 2/(1 - 2 phi)",
                   "|limit on the real axis - 4|, phi = 1/4");
}
