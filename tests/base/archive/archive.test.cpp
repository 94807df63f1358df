// The archive: every kind of value to bytes and back, and bytes that nobody vouches for.
#include <phistep/base/archive/archive.hpp>
#include <phistep/io/checkpoint.hpp>

#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <new>
#include <random>
#include <sstream>
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
  void archive(auto& ar) { ar("x", x, "k", k, "l", l); }
  friend bool operator==(const Plain&, const Plain&) = default;
};
struct Own {
  std::vector<Vec> parts;
  int n = 0;
  void archive(auto& ar) { ar(parts, n); }
};
struct Less {
  std::vector<Vec> parts;
  void archive(auto& ar) { ar(parts); }
};
struct More : Own {
  int more = 0;
  void archive(auto& ar) { ar(parts, n, "more", more); }
};
struct Napper {
  std::int32_t naps = 0;
  std::array<double, 2> slip{};
  bool flagged = false;
};
struct All {
  std::vector<Napper> list;
  void archive(auto& ar) {
    ar.columns("list", list, "naps", &Napper::naps, "slip", &Napper::slip, "flagged", &Napper::flagged);
  }
};
/// Can't be copied, and is read member by member.
struct Large {
  using ArchivedByParts = void;
  Large() = default;
  Large(const Large&) = delete;
  std::vector<double> list{1, 2};
  Napper one;
  std::vector<Napper> nappers{1};
  int done = 0;
  bool can_be = true;
  void archive(auto& ar) {
    int version = 7;
    ar.aside("version", version);
    ar("list", list, "naps", one.naps);
    ar.columns("nappers", nappers, "naps", &Napper::naps);
    ar.at_last([this] { ++done; });
    ar.check(can_be && version == 7);
  }
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
}

/// What reading into these says.
template <class... T>
std::string refusal(const Bytes& bytes, T... named) {
  try {
    Reader in{bytes};
    in(named...);
    in.finish();
  } catch (const CheckpointError& error) {
    return error.what();
  }
  return "accepted";
}

TEST_CASE("values of another name, kind or shape are refused by name") {
  const Bytes bytes = write("t", 1.5, "n", 3, "own", Own{{Vec::Ones(2)}, 5});
  CHECK_THAT(refusal(bytes, "time", 0.0), contains("has no time: where it should be there is t"));
  CHECK_THAT(refusal(bytes, "t", 0.0f), contains("t is of another kind: f8 there, f4 here"));
  CHECK_THAT(refusal(bytes, "t", 0), contains("t is of another kind: f8 there, i4 here"));
  CHECK_THAT(refusal(bytes, "t", true), contains("f8 there, b1 here"));
  CHECK_THAT(refusal(bytes, "t", std::vector<double>{}), contains("f8 there, f8, a list here"));
  CHECK_THAT(refusal(bytes, "t", Vec{}), contains("f8, a matrix here"));
  CHECK_THAT(refusal(bytes, "t", Own{}), contains("f8 there, a section here"));
  CHECK_THAT(refusal(bytes, "t", std::string{}), contains("f8 there, text here"));
  CHECK_THAT(refusal(bytes, "t", 0.0, "n", 0, "own", Empty{}),
             contains("holds own, which this program has no place for"));
  CHECK_THAT(refusal(bytes, "t", 0.0, "n", 0, "own", Less{}), contains("holds own/1, which"));
  CHECK_THAT(refusal(bytes, "t", 0.0, "n", 0, "own", More{}), contains("has no own/more"));
  CHECK(refusal(bytes, "t", 0.0, "n", 0, "own", Own{}) == "accepted");
}

TEST_CASE("integers are read into other sizes that hold them") {
  const auto reads = [](auto from, auto to) {
    read(write(from), to);
    return to;
  };
  CHECK(reads(std::int32_t{-7}, std::int64_t{0}) == -7);
  CHECK(reads(std::int64_t{-7}, std::int16_t{0}) == -7);
  CHECK(reads(std::uint8_t{200}, std::int32_t{0}) == 200);
  CHECK(reads(std::int64_t{200}, std::uint8_t{0}) == 200);
  CHECK(reads(std::vector<std::int32_t>{1, -2}, std::vector<std::int64_t>{}) == std::vector<std::int64_t>{1, -2});
  CHECK_THROWS_WITH(reads(std::int64_t{200}, std::int8_t{0}), contains("values that can't be"));
  CHECK_THROWS_AS(reads(std::int32_t{-1}, std::uint64_t{0}), CheckpointError);
  CHECK_THROWS_AS(reads(~std::uint64_t{0}, std::int64_t{0}), CheckpointError);
  CHECK_THROWS_AS(reads(std::int64_t{1} << 32, std::int32_t{0}), CheckpointError);
}

TEST_CASE("facts have to be the same") {
  Writer out;
  out.open("stepper");
  out.fact("scheme", "tr_bdf2");
  out.close();
  Reader same{out.bytes()};
  same.open("stepper");
  CHECK_NOTHROW(same.fact("scheme", "tr_bdf2"));
  Reader other{out.bytes()};
  other.open("stepper");
  CHECK_THROWS_WITH(other.fact("scheme", "trapezoidal"),
                    contains("stepper/scheme is \"tr_bdf2\", here it is \"trapezoidal\""));
}

