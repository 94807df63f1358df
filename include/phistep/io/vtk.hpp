/// @file
/// Files that ParaView and PyVista open: particles (.vtp), fields on regular grids (.vti), nets, cloth and meshes (.vtu), and
/// series of them (.pvd).
///
///     integrate(…, sampled(0.1, vtk_series("out/melt")));                               // particles, motions
///     integrate(…, sampled(0.1, vtk_series("out/plate", VtkGrid{.size = {80, 50}, .spacing = {dx, dx}})));
///     integrate(…, sampled(0.1, vtk_series("out/cloth", VtkMesh{.triangles = triangles})));
///     write_vtk("end.vtp", particles);
///     write_vtk("end.vti", VtkGrid{.size = {80, 50}, .names = {"temperature"}}, theta);
///
/// A series writes out/melt.pvd and out/melt/00000.vtp, 00001.vtp, …: open the .pvd. It is complete after each frame, so the
/// files of a run that was cut off open as well. The folder out must exist. Arrays are named "velocity", "mass", "radius", …;
/// further ones are columns, as in extended_xyz: column("speed", [](double t, const auto& y) -> Eigen::VectorXd { … }).
///
/// Numbers are Float64 unless single precision is asked for; integers keep their type. No other library is needed.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "phistep/core/version.hpp"
#include "phistep/io/text.hpp"
#include "phistep/io/vtk/blocks.hpp"
#include "phistep/io/vtk/collection.hpp"
#include "phistep/io/vtk/file.hpp"
#include "phistep/io/vtk/layout.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// How VTK files are written.
struct VtkOptions {
  bool single = false;  ///< real numbers as Float32: half the size, 7 digits
  bool resume = false;  ///< a series: go on with the one that is there, in place of starting a new one
};

/// Writes a state to a file whose extension is that of the layout: .vtp, .vti, .vtu.
/// @param columns  further arrays with a value, or a column of values, for each point (cell): column("pressure", p)
/// @throws std::invalid_argument where extension, layout and state don't fit; std::runtime_error, naming file and reason,
/// where the file can't be written: an older one is then still there
template <VtkLayout Layout, State S, class... Content>
void write_vtk(const std::filesystem::path& path, const Layout& layout, const S& state, const VtkOptions& options,
               const NamedColumn<Content>&... columns) {
  if (path.extension() != Layout::extension)
    throw std::invalid_argument("phistep: the name of this VTK file must end in " + std::string(Layout::extension) +
                                ": " + detail::utf8(path));
  detail::vtk_file(layout, state, detail::VtkHead{{}, options.single}, columns...).write(path);
}
template <VtkLayout Layout, State S, class... Content>
void write_vtk(const std::filesystem::path& path, const Layout& layout, const S& state,
               const NamedColumn<Content>&... columns) {
  write_vtk(path, layout, state, VtkOptions{}, columns...);
}
/// … of particles or a motion: .vtp.
template <State S, class... Content>
void write_vtk(const std::filesystem::path& path, const S& state, const NamedColumn<Content>&... columns) {
  write_vtk(path, VtkPoints{}, state, VtkOptions{}, columns...);
}

/// An observer that writes a frame at each look, and its time into the series' .pvd.
///
/// A frame at a time replaces those of that time or later: a second run with the same object starts the series anew, a run
/// from where the last one ended goes on with it. A new object starts a new series (frames of an older one stay in the folder
/// until they are overwritten, and are not listed), unless it resumes: then the frames before its first one stay, and those
/// that were written after a checkpoint are written again. Runs backward in time are series too.
template <VtkLayout Layout, class... Content>
class VtkSeries {
 public:
  VtkSeries(const std::filesystem::path& base, Layout layout, VtkOptions options, NamedColumn<Content>... columns)
      : layout_(std::move(layout)),
        options_{options},
        frames_{base, Layout::extension},
        columns_{std::move(columns)...} {}

  /// @throws std::invalid_argument where layout and state don't fit; std::runtime_error, naming file and reason, where a
  /// file can't be written
  template <class Scalar, State S>
  void operator()(Scalar t, const S& state) {
    const auto now = static_cast<double>(t);
    const VtkFile frame = std::apply(
        [&](const auto&... column) {
          return detail::vtk_file(layout_, state, detail::VtkHead{now, options_.single}, column...);
        },
        columns_);
    if (options_.resume && !is_read_) frames_.read();
    is_read_ = true;
    frame.write(frames_.next(now));
    frames_.add(now);
  }
  /// The times of the frames, and the path of the .pvd.
  [[nodiscard]] const VtkCollection& frames() const { return frames_; }

 private:
  Layout layout_;
  VtkOptions options_;
  VtkCollection frames_;
  std::tuple<NamedColumn<Content>...> columns_;
  bool is_read_ = false;
};

/// `sampled(0.1, vtk_series("out/melt"))`: particles or a motion, at exact times. `every(0.1, …)` takes ends of steps.
/// @param base  of out/melt.pvd and the folder out/melt; its own folder must exist
template <class... Content>
[[nodiscard]] VtkSeries<VtkPoints, Content...> vtk_series(const std::filesystem::path& base,
                                                          NamedColumn<Content>... columns) {
  return {base, VtkPoints{}, VtkOptions{}, std::move(columns)...};
}
/// … with options: `vtk_series("out/melt", {.resume = true})`.
template <class... Content>
[[nodiscard]] VtkSeries<VtkPoints, Content...> vtk_series(const std::filesystem::path& base, VtkOptions options,
                                                          NamedColumn<Content>... columns) {
  return {base, VtkPoints{}, options, std::move(columns)...};
}
/// … of fields on a grid, or on a mesh; with positions that aren't matrices, or wrapped.
template <VtkLayout Layout, class... Content>
[[nodiscard]] VtkSeries<Layout, Content...> vtk_series(const std::filesystem::path& base, Layout layout,
                                                       NamedColumn<Content>... columns) {
  return {base, std::move(layout), VtkOptions{}, std::move(columns)...};
}
template <VtkLayout Layout, class... Content>
[[nodiscard]] VtkSeries<Layout, Content...> vtk_series(const std::filesystem::path& base, Layout layout,
                                                       VtkOptions options, NamedColumn<Content>... columns) {
  return {base, std::move(layout), options, std::move(columns)...};
}

}}  // namespace phistep::PHISTEP_ABI
