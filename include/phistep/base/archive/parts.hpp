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
/// first part changes. Names precede the parts they belong to: save_parts(out, "t", t, "count", count).
///
/// A part that holds more than it saves (Jacobians, factors) has `void forget_unsaved()`, called after saving and loading.
/// The run that saved and the run that resumes are then the same.
#pragma once

#include <concepts>
#include <string>
#include <string_view>
#include <utility>

#include "phistep/base/archive/archive.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// An object that saves and loads itself.
template <class T>
concept Restorable = requires(T& x, const T& same, Writer& out, Reader& in, void (*then)()) {
  same.save(out);
  x.load(in, then);
};
/// An object that holds more than a checkpoint does.
template <class T>
concept HasUnsaved = requires(T& x) {
  x.forget_unsaved();
};

namespace detail {
/// Of a part without a name before it: its type's, else its place.
template <class Part>
[[nodiscard]] std::string default_name(auto& archive) {
  const std::string place = archive.ordinal();
  if constexpr (requires { Part::part_name; }) return Part::part_name;
  else return place;
}
template <class Part>
void save_part(Writer& out, std::string_view name, const Part& part) {
  if constexpr (Restorable<Part>) {
    out.open(name);
    part.save(out);
    out.close();
  } else if constexpr (ShowsTrials<Part>) {  // arrays of a code, in the order of its particles
    PlainState<Part> copy;
    copy_blocks<Part>(copy, part);
    out.value(name, copy);
  } else {
    out.value(name, part);
  }
}
}  // namespace detail

inline void save_parts(Writer&) {}
template <class First, class... Rest>
void save_parts(Writer& out, const First& first, const Rest&... rest) {
  if constexpr (detail::is_name<First>) {
    [&](const auto& part, const auto&... others) {
      detail::save_part(out, first, part);
      save_parts(out, others...);
    }(rest...);
  } else {
    detail::save_part(out, detail::default_name<First>(out), first);
    save_parts(out, rest...);
  }
}

template <std::invocable Then>
void load_parts(Reader& /*in*/, Then&& then) {
  then();
}
template <std::invocable Then, class First, class... Rest>
void load_parts(Reader& in, Then&& then, First& first, Rest&... rest);

namespace detail {
template <class Then, class Part, class... Rest>
void load_part(Reader& in, std::string_view name, Then& then, Part& part, Rest&... rest) {
  if constexpr (Restorable<Part>) {
    in.open(name);
    part.load(in, [&] {
      in.close();
      load_parts(in, then, rest...);
    });
  } else if constexpr (State<Part>) {  // keeps its shape, and a Map or Ref is written through
    PlainState<Part> copy;
    copy_blocks<Part>(copy, part);
    in.value<true>(name, copy);
    load_parts(in, then, rest...);
    copy_blocks<Part>(part, copy);
  } else {
    Part copy = part;
    in.value(name, copy);
    load_parts(in, then, rest...);
    part = std::move(copy);
  }
}
}  // namespace detail

template <std::invocable Then, class First, class... Rest>
void load_parts(Reader& in, Then&& then, First& first, Rest&... rest) {
  if constexpr (detail::is_name<First>) detail::load_part(in, first, then, rest...);
  else detail::load_part(in, detail::default_name<First>(in), then, first, rest...);
}

}}  // namespace phistep::PHISTEP_ABI
