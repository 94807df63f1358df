/// @file
/// The step's matrix W = M − γ_f C − γ_f γ_d K of particles that act on each other in pairs, as an EdgeOperator, solved
/// by conjugate gradients.
///
/// A central pair's tangents are B = along n nᵀ + across (I − n nᵀ), for K and for C with one n, hence for W as well:
///     along_W = γ_f (along_C + γ_d along_K),   across_W likewise,   a = across_W,   w = √|along_W − across_W| n.
/// Only a negative across (a compressed spring) or along (a softening pair) can make W indefinite. Conjugate gradients see
/// it as pᵀWp ≤ 0; W is then made again from the parts clamped at zero, which is definite: Newton converges more slowly,
/// to the same solution (Teran et al., Robust quasistatic finite elements, SCA 2005, do so for elements).
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/linear/network/edge_operator.hpp"
#include "phistep/linear/network/node_order.hpp"
#include "phistep/step/matrix/choice.hpp"
#include "phistep/step/matrix/dense_system.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Relative residual of the linear solve inside Newton where the user names none: an inexact Newton iteration (Dembo,
/// Eisenstat & Steihaug, SIAM J. Numer. Anal. 19, 1982) with a constant forcing term. Measured in docs/reference/solvers.md.
inline constexpr double automatic_linear_rtol = 1e-2;

template <class Scalar, int dim, bool has_K, bool has_C>
class NetworkSystem : public SystemDefaults {
 public:
  void resize(Eigen::Index n) {
    *this = {};
    unknowns_ = n;
    const auto nodes = static_cast<std::size_t>((n + dim - 1) / dim);
    W_.diagonal.assign(nodes, Node::Zero());
    mass_.assign(nodes, Node::Zero());
    drift_.assign(nodes, Scalar{0});
    diagonal_size_.assign(nodes, Scalar{0});
    cg_.resize(nodes);
  }

  void clear() {
    written_ = 0;
    if (!has_pattern_) pairs_.clear(), tangents_.clear();
    std::fill(local_.begin(), local_.end(), Local{});
  }
  void position(Eigen::Index i, Eigen::Index j, Scalar x) {
    if constexpr (has_K) local(i, j).K += x;
  }
  void velocity(Eigen::Index i, Eigen::Index j, Scalar x) {
    if constexpr (has_C) local(i, j).C += x;
  }
  void rate(Eigen::Index i, Eigen::Index j, Scalar x) { velocity(i, j, x); }

  /// The pair (i, j) of particles: ∂f_i/∂r_j = ∂f_j/∂r_i = −∂f_i/∂r_i = −∂f_j/∂r_j = K, and C likewise for velocities.
  /// @param n  the unit vector along the pair, dim numbers
  /// @throws std::invalid_argument unless both are particles of this state
  void edge(Eigen::Index i, Eigen::Index j, const Scalar* n, PairTangent<Scalar> K, PairTangent<Scalar> C = {}) {
    const NodePair pair{static_cast<std::int32_t>(i), static_cast<std::int32_t>(j)};
    if (has_pattern_ && (written_ >= pairs_.size() || pairs_[written_] != pair)) {
      pairs_.resize(written_);
      tangents_.resize(written_);
      has_pattern_ = false;
    }
    if (!has_pattern_) {
      const auto nodes = static_cast<Eigen::Index>(W_.nodes());
      if (i < 0 || j < 0 || i >= nodes || j >= nodes || i == j)
        throw std::invalid_argument("phistep: no pair of particles: " + std::to_string(i) + " and " +
                                    std::to_string(j) + " of " + std::to_string(nodes));
      pairs_.push_back(pair);
      tangents_.emplace_back();
    }
    Tangent& tangent = tangents_[written_++];
    for (int a = 0; a < dim; ++a) tangent.n[a] = n[a];
    if constexpr (has_K) tangent.K = K;
    if constexpr (has_C) tangent.C = C;
  }

  [[nodiscard]] bool is_finite() const {
    FiniteWitness<Scalar> witness;
    for (std::size_t e = 0; e < written_; ++e) {
      const Tangent& t = tangents_[e];
      for (const Scalar x : t.n) witness.see(x);
      if constexpr (has_K) witness.see(t.K.along), witness.see(t.K.across);
      if constexpr (has_C) witness.see(t.C.along), witness.see(t.C.across);
    }
    for (const Local& x : local_) witness.see(x.K), witness.see(x.C);
    return witness.all_finite();
  }

