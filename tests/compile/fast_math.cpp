// expect: ffast-math removes the NaN checks
#ifdef MUST_FAIL
#define __FAST_MATH__ 1
#endif
#include <phistep/base/version.hpp>

int main() { return phistep::version_major; }
