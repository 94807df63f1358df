// The archive: every kind of value to bytes and back, and bytes that nobody vouches for.
#include <phistep/core/archive.hpp>
#include <phistep/core/checksum.hpp>

#include <array>
#include <bit>
#include <complex>
#include <cstring>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;

namespace {

using Bytes = std::vector<std::byte>;

template <class... T>
Bytes write(const T&... values) {
  Writer out;
  out(values...);
  out.finish();
  return {out.bytes().begin(), out.bytes().end()};
}
template <class... T>
void read(const Bytes& bytes, T&... values) {
  Reader in{bytes};
  in(values...);
  in.finish();
}
/// There and back, into `other`; the same bytes again.
template <class T>
T copied(const T& value, T other = {}) {
  read(write(value), other);
  CHECK(write(other) == write(value));
  return other;
}

enum class Color : std::uint8_t { red, green };
struct Empty {};
struct Plain {
  double x;
  std::int32_t k;
  std::int32_t l;
  friend bool operator==(const Plain&, const Plain&) = default;
};
struct Own {
  std::vector<Vec> parts;
  int n = 0;
  void archive(auto& ar) { ar(parts, n); }
};
struct Blocks2 {
  Vec r, v;
  static auto blocks(auto& y) { return std::tie(y.r, y.v); }
};

}  // namespace

