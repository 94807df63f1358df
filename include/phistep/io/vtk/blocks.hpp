/// @file
/// The blocks and properties of a state as arrays of a VTK file; io/vtk.hpp is its face.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/core/version.hpp"
#include "phistep/io/csv.hpp"
#include "phistep/io/text.hpp"
#include "phistep/io/vtk/file.hpp"
#include "phistep/particles/particles.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep { inline namespace PHISTEP_ABI { namespace detail {

/// What all files have: the time, where it is known, and the precision.
struct VtkHead {
  std::optional<double> t;  ///< [time]
  bool single = false;
};

[[nodiscard]] inline VtkFile begin_vtk(std::string type, const std::string& attributes, const VtkHead& head) {
  VtkFile file{std::move(type), attributes, head.single};
  if (head.t) file.time(*head.t);
  return file;
}

/// A block as dim × N. @param dimensions  of a flat vector; 0: it is one particle
template <class Block>
[[nodiscard]] auto as_vectors(const Block& block, Index dimensions) {
  using Scalar = typename std::remove_cvref_t<Block>::Scalar;
  constexpr bool is_flat = std::remove_cvref_t<Block>::ColsAtCompileTime == 1;
  const Index rows = is_flat && dimensions > 0 ? dimensions : block.rows();
  if (rows > 3 || (is_flat && block.rows() % std::max<Index>(rows, 1) != 0))
    throw std::invalid_argument(
        "phistep: particles of a VTK file need positions dim x N with dim <= 3; a flat vector of " +
        std::to_string(block.rows()) + " numbers needs VtkPoints{.dimensions = 1, 2 or 3} that divides it");
  Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic> x(rows, rows == 0 ? 0 : block.size() / rows);
  for (Index j = 0; j < block.cols(); ++j)
    for (Index i = 0; i < block.rows(); ++i) {
      const Index k = i + block.rows() * j;
      x(k % rows, k / rows) = block(i, j);
    }
  return x;
}

/// The name of block k: "velocity", a state's own block_names, else as in tables (io/csv.hpp).
template <State S>
[[nodiscard]] std::string vtk_name(std::size_t k, bool of_field) {
  if (!of_field && Blocks<S>::drifts && k == 1) return "velocity";
  if constexpr (requires { S::block_names[k]; }) return std::string(S::block_names[k]);
  else return block_name<S>(k);
}

template <class Number, int dim, class... Extra>
void add_extra_blocks(VtkFile& file, const Particles<Number, dim, Extra...>& particles) {
  [[maybe_unused]] const auto add = [&file](const char* name, const auto& x) {
    file.numbers(name, x.cols(), x.rows(), [&x](Index i, Index c) { return x(c, i); });
  };
  (add(Extra::name, Extra::block(particles)), ...);
}

/// All that n particles have beside their positions.
template <State S>
void add_particle_arrays(VtkFile& file, const S& state, Index n, Index dimensions) {
  file.vectors("velocity", as_vectors(std::get<1>(Blocks<S>::all(state)), dimensions));
  if constexpr (requires { state.body(); }) {
    const auto& body = state.body();
    const auto list = [&](const char* name, const auto& values) {
      if (static_cast<Index>(values.size()) == n && n > 0)
        file.numbers(name, n, 1, [&values](Index i, Index) {
          if constexpr (requires { values.rows(); }) return values[i];
          else return values[static_cast<std::size_t>(i)];
        });
    };
    list("id", body.id), list("mass", body.mass), list("radius", body.radius), list("type", body.type);
    list("charge", body.charge), list("heat_capacity", body.heat_capacity), list("still", body.still);
    add_extra_blocks(file, state);
  } else {
    for_each_block(
        [&](auto k, const auto& block) {
          if constexpr (k() >= 2) {
            const Index parts = n == 0 ? 0 : block.size() / n;
            if (parts * n != block.size())
              throw std::invalid_argument("phistep: a block of " + std::to_string(block.size()) + " numbers for " +
                                          std::to_string(n) + " particles of a VTK file");
            file.numbers(vtk_name<S>(k(), false), n, parts, [&](Index i, Index c) {
              const Index at = parts * i + c;
              return block(at % block.rows(), at / block.rows());
            });
          }
        },
        Blocks<S>::all(state));
  }
}

/// The state's blocks as fields with n values each.
/// @throws std::invalid_argument where n or the names don't fit the state
template <State S>
void add_fields(VtkFile& file, const S& state, Index n, const std::vector<std::string>& names) {
  const auto blocks = Blocks<S>::all(state);
  constexpr std::size_t count = std::tuple_size_v<std::remove_cvref_t<decltype(blocks)>>;
  std::size_t fields = 0;
  for_each_block(
      [&](auto, const auto& block) {
        if (n < 1 || block.size() == 0 || block.size() % n != 0)
          throw std::invalid_argument("phistep: a state of " + std::to_string(block.size()) +
                                      " numbers for a VTK grid or mesh of " + std::to_string(n) + " values");
        fields += static_cast<std::size_t>(block.size() / n);
      },
      blocks);
  if (!names.empty() && names.size() != count && names.size() != fields)
    throw std::invalid_argument("phistep: " + std::to_string(names.size()) + " names for the " +
                                std::to_string(fields) + " fields of a VTK grid or mesh");
  std::size_t next = 0;
  for_each_block(
      [&](auto k, const auto& block) {
        const Index parts = block.size() / n;
        const bool by_columns = block.rows() == parts && block.cols() == n;
        const auto value = [&](Index i, Index c) {
          if (by_columns) return block(c, i);
          const Index at = n * c + i;
          return block(at % block.rows(), at / block.rows());
        };
        if (parts == 1 || names.size() != fields) {
          file.numbers(names.empty() ? vtk_name<S>(k(), true) : names[next], n, parts, value);
          next += 1;
        } else {
          for (Index part = 0; part < parts; ++part)
            file.numbers(names[next++], n, 1, [&](Index i, Index) { return value(i, part); });
        }
      },
      blocks);
}

/// A column of one's own: a value or a column of values an item, or a function of (t, state) that returns them.
template <class Content, State S>
void add_column(VtkFile& file, Index n, const NamedColumn<Content>& column, const VtkHead& head, const S& state) {
  const auto add = [&](const auto& values) {
    constexpr bool is_flat = std::remove_cvref_t<decltype(values)>::IsVectorAtCompileTime;
    const Index items = is_flat ? values.size() : values.cols();
    if (items != n)
      throw std::invalid_argument("phistep: column " + column.name + " of a VTK file has " + std::to_string(items) +
                                  " values for " + std::to_string(n) + " points or cells");
    if constexpr (is_flat) file.numbers(column.name, n, 1, [&](Index i, Index) { return values[i]; });
    else file.numbers(column.name, n, values.rows(), [&](Index i, Index c) { return values(c, i); });
  };
  if constexpr (requires { column.content.cols(); }) {
    add(column.content);
  } else {
    static_assert(std::is_invocable_v<const Content&, double, const S&>,
                  "phistep: a column of a VTK file is an Eigen vector or matrix, or a function of (t, state) that "
                  "returns one");
    // Kept as a plain vector: an expression may refer to what the function no longer has.
    const typename std::remove_cvref_t<std::invoke_result_t<const Content&, double, const S&>>::PlainObject values =
        column.content(head.t.value_or(std::nan("")), state);
    add(values);
  }
}

}}}  // namespace phistep::PHISTEP_ABI::detail
