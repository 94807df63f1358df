/// @file
/// Named values to bytes and back. One member serves both directions,
///
///     void archive(auto& ar) { ar("anchor", anchor, "slip", slip); }
///
/// and must not change anything while it writes. A name may be left out: the value is then called by its place, 0, 1, ….
/// Archived without one: numbers, enums, std::array, vector, string, pair and tuple of what can be archived,
/// Eigen's dense types, structs of blocks (see base/state/blocks.hpp), random engines (through a string stream), empty types.
///
/// Beside `ar(…)` there are
///     ar.in_place(x…)        x keeps its shape, and any other shape in the bytes is an error
///     ar.fact(name, text)    what has to be the same where it is read
///     ar.check(ok)           what was read can be true
///     ar.aside(x…)           as ar(x…), of what isn't a member
///     ar.state(name, y)      a state: it keeps its shape
///     ar.open(name), ar.close()    a section around what stands between
///     ar.at_last(f)          when all has been read and checked: f(), which can't be undone
///     Ar::reading            with Ar the archive's type: the direction
///
/// An object that can't be copied, or is too large to be, is read member by member and says so: `using ArchivedByParts = void;`.
///
/// Each value says what it is, for programs that know nothing of these types. All is little-endian:
///
///     bytes    what
///     1        b  bool     i  signed     u  unsigned     f  IEEE float     w  two f8 whose sum is the number
///              t  text     {  a section begins     }  it ends
///     1        bytes of one number: 1, 2, 4, 8, for w 16; 0 of sections
///     1        how many sizes: 0 of one number or a struct, 1 of a list, 2 of a matrix
///     1        length of the name
///     …        name
///     8 each   sizes: of a matrix rows, columns; of a section how many values are in it
///     …        the numbers, a matrix's column by column
///
/// Bytes are untrusted input: every size is checked against what is left before anything is allocated.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/archive/archive_kinds.hpp"
#include "phistep/base/archive/archive_layout.hpp"
#include "phistep/base/machine/memory.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Values to bytes: `Writer out; out("x", x, "y", y);`
class Writer : public Archive<Writer> {
  static_assert(std::endian::native == std::endian::little,
                "phistep: archives are little-endian, as this machine isn't");

 public:
  static constexpr bool reading = false;

  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }
  /// The parts of a checkpoint: `out.save(stepper, y, "t", t);`
  template <class... Parts>
  void save(const Parts&... parts) {
    this->parts(parts...);
  }

  void open(std::string_view name, const std::uint64_t* count = nullptr) {
    record(name, {}, count != nullptr ? 1 : 0, {count != nullptr ? *count : 0, 1});
    enter();
  }
  void close() {
    leave();
    record({}, {'}', 0}, 0, {});
  }
  void fact(std::string_view name, std::string_view text) {
    const std::string copy(text);
    value(name, copy);
  }
  static void check(bool) {}
  static void at_last(const auto& /*f*/) {}

 private:
  friend class Archive<Writer>;
  using Size = std::array<std::uint64_t, 2>;

  void record(std::string_view name, detail::Kind kind, std::uint8_t rank, const Size& size) {
    if (name.size() > 255)
      throw CheckpointError("phistep: this name is too long for a checkpoint: " + std::string(name));
    const std::array<std::uint8_t, 4> head{static_cast<std::uint8_t>(kind.letter), kind.width, rank,
                                           static_cast<std::uint8_t>(name.size())};
    raw(head.data(), head.size());
    raw(name.data(), name.size());
    raw(size.data(), rank);
  }
  template <class T>
  void head(std::string_view name, std::uint8_t rank, const Size& size, detail::Kind kind = detail::kind_of<T>()) {
    record(name, kind, rank, size);
  }
  template <class T>
  void data(const T* x, std::size_t n) {
    if constexpr (detail::kind_of<T>().letter == 'w') {
      for (std::size_t i = 0; i < n; ++i) {
        const auto high = static_cast<double>(x[i]);
        const double low = std::isfinite(high) ? static_cast<double>(x[i] - static_cast<T>(high)) : 0.0;
        if (std::isfinite(x[i]) && static_cast<T>(high) + static_cast<T>(low) != x[i])
          throw CheckpointError("phistep: a long double beyond the range of double can't be in a checkpoint");
        raw(std::array{high, low}.data(), 2);
      }
    } else {
      raw(x, n);
    }
  }
  template <class T>
  void raw(const T* x, std::size_t n) {
    const auto* const first = reinterpret_cast<const std::byte*>(x);
    bytes_.insert(bytes_.end(), first, first + n * sizeof(T));
  }
  static void fits(std::string_view, const Size&, std::uint64_t, std::uint64_t) {}
  static void keep(const auto& /*x*/) {}
  static int pause() { return 0; }

  std::vector<std::byte> bytes_;
};

