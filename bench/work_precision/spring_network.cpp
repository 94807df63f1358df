#include <phistep/sparse.hpp>

#include "problems/drum.hpp"

#include "large.hpp"

work_precision::Table work_precision::spring_network() {
  using P = problems::Drum;
  const auto force = P::force();
  const P::State start = P::start();
  using Force = std::remove_const_t<decltype(force)>;
  Table table{"spring_network",
              "A stretched net of 20 x 20 masses on stiff, damped springs",
              P::exact(),
              system_of(Shape::sparse, 1.0, P::end, FirstOrder<P::State, Force>{start, force, P::masses()}),
              1,
              3};
  table.samples = P::samples();
  PhistepRows rows{table, start, [=](const auto& y, auto scheme, std::size_t) {
                     return phistep::PhiStepper{y, force, scheme, phistep::mass(P::masses())};
                   }};
  rows.fixed("trapezoidal", phistep::trapezoidal, 64, 1024);
  // Spring networks are solved without a matrix, which schemes of higher order ask to multiply with.
  rows.controlled("TR-BDF2", phistep::tr_bdf2, -5);
  rows.controlled("trapezoidal", phistep::trapezoidal, -5);
  return table;
}
