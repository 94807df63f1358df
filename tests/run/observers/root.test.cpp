#include <phistep/run/observers/root.hpp>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;
using Kind = Root<double>::Kind;

namespace {

/// Searches g over [t0, t1] and counts its evaluations between the ends.
struct Search {
  int evaluations = 0;
  template <class Scalar, class G>
  Root<Scalar> operator()(Scalar t0, Scalar t1, G&& g, Direction wanted = Direction::both,
                          Standing standing = Standing::clear) {
    evaluations = 0;
    const auto value = [&](Scalar t) {
      CHECK((t - t0) * (t1 - t) >= 0);
      ++evaluations;
      return g(t);
    };
    return first_root(Sample<Scalar>{t0, g(t0)}, Sample<Scalar>{t1, g(t1)}, value, standing, wanted);
  }
};

/// 100 u |t|: what a root is to be known to.
template <class Scalar>
Scalar allowed(Scalar t) {
  return 50 * std::numeric_limits<Scalar>::epsilon() * std::abs(t);
}

double uniform(std::mt19937_64& random, double a, double b) {
  return a + (b - a) * static_cast<double>(random() >> 11) * 0x1p-53;
}

}  // namespace

TEMPLATE_TEST_CASE("root: simple ones, to 100 u |t|, in few evaluations", "", float, double, long double) {
  using Scalar = TestType;
  Search search;
  const auto check = [&](Scalar t0, Scalar t1, auto g, Scalar exact) {
    const Root<Scalar> root = search(t0, t1, g);
    REQUIRE(root.kind == Root<Scalar>::Kind::found);
    CHECK(std::abs(root.t - exact) <= allowed(exact));
    CHECK(search.evaluations <= (t1 < 1000 || t0 == 1000 ? 16 : 24));  // a chord over 1000 times the root helps little
    CHECK(sign_of(root.before.g) == root.start_sign);
    CHECK(sign_of(root.after.g) != root.start_sign);
    CHECK(sign_of(root.slope) == -root.start_sign * sign_of(t1 - t0));
  };
  const auto two = [](Scalar t) { return t * t - 2; };
  const Scalar root2 = std::sqrt(Scalar(2));
  check(0, 2, two, root2);
  check(2, 0, two, root2);
  check(-2, 0, two, -root2);
  check(1, 1000, two, root2);
  check(
      0, 2, [](Scalar t) { return std::cos(t); }, std::acos(Scalar(0)));
  check(
      1000, 1001, [](Scalar t) { return std::cos(t - 999); }, 999 + std::acos(Scalar(0)));
  check(
      0, 1, [](Scalar t) { return t - Scalar(1e-6); }, Scalar(1e-6));
}

TEST_CASE("root: a step that spans t = 0 knows t to the rounding of t − t0") {
  Search search;
  const auto root = search(-1.0, 3.0, [](double t) { return std::expm1(t); });
  REQUIRE(root.kind == Kind::found);
  CHECK(std::abs(root.t) <= 2 * std::numeric_limits<double>::epsilon());
}

TEST_CASE("root: the slope there is dg/dt") {
  Search search;
  const auto root = search(0.0, 2.0, [](double t) { return t * t - 2; });
  CHECK(root.slope == Approx(2 * std::sqrt(2.0)).epsilon(1e-6));
}

TEST_CASE("root: only the direction that is wanted, as the run goes") {
  Search search;
  const auto g = [](double t) { return t - 0.25; };
  CHECK(search(0.0, 1.0, g, Direction::rising).kind == Kind::found);
  CHECK(search(0.0, 1.0, g, Direction::falling).kind == Kind::none);
  CHECK(search(1.0, 0.0, g, Direction::rising).kind == Kind::none);
  CHECK(search(1.0, 0.0, g, Direction::falling).kind == Kind::found);
}