/// Bytes to values: `Reader in{bytes}; in.load(stepper, y, "t", t);`, or `in("x", x, "y", y); in.finish();`, which leaves what it has
/// read before it throws. @throws CheckpointError where they don't fit
///
/// What is loaded is read into its place, and put back if anything that follows is wrong. Old values are kept, and moved back: that
/// can't fail for want of memory, and needs no writing of what a file can't hold.
class Reader : public Archive<Reader> {
 public:
  static constexpr bool reading = true;

  explicit Reader(std::span<const std::byte> bytes) : rest_{bytes} {}

  /// Reads what save(parts…) wrote, all or nothing: if anything throws, each part is put back, bit by bit.
  template <class... Parts>
  void load(Parts&... parts) {
    load_by([](auto&& read) { read(); }, parts...);
  }
  /// The same. @param how  how(read) calls read(), and throws where nothing may be kept of it
  template <class How, class... Parts>
  void load_by(How&& how, Parts&... parts) {
    is_open_ = keeps_ = true;
    try {
      how([&] {
        this->parts(parts...);
        finish();
      });
      for (const auto& f : last_) f();
    } catch (...) {
      for (; !undo_.empty(); undo_.pop_back()) undo_.back()();
      throw;
    }
  }
  /// f() when all has been read and checked: what can't be undone.
  void at_last(std::function<void()> f) {
    if (is_open_) last_.push_back(std::move(f));
    else f();
  }

  void open(std::string_view name, std::uint64_t* count = nullptr) {
    Size size{};
    expect(name, {}, count != nullptr ? 1 : 0, size);
    if (count != nullptr) {
      if (size[0] > rest_.size() / 4) too_early(name);  // a record each, at least
      *count = size[0];
    }
    path_.emplace_back(name);
    enter();
  }
  void close() {
    const Record next = record({});
    if (next.kind.letter != '}') left_over(next.name);
    leave();
    path_.pop_back();
  }
  void fact(const char* name, std::string_view text) {
    std::string there;
    aside(name, there);
    if (there != text)
      refuse("the checkpoint's " + path(name) + " is \"" + there + "\", here it is \"" + std::string(text) + '"');
  }
  void check(bool ok) const {
    if (!ok) refuse("the checkpoint's " + path({}) + " holds values that can't be");
  }
  /// All has been read.
  void finish() {
    if (!rest_.empty()) left_over(record({}).name);
  }

 private:
  friend class Archive<Reader>;
  using Size = std::array<std::uint64_t, 2>;
  struct Record {
    detail::Kind kind;
    std::uint8_t rank;
    std::string name;
  };

  /// Notes what x was; not after pause(), within what is noted as a whole.
  template <class T>
  void keep(T& x) {
    if constexpr (!ByParts<T> && !std::is_empty_v<T>) {
      static_assert(std::is_copy_constructible_v<T> && std::is_move_assignable_v<T>,
                    "phistep: an object that can't be copied is read by its parts: `using ArchivedByParts = void;`");
      if (!keeps_) return;
      T copy = x;
      const auto old = std::make_shared<T>(std::move(x));  // it allocates before it moves
      x = std::move(copy);                                 // so what is put back has its old place in memory
      undo_.push_back([&x, old] { x = std::move(*old); });
    }
  }
  [[nodiscard]] auto pause() {
    return AtExit{[this, before = std::exchange(keeps_, false)] { keeps_ = before; }};
  }

  [[noreturn]] static void refuse(const std::string& why) { throw CheckpointError("phistep: " + why); }
  [[noreturn]] void too_early(std::string_view name) const {
    refuse("the checkpoint ends too early, at " + path(name));
  }
  [[noreturn]] void left_over(std::string_view name) const {
    refuse("the checkpoint holds " + path(name) + ", which this program has no place for");
  }
  /// Sections and name, as a path.
  [[nodiscard]] std::string path(std::string_view name) const {
    std::string all;
    for (const std::string& section : path_) all += section + '/';
    all += name;
    if (!all.empty() && all.back() == '/') all.pop_back();
    return all;
  }

