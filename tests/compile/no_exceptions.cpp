// expect: exceptions are needed, compile without -fno-exceptions
// errors: 2
// lines: 10
// failing flags: -fno-exceptions
#include <phistep/phistep.hpp>

int main() {}