TEST_CASE("root: g that dips through zero and comes back: the first root, or the one that is wanted") {
  Search search;
  for (const double depth : {0.1, 1e-4, 1e-10}) {
    const double w = std::sqrt(depth);
    const auto g = [=](double t) { return (t - 1.3) * (t - 1.3) - depth; };
    // g is exact to u near its roots, where its slope is 2w.
    const double bound = allowed(1.3) + std::numeric_limits<double>::epsilon() / w;
    const auto first = search(0.9, 2.0, g);
    REQUIRE(first.kind == Kind::found);
    CHECK(std::abs(first.t - (1.3 - w)) <= bound);
    CHECK(search.evaluations <= 40);
    const auto last = search(0.9, 2.0, g, Direction::rising);
    REQUIRE(last.kind == Kind::found);
    CHECK(std::abs(last.t - (1.3 + w)) <= bound);
    CHECK(std::abs(search(2.0, 0.9, g).t - (1.3 + w)) <= bound);
    const auto other = search(
        0.9, 2.0, [=](double t) { return -g(t); }, Direction::falling);
    CHECK(std::abs(other.t - (1.3 + w)) <= bound);
  }
}

TEST_CASE("root: g that comes near zero, or touches it, has none") {
  Search search;
  for (const double gap : {0.1, 1e-6, 1e-12, 0.0}) {
    const auto root = search(1.0, 2.0, [=](double t) { return (t - 1.3) * (t - 1.3) + gap; });
    CHECK(root.kind == Kind::none);
    CHECK(root.start_sign == 1);
    CHECK(search.evaluations <= 40);
  }
  CHECK(search(1.0, 2.0, [](double t) { return t; }).kind == Kind::none);
  CHECK(search.evaluations <= 1);  // at the start g leaves zero: no more to see
  CHECK(search(1.0, 2.0, [](double t) { return 3 - t; }).kind == Kind::none);
  CHECK(search.evaluations <= 2);
}

TEST_CASE("root: g that is zero at the end has its root there") {
  Search search;
  for (const double t1 : {2.0, 0.0, -3.0}) {
    const auto root = search(1.0, t1, [=](double t) { return t - t1; });
    REQUIRE(root.kind == Kind::found);
    CHECK(root.t == t1);
  }
  // Dips through zero and comes back to it at the end: the first root all the same, or the one that is wanted.
  const auto dip = [](double t) { return (t - 1.25) * (t - 1.5); };
  CHECK(std::abs(search(1.0, 1.5, dip).t - 1.25) <= allowed(1.25));
  CHECK(search(1.0, 1.5, dip, Direction::rising).t == 1.5);
  CHECK(search(1.0, 1.5, [](double t) { return (t - 1.5) * (t - 1.5); }).t == 1.5);  // touches it there
}

TEST_CASE("root: a ball on the ground that is thrown up, in steps up to 1e4 times its flight") {
  Search search;
  for (const double t0 : {0.0, 1.0, -0.5})
    for (const double step : {0.3, 1.5, 30.0, 1e4})
      for (const double residue : {0.0, 1e-17, -1e-17}) {
        CAPTURE(t0, step, residue);
        const auto g = [=](double t) { return residue + (t - t0) * (1 - (t - t0)); };
        const auto root = search(t0, t0 + step, g, Direction::falling, Standing::on_root);
        CHECK(root.start_sign == 1);
        CHECK((root.kind == Kind::found) == (step > 1));
        // 1 + t0 is known to the rounding of t − t0, here of (t1 − t0) at worst.
        if (step > 1) CHECK(std::abs(root.t - (t0 + 1)) <= allowed(1.5) * std::max(1.0, std::abs(t0)));
        CHECK(search.evaluations <= 60);
      }
}

TEST_CASE("root: one just handled is not found again, whichever way rounding left it") {
  Search search;
  for (const double t0 : {0.0, 0.7, 1e6})
    for (const double ulps : {-3.0, -1.0, 0.0, 1.0, 3.0})
      for (const double slope : {1.0, -1.0, 1e-8, 1e8}) {
        const double residue = ulps * slope * std::max(std::abs(t0), 1.0) * 0x1p-52;
        const auto g = [=](double t) { return residue + slope * (t - t0) * (2 + t - t0); };
        CAPTURE(t0, ulps, slope);
        const auto root = search(t0, t0 + 1, g, Direction::both, Standing::on_root);
        CHECK(root.kind == Kind::none);
        CHECK(root.start_sign == sign_of(slope));
      }
}

