// Springs as pairs and as entries are one tangent; the order of the list does not matter.
#include <phistep/base/state/motion.hpp>
#include <phistep/particles/springs/springs.hpp>
#include <phistep/study/checks/check_force.hpp>

#include <Eigen/Core>

#include <algorithm>
#include <random>

#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;

namespace springs_cases {

/// Spreads pairs over dense matrices.
template <int dim>
struct PairSink {
  Eigen::MatrixXd K, C;
  int pairs = 0, entries = 0;
  explicit PairSink(Eigen::Index n) : K(Eigen::MatrixXd::Zero(n, n)), C(K) {}
  void position(Eigen::Index, Eigen::Index, double) { ++entries; }
  void velocity(Eigen::Index, Eigen::Index, double) { ++entries; }
  void edge(Eigen::Index i, Eigen::Index j, const double* n, PairTangent<double> k, PairTangent<double> c) {
    ++pairs;
    using Small = Eigen::Matrix<double, dim, dim>;
    const Eigen::Map<const Eigen::Matrix<double, dim, 1>> direction(n);
    const Small along = direction * direction.transpose();
    const auto add = [&](Eigen::MatrixXd& to, const PairTangent<double>& t) {
      const Small B = t.along * along + t.across * (Small::Identity() - along);
      to.block<dim, dim>(dim * i, dim * j) += B;
      to.block<dim, dim>(dim * j, dim * i) += B;
      to.block<dim, dim>(dim * i, dim * i) -= B;
      to.block<dim, dim>(dim * j, dim * j) -= B;
    };
    add(K, k);
    add(C, c);
  }
};
struct EntrySink {
  Eigen::MatrixXd K, C;
  explicit EntrySink(Eigen::Index n) : K(Eigen::MatrixXd::Zero(n, n)), C(K) {}
  void position(Eigen::Index i, Eigen::Index j, double x) { K(i, j) += x; }
  void velocity(Eigen::Index i, Eigen::Index j, double x) { C(i, j) += x; }
};

inline const std::vector<Spring> some{{3, 1, 20, 0.4}, {0, 1, 10, 0.5}, {4, 0, 5, 9}, {2, 3, 8, 0}, {1, 2, 7, 1.5}};

template <int dim>
Motion<Vec> points() {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Motion<Vec> y{Vec(dim * 5), Vec(dim * 5)};
  for (double& x : y.r) x = uniform(random);
  for (double& x : y.v) x = uniform(random);
  return y;
}
struct Out {
  Vec force;
};

template <int dim>
void check_pairs() {
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

}  // namespace springs_cases

using namespace springs_cases;

#if PHISTEP_QUICK

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

TEST_CASE("the force does not depend on the order of the list") {
  const auto y = points<3>();
  auto shuffled = some;
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(4));
  const auto network = spring_network<3>(some), other = spring_network<3>(shuffled);
  Out a{Vec::Zero(15)}, b{Vec::Zero(15)};
  network.add(0.0, y, a);
  other.add(0.0, y, b);
  CHECK(a.force.norm() > 1);
  CHECK(a.force == b.force);  // sorted alike: the same bits
}

#elif PHISTEP_FULL

TEMPLATE_TEST_CASE_SIG("pairs are the entries, without what dashpots add to the tangent in r", "", ((int dim), dim), 1,
                       2, 3) {
  check_pairs<dim>();
}

#endif
