#include <phistep/linear/network/edge_operator.hpp>

#include <random>

#include "support/catch.hpp"

using namespace phistep;

namespace {

/// A ring of five nodes with one chord, in the operator's own arrays and as a dense matrix.
template <int dim>
struct Ring {
  static constexpr int nodes = 5;
  EdgeOperator<double, dim> A;
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(nodes * dim, nodes* dim);

  Ring(bool with_signs, bool with_coupling) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(0.2, 1.0);
    using Small = Eigen::Matrix<double, dim, dim>;
    A.start = {0, 3, 4, 5, 6, 6};
    A.neighbour = {1, 2, 4, 2, 3, 4};
    A.has_signs = with_signs;
    const int from[] = {0, 0, 0, 1, 2, 3};
    for (std::size_t e = 0; e < 6; ++e) {
      Lanes<double> edge = Lanes<double>::Zero();
      Eigen::Matrix<double, dim, 1> w;
      for (int a = 0; a < dim; ++a) edge[a] = w[a] = uniform(random);
      edge[3] = uniform(random);
      A.edges.push_back(edge);
      A.signs.push_back(with_signs && e % 2 == 1 ? -1 : 1);
      const Small B = edge[3] * Small::Identity() + A.signs[e] * w * w.transpose();
      const int i = dim * from[e], j = dim * A.neighbour[e];
      dense.template block<dim, dim>(i, i) += B;
      dense.template block<dim, dim>(j, j) += B;
      dense.template block<dim, dim>(i, j) -= B;
      dense.template block<dim, dim>(j, i) -= B;
    }
    for (int i = 0; i < nodes; ++i) {
      Small N = Small::Zero();
      for (int a = 0; a < dim; ++a) N(a, a) = 2 + uniform(random);
      if (with_coupling) N(0, dim - 1) = N(dim - 1, 0) = uniform(random);
      typename EdgeOperator<double, dim>::Block block;
      Lanes<double> diagonal = Lanes<double>::Zero();
      for (int b = 0; b < dim; ++b) {
        block[static_cast<std::size_t>(b)].setZero();
        block[static_cast<std::size_t>(b)].template head<dim>() = N.col(b).array();
        diagonal[b] = N(b, b);
      }
      A.diagonal.push_back(diagonal);
      if (with_coupling) A.coupling.push_back(block);
      dense.template block<dim, dim>(dim * i, dim * i) += N;
    }
  }
};

template <int dim>
void check(bool with_signs, bool with_coupling) {
  const Ring<dim> ring(with_signs, with_coupling);
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(5 * dim, -1, 2);
  std::vector<Lanes<double>> in(5, Lanes<double>::Zero()), out(5);
  for (int i = 0; i < 5; ++i)
    for (int a = 0; a < dim; ++a) in[static_cast<std::size_t>(i)][a] = x[dim * i + a];
  for (std::size_t i = 0; i < 5; ++i) out[i] = ring.A.node(i, in[i]);
  const double product = ring.A.add_edges(in.data(), out.data());
  const Eigen::VectorXd y = ring.dense * x;
  for (int i = 0; i < 5; ++i)
    for (int a = 0; a < 4; ++a)
      // A few roundings of numbers below 30; padding is 0, exactly.
      CHECK(std::abs(out[static_cast<std::size_t>(i)][a] - (a < dim ? y[dim * i + a] : 0)) <= (a < dim ? 1e-14 : 0));
  CHECK(product == Approx(x.dot(y)).epsilon(1e-14));

  std::vector<typename EdgeOperator<double, dim>::Block> blocks(5);
  std::vector<double> scratch(5);
  ring.A.diagonal_blocks(blocks, scratch);
  for (int i = 0; i < 5; ++i)
    for (int b = 0; b < dim; ++b)
      for (int a = 0; a < dim; ++a)
        CHECK(blocks[static_cast<std::size_t>(i)][static_cast<std::size_t>(b)][a] ==
              Approx(ring.dense(dim * i + a, dim * i + b)).margin(1e-14));
}

}  // namespace

TEST_CASE("the operator is the matrix it stands for") {
  for (const bool with_signs : {false, true})
    for (const bool with_coupling : {false, true}) {
      CAPTURE(with_signs, with_coupling);
      check<1>(with_signs, with_coupling);
      check<2>(with_signs, with_coupling);
      check<3>(with_signs, with_coupling);
    }
}
