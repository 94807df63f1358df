/// @file
/// Many bodies: positions, velocities, masses and other properties.
///
///     Particles<double, 3> atoms{positions};                    // dim × N, one column a particle
///     atoms.set_mass(39.95).set_box(Box<double, 3>::periodic(lower, upper));
///
///     Particles<double, 3, Spin> grains{positions};             // with spins: a block more in state and force
///     grains.set_mass(masses).set_radius(radii).set_type(types);
///
/// Particles stay in the order in which they were given. Properties are set by functions, so that steppers notice the change.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/machine/memory.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/particles/bodies/body.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <class Extra, class Scalar, int dim>
using ExtraNumbers = Eigen::Matrix<Scalar, Extra::rows(dim), Eigen::Dynamic>;

/// What a force sees of particles.
template <class Scalar, int dim, class Mass, class... Extra>
struct ParticleView : Extra::template Block<const ExtraNumbers<Extra, Scalar, dim>&>... {
  using Vectors = Eigen::Matrix<Scalar, dim, Eigen::Dynamic>;
  const Vectors& r;               ///< positions [length], dim × N, not wrapped
  const Vectors& v;               ///< velocities [length/time], dim × N
  const Mass& mass;               ///< as in any motion's view
  const Body<Scalar, dim>& body;  ///< masses, radii, types, charges, the box
};

/// A motion of N particles: positions r and velocities v, dim × N, and what each body has: a mass, and, where it is set, a
/// radius, a type, a charge; the box around them.
/// @tparam dim    2 or 3
/// @tparam Extra  Spin, Temperature: blocks that are integrated beside r and v
template <class Number, int dim, class... Extra>
class Particles : public Extra::template Block<ExtraNumbers<Extra, Number, dim>>... {
  static_assert(dim == 2 || dim == 3, "phistep: particles live in 2 or 3 dimensions");
  static_assert(std::floating_point<Number>);
  using Properties = Body<Number, dim>;

 public:
  using Scalar = Number;
  using Vector = Eigen::Matrix<Scalar, dim, 1>;
  using Vectors = Eigen::Matrix<Scalar, dim, Eigen::Dynamic>;
  using Column = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Plain = Particles;
  static constexpr int dimensions = dim;
  static constexpr bool drifts = true;
  template <class Feature>
  static constexpr bool has = (std::is_same_v<Feature, Extra> || ...);

  Vectors r;  ///< positions [length], one column a particle
  Vectors v;  ///< velocities [length/time]

  static auto blocks(auto& y) { return std::tie(y.r, y.v, Extra::block(y)...); }
  struct Rate : Extra::template RateBlock<ExtraNumbers<Extra, Scalar, dim>>... {
    Vectors force;  ///< [force]
    static auto blocks(auto& psi) { return std::tie(psi.force, Extra::rate(psi)...); }
  };
  template <class Masses>
  static auto view(const Particles& y, const Masses& masses) {
    return ParticleView<Scalar, dim, std::tuple_element_t<0, Masses>, Extra...>{
        {Extra::block(y)}..., y.r, y.v, std::get<0>(masses), y.body()};
  }
  /// The masses that a stepper uses where it is given none.
  /// @throws std::invalid_argument where r, v and the properties are not of one number of particles
  [[nodiscard]] static auto masses(const Particles& y) {
    const Properties& body = y.body();
    for_each_block(
        [&body](auto, const auto& block) {
          if (block.cols() != body.size())
            throw std::invalid_argument("phistep: " + std::to_string(block.cols()) + " columns of a block for " +
                                        std::to_string(body.size()) +
                                        " particles: use add(…) and erase(…) to change their number");
        },
        blocks(y));
    return std::tuple{ParticleMasses<Scalar, dim>{body.mass, body.still}, Extra::masses(body)...};
  }
  /// A copy of the blocks is a copy of particles with the same properties.
  static void share_properties(Particles& to, const Particles& from) {
    if (to.body_ != from.body_) to.body_ = from.body_;
  }
  [[nodiscard]] static bool same_properties(const Particles& a, const Particles& b) { return a.body_ == b.body_; }

