#include <phistep/base/state/blocks.hpp>
#include <phistep/base/state/motion.hpp>
#include <phistep/base/state/reductions.hpp>

#include <cmath>

#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

static_assert(solved_blocks<Fixed> == 1 && solved_blocks<Motion<Fixed>> == 1 && solved_blocks<Warm> == 2);
static_assert(static_unknowns<Fixed> == 6 && static_unknowns<Motion<Fixed>> == 6);
static_assert(static_unknowns<Dynamic> == Eigen::Dynamic && static_unknowns<Warm> == Eigen::Dynamic);
static_assert(std::is_same_v<PlainState<Mapped>, Dynamic> &&
              std::is_same_v<PlainState<Motion<Strided>>, Motion<Dynamic>>);
static_assert(std::is_same_v<PlainState<Structs>, Columns> && std::is_same_v<PlainState<Warm>, Warm>);
static_assert(std::is_same_v<ScalarOf<Motion<Eigen::Vector2f>>, float>);

// An expression stands for the vector it makes; a view of the user's own memory stays a view.
static_assert(
    std::is_same_v<decltype(Motion{Eigen::Vector2d::Zero(), Eigen::Vector2d(1, 0)}), Motion<Eigen::Vector2d>>);
static_assert(std::is_same_v<decltype(Motion{std::declval<Mapped>(), std::declval<Mapped>()}), Motion<Mapped>>);

TEST_CASE("a motion solves for v alone") {
  const Motion<Fixed> y{Fixed::Zero(), Fixed::Ones()};
  CHECK(unknowns<Motion<Fixed>>(y) == 6);
  CHECK(std::get<0>(Blocks<Motion<Fixed>>::solved(y)) == y.v);
}

TEST_CASE("a user's own state solves for all but r") {
  const Coupled c;
  CHECK(unknowns<Warm>(c.state) == 8);
  CHECK(&std::get<0>(Blocks<Warm>::solved(c.state)) == &c.state.v);
  CHECK(&std::get<1>(Blocks<Warm>::solved(c.state)) == &c.state.T);
  const Warm::Rate rate = make_rate<Warm>(c.state);
  CHECK(rate.force == Eigen::VectorXd::Zero(6));
  CHECK(rate.heat == Eigen::VectorXd::Zero(2));
}

TEST_CASE("same_shape compares rows and columns of every block") {
  Motion<Columns> a{Columns::Zero(3, 2), Columns::Zero(3, 2)}, b = a;
  CHECK(same_shape<Motion<Columns>>(a, b));
  b.v.resize(3, 3);
  CHECK_FALSE(same_shape<Motion<Columns>>(a, b));
}

TEST_CASE("committing swaps owned dynamic buffers and copies into views") {
  Dynamic y = Dynamic::Ones(3), next = Dynamic::Constant(3, 2.0);
  const double* const old = next.data();
  commit_blocks<Dynamic>(y, next);
  CHECK(y == Dynamic::Constant(3, 2.0));
  CHECK(y.data() == old);

  Dynamic memory = Dynamic::Ones(3);
  Mapped view(memory.data(), 3);
  next.setConstant(5);
  commit_blocks<Mapped>(view, next);
  CHECK(memory == Dynamic::Constant(3, 5.0));
}

TEMPLATE_TEST_CASE("the first non-finite number is found by component and particle", "", Columns, RowMajor,
                   FixedColumns) {
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    Motion<TestType> y{TestType::Zero(3, 2), TestType::Zero(3, 2)};
    CHECK_FALSE(first_non_finite(Blocks<Motion<TestType>>::all(y)));
    y.v(2, 1) = bad;
    const ComponentLocation where = first_non_finite(Blocks<Motion<TestType>>::all(y));
    REQUIRE(where);
    CHECK(where.block == 1);
    CHECK(where.row == 2);
    CHECK(where.column == 1);
    CHECK_FALSE(std::isfinite(y.v.data()[where.index]));
  }
}
