/// @file
/// The problems in extended precision at any time, to be measured by: two solvers that share nothing with the library's
/// schemes. Both extrapolate to order 8 or 16 (Hairer & Wanner, Solving ODEs II, sect. IV.9; Hairer, Nørsett & Wanner,
/// Solving ODEs I, sect. II.9), with fixed columns, and land on each time that is asked for.
#pragma once

#include <Eigen/LU>
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

namespace truth {

using Real = long double;
template <int n>
using Vector = Eigen::Matrix<Real, n, 1>;

/// (I − hJ)⁻¹ for a problem with rate and entries (problems/entries.hpp).
template <class Problem>
class Dense {
 public:
  static constexpr int size = Problem::State::RowsAtCompileTime;
  using State = Vector<size>;
  Dense() = default;
  explicit Dense(Problem problem) : problem_{std::move(problem)} {}
  [[nodiscard]] State rate(const State& y) const {
    State out(y.size());
    problem_.rate(y, out);
    return out;
  }
  void linearize(const State& y) {
    J_.setZero(y.size(), y.size());
    problem_.entries(y, [this](int i, int j, Real x) { J_(i, j) += x; });
  }
  void factorize(Real h) { lu_.compute(Matrix::Identity(J_.rows(), J_.cols()) - h * J_); }
  template <class Columns>
  [[nodiscard]] auto solve(const Columns& b) const {
    return lu_.solve(b);
  }

 private:
  using Matrix = Eigen::Matrix<Real, size, size>;
  Problem problem_;
  Matrix J_;
  Eigen::PartialPivLU<Matrix> lu_;
};

/// The same for terms whose Jacobian is a band.
template <class Force>
class Banded {
 public:
  using State = Vector<Eigen::Dynamic>;
  Banded(Force force, Eigen::Index width) : force_{std::move(force)}, width_{width} {}
  [[nodiscard]] State rate(const State& y) const {
    Still state{y};
    Rates out{State::Zero(y.size())};
    force_.add(0.0, state, out);
    return out.rate;
  }
  void linearize(const State& y) {
    sink_.entries.clear();
    n_ = y.size();
    Still state{y};
    force_.add_jacobian(0.0, state, sink_);
  }
  void factorize(Real h) {
    if (lu_.rows() != n_) lu_.resize(n_, width_, width_);
    lu_.clear();
    for (Eigen::Index j = 0; j < n_; ++j) *lu_.column(j) = 1;
    for (const auto& [i, j, x] : sink_.entries) lu_.column(j)[i - j] -= h * x;
    if (!lu_.factorize()) throw std::runtime_error("truth: singular matrix");
  }
  [[nodiscard]] State solve(State b) const {
    lu_.solve_in_place(b);
    return b;
  }

 private:
  struct Still {
    const State& y;
  };
  struct Rates {
    State rate;
  };
  struct Sink {
    struct Entry {
      Eigen::Index i, j;
      Real x;
    };
    std::vector<Entry> entries{};
    void rate(Eigen::Index i, Eigen::Index j, Real x) { entries.push_back({i, j, x}); }
  };
  Force force_;
  Eigen::Index width_, n_ = 0;
  Sink sink_;
  phistep::BandedLu<Real> lu_;
};

/// Linearly implicit Euler in n_j = 1 … 8 steps: (I − hJ) Δ = h f(y), y ← y + Δ.
template <class Problem>
struct StiffRows {
  static constexpr int columns = 8;
  Problem problem;
  using State = typename Problem::State;

  static Real ratio(int j, int k) { return Real(j) / Real(j - k); }
  void begin(const State& y) { problem.linearize(y); }
  [[nodiscard]] State row(const State& y, Real H, int j) {
    const Real h = H / Real(j);
    problem.factorize(h);
    State z = y;
    for (int m = 0; m < j; ++m) z += problem.solve(h * problem.rate(z));
    return z;
  }
};

/// Motion by Störmer's rule in n_j = 1 … 8 steps: kick h/2, drift h, … in even powers of h.
template <class Force, int n>
struct MotionRows {
  static constexpr int columns = 8;
  using State = Vector<2 * n>;

