// What terms.test.cpp and terms.full.cpp share.
#pragma once

#include <phistep/force/drag.hpp>
#include <phistep/force/external_field.hpp>
#include <phistep/force/gravity.hpp>
#include <phistep/force/sum.hpp>
#include <phistep/force/uniform_force.hpp>
#include <phistep/particles/springs/springs.hpp>
#include <phistep/phistep.hpp>

#include <Eigen/Geometry>

#include <cmath>
#include <functional>
#include <stdexcept>
#include <tuple>

#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

namespace terms_cases {

/// Ψ of a force at a motion's state, added to what `out` holds.
template <class S, class F>
auto added(F& force, const S& y, const auto& mass, double start = 0) {
  auto out = make_rate<S>(y);
  out.force.setConstant(start);
  add_force(unwrap(force), 0.0, Blocks<S>::view(y, std::tuple{mass}), NoMemory{}, out);
  return out.force;
}

template <class V>
Motion<V> grains() {
  return SecondOrder<V>{}.state;
}

inline void check_right(const JacobianCheck& result) {
  CAPTURE(result.message());
  CHECK(result);
}
/// What a term adds to nothing, to tens, and to a flat vector of nothing.
inline void check_added(const Eigen::VectorXd& alone, const Eigen::VectorXd& onto, const Eigen::VectorXd& flat) {
  CHECK(alone.norm() > 0.1);
  CHECK(distance(onto, alone.array() + 10) <= 1e-13);
  CHECK(distance(alone, flat) <= 1e-13);  // the same force, whatever the shape
}

inline const std::vector<Spring> one_spring{{0, 1, 80.0, 0.4}};

/// The contract of every term, in every shape of a state.
template <class V>
void check_terms() {
  const auto y = grains<V>();
  const auto check = [&](auto term) {
    check_added(numbers(typename V::PlainObject(added(term, y, UnitMass{}))),
                numbers(typename V::PlainObject(added(term, y, UnitMass{}, 10.0))),
                numbers(Dynamic(added(term, grains<Dynamic>(), UnitMass{}))));
  };
  check(Gravity{Eigen::Vector3d(1, 2, -9.81)});
  check(UniformForce{Eigen::Vector3d(1, 2, 3)});
  check(LinearDrag{0.7});
  if constexpr (!V::IsRowMajor) {  // which springs refuse, see tests/compile
    check(spring_network<3>(one_spring));
    check(spring_network<3>(one_spring, SpringDamping{2.0}));
    check(QuadraticDrag{0.7});
    check(ExternalField{[](const Eigen::Vector3d& r) -> Eigen::Vector3d { return r.squaredNorm() * r; }});
  }
  check(term([](const auto& r) { return typename std::remove_cvref_t<decltype(r)>::PlainObject(-r); }));
  check(LinearDrag{0.7} + Gravity{Eigen::Vector3d(0, 0, -1)} + UniformForce{Eigen::Vector3d(0, 1, 0)});
}

}  // namespace terms_cases
