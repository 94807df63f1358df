/// @file
/// Frames in the extended XYZ format, which OVITO, ASE and others open: the number of particles, a line of properties, and
/// one line a particle: species, position, velocity, and columns of one's own.
///
///     integrate(…, every(0.1, extended_xyz(out, "Fe", column("radius", radii))));
///     integrate(…, every(0.1, extended_xyz(out)));           // of Particles: with their box, ids, radii, spins …
#pragma once

#include <Eigen/Core>

#include <concepts>
#include <cstdint>
#include <limits>
#include <ostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/core/version.hpp"
#include "phistep/io/text.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/motion.hpp"

namespace phistep::inline PHISTEP_ABI {

/// What a frame says beside positions and velocities.
struct FrameInfo {
  std::vector<std::string> species{"X"};  ///< one for all, or one a particle; of Particles: one for all, or one a type
  bool periodic = false;                  ///< whether there is a lattice; Particles have a box that says it
  Eigen::Matrix3d lattice = Eigen::Matrix3d::Zero();  ///< its vectors as columns [length]
  bool exact = false;                                 ///< as many digits as bring back the same bits, rather than 9
  bool wrapped = false;                               ///< Particles: positions moved into the periodic box
};

/// The text of one frame; columns without values are left out.
template <class... Values>
class FrameText {
 public:
  FrameText(Eigen::Index n, bool exact, const NamedColumn<Values>&... columns)
      : n_{n}, exact_{exact}, columns_{columns...} {}

  [[nodiscard]] std::string operator()(double time, const std::string& about, const auto& r, const auto& v,
                                       auto&& species) const {
    std::string text = std::to_string(n_) + '\n' + about + "Properties=species:S:1:pos:R:3:velo:R:3";
    std::apply([&](const auto&... column) { (declare(text, column), ...); }, columns_);
    text += " Time=";
    append_number(text, time);
    text += '\n';
    for (Eigen::Index j = 0; j < n_; ++j) {
      text += species(j);
      put_vector(text, r, j), put_vector(text, v, j);
      std::apply([&](const auto&... column) { (put_values(text, column.content, j), ...); }, columns_);
      text += '\n';
    }
    return text;
  }

 private:
  static constexpr int digits = std::numeric_limits<float>::max_digits10;

  // A vector holds one value a particle, a matrix one column of values.
  template <class T>
  static constexpr bool is_flat = std::remove_cvref_t<T>::IsVectorAtCompileTime;

  template <class T>
  void declare(std::string& text, const NamedColumn<T>& column) const {
    const auto& values = column.content;
    if (values.size() == 0) return;
    text += ':' + column.name + (std::is_integral_v<typename std::remove_cvref_t<T>::Scalar> ? ":I:" : ":R:") +
            std::to_string(is_flat<T> ? 1 : values.rows());
  }
  void put(std::string& text, auto x) const {
    text += ' ';
    if constexpr (std::is_integral_v<decltype(x)>) {
      append_number(text, x);
    } else {
      if (exact_) append_number(text, x);
      else append_number(text, static_cast<double>(x), digits);
    }
  }
  void put_vector(std::string& text, const auto& x, Eigen::Index j) const {
    for (Eigen::Index i = 0; i < 3; ++i) put(text, i < x.rows() ? x(i, j) : 0);
  }
  template <class T>
  void put_values(std::string& text, const T& values, Eigen::Index j) const {
    if (values.size() == 0) return;
    if constexpr (is_flat<T>) put(text, values[j]);
    else
      for (Eigen::Index i = 0; i < values.rows(); ++i) put(text, values(i, j));
  }