  [[nodiscard]] Outcome factorize(const auto& masses, Scalar gamma_force, Scalar gamma_drift, Statistics& statistics) {
    if (!has_pattern_ || written_ != pairs_.size()) make_pattern(statistics);
    gamma_drift_ = gamma_drift;
    ++statistics.factorizations;
    // Where the last particle is incomplete, its missing components are unknowns of their own.
    for (Node& m : mass_) m.template head<dim>().setOnes();
    masses([this](Eigen::Index i, Eigen::Index, auto m) {
      mass_[number_[static_cast<std::size_t>(i / dim)]][i % dim] = static_cast<Scalar>(m);
    });
    // Edges hold roots. Those of numbers like masses must be scaled exactly where the unit of mass is, by odd powers of two
    // as well: W is multiplied by two for every other one.
    scale_ = mass_.empty() || std::ilogb(mass_.front()[0]) % 2 == 0 ? Scalar{1} : Scalar{2};
    for (Node& m : mass_) m *= scale_;
    gamma_force_ = scale_ * gamma_force;
    if (assemble(false)) return Outcome::success;
    ++statistics.fallbacks;
    return assemble(true) ? Outcome::success : Outcome::not_positive_definite;
  }

  /// @param rtol  relative residual at which to stop, 0: automatic
  [[nodiscard]] Outcome solve(auto& x, double rtol, Statistics& statistics) {
    const auto tolerance = static_cast<Scalar>(rtol > 0 ? rtol : automatic_linear_rtol);
    // In exact arithmetic one iteration an unknown would do; rounding delays small stiff networks.
    const auto most = static_cast<int>(std::min<Eigen::Index>(20 * unknowns_ + 100, 100000));
    const Scalar unit = to_unit_size(max_abs(x));  // so that squares stay in range
    for (int attempt = 0; attempt < 2; ++attempt) {
      cg_.residual.assign(W_.nodes(), Node::Zero());
      for_each_unknown(
          [&, by = scale_ * unit](auto i, auto component, auto at) { cg_.residual[i][component] = by * x[at]; });
      const auto end = cg_.solve(W_, tolerance, most);
      statistics.linear_iterations += cg_.iterations;
      if (end == BlockCg<Scalar, dim>::End::converged) {
        for_each_unknown([&](auto i, auto component, auto at) { x[at] = cg_.solution[i][component] / unit; });
        return Outcome::success;
      }
      if (end == BlockCg<Scalar, dim>::End::gave_up || clamped_) break;
      ++statistics.fallbacks;
      if (!assemble(true)) break;
    }
    return Outcome::linear_solver_failed;
  }
  /// Forgets the numbering of the nodes.
  void forget_pattern() { has_pattern_ = has_coupling_ = false; }

 private:
  using Operator = EdgeOperator<Scalar, dim>;
  using Node = typename Operator::Node;
  struct Tangent {
    Scalar n[dim];
    [[no_unique_address]] Only<has_K, PairTangent<Scalar>, 0> K;
    [[no_unique_address]] Only<has_C, PairTangent<Scalar>, 1> C;
  };
  struct Local {
    Scalar K{0}, C{0};
  };

  [[nodiscard]] Local& local(Eigen::Index i, Eigen::Index j) {
    if (i / dim != j / dim)
      throw std::invalid_argument("phistep: a force whose pairs come as edges has an entry between particles " +
                                  std::to_string(i / dim) + " and " + std::to_string(j / dim) +
                                  "; its structure is not Structure::network");
    if (local_.empty()) local_.assign(W_.nodes() * dim * dim, {});
    has_coupling_ = has_coupling_ || i != j;
    return local_[static_cast<std::size_t>((i / dim * dim + j % dim) * dim + i % dim)];
  }

