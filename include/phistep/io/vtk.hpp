/// @file
/// Files that ParaView and PyVista open: particles, nets and meshes, fields on regular grids, and series of them.
///
///     integrate(…, sampled(0.1, vtk_series("out/melt")));                               // particles, motions
///     integrate(…, sampled(0.1, vtk_series("out/plate", VtkGrid{.size = {80, 50}, .spacing = {dx, dx}})));
///     write_vtk("end.vtk", cloth, VtkMesh{.triangles = triangles}, column("strain", strain));
///
/// A series writes out/melt/00000.vtk, 00001.vtk, … and lists them with their times in out/melt.vtk.series: open the list. It
/// is complete after each frame, so the files of a run that was cut off open as well. The folder out must exist.
/// Format: "VTK legacy file formats", docs.vtk.org, version 3.0, binary. Integers have 64 bits.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <limits>
#include <locale>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/state/blocks.hpp"
#include "phistep/io/csv.hpp"
#include "phistep/io/text.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Particles and motions: positions (dim × N with dim ≤ 3, or a flat vector x₀ y₀ [z₀] x₁ …), velocities, the properties of
/// Particles, and cells between the points: nets, cloth, finite elements.
struct VtkMesh {
  std::vector<std::array<Index, 2>> lines{};       ///< indices of points; without any cells each point is one
  std::vector<std::array<Index, 3>> triangles{};   ///< indices of points
  std::vector<std::array<Index, 4>> quads{};       ///< in order around the cell
  std::vector<std::array<Index, 4>> tetrahedra{};  ///< likewise
  Index dimensions = 0;                            ///< of a particle in a flat vector; 0: the vector is one particle
  bool wrapped = false;                            ///< Particles: positions moved into the periodic box
  bool single = false;                             ///< real numbers with 32 bits: half the size, 7 digits
  bool resume = false;                             ///< a series: goes on with the one that is there
};

/// Fields on a regular grid in 1, 2 or 3 dimensions, x fastest. A block of k n numbers has k values at each of n points: as a
/// k × n matrix a column for each, else all first values, then all second ones (u₀ u₁ … v₀ v₁ …).
struct VtkGrid {
  std::array<Index, 3> size{};       ///< how many values along x, y, z: {80, 50} in the plane; 0 counts as 1
  std::array<double, 3> spacing{};   ///< [length] between them; 0 counts as 1
  std::array<double, 3> origin{};    ///< [length] where the first value lies; on cells: the first one's lower corner
  bool on_cells = false;             ///< values of cells (finite volumes), else of points
  std::vector<std::string> names{};  ///< of the state's blocks: y, or r and v of a motion, unless given
  bool single = false;               ///< as in VtkMesh
  bool resume = false;               ///< likewise
};

