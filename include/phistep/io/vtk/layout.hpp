/// @file
/// What the numbers of a state are in a VTK file: particles, values on a regular grid, or values on a mesh.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "phistep/core/version.hpp"
#include "phistep/io/vtk/blocks.hpp"
#include "phistep/io/vtk/file.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Particles: a point each, with all that they have. Files end in .vtp (PolyData).
///
/// A motion's positions are a dim × N matrix, dim ≤ 3 (missing coordinates are 0), or one flat vector x₀ y₀ [z₀] x₁ …
struct VtkPoints {
  Index dimensions = 0;  ///< coordinates of a particle in a flat vector; 0: a flat vector is one particle
  bool wrapped = false;  ///< Particles: positions moved into the periodic box

  static constexpr const char* extension = ".vtp";
};

/// Values on a regular grid in 1, 2 or 3 dimensions, x fastest. Files end in .vti (ImageData).
///
/// A block of n numbers is one field on n points; of k n numbers it is k fields, one after the other (u₀ u₁ … v₀ v₁ …), or,
/// as a k × n matrix, a column a point.
struct VtkGrid {
  std::array<Index, 3> size{};       ///< how many values along x, y, z: {80, 50} in the plane; 0 counts as 1
  std::array<double, 3> spacing{};   ///< [length] between them, along the axes that have more than one
  std::array<double, 3> origin{};    ///< [length] where the first value lies; on cells: the first one's lower corner
  bool on_cells = false;             ///< values of cells (finite volumes), else of points
  std::vector<std::string> names{};  ///< of the fields, or of the blocks; none: those of the blocks

  static constexpr const char* extension = ".vti";
  [[nodiscard]] Index along(std::size_t axis) const { return std::max<Index>(size[axis], 1); }
  [[nodiscard]] Index values() const { return along(0) * along(1) * along(2); }
};

/// Points with lines, triangles, quadrilaterals or tetrahedra between them: nets, cloth, finite elements. Files end in .vtu
/// (UnstructuredGrid).
///
/// Without points of its own it takes a motion's positions, which move; with them, the state's blocks are values at the
/// points, named and laid out as in VtkGrid.
struct VtkMesh {
  Eigen::Matrix<double, 3, Eigen::Dynamic> points{};  ///< [length], or none: the positions of the state
  std::vector<std::array<Index, 2>> lines{};          ///< indices of points
  std::vector<std::array<Index, 3>> triangles{};      ///< likewise
  std::vector<std::array<Index, 4>> quads{};          ///< in order around the cell
  std::vector<std::array<Index, 4>> tetrahedra{};     ///< likewise
  std::vector<std::string> names{};                   ///< of the fields, where there are points
  Index dimensions = 0;                               ///< as in VtkPoints

  static constexpr const char* extension = ".vtu";
};

/// VtkPoints, VtkGrid, VtkMesh.
template <class T>
concept VtkLayout = std::same_as<T, VtkPoints> || std::same_as<T, VtkGrid> || std::same_as<T, VtkMesh>;

