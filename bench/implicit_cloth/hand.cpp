#include <Eigen/Dense>

#include <cstring>

#include "rivals.hpp"

namespace cloth {
namespace {
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// xx yy zz xy xz yz
struct SixDoubles {
  int i, j;
  double b[6];
  void set(const Vector3d& w, double a) {
    b[0] = a + w[0] * w[0], b[1] = a + w[1] * w[1], b[2] = a + w[2] * w[2];
    b[3] = w[0] * w[1], b[4] = w[0] * w[2], b[5] = w[1] * w[2];
  }
  void times(double u, double v, double w, double& p, double& q, double& s) const {
    p = b[0] * u + b[3] * v + b[4] * w, q = b[3] * u + b[1] * v + b[5] * w, s = b[4] * u + b[5] * v + b[2] * w;
  }
};
template <class T>
struct Four {
  int i, j;
  T d[3], a;
  void set(const Vector3d& w, double across) {
    for (int c = 0; c < 3; ++c) d[c] = static_cast<T>(w[c]);
    a = static_cast<T>(across);
  }
  void times(double u, double v, double w, double& p, double& q, double& s) const {
    const double h = d[0] * u + d[1] * v + d[2] * w;
    p = a * u + h * d[0], q = a * v + h * d[1], s = a * w + h * d[2];
  }
};

template <class Edge>
class Packed : public Rival {
 public:
  explicit Packed(const Problem& problem) : edges_(problem.springs.size()), inverse_(problem.r.size()) {}

  void step(const Problem& problem, Answer& answer) override {
    assemble(problem);
    const Eigen::Index n = problem.unknowns();
    VectorXd& x = answer.x;
    x.setZero(n);
    r_ = problem.right_hand_side;
    z_.resize(n), A_.resize(n);
    double rz = precondition();
    const double target = tolerance * r_.norm();
    p_ = z_;
    for (answer.iterations = 1; answer.iterations < 20000; ++answer.iterations) {
      multiply(p_.data(), A_.data());
      const double alpha = rz / p_.dot(A_);
      x += alpha * p_;
      r_ -= alpha * A_;
      if (r_.norm() < target) break;
      const double next = precondition();
      p_ = z_ + next / rz * p_;
      rz = next;
    }
  }

 private:
  void assemble(const Problem& problem) {
    for (auto& block : inverse_) block.setIdentity();
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      const Spring& s = problem.springs[e];
      double across = 0;
      const Vector3d n = problem.direction(s, across), w = std::sqrt(problem.k * (1 - across)) * n;
      const double a = problem.k * across;
      edges_[e].i = s.i, edges_[e].j = s.j;
      edges_[e].set(w, a);
      const Matrix3d B = a * Matrix3d::Identity() + w * w.transpose();
      inverse_[static_cast<std::size_t>(s.i)] += B;
      inverse_[static_cast<std::size_t>(s.j)] += B;
    }
    for (auto& block : inverse_) block = block.inverse().eval();
  }
  double precondition() {
    double sum = 0;
    for (std::size_t i = 0; i < inverse_.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(3 * i);
      const Vector3d z = inverse_[i] * r_.segment<3>(at);
      z_.segment<3>(at) = z;
      sum += z.dot(r_.segment<3>(at));
    }
    return sum;
  }
  void multiply(const double* x, double* y) const {
    std::memcpy(y, x, static_cast<std::size_t>(A_.size()) * sizeof(double));
    for (const Edge& e : edges_) {
      const double *const a = x + 3 * e.i, *const b = x + 3 * e.j;
      double p = 0, q = 0, s = 0;
      e.times(a[0] - b[0], a[1] - b[1], a[2] - b[2], p, q, s);
      double *const c = y + 3 * e.i, *const d = y + 3 * e.j;
      c[0] += p, c[1] += q, c[2] += s;
      d[0] -= p, d[1] -= q, d[2] -= s;
    }
  }

  std::vector<Edge> edges_;
  std::vector<Matrix3d> inverse_;
  VectorXd r_, z_, p_, A_;
};

/// The same with the edges of a node together (half of them, to later nodes), y_i in a register, four lanes a node, and
/// all that follows from α in one sweep.
class Padded : public Rival {
  using Node = Eigen::Array4d;
  struct Inverse {
    Node column[3];
  };

 public:
  explicit Padded(const Problem& problem)
      : nodes_{problem.r.size()},
        start_(nodes_ + 1, 0),
        to_(problem.springs.size()),
        edges_(problem.springs.size()),
        sorted_(problem.springs),
        inverse_(nodes_),
        sum_(nodes_) {
    for (auto& s : sorted_)
      if (s.i > s.j) std::swap(s.i, s.j);
    std::sort(sorted_.begin(), sorted_.end(),
              [](const Spring& a, const Spring& b) { return a.i < b.i || (a.i == b.i && a.j < b.j); });
    for (std::size_t e = 0; e < sorted_.size(); ++e) {
      ++start_[static_cast<std::size_t>(sorted_[e].i) + 1];
      to_[e] = sorted_[e].j;
    }
    for (std::size_t i = 0; i < nodes_; ++i) start_[i + 1] += start_[i];
    for (auto* all : {&x_, &r_, &z_, &p_, &y_}) all->assign(nodes_, Node::Zero());
  }

