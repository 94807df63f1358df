#include <phistep/base/numbers/pack.hpp>
#include <phistep/base/numbers/pack_math.hpp>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

// The machine's own width, narrower registers, and what no machine has a register for: an array.
#define WIDTHS                                                                                                   \
  (Pack<double, native_width<double>>), (Pack<float, native_width<float>>), (Pack<double, 2>), (Pack<float, 8>), \
      (Pack<double, 16>)

namespace {

template <class P>
P counting(double from = 0) {
  return P::make([&](int l) { return static_cast<typename P::Scalar>(l + from); });
}
/// The greatest relative error of f over random arguments in [low, high], in units of epsilon.
template <class P>
double error(auto f, auto exact, double low, double high, bool logarithmic = true) {
  using Scalar = typename P::Scalar;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> u(logarithmic ? std::log(low) : low, logarithmic ? std::log(high) : high);
  long double worst = 0;
  for (int k = 0; k < 4000; ++k) {
    const P x = P::make([&](int) { return static_cast<Scalar>(logarithmic ? std::exp(u(random)) : u(random)); });
    const P y = f(x);
    for (int l = 0; l < P::width; ++l) {
      const long double e = exact(static_cast<long double>(x[l]));
      worst = std::max(worst, std::abs((static_cast<long double>(y[l]) - e) / e));
    }
  }
  return static_cast<double>(worst / static_cast<long double>(std::numeric_limits<Scalar>::epsilon()));
}

/// A law as a user writes it: numbers of any type, numbers or packs alike.
const auto law = [](auto r2) {
  const auto s = reciprocal(r2);
  return select(r2 < 6.25, 48 * pow<3>(s) * (pow<3>(s) - 0.5) * s, 0.0 * r2);
};

}  // namespace

TEMPLATE_TEST_CASE("lanes: arithmetic, comparisons, select, loads", "", WIDTHS) {
  using P = TestType;
  using Scalar = typename P::Scalar;
  const P a = counting<P>(1), b{3};
  alignas(64) Scalar memory[18] = {};
  (a * b - a / 2 + 1).store(memory + 1);
  for (int l = 0; l < P::width; ++l) {
    const auto x = static_cast<Scalar>(l + 1);
    CHECK(memory[l + 1] == x * 3 - x / 2 + 1);
    CHECK(P::load(memory + 1)[l] == memory[l + 1]);
    CHECK((a < b)[l] == (x < 3));
    CHECK((a <= b)[l] == (x <= 3));
    CHECK((a > b)[l] == (x > 3));
    CHECK((a >= b)[l] == (x >= 3));
    CHECK((a == b)[l] == (x == 3));
    CHECK((a != b)[l] == (x != 3));
    CHECK(((a > 1) && !(a == b))[l] == (x > 1 && x != 3));
    CHECK(((a < 2) || (a == b))[l] == (x < 2 || x == 3));
    CHECK(select(a < b, a, -a)[l] == (x < 3 ? x : -x));
    CHECK(min(a, b)[l] == std::min(x, Scalar{3}));
    CHECK(max(a, b)[l] == std::max(x, Scalar{3}));
    CHECK(abs(a - b)[l] == std::abs(x - 3));
    CHECK(sqrt(a)[l] == std::sqrt(x));
    CHECK(nearest_integer(a / 4)[l] == std::nearbyint(x / 4));
    CHECK(fma(a, b, a)[l] == 4 * x);
  }
  CHECK(!std::signbit(abs(P{-0.0})[0]));
  // As for numbers, b < a ? b : a: the first where neither is less.
  constexpr auto not_a_number = std::numeric_limits<Scalar>::quiet_NaN();
  CHECK(std::isnan(min(P{not_a_number}, P{1})[0]));
  CHECK(min(P{1}, P{not_a_number})[P::width - 1] == 1);
  CHECK(std::signbit(min(P{-0.0}, P{0.0})[0]));
  CHECK(!std::signbit(min(P{0.0}, P{-0.0})[0]));
  a.store_aligned(memory);
  CHECK(all(P::load_aligned(memory) == a));
  for (int n = 0; n <= P::width + 1; ++n) CHECK(first_lanes<P>(n).bits() == (1u << std::min(n, P::width)) - 1);
  CHECK((any(a == P::width) && !any(a == 0) && all(a > 0) && !all(a == 1) == (P::width > 1)));
  const P nan{std::numeric_limits<Scalar>::quiet_NaN()};
  CHECK((!any(nan == nan) && all(nan != nan) && !any(nan < a) && !any(nan >= a)));
}

TEMPLATE_TEST_CASE("a sum is a tree of halves", "", WIDTHS) {
  using P = TestType;
  using Scalar = typename P::Scalar;
  std::mt19937 random(3);
  std::uniform_real_distribution<Scalar> u(-1, 1);
  const P a = P::make([&](int) { return u(random); });
  std::vector<Scalar> tree(static_cast<std::size_t>(P::width));
  a.store(tree.data());
  for (std::size_t half = tree.size() / 2; half > 0; half /= 2)
    for (std::size_t l = 0; l < half; ++l) tree[l] += tree[l + half];
  CHECK(sum(a) == tree[0]);
}