namespace detail {

/// Writes beside the file first, then renames: a crash or a full disk leaves the older one.
inline void replace_file(const std::filesystem::path& path, const std::string& text) {
  const auto beside = std::filesystem::path(path) += ".part";
  errno = 0;
  std::ofstream out(beside, std::ios::binary);
  out << text, out.close();
  std::error_code error{out ? 0 : errno == 0 ? EIO : errno, std::generic_category()};
  if (!error) std::filesystem::rename(beside, path, error);
  if (error) throw std::runtime_error("phistep: cannot write " + path.string() + ": " + error.message());
}
[[noreturn]] inline void refuse_vtk(Index n, const std::string& what) {
  throw std::invalid_argument("phistep: a VTK file of " + std::to_string(n) + " points or cells has " + what);
}
[[nodiscard]] inline std::ostringstream exact_text() {
  std::ostringstream text;
  text.imbue(std::locale::classic()), text.precision(std::numeric_limits<double>::max_digits10);
  return text;
}

/// The text of one file, its numbers as bytes between the lines.
struct VtkFile {
  bool single;
  std::ostringstream out = exact_text();
  /// Numbers one after the other, most significant byte first.
  template <class Number>
  void put(const auto& x) {
    for (const auto& number : x) {
      auto bytes = std::bit_cast<std::array<char, sizeof(Number)>>(static_cast<Number>(number));
      if constexpr (std::endian::native == std::endian::little) std::reverse(bytes.begin(), bytes.end());
      out.write(bytes.data(), bytes.size());
    }
    out << '\n';
  }
  template <class Values>
  void numbers(const Values& x) {
    if constexpr (std::is_integral_v<typename Values::Scalar>)
      out << " vtktypeint64\n", put<std::int64_t>(x.reshaped());
    else if (single) out << " float\n", put<float>(x.reshaped());
    else out << " double\n", put<double>(x.reshaped());
  }
  /// A value, or a column of values, for each of n points or cells.
  void array(const std::string& name, Index n, const auto& x) {
    constexpr bool is_flat = std::remove_cvref_t<decltype(x)>::IsVectorAtCompileTime;
    const Index items = is_flat ? x.size() : x.cols();
    if (items != n) refuse_vtk(n, "an array " + name + " of " + std::to_string(items));
    if (name.empty()) refuse_vtk(n, "an array without a name");
    out << "FIELD data 1\n" << std::hex;
    for (const char c : name)
      if (const auto byte = static_cast<unsigned char>(c); byte > ' ' && byte < 127 && c != '%' && c != '"') out << c;
      else out << '%' << byte / 16 << byte % 16;
    out << std::dec << ' ' << (is_flat ? 1 : x.rows()) << ' ' << n;
    numbers(x);
  }
};

/// Geometry, and the arrays that the state has by itself; returns the number of points or cells.
template <State S>
Index put_state(VtkFile& file, const VtkMesh& mesh, const S& state) {
  static_assert(Blocks<S>::drifts, "phistep: a VTK file of a state without positions needs a VtkGrid{...}");
  const auto blocks = Blocks<S>::all(state);
  auto points = in_space(std::get<0>(blocks), mesh.dimensions);
  const Index n = points.cols();
  if constexpr (requires { state.body().box; })
    for (Index j = 0; mesh.wrapped && j < n; ++j)
      points.col(j).head(S::dimensions) = state.body().box.wrapped(state.r.col(j));
  std::vector<std::int32_t> cells, types;
  const auto add = [&](const auto& list, std::int32_t type) {  // VTK's number
    for (const auto& cell : list) {
      types.push_back(type), cells.push_back(static_cast<std::int32_t>(cell.size()));
      for (const Index i : cell)
        if (i < 0 || i >= n) refuse_vtk(n, "a cell with the point " + std::to_string(i) + ", counted from 0");
        else cells.push_back(static_cast<std::int32_t>(i));
    }
  };
  add(mesh.lines, 3), add(mesh.triangles, 5), add(mesh.quads, 9), add(mesh.tetrahedra, 10);
  if (types.empty())
    for (Index i = 0; i < n; ++i) add(std::array<std::array<Index, 1>, 1>{{{i}}}, 1);
  file.out << "UNSTRUCTURED_GRID\nPOINTS " << n, file.numbers(points);
  file.out << "CELLS " << types.size() << ' ' << cells.size() << '\n', file.put<std::int32_t>(cells);
  file.out << "CELL_TYPES " << types.size() << '\n', file.put<std::int32_t>(types);
  file.out << "POINT_DATA " << n << '\n', file.array("velocity", n, in_space(std::get<1>(blocks), mesh.dimensions));
  if constexpr (requires { state.body(); }) {
    const auto list = [&]<class Values>(const char* name, const Values& x) {
      using Column = Eigen::Matrix<typename Values::value_type, Eigen::Dynamic, 1>;
      if (static_cast<Index>(x.size()) == n) file.array(name, n, Eigen::Map<const Column>(x.data(), n));
    };
    const auto& body = state.body();
    list("id", body.id), list("mass", body.mass), list("radius", body.radius), list("type", body.type);
    list("charge", body.charge), list("heat_capacity", body.heat_capacity), list("still", body.still);
    if constexpr (requires { state.omega; }) file.array("omega", n, state.omega);
    if constexpr (requires { state.temperature; }) file.array("temperature", n, state.temperature);
  }
  return n;
}
template <State S>
Index put_state(VtkFile& file, const VtkGrid& grid, const S& state) {
  auto size = exact_text(), origin = exact_text(), spacing = exact_text();
  Index n = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    const Index count = std::max<Index>(grid.size[a], 1);
    n *= count, size << ' ' << (grid.on_cells && grid.size[a] > 0 ? count + 1 : count);
    origin << ' ' << grid.origin[a], spacing << ' ' << (grid.spacing[a] == 0 ? 1 : grid.spacing[a]);
  }
  file.out << "STRUCTURED_POINTS\nDIMENSIONS" << size.str() << "\nORIGIN" << origin.str() << "\nSPACING"
           << spacing.str() << (grid.on_cells ? "\nCELL_DATA " : "\nPOINT_DATA ") << n << '\n';
  for_each_block(
      [&]<class Block>(auto k, const Block& block) {
        const Index parts = block.size() / n;
        if (parts == 0 || block.size() % n != 0) refuse_vtk(n, "a state of " + std::to_string(block.size()));
        Eigen::Matrix<typename Block::Scalar, Eigen::Dynamic, Eigen::Dynamic> x = block;
        if (block.rows() != parts || block.cols() != n) x = block.reshaped(n, parts).transpose().eval();
        file.array(k() < grid.names.size() ? grid.names[k()] : block_name<S>(k()), n, x);
      },
      Blocks<S>::all(state));
  return n;
}

}  // namespace detail

