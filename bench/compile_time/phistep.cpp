// The headers alone.
#include <phistep/phistep.hpp>
