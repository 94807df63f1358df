// Springs as pairs and as entries are one tangent; the order of the list does not matter.
#include "particles/springs/springs_cases.hpp"

using namespace springs_cases;

TEMPLATE_TEST_CASE_SIG("pairs are the entries, without what dashpots add to the tangent in r", "", ((int dim), dim),
                       3) {
  check_pairs<dim>();
}

TEST_CASE("a spring without a length at rest is k d everywhere, at its zero too") {
  auto y = points<3>();
  const auto network = spring_network<3>({{0, 1, 6.0, 0.0}});
  CHECK(check_jacobian(network, y));
  y.r.segment<3>(3) = y.r.segment<3>(0);
  EntrySink entries(15);
  network.add_jacobian(0.0, y, entries);
  CHECK((entries.K.block<3, 3>(0, 3) - 6 * Eigen::Matrix3d::Identity()).norm() == 0);
  CHECK((entries.K.block<3, 3>(3, 3) + 6 * Eigen::Matrix3d::Identity()).norm() == 0);
  Out out{Vec::Zero(15)};
  network.add(0.0, y, out);
  CHECK(out.force.norm() == 0);
  // With one, its ends in one point have no direction.
  spring_network<3>({{0, 1, 6.0, 0.5}}).add(0.0, y, out);
  CHECK(out.force.head<6>().array().isNaN().all());
  CHECK(out.force.tail<9>().norm() == 0);
}

TEST_CASE("the list keeps its order outside, and the force does not depend on it") {
  const auto y = points<3>();
  auto shuffled = some;
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(4));
  const auto network = spring_network<3>(some), other = spring_network<3>(shuffled);
  REQUIRE(other.springs.size() == 5);
  for (std::size_t s = 0; s < 5; ++s) CHECK(other.springs[s].stiffness == shuffled[s].stiffness);
  Out a{Vec::Zero(15)}, b{Vec::Zero(15)};
  network.add(0.0, y, a);
  other.add(0.0, y, b);
  CHECK(a.force.norm() > 1);
  CHECK(a.force == b.force);  // sorted alike: the same bits
}