TEST_CASE("root: a run that starts where another ended on a root; one that starts near a root") {
  Search search;
  for (const double residue : {1e-16, -1e-16}) {
    const auto g = [=](double t) { return residue + (t - 0.3); };
    CHECK(search(0.3, 1.0, g, Direction::both, Standing::unknown).kind == Kind::none);
  }
  // Farther than rounding from it, the root is ahead.
  const auto near = search(
      0.3, 1.0, [](double t) { return t - 0.3 - 1e-11; }, Direction::both, Standing::unknown);
  CHECK(near.kind == Kind::found);
  CHECK(std::abs(near.t - 0.3 - 1e-11) <= allowed(0.3));
  CHECK(search(
            0.3, 1.0, [](double) { return 1.0; }, Direction::both, Standing::unknown)
            .start_sign == 1);
  CHECK(search.evaluations <= 2);
}

TEST_CASE("root: of two runs in a row one finds a root at their joint, whichever side rounding puts it on") {
  Search search;
  for (const double joint : {0.3, -7.0, 1e6})
    for (const double way : {1.0, -1.0})  // backward, too
      for (const double ulps : {-900.0, -400.0, -3.0, -1.0, -0.25, 0.0, 0.25, 1.0, 3.0, 100.0, 400.0, 700.0, 2000.0})
        for (const double slope : {1.0, -1e-8, 1e8}) {
          CAPTURE(joint, way, ulps, slope);
          const double before = ulps * std::abs(joint) * 0x1p-52;  // the root lies so far behind the joint [time]
          const auto g = [=](double t) { return slope * (way * (t - joint) - before); };
          const auto first = search(joint - way, joint, g);
          const auto second = search(joint, joint + way, g, Direction::both, Standing::unknown);
          CHECK((first.kind == Kind::found) + (second.kind == Kind::found) == 1);
          if (first.kind == Kind::found) CHECK(std::abs(first.t - joint) <= 1024 * std::abs(joint) * 0x1p-52);
          // The other direction finds none in either.
          const Direction other = slope > 0 ? Direction::falling : Direction::rising;
          CHECK(search(joint - way, joint, g, other).kind == Kind::none);
          CHECK(search(joint, joint + way, g, other, Standing::unknown).kind == Kind::none);
        }
  // A jump, too.
  for (const double joint : {0.0, 0.3, -7.0, 1e6})
    for (const double ulps : {-900.0, -1.0, 0.0, 1.0, 2.0, 30.0, 100.0, 900.0})
      for (const double size : {1.0, 1e-300, 1e300}) {
        CAPTURE(joint, ulps, size);
        const double at = joint + ulps * std::abs(joint) * 0x1p-52;
        const auto g = [=](double t) { return t < at ? -1.0 : size; };
        const auto first = search(joint - 1, joint, g);
        const auto second = search(joint, joint + 1, g, Direction::both, Standing::unknown);
        CHECK((first.kind == Kind::found) + (second.kind == Kind::found) == 1);
      }
  // What comes near zero and leaves again has none; steps that end far from a root ask nothing more.
  CHECK(search(1.0, 2.0, [](double t) { return 1e-9 + (t - 2) * (t - 2); }).kind == Kind::none);
  CHECK(search(1.0, 2.0, [](double t) { return t - 2 - 1e-9; }).kind == Kind::none);
  CHECK(search.evaluations <= 2);
}

