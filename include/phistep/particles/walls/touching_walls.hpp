/// @file
/// Which bodies touch which walls, and where.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <variant>
#include <vector>

#include "phistep/base/machine/shares.hpp"
#include "phistep/base/state/active_set.hpp"
#include "phistep/base/version.hpp"
#include "phistep/particles/contacts/contact_bodies.hpp"
#include "phistep/particles/contacts/spring_table.hpp"
#include "phistep/particles/walls/wall_shapes.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The bodies that walls remember, in the user's order. A place is the number of a wall and that of a body.
template <class Scalar>
struct WallBodies {
  ContactBodies<Scalar> bodies;

  [[nodiscard]] static std::int64_t place(std::int64_t wall, std::int32_t body) { return wall << 32 | body; }
  [[nodiscard]] static std::int32_t wall_of(std::int64_t place) { return static_cast<std::int32_t>(place >> 32); }
  [[nodiscard]] static std::int32_t body_of(std::int64_t place) { return static_cast<std::int32_t>(place); }
  [[nodiscard]] bool has(std::int64_t place) const {
    return body_of(place) >= 0 && static_cast<std::size_t>(body_of(place)) < bodies.size();
  }
  void archive(auto& ar) { ar("bodies", bodies); }
};

/// A workspace, its buffers serve again.
template <class Scalar, int dim>
class TouchingWalls {
  using Springs = SpringTable<Scalar, std::int64_t>;

 public:
  // One number a contact each, and as many more as fill its pack.
  std::vector<Scalar> nx, ny, nz, overlap, arm, rho, w;  ///< as in ContactPoint
  std::vector<std::int32_t> from;                        ///< where its springs stand in the table before

  [[nodiscard]] std::int64_t count() const { return count_; }

  /// Another set is noted, and which places have joined it: see ContactMemory::part.
  void update(std::size_t walls, const ActiveSet& active) {
    if (active.number() == set_) return;
    before_ = set_;
    joined_.clear();
    for_each_change(list_, active.list(), [this](std::int32_t i, bool joined) {
      if (joined) joined_.push_back(i);
    });
    const std::size_t bodies = joined_.size();
    for (std::size_t k = 1; k < walls; ++k)
      for (std::size_t b = 0; b < bodies; ++b)
        joined_.push_back(
            WallBodies<Scalar>::place(static_cast<std::int64_t>(k), static_cast<std::int32_t>(joined_[b])));
    list_ = active.list();
    set_ = active.number();
  }
  [[nodiscard]] std::uint64_t before() const { return before_; }
  [[nodiscard]] const std::vector<std::int64_t>& joined() const { return joined_; }

  /// Fills the table with the contacts' places, and makes room for their springs.
  /// @param active  of these bodies; null: of all
  void find(const std::vector<Wall<dim>>& walls, const auto& y, const ActiveSet* active, const Springs& before,
            Springs& table, bool with_roll) {
    for_each_number([](auto& x) { x.clear(); });
    from.clear();
    table.place.clear();
    SpringFinder springs_of{before.place, std::int64_t{0}};
    for (std::size_t k = 0; k < walls.size(); ++k)
      std::visit(
          [&](const auto& wall) {
            const NearWall<Scalar, dim, std::remove_cvref_t<decltype(wall)>> shape{wall, y.body.box};
            Eigen::Matrix<Scalar, dim, 1> n;
            for_each_touching(shape, y, active, [&](Eigen::Index i) {
              const Scalar radius = y.body.radius[i], distance = shape.approach(y.r.col(i), n);
              table.place.push_back(
                  WallBodies<Scalar>::place(static_cast<std::int64_t>(k), static_cast<std::int32_t>(i)));
              from.push_back(springs_of(table.place.back()));
              nx.push_back(n[0]);
              ny.push_back(n[1]);
              nz.push_back(dim == 3 ? n[dim - 1] : Scalar{0});
              overlap.push_back(radius - distance);
              arm.push_back(distance / radius);
              rho.push_back(Scalar{1} / radius);
              w.push_back(Scalar{1} / y.body.mass[i]);
            });
          },
          walls[k]);
    const std::size_t found = table.place.size();
    count_ = static_cast<std::int64_t>(found);
    table.resize(found, with_roll);
    // A whole pack more, with numbers that do no harm.
    constexpr std::size_t width = native_width<Scalar>;
    for_each_number([&](auto& x) { x.resize(found + width, Scalar{1}); });
    from.resize(found + width, static_cast<std::int32_t>(before.size()));
  }

 private:
  /// f(i), ascending. Threads share the search.
  void for_each_touching(const auto& wall, const auto& y, const ActiveSet* active, auto&& f) {
    const std::size_t bodies = active ? active->list().size() : static_cast<std::size_t>(y.r.cols());
    touching_.resize(bodies);
    found_.assign(thread_count(), {});
    for_each_share(bodies, 1, shared_from / 16, [&](const Share& own) {
      Eigen::Matrix<Scalar, dim, 1> n;
      std::size_t end = own.begin;
      for (std::size_t b = own.begin; b < own.end; ++b) {
        const std::int32_t i = active ? active->list()[b] : static_cast<std::int32_t>(b);
        const Eigen::Matrix<Scalar, dim, 1> r = y.r.col(i);
        if (wall.is_far(r, y.body.radius[i])) continue;
        // A position that is NaN touches, so that its force becomes NaN.
        if (!(wall.approach(r, n) >= y.body.radius[i]) && !y.body.is_still(i)) touching_[end++] = i;
      }
      found_[own.number] = {own.begin, end};
    });
    for (const auto& [begin, end] : found_)
      for (std::size_t b = begin; b < end; ++b) f(Eigen::Index{touching_[b]});
  }
  void for_each_number(auto&& f) {
    for (auto* x : {&nx, &ny, &nz, &overlap, &arm, &rho, &w}) f(*x);
  }
  std::int64_t count_ = 0;
  std::vector<std::int32_t> touching_;  // what each thread has found, from where its share begins
  std::vector<std::array<std::size_t, 2>> found_;
  std::vector<std::int32_t> list_;    // the particles of the last set
  std::vector<std::int64_t> joined_;  // places: wall 0 and those that joined it, then the other walls
  std::uint64_t set_ = 0, before_ = 0;
};

}}  // namespace phistep::PHISTEP_ABI
