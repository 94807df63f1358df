/// @file
/// The bodies that contacts remember: their identities and properties.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// @throws std::invalid_argument where contacts can't be computed for these bodies
template <class Body>
void check_bodies(const Body& body, std::ptrdiff_t count) {
  if (body.radius.size() != count)
    throw std::invalid_argument("phistep: contacts need the radii of the particles: set_radius(…)");
  for (Eigen::Index i = 0; i < body.radius.size(); ++i)
    if (!(body.radius[i] > 0) || !std::isfinite(body.radius[i]) || !(body.mass[i] > 0) || !std::isfinite(body.mass[i]))
      throw std::invalid_argument("phistep: the radius and mass of particle " + std::to_string(i) +
                                  " must be finite and > 0");
}

/// The properties of bodies that contacts use, in slots.
template <class Scalar>
struct ContactBodies {
  std::vector<std::int32_t> particle;  ///< the user's index of a slot's
  std::vector<std::int64_t> id;        ///< and its identity
  std::vector<std::int32_t> slot;      ///< of each particle
  std::vector<Scalar> radius, inverse_radius, inverse_mass;
  std::vector<std::int32_t> type;  ///< or none: all are 0

  [[nodiscard]] std::size_t size() const { return particle.size(); }
  [[nodiscard]] std::int32_t type_of(std::size_t s) const { return type.empty() ? 0 : type[s]; }
  void assign(const auto& body, std::vector<std::int32_t> order) {
    particle = std::move(order);
    const std::size_t n = particle.size();
    id.resize(n), radius.resize(n), inverse_mass.resize(n), type.resize(body.type.size() == 0 ? 0 : n);
    for (std::size_t s = 0; s < n; ++s) {
      const Eigen::Index i = particle[s];
      id[s] = body.id[static_cast<std::size_t>(i)];
      radius[s] = static_cast<Scalar>(body.radius[i]);
      inverse_mass[s] = body.is_still(i) ? Scalar{0} : Scalar{1} / static_cast<Scalar>(body.mass[i]);
      if (!type.empty()) type[s] = body.type_of(i);
    }
    derive();
  }
  /// Whether these are that body's.
  [[nodiscard]] bool are(const auto& body) const {
    if (static_cast<std::size_t>(body.size()) != size() || body.radius.size() != body.size()) return false;
    for (std::size_t s = 0; s < size(); ++s) {
      const Eigen::Index i = particle[s];
      const Scalar inverse = body.is_still(i) ? Scalar{0} : Scalar{1} / static_cast<Scalar>(body.mass[i]);
      if (id[s] != body.id[static_cast<std::size_t>(i)] || radius[s] != static_cast<Scalar>(body.radius[i]) ||
          inverse_mass[s] != inverse || type_of(s) != body.type_of(i))
        return false;
    }
    return true;
  }
  void archive(auto& ar) {
    ar("particle", particle, "id", id, "radius", radius, "inverse_mass", inverse_mass, "type", type);
    const std::size_t n = size();
    ar.check(id.size() == n && radius.size() == n && inverse_mass.size() == n && (type.empty() || type.size() == n));
    std::vector<std::uint8_t> seen(n, 0);
    for (const std::int32_t i : particle) {
      ar.check(i >= 0 && static_cast<std::size_t>(i) < n && seen[static_cast<std::size_t>(i)] == 0);
      seen[static_cast<std::size_t>(i)] = 1;
    }
    derive();
  }

 private:
  void derive() {
    slot.resize(size());
    inverse_radius.resize(size());
    for (std::size_t s = 0; s < size(); ++s) {
      slot[static_cast<std::size_t>(particle[s])] = static_cast<std::int32_t>(s);
      inverse_radius[s] = Scalar{1} / radius[s];
    }
  }
};

/// Where the body of an identity stands.
class SlotsById {
 public:
  explicit SlotsById(const std::vector<std::int64_t>& ids) : sorted_(ids.size()) {
    for (std::size_t s = 0; s < ids.size(); ++s) sorted_[s] = {ids[s], static_cast<std::int32_t>(s)};
    std::sort(sorted_.begin(), sorted_.end());
  }
  /// −1: it isn't there.
  [[nodiscard]] std::int32_t operator()(std::int64_t id) const {
    const auto at = std::lower_bound(sorted_.begin(), sorted_.end(), std::pair{id, std::int32_t{0}});
    return at != sorted_.end() && at->first == id ? at->second : -1;
  }

 private:
  std::vector<std::pair<std::int64_t, std::int32_t>> sorted_;
};

}}  // namespace phistep::PHISTEP_ABI
