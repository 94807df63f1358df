/// @file
/// LAMMPS data files: `read_data` there, particles here.
///
///     phistep::Particles<double, 3> melt = phistep::read_lammps_data("melt.data").atoms;
///     auto data = phistep::read_lammps_data<phistep::Particles<double, 3, phistep::Spin>>("chute.data", {.style = "sphere"});
///     data.atoms, data.bonds, data.type_mass, …
///
/// Atom styles atomic, charge, sphere, bond (angle, molecular) and full; other sections are skipped, a tilted box is an error.
/// Source: docs.lammps.org/read_data.html. Types and bond types are those of the file less 1, units are the file's. A
/// compressed file: `zcat file.data.gz | program`, and read_lammps_data(std::cin). Needs std::from_chars for real numbers
/// (libstdc++ 11, MSVC; not libc++ before 20).
#pragma once

#include <phistep/particles/bodies/particles.hpp>

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <istream>
#include <iterator>
#include <numbers>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>
#include <vector>

namespace phistep {

/// What a data file leaves to the input script.
struct LammpsOptions {
  std::string style{};                             ///< of atoms, where the line "Atoms # style" doesn't say it
  std::array<bool, 3> periodic{true, true, true};  ///< `boundary p p p`
};

template <class P = Particles<double, 3>>
struct LammpsData {
  struct Bond {
    Eigen::Index i, j;  ///< columns of `atoms`
    int type;
  };
  P atoms;  ///< by increasing id; positions as in the file, masses from Masses or from densities, else 1
  std::vector<Bond> bonds{};                                  ///< section Bonds
  std::vector<typename P::Scalar> type_mass{};                ///< [mass] of each type: section Masses, or empty
  std::vector<std::int64_t> molecule{};                       ///< of each atom, for styles that have it
  Eigen::Matrix<int, P::dimensions, Eigen::Dynamic> image{};  ///< how often each left through the box's sides, or empty

  /// Puts atoms where they would be without the box's sides.
  void unwrap() {
    const auto length = atoms.box().length();
    for (Eigen::Index j = 0; j < image.cols(); ++j)
      atoms.r.col(j) += image.col(j).template cast<typename P::Scalar>().cwiseProduct(length);
    image.resize(P::dimensions, 0);
  }
};

/// One pass through a file. Every error is a std::runtime_error "phistep: NAME, line 12: …".
template <class P>
class LammpsReader {
  using Scalar = typename P::Scalar;
  static constexpr int dim = P::dimensions;
  using Vector = Eigen::Matrix<Scalar, 3, 1>;
  struct Row {
    std::int64_t id = 0, molecule = 0;
    int type = 0;
    Scalar charge = 0, diameter = 0, mass = 0;
    Vector x = Vector::Zero(), v = Vector::Zero(), omega = Vector::Zero();
    std::array<int, 3> image{};
  };

 public:
  LammpsReader(std::istream& in, std::string name, LammpsOptions options)
      : in_{in}, name_{std::move(name)}, style_{std::move(options.style)}, periodic_{options.periodic} {}

  [[nodiscard]] LammpsData<P> read() {
    ++line_;  // LAMMPS skips the first line, whatever it says
    if (!std::getline(in_, text_)) fail("the file is empty");
    bool more = next();
    while (more && !is_section()) header(), more = next();
    if (atoms_ < 0) fail("the header should say how many atoms there are: \"32000 atoms\"");
    while (more) {
      const std::string name(rest_);
      if (name == "Masses") each(name, types_, [this] { mass(); });
      else if (name == "Atoms") read_atoms();
      else if (name == "Velocities") each(name, atoms_, [this] { velocity(); });
      else if (name == "Bonds") each(name, bonds_, [this] { bond(); });
      while ((more = next()) && !is_section())
        if (name == "Masses" || name == "Atoms" || name == "Velocities" || name == "Bonds")
          fail(name + " has more lines than the header says");
    }
    if (columns_.empty() && atoms_ > 0) fail("the section Atoms is missing");
    return result();
  }