TEST_CASE("parts are read all or none: what was read is put back, and what can't be undone waits for the end") {
  Large from, to;
  from.list = {3, 4, 5}, from.one.naps = 6, from.nappers.resize(4), from.nappers[3].naps = 8;
  Writer out;
  out.save("a", from, "b", Vec(Vec::Ones(2)), "c", 9);
  Vec b = Vec::Zero(2), longer = Vec::Zero(3);
  int c = 0;
  const double* const place = to.list.data();
  const auto refused = [&](Large& large, Vec& y, const char* last) {
    Reader in{out.bytes()};
    CHECK_THROWS_AS(in.load("a", large, "b", y, last, c), CheckpointError);
    CHECK(to.list == std::vector<double>{1, 2});
    CHECK(to.list.data() == place);
    CHECK((to.one.naps == 0 && to.nappers.size() == 1 && to.nappers[0].naps == 0 && to.done == 0 && c == 0));
    CHECK((b == Vec::Zero(2) && longer == Vec::Zero(3)));
  };
  refused(to, longer, "c");
  refused(to, b, "d");
  to.can_be = false;
  refused(to, b, "c");
  to.can_be = true;
  Reader some{out.bytes()}, disagreed{out.bytes()}, in{out.bytes()};
  CHECK_THROWS_WITH(some.load("a", to, "b", b), contains("holds c, which"));
  const auto no = [](auto&& read) { read(), throw std::bad_alloc(); };
  CHECK_THROWS_AS(disagreed.load_by(no, "a", to, "b", b, "c", c), std::bad_alloc);
  CHECK((to.list.data() == place && to.one.naps == 0 && to.nappers.size() == 1 && to.done == 0 && b == Vec::Zero(2)));
  in.load("a", to, "b", b, "c", c);
  CHECK((to.list == from.list && to.one.naps == 6 && to.nappers.size() == 4 && to.nappers[3].naps == 8));
  CHECK((b == Vec::Ones(2) && c == 9 && to.done == 1 && from.done == 0));
}

TEST_CASE("columns of structs, rows before columns, little-endian") {
  const All all = copied(All{{{1, {2, 3}, true}, {4, {5, 6}, false}}}, All{{{7, {}, true}}});
  REQUIRE(all.list.size() == 2);
  CHECK((all.list[0].naps == 1 && all.list[1].naps == 4));
  CHECK((all.list[1].slip == std::array<double, 2>{5, 6} && all.list[0].flagged && !all.list[1].flagged));
  CHECK(copied(All{}).list.empty());

  // A matrix of rows is written by columns, each number from its least byte on.
  const Eigen::Matrix<std::int16_t, 2, 2, Eigen::RowMajor> rows{{1, 2}, {3, 0x405}};
  const std::vector<int> expected{'i', 2, 2, 1, 'm', 2, 0, 0, 0, 0, 0, 0, 0, 2, 0,
                                  0,   0, 0, 0, 0,   0, 1, 0, 3, 0, 2, 0, 5, 4};
  std::vector<int> bytes;
  for (const std::byte byte : write("m", rows)) bytes.push_back(std::to_integer<int>(byte));
  CHECK(bytes == expected);
}

TEST_CASE("a long double is the sum of two doubles, or can't be written") {
  const auto exact = [](long double x) { return copied(x) == x && std::signbit(copied(x)) == std::signbit(x); };
  CHECK((exact(1.0L / 3) && exact(-0.0L) && exact(-1e300L / 7)));
  CHECK(std::isnan(copied(std::numeric_limits<long double>::quiet_NaN())));
  CHECK(exact(-std::numeric_limits<long double>::infinity()));
  if constexpr (std::numeric_limits<long double>::max_exponent > std::numeric_limits<double>::max_exponent) {
    CHECK_THROWS_WITH(write(std::numeric_limits<long double>::max()), contains("beyond the range of double"));
    CHECK_THROWS_AS(write(std::numeric_limits<long double>::min()), CheckpointError);
  }
}

TEST_CASE("false sizes are noticed before anything is allocated") {
  const auto refused = [](auto value, std::initializer_list<std::int64_t> sizes) {
    // A record of the value with these sizes, and little behind it.
    Bytes bytes = write("x", value);
    const std::size_t at = 5;  // kind, width, rank, length of the name, name
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      const std::int64_t size = sizes.begin()[k];
      std::memcpy(bytes.data() + at + 8 * k, &size, sizeof size);
    }
    bytes.resize(at + 8 * sizes.size() + 32);
    Reader in{bytes};
    CHECK_THROWS_AS(in("x", value), CheckpointError);
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
  Bytes two = write(true);
  two.back() = std::byte{2};
  Reader in{two};
  CHECK_THROWS_AS(in(flag), CheckpointError);
}

TEST_CASE("every truncation is an error, never a read beyond the end") {
  const std::tuple value{1, Vec(Vec::Ones(3)), std::vector<std::string>{"abc", "d"}, 2.0L, true};
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