TEST_CASE("root: a start on a flat root, beside rounding errors of g") {
  Search search;
  // The ball lies on the ground, at height 1 + g: the drop is lost in the 1 until t = 1e-8.
  const auto height = [](double t) { return (1 - t * t) - 1; };
  const auto root = search(0.0, 1.0, height);
  CHECK(root.kind == Kind::none);
  CHECK(root.start_sign == -1);
  const auto nothing = search(0.0, 1.0, [](double) { return 0.0; });
  CHECK(nothing.kind == Kind::none);
  CHECK(nothing.start_sign == 0);
}

TEST_CASE(
    "root: where a step is too short for probes, its end tells how g leaves its root, unless that is as near as its "
    "start") {
  Search search;
  // With room for no probe, or for two.
  for (const double length : {0x1p-48, 0x1p-44})
    for (const int side : {-1, 1}) {
      const auto root = search(
          1.0, 1.0 + length, [side](double t) { return side * (t - 1); }, Direction::both, Standing::on_root);
      CHECK(root.kind == Kind::none);
      CHECK(root.start_sign == side);
    }
  const auto stays = search(
      1.0, 1.0 + 0x1p-44, [](double) { return 1e-17; }, Direction::both, Standing::on_root);
  CHECK(stays.start_sign == 0);
}

TEST_CASE("root: one nearer to t0 than time can tell comes after it: no step has length 0") {
  Search search;
  const auto root = search(1.0, 2.0, [](double t) { return (t - 1) - 1e-17; });
  REQUIRE(root.kind == Kind::found);
  CHECK(root.t > 1);
  CHECK(root.t - 1 <= allowed(1.0));
}

TEST_CASE("root: rounding errors of g are not taken for its sign") {
  // A flat start, beside errors that happen to grow, or to grow within what is known to be rounding.
  const std::vector<double> growing{0.2, 1, 2, -1, 1}, small{1, 0.2, 0.4, 0.8, -0.5};
  for (const auto& noise : {growing, small}) {
    std::size_t n = 0;
    const auto g = [&](double t) { return -t * t + 1e-17 * (n < noise.size() ? noise[n++] : 0); };
    const Sample<double> start{0.0, g(0.0)};
    const auto root = first_root(start, Sample<double>{1.0, -1.0}, g, Standing::on_root);
    CHECK(root.kind == Kind::none);
    CHECK(root.start_sign == -1);
  }
}

TEST_CASE("root: jumps are found to the resolution of time, by less than 100 evaluations") {
  Search search;
  for (const double at : {0.3, 1e-9, 0.999999})
    for (const double far : {1.0, 1e-300, 1e300}) {
      const auto root = search(0.0, 1.0, [=](double t) { return t < at ? -1.0 : far; });
      REQUIRE(root.kind == Kind::found);
      CHECK(std::abs(root.t - at) <= allowed(at));
      CHECK(search.evaluations < 100);
    }
  // On the far side of a jump that was handled, it is over.
  const auto over = search(
      0.3, 1.0, [=](double) { return 1.0; }, Direction::both, Standing::on_root);
  CHECK(over.kind == Kind::none);
  CHECK(over.start_sign == 1);
  // A pole changes sign, too, and is no root; what counts is that the search ends.
  CHECK(search(0.0, 1.0, [](double t) { return 1 / (t - 0.3); }).kind == Kind::found);
  CHECK(search.evaluations < 100);
}

TEST_CASE("root: steep and flat g, of any size") {
  Search search;
  for (const double scale : {1e-290, 1e-20, 1.0, 1e290})
    for (const int power : {1, 3, 9, 21}) {
      const auto g = [=](double t) { return scale * std::pow(t - 0.3, power); };
      const auto root = search(0.0, 1.0, g);
      REQUIRE(root.kind == Kind::found);
      // Where g underflows it is zero; it is so within (1e-324/scale)^(1/power) of the root.
      CHECK(std::abs(root.t - 0.3) <= allowed(0.3) + std::pow(1e-320 / scale, 1.0 / power));
      CHECK(search.evaluations < 100);
    }
  const auto steep = search(0.0, 1.0, [](double t) { return std::tanh(1e12 * (t - 0.3)); });
  CHECK(std::abs(steep.t - 0.3) <= allowed(0.3));
  CHECK(search.evaluations < 100);
}