 private:
  [[noreturn]] void fail(const std::string& why) const {
    throw std::runtime_error("phistep: " + name_ + ", line " + std::to_string(line_) + ": " + why);
  }
  /// The next line that isn't blank, without its comment.
  bool next() {
    while (std::getline(in_, text_)) {
      ++line_;
      const std::size_t hash = std::min(text_.find('#'), text_.size());
      comment_ = std::string_view(text_).substr(std::min(hash + 1, text_.size()));
      rest_ = std::string_view(text_).substr(0, hash);
      rest_.remove_suffix(rest_.size() - (rest_.find_last_not_of(blanks) + 1));
      skip_blanks(rest_);
      if (!rest_.empty()) return true;
    }
    return false;
  }
  [[nodiscard]] bool is_section() const { return std::isalpha(static_cast<unsigned char>(rest_.front())) != 0; }
  static void skip_blanks(std::string_view& text) {
    text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  }
  static std::string_view word(std::string_view& text) {
    skip_blanks(text);
    const std::string_view found = text.substr(0, text.find_first_of(blanks));
    text.remove_prefix(found.size());
    return found;
  }
  template <class Number>
  Number number(const std::string& what) {
    const std::string_view text = word(rest_);
    if (text.empty()) fail("the line ends where " + what + " should be");
    Number x{};
    const char *const first = text.data() + (text.size() > 1 && text[0] == '+'), *const last =
                                                                                     text.data() + text.size();
    auto [end, error] = std::from_chars(first, last, x);
    if (error == std::errc::result_out_of_range && text.find("e-") != text.npos) x = 0, error = {};  // too small: 0
    if (error != std::errc{} || end != last || !std::isfinite(static_cast<double>(x)))
      fail(what + " should be a " + (std::is_integral_v<Number> ? "whole" : "finite") + " number, not \"" +
           std::string(text.substr(0, 40)) + '"');
    return x;
  }
  Scalar positive(const char* what) {
    const auto x = number<Scalar>(what);
    if (!(x > 0)) fail(std::string(what) + " must be > 0");
    return x;
  }
  int type(std::int64_t types, const char* what) {
    const auto k = number<std::int64_t>(what);
    if (k < 1 || k > types || k > (1 << 30))
      fail(std::string(what) + ' ' + std::to_string(k) + " isn't one of 1 … " + std::to_string(types));
    return static_cast<int>(k - 1);
  }
  Vector vector(const char* what, bool must_be_flat = true) {
    Vector x;
    for (Scalar& component : x) component = number<Scalar>(what);
    if (must_be_flat && dim == 2 && x[2] != 0)
      fail(std::string("particles in the plane need 0 as their third ") + what);
    return x;
  }
  /// Numbers, then words that say what they are; other words are skipped.
  void header() {
    static constexpr std::string_view sides[] = {"xlo xhi", "ylo yhi", "zlo zhi"};
    std::int64_t* const counts[] = {&atoms_, &types_, &bonds_, &bond_types_};
    static constexpr std::string_view names[] = {"atoms", "atom types", "bonds", "bond types"};
    std::string_view key = rest_;
    while (!key.empty() && std::isalpha(static_cast<unsigned char>(key.front())) == 0) word(key), skip_blanks(key);
    for (std::size_t k = 0; k < 4; ++k)
      if (key == names[k] && (*counts[k] = number<std::int64_t>(names[k].data())) < 0)
        fail("there can't be fewer than 0 " + std::string(key));
    for (Eigen::Index a = 0; a < 3; ++a)
      if (key == sides[a]) {
        lower_[a] = number<Scalar>("lower side"), upper_[a] = number<Scalar>("upper side");
        if (!(upper_[a] > lower_[a]) || !std::isfinite(upper_[a] - lower_[a]))
          fail("the box has no extent, or none that numbers hold: " + std::string(key));
      }
    for (int k = 0; k < 3 && key == "xy xz yz"; ++k)
      if (number<Scalar>("tilt") != 0) fail("a box with a tilt isn't known here");
  }
  void each(const std::string& name, std::int64_t lines, auto&& read_line) {
    if (columns_.empty() && name != "Masses" && name != "Atoms") fail("the section " + name + " comes before Atoms");
    for (std::int64_t k = 0; k < lines; ++k) {
      if (!next() || is_section())
        fail(name + " ends after " + std::to_string(k) + " of " + std::to_string(lines) + " lines");
      read_line();
      if (!rest_.empty()) fail("nothing should follow, but \"" + std::string(rest_.substr(0, 40)) + "\" does");
    }
  }
  void mass() {
    masses_.push_back({type(types_, "type"), positive("mass")});  // a header may announce any number of types
  }
  void read_atoms() {
    if (!columns_.empty()) fail("a second section Atoms");
    const std::string said(word(comment_));
    if (style_.empty()) style_ = said.empty() ? "atomic" : said;
    if (style_ != said && !said.empty()) fail("the file says style " + said + ", not " + style_);
    // i id, t type, m molecule, q charge, d diameter, r density, x position
    static constexpr std::pair<std::string_view, std::string_view> styles[] = {
        {"atomic", "itx"}, {"charge", "itqx"},  {"bond", "imtx"},     {"angle", "imtx"},
        {"full", "imtqx"}, {"sphere", "itdrx"}, {"molecular", "imtx"}};
    const auto known = std::ranges::find(styles, style_, &std::pair<std::string_view, std::string_view>::first);
    if (known == std::end(styles))
      fail("atom style " + style_ + " isn't known here: atomic, charge, sphere, bond, angle, molecular, full are");
    columns_ = known->second;
    each("Atoms", atoms_, [this] { atom(); });
    std::stable_sort(rows_.begin(), rows_.end(), [](const Row& a, const Row& b) { return a.id < b.id; });
    for (std::size_t k = 1; k < rows_.size(); ++k)
      if (rows_[k].id == rows_[k - 1].id) fail("a second atom " + std::to_string(rows_[k].id));
  }
  void atom() {
    Row row;
    for (const char column : columns_)
      if (column == 'i') row.id = number<std::int64_t>("id");
      else if (column == 't') row.type = type(types_, "type");
      else if (column == 'm') row.molecule = number<std::int64_t>("molecule");
      else if (column == 'q') row.charge = number<Scalar>("charge");
      else if (column == 'd') row.diameter = positive("diameter");
      else if (column == 'r') {
        const Scalar r = row.diameter / 2;
        row.mass = Scalar{4} / 3 * std::numbers::pi_v<Scalar> * r * r * r * positive("density");
        if (!std::isfinite(row.mass) || !(row.mass > 0)) fail("a mass of 4/3 pi r^3 density that numbers can't hold");
      } else row.x = vector("coordinate");
    if (row.id <= 0 || row.id >= (std::int64_t{1} << 62)) fail("an id must be > 0 and < 2^62");
    for (std::size_t a = 0; a < 3 && (a > 0 || !rest_.empty()); ++a)
      row.image[a] = number<int>("image flag"), has_images_ = true;
    rows_.push_back(row);
  }
  [[nodiscard]] Row& row_of(std::int64_t id) {
    const auto found = std::ranges::lower_bound(rows_, id, {}, &Row::id);
    if (found == rows_.end() || found->id != id) fail("there is no atom " + std::to_string(id));
    return *found;
  }
  void velocity() {
    Row& row = row_of(number<std::int64_t>("id"));
    row.v = vector("velocity");
    if (columns_.find('d') != columns_.npos) row.omega = vector("angular velocity", false);
  }
  void bond() {
    (void)number<std::int64_t>("id");
    const int kind = type(bond_types_, "bond type");
    const auto i = &row_of(number<std::int64_t>("atom")) - rows_.data();
    const auto j = &row_of(number<std::int64_t>("atom")) - rows_.data();
    if (i == j) fail("a bond of an atom with itself");
    data_.bonds.push_back({i, j, kind});
  }