  [[nodiscard]] Record record(std::string_view wanted) {
    std::array<std::uint8_t, 4> head{};
    if (rest_.empty() && path_.empty()) refuse("the checkpoint has no " + path(wanted));
    if (rest_.size() < head.size()) too_early(wanted);
    std::memcpy(head.data(), rest_.data(), head.size());
    rest_ = rest_.subspan(head.size());
    if (rest_.size() < head[3]) too_early(wanted);
    const std::string name(reinterpret_cast<const char*>(rest_.data()), head[3]);
    rest_ = rest_.subspan(head[3]);
    return {{static_cast<char>(head[0]), head[1]}, head[2], name};
  }
  void expect(std::string_view name, detail::Kind kind, std::uint8_t rank, Size& size) {
    const Record next = record(name);
    if (next.kind.letter == '}') refuse("the checkpoint has no " + path(name));
    if (next.name != name)
      refuse("the checkpoint has no " + path(name) + ": where it should be there is " + path(next.name));
    const bool same = next.kind == kind || (next.kind.is_integer() && kind.is_integer());
    if (!same || next.rank != rank) {
      const auto words = [](detail::Kind of, int sizes) {
        return of.words() + (sizes == 0 || of.letter == 't' ? "" : sizes == 1 ? ", a list" : ", a matrix");
      };
      refuse("the checkpoint's " + path(name) + " is of another kind: " + words(next.kind, next.rank) + " there, " +
             words(kind, rank) + " here");
    }
    if (rest_.size() < rank * sizeof(std::uint64_t)) too_early(name);
    raw(size.data(), rank);
    kind_ = next.kind;
  }
  template <class T>
  void head(std::string_view name, std::uint8_t rank, Size& size, detail::Kind kind = detail::kind_of<T>()) {
    size = {1, 1};
    expect(name, kind, rank, size);
    const bool has_width =
        kind_ == kind || kind_.width == 1 || kind_.width == 2 || kind_.width == 4 || kind_.width == 8;
    if (!has_width) refuse("the checkpoint's " + path(name) + " is of another kind: " + kind_.words());
    constexpr std::uint64_t limit = std::numeric_limits<std::int32_t>::max();
    const std::uint64_t most = rest_.size() / kind_.width;
    const bool is_empty = size[0] == 0 || size[1] == 0;
    if (is_empty ? std::max(size[0], size[1]) > limit : size[0] > most || size[1] > most / size[0]) too_early(name);
  }
  /// Reads n numbers of the current record; head() has checked that the record has them.
  template <class T>
  void data(T* x, std::size_t n) {
    constexpr detail::Kind kind = detail::kind_of<T>();
    if constexpr (kind.letter == 'w') {
      for (std::size_t i = 0; i < n; ++i) {
        std::array<double, 2> parts{};
        raw(parts.data(), 2);
        x[i] = parts[1] == 0 ? static_cast<T>(parts[0]) : static_cast<T>(parts[0]) + static_cast<T>(parts[1]);
      }
    } else if constexpr (kind.letter == 'b') {
      for (std::size_t i = 0; i < n; ++i) {
        std::uint8_t byte = 0;
        raw(&byte, 1);
        check(byte <= 1);
        x[i] = byte == 1;
      }
    } else if (kind_ == kind || kind_.letter == 't') {
      raw(x, n);
    } else if constexpr (kind.letter == 'i' || kind.letter == 'u') {
      for (std::size_t i = 0; i < n; ++i) x[i] = integer<T>();
    }
  }
  /// An integer of another size than the writer's.
  template <class T>
  [[nodiscard]] T integer() {
    std::array<std::uint8_t, 8> bytes{};
    std::memcpy(bytes.data(), rest_.data(), kind_.width);
    rest_ = rest_.subspan(kind_.width);
    const bool negative = kind_.letter == 'i' && bytes[kind_.width - 1u] >= 128;
    std::uint64_t bits = negative ? ~std::uint64_t{0} : 0;
    for (unsigned k = kind_.width; k-- > 0;) bits = bits << 8 | bytes[k];
    const T value = static_cast<T>(bits);
    // Read back, it is the same number.
    using Wide = std::conditional_t<detail::kind_of<T>().letter == 'i', std::int64_t, std::uint64_t>;
    const auto wide = static_cast<Wide>(value);
    check(static_cast<std::uint64_t>(wide) == bits && (std::is_signed_v<Wide> ? (wide < 0) == negative : !negative));
    return value;
  }
  template <class T>
  void raw(T* x, std::size_t n) {
    if (n == 0) return;
    std::memcpy(static_cast<void*>(x), rest_.data(), n * sizeof(T));
    rest_ = rest_.subspan(n * sizeof(T));
  }
  void fits(std::string_view name, const Size& size, std::uint64_t rows, std::uint64_t columns) const {
    if (size[0] == rows && size[1] == columns) return;
    const auto words = [](std::uint64_t r, std::uint64_t c) { return std::to_string(r) + " x " + std::to_string(c); };
    refuse("the checkpoint's " + path(name) + " is of another size: " + words(size[0], size[1]) + " there, " +
           words(rows, columns) + " here");
  }

  std::span<const std::byte> rest_;
  std::vector<std::string> path_;
  detail::Kind kind_;
  std::vector<std::function<void()>> undo_, last_;
  bool is_open_ = false, keeps_ = false;
};

}}  // namespace phistep::PHISTEP_ABI
