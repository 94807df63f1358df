/// @file
/// How a type falls into the records of an archive: what Writer and Reader of archive.hpp share.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/archive/archive_kinds.hpp"
#include "phistep/base/state/blocks.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What both directions share: how a type falls into records.
template <class Self>
class Archive {
 public:
  template <class... T>
  void operator()(T&&... parts) {
    values<As::value>(parts...);
  }
  template <class... T>
  void in_place(T&&... parts) {
    values<As::in_place>(parts...);
  }
  template <class... T>
  void aside(T&&... parts) {
    [[maybe_unused]] const auto paused = self().pause();
    values<As::value>(parts...);
  }
  template <bool fixed = false, class T>
  void value(std::string_view name, T& x) {
    self().keep(x);
    if constexpr (ByParts<std::remove_const_t<T>>) return pass<fixed>(name, x);
    [[maybe_unused]] const auto paused = self().pause();
    pass<fixed>(name, x);
  }
  /// A state keeps its shape. Views are gathered: arrays of a code in the order of its particles.
  template <class T>
  void state(std::string_view name, T& x) {
    using S = std::remove_const_t<T>;
    [[maybe_unused]] const auto paused = self().pause();
    if constexpr (Self::reading || !std::is_same_v<S, PlainState<S>>) {
      PlainState<S> copy;
      copy_blocks<S>(copy, x);
      pass<true>(name, copy);
      if constexpr (Self::reading) self().at_last([&x, copy = std::move(copy)] { copy_blocks<S>(x, copy); });
    } else {
      pass<true>(name, x);
    }
  }
  /// A list of structs, as a list for each of the members named: columns("sleepers", list, "kind", &Sleeper::kind, …).
  template <class List, class... Members>
  void columns(std::string_view name, List& list, const Members&... members) {
    self().keep(list);
    [[maybe_unused]] const auto paused = self().pause();
    self().open(name);
    bool is_first = true;
    column(is_first, list, members...);
    self().close();
  }

 protected:
  /// The parts of a checkpoint.
  template <class... T>
  void parts(T&... all) {
    values<As::part>(all...);
  }
  void enter() { counts_.push_back(0); }
  void leave() { counts_.pop_back(); }

 private:
  enum class As { value, in_place, part };
  [[nodiscard]] Self& self() { return static_cast<Self&>(*this); }
  /// The name of a value that has none.
  [[nodiscard]] std::string ordinal() { return std::to_string(counts_.back()++); }

  template <bool fixed, class T>
  void pass(std::string_view name, T& x) {
    using V = std::remove_const_t<T>;
    if constexpr (detail::Archived<V>) {
      self().open(name);
      const_cast<V&>(x).archive(self());
      self().close();
    } else if constexpr (detail::Dense<V>) {
      dense<fixed>(name, x);
    } else if constexpr (detail::Blocked<V>) {
      self().open(name);
      std::apply([this](auto&... block) { (this->template value<fixed>(this->template name_of<V>(), block), ...); },
                 V::blocks(x));
      self().close();
    } else if constexpr (std::is_same_v<V, std::string> || detail::is_list<V>) {
      list<fixed>(name, x);
    } else if constexpr (detail::TupleLike<V> && requires { x.begin(); }) {
      list<fixed>(name, x);
    } else if constexpr (detail::TupleLike<V>) {
      self().open(name);
      std::apply([this](auto&... element) { this->template values<as<fixed>>(element...); }, x);
      self().close();
    } else if constexpr (detail::is_number<V>) {
      std::array<std::uint64_t, 2> size{1, 1};
      self().template head<V>(name, 0, size);
      self().data(&x, 1);
    } else if constexpr (detail::RandomEngine<V>) {
      engine(name, x);
    } else {
      static_assert(std::is_empty_v<V>,
                    "phistep: this type can't be archived: give it void archive(auto& ar) { ar(its, members); }");
    }
  }

  template <bool fixed>
  static constexpr As as = fixed ? As::in_place : As::value;
  template <As as>
  void values() {}
  template <As as, class First, class... Rest>
  void values(First& first, Rest&... rest) {
    if constexpr (detail::is_name<First>) {
      named<as>(first, rest...);
    } else {
      const std::string place = ordinal();
      if constexpr (requires { First::part_name; }) named<as>(First::part_name, first, rest...);
      else named<as>(place, first, rest...);
    }
  }
  template <As as, class T, class... Rest>
  void named(std::string_view name, T& x, Rest&... rest) {
    if constexpr (as == As::part && State<std::remove_const_t<T>>) state(name, x);
    else value<as == As::in_place>(name, x);
    values<as>(rest...);
  }
  /// The name of a struct's next block.
  template <class V>
  [[nodiscard]] std::string name_of() {
    if constexpr (requires { V::block_names; }) return V::block_names[counts_.back()++];
    else return ordinal();
  }