TEMPLATE_TEST_CASE("bits lane by lane, and of two the larger: the second where one is no number", "", WIDTHS) {
  using P = TestType;
  using Scalar = typename P::Scalar;
  const Scalar nan = std::numeric_limits<Scalar>::quiet_NaN();
  const P a = P::make([](int l) { return static_cast<Scalar>(l % 2 == 0 ? l + 1 : -l - 1); });
  const P sign = bit_and(a, P{Scalar{-0.0}}), size = larger(a, -a);
  for (int l = 0; l < P::width; ++l) {
    CAPTURE(l);
    CHECK(std::signbit(sign[l]) == (l % 2 == 1));
    CHECK(size[l] == static_cast<Scalar>(l + 1));
    CHECK(bit_or(size, sign)[l] == a[l]);
    CHECK(larger(P{nan}, a)[l] == a[l]);
    CHECK(std::isnan(larger(a, P{nan})[l]));
  }
  CHECK(fold(size, [](auto x, auto y) { return larger(x, y); }) == static_cast<Scalar>(P::width));
}

TEMPLATE_TEST_CASE("gather4 transposes structs from anywhere", "", WIDTHS) {
  using P = TestType;
  using Scalar = typename P::Scalar;
  std::vector<Scalar> structs(4 * 40);
  for (std::size_t i = 0; i < structs.size(); ++i) structs[i] = static_cast<Scalar>(i);
  const std::int32_t slot[16] = {39, 3, 3, 0, 17, 8, 21, 5, 30, 11, 2, 38, 1, 25, 13, 7};
  const auto [x, y, z, w] = gather4<P>(structs.data(), slot);
  const P direct = P::gather(structs.data(), slot);
  for (int l = 0; l < P::width; ++l) {
    const auto first = static_cast<Scalar>(4 * slot[l]);
    CHECK((x[l] == first && y[l] == first + 1 && z[l] == first + 2 && w[l] == first + 3));
    CHECK(direct[l] == static_cast<Scalar>(slot[l]));
  }
}

TEMPLATE_TEST_CASE("functions: errors as the header states them", "", WIDTHS) {
  using P = TestType;
  using Scalar = typename P::Scalar;
  // An ulp is between ½ and 1 epsilon of its number.
  CHECK(error<P>([](P x) { return reciprocal(x); }, [](auto x) { return 1 / x; }, 1e-30, 1e30) <= 1);
  CHECK(error<P>([](P x) { return rsqrt(x); }, [](auto x) { return 1 / std::sqrt(x); }, 1e-30, 1e30) <= 1);
  CHECK(error<P>([](P x) { return rsqrt3(x); }, [](auto x) { return 1 / (x * std::sqrt(x)); }, 1e-20, 1e20) <= 3);
  CHECK(error<P>([](P x) { return exp(x); }, [](auto x) { return std::exp(x); }, -85, 88, false) <= 2);
  // Two roundings by squaring, the root's and the product's.
  CHECK(error<P>([](P x) { return pow(x, Scalar{-1.5}); }, [](auto x) { return std::pow(x, -1.5L); }, 1e-10, 1e10) <=
        3);
  CHECK(error<P>([](P x) { return pow(x, Scalar{0.75}); }, [](auto x) { return std::pow(x, 0.75L); }, 1e-10, 1e10) <=
        1);
  CHECK(error<P>([](P x) { return pow<-3>(x); }, [](auto x) { return std::pow(x, -3.0L); }, 1e-10, 1e10) <= 3);
  CHECK(error<P>([](P x) { return power(x, 7); }, [](auto x) { return std::pow(x, 7.0L); }, 1e-5, 1e5) <= 4);

  const Scalar inf = std::numeric_limits<Scalar>::infinity();
  CHECK((reciprocal(P{0})[0] == inf && reciprocal(P{inf})[0] == 0 && reciprocal(P{-0.0})[0] == -inf));
  CHECK((rsqrt(P{0})[0] == inf && rsqrt(P{inf})[0] == 0 && std::isnan(rsqrt(P{-1})[0])));
  CHECK((exp(P{-inf})[0] == 0 && exp(P{inf})[0] == inf && exp(P{0})[0] == 1));
  CHECK((std::isnan(exp(P{NAN})[0]) && std::isnan(rsqrt(P{NAN})[0]) && std::isnan(reciprocal(P{NAN})[0])));
  const Scalar greatest = std::nextafter(std::log(std::numeric_limits<Scalar>::max()), Scalar{0});
  CHECK((exp(P{greatest})[0] < inf && exp(P{greatest})[0] > std::numeric_limits<Scalar>::max() / 2));
}

TEMPLATE_TEST_CASE("one generic law for packs and for numbers", "", WIDTHS) {
  using P = TestType;
  using Scalar = typename P::Scalar;
  const P r2 = counting<P>(1);
  for (int l = 0; l < P::width; ++l) {
    const auto number = static_cast<Scalar>(law(r2[l]));
    CHECK(law(r2)[l] == Approx(number).epsilon(20 * std::numeric_limits<Scalar>::epsilon()));
    CHECK((number == 0) == (r2[l] > 6.25));
  }
}

TEMPLATE_TEST_CASE("scaling by powers of four changes no bit of a root or a quotient", "", WIDTHS) {
  using P = TestType;
  const P a = 1 + counting<P>(1) / 7;
  for (const int k : {-20, -3, 5, 24}) {
    const double s = std::ldexp(1.0, 2 * k);
    const auto scaled = [](double f) { return P{f}; };
    CHECK(all(reciprocal(a * scaled(s)) * scaled(s) == reciprocal(a)));
    CHECK(all(rsqrt(a * scaled(s)) * scaled(std::ldexp(1.0, k)) == rsqrt(a)));
  }
}
