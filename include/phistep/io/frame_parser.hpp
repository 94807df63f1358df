/// @file
/// One frame of an extended XYZ file as Particles; io/extended_xyz_reader.hpp is its face.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "phistep/core/version.hpp"
#include "phistep/io/text_reader.hpp"
#include "phistep/particles/particles.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The columns and the second line of one frame.
template <class P>
class FrameParser {
  using Scalar = typename P::Scalar;
  static constexpr int dim = P::dimensions;
  static constexpr bool spins = P::template has<Spin>, warms = P::template has<Temperature>;
  using Values = std::vector<Scalar>;
  /// Where a column goes: numbers, whole numbers, species, or nowhere.
  struct Target {
    Values* numbers = nullptr;
    std::vector<std::int64_t>* whole = nullptr;
    bool is_species = false, must_be_positive = false;
    int width = 1, kept = 1;
    std::string name;
  };

 public:
  FrameParser(TextReader& text, std::vector<std::string>& species) : text_{text}, species_{species} {}

  [[nodiscard]] double time() const { return time_; }

  [[nodiscard]] P read(std::int64_t n) {
    if (!text_.next_line()) text_.fail("the file ends where a frame's second line should be");
    const std::int64_t head = text_.line_number();
    about(std::string(text_.rest()));
    for (std::int64_t k = 0; k < n; ++k) {
      if (!text_.next_line())
        text_.fail("the file ends after " + std::to_string(k) + " of " + std::to_string(n) + " particles");
      for (const Target& column : columns_) particle(column);
      text_.end_line();
    }
    try {
      return build(static_cast<Eigen::Index>(n));
    } catch (const std::invalid_argument& error) {  // what no line shows by itself: two equal ids
      text_.fail_at(head, error.what());
    }
  }

 private:
  /// key=value, key="a value", and words, which are ignored.
  void about(std::string_view line) {
    std::string properties = "species:S:1:pos:R:3", lattice, origin, upper, pbc;
    while (!line.empty()) {
      const auto from = line.find_first_not_of(" \t");
      if (from == line.npos) break;
      line.remove_prefix(from);
      const auto end = line.find_first_of("= \t");
      if (end == line.npos || line[end] != '=') {
        line.remove_prefix(std::min(end, line.size()));
        continue;
      }
      const std::string_view key = line.substr(0, end);
      line.remove_prefix(end + 1);
      std::string_view value = line.substr(0, line.find_first_of(" \t"));
      if (!line.empty() && (line[0] == '"' || line[0] == '\'' || line[0] == '{')) {
        const char close = line[0] == '{' ? '}' : line[0];
        const auto last = line.find(close, 1);
        if (last == line.npos) text_.fail("the value of " + std::string(key) + " has no end");
        value = line.substr(1, last - 1);
        line.remove_prefix(last + 1);
      } else {
        line.remove_prefix(value.size());
      }
      if (key == "Properties") properties = value;
      else if (key == "Lattice") lattice = value;
      else if (key == "Origin") origin = value;
      else if (key == "Upper") upper = value;
      else if (key == "pbc") pbc = value;
      else if (key == "Time" || key == "time") time_ = text_.as_number<double>(value, "Time");
      else if (key == "inertia_factor" && spins) factor_ = text_.as_number<Scalar>(value, "inertia_factor");
    }
    if (!(factor_ > 0)) text_.fail("inertia_factor must be > 0");
    read_box(lattice, origin, upper, pbc);
    read_properties(properties);
  }
  /// Upper is our own: the other side of the box, where Origin + Lattice is not quite it.
  void read_box(const std::string& lattice, const std::string& origin, const std::string& sides,
                const std::string& pbc) {
    std::array<double, 3> lower{}, upper{};
    const auto read_three = [this](const std::string& from, std::array<double, 3>& to, const char* what) {
      text_.set_rest(from);
      for (double& x : to) x = text_.template number<double>(what);
      text_.end_line();
    };
    if (!origin.empty()) read_three(origin, lower, "Origin");
    if (!sides.empty()) read_three(sides, upper, "Upper");
    std::array<bool, 3> periodic{!lattice.empty(), !lattice.empty(), !lattice.empty()};
    if (!pbc.empty()) {
      text_.set_rest(pbc);
      for (bool& repeats : periodic) {
        const std::string_view word = text_.word();
        if (word == "T" || word == "True" || word == "true" || word == "1") repeats = true;
        else if (word == "F" || word == "False" || word == "false" || word == "0") repeats = false;
        else text_.fail("pbc should be three of T and F");
      }
      text_.end_line();
    }
    if (lattice.empty()) {
      for (const bool repeats : periodic)
        if (repeats) text_.fail("pbc without a Lattice");
      return;
    }
    text_.set_rest(lattice);
    for (int k = 0; k < 9; ++k) {
      const auto x = text_.template number<double>("Lattice");
      if (k % 4 != 0 && x != 0) text_.fail("only a box along the axes is known here: a leaning Lattice");
      const int a = k / 4;
      if (k % 4 != 0 || a >= dim) continue;
      const auto axis = static_cast<std::size_t>(a);
      box_.is_periodic[axis] = periodic[axis];
      box_.lower[a] = static_cast<Scalar>(lower[axis]);
      box_.upper[a] = static_cast<Scalar>(sides.empty() ? lower[axis] + x : upper[axis]);
      if (!(box_.upper[a] > box_.lower[a]) || !std::isfinite(box_.upper[a] - box_.lower[a]))
        text_.fail("the Lattice has no extent along an axis, or none that numbers hold");
    }
    text_.end_line();
  }

