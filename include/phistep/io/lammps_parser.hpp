/// @file
/// Reads a LAMMPS data file, section by section; io/lammps_data.hpp is its face.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <istream>
#include <iterator>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "phistep/core/version.hpp"
#include "phistep/io/lammps_header.hpp"
#include "phistep/particles/particles.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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
  using Scalar = typename P::Scalar;
  static constexpr int dim = P::dimensions;

  P atoms;  ///< by increasing id; positions as in the file, masses from Masses or from densities, else 1
  std::vector<Bond> bonds;                          ///< section Bonds
  std::vector<Scalar> type_mass;                    ///< [mass] of each type: section Masses, or empty
  std::vector<std::int64_t> molecule;               ///< of each atom, for styles that have it
  Eigen::Matrix<int, dim, Eigen::Dynamic> image{};  ///< how often each atom left through the box's sides, or empty

  /// Puts atoms where they would be without the box's sides.
  void unwrap() {
    const auto length = atoms.box().length();
    for (Eigen::Index j = 0; j < image.cols(); ++j)
      for (int a = 0; a < dim; ++a) atoms.r(a, j) += static_cast<Scalar>(image(a, j)) * length[a];
    image.resize(dim, 0);
  }
};

/// One pass through a file.
template <class P>
class LammpsParser {
  using Scalar = typename P::Scalar;
  static constexpr int dim = P::dimensions;
  static constexpr bool spins = P::template has<Spin>;
  struct Row {
    std::int64_t id, molecule, line;
    int type;
    Scalar charge, diameter, density;
    std::array<Scalar, 3> x, v, omega;
    std::array<int, 3> image;
    bool has_velocity;
  };
  struct TypeMass {
    std::size_t type;
    Scalar mass;
    std::int64_t line;
  };

 public:
  LammpsParser(std::istream& in, std::string name, const LammpsOptions& options)
      : text_{in, std::move(name)}, options_{options} {}

  [[nodiscard]] LammpsData<P> read() {
    if (!text_.next_line()) text_.fail("the file is empty");  // LAMMPS skips the first line, whatever it says
    bool more = text_.next();
    while (more && !text_.starts_section()) header_.take(text_), more = text_.next();
    if (header_.atoms < 0) text_.fail("the header should say how many atoms there are: \"32000 atoms\"");
    while (more) more = section(std::string(text_.rest()));
    if (!has_atoms_ && header_.atoms > 0) text_.fail("the section Atoms is missing");
    return result();
  }

 private:
  /// Reads one section and the line after it; false at the end of the file.
  bool section(const std::string& name) {
    if (name == "Masses") {
      const bool more = each(name, header_.types, [this] { mass(); });
      sort_masses();
      return more;
    }
    if (name == "Atoms") {
      if (has_atoms_) text_.fail("a second section Atoms");
      has_atoms_ = true;
      choose_style();
      const bool more = each(name, header_.atoms, [this] { atom(); });
      sort();
      return more;
    }
    if (name == "Velocities" || name == "Bonds") {
      if (!has_atoms_) text_.fail("the section " + name + " comes before Atoms");
      if (name == "Bonds") return each(name, header_.bonds, [this] { bond(); });
      return each(name, header_.atoms, [this] { velocity(); });
    }
    static constexpr std::string_view others[] = {"Angles", "Dihedrals", "Impropers", "Ellipsoids",
                                                  "Lines",  "Triangles", "Bodies"};
    if (std::find(std::begin(others), std::end(others), name) == std::end(others) && !name.ends_with(" Coeffs") &&
        !name.ends_with(" Type Labels"))
      text_.fail("\"" + name + "\" is no section of a LAMMPS data file");
    bool more = text_.next();
    while (more && !text_.starts_section()) more = text_.next();
    return more;
  }
  bool each(const std::string& name, std::int64_t lines, auto&& read_line) {
    for (std::int64_t k = 0; k < lines; ++k) {
      if (!text_.next() || text_.starts_section())
        text_.fail(name + " ends after " + std::to_string(k) + " of " + std::to_string(lines) + " lines");
      read_line();
      text_.end_line();
    }
    if (!text_.next()) return false;
    if (!text_.starts_section()) text_.fail(name + " has more than the " + std::to_string(lines) + " lines announced");
    return true;
  }

