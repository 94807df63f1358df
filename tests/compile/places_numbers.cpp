// expect: places\(...\) takes what is made of numbers of one type
#include <phistep/in_place.hpp>

#include <vector>

struct Mixed {
  double length;
  int id;
};

int main() {
  std::vector<double> u(4, 1.0), rate(4);
#ifdef MUST_FAIL
  std::vector<Mixed> unknowns(4);
#else
  std::vector<double>& unknowns = u;
#endif
  phistep::VectorInPlace state{phistep::places(unknowns), phistep::places(rate)};
  phistep::PhiStepper stepper{state, state.force([&] { rate = u; }), phistep::forward_euler};
  return stepper.step(state, 0, 0.1) ? 0 : 1;
}