  Particles() : Particles(Vectors(dim, 0)) {}
  /// At rest, of mass 1, in an open box.
  explicit Particles(Vectors positions) : Particles{positions, Vectors::Zero(dim, positions.cols())} {}
  /// @throws std::invalid_argument where the numbers of columns differ
  Particles(Vectors positions, Vectors velocities) : r(std::move(positions)), v(std::move(velocities)) {
    if (r.cols() != v.cols())
      throw std::invalid_argument("phistep: " + std::to_string(r.cols()) + " positions and " +
                                  std::to_string(v.cols()) + " velocities");
    (Extra::block(*this).setZero(Extra::block(*this).rows(), r.cols()), ...);
    Properties body;
    body.mass.setOnes(r.cols());
    enumerate(body);
    hold(std::move(body));
  }

  [[nodiscard]] Index size() const { return r.cols(); }
  [[nodiscard]] const Body<Scalar, dim>& body() const { return *body_; }
  [[nodiscard]] const Column& mass() const { return body_->mass; }
  [[nodiscard]] const Column& radius() const { return body_->radius; }
  [[nodiscard]] const Eigen::VectorXi& type() const { return body_->type; }
  [[nodiscard]] const Column& charge() const { return body_->charge; }
  [[nodiscard]] const Box<Scalar, dim>& box() const { return body_->box; }
  /// A particle's index is its column, its id never changes.
  [[nodiscard]] const std::vector<std::int64_t>& id() const { return body_->id; }

  /// Each sets one property of all particles, by one number or by a vector (of Eigen, or a std::vector), and returns the particles.
  /// @throws std::invalid_argument naming the particle with an impossible value; nothing has changed then
  Particles& set_mass(const auto& m) { return set(&Properties::mass, m); }
  Particles& set_radius(const auto& radius) { return set(&Properties::radius, radius); }
  Particles& set_type(const auto& type) { return set(&Properties::type, type); }
  Particles& set_charge(const auto& charge) { return set(&Properties::charge, charge); }
  Particles& set_heat_capacity(const auto& c) { return set(&Properties::heat_capacity, c); }
  Particles& set_box(const Box<Scalar, dim>& box) {
    return set([&](auto& body) { body.box = box; });
  }
  /// I/(m R²): ⅖ unless set, ½ for discs.
  Particles& set_inertia_factor(Scalar factor) {
    return set([&](auto& body) { body.inertia_factor = factor; });
  }
  /// 1 holds a particle as it is: no force moves it, and forces on it are not computed. Empty: holds none.
  Particles& set_still(std::vector<std::uint8_t> still) {
    if (!still.empty() && static_cast<Index>(still.size()) != size())
      throw std::invalid_argument("phistep: " + std::to_string(still.size()) + " flags for " + std::to_string(size()) +
                                  " particles");
    return set([&](auto& body) { body.still = std::move(still); });
  }

  /// The user's own ids, all different and < 2^62; particles added later get those after the largest.
  Particles& set_id(std::vector<std::int64_t> id) {
    if (static_cast<Index>(id.size()) != size())
      throw std::invalid_argument("phistep: " + std::to_string(id.size()) + " ids for " + std::to_string(size()) +
                                  " particles");
    std::vector<std::int64_t> sorted = id;
    std::sort(sorted.begin(), sorted.end());
    const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
    if (twice != sorted.end())
      throw std::invalid_argument("phistep: two particles have the id " + std::to_string(*twice));
    if (!sorted.empty() && sorted.back() >= largest_id)
      throw std::invalid_argument("phistep: the id " + std::to_string(sorted.back()) + " isn't < 2^62");
    return set([&](auto& body) {
      body.id = std::move(id);
      if (!sorted.empty()) body.next_id = std::max<std::int64_t>(0, sorted.back() + 1);
    });
  }

