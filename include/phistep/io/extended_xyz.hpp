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
#include <ostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/core/version.hpp"
#include "phistep/io/frame_text.hpp"
#include "phistep/io/text.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What a frame holds beside positions and velocities.
struct FrameInfo {
  std::vector<std::string> species{"X"};  ///< one for all, or one a particle; of Particles: one for all, or one a type
  bool periodic = false;                  ///< whether there is a lattice; Particles have a box that says it
  Eigen::Matrix3d lattice = Eigen::Matrix3d::Zero();  ///< its vectors as columns [length]
  bool exact = false;                                 ///< as many digits as bring back the same bits, rather than 9
  bool wrapped = false;                               ///< Particles: positions moved into the periodic box
};

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

}}  // namespace phistep::PHISTEP_ABI
