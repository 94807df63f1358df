// expect: a term of seldom.k, term. may remember nothing but a neighbour list
#include <phistep/phistep.hpp>

using Vec = Eigen::Vector2d;

struct Anchor : phistep::ForceTerm {
  struct Memory {
#ifndef MUST_FAIL
    static constexpr bool is_cache = true;
#endif
    Vec r{0, 0};
  };
  static constexpr bool uses_velocity = false, uses_time = false;
  static void add(double, const auto& y, const Memory& m, auto& out) { out.force -= y.r - m.r; }
  static void commit(double, const auto&, Memory&) {}
};

int main() {
  const auto fast = [](const Vec& r) -> Vec { return -9 * r; };
  phistep::Motion y{Vec{1, 0}, Vec{0, 0}};
  phistep::PhiStepper stepper{y, phistep::term(fast) + phistep::seldom(4, Anchor{}), phistep::velocity_verlet};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
