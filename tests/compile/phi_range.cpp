// expect: phi must lie in
#include <phistep/base/facts/phi.hpp>

int main() {
#ifdef MUST_FAIL
  constexpr phistep::SinglePhi<phistep::FixedPhi<3, 2>> scheme{};
#else
  constexpr phistep::SinglePhi<phistep::FixedPhi<2, 3>> scheme{};
#endif
  return scheme.force.value<double>() > 0 ? 0 : 1;
}