  template <class List>
  void column(bool&, List&) {}
  template <class List, class T, class M, class... Rest>
  void column(bool& is_first, List& list, const char* name, M T::*member, const Rest&... rest) {
    const auto numbers = [member](auto& x) {
      auto& own = x.*member;
      if constexpr (requires { own.data(); }) return std::span(own.data(), static_cast<std::size_t>(own.size()));
      else return std::span(&own, 1);
    };
    T like{};
    const std::size_t each = numbers(like).size();
    std::vector<typename decltype(numbers(like))::value_type> all;
    if constexpr (!Self::reading) {
      all.reserve(each * list.size());
      for (const T& x : list)
        for (const auto& one : numbers(x)) all.push_back(one);
    }
    this->template list<false>(name, all);
    if constexpr (Self::reading) {
      if (std::exchange(is_first, false)) list.assign(all.size() / each, T{});
      self().check(all.size() == each * list.size());
      auto from = all.begin();
      for (T& x : list)
        for (auto& one : numbers(x)) one = *from++;
    }
    column(is_first, list, rest...);
  }
  /// A random engine as the standard writes it: it goes on in the same way elsewhere.
  template <class Out = std::ostringstream, class In = std::istringstream, class T>
  void engine(std::string_view name, T& x) {
    std::string state;
    if constexpr (!Self::reading) {
      Out out;
      out.imbue(decltype(out.getloc())::classic());
      out << x;
      state = out.str();
    }
    list<false>(name, state);
    if constexpr (Self::reading) {
      In in(state);
      in.imbue(decltype(in.getloc())::classic());
      in >> x;
      self().check(static_cast<bool>(in));
    }
  }
  /// Vectors and strings grow to what is there, arrays have as many.
  template <bool fixed, class T>
  void list(std::string_view name, T& x) {
    using List = std::remove_const_t<T>;
    using V = std::remove_const_t<typename T::value_type>;
    constexpr bool is_text = std::is_same_v<List, std::string>, grows = is_text || detail::is_list<List>;
    static_assert(!grows || !std::is_empty_v<V>, "phistep: a list of empty objects can't be archived");
    std::array<std::uint64_t, 2> size{x.size(), 1};
    if constexpr (detail::is_number<V>) {
      self().template head<V>(name, 1, size, is_text ? detail::Kind{'t', 1} : detail::kind_of<V>());
      if constexpr (!grows) self().fits(name, size, x.size(), 1);
      else if constexpr (Self::reading) x.resize(static_cast<std::size_t>(size[0]));
      if constexpr (grows && std::is_same_v<V, bool>) {
        for (std::size_t i = 0; i < x.size(); ++i) {
          bool bit = x[i];
          self().data(&bit, 1);
          if constexpr (Self::reading) x[i] = bit;
        }
      } else {
        self().data(x.data(), x.size());
      }
    } else {
      self().open(name, &size[0]);
      if constexpr (!grows) self().fits(name, size, x.size(), 1);
      if constexpr (grows && Self::reading)  // with what is really there
        for (x.clear(); x.size() < size[0];) values<As::value>(x.emplace_back());
      else
        for (auto& element : x) values<as<fixed && !grows>>(element);
      self().close();
    }
  }

  template <bool fixed, class T>
  void dense(std::string_view name, T& x) {
    using V = std::remove_const_t<T>;
    using Scalar = typename V::Scalar;
    constexpr bool plain = std::is_base_of_v<Eigen::PlainObjectBase<V>, V>;
    std::array<std::uint64_t, 2> size{static_cast<std::uint64_t>(x.rows()), static_cast<std::uint64_t>(x.cols())};
    self().template head<Scalar>(name, 2, size);
    if constexpr (Self::reading) {
      const auto bound = [](Eigen::Index own, std::uint64_t there) {
        return own == Eigen::Dynamic ? there : static_cast<std::uint64_t>(own);
      };
      if constexpr (fixed || !plain || V::SizeAtCompileTime != Eigen::Dynamic) {
        self().fits(name, size, static_cast<std::uint64_t>(x.rows()), static_cast<std::uint64_t>(x.cols()));
      } else {
        self().fits(name, size, bound(V::RowsAtCompileTime, size[0]), bound(V::ColsAtCompileTime, size[1]));
        self().fits(name, size, std::min(size[0], bound(V::MaxRowsAtCompileTime, size[0])),
                    std::min(size[1], bound(V::MaxColsAtCompileTime, size[1])));
        x.resize(static_cast<Eigen::Index>(size[0]), static_cast<Eigen::Index>(size[1]));
      }
    }
    if constexpr (plain && (!V::IsRowMajor || V::IsVectorAtCompileTime)) {
      self().data(x.data(), static_cast<std::size_t>(x.size()));
    } else {
      // A view may have gaps, and rows may come first: its numbers pass through a matrix of columns.
      Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic> copy(x.rows(), x.cols());
      if constexpr (!Self::reading) copy = x;
      self().data(copy.data(), static_cast<std::size_t>(copy.size()));
      if constexpr (Self::reading) x = copy;
    }
  }

  std::vector<std::size_t> counts_{0};  // of values without a name, section by section
};

}}  // namespace phistep::PHISTEP_ABI