namespace detail {

/// Positions of a motion, or of particles.
template <State S>
[[nodiscard]] auto vtk_positions(const S& state, Index dimensions) {
  static_assert(
      Blocks<S>::drifts,
      "phistep: a VTK file needs positions: of a motion or of Particles; for fields give it a VtkGrid{...}, or "
      "a VtkMesh{...} with points");
  return as_vectors(std::get<0>(Blocks<S>::all(state)), dimensions);
}

template <State S, class... Columns>
[[nodiscard]] VtkFile vtk_file(const VtkPoints& layout, const S& state, const VtkHead& head,
                               const Columns&... columns) {
  auto r = vtk_positions(state, layout.dimensions);
  const Index n = r.cols();
  if constexpr (requires { state.body().box; })
    if (layout.wrapped)
      for (Index j = 0; j < n; ++j) r.col(j) = state.body().box.wrapped(state.r.col(j));
  VtkFile file = begin_vtk("PolyData", "", head);
  const std::string count = std::to_string(n);
  file.open("Piece", "NumberOfPoints=\"" + count + "\" NumberOfVerts=\"" + count +
                         "\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"0\"");
  file.open("PointData");
  add_particle_arrays(file, state, n, layout.dimensions);
  (add_column(file, n, columns, head, state), ...);
  file.close("PointData");
  file.open("Points");
  file.vectors("Points", r);
  file.close("Points");
  file.open("Verts");
  file.template array<std::int64_t>("connectivity", n, 1, [](Index i, Index) { return i; });
  file.template array<std::int64_t>("offsets", n, 1, [](Index i, Index) { return i + 1; });
  file.close("Verts");
  file.close("Piece");
  return file;
}

template <State S, class... Columns>
[[nodiscard]] VtkFile vtk_file(const VtkGrid& grid, const S& state, const VtkHead& head, const Columns&... columns) {
  std::string extent, origin, spacing;
  for (std::size_t a = 0; a < 3; ++a) {
    const bool has_length = grid.on_cells ? grid.size[a] > 0 : grid.size[a] > 1;
    const double step = has_length || grid.spacing[a] > 0 ? grid.spacing[a] : 1;
    if (grid.size[a] < 0 || !(step > 0) || !std::isfinite(step) || !std::isfinite(grid.origin[a]))
      throw std::invalid_argument(
          "phistep: a VtkGrid needs sizes >= 0, and a finite origin and a finite spacing > 0 along each axis that it "
          "has");
    const char* const blank = a == 0 ? "" : " ";
    extent += blank + ("0 " + std::to_string(grid.on_cells ? grid.size[a] : grid.along(a) - 1));
    append_number(origin += blank, grid.origin[a]);
    append_number(spacing += blank, step);
  }
  VtkFile file = begin_vtk("ImageData",
                           "WholeExtent=\"" + extent + "\" Origin=\"" + origin + "\" Spacing=\"" + spacing + '"', head);
  file.open("Piece", "Extent=\"" + extent + '"');
  const char* const where = grid.on_cells ? "CellData" : "PointData";
  file.open(where);
  add_fields(file, state, grid.values(), grid.names);
  (add_column(file, grid.values(), columns, head, state), ...);
  file.close(where);
  file.close("Piece");
  return file;
}

/// Calls f(corners, VTK's number of the cell type, its name) for each list of cells.
void for_each_cell_list(const VtkMesh& mesh, auto&& f) {
  f(mesh.lines, 3, "line"), f(mesh.triangles, 5, "triangle"), f(mesh.quads, 9, "quad");
  f(mesh.tetrahedra, 10, "tetrahedron");
}

/// Cells of a mesh with n points; where it has none, each point is one, so that something is seen.
inline void add_cells(VtkFile& file, const VtkMesh& mesh, Index n) {
  std::vector<std::int64_t> corners, ends;
  std::vector<std::uint8_t> types;
  for_each_cell_list(mesh, [&](const auto& cells, std::uint8_t type, const char* name) {
    for (std::size_t k = 0; k < cells.size(); ++k) {
      for (const Index i : cells[k]) {
        if (i < 0 || i >= n)
          throw std::invalid_argument("phistep: " + std::string(name) + ' ' + std::to_string(k) +
                                      " of a VtkMesh has the point " + std::to_string(i) + ", there are " +
                                      std::to_string(n) + ", counted from 0");
        corners.push_back(i);
      }
      ends.push_back(static_cast<std::int64_t>(corners.size())), types.push_back(type);
    }
  });
  if (types.empty())
    for (Index i = 0; i < n; ++i) corners.push_back(i), ends.push_back(i + 1), types.push_back(1);
  file.open("Piece",
            "NumberOfPoints=\"" + std::to_string(n) + "\" NumberOfCells=\"" + std::to_string(types.size()) + '"');
  file.open("Cells");
  const auto put = [&file]<class Number>(const char* name, const std::vector<Number>& list) {
    file.template array<Number>(name, static_cast<Index>(list.size()), 1,
                                [&list](Index i, Index) { return list[static_cast<std::size_t>(i)]; });
  };
  put("connectivity", corners), put("offsets", ends), put("types", types);
  file.close("Cells");
}

template <State S, class... Columns>
[[nodiscard]] VtkFile vtk_file(const VtkMesh& mesh, const S& state, const VtkHead& head, const Columns&... columns) {
  VtkFile file = begin_vtk("UnstructuredGrid", "", head);
  const auto finish = [&](const auto& points, auto&& add_arrays) {
    add_cells(file, mesh, points.cols());
    file.open("PointData");
    add_arrays();
    (add_column(file, points.cols(), columns, head, state), ...);
    file.close("PointData");
    file.open("Points");
    file.vectors("Points", points);
    file.close("Points");
    file.close("Piece");
  };
  if (mesh.points.cols() > 0) finish(mesh.points, [&] { add_fields(file, state, mesh.points.cols(), mesh.names); });
  else if constexpr (Blocks<S>::drifts) {
    const auto r = vtk_positions(state, mesh.dimensions);
    finish(r, [&] { add_particle_arrays(file, state, r.cols(), mesh.dimensions); });
  } else throw std::invalid_argument("phistep: a VtkMesh needs points where the state has no positions");
  return file;
}

}  // namespace detail

}}  // namespace phistep::PHISTEP_ABI