  /// Numbers the nodes, and sorts the edges by their nodes.
  void make_pattern(Statistics& statistics) {
    has_pattern_ = false;  // not until all of this has been done: it may run out of memory
    pairs_.resize(written_);
    tangents_.resize(written_);
    if (pairs_.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
      throw std::invalid_argument("phistep: too many pairs for one network");
    const std::vector<std::int32_t> number = close_order(W_.nodes(), pairs_);
    number_.assign(number.begin(), number.end());
    std::vector<std::pair<NodePair, std::size_t>> sorted;
    sorted.reserve(pairs_.size());
    for (std::size_t e = 0; e < pairs_.size(); ++e)
      sorted.push_back({std::minmax({number[static_cast<std::size_t>(pairs_[e].first)],
                                     number[static_cast<std::size_t>(pairs_[e].second)]}),
                        e});
    std::sort(sorted.begin(), sorted.end());
    W_.connect(sorted);
    source_.resize(sorted.size());
    for (std::size_t s = 0; s < sorted.size(); ++s) source_[s] = sorted[s].second;
    has_pattern_ = true;
    ++statistics.analyses;
  }

  /// W and its preconditioner. False where a diagonal block is not positive definite.
  [[nodiscard]] bool assemble(bool clamped) {
    clamped_ = clamped;
    fill_nodes(clamped);
    W_.has_signs = false;
    for (std::size_t s = 0; s < source_.size(); ++s) {
      const Tangent& t = tangents_[source_[s]];
      PairTangent<Scalar> B;
      if constexpr (has_K) {
        B = {gamma_drift_ * t.K.along, gamma_drift_ * t.K.across};
        const Scalar size = std::max(std::abs(B.along), std::abs(B.across));
        drift_[number_[static_cast<std::size_t>(pairs_[source_[s]].first)]] += size;
        drift_[number_[static_cast<std::size_t>(pairs_[source_[s]].second)]] += size;
      }
      if constexpr (has_C) B.along += t.C.along, B.across += t.C.across;
      B.along *= gamma_force_, B.across *= gamma_force_;
      if (clamped) B.along = std::max(Scalar{0}, B.along), B.across = std::max(Scalar{0}, B.across);
      const Scalar beyond = B.along - B.across, size = std::sqrt(std::abs(beyond));
      W_.signs[s] = beyond < Scalar{0} ? Scalar{-1} : Scalar{1};
      W_.has_signs = W_.has_signs || beyond < Scalar{0};
      Node& edge = W_.edges[s];
      edge.setZero();
      for (int a = 0; a < dim; ++a) edge[a] = size * t.n[a];
      edge[3] = B.across;
    }
    const bool definite = cg_.precondition(W_, diagonal_size_);
    // Node by node: a heavy one must not hide how stiff the others are.
    double share = 0, largest = 0;
    for (std::size_t i = 0; i < drift_.size(); ++i) {
      share = std::max(share, static_cast<double>(std::abs(gamma_force_) * drift_[i] / diagonal_size_[i]));
      largest = std::max(largest, static_cast<double>(diagonal_size_[i]));
    }
    set(std::min(share, 1.0), largest / static_cast<double>(scale_));
    return definite;
  }

  /// M − γ_f C − γ_f γ_d K of what acts on each particle alone; without C and K where clamped and not definite.
  void fill_nodes(bool clamped) {
    for (std::size_t i = 0; i < W_.nodes(); ++i) W_.diagonal[i] = mass_[i];
    std::fill(drift_.begin(), drift_.end(), Scalar{0});
    if (local_.empty()) return;
    if (has_coupling_) W_.coupling.resize(W_.nodes());
    for (std::size_t particle = 0; particle < W_.nodes(); ++particle) {
      const std::size_t i = number_[particle];
      Scalar N[dim][dim]{}, test[dim][dim];
      for (int b = 0; b < dim; ++b)
        for (int a = 0; a < dim; ++a) {
          const Local& x = local_[(particle * dim + static_cast<std::size_t>(b)) * dim + static_cast<std::size_t>(a)];
          drift_[i] = std::max(drift_[i], std::abs(gamma_drift_ * x.K));
          test[b][a] = N[b][a] = (a == b ? mass_[i][a] : Scalar{0}) - gamma_force_ * (x.C + gamma_drift_ * x.K);
        }
      const bool keep = !clamped || invert_definite<dim>(test);
      for (int b = 0; b < dim; ++b) {
        if (keep) W_.diagonal[i][b] = N[b][b];
        if (!has_coupling_) continue;
        Node& column = W_.coupling[i][static_cast<std::size_t>(b)];
        column.setZero();
        for (int a = 0; a < dim; ++a) column[a] = keep ? N[b][a] : a == b ? mass_[i][a] : Scalar{0};
      }
    }
  }

  /// f(node of W, component, index among the unknowns)
  void for_each_unknown(auto f) const {
    Eigen::Index at = 0;
    for (const std::size_t i : number_)
      for (Eigen::Index a = 0; a < dim && at < unknowns_; ++a, ++at) f(i, a, at);
  }

  Eigen::Index unknowns_ = 0;
  EdgeOperator<Scalar, dim> W_;
  BlockCg<Scalar, dim> cg_;
  std::vector<NodePair> pairs_;                // in the force's order
  std::vector<Tangent> tangents_;              // likewise
  std::vector<Local> local_;                   // column-major blocks, particle by particle
  std::vector<Node> mass_;                     // by node of W
  std::vector<Scalar> drift_, diagonal_size_;  // by node of W: γ_d K, and the largest entry on W's diagonal
  std::vector<std::size_t> number_;            // node of W of each particle
  std::vector<std::size_t> source_;            // of each edge of W in tangents_
  Scalar gamma_force_{0}, gamma_drift_{0};     // γ_f times scale_, and γ_d
  Scalar scale_{1};                            // what W, its right-hand sides and mass_ are multiplied by
  std::size_t written_ = 0;
  bool has_pattern_ = false, has_coupling_ = false, clamped_ = false;
};

template <MatrixFacts facts, class Scalar, class Solver, class Force>
struct SystemFor<SystemKind::edges, facts, Scalar, Solver, Force> {
  using type = NetworkSystem<Scalar, facts.block, facts.has_K, facts.has_C>;
};

}}  // namespace phistep::PHISTEP_ABI
