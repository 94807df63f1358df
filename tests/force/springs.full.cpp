// springs: the full product and what is dear to compile. The quick half is springs.test.cpp.
#include "force/springs_cases.hpp"

using namespace springs_cases;

TEMPLATE_TEST_CASE_SIG("pairs are the entries, without what dashpots add to the tangent in r", "", ((int dim), dim), 1,
                       2, 3) {
  auto y = points<dim>();
  const auto compare = [&](const auto& network) {
    PairSink<dim> pairs(5 * dim);
    EntrySink entries(5 * dim);
    network.add_jacobian(0.0, y, pairs);
    network.add_jacobian(0.0, y, entries);
    CHECK(pairs.pairs == 5);
    CHECK(pairs.entries == 0);
    CHECK((pairs.C - entries.C).norm() <= 1e-14 * (1 + entries.C.norm()));
    return (pairs.K - entries.K).norm() / entries.K.norm();
  };
  CHECK(compare(spring_network<dim>(some)) <= 1e-15);
  const auto damped = spring_network<dim>(some, SpringDamping{3.0});
  if (dim > 1) CHECK(compare(damped) > 1e-3);  // on a line there is no geometric part
  y.v.setZero();
  CHECK(compare(damped) <= 1e-15);
}
