#include "problems/brusselator_1d.hpp"

#include "large.hpp"

work_precision::Table work_precision::brusselator_1d() {
  using P = problems::Brusselator1D;
  const P::State start = P::start();
  constexpr double a = 1;
  Table table{"brusselator_1d",
              "Brusselator with diffusion, 500 points in one dimension",
              P::exact(),
              system_of(Shape::banded, a, P::end, FirstOrder<P::State, P>{start, {}}),
              0,
              6};
  table.samples = P::samples();
  using Rows = truth::StiffRows<truth::Banded<P>>;
  truth::tell(table, truth::Path<Rows>{{{P::end, Rows{{P{}, 2}}}}, a, 1e-12L}, start.cast<truth::Real>());
  PhistepRows rows{table, start, [](const auto& y, auto scheme, std::size_t) {
                     return phistep::PhiStepper{y, P{}, scheme};
                   }};
  rows.fixed("trapezoidal", phistep::trapezoidal, 32, 4096);
  add_large(rows, -6);
  return table;
}
