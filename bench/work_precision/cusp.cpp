#include "problems/cusp.hpp"

#include "driven.hpp"

work_precision::Table work_precision::cusp() {
  return driven_stiff<problems::Cusp>("cusp", "Cusp: nerve impulses at 32 points of a ring, to t = 1.1", 1.0);
}
