/// @file
/// What is read from a checkpoint is read into its place, and put back if anything that follows is wrong.
///
/// Old values are kept, and moved back: that can't fail for want of memory, and needs no writing of what a file can't hold. What
/// can't be put back (factors that are forgotten) is done at last.
#pragma once

#include <functional>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/archive/archive_kinds.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The undoing of a Reader.
class AllOrNothing {
 public:
  /// f() when all has been read and checked: what can't be undone.
  void at_last(std::function<void()> f) {
    if (is_open_) last_.push_back(std::move(f));
    else f();
  }
  /// Notes what x was; not after pause(), within what is noted as a whole.
  template <class T>
  void keep(T& x) {
    if constexpr (!ByParts<T> && !std::is_empty_v<T>) {
      static_assert(std::is_copy_constructible_v<T> && std::is_move_assignable_v<T>,
                    "phistep: an object that can't be copied is read by its parts: `using ArchivedByParts = void;`");
      if (!keeps_) return;
      T copy = x;
      const auto old = std::make_shared<T>(std::move(x));  // it allocates before it moves
      take(x, copy);                                       // so what is put back has its old place in memory
      undo_.push_back([&x, old] { x = std::move(*old); });
    }
  }
  [[nodiscard]] auto pause() { return Paused{keeps_, std::exchange(keeps_, false)}; }

 protected:
  /// Calls read(); if it throws, what it has changed is put back.
  void attempt(auto&& read) {
    is_open_ = keeps_ = true;
    try {
      read();
      for (const auto& f : last_) f();
    } catch (...) {
      for (; !undo_.empty(); undo_.pop_back()) undo_.back()();
      throw;
    }
  }

 private:
  /// Out of line: inlined, g++ 12 holds an empty std::optional's value for uninitialized.
  template <class T>
  [[gnu::noinline]] static void take(T& to, T& from) {
    to = std::move(from);
  }
  struct Paused {
    bool& keeps;
    bool before;
    ~Paused() { keeps = before; }
  };

  std::vector<std::function<void()>> undo_, last_;
  bool is_open_ = false, keeps_ = false;
};

}}  // namespace phistep::PHISTEP_ABI