  Eigen::Index n_;
  bool exact_;
  std::tuple<const NamedColumn<Values>&...> columns_;
};

inline void check_species(const std::vector<std::string>& species) {
  for (const std::string& name : species)
    if (name.empty() || name.find_first_of(" \t\r\n") != std::string::npos)
      throw std::invalid_argument("phistep: a species of an extended XYZ frame must be a word");
}
template <class T>
void check_column(Eigen::Index n, const NamedColumn<T>& column) {
  const bool flat = std::remove_cvref_t<T>::IsVectorAtCompileTime;
  const Eigen::Index size = flat ? column.content.size() : column.content.cols();
  if (size != n)
    throw std::invalid_argument("phistep: column " + column.name + " of an extended XYZ frame has " +
                                std::to_string(size) + " values for " + std::to_string(n) + " particles");
  if (column.name.empty() || column.name.find_first_of(" :\t\r\n\"=") != std::string::npos)
    throw std::invalid_argument("phistep: a column of an extended XYZ frame needs a name that is one word");
}
inline void append_frame(std::ostream& out, const std::string& text) {
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  if (!out) throw std::runtime_error("phistep: writing an extended XYZ frame failed");
}
[[nodiscard]] inline std::string lattice_text(const Eigen::Matrix3d& lattice) {
  std::string text = "Lattice=\"";
  for (Eigen::Index k = 0; k < 9; ++k) {
    if (k > 0) text += ' ';
    append_number(text, lattice(k % 3, k / 3));
  }
  return text + "\" ";
}

/// Appends one frame: positions and velocities, both dim × N with dim ≤ 3 (missing coordinates are 0), and any number of
/// columns with one value (or one column of values) a particle. Numbers have 9 digits, or all of them.
/// @throws std::invalid_argument where the shapes differ or dim > 3; std::runtime_error where the stream fails.
template <class Positions, class Velocities, class... Values>
void write_extended_xyz(std::ostream& out, double time, const Eigen::DenseBase<Positions>& r,
                        const Eigen::DenseBase<Velocities>& v, const FrameInfo& info,
                        const NamedColumn<Values>&... columns) {
  const Eigen::Index n = r.cols();
  if (r.rows() > 3 || r.rows() != v.rows() || n != v.cols())
    throw std::invalid_argument(
        "phistep: write_extended_xyz needs positions and velocities of one shape, dim x N with dim <= 3");
  if (info.species.empty() || (info.species.size() != 1 && info.species.size() != static_cast<std::size_t>(n)))
    throw std::invalid_argument("phistep: write_extended_xyz needs one species, or one a particle");
  check_species(info.species);
  (check_column(n, columns), ...);
  const auto species = [&info](Eigen::Index j) -> const std::string& {
    return info.species[info.species.size() == 1 ? 0 : static_cast<std::size_t>(j)];
  };
  append_frame(out, FrameText{n, info.exact, columns...}(time, info.periodic ? lattice_text(info.lattice) : "",
                                                         r.derived(), v.derived(), species));
}
template <class Positions, class Velocities>
void write_extended_xyz(std::ostream& out, double time, const Eigen::DenseBase<Positions>& r,
                        const Eigen::DenseBase<Velocities>& v, std::string_view species = "X") {
  write_extended_xyz(out, time, r, v, FrameInfo{.species = {std::string{species}}});
}

/// The box as Lattice, Origin and pbc. Along an open axis without sides the particles' own extent stands for them.
template <class P>
[[nodiscard]] std::string box_text(const P& particles) {
  constexpr int dim = P::dimensions;
  const auto& box = particles.box();
  if (box.is_open()) return "pbc=\"F F F\" ";
  Eigen::Matrix3d lattice = Eigen::Matrix3d::Identity();
  std::string origin, periodic, sides;
  bool is_rounded = false;
  for (int a = 0; a < 3; ++a) {
    double lower = 0, upper = 1;
    bool repeats = false;
    if (a < dim) {
      lower = static_cast<double>(box.lower[a]), upper = static_cast<double>(box.upper[a]);
      repeats = box.is_periodic[static_cast<std::size_t>(a)];
      if (!(upper > lower) && particles.size() > 0)
        lower = static_cast<double>(particles.r.row(a).minCoeff()),
        upper = static_cast<double>(particles.r.row(a).maxCoeff());
      if (!(upper > lower)) upper = lower + 1;
    }
    lattice(a, a) = upper - lower;
    // Rounding may have lost the other side: then it is told, too.
    is_rounded = is_rounded || lower + lattice(a, a) != upper;
    if (a > 0) sides += ' ';
    append_number(sides, upper);
    if (a > 0) origin += ' ', periodic += ' ';
    append_number(origin, lower);
    periodic += repeats ? 'T' : 'F';
  }
  return lattice_text(lattice) + "Origin=\"" + origin + "\" " + (is_rounded ? "Upper=\"" + sides + "\" " : "") +
         "pbc=\"" + periodic + "\" ";
}

/// Appends a frame of Particles: their box, id, and mass (unless all are 1), radius, charge, type (as species where each has a
/// name, and as a number), omega and temperature where they have them; then columns of one's own.
/// @throws std::invalid_argument where species are none, no words, or too few; std::runtime_error where the stream fails
template <class P, class... Values>
  requires requires(const P& particles) { particles.body(); }
void write_extended_xyz(std::ostream& out, double time, const P& particles, const FrameInfo& info = {},
                        const NamedColumn<Values>&... columns) {
  using Scalar = typename P::Scalar;
  using Column = typename P::Column;
  using Block = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  const auto& body = particles.body();
  const Eigen::Index n = particles.size();
  const std::size_t types = body.type.size() == 0 ? 1 : static_cast<std::size_t>(body.type.maxCoeff()) + 1;
  if (info.species.empty() || (info.species.size() != 1 && info.species.size() < types))
    throw std::invalid_argument("phistep: write_extended_xyz needs one species, or one a type");
  check_species(info.species);
  (check_column(n, columns), ...);
  const auto species = [&](Eigen::Index j) -> const std::string& {
    return info.species[info.species.size() == 1 ? 0 : static_cast<std::size_t>(body.type_of(j))];
  };
  typename P::Vectors r = particles.r;
  if (info.wrapped)
    for (Eigen::Index j = 0; j < n; ++j) r.col(j) = body.box.wrapped(r.col(j));
  Block omega;
  Column temperature;
  if constexpr (requires { particles.omega; }) omega = particles.omega;
  if constexpr (requires { particles.temperature; }) temperature = particles.temperature.transpose();
  const bool of_mass_1 = (body.mass.array() == Scalar{1}).all();
  using Ids = Eigen::Matrix<std::int64_t, Eigen::Dynamic, 1>;
  using Flags = Eigen::Matrix<std::uint8_t, Eigen::Dynamic, 1>;
  const auto id = column("id", Ids(Eigen::Map<const Ids>(body.id.data(), n)));
  const auto mass = column("mass", of_mass_1 ? Column{} : body.mass);
  const auto radius = column("radius", body.radius), charge = column("charge", body.charge);
  const auto type = column("type_index", body.type);
  const auto capacity = column("heat_capacity", body.heat_capacity);
  const auto still =
      column("still", Ids(Eigen::Map<const Flags>(body.still.data(), static_cast<Eigen::Index>(body.still.size()))
                              .template cast<std::int64_t>()));
  const auto spin = column("omega", std::move(omega));
  const auto heat = column("temperature", std::move(temperature));
  std::string about = box_text(particles);
  if (spin.content.size() > 0) about += "inertia_factor=", append_number(about, body.inertia_factor), about += ' ';
  const FrameText frame{n, info.exact, id, mass, radius, type, charge, capacity, still, spin, heat, columns...};
  append_frame(out, frame(time, about, r, particles.v, species));
}

/// An observer that appends a frame at each look at a motion, or at Particles.
/// @tparam dim  coordinates of a particle where the state is one flat vector (x₀ y₀ [z₀] x₁ …)
template <int dim, class... Content>
class ExtendedXyz {
 public:
  ExtendedXyz(std::ostream& out, FrameInfo info, NamedColumn<Content>... columns)
      : out_{&out}, info_{std::move(info)}, columns_{std::move(columns)...} {}