  void mass() {
    const std::size_t type = type_index(header_.types, "type");
    masses_.push_back({type, positive("mass"), text_.line_number()});
  }
  /// Memory is taken only now: a header may announce any number of types, but these lines were read.
  void sort_masses() {
    type_mass_.resize(static_cast<std::size_t>(header_.types), Scalar{0});
    for (const TypeMass& entry : masses_) {
      if (type_mass_[entry.type] > 0) text_.fail_at(entry.line, "a second mass of this type");
      type_mass_[entry.type] = entry.mass;
    }
    masses_.clear();
  }
  void choose_style() {
    std::string style = options_.style;
    const std::string_view said = text_.first_of_comment();
    if (style.empty()) style = said;
    if (style != said && !said.empty()) text_.fail("the file says style " + std::string(said) + ", not " + style);
    // i id, t type, m molecule, q charge, d diameter, r density, x position
    if (style == "atomic") columns_ = "itx";
    else if (style == "charge") columns_ = "itqx";
    else if (style == "bond" || style == "angle" || style == "molecular") columns_ = "imtx";
    else if (style == "full") columns_ = "imtqx";
    else if (style == "sphere") columns_ = "itdrx";
    else if (!style.empty())
      text_.fail("atom style " + style + " isn't known here: atomic, charge, sphere, bond, angle, molecular, full are");
  }
  void atom() {
    if (columns_.empty()) guess_style();
    Row row{};
    row.line = text_.line_number();
    for (const char column : columns_)
      if (column == 'i') row.id = text_.template number<std::int64_t>("id");
      else if (column == 't') row.type = static_cast<int>(type_index(header_.types, "type"));
      else if (column == 'm') row.molecule = text_.template number<std::int64_t>("molecule");
      else if (column == 'q') row.charge = text_.template number<Scalar>("charge");
      else if (column == 'd') row.diameter = positive("diameter");
      else if (column == 'r') row.density = positive("density");
      else vector(row.x, "coordinate");
    if (row.id <= 0 || row.id >= largest_id) text_.fail("an id must be > 0 and < 2^62");
    if (row.diameter > 0 && !(std::isfinite(mass_of(row)) && mass_of(row) > 0))
      text_.fail("a mass of 4/3 pi r^3 density that numbers can't hold");
    flat(row.x[2], "coordinate");
    if (!text_.skip_blanks()) {
      for (int& image : row.image) image = text_.template number<int>("image flag");
      has_images_ = true;
    }
    rows_.push_back(row);
  }
  [[nodiscard]] static Scalar mass_of(const Row& row) {
    const Scalar radius = row.diameter / 2;
    return Scalar{4} / 3 * std::numbers::pi_v<Scalar> * radius * radius * radius * row.density;
  }
  /// Only atomic lines have a length of their own.
  void guess_style() {
    const std::string_view line = text_.rest();
    int words = 0;
    while (!text_.word().empty()) ++words;
    text_.set_rest(line);
    if (words != 5 && words != 8)
      text_.fail("which atom style has " + std::to_string(words) +
                 " columns? Say it: \"Atoms # sphere\" in the file, or read_lammps_data(…, {.style = \"sphere\"})");
    columns_ = "itx";
  }
  void sort() {
    const auto before = [](const Row& a, const Row& b) { return a.id < b.id; };
    if (!std::is_sorted(rows_.begin(), rows_.end(), before)) std::stable_sort(rows_.begin(), rows_.end(), before);
    for (std::size_t k = 1; k < rows_.size(); ++k)
      if (rows_[k].id == rows_[k - 1].id) text_.fail_at(rows_[k].line, "a second atom " + std::to_string(rows_[k].id));
  }
  [[nodiscard]] Row& row_of(std::int64_t id) {
    // Ids mostly are 1 … N.
    const auto guess = static_cast<std::size_t>(id) - 1;
    if (guess < rows_.size() && rows_[guess].id == id) return rows_[guess];
    const auto found =
        std::lower_bound(rows_.begin(), rows_.end(), id, [](const Row& row, std::int64_t x) { return row.id < x; });
    if (found == rows_.end() || found->id != id) text_.fail("there is no atom " + std::to_string(id));
    return *found;
  }
  void velocity() {
    Row& row = row_of(text_.template number<std::int64_t>("id"));
    if (std::exchange(row.has_velocity, true)) text_.fail("a second velocity of atom " + std::to_string(row.id));
    vector(row.v, "velocity");
    flat(row.v[2], "velocity");
    if (columns_.find('d') != columns_.npos) vector(row.omega, "angular velocity");
  }
  void bond() {
    (void)text_.template number<std::int64_t>("id");
    const auto type = static_cast<int>(type_index(header_.bond_types, "bond type"));
    const auto i = &row_of(text_.template number<std::int64_t>("atom")) - rows_.data();
    const auto j = &row_of(text_.template number<std::int64_t>("atom")) - rows_.data();
    if (i == j) text_.fail("a bond of an atom with itself");
    result_bonds_.push_back({i, j, type});
  }

