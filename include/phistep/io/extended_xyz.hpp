/// @file
/// Frames in the extended XYZ format, which OVITO, ASE and others open: the number of particles, a line of properties, and
/// one line a particle: species, position, velocity, and columns of one's own.
///
///     integrate(…, every(0.1, extended_xyz(out, "Fe", column("radius", radii))));
#pragma once

#include <Eigen/Core>

#include <concepts>
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
  std::vector<std::string> species{"X"};              ///< one for all, or one a particle
  bool periodic = false;                              ///< whether there is a lattice
  Eigen::Matrix3d lattice = Eigen::Matrix3d::Zero();  ///< its vectors as columns [length]
};

/// Appends one frame: positions and velocities, both dim × N with dim ≤ 3 (missing coordinates are 0), and any number of
/// columns with one value (or one column of values) a particle. Numbers have 9 digits.
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
  for (const std::string& species : info.species)
    if (species.empty() || species.find_first_of(" \t\r\n") != std::string::npos)
      throw std::invalid_argument("phistep: a species of an extended XYZ frame must be a word");

  constexpr int digits = std::numeric_limits<float>::max_digits10;
  std::string text = std::to_string(n) + '\n';
  if (info.periodic) {
    text += "Lattice=\"";
    for (Eigen::Index k = 0; k < 9; ++k) {
      if (k > 0) text += ' ';
      append_number(text, info.lattice(k % 3, k / 3));
    }
    text += "\" ";
  }
  text += "Properties=species:S:1:pos:R:3:velo:R:3";
  [[maybe_unused]] const auto declare = [&](const auto& column) {
    // A vector holds one value a particle, a matrix one column of values.
    const auto& values = column.content;
    const bool flat = std::remove_cvref_t<decltype(values)>::IsVectorAtCompileTime;
    if ((flat ? values.size() : values.cols()) != n)
      throw std::invalid_argument("phistep: column " + column.name + " of an extended XYZ frame has " +
                                  std::to_string(flat ? values.size() : values.cols()) + " values for " +
                                  std::to_string(n) + " particles");
    if (column.name.empty() || column.name.find_first_of(" :\t\r\n\"=") != std::string::npos)
      throw std::invalid_argument("phistep: a column of an extended XYZ frame needs a name that is one word");
    const bool integral = std::is_integral_v<typename std::remove_cvref_t<decltype(values)>::Scalar>;
    text += ':' + column.name + (integral ? ":I:" : ":R:") + std::to_string(flat ? 1 : values.rows());
  };
  (declare(columns), ...);
  text += " Time=";
  append_number(text, time);
  text += '\n';

  const auto put = [&text](auto x) {
    text += ' ';
    if constexpr (std::is_integral_v<decltype(x)>) append_number(text, x);
    else append_number(text, static_cast<double>(x), digits);
  };
  const auto put_vector = [&put](const auto& x, Eigen::Index j) {
    for (Eigen::Index i = 0; i < 3; ++i) put(i < x.rows() ? static_cast<double>(x.derived()(i, j)) : 0.0);
  };
  [[maybe_unused]] const auto put_values = [&put](const auto& values, Eigen::Index j) {
    if constexpr (std::remove_cvref_t<decltype(values)>::IsVectorAtCompileTime) put(values[j]);
    else
      for (Eigen::Index i = 0; i < values.rows(); ++i) put(values(i, j));
  };
  for (Eigen::Index j = 0; j < n; ++j) {
    text += info.species[info.species.size() == 1 ? 0 : static_cast<std::size_t>(j)];
    put_vector(r, j);
    put_vector(v, j);
    (put_values(columns.content, j), ...);
    text += '\n';
  }
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  if (!out) throw std::runtime_error("phistep: writing an extended XYZ frame failed");
}
template <class Positions, class Velocities>
void write_extended_xyz(std::ostream& out, double time, const Eigen::DenseBase<Positions>& r,
                        const Eigen::DenseBase<Velocities>& v, std::string_view species = "X") {
  write_extended_xyz(out, time, r, v, FrameInfo{.species = {std::string{species}}});
}

/// An observer that appends a frame at each look at a motion.
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
    const auto blocks = Blocks<S>::all(state);
    const auto r = particles(std::get<0>(blocks)), v = particles(std::get<1>(blocks));
    std::apply(
        [&](const auto&... column) {
          write_extended_xyz(*out_, static_cast<double>(t), r, v, info_, now(column, t, state)...);
        },
        columns_);
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
    if constexpr (std::is_invocable_v<const C&, Scalar, const S&>) {
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
[[nodiscard]] ExtendedXyz<dim, Content...> extended_xyz(std::ostream& out, FrameInfo info,
                                                        NamedColumn<Content>... columns) {
  return {out, std::move(info), std::move(columns)...};
}
template <int dim = 3, class... Content>
[[nodiscard]] ExtendedXyz<dim, Content...> extended_xyz(std::ostream& out, std::string species = "X",
                                                        NamedColumn<Content>... columns) {
  return {out, FrameInfo{.species = {std::move(species)}}, std::move(columns)...};
}

}  // namespace phistep::inline PHISTEP_ABI
