// Steps written into the state or through a view.
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "support/catch.hpp"

namespace in_place_cases {

using namespace phistep;

enum class Trouble { none, nan, inf, exception };

/// Ψ = f, from the `at`-th call on with a trouble in number `where`.
template <class Scalar>
struct Setting {
  Index particles;
  std::vector<Scalar> r, v, f;  // x₀ y₀ z₀ x₁ …
  Scalar dt;
  int steps;
  Trouble trouble = Trouble::none;
  int at = 0;
  Index where = 0;
};
template <class Scalar>
struct Force {
  const Setting<Scalar>* setting;
  int calls = 0;
  template <class Block>
  Block operator()(const Block& r) {
    Block out = r;
    for (Index k = 0; k < r.size(); ++k) out.data()[k] = setting->f[static_cast<std::size_t>(k)];
    if (calls++ < setting->at || setting->trouble == Trouble::none) return out;
    if (setting->trouble == Trouble::exception) throw std::runtime_error("struck");
    out.data()[setting->where] = setting->trouble == Trouble::nan ? std::numeric_limits<Scalar>::quiet_NaN()
                                                                  : -std::numeric_limits<Scalar>::infinity();
    return out;
  }
};

/// How it ended.
template <class Scalar>
struct Ended {
  std::vector<Scalar> r, v;
  std::int64_t steps = 0, force_calls = 0, failed_steps = 0, block = -1, index = -1;
  Outcome outcome = Outcome::success;
  bool threw = false;

