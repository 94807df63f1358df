#include <phistep/sparse.hpp>

#include "problems/heat_2d.hpp"

#include "large.hpp"

work_precision::Table work_precision::heat_2d() {
  using P = problems::Heat2D;
  const P::State start = P::exact(0);
  Table table{"heat_2d",
              "Heat on 64 x 64 points in two dimensions",
              P::exact(P::end),
              system_of(Shape::sparse, 0.1, P::end, FirstOrder<P::State, P>{start, {}}),
              0,
              4};
  table.truth = [](const std::vector<double>& times) {
    Eigen::MatrixXd film(P::side * P::side, static_cast<Eigen::Index>(times.size()));
    for (std::size_t k = 0; k < times.size(); ++k) film.col(static_cast<Eigen::Index>(k)) = P::exact(times[k]);
    return film;
  };
  PhistepRows rows{table, start, [](const auto& y, auto scheme, std::size_t) {
                     return phistep::PhiStepper{y, P{}, scheme};
                   }};
  rows.fixed("trapezoidal", phistep::trapezoidal, 8, 512);
  rows.fixed("TR-BDF2", phistep::tr_bdf2, 8, 512);
  add_large(rows, -5);
  return table;
}
