#pragma once

// Random networks of mass-action reactions: A → B, A → B + C, A + B → C, A + B → C + D, rates 1e-3 … 1e9. Every species
// has a mass of 1, 2 or 3, which all reactions keep.

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <type_traits>
#include <vector>

#include "accuracy/truth/problem.hpp"
#include "accuracy/truth/random.hpp"

namespace truth {

/// In the form of problems/entries.hpp.
class Network {
 public:
  using State = Eigen::VectorXd;

  Network(Random& random, int species, int reactions) : masses_(species) {
    for (int i = 0; i < species; ++i) masses_[i] = i < 3 ? 1 + i % 2 : random.integer(1, 3);
    while (static_cast<int>(reactions_.size()) < reactions) {
      const auto draw = [&] { return random.integer(0, species - 1); };
      const auto maybe = [&] { return random.chance(0.5) ? draw() : none; };
      const Reaction next{draw(), maybe(), draw(), maybe(), random.power_of_ten(-3, 9)};
      const bool nothing = (next.a == next.c && next.b == next.d) || (next.a == next.d && next.b == next.c);
      if (!nothing && mass(next.a) + mass(next.b) == mass(next.c) + mass(next.d)) reactions_.push_back(next);
    }
  }
  [[nodiscard]] const Eigen::VectorXd& masses() const { return masses_; }

  template <class Y, class Out>
  void rate(const Y& y, Out&& out) const {
    for (Eigen::Index i = 0; i < masses_.size(); ++i) out[i] = 0;
    for (const Reaction& r : reactions_) {
      const auto v = r.b == none ? r.k * y[r.a] : r.k * y[r.a] * y[r.b];
      for (const int i : {r.a, r.b})
        if (i != none) out[i] -= v;
      for (const int i : {r.c, r.d})
        if (i != none) out[i] += v;
    }
  }
  template <class Y, class Put>
  void entries(const Y& y, Put&& put) const {
    for (const Reaction& r : reactions_) {
      const auto by = [&](int j, const auto& slope) {
        for (const int i : {r.a, r.b})
          if (i != none) put(i, j, -slope);
        for (const int i : {r.c, r.d})
          if (i != none) put(i, j, slope);
      };
      using T = std::remove_cvref_t<decltype(y[0])>;
      by(r.a, r.b == none ? T(r.k) : T(r.k * y[r.b]));
      if (r.b != none) by(r.b, T(r.k * y[r.a]));
    }
  }

 private:
  static constexpr int none = -1;
  struct Reaction {
    int a, b, c, d;  // a + b → c + d, b and d may be none
    double k;
  };
  [[nodiscard]] double mass(int i) const { return i == none ? 0 : masses_[i]; }
  Eigen::VectorXd masses_;
  std::vector<Reaction> reactions_;
};

}  // namespace truth
