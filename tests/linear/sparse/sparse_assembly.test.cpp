// Sparse assembly: entries in an order of the force's own, patterns that change on the way, and what is stored.
#include <phistep/linear/sparse/sparse_assembly.hpp>
#include <phistep/sparse.hpp>

#include <random>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;
using Mat = Eigen::MatrixXd;
using Vec = Eigen::VectorXd;

namespace {

constexpr Eigen::Index n = 7;

struct Entry {
  Eigen::Index i, j;
  double x;
  bool is_K;
};
/// A system that shows its W, and counts its patterns.
template <bool has_K, bool has_C, bool adds_transposes = false>
struct Shown : SparseAssembly<double, has_K, has_C, adds_transposes> {
  int patterns = 0;
  void write(const std::vector<Entry>& entries) {
    this->clear();
    for (const Entry& e : entries) e.is_K ? this->position(e.i, e.j, e.x) : this->velocity(e.i, e.j, e.x);
  }
  Mat made(double force, double drift, const auto& masses) {
    patterns += this->settle(masses);
    this->assemble(masses, force, drift);
    return Mat(this->matrix());
  }
  void lose_pattern() { this->forget_pattern(); }
};
const auto masses = [](auto&& put) {
  for (Eigen::Index i = 0; i < n; ++i) put(i, i, 2.0 + static_cast<double>(i));
  put(Eigen::Index{0}, Eigen::Index{3}, 0.5);
};
Mat dense(const std::vector<Entry>& entries, double force, double drift, bool has_K, bool has_C) {
  Mat W = Mat::Zero(n, n);
  masses([&W](Eigen::Index i, Eigen::Index j, double m) { W(i, j) += m; });
  for (const Entry& e : entries)
    if (e.is_K ? has_K : has_C) W(e.i, e.j) -= force * (e.is_K ? drift : 1.0) * e.x;
  return W;
}
std::vector<Entry> entries_of(unsigned seed, int count, bool has_K, bool has_C) {
  std::mt19937 random{seed};
  std::vector<Entry> all;
  for (int k = 0; k < count; ++k)
    all.push_back({static_cast<Eigen::Index>(random() % n), static_cast<Eigen::Index>(random() % n),
                   static_cast<double>(random() % 97) / 16 - 3, has_K && (!has_C || random() % 2 == 0)});
  return all;
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("W is M - gamma C - gamma^2 K whatever the order of the entries, and whenever it changes", "",
                       ((bool has_K, bool has_C), has_K, has_C), (true, true), (true, false), (false, true)) {
  Shown<has_K, has_C> system;
  system.resize(n);
  const auto check = [&](const std::vector<Entry>& entries, int patterns) {
    system.write(entries);
    CHECK(system.is_finite());
    CHECK((system.made(0.5, 0.25, masses) - dense(entries, 0.5, 0.25, has_K, has_C)).norm() <= 1e-14);
    CHECK(system.patterns == patterns);
    // Another γ of the same tangents.
    CHECK((system.made(2, 1, masses) - dense(entries, 2, 1, has_K, has_C)).norm() <= 1e-14);
    CHECK(system.patterns == patterns);
    if (has_K) {
      const Vec x = Vec::LinSpaced(n, -1, 2);
      Vec out = Vec::Ones(n);
      system.add_position_product(3, x, out);
      const Mat K = (dense(entries, 1, 0, has_K, has_C) - dense(entries, 1, 1, has_K, has_C));
      CHECK((out - Vec::Ones(n) - 3 * K * x).norm() <= 1e-12);
    }
  };
  auto first = entries_of(1, 30, has_K, has_C);
  check(first, 1);
  for (Entry& e : first) e.x *= -1.5;
  check(first, 1);  // new values, the same places
  auto other = first;
  std::swap(other[11], other[20]);
  check(other, 2);  // another order, noticed on the way
  check(other, 2);
  other.resize(21);
  check(other, 3);  // fewer
  auto more = other;
  more.push_back({6, 0, 1.5, has_K});
  check(more, 4);  // more
  check(more, 4);
  check({}, 5);
  // The pattern is lost after its values have come: they are not.
  check(first, 6);
  system.write(first);
  system.lose_pattern();
  CHECK(system.is_finite());
  CHECK((system.made(0.5, 0.25, masses) - dense(first, 0.5, 0.25, has_K, has_C)).norm() <= 1e-14);
  CHECK(system.patterns == 7);
  system.write(first);
  CHECK((system.made(0.5, 0.25, masses) - dense(first, 0.5, 0.25, has_K, has_C)).norm() <= 1e-14);
  CHECK(system.patterns == 7);
}

TEST_CASE("masses are those of the call, and what isn't finite is found in a new pattern and in an old one") {
  Shown<true, true> system;
  system.resize(n);
  auto entries = entries_of(3, 12, true, true);
  system.write(entries);
  static_cast<void>(system.made(1, 1, masses));
  const auto heavier = [](auto&& put) {
    masses([&put](Eigen::Index i, Eigen::Index j, double m) { put(i, j, 10 * m); });
  };
  CHECK((system.made(1, 1, heavier) - system.made(1, 1, masses) - 9 * dense({}, 0, 0, true, true)).norm() <= 1e-13);
  entries[5].x = NAN;
  system.write(entries);
  CHECK_FALSE(system.is_finite());
  Shown<true, true> fresh;
  fresh.resize(n);
  fresh.write(entries);
  CHECK_FALSE(fresh.is_finite());
}

TEST_CASE("of a kind of tangent that isn't there, entries are not even places") {
  Shown<false, true> system;
  system.resize(n);
  system.write({{1, 4, 2.0, true}, {5, 2, 3.0, false}});
  const Mat W = system.made(1, 1, masses);
  CHECK(W(5, 2) == -3);
  CHECK(system.pattern().nonZeros() == n + 2);  // (5, 2) and the mass's (0, 3)
}

TEST_CASE("with transposes, every entry's has a slot") {
  Shown<false, true, true> system;
  system.resize(n);
  system.write({{1, 4, 2.0, false}});
  const Mat W = system.made(1, 0, masses);
  CHECK(W(1, 4) == -2);
  CHECK(system.pattern().coeff(4, 1) == 0);
  CHECK(system.pattern().nonZeros() == n + 4);  // (4, 1) and the mass's (0, 3), (3, 0), too
}

TEST_CASE("a place that doesn't exist in the pattern is another pattern, no access beyond it") {
  Shown<false, true> system;
  system.resize(n);
  system.write({{1, 4, 2.0, false}, {2, 2, 1.0, false}});
  static_cast<void>(system.made(1, 0, masses));
  system.write({{1, 6, 2.0, false}, {6, 6, 1.0, false}});
  CHECK((system.made(1, 0, masses) - dense({{1, 6, 2.0, false}, {6, 6, 1.0, false}}, 1, 0, false, true)).norm() == 0);
}
