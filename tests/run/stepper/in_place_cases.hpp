// What in_place.test.cpp and in_place.full.cpp share: steps that may be written into the state or through a view, against
// steps beside it. Numbers up to the largest, faults at every call: to the bit the states, and what is said of a failure.
#pragma once

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
