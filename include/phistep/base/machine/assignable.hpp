/// @file
/// Holds a value that can be assigned though its type is a lambda with captures: it is made anew in its place.
#pragma once

#include <memory>
#include <type_traits>
#include <utility>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What may throw while it is copied, and has no assignment of its own, has none here.
template <class T>
class Assignable {
 public:
  explicit Assignable(T value) : value_{std::move(value)} {}
  Assignable(const Assignable&) = default;
  Assignable(Assignable&&) = default;
  Assignable& operator=(const Assignable&) requires std::is_copy_assignable_v<T>
  = default;
  Assignable& operator=(Assignable&&) requires std::is_move_assignable_v<T>
  = default;
  Assignable& operator=(const Assignable& other) requires(!std::is_copy_assignable_v<T> &&
                                                          std::is_nothrow_copy_constructible_v<T>) {
    if (this == &other) return *this;
    std::destroy_at(&value_);
    std::construct_at(&value_, other.value_);
    return *this;
  }
  ~Assignable() = default;

  [[nodiscard]] T& operator*() { return value_; }
  [[nodiscard]] const T& operator*() const { return value_; }

 private:
  T value_;
};

}}  // namespace phistep::PHISTEP_ABI