  void step(const Problem& problem, Answer& answer) override {
    assemble(problem);
    double rr = 0, rz = 0;
    for (std::size_t i = 0; i < nodes_; ++i) {
      const Vector3d b = problem.right_hand_side.segment<3>(static_cast<Eigen::Index>(3 * i));
      r_[i] << b[0], b[1], b[2], 0;
      x_[i].setZero();
      z_[i] = p_[i] = product(i, r_[i]);
      rr += (r_[i] * r_[i]).sum();
      rz += (r_[i] * z_[i]).sum();
    }
    const double target = tolerance * tolerance * rr;
    for (answer.iterations = 1; answer.iterations < 20000; ++answer.iterations) {
      const double alpha = rz / multiply();
      Node all_rr = Node::Zero(), all_rz = Node::Zero();
      for (std::size_t i = 0; i < nodes_; ++i) {
        x_[i] += alpha * p_[i];
        const Node r = r_[i] - alpha * y_[i], z = product(i, r);
        r_[i] = r, z_[i] = z;
        all_rr += r * r, all_rz += r * z;
      }
      if (all_rr.sum() < target) break;
      const double next = all_rz.sum(), beta = next / rz;
      rz = next;
      for (std::size_t i = 0; i < nodes_; ++i) p_[i] = z_[i] + beta * p_[i];
    }
    answer.x.resize(problem.unknowns());
    for (std::size_t i = 0; i < nodes_; ++i)
      for (int c = 0; c < 3; ++c) answer.x[static_cast<Eigen::Index>(3 * i) + c] = x_[i][c];
  }

 private:
  [[nodiscard]] Node product(std::size_t i, const Node& r) const {
    const Inverse& D = inverse_[i];
    return D.column[0] * r[0] + D.column[1] * r[1] + D.column[2] * r[2];
  }
  void assemble(const Problem& problem) {
    for (auto& block : sum_) block.setIdentity();
    for (std::size_t e = 0; e < sorted_.size(); ++e) {
      const Spring& s = sorted_[e];
      double across = 0;
      const Vector3d n = problem.direction(s, across), w = std::sqrt(problem.k * (1 - across)) * n;
      const double a = problem.k * across;
      edges_[e] << w[0], w[1], w[2], a;
      const Matrix3d B = a * Matrix3d::Identity() + w * w.transpose();
      sum_[static_cast<std::size_t>(s.i)] += B;
      sum_[static_cast<std::size_t>(s.j)] += B;
    }
    for (std::size_t i = 0; i < nodes_; ++i) {
      const Matrix3d D = sum_[i].inverse();
      for (int c = 0; c < 3; ++c) inverse_[i].column[c] << D(0, c), D(1, c), D(2, c), 0;
    }
  }
  double multiply() {
    const Node* const x = p_.data();
    Node* const y = y_.data();
    for (std::size_t i = 0; i < nodes_; ++i) y[i] = x[i];
    Node product = Node::Zero();
    for (std::size_t i = 0; i < nodes_; ++i) {
      const Node here = x[i];
      Node sum = y[i];
      for (int e = start_[i]; e < start_[i + 1]; ++e) {
        const int j = to_[static_cast<std::size_t>(e)];
        const Node w = edges_[static_cast<std::size_t>(e)], d = here - x[j];
        const double h = (w * d).sum();
        const Node q = edges_[static_cast<std::size_t>(e)][3] * d + h * w;
        sum += q;
        y[j] -= q;
      }
      product += here * sum;
      y[i] = sum;
      y[i][3] = 0;
    }
    return product.sum();
  }

  std::size_t nodes_;
  std::vector<int> start_, to_;
  std::vector<Node> edges_;
  std::vector<Spring> sorted_;
  std::vector<Inverse> inverse_;
  std::vector<Matrix3d> sum_;
  std::vector<Node> x_, r_, z_, p_, y_;
};
}  // namespace

std::unique_ptr<Rival> hand_six_doubles(const Problem& p) { return std::make_unique<Packed<SixDoubles>>(p); }
std::unique_ptr<Rival> hand_four_doubles(const Problem& p) { return std::make_unique<Packed<Four<double>>>(p); }
std::unique_ptr<Rival> hand_four_floats(const Problem& p) { return std::make_unique<Packed<Four<float>>>(p); }
std::unique_ptr<Rival> hand_padded(const Problem& p) { return std::make_unique<Padded>(p); }

}  // namespace cloth
