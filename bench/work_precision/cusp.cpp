#include <phistep/sparse.hpp>

#include "problems/cusp.hpp"

#include "driven.hpp"

work_precision::Table work_precision::cusp() {
  using P = problems::Cusp;
  Table table = driven_stiff<P>("cusp", "Cusp: nerve impulses at 32 points of a ring, to t = 1.1", 1.0);
  const P::State start = P::start();
  PhistepRows rows{table, start, [](const auto& y, auto scheme, std::size_t) {
                     return phistep::PhiStepper{y, SparseTerm<P>{}, scheme};
                   }};
  rows.controlled("TR-BDF2, sparse", phistep::tr_bdf2, -5);
  rows.controlled("Rodas4, sparse", phistep::rodas4, -9);
  rows.controlled("Rodas4P2, sparse", phistep::rodas4p2, -9);
  rows.controlled("Rodas5P, sparse", phistep::rodas5p, -10);
  rows.controlled("Radau, sparse", phistep::radau);
  return table;
}
