/// @file
/// A file in VTK's XML formats: elements as text, then the numbers of all arrays as raw bytes.
///
///     VtkFile file{"PolyData"};
///     file.open("Piece", "NumberOfPoints=\"2\"");
///     file.array<double>("radius", 2, 1, [&](Index i, Index) { return radius[i]; });
///     file.close("Piece");
///     file.write("grains.vtp");
///
/// io/vtk.hpp writes states; this is for those who need another data set. Format: "VTK XML file formats", docs.vtk.org,
/// version 1.0 with header_type UInt64 and AppendedData of encoding "raw". The byte order is the machine's, and named.
#pragma once

#include <array>
#include <bit>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>

#include "phistep/core/version.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

namespace detail {

/// A path as UTF-8, with '/' between folders.
[[nodiscard]] inline std::string utf8(const std::filesystem::path& path) {
  const auto text = path.generic_u8string();
  return {text.begin(), text.end()};
}
/// @throws std::runtime_error that names the file and the system's reason, where it gave one
[[noreturn]] inline void fail_file(const char* what, const std::filesystem::path& path, std::error_code error) {
  throw std::runtime_error(std::string("phistep: ") + what + ' ' + utf8(path) +
                           (error ? ": " + error.message() : std::string{}));
}
[[nodiscard]] inline std::error_code last_error() { return {errno, std::generic_category()}; }

/// Writes the pieces to a file beside it first, then renames: a crash or a full disk leaves the old file.
/// @throws std::runtime_error naming the file and the reason
inline void replace_file(const std::filesystem::path& path, std::string_view text, std::string_view bytes = {},
                         std::string_view end = {}) {
  std::filesystem::path beside = path;
  beside += ".part";
  errno = 0;
  std::ofstream out(beside, std::ios::binary);
  if (!out) fail_file("cannot write", path, last_error());
  for (const std::string_view piece : {text, bytes, end})
    out.write(piece.data(), static_cast<std::streamsize>(piece.size()));
  out.close();
  std::error_code error = out ? std::error_code{} : last_error();
  const bool failed = !out;
  if (!failed) std::filesystem::rename(beside, path, error);
  if (!failed && !error) return;
  std::error_code ignored;
  std::filesystem::remove(beside, ignored);
  fail_file("writing failed:", path, error);
}

/// Text inside the quotes of an attribute.
[[nodiscard]] inline std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '&') result += "&amp;";
    else if (c == '<') result += "&lt;";
    else if (c == '>') result += "&gt;";
    else if (c == '"') result += "&quot;";
    else result += c;
  }
  return result;
}

/// VTK's name of a number type.
template <class Number>
[[nodiscard]] constexpr const char* vtk_type() {
  static_assert(std::is_arithmetic_v<Number> && sizeof(Number) <= 8);
  if constexpr (std::is_floating_point_v<Number>) return sizeof(Number) == 8 ? "Float64" : "Float32";
  else if constexpr (std::is_signed_v<Number>)
    return sizeof(Number) == 8 ? "Int64" : sizeof(Number) == 4 ? "Int32" : sizeof(Number) == 2 ? "Int16" : "Int8";
  else
    return sizeof(Number) == 8 ? "UInt64" : sizeof(Number) == 4 ? "UInt32" : sizeof(Number) == 2 ? "UInt16" : "UInt8";
}

}  // namespace detail

/// The text and the bytes of one file.
class VtkFile {
 public:
  /// @param type    "PolyData", "ImageData", "UnstructuredGrid"
  /// @param single  whether real() writes Float32 rather than Float64
  explicit VtkFile(std::string type, std::string_view attributes = {}, bool single = false)
      : type_{std::move(type)}, single_{single} {
    text_ =
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<VTKFile type=\"" + type_ + "\" version=\"1.0\" byte_order=\"" +
        (std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian") + "\" header_type=\"UInt64\">\n";
    open(type_, attributes);
  }

  /// An element that holds others. @param attributes  name="value", with blanks between
  void open(std::string_view tag, std::string_view attributes = {}) {
    indent();
    text_ += '<';
    text_ += tag;
    if (!attributes.empty()) text_ += ' ', text_ += attributes;
    text_ += ">\n";
    ++depth_;
  }
  void close(std::string_view tag) {
    --depth_;
    indent();
    text_ += "</";
    text_ += tag;
    text_ += ">\n";
  }

  /// An array of `items` entries with `components` numbers each: value(i, c).
  /// @param more  further attributes
  template <class Number, class Value>
  void array(std::string_view name, Index items, Index components, Value&& value, std::string_view more = {}) {
    indent();
    text_ += "<DataArray type=\"" + std::string(detail::vtk_type<Number>()) + "\" Name=\"" + detail::escaped(name) +
             "\" NumberOfComponents=\"" + std::to_string(components) + "\" " + std::string(more) +
             "format=\"appended\" offset=\"" + std::to_string(bytes_.size()) + "\"/>\n";
    put(static_cast<std::uint64_t>(items * components) * sizeof(Number));
    bytes_.reserve(bytes_.size() + static_cast<std::size_t>(items * components) * sizeof(Number));
    for (Index i = 0; i < items; ++i)
      for (Index c = 0; c < components; ++c) put(static_cast<Number>(value(i, c)));
  }
  /// … of real numbers, in the file's precision; of integers as they are.
  template <class Value>
  void numbers(std::string_view name, Index items, Index components, Value&& value) {
    using Number = std::remove_cvref_t<std::invoke_result_t<Value&, Index, Index>>;
    if constexpr (!std::is_floating_point_v<Number>) array<Number>(name, items, components, value);
    else if (single_) array<float>(name, items, components, value);
    else array<double>(name, items, components, value);
  }
  /// … of vectors of at most three components, those that are missing being 0.
  /// @throws std::invalid_argument where there are more
  template <class Vectors>
  void vectors(std::string_view name, const Vectors& x) {
    using Number = typename Vectors::Scalar;
    if (x.rows() > 3)
      throw std::invalid_argument("phistep: " + std::string(name) + " of a VTK file has " + std::to_string(x.rows()) +
                                  " components, and there are 3 dimensions at most");
    numbers(name, x.cols(), 3, [&x](Index i, Index c) { return c < x.rows() ? x(c, i) : Number{0}; });
  }
  /// The time, where ParaView looks for it. [time]
  void time(double t) {
    open("FieldData");
    array<double>(
        "TimeValue", 1, 1, [t](Index, Index) { return t; }, "NumberOfTuples=\"1\" ");
    close("FieldData");
  }

  /// @throws std::runtime_error naming the file and the reason; an older file of that name is then still there
  void write(const std::filesystem::path& path) const {
    detail::replace_file(path, text_ + "  </" + type_ + ">\n  <AppendedData encoding=\"raw\">\n_", bytes_,
                         "\n  </AppendedData>\n</VTKFile>\n");
  }

 private:
  void indent() { text_.append(static_cast<std::size_t>(2 * depth_), ' '); }
  template <class Number>
  void put(Number x) {
    const auto bytes = std::bit_cast<std::array<char, sizeof(Number)>>(x);
    bytes_.append(bytes.data(), bytes.size());
  }

  std::string type_, text_, bytes_;
  int depth_ = 1;
  bool single_;
};

}}  // namespace phistep::PHISTEP_ABI
