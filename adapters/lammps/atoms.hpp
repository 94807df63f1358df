/// @file
/// LAMMPS' arrays as phistep sees them: which atoms of this rank move, where their numbers are, what they weigh.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include <phistep/in_place.hpp>

#include "atom.h"

namespace phistep_lammps {
using LAMMPS_NS::Atom;

/// The atoms of this rank that the fix moves.
struct Movers {
  const Atom* atom = nullptr;
  double ftm2v = 1;       // force × ftm2v = mass × velocity per time
  std::vector<int> some;  // their indices, where the group isn't all
  bool is_all = true;

  void find(int groupbit) {
    const int n = atom->nlocal;
    is_all = std::all_of(atom->mask, atom->mask + n, [groupbit](int mask) { return (mask & groupbit) != 0; });
    some.clear();
    if (is_all) return;
    for (int i = 0; i < n; ++i)
      if ((atom->mask[i] & groupbit) != 0) some.push_back(i);
  }
  [[nodiscard]] std::ptrdiff_t size() const { return is_all ? atom->nlocal : static_cast<std::ptrdiff_t>(some.size()); }
  [[nodiscard]] std::ptrdiff_t index(std::ptrdiff_t k) const { return is_all ? k : some[static_cast<std::size_t>(k)]; }
  /// Their rows of an array of LAMMPS, one after the other, and back.
  void gather(double* const* rows, double* to) const {
    for (std::ptrdiff_t k = 0; k < size(); ++k) std::copy_n(rows[index(k)], 3, to + 3 * k);
  }
  void scatter(const double* from, double* const* rows) const {
    for (std::ptrdiff_t k = 0; k < size(); ++k) std::copy_n(from + 3 * k, 3, rows[index(k)]);
  }
  [[nodiscard]] double mass(std::ptrdiff_t k) const {
    const std::ptrdiff_t i = index(k);
    return atom->rmass != nullptr ? atom->rmass[i] : atom->mass[atom->type[i]];
  }
};

/// i ↦ h/m_i of components.
struct InverseInertia {
  const double* all;
  double operator()(std::ptrdiff_t component) const { return all[component]; }
  template <int width>
  auto operator()(phistep::From<double, width> components) const {
    return components(all);
  }
};
/// The masses, or moments of inertia 2/5 m r², that LAMMPS' arrays hold now.
template <bool spins>
class Inertia {
 public:
  static constexpr phistep::Structure structure = phistep::Structure::diagonal;
  static constexpr bool is_matrix = false;

  explicit Inertia(const Movers& movers) : movers_{&movers} {}
  template <class Scalar, class Block>
  [[nodiscard]] Inertia bind(const Block& /*block*/) const {
    return *this;
  }
  /// Divided as LAMMPS does.
  [[nodiscard]] InverseInertia h_over_mass(double h) const {
    const auto n = static_cast<std::size_t>(movers_->size());
    const Atom& atom = *movers_->atom;
    inverse_.resize(3 * n);
    const double by = spins ? h * movers_->ftm2v / 0.4 : h * movers_->ftm2v;
    for (std::size_t k = 0; k < n; ++k) {
      const auto at = static_cast<std::ptrdiff_t>(k);
      double each = by / movers_->mass(at);
      if constexpr (spins) {
        const double radius = atom.radius[movers_->index(at)];
        each = by / (radius * radius * movers_->mass(at));
      }
      inverse_[3 * k] = inverse_[3 * k + 1] = inverse_[3 * k + 2] = each;
    }
    return {inverse_.data()};
  }
  [[nodiscard]] double operator[](std::ptrdiff_t component) const {
    const double m = movers_->mass(component / 3) / movers_->ftm2v;
    if constexpr (!spins) return m;
    const double radius = movers_->atom->radius[movers_->index(component / 3)];
    return 0.4 * radius * radius * m;
  }
  void subtract_product(const auto& x, auto&& out) const {
    for (std::ptrdiff_t i = 0; i < x.size(); ++i) out[i] -= (*this)[i] * x[i];
  }
  void add_product(auto&& x, auto& out) const {
    for (std::ptrdiff_t i = 0; i < out.size(); ++i) out.data()[i] += (*this)[i] * x(i);
  }
  void for_each_entry(std::ptrdiff_t n, auto&& f) const {
    for (std::ptrdiff_t i = 0; i < n; ++i) f(i, i, (*this)[i]);
  }

 private:
  const Movers* movers_;
  mutable std::vector<double> inverse_;
};
}  // namespace phistep_lammps
template <bool spins>
struct phistep::MassKind<phistep_lammps::Inertia<spins>> {
  using type = phistep_lammps::Inertia<spins>;
  static type make(const type& all) { return all; }
};

namespace phistep_lammps {
/// An array of LAMMPS, three numbers an atom: itself, or of a part of its atoms a copy.
class Rows {
 public:
  [[nodiscard]] auto take(const Movers& movers, double** all) {
    rows_ = all;
    const std::ptrdiff_t n = movers.size();
    if (movers.is_all) return phistep::places<3>(all[0], n, std::ptrdiff_t{3});
    copy_.resize(static_cast<std::size_t>(3 * n));
    movers.gather(all, copy_.data());
    return phistep::places<3>(copy_.data(), n, std::ptrdiff_t{3});
  }
  void give(const Movers& movers) {
    if (!movers.is_all) movers.scatter(copy_.data(), rows_);
  }

 private:
  double** rows_ = nullptr;
  std::vector<double> copy_;
};
using Places = decltype(std::declval<Rows&>().take(std::declval<const Movers&>(), nullptr));
}  // namespace phistep_lammps