TEST_CASE("numbers keep their bits") {
  CHECK(copied(-3) == -3);
  CHECK(copied(std::int64_t{1} << 60) == std::int64_t{1} << 60);
  CHECK(copied(true));
  CHECK(copied(Color::green) == Color::green);
  CHECK(std::signbit(copied(-0.0)));
  const double nan = std::bit_cast<double>(0x7ff8dead'beef1234u);  // its payload too
  CHECK(std::bit_cast<std::uint64_t>(copied(nan)) == 0x7ff8dead'beef1234u);
  CHECK(copied(std::numeric_limits<float>::denorm_min()) == std::numeric_limits<float>::denorm_min());
  CHECK(copied(1.0L / 3) == 1.0L / 3);
  CHECK(copied(std::complex<double>{1, 2}) == std::complex<double>{1, 2});
}

TEST_CASE("the padding of a long double is not written") {
  long double a, b;
  std::memset(static_cast<void*>(&a), 0x00, sizeof a);
  std::memset(static_cast<void*>(&b), 0xff, sizeof b);
  a = 1.0L / 3;
  b = 1.0L / 3;
  CHECK(write(a) == write(b));
  Eigen::Vector<long double, 2> u{a, b}, w{b, a};
  CHECK(write(u) == write(w));
}

TEST_CASE("containers and Eigen's types") {
  CHECK(copied(std::vector<double>{1, 2, 3}, {9}) == std::vector<double>{1, 2, 3});
  CHECK(copied(std::vector<bool>{true, false}) == std::vector<bool>{true, false});
  CHECK(copied(std::vector<std::string>{"a", "", "bc"}) == std::vector<std::string>{"a", "", "bc"});
  CHECK(copied(std::vector<Plain>{{1, 2, 3}, {4, 5, 6}}) == std::vector<Plain>{{1, 2, 3}, {4, 5, 6}});
  CHECK(copied(std::vector<long double>{1.0L / 3}) == std::vector<long double>{1.0L / 3});
  CHECK(copied(std::array<float, 3>{1, 2, 3}) == std::array<float, 3>{1, 2, 3});
  CHECK(copied(std::tuple{1, std::pair{2.0, 'x'}, std::string("y")}) ==
        std::tuple{1, std::pair{2.0, 'x'}, std::string("y")});
  CHECK(copied(std::optional<int>{4}) == 4);
  CHECK(copied(std::optional<int>{}, std::optional<int>{7}) == std::nullopt);
  CHECK(copied(Vec(Vec::LinSpaced(5, 0, 1)), Vec(2)) == Vec::LinSpaced(5, 0, 1));
  const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> rows = Eigen::MatrixXd::Random(3, 4);
  CHECK(copied(rows) == rows);
  const Eigen::Matrix2f fixed = Eigen::Matrix2f::Random();
  CHECK(copied(fixed) == fixed);
  CHECK(copied(Vec(0), Vec(3)).size() == 0);
  std::mt19937_64 random(3);
  random.discard(10);
  CHECK(copied(random) == random);
  static_cast<void>(copied(Empty{}));
  const Own own = copied(Own{{Vec::Ones(2), Vec::Zero(3)}, 5});
  CHECK(own.parts.size() == 2);
  CHECK(own.parts[1] == Vec::Zero(3));
  CHECK(own.n == 5);
  CHECK(copied(Blocks2{Vec::Ones(2), Vec::Zero(2)}).r == Vec::Ones(2));
}

TEST_CASE("views are written through, and hold the bytes of what they show") {
  std::array<double, 6> memory{1, 0, 2, 0, 3, 0};
  Eigen::Map<Vec, 0, Eigen::InnerStride<2>> strided(memory.data(), 3);
  const Bytes bytes = write(strided);
  CHECK(bytes == write(Vec(Eigen::Vector3d{1, 2, 3})));
  strided.setZero();
  memory[1] = 7;
  read(bytes, strided);
  CHECK(memory == std::array<double, 6>{1, 7, 2, 0, 3, 0});
}

TEST_CASE("bytes of another shape are refused") {
  const Bytes three = write(Vec(Vec::Ones(3)));
  Vec two = Vec::Zero(2);
  Reader in{three};
  CHECK_THROWS_WITH(in.in_place(two), contains("another size") && contains("3 x 1") && contains("2 x 1"));
  CHECK(two == Vec::Zero(2));
  Eigen::Vector2d fixed;
  CHECK_THROWS_WITH(read(three, fixed), contains("another size"));
  Eigen::Map<Vec> map(two.data(), 2);
  CHECK_THROWS_WITH(read(three, map), contains("another size"));
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 2, 1> small;
  CHECK_THROWS_AS(read(three, small), CheckpointError);
  Eigen::Matrix<double, 2, Eigen::Dynamic> half;
  CHECK_THROWS_AS(read(three, half), CheckpointError);
  Writer out;
  out.shape(two);
  Reader shape{out.bytes()};
  CHECK_THROWS_AS(shape.shape(Vec(Vec::Ones(3))), CheckpointError);
}

TEST_CASE("bytes of another layout are refused though their number fits") {
  float f = 0;
  CHECK_THROWS_WITH(read(write(std::int32_t{1}), f), contains("laid out otherwise"));
  std::uint32_t u = 0;
  CHECK_THROWS_AS(read(write(std::int32_t{1}), u), CheckpointError);
  std::array<double, 2> two{};
  CHECK_THROWS_AS(read(write(std::uint64_t{1}, 2.0), two), CheckpointError);
  double one = 0;
  CHECK_THROWS_AS(read(write(1.0, 2.0), one), CheckpointError);  // something is left
}

TEST_CASE("false sizes are noticed before anything is allocated") {
  const auto refused = [](auto value, std::initializer_list<std::int64_t> sizes) {
    Writer out;
    for (const std::int64_t size : sizes) out(size);
    out(std::array<double, 4>{});
    Reader in{out.bytes()};
    CHECK_THROWS_AS(in(value), CheckpointError);
  };
  const std::int64_t huge = std::int64_t{1} << 61;
  for (const std::int64_t n : {huge, std::int64_t{-1}, std::int64_t{1} << 40, std::int64_t{1000}}) {
    refused(std::vector<double>{}, {n});
    refused(std::vector<std::string>{}, {n});
    refused(std::vector<Eigen::Matrix3d>{}, {n});
    refused(std::string{}, {n});
    refused(Vec{}, {n, 1});
    refused(Eigen::MatrixXd{}, {n, n});
    refused(Eigen::MatrixXd{}, {8, n});
    refused(Eigen::MatrixXd{}, {n, 8});
    refused(Eigen::Matrix3Xd{}, {3, n});
  }
  bool flag = false;
  const Bytes two{std::byte{2}};
  Reader in{two};
  CHECK_THROWS_AS(in(flag), CheckpointError);
}

TEST_CASE("every truncation is an error, never a read beyond the end") {
  const std::tuple value{1, Vec(Vec::Ones(3)), std::vector<std::string>{"abc", "d"}, 2.0L, true, std::optional<int>{1}};
  const Bytes all = write(value);
  for (std::size_t n = 0; n < all.size(); ++n) {
    // Its own allocation, so that a sanitizer sees what reads beyond.
    const Bytes part(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(n));
    auto other = value;
    CHECK_THROWS_AS(read(part, other), CheckpointError);
  }
}

TEST_CASE("the checksum is CRC-64/XZ, in one piece or several") {
  const std::string_view text = "123456789";
  const auto bytes = std::as_bytes(std::span(text));
  CHECK(checksum(bytes) == 0x995dc9bbdf1939fau);  // the catalogue's check value
  CHECK(checksum(bytes.subspan(4), checksum(bytes.first(4))) == checksum(bytes));
}
