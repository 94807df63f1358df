#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <phistep/phistep.hpp>

#include <cmath>

namespace problems {

/// u_t = Δu + λ u²(1 − u) on the unit square (cube), u = 0 around it, by the five-point (seven-point) stencil on m^d inner
/// points, with an optional wind w: −w ∂u/∂x by central differences, which makes the Jacobian unsymmetric.
struct ReactionDiffusion {
  using Vec = Eigen::VectorXd;
  using Sparse = Eigen::SparseMatrix<double>;
  Eigen::Index m = 20;
  int dim = 2;
  double rate = 50, wind = 0, wind_from = 0;  ///< λ [1/time], w [length/time], from that time on

  [[nodiscard]] Eigen::Index size() const { return dim == 2 ? m * m : m * m * m; }
  [[nodiscard]] double scale() const { return static_cast<double>((m + 1) * (m + 1)); }
  [[nodiscard]] double drift(double t) const { return t >= wind_from ? wind * static_cast<double>(m + 1) / 2 : 0.0; }
  [[nodiscard]] Vec start() const {
    Vec u(size());
    const double h = 1 / static_cast<double>(m + 1);
    const auto bump = [h](Eigen::Index i) { return std::sin(3.14159265358979323846 * h * static_cast<double>(i + 1)); };
    for (Eigen::Index k = 0; k < size(); ++k)
      u[k] = 0.9 * bump(k % m) * bump(k / m % m) * (dim == 3 ? bump(k / (m * m)) : 1.0);
    return u;
  }

  void add(double t, const auto& state, auto& out) const {
    const double* const u = state.y.data();
    double* const to = out.rate.data();
    const double s = scale(), w = drift(t);
    const Eigen::Index n = size(), planes = dim == 2 ? 1 : m;
    Eigen::Index k = 0;
    for (Eigen::Index z = 0; z < planes; ++z)
      for (Eigen::Index y = 0; y < m; ++y)
        for (Eigen::Index x = 0; x < m; ++x, ++k) {
          double sum = (y > 0 ? u[k - m] : 0) + (y + 1 < m ? u[k + m] : 0);
          const double left = x > 0 ? u[k - 1] : 0, right = x + 1 < m ? u[k + 1] : 0;
          sum += left + right;
          if (dim == 3) sum += (k >= m * m ? u[k - m * m] : 0) + (k + m * m < n ? u[k + m * m] : 0);
          to[k] += s * (sum - 2 * dim * u[k]) - w * (right - left) + rate * u[k] * u[k] * (1 - u[k]);
        }
  }
  void add_jacobian(double t, const auto& state, auto& sink) const {
    entries(t, state.y, [&sink](Eigen::Index i, Eigen::Index j, double x) { sink.rate(i, j, x); });
  }
  void entries(double t, const auto& u, auto&& put) const {
    const double s = scale(), w = drift(t);
    for (Eigen::Index k = 0; k < size(); ++k) {
      const Eigen::Index x = k % m, y = k / m % m;
      put(k, k, -2 * dim * s + rate * u[k] * (2 - 3 * u[k]));
      if (x > 0) put(k, k - 1, s + w);
      if (x + 1 < m) put(k, k + 1, s - w);
      if (y > 0) put(k, k - m, s);
      if (y + 1 < m) put(k, k + m, s);
      if (dim == 3 && k >= m * m) put(k, k - m * m, s);
      if (dim == 3 && k + m * m < size()) put(k, k + m * m, s);
    }
  }
  [[nodiscard]] Sparse pattern() const {
    std::vector<Eigen::Triplet<double>> all;
    entries(0, Vec::Ones(size()).eval(), [&all](Eigen::Index i, Eigen::Index j, double x) {
      all.emplace_back(static_cast<int>(i), static_cast<int>(j), x);
    });
    Sparse A(size(), size());
    A.setFromTriplets(all.begin(), all.end());
    return A;
  }
};

/// … as a term with a sparse Jacobian.
struct ReactionDiffusionTerm : phistep::ForceTerm, ReactionDiffusion {
  static constexpr phistep::Structure structure = phistep::Structure::sparse;
  explicit ReactionDiffusionTerm(const ReactionDiffusion& problem) : ReactionDiffusion{problem} {}
};

/// … as a function, whose Jacobian is made by differences.
[[nodiscard]] inline auto as_function(const ReactionDiffusion& problem) {
  return [problem](const Eigen::VectorXd& u, double t) -> Eigen::VectorXd {
    struct {
      const Eigen::VectorXd& y;
    } state{u};
    struct {
      Eigen::VectorXd rate;
    } out{Eigen::VectorXd::Zero(u.size())};
    problem.add(t, state, out);
    return out.rate;
  };
}

}  // namespace problems
