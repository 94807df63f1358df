/// @file
/// What a checkpoint is made of: parts that are written one after the other, and read all or none.
///
/// A part is a value (it is archived, and read into a copy), or an object with
///
///     void save(Writer& out) const;
///     template <class Then> void load(Reader& in, Then&& then);
///
/// where load reads everything into temporaries, calls then(), which reads and checks what follows, and only after that
/// changes itself, without throwing. Loads nest in one another in this way, so that the last byte is checked before the
/// first part changes.
#pragma once

#include <concepts>
#include <utility>

#include "phistep/core/archive.hpp"
#include "phistep/core/version.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep::inline PHISTEP_ABI {

/// An object that saves and loads itself.
template <class T>
concept Restorable = requires(T& x, const T& same, Writer& out, Reader& in, void (*then)()) {
  same.save(out);
  x.load(in, then);
};

inline void save_parts(Writer&) {}
template <class First, class... Rest>
void save_parts(Writer& out, const First& first, const Rest&... rest) {
  if constexpr (Restorable<First>) first.save(out);
  else out(first);
  save_parts(out, rest...);
}

template <std::invocable Then>
void load_parts(Reader& /*in*/, Then&& then) {
  then();
}
template <std::invocable Then, class First, class... Rest>
void load_parts(Reader& in, Then&& then, First& first, Rest&... rest) {
  if constexpr (Restorable<First>) {
    first.load(in, [&] { load_parts(in, then, rest...); });
  } else {
    First copy = first;
    in(copy);
    load_parts(in, then, rest...);
    first = std::move(copy);
  }
}

/// A state as a part: it keeps its shape, and a Map or Ref is written through.
template <State S>
class StatePart {
 public:
  explicit StatePart(S& state) : state_{&state} {}
  void save(Writer& out) const { out(*state_); }
  template <class Then>
  void load(Reader& in, Then&& then) {
    PlainState<S> copy;
    copy_blocks<S>(copy, *state_);
    in.in_place(copy);
    then();
    copy_blocks<S>(*state_, copy);
  }

 private:
  S* state_;
};

}  // namespace phistep::inline PHISTEP_ABI