  LammpsData<P> result() {
    const auto n = static_cast<Eigen::Index>(rows_.size());
    const auto has = [this](char column) { return columns_.find(column) != columns_.npos; };
    if (!masses_.empty()) data_.type_mass.resize(static_cast<std::size_t>(types_), Scalar{0});
    for (const auto& [kind, m] : masses_) data_.type_mass[static_cast<std::size_t>(kind)] = m;
    typename P::Vectors r(dim, n), v(dim, n);
    typename P::Column mass(n), radius(has('d') ? n : 0), charge(has('q') ? n : 0);
    Eigen::VectorXi kinds(n);
    std::vector<std::int64_t> id;
    data_.image.resize(dim, has_images_ ? n : 0);
    for (Eigen::Index j = 0; j < n; ++j) {
      const Row& row = rows_[static_cast<std::size_t>(j)];
      r.col(j) = row.x.template head<dim>(), v.col(j) = row.v.template head<dim>();
      id.push_back(row.id), kinds[j] = row.type;
      mass[j] = has('d') ? row.mass : masses_.empty() ? 1 : data_.type_mass[static_cast<std::size_t>(row.type)];
      if (!(mass[j] > 0)) fail("the section Masses has no mass of type " + std::to_string(row.type + 1));
      if (has('q')) charge[j] = row.charge;
      if (has('d')) radius[j] = row.diameter / 2;
      if (has('m')) data_.molecule.push_back(row.molecule);
      for (int a = 0; a < dim && has_images_; ++a) data_.image(a, j) = row.image[static_cast<std::size_t>(a)];
    }
    data_.atoms = P{std::move(r), std::move(v)};
    data_.atoms.set_mass(mass).set_type(kinds).set_radius(radius).set_charge(charge).set_id(std::move(id));
    if constexpr (P::template has<Spin>)
      for (Eigen::Index j = 0; j < n; ++j)
        data_.atoms.omega.col(j) = rows_[static_cast<std::size_t>(j)].omega.template tail < dim == 3 ? 3 : 1 > ();
    Box<Scalar, dim> box;
    box.lower = lower_.template head<dim>(), box.upper = upper_.template head<dim>();
    std::copy_n(periodic_.begin(), dim, box.is_periodic.begin());
    data_.atoms.set_box(box);
    return std::move(data_);
  }

