/// @file
/// Frames in the extended XYZ format, which OVITO, ASE and others open: the number of particles; a line with the box, the time
/// and the names of columns; a line a particle: species, position, velocity, what else it has (id, radius …), own columns.
///
///     integrate(…, every(0.1, extended_xyz(out, {.species = {"Fe"}}, column("temperature", T))));
#pragma once

#include <Eigen/Core>

#include <charconv>
#include <functional>
#include <limits>
#include <ostream>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/state/blocks.hpp"
#include "phistep/io/text.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What a frame holds beside positions and velocities.
struct FrameInfo {
  std::vector<std::string> species{"X"};  ///< one for all, or one per particle (Particles: per type)
  bool exact = false;                     ///< as many digits as bring back the same bits, rather than 9
  bool wrapped = false;                   ///< Particles: positions moved into the periodic box
  Eigen::Index dimensions = 0;            ///< of a particle in a flat vector; 0: the vector is one particle
};

namespace detail {
template <class T>
void check_column(Eigen::Index n, const NamedColumn<T>& column) {
  const Eigen::Index size = T::IsVectorAtCompileTime ? column.content.size() : column.content.cols();
  if (size != n)
    throw std::invalid_argument("phistep: column " + column.name + " of an extended XYZ frame has " +
                                std::to_string(size) + " values for " + std::to_string(n) + " particles");
  if (column.name.empty() || column.name.find_first_of(" :\t\r\n\"=") != std::string::npos)
    throw std::invalid_argument("phistep: a column of an extended XYZ frame needs a name that is one word");
}

/// Columns without values are left out. @param kind  which species particle j is, where there are several
template <class... Values>
void append_frame(std::ostream& out, double time, const std::string& about, const auto& r, const auto& v,
                  const FrameInfo& info, auto&& kind, const NamedColumn<Values>&... columns) {
  for (const std::string& name : info.species)
    if (name.empty() || name.find_first_of(" \t\r\n") != std::string::npos)
      throw std::invalid_argument("phistep: a species of an extended XYZ frame must be a word");
  std::string text = std::to_string(r.cols()) + '\n' + about + "Properties=species:S:1:pos:R:3:velo:R:3";
  [[maybe_unused]] const auto declare = [&text]<class T>(const std::string& name, const T& x) {
    const char* const type = std::is_integral_v<typename T::Scalar> ? ":I:" : ":R:";
    if (x.size() > 0) text += ':' + name + type + std::to_string(T::IsVectorAtCompileTime ? 1 : x.rows());
  };
  (declare(columns.name, columns.content), ...);
  text += " Time=", append_number(text, time), text += '\n';
  const auto put = [&](auto x) {
    text += ' ';
    if (std::is_integral_v<decltype(x)> || info.exact) append_number(text, x);
    else
      append_number(text, static_cast<double>(x), std::chars_format::general, std::numeric_limits<float>::max_digits10);
  };
  for (Eigen::Index j = 0; j < r.cols(); ++j) {
    text += info.species[info.species.size() == 1 ? 0 : static_cast<std::size_t>(kind(j))];
    for (Eigen::Index i = 0; i < 3; ++i) put(r(i, j));
    for (Eigen::Index i = 0; i < 3; ++i) put(v(i, j));
    [[maybe_unused]] const auto put_all = [&]<class T>(const T& x) {
      for (Eigen::Index i = 0; x.size() > 0 && i < (T::IsVectorAtCompileTime ? 1 : x.rows()); ++i)
        if constexpr (T::IsVectorAtCompileTime) put(x[j]);
        else put(x(i, j));
    };
    (put_all(columns.content), ...);
    text += '\n';
  }
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  if (!out) throw std::runtime_error("phistep: writing an extended XYZ frame failed");
}

/// The box as Lattice, Origin and pbc. Along an open axis without sides the particles' own extent stands for them.
template <class P>
[[nodiscard]] std::string box_text(const P& particles) {
  const auto& box = particles.box();
  if (box.is_open()) return "pbc=\"F F F\" ";
  Eigen::Vector3d lower = Eigen::Vector3d::Zero(), upper = Eigen::Vector3d::Ones();
  std::string sides, origin, periodic;
  for (int a = 0; a < 3; ++a) {
    const bool is_there = a < P::dimensions, has_sides = is_there && box.upper[a] > box.lower[a];
    if (has_sides) lower[a] = static_cast<double>(box.lower[a]), upper[a] = static_cast<double>(box.upper[a]);
    else if (is_there && particles.size() > 0)
      lower[a] = static_cast<double>(particles.r.row(a).minCoeff()),
      upper[a] = static_cast<double>(particles.r.row(a).maxCoeff());
    if (!(upper[a] > lower[a])) upper[a] = lower[a] + 1;
    for (int b = 0; b < 3; ++b) append_number(sides, a == b ? upper[a] - lower[a] : 0.0), sides += ' ';
    append_number(origin, lower[a]), origin += ' ';
    periodic += is_there && box.is_periodic[static_cast<std::size_t>(a)] ? "T " : "F ";
  }
  sides.back() = origin.back() = periodic.back() = '"';
  return "Lattice=\"" + sides + " Origin=\"" + origin + " pbc=\"" + periodic + ' ';
}
}  // namespace detail