  /// Appends particles; their blocks and properties come with them, their ids are new. Properties that only one side has
  /// are an error. The box stays.
  void add(const Particles& others) {
    if (others.size() == 0) return;
    Properties body = *body_;
    const Properties& theirs = others.body();
    append(body.mass, theirs.mass, "mass");
    append(body.radius, theirs.radius, "radius");
    append(body.type, theirs.type, "type");
    append(body.charge, theirs.charge, "charge");
    append(body.heat_capacity, theirs.heat_capacity, "heat capacity");
    if (!body.still.empty() || !theirs.still.empty()) {
      body.still.resize(static_cast<std::size_t>(size()));
      for (Index i = 0; i < others.size(); ++i) body.still.push_back(theirs.is_still(i) ? 1 : 0);
    }
    enumerate(body);
    body.check();
    for_each_block(
        [n = size(), added = others.size()](auto, auto& block, const auto& more) {  // `more` may be `block`
          block.conservativeResize(Eigen::NoChange, n + added);
          block.rightCols(added) = more.leftCols(added);
        },
        blocks(*this), blocks(others));
    hold(std::move(body));
  }
  /// Removes those for which gone(index) says so; the others keep their order and their ids. Returns how many went.
  Index erase_if(auto&& gone) {
    std::vector<Index> kept;
    for (Index i = 0; i < size(); ++i)
      if (!gone(i)) kept.push_back(i);
    const Index erased = size() - static_cast<Index>(kept.size());
    if (erased == 0) return 0;
    Properties body = *body_;
    const auto keep_rows = [&kept](auto& values) {
      if (values.size() != 0) values = values(kept).eval();
    };
    keep_rows(body.mass), keep_rows(body.radius), keep_rows(body.type), keep_rows(body.charge);
    keep_rows(body.heat_capacity);
    const auto keep = [&kept](auto& values) {
      if (values.empty()) return;
      for (std::size_t k = 0; k < kept.size(); ++k) values[k] = values[static_cast<std::size_t>(kept[k])];
      values.resize(kept.size());
    };
    keep(body.id), keep(body.still);
    for_each_block([&kept](auto, auto& block) { block = block(Eigen::all, kept).eval(); }, blocks(*this));
    hold(std::move(body));
    return erased;
  }
  /// Removes one particle.
  void erase(Index i) {
    erase_if([i](Index j) { return i == j; });
  }

  void archive(auto& ar) {
    ar("r", r, "v", v);
    (ar.value(Extra::name, Extra::block(*this)), ...);
    if constexpr (std::remove_reference_t<decltype(ar)>::reading) {
      Properties body;
      ar("body", body);
      for_each_block([&](auto, const auto& block) { ar.check(block.cols() == body.size()); }, blocks(*this));
      if (body_ == nullptr || !same(body, *body_)) hold(std::move(body));
    } else {
      ar("body", *body_);
    }
  }

 private:
  void hold(Properties&& body) {
    body.serial = next_serial();
    body_ = std::make_shared<const Properties>(std::move(body));
  }
  Particles& set(auto&& edit) {
    Properties body = *body_;
    edit(body);
    body.check();
    hold(std::move(body));
    return *this;
  }
  Particles& set(auto Properties::*column, const auto& values) {
    return set([&](auto& body) { fill(body.*column, values); });
  }
  void fill(auto& column, const auto& values) const {
    using To = std::remove_cvref_t<decltype(column)>;
    using From = std::remove_cvref_t<decltype(values)>;
    if constexpr (std::is_arithmetic_v<From>) {
      column.setConstant(size(), static_cast<typename To::Scalar>(values));
    } else if constexpr (!std::is_base_of_v<Eigen::EigenBase<From>, From>) {
      using Values = Eigen::Matrix<typename From::value_type, Eigen::Dynamic, 1>;
      fill(column, Eigen::Map<const Values>(values.data(), static_cast<Index>(values.size())));
    } else {
      if (values.size() != 0 && values.size() != size())
        throw std::invalid_argument("phistep: " + std::to_string(values.size()) + " values for " +
                                    std::to_string(size()) + " particles");
      column = values.template cast<typename To::Scalar>();
    }
  }
  static void enumerate(Properties& body) {
    while (static_cast<Index>(body.id.size()) < body.mass.size()) body.id.push_back(body.next_id++);
  }
  void append(auto& column, const auto& more, const char* name) const {
    const Index n = size(), added = more.size();
    if (column.size() == 0 && added == 0) return;
    if (column.size() != n || added == 0)
      throw std::invalid_argument("phistep: add(…) needs a value of " + std::string(name) +
                                  " of all particles or of none");
    column.conservativeResize(n + added);
    column.tail(added) = more;
  }
  [[nodiscard]] static bool same(const Properties& a, const Properties& b) {
    const auto equal = [](const auto& x, const auto& y) { return x.size() == y.size() && equal_bits(x, y); };
    return equal(a.mass, b.mass) && equal(a.radius, b.radius) && equal(a.type, b.type) && equal(a.charge, b.charge) &&
           equal(a.heat_capacity, b.heat_capacity) && a.id == b.id && a.still == b.still && a.box == b.box &&
           a.inertia_factor == b.inertia_factor && a.next_id == b.next_id;
  }

  std::shared_ptr<const Properties> body_;
};

}}  // namespace phistep::PHISTEP_ABI
