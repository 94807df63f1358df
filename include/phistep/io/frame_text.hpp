/// @file
/// Frames in the extended XYZ format as text; io/extended_xyz.hpp is its face.
#pragma once

#include <Eigen/Core>

#include <limits>
#include <ostream>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "phistep/core/version.hpp"
#include "phistep/io/text.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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
    // Lower side + length may be rounded: then the upper side is written as well.
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

}}  // namespace phistep::PHISTEP_ABI