TEST_CASE("root: g that is not finite is reported, with the time, wherever it happens") {
  Search search;
  const double nan = std::nan(""), infinity = HUGE_VAL;
  for (const double bad : {nan, infinity, -infinity}) {
    auto root = search(0.0, 1.0, [=](double t) { return t == 0 ? bad : 1.0; });
    CHECK(root.kind == Kind::not_finite);
    CHECK(root.t == 0);
    root = search(0.0, 1.0, [=](double t) { return t == 1 ? bad : 1.0; });
    CHECK(root.kind == Kind::not_finite);
    CHECK(root.t == 1);
    root = search(0.0, 1.0, [=](double t) { return t == 0 ? -1 : t == 1 ? 1 : bad; });
    CHECK(root.kind == Kind::not_finite);
    CHECK(search.evaluations == 1);
    root = search(0.0, 1.0, [=](double t) { return t == 0 ? 0 : t == 1 ? 1 : bad; });
    CHECK(root.kind == Kind::not_finite);
    CHECK(search.evaluations == 1);
    root = search(0.0, 1.0, [=](double t) { return t > 0.4 && t < 0.6 ? bad : (t - 0.5) * (t - 0.5); });
    CHECK(root.kind == Kind::not_finite);
    CHECK(std::abs(root.t - 0.5) <= 0.1);
  }
}

TEST_CASE("root: 10 000 polynomials with one root in the step, and as many with two") {
  std::mt19937_64 random;
  const std::uint64_t seed = std::random_device{}();
  random.seed(seed);
  CAPTURE(seed);
  Search search;
  int most = 0;
  double total = 0;
  for (int n = 0; n < 10000; ++n) {
    const double t0 = uniform(random, -10, 10), dt = (random() & 1 ? 1 : -1) * std::exp(uniform(random, -7, 3));
    const double root = t0 + dt * uniform(random, 0.001, 0.999), scale = std::exp(uniform(random, -30, 30));
    // The other roots stay a tenth of the step or more away from it. In factors, g has the right sign at every t.
    double others[4];
    const auto degree = random() % 5;
    for (double& r : others) r = t0 + dt * (random() & 1 ? uniform(random, 1.1, 10) : uniform(random, -10, -0.1));
    const auto product = [&](double t) {
      double g = scale;
      for (std::uint64_t k = 0; k < degree; ++k) g *= (t - others[k]) / dt;
      return g;
    };
    const double least = 4 * std::numeric_limits<double>::epsilon() * std::min(std::abs(t0), std::abs(t0 + dt));
    const auto one = search(t0, t0 + dt, [&](double t) { return product(t) * (t - root); });
    CAPTURE(n, t0, dt, root, degree, one.t);
    REQUIRE(one.kind == Kind::found);
    REQUIRE(std::abs(one.t - root) <= std::max(allowed(root), least));
    most = std::max(most, search.evaluations);
    total += search.evaluations;

    const double second = t0 + dt * uniform(random, 0.001, 0.999),
                 first = std::abs(root - t0) < std::abs(second - t0) ? root : second;
    if (std::abs(second - root) < 1e-4 * std::abs(dt)) continue;
    const auto two = search(t0, t0 + dt, [&](double t) { return scale * (t - root) * (t - second); });
    CAPTURE(second, two.t);
    REQUIRE(two.kind == Kind::found);
    REQUIRE(std::abs(two.t - first) <= std::max(allowed(first), least));
  }
  WARN("evaluations for one root: mean " << total / 10000 << ", most " << most);
  CHECK(most < 60);
}