  std::size_t type_index(std::int64_t types, const char* what) {
    const auto type = text_.template number<std::int64_t>(what);
    if (type < 1 || type > types)
      text_.fail(std::string(what) + " " + std::to_string(type) + " isn't one of 1 … " + std::to_string(types));
    return static_cast<std::size_t>(type - 1);
  }
  Scalar positive(const char* what) {
    const auto x = text_.template number<Scalar>(what);
    if (!(x > 0)) text_.fail(std::string(what) + " must be > 0");
    return x;
  }
  void vector(std::array<Scalar, 3>& x, const char* what) {
    for (Scalar& component : x) component = text_.template number<Scalar>(what);
  }
  void flat(Scalar z, const char* what) const {
    if (dim == 2 && z != 0) text_.fail(std::string("particles in the plane need 0 as their third ") + what);
  }

  LammpsData<P> result() {
    const auto n = static_cast<Eigen::Index>(rows_.size());
    typename P::Vectors r(dim, n), v(dim, n);
    typename P::Column mass(n), radius, charge;
    Eigen::VectorXi type(n);
    std::vector<std::int64_t> id, molecule;
    Eigen::Matrix<int, dim, Eigen::Dynamic> image(dim, has_images_ ? n : 0);
    const auto has = [this](char column) { return columns_.find(column) != columns_.npos; };
    if (has('d')) radius.resize(n);
    if (has('q')) charge.resize(n);
    for (Eigen::Index j = 0; j < n; ++j) {
      const Row& row = rows_[static_cast<std::size_t>(j)];
      for (int a = 0; a < dim; ++a) {
        r(a, j) = row.x[static_cast<std::size_t>(a)];
        v(a, j) = row.v[static_cast<std::size_t>(a)];
        if (has_images_) image(a, j) = row.image[static_cast<std::size_t>(a)];
      }
      type[j] = row.type;
      mass[j] = type_mass_.empty() ? Scalar{1} : type_mass_[static_cast<std::size_t>(row.type)];
      if (!(mass[j] > 0)) text_.fail("the section Masses has no mass of type " + std::to_string(row.type + 1));
      if (has('q')) charge[j] = row.charge;
      if (has('d')) {
        radius[j] = row.diameter / 2;
        mass[j] = mass_of(row);
      }
      id.push_back(row.id);
      if (has('m')) molecule.push_back(row.molecule);
    }
    P atoms{std::move(r), std::move(v)};
    atoms.set_mass(mass).set_type(type).set_radius(radius).set_charge(charge).set_id(std::move(id));
    if constexpr (spins)
      for (Eigen::Index j = 0; j < n; ++j)
        for (Eigen::Index a = 0; a < atoms.omega.rows(); ++a)
          atoms.omega(a, j) = rows_[static_cast<std::size_t>(j)].omega[static_cast<std::size_t>(dim == 3 ? a : 2)];
    Box<Scalar, dim> box;
    for (std::size_t a = 0; a < dim; ++a) {
      box.lower[static_cast<Eigen::Index>(a)] = header_.lower[a];
      box.upper[static_cast<Eigen::Index>(a)] = header_.upper[a];
      box.is_periodic[a] = options_.periodic[a];
    }
    atoms.set_box(box);
    return {std::move(atoms), std::move(result_bonds_), std::move(type_mass_), std::move(molecule), std::move(image)};
  }

  LammpsText text_;
  const LammpsOptions& options_;
  LammpsHeader<Scalar> header_;
  bool has_atoms_ = false, has_images_ = false;
  std::string columns_;
  std::vector<Row> rows_;
  std::vector<TypeMass> masses_;
  std::vector<Scalar> type_mass_;
  std::vector<typename LammpsData<P>::Bond> result_bonds_;
};

}}  // namespace phistep::PHISTEP_ABI
