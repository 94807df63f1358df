/// @file
/// Whether a class has any member of a given name, be it a template or overloaded, which no call that fails tells: beside a
/// second member of that name, taking its address is ambiguous.
#pragma once

#include <type_traits>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

struct NameAdd {
  struct Second {
    int add;
  };
  template <class F>
  using Member = decltype(&F::add);
};
struct NameJacobian {
  struct Second {
    int jacobian;
  };
  template <class F>
  using Member = decltype(&F::jacobian);
};
struct NameApplyJacobian {
  struct Second {
    int apply_jacobian;
  };
  template <class F>
  using Member = decltype(&F::apply_jacobian);
};

template <class F, class Name>
struct WithName : F, Name::Second {};
template <class F, class Name>
inline constexpr bool has_member_named = false;
template <class F, class Name>
  requires(std::is_class_v<F> && !std::is_final_v<F>)
inline constexpr bool has_member_named<F, Name> = !requires { typename Name::template Member<WithName<F, Name>>; };

}}  // namespace phistep::PHISTEP_ABI