TEST_CASE("root: no bracket takes more than two evaluations beyond bisection") {
  // Functions made to fool the rule of false position.
  for (const double at : {0.001, 0.3, 0.77})
    for (const int kind : {0, 1, 2, 3}) {
      int evaluations = 0;
      const auto g = [&](double t) {
        ++evaluations;
        const double x = t - at;
        switch (kind) {
          case 0:
            return x < 0 ? -1.0 : 1e9 * x + 1e-9;
          case 1:
            return std::copysign(std::exp(-1e-3 / (x * x + 1e-300)), x);
          case 2:
            return std::cbrt(x);
          default:
            return x < 0 ? -1e-200 : 1.0;
        }
      };
      Sample<double> a{0, g(0)}, b{1, g(1)};
      evaluations = 0;
      const double least = 1e-12;
      close_bracket(a, b, least, g);
      CHECK(evaluations <= static_cast<int>(std::ceil(std::log2(1 / least))) + 2);
      CHECK((g(a.t) == 0 || (a.t - at) * (b.t - at) <= 0));  // one of them underflows to zero
    }
}

TEST_CASE("root: units of time and of g that are powers of two change no bit and no count") {
  Search search;
  const double time = 0x1p40, unit = 0x1p-60;
  const auto g = [](double t) { return (t - 1.3) * (t - 1.7) * (t + 2); };
  for (const double t1 : {1.5, 2.0}) {
    const auto plain = search(1.0, t1, g);
    const int evaluations = search.evaluations;
    const auto scaled = search(time, t1 * time, [&](double t) { return unit * g(t / time); });
    CHECK(scaled.kind == Kind::found);
    CHECK(scaled.t == plain.t * time);
    CHECK(scaled.slope == plain.slope * unit / time);
    CHECK(search.evaluations == evaluations);
  }
}

TEST_CASE("refine: corrects an interpolated root by one to three steps really done") {
  Search search;
  const auto g = [](double t) { return std::cos(t); };
  for (const double error : {1e-2, 1e-4, 1e-8, -1e-4}) {
    // What really happens is the interpolant, shifted and bent.
    const auto real = [=](double t) { return std::cos(t) + error * (1 + t); };
    const auto root = search(1.0, 2.0, g);
    std::vector<double> tried;
    const auto refined = refine(root, Sample<double>{2, g(2)}, [&](double t) {
      tried.push_back(t);
      return real(t);
    });
    CAPTURE(error, refined.t, tried.size());
    CHECK(refined.t == tried.back());
    CHECK(refined.g == real(refined.t));
    CHECK(std::abs(refined.g) <= 1e-14);
    CHECK(refined.resteps == static_cast<int>(tried.size()));
    CHECK(refined.resteps <= (std::abs(error) > 1e-3 ? 5 : 3));
  }
  // Exact interpolation: one step, to have the state there.
  const auto root = search(1.0, 2.0, g);
  CHECK(refine(root, Sample<double>{2, g(2)}, g).resteps == 1);
}

TEST_CASE("refine: nothing to do at the step's end; a failed step ends it; a jump ends behind it") {
  Search search;
  const auto at_end = search(0.0, 1.0, [](double t) { return t - 1; });
  CHECK(refine(at_end, Sample<double>{1, 0}, [](double) { return 7.0; }).resteps == 0);
  const auto g = [](double t) { return t - 0.3; };
  const auto root = search(0.0, 1.0, g);
  const auto failed = refine(root, Sample<double>{1, 0.7}, [](double) { return std::nan(""); });
  CHECK(failed.resteps == 1);
  CHECK(std::isnan(failed.g));
  for (const double at : {0.25, 0.35, 0.3}) {
    const auto jump = refine(root, Sample<double>{1, 0.7}, [=](double t) { return t < at ? -1.0 : 1.0; });
    CHECK(jump.g == 1);
    CHECK(jump.t >= at);
    CHECK(jump.t <= at + 1e-14);
    CHECK(jump.resteps <= 60);
    // … also where g moves on both sides of it
    const auto bent = refine(root, Sample<double>{1, 0.7}, [=](double t) { return t < at ? t - 1 : 1 + t; });
    CHECK((bent.t >= at && bent.t <= at + 1e-14));
    CHECK(bent.resteps <= 60);
  }
}