  static Real ratio(int j, int k) { return Real(j * j) / Real((j - k) * (j - k)); }
  void begin(const State&) {}
  [[nodiscard]] State row(const State& y, Real H, int j) {
    const Real h = H / Real(j);
    Vector<n> r = y.template head<n>(), v = y.template tail<n>(), a;
    Force::acceleration(r.data(), a.data());
    for (int m = 0; m < j; ++m) {
      v += h / 2 * a;
      r += h * v;
      Force::acceleration(r.data(), a.data());
      v += h / 2 * a;
    }
    State z;
    z << r, v;
    return z;
  }
};

/// y at t1 from y at t0; dt: what is tried first, then what is right. Errors are judged by |y_i| + a.
template <class Rows>
void advance(Rows& rows, typename Rows::State& y, Real t0, Real t1, Real& dt, Real a, Real rtol) {
  using State = typename Rows::State;
  constexpr int columns = Rows::columns;
  constexpr int order = columns;
  std::vector<State> T(columns, y);
  Real t = t0;
  for (long attempts = 0; t < t1; ++attempts) {
    if (attempts > 1000000) throw std::runtime_error("truth: too many steps");
    const bool last = t + Real(1.0001) * dt >= t1;
    const Real H = last ? t1 - t : dt;
    rows.begin(y);
    Real error = 0;
    for (int j = 1; j <= columns; ++j) {
      State z = rows.row(y, H, j);
      // T[k] of the previous row moves to column k + 1 of this one.
      for (int k = 1; k < j; ++k) {
        std::swap(z, T[static_cast<std::size_t>(k - 1)]);
        const State& now = T[static_cast<std::size_t>(k - 1)];
        z = (now + (now - z) / (Rows::ratio(j, k) - 1)).eval();
      }
      if (j == columns)
        error = ((z - T[columns - 2]).array() / (rtol * (y.array().abs().max(z.array().abs()) + a))).abs().maxCoeff();
      T[static_cast<std::size_t>(j - 1)] = z;
    }
    const Real factor = std::isfinite(error)
                            ? std::clamp(Real(0.8) * std::pow(error, Real(-1) / order), Real(0.1), Real(4))
                            : Real(0.1);
    if (error <= 1) {
      y = T[columns - 1];
      t = last ? t1 : t + H;
      if (!last || factor < 1) dt = H * factor;
    } else {
      dt = H * factor;
    }
  }
}

/// A problem's legs, one after the other.
template <class Rows>
class Path {
 public:
  using State = typename Rows::State;
  using Legs = std::vector<std::pair<double, Rows>>;
  Path(Legs legs, double a, Real rtol) : legs_{std::move(legs)}, a_{a}, rtol_{rtol} {}

  [[nodiscard]] double end() const { return legs_.back().first; }
  /// y at `to` from y at `from`
  void go(State& y, Real from, Real to, Real dt) {
    for (auto& [end, rows] : legs_) {
      const Real stop = std::min<Real>(end, to);
      if (from >= stop) continue;
      advance(rows, y, from, stop, dt, a_, rtol_);
      from = stop;
      if (stop == end) dt = Real(1e-7) * end;
    }
  }
  /// One column a time, of the samples only where there are some.
  [[nodiscard]] Eigen::MatrixXd film(State y, const std::vector<double>& times,
                                     const std::vector<Eigen::Index>& samples = {}) {
    Eigen::MatrixXd out(samples.empty() ? y.size() : static_cast<Eigen::Index>(samples.size()),
                        static_cast<Eigen::Index>(times.size()));
    Real t = 0;
    for (std::size_t k = 0; k < times.size(); ++k) {
      const Real next = static_cast<Real>(times[k]);
      go(y, t, next, (next - t) / 4);
      t = next;
      for (Eigen::Index i = 0; i < out.rows(); ++i)
        out(i, static_cast<Eigen::Index>(k)) =
            static_cast<double>(y[samples.empty() ? i : samples[static_cast<std::size_t>(i)]]);
    }
    return out;
  }
  /// By how much the problem magnifies a small relative error made at its start or at one of ten later times, at worst, until
  /// its end; at least 1. With w = |y| + a, κ = max_s max_i Σ_k |∂y_i(end)/∂y_k(s)| w_k(s)/w_i(end): the norm of errors, with
  /// the worst signs. Of many unknowns with the worst of a dozen random ones, which is a bound from below.
  [[nodiscard]] double conditioning(State y) {
    constexpr int intervals = 11, tries = 12;
    const Real by = std::sqrt(rtol_) / 10;
    const auto n = y.size();
    const auto weight = [this](const State& x) -> State { return (x.array().abs() + Real(a_)).matrix(); };
    std::mt19937 random{1};
    double kappa = 1;
    for (int s = 0; s < intervals; ++s) {
      const Real from = Real(end()) * s / intervals;
      const State w = weight(y);
      const auto at_end = [&](State x) {
        go(x, from, Real(end()), Real(1e-7) * Real(end()));
        return x;
      };
      State growth = State::Zero(n);
      for (Eigen::Index k = 0; k < (n <= 40 ? n : tries); ++k) {
        State shift = State::Zero(n);
        if (n <= 40) shift[k] = w[k];
        else
          for (Eigen::Index i = 0; i < n; ++i) shift[i] = random() % 2 ? w[i] : -w[i];
        const State moved = ((at_end(y + by * shift) - at_end(y - by * shift)) / (2 * by)).cwiseAbs();
        growth = n <= 40 ? State(growth + moved) : State(growth.cwiseMax(moved));
      }
      kappa = std::max(kappa, static_cast<double>((growth.array() / weight(at_end(y)).array()).maxCoeff()));
      go(y, from, Real(end()) * (s + 1) / intervals, Real(1e-7) * Real(end()));
    }
    return kappa;
  }

 private:
  Legs legs_;
  double a_;
  Real rtol_;
};

/// Gives a table both.
template <class Table, class Rows>
void tell(Table& table, const Path<Rows>& path, const typename Rows::State& start) {
  table.truth = [path, start, samples = table.samples](const std::vector<double>& times) mutable {
    return Path<Rows>(path).film(start, times, samples);
  };
  table.conditioning = [path, start] { return Path<Rows>(path).conditioning(start); };
}

}  // namespace truth