  /// name:type:width, one after the other.
  void read_properties(std::string_view all) {
    const auto next = [&all] {
      const auto colon = all.find(':');
      const std::string_view part = all.substr(0, colon);
      all.remove_prefix(colon == all.npos ? all.size() : colon + 1);
      return part;
    };
    while (!all.empty()) {
      const std::string name{next()}, kind{next()};
      const int width = text_.template as_number<int>(next(), "the width of a property");
      if (name.empty() || width < 1 || width > 1000 || (kind != "S" && kind != "R" && kind != "I" && kind != "L"))
        text_.fail("Properties should be name:type:width with the types S, R, I, L, at \"" + name + '"');
      for (const Target& column : columns_)
        if (column.name == name) text_.fail("Properties has " + name + " twice");
      Target column = destination(name);
      column.name = name;
      const bool numeric = kind == "R" || kind == "I";
      if ((column.numbers != nullptr && !numeric) || (column.whole != nullptr && kind != "I") ||
          (column.is_species && kind != "S"))
        text_.fail("the property " + name + " can't be of type " + kind);
      if (width < column.kept)
        text_.fail("the property " + name + " needs " + std::to_string(column.kept) + " columns");
      column.width = width;
      columns_.push_back(std::move(column));
    }
    if (std::none_of(columns_.begin(), columns_.end(), [](const Target& column) { return column.name == "pos"; }))
      text_.fail("Properties has no positions: pos:R:3");
  }
  [[nodiscard]] Target destination(const std::string& name) {
    const auto numbers = [](Values& to, int kept = 1, bool positive = false) {
      Target column;
      column.numbers = &to, column.kept = kept, column.must_be_positive = positive;
      return column;
    };
    Target column;
    if (name == "pos") return numbers(r_, dim);
    if (name == "velo" || name == "vel" || name == "velocities") return numbers(v_, dim);
    if (name == "mass" || name == "masses") return numbers(mass_, 1, true);
    if (name == "radius") return numbers(radius_, 1, true);
    if (name == "charge" || name == "initial_charges") return numbers(charge_);
    if (name == "heat_capacity") return numbers(capacity_, 1, true);
    if (name == "omega" && spins) return numbers(omega_, dim == 3 ? 3 : 1);
    if (name == "temperature" && warms) return numbers(temperature_);
    if (name == "id") column.whole = &id_;
    if (name == "type_index") column.whole = &type_;
    if (name == "still") column.whole = &still_;
    if (name == "species") column.is_species = true;
    return column;
  }

  void particle(const Target& column) {
    for (int a = 0; a < column.width; ++a) {
      const char* what = column.name.c_str();
      if (column.numbers != nullptr && (a < column.kept || column.numbers == &r_ || column.numbers == &v_)) {
        const auto x = text_.template number<Scalar>(what);
        if (column.must_be_positive && !(x > 0)) text_.fail(column.name + " must be > 0");
        if (a < column.kept) column.numbers->push_back(x);
        else if (x != 0) text_.fail("particles in the plane need 0 as the third number of " + column.name);
      } else if (column.whole != nullptr && a == 0) {
        const auto x = text_.template number<std::int64_t>(what);
        if (column.whole != &id_ && (x < 0 || x > std::numeric_limits<int>::max()))
          text_.fail(column.name + " can't be " + std::to_string(x));
        column.whole->push_back(column.whole == &still_ ? x != 0 : x);
      } else {
        const std::string_view word = text_.word();
        if (word.empty()) text_.fail("the line ends where " + column.name + " should be");
        if (column.is_species && a == 0) kind_.push_back(index_of(word));
      }
    }
  }
  [[nodiscard]] int index_of(std::string_view name) {
    if (!kind_.empty() && species_[static_cast<std::size_t>(kind_.back())] == name) return kind_.back();
    const auto found = std::find(species_.begin(), species_.end(), name);
    if (found != species_.end()) return static_cast<int>(found - species_.begin());
    species_.emplace_back(name);
    return static_cast<int>(species_.size() - 1);
  }

  [[nodiscard]] P build(Eigen::Index n) const {
    using Column = typename P::Column;
    const auto block = [n](const Values& from, Eigen::Index rows) {
      using Block = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
      return from.empty() ? Block(Block::Zero(rows, n)) : Block(Eigen::Map<const Block>(from.data(), rows, n));
    };
    const auto values = [](const Values& from) {
      return Column(Eigen::Map<const Column>(from.data(), static_cast<Eigen::Index>(from.size())));
    };
    P particles{block(r_, dim), block(v_, dim)};
    if (!mass_.empty()) particles.set_mass(values(mass_));
    particles.set_radius(values(radius_)).set_charge(values(charge_)).set_heat_capacity(values(capacity_));
    Eigen::VectorXi type(static_cast<Eigen::Index>(type_.empty() && species_.size() > 1 ? kind_.size() : type_.size()));
    for (Eigen::Index j = 0; j < type.size(); ++j) {
      const auto k = static_cast<std::size_t>(j);
      type[j] = type_.empty() ? kind_[k] : static_cast<int>(type_[k]);
    }
    particles.set_type(type).set_box(box_).set_inertia_factor(factor_);
    particles.set_still({still_.begin(), still_.end()});
    if (!id_.empty()) particles.set_id(id_);
    if constexpr (spins) particles.omega = block(omega_, particles.omega.rows());
    if constexpr (warms) particles.temperature = block(temperature_, 1);
    return particles;
  }

  TextReader& text_;
  std::vector<std::string>& species_;
  std::vector<Target> columns_;
  Values r_, v_, mass_, radius_, charge_, capacity_, omega_, temperature_;
  std::vector<std::int64_t> id_, type_, still_;
  std::vector<int> kind_;
  Box<Scalar, dim> box_;
  Scalar factor_ = Scalar{2} / Scalar{5};
  double time_ = std::numeric_limits<double>::quiet_NaN();
};

}}  // namespace phistep::PHISTEP_ABI