/// Appends one frame: positions and velocities, both dim × N with dim ≤ 3 (missing coordinates are 0), and any number of
/// columns with one value (or one column of values) a particle. Numbers have 9 digits, or all of them.
/// @throws std::invalid_argument where the shapes differ or dim > 3; std::runtime_error where the stream fails.
template <class Positions, class Velocities, class... Values>
void write_extended_xyz(std::ostream& out, double time, const Eigen::DenseBase<Positions>& r,
                        const Eigen::DenseBase<Velocities>& v, const FrameInfo& info = {},
                        const NamedColumn<Values>&... columns) {
  if (r.rows() != v.rows() || r.cols() != v.cols())
    throw std::invalid_argument("phistep: write_extended_xyz needs positions and velocities of one shape, dim x N");
  if (info.species.size() != 1 && (info.species.empty() || info.species.size() != static_cast<std::size_t>(r.cols())))
    throw std::invalid_argument("phistep: write_extended_xyz needs one species, or one a particle");
  (detail::check_column(r.cols(), columns), ...);
  detail::append_frame(out, time, "", in_space(r.derived(), 0), in_space(v.derived(), 0), info, std::identity{},
                       columns...);
}

/// Appends a frame of Particles: box, id, mass (unless all are 1), and where they have them radius, charge, type (as a number, and
/// as species where each type has a name), omega and temperature; then the given columns.
/// @throws std::invalid_argument where species are too few, or one isn't a word; std::runtime_error where the stream fails
template <class P, class... Values>
  requires requires(const P& particles) { particles.body(); }
void write_extended_xyz(std::ostream& out, double time, const P& particles, const FrameInfo& info = {},
                        const NamedColumn<Values>&... columns) {
  const auto& body = particles.body();
  const std::size_t types = body.type.size() == 0 ? 1 : static_cast<std::size_t>(body.type.maxCoeff()) + 1;
  if (info.species.empty() || (info.species.size() != 1 && info.species.size() < types))
    throw std::invalid_argument("phistep: write_extended_xyz needs one species, or one a type");
  (detail::check_column(particles.size(), columns), ...);
  typename P::Vectors r = particles.r;
  if (info.wrapped)
    for (Eigen::Index j = 0; j < r.cols(); ++j) r.col(j) = body.box.wrapped(r.col(j));
  Eigen::Matrix<typename P::Scalar, Eigen::Dynamic, Eigen::Dynamic> omega, temperature;
  if constexpr (requires { particles.omega; }) omega = particles.omega;
  if constexpr (requires { particles.temperature; }) temperature = particles.temperature;
  const auto list = []<class List>(const List& x) {
    using Column = Eigen::Matrix<typename List::value_type, Eigen::Dynamic, 1>;
    return Eigen::Map<const Column>(x.data(), static_cast<Eigen::Index>(x.size()));
  };
  std::string about = detail::box_text(particles);
  if (omega.size() > 0) about += "inertia_factor=", append_number(about, body.inertia_factor), about += ' ';
  detail::append_frame(
      out, time, about, in_space(r, 0), in_space(particles.v, 0), info,
      [&body](Eigen::Index j) { return body.type_of(j); }, column("id", list(body.id)),
      column("mass", (body.mass.array() == 1).all() ? typename P::Column{} : body.mass), column("radius", body.radius),
      column("type_index", body.type), column("charge", body.charge), column("heat_capacity", body.heat_capacity),
      column("still", list(body.still)), column("omega", omega), column("temperature", temperature), columns...);
}

/// An observer that appends a frame of a motion, or of Particles, each time it is called: `every(0.1, extended_xyz(out, {.species =
/// {"Fe"}}))`; then columns, `column("speed", [](double, const auto& y) -> Eigen::VectorXd { … })`.
/// @throws as write_extended_xyz does, when it is called
template <class... Content>
[[nodiscard]] auto extended_xyz(std::ostream& out, FrameInfo info = {}, NamedColumn<Content>... columns) {
  return [&out, info = std::move(info), columns = std::make_tuple(std::move(columns)...)]<State S>(auto t,
                                                                                                   const S& state) {
    static_assert(Blocks<S>::drifts, "phistep: extended_xyz(out) needs a motion, with positions and velocities");
    const auto write = [&](const auto&... own) {
      if constexpr (requires { state.body(); }) {
        write_extended_xyz(out, static_cast<double>(t), state, info, column_at(own, t, state)...);
      } else {
        const auto blocks = Blocks<S>::all(state);
        write_extended_xyz(out, static_cast<double>(t), in_space(std::get<0>(blocks), info.dimensions),
                           in_space(std::get<1>(blocks), info.dimensions), info, column_at(own, t, state)...);
      }
    };
    std::apply(write, columns);
  };
}

}}  // namespace phistep::PHISTEP_ABI