  friend bool operator==(const Ended& a, const Ended& b) {
    const auto same = [](const std::vector<Scalar>& x, const std::vector<Scalar>& y) {
      return same_bits(x.data(), y.data(), static_cast<Index>(x.size()));
    };
    return same(a.r, b.r) && same(a.v, b.v) && a.steps == b.steps && a.force_calls == b.force_calls &&
           a.failed_steps == b.failed_steps && a.block == b.block && a.index == b.index && a.outcome == b.outcome &&
           a.threw == b.threw;
  }
};

/// Steps until one fails, then once more: a failure must leave nothing behind.
template <class Scalar, class S>
Ended<Scalar> go(S y, const Setting<Scalar>& setting, auto scheme, auto mass, bool edited) {
  Ended<Scalar> end;
  PhiStepper stepper{y, Force<Scalar>{&setting}, scheme, mass};
  for (int n = 0, failures = 0; n < setting.steps && failures < 2; ++n) {
    try {
      const StepReport report = stepper.step(y, static_cast<Scalar>(n) * setting.dt, setting.dt,
                                             edited || n == 0 ? Origin::unknown : Origin::unedited);
      if (!report) {
        ++failures;
        end.outcome = report.outcome();
        end.block = report.failure().block, end.index = report.failure().index;
      }
    } catch (const std::runtime_error&) {
      ++failures;
      end.threw = true;
    }
  }
  end.steps = stepper.statistics().steps;
  end.force_calls = stepper.statistics().force_calls;
  end.failed_steps = stepper.statistics().failed_steps;
  const auto take = [](const auto& block) {
    using Block = typename std::remove_cvref_t<decltype(block)>::PlainObject;
    const Block plain = block;
    return std::vector<Scalar>(plain.data(), plain.data() + plain.size());
  };
  end.r = take(y.r), end.v = take(y.v);
  return end;
}

/// r and v by views of type V on memory with gaps; the gaps must stay.
template <class V, class Scalar>
Ended<Scalar> go_mapped(const Setting<Scalar>& setting, auto scheme, auto mass, bool edited, auto make) {
  std::vector<Scalar> memory(static_cast<std::size_t>(20 * setting.particles), Scalar{0.125});
  std::vector<Scalar> taken(memory.size(), Scalar{0.125});
  const auto put = [&](V block, const std::vector<Scalar>& values, Scalar* from) {
    for (Index k = 0; k < block.size(); ++k) {
      auto& place = V::IsVectorAtCompileTime ? block(k % block.rows(), k / block.rows()) : block(k % 3, k / 3);
      place = values[static_cast<std::size_t>(k)];
      taken[static_cast<std::size_t>(&place - from)] = 0;
    }
  };
  Motion<V> y{make(memory.data(), 0), make(memory.data(), 1)};
  put(y.r, setting.r, memory.data()), put(y.v, setting.v, memory.data());
  const Ended<Scalar> end = go(y, setting, scheme, mass, edited);
  bool kept = true;
  for (std::size_t k = 0; k < memory.size(); ++k) kept = kept && (taken[k] == 0 || memory[k] == Scalar{0.125});
  CHECK(kept);
  return end;
}

/// All layouts, edited and unedited, against an owned vector whose every step is done beside it.
template <class Scalar>
void compare(const Setting<Scalar>& s, auto scheme, auto mass) {
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Columns = Eigen::Matrix<Scalar, 3, Eigen::Dynamic>;
  const Index n = s.particles;
  const Motion<Vector> flat{Eigen::Map<const Vector>(s.r.data(), 3 * n), Eigen::Map<const Vector>(s.v.data(), 3 * n)};
  const Motion<Columns> columns{Eigen::Map<const Columns>(s.r.data(), 3, n),
                                Eigen::Map<const Columns>(s.v.data(), 3, n)};
  const Ended<Scalar> beside = go(flat, s, scheme, mass, true);
  CHECK(go(flat, s, scheme, mass, false) == beside);
  CHECK(go(columns, s, scheme, mass, false) == beside);
  for (const bool edited : {true, false}) {
    CAPTURE(edited);
    using Mapped = Eigen::Map<Vector>;
    using Strided = Eigen::Map<Vector, 0, Eigen::InnerStride<2>>;
    using Structs = Eigen::Map<Columns, 0, Eigen::OuterStride<>>;
    CHECK(go_mapped<Mapped>(s, scheme, mass, edited,
                            [n](Scalar* p, Index which) { return Mapped(p + which * 4 * n, 3 * n); }) == beside);
    CHECK(go_mapped<Strided>(s, scheme, mass, edited,
                             [n](Scalar* p, Index which) { return Strided(p + which, 3 * n); }) == beside);
    CHECK(go_mapped<Structs>(s, scheme, mass, edited, [n](Scalar* p, Index which) {
            return Structs(p + 4 * which, 3, n, Eigen::OuterStride<>(12));
          }) == beside);
    CHECK(go_mapped<Structs>(s, scheme, mass, edited, [n](Scalar* p, Index which) {  // one with gaps, one without
            return Structs(p + which * 8 * n, 3, n, Eigen::OuterStride<>(which == 0 ? 4 : 3));
          }) == beside);
    Vector r = flat.r, v = flat.v;
    using Reference = Eigen::Ref<Vector>;
    CHECK(go(Motion<Reference>{Reference(r), Reference(v)}, s, scheme, mass, edited) == beside);
    CHECK(same_bits(r.data(), beside.r.data(), 3 * n));
  }
}

/// Numbers of all magnitudes: usual ones, denormal ones, and such that some step leaves the range of the type.
template <class Scalar>
Setting<Scalar> random_setting(std::mt19937& random, Index particles) {
  using Limits = std::numeric_limits<Scalar>;
  const Scalar scales[] = {
      1, Limits::denorm_min() * 1000, std::sqrt(Limits::max()), Limits::max() / 1000, Limits::max() / 4, Limits::max()};
  std::uniform_int_distribution<std::size_t> pick(0, std::size(scales) - 1), one_in(0, 3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto numbers = [&] {
    std::vector<Scalar> x(static_cast<std::size_t>(3 * particles));
    const Scalar scale = scales[pick(random)], usual = one_in(random) == 0 ? scale : Scalar{1};
    for (Scalar& value : x) value = usual * static_cast<Scalar>(uniform(random));
    // Mostly a single number is large: it must be found where it stands.
    x[std::uniform_int_distribution<std::size_t>(0, x.size() - 1)(random)] =
        scale * static_cast<Scalar>(uniform(random));
    return x;
  };
  Setting<Scalar> s{particles, numbers(), numbers(), numbers(), Scalar{0}, 6};
  const Scalar lengths[] = {Scalar{0.01f}, Scalar{1}, Scalar{1000}, -Scalar{0.5f}, std::sqrt(Limits::max())};
  s.dt = lengths[std::uniform_int_distribution<std::size_t>(0, std::size(lengths) - 1)(random)];
  if (one_in(random) == 0) {
    s.trouble = static_cast<Trouble>(1 + one_in(random) % 3);
    s.at = static_cast<int>(one_in(random));
    s.where = std::uniform_int_distribution<Index>(0, 3 * particles - 1)(random);
  }
  return s;
}
template <class Scalar>
void compare_random(unsigned seed, int rounds, std::initializer_list<Index> sizes) {
  std::mt19937 random(seed);
  for (int round = 0; round < rounds; ++round)
    for (const Index n : sizes) {
      const Setting<Scalar> s = random_setting<Scalar>(random, n);
      CAPTURE(round, n, s.dt, static_cast<int>(s.trouble), s.at, s.where);
      Eigen::Matrix<Scalar, Eigen::Dynamic, 1> each(3 * n);
      for (Index k = 0; k < 3 * n; ++k) each[k] = static_cast<Scalar>(k % 7 == 3 ? 0.001 : 2.0);
      compare(s, forward_euler, mass(Scalar{2}));
      compare(s, symplectic_euler, mass(each));
      compare(s, velocity_verlet, UnitMasses{});
    }
}

}  // namespace in_place_cases

using namespace in_place_cases;

TEST_CASE("in place or beside, states of all magnitudes end alike") {
  compare_random<double>(1, 40, {2, 5});
  compare_random<double>(3, 4, {120});
  compare_random<double>(2, 2, {700});  // a strided view is written in several chunks
}

TEST_CASE("what fails after the first chunk of a view was written leaves every number as it was") {
  for (const Trouble trouble : {Trouble::nan, Trouble::inf, Trouble::exception})
    for (const Index where : {Index{0}, Index{3 * 400}, Index{3 * 700 - 1}})
      for (const int at : {0, 1, 2}) {
        const std::vector<double> x(2100, 0.75), f(2100, 3.0);
        const Setting<double> s{700, x, x, f, 0.1, 6, trouble, at, where};
        CAPTURE(static_cast<int>(trouble), where, at);
        compare(s, forward_euler, mass(1.5)), compare(s, velocity_verlet, mass(1.5));
      }
}

TEST_CASE("an unedited run is done in place where overflow is excluded, and beside the state where it isn't") {
  using Eigen::VectorXd;
  const auto is_swapped_each_step = [](double scale, double f, auto scheme) {
    Motion<VectorXd> y{VectorXd::Constant(300, scale), VectorXd::Constant(300, scale)};
    PhiStepper stepper{y, [f](const VectorXd& r) -> VectorXd { return VectorXd::Constant(r.size(), f); }, scheme};
    const double* const home = y.r.data();
    bool swapped = true;
    for (int n = 0; n < 6; ++n) {
      REQUIRE(stepper.step(y, 0.1 * n, 0.1, n == 0 ? Origin::unknown : Origin::unedited));
      swapped = swapped && (y.r.data() == home) == (n % 2 == 1);
    }
    return swapped;
  };
  CHECK_FALSE(is_swapped_each_step(1, 1, forward_euler));
  CHECK_FALSE(is_swapped_each_step(1e300, 1, symplectic_euler));
  CHECK(is_swapped_each_step(1e307, 1, forward_euler));  // 300 of them are more than there is
  CHECK(is_swapped_each_step(1, 1e307, symplectic_euler));
  CHECK(is_swapped_each_step(1, 1, velocity_verlet));
}

TEST_CASE("bounds are taken anew where the state may have been edited, and after failures") {
  using Eigen::VectorXd;
  Motion<VectorXd> y{VectorXd::Zero(300), VectorXd::Ones(300)};
  bool bad = false, throws = false;
  PhiStepper stepper{y,
                     [&](const VectorXd& r) -> VectorXd {
                       if (throws) throw std::runtime_error("struck");
                       return VectorXd::Constant(r.size(), bad ? std::nan("") : 1.0);
                     },
                     forward_euler};
  REQUIRE(stepper.step(y, 0.0, 0.1, Origin::unknown));
  REQUIRE(stepper.step(y, 0.1, 0.1, Origin::unedited));
  y.v[299] = 1.7e308;
  const auto keeps_every_bit = [&](Origin origin) {
    const Motion<VectorXd> before = y;
    const StepReport report = stepper.step(y, 0.2, 1e3, origin);
    CHECK(report.outcome() == Outcome::non_finite_state);
    CHECK(report.failure().index == 299);
    CHECK(equal_blocks<Motion<VectorXd>>(y, before));
  };
  keeps_every_bit(Origin::unknown);
  keeps_every_bit(Origin::unedited);
  y.v[299] = 1;
  REQUIRE(stepper.step(y, 0.2, 0.1, Origin::unknown));
  REQUIRE(stepper.step(y, 0.3, 0.1, Origin::unedited));
  bad = true;
  CHECK(stepper.step(y, 0.4, 0.1, Origin::unedited).outcome() == Outcome::non_finite_force);
  bad = false;
  y.v[299] = 1.7e308;  // what put the state back after a failure may have put back anything
  keeps_every_bit(Origin::unedited);
  y.v[299] = 1;
  REQUIRE(stepper.step(y, 0.4, 0.1, Origin::unedited));
  throws = true;
  CHECK_THROWS(stepper.step(y, 0.5, 0.1, Origin::unedited));
  throws = false;
  y.v[299] = 1.7e308;
  keeps_every_bit(Origin::unedited);
  y.v[299] = 1;
  REQUIRE(stepper.step(y, 0.5, 0.1, Origin::unedited));
  stepper.reset();
  y.v[299] = 1.7e308;
  keeps_every_bit(Origin::unedited);
}

// The same in every precision and many more times.

TEST_CASE("in place or beside, many states of all magnitudes end alike") {
  compare_random<double>(11, 400, {2, 3, 9});
  compare_random<double>(12, 10, {600, 1400});
}
TEST_CASE("in place or beside, so do those of other precisions") {
  compare_random<float>(13, 300, {2, 3, 9});
  compare_random<float>(14, 5, {900});
  compare_random<long double>(15, 200, {2, 5});
  compare_random<long double>(16, 3, {500});
}
