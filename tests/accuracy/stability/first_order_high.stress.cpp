// The atlas, first order, schemes of high order: Rosenbrock, Radau, explicit Runge-Kutta, composition.

#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "accuracy/stability/survey.hpp"

using namespace stability;

namespace {

const std::vector<Entry>& all() {
  static const std::vector<Entry> entries = [] {
    std::vector<Entry> made;
    subjects::add_rosenbrock(made);
    subjects::add_radau(made);
    subjects::add_runge_kutta(made);
    subjects::add_composed(made);
    return made;
  }();
  return entries;
}

}  // namespace

TEST_CASE("atlas, first order, high order: no cell is unexplained") {
  survey(all(), "atlas, high order: every cell as theory says");
}

TEST_CASE("atlas, first order, high order: sectors, far ends, axes, orders") {
  const auto of = [](const char* name) -> const Subject& { return named(all(), name); };
  // L-stable: HW II, IV.10; Steinebach (2023), whose R is of order 6 there; HW II, IV.5.
  read_off(of("rodas4"), {90, 0, 4});
  read_off(of("rodas5p"), {90, 0});
  read_off(of("radau(3)"), {90, 0, 5});
  read_off(of("radau(5)"), {90, 0});
  read_off(of("radau(7)"), {90, 0});
  read_off(of("tsit5"), {NAN, NAN, 5});
  read_off(of("dop853"));
  read_off(of("composed(trapezoidal)"), {NAN, 1});
}