/// Writes a state as points with all that they have, or as a layout says.
/// @param columns  further arrays with a value, or a column of values, for each point (cell): column("pressure", p)
/// @throws std::invalid_argument where layout and state don't fit; std::runtime_error, naming file and reason, where the file
/// can't be written: an older one is then still there
template <State S, class Layout = VtkMesh, class... Values>
void write_vtk(const std::filesystem::path& path, const S& state, const Layout& layout = {},
               const NamedColumn<Values>&... columns) {
  detail::VtkFile file{layout.single};
  file.out << "# vtk DataFile Version 3.0\nphistep\nBINARY\nDATASET ";
  [[maybe_unused]] const Index n = detail::put_state(file, layout, state);
  (file.array(columns.name, n, columns.content), ...);
  detail::replace_file(path, file.out.str());
}

/// An observer that writes a frame each time it is called: `sampled(0.1, vtk_series("out/melt"))`, or with a layout, then columns,
/// `vtk_series("out/melt", {.wrapped = true}, column("speed", [](double, const auto& y) -> Eigen::VectorXd { … }))`.
///
/// A frame replaces those of its time or later: a second run with the same object starts the series anew, a run from where the
/// last one ended goes on with it. A new object starts a new series, unless it resumes: then the frames before its first one
/// stay. Runs backward in time are series too.
/// @param base  of the list out/melt.vtk.series and the folder out/melt; its own folder must exist
template <class Layout = VtkMesh, class... Content>
[[nodiscard]] auto vtk_series(const std::filesystem::path& base, Layout layout = {}, NamedColumn<Content>... columns) {
  return [base, layout = std::move(layout), columns = std::make_tuple(std::move(columns)...),
          times = std::vector<double>{}](auto time, const auto& state) mutable {
    const auto t = static_cast<double>(time);
    const auto list = std::filesystem::path(base) += ".vtk.series";
    if (std::exchange(layout.resume, false)) {
      std::ifstream in(list);
      in.imbue(std::locale::classic());
      double listed = 0;
      for (std::string word; in >> word;)
        if (word == "{\"time\":" && in >> listed) times.push_back(listed);
    }
    const bool is_back = times.size() > 1 ? times[1] < times[0] : !times.empty() && t < times[0];
    while (!times.empty() && (is_back ? times.back() <= t : times.back() >= t)) times.pop_back();
    std::error_code ignored;  // writing fails, and says why
    std::filesystem::create_directory(base, ignored);
    const auto name = [](std::size_t k) {
      std::string digits = std::to_string(k) + ".vtk";
      return digits.insert(0, 9 - std::min<std::size_t>(digits.size(), 9), '0');
    };
    const auto frame = base / name(times.size());
    std::apply([&](const auto&... own) { write_vtk(frame, state, layout, column_at(own, t, state)...); }, columns);
    times.push_back(t);
    auto text = detail::exact_text();
    for (std::size_t k = 0; k < times.size(); ++k)
      text << (k == 0 ? "{\"file-series-version\": \"1.0\", \"files\": [\n" : ",\n") << "{\"time\": " << times[k]
           << ", \"name\": " << std::quoted((base.filename() / name(k)).generic_string()) << '}';
    detail::replace_file(list, text.str() + "\n]}\n");
  };
}

}}  // namespace phistep::PHISTEP_ABI
