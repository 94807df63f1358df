// expect: C..20 is needed: compile with -std=c..20
// errors: 2
// lines: 10
// failing flags: -std=c++17
#include <phistep/phistep.hpp>

int main() {}
