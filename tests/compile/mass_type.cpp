// expect: a mass is a number, an Eigen vector or a matrix
#include <phistep/phistep.hpp>

#include <string>

int main() {
#ifdef MUST_FAIL
  const std::string m = "2 kg";
#else
  const double m = 2;
#endif
  static_cast<void>(phistep::mass(m));
}