  static constexpr const char* blanks = " \t\r\v\f";
  std::istream& in_;
  std::string name_, text_, style_, columns_;
  std::string_view rest_, comment_;
  std::array<bool, 3> periodic_;
  std::int64_t line_ = 0, atoms_ = -1, types_ = 0, bonds_ = 0, bond_types_ = 0;
  Vector lower_ = Vector::Constant(-0.5), upper_ = Vector::Constant(0.5);  // LAMMPS' own
  bool has_images_ = false;
  std::vector<Row> rows_;
  std::vector<std::pair<int, Scalar>> masses_;
  LammpsData<P> data_{};
};

/// What a LAMMPS data file holds: particles, box, bonds, masses of types.
/// @param name  of the stream, for errors
/// @throws std::runtime_error that names the line, where the text isn't a LAMMPS data file of a known style
template <class P = Particles<double, 3>>
[[nodiscard]] LammpsData<P> read_lammps_data(std::istream& in, LammpsOptions options = {},
                                             std::string name = "LAMMPS data") {
  return LammpsReader<P>{in, std::move(name), std::move(options)}.read();
}
/// The same from the file of this name.
/// @throws std::runtime_error where it cannot be opened, or its text is wrong
template <class P = Particles<double, 3>>
[[nodiscard]] LammpsData<P> read_lammps_data(const std::string& path, LammpsOptions options = {}) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error("phistep: cannot open " + path);
  return read_lammps_data<P>(in, std::move(options), path);
}

}  // namespace phistep
