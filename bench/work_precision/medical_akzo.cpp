#include "problems/medical_akzo.hpp"

#include "large.hpp"

work_precision::Table work_precision::medical_akzo() {
  using P = problems::MedicalAkzo;
  const P::State start = P::start();
  const P flowing{2}, stopped{0};
  constexpr double a = 1e-2;
  using Plain = FirstOrder<P::State, P>;
  Table table{"medical_akzo",
              "Medical Akzo Nobel, 200 points in one dimension",
              P::exact(),
              system_of<Plain>(Shape::banded, a, {{P::change, {start, flowing}}, {P::end, {start, stopped}}}),
              0,
              6};
  table.samples = P::samples();
  using Rows = truth::StiffRows<truth::Banded<P>>;
  truth::tell(table, truth::Path<Rows>{{{P::change, Rows{{flowing, 2}}}, {P::end, Rows{{stopped, 2}}}}, a, 1e-12L},
              start.cast<truth::Real>());
  PhistepRows rows{table, start, [=](const auto& y, auto scheme, std::size_t leg) {
                     return phistep::PhiStepper{y, leg == 0 ? flowing : stopped, scheme};
                   }};
  add_large(rows, -6);
  return table;
}
