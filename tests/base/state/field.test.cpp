// Linear combinations of fields: the numbers of Eigen's, each vector touched once.
#include "support/catch.hpp"
#include "support/local_field.hpp"

#include <Eigen/Core>

#include <vector>

using namespace phistep;

namespace {
const std::vector<double> a0{1, -2, 3}, b0{0.5, 0.25, -4}, c0{7, 11, 13};
Eigen::Map<const Eigen::VectorXd> eigen(const std::vector<double>& x) {
  return {x.data(), static_cast<Eigen::Index>(x.size())};
}
}  // namespace

TEST_CASE("a linear combination of fields has the numbers of Eigen's, in one pass") {
  const long alive = LocalOps::counts().alive;
  {
    LocalField a = local_field(a0), b = local_field(b0), c = local_field(c0), out;
    const long before = LocalOps::counts().combinations;
    out = a + 0.5 * (b - c) / 4 - -c;
    CHECK(LocalOps::counts().combinations == before + 1);
    CHECK(eigen(numbers(out)).isApprox(eigen(a0) + 0.5 * (eigen(b0) - eigen(c0)) / 4 + eigen(c0), 1e-15));
    a = b + 2 * a;  // it may occur in what it becomes
    CHECK(eigen(numbers(a)).isApprox(eigen(b0) + 2 * eigen(a0), 1e-15));
    a -= b;
    a += c - a;
    CHECK(numbers(a) == c0);
    b *= 2;
    CHECK(numbers(b) == std::vector<double>{1, 0.5, -8});
    CHECK(numbers(c) == c0);
    CHECK(LocalOps::counts().combinations == before + 5);
    CHECK(LocalOps::counts().alive == alive + 4);
  }
  CHECK(LocalOps::counts().alive == alive);
}

TEST_CASE("a field is copied with its layout, moved with its vector, and empty without one") {
  LocalField a = local_field(a0), none;
  LocalField b = a;
  CHECK(numbers(b) == a0);
  CHECK(b.handle() != a.handle());
  const auto* handle = b.handle();
  const LocalField c = std::move(b);
  CHECK(c.handle() == handle);
  CHECK(none.size() == 0);
  none.setZero();
  none = a;
  CHECK(none.size() == 3);
  a = LocalField{};
  none.take_shape(c);  // it has one
  CHECK(numbers(none) == a0);
}

TEST_CASE("what the library asks of all ranks") {
  const LocalField y = local_field({1, -5, 2}), w = local_field({1, 2, 0});
  CHECK(all_finite(std::tie(y, w)));
  CHECK(largest(y) == 5);
  CHECK(weighted_rms(y, w) == std::sqrt((1 + 100 + 0) / 3.0));
  CHECK(equal_blocks<LocalField>(y, y));
  CHECK_FALSE(equal_blocks<LocalField>(y, w));
  const LocalField bad = local_field({1, std::nan(""), 2});
  const auto found = first_non_finite(std::tie(y, bad));
  CHECK(found.block == 1);
  CHECK(found.index == -1);
}