  /// @throws std::invalid_argument where shapes don't fit; std::runtime_error where the stream fails
  template <class Scalar, State S>
  void operator()(Scalar t, const S& state) {
    static_assert(Blocks<S>::drifts, "phistep: extended_xyz(out) needs a motion, with positions and velocities");
    if constexpr (requires { state.body(); }) {
      std::apply(
          [&](const auto&... column) {
            write_extended_xyz(*out_, static_cast<double>(t), state, info_, now(column, t, state)...);
          },
          columns_);
    } else {
      const auto blocks = Blocks<S>::all(state);
      const auto r = particles(std::get<0>(blocks)), v = particles(std::get<1>(blocks));
      std::apply(
          [&](const auto&... column) {
            write_extended_xyz(*out_, static_cast<double>(t), r, v, info_, now(column, t, state)...);
          },
          columns_);
    }
  }

 private:
  template <class Block>
  [[nodiscard]] static auto particles(const Block& block) {
    using Scalar = typename Block::Scalar;
    if constexpr (Block::IsVectorAtCompileTime) {
      if (block.size() % dim != 0)
        throw std::invalid_argument("phistep: extended_xyz<" + std::to_string(dim) + ">(out) does not fit a state of " +
                                    std::to_string(block.size()) + " components");
      return Eigen::Matrix<Scalar, dim, Eigen::Dynamic>(block.reshaped(dim, block.size() / dim));
    } else {
      return Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>(block);
    }
  }
  /// A column's values as they are now.
  template <class C, class Scalar, class S>
  [[nodiscard]] static decltype(auto) now(const NamedColumn<C>& column, Scalar t, const S& state) {
    // A matrix can be "called" too, with anything for its indices.
    if constexpr (!requires { column.content.cols(); }) {
      using Values = typename std::remove_cvref_t<std::invoke_result_t<const C&, Scalar, const S&>>::PlainObject;
      return NamedColumn<Values>{column.name, column.content(t, state)};
    } else {
      return (column);
    }
  }

  std::ostream* out_;
  FrameInfo info_;
  std::tuple<NamedColumn<Content>...> columns_;
};

/// `every(0.1, extended_xyz(out, "Fe"))`, `extended_xyz<2>(out)` for flat vectors in the plane, with a lattice
/// `extended_xyz(out, {.species = {"Ar"}, .periodic = true, .lattice = box})`; then columns, `column("radius", radii)` or
/// `column("speed", [](double, const auto& y) -> Eigen::VectorXd { … })`.
template <int dim = 3, class... Content>
[[nodiscard]] ExtendedXyz<dim, Content...> extended_xyz(std::ostream& out, FrameInfo info = {},
                                                        NamedColumn<Content>... columns) {
  return {out, std::move(info), std::move(columns)...};
}
template <int dim = 3, std::convertible_to<std::string> Text, class... Content>
[[nodiscard]] ExtendedXyz<dim, Content...> extended_xyz(std::ostream& out, Text&& species,
                                                        NamedColumn<Content>... columns) {
  return {out, FrameInfo{.species = {std::string(std::forward<Text>(species))}}, std::move(columns)...};
}

}  // namespace phistep::inline PHISTEP_ABI
