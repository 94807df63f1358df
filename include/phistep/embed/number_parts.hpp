/// @file
/// States of numbers that are made of reals: complex ones, and those of Eigen's AutoDiffScalar, each a value with its derivatives by
/// some parameters. A stepper steps their parts, as a state of reals: so every scheme, solver and norm serves them, and what is not
/// analytic, as |ψ|²ψ, has its whole Jacobian. Forces, events and observers see the numbers.
///
///     Eigen::VectorXcd psi = …;
///     phistep::PhiStepper stepper{psi, [&H](const Eigen::VectorXcd& y) -> Eigen::VectorXcd { return -1i * (H * y); },
///                                 phistep::trapezoidal};
///
/// Part p of number (i, j), of k parts, is the real number (k i + p, j).
#pragma once

#include <Eigen/Core>

#include <complex>
#include <concepts>
#include <functional>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/motion.hpp"
#include "phistep/force/evaluate.hpp"
#include "phistep/force/signature.hpp"
#include "phistep/step/jacobian/analytic.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The parts of a number: their type, how many, part p of x as a reference. The traits of a number type.
template <class Number>
struct NumberParts;
template <std::floating_point T>
struct NumberParts<std::complex<T>> {
  using Real = T;
  static constexpr int count = 2;
  static auto& part(auto& x, Index p) {
    using Part = std::conditional_t<std::is_const_v<std::remove_reference_t<decltype(x)>>, const T, T>;
    return reinterpret_cast<Part*>(&x)[p];  // as [complex.numbers.general] allows
  }
};
template <class Number>
  requires(Number::DerType::SizeAtCompileTime > 0 && std::floating_point<typename Number::DerType::Scalar>)
struct NumberParts<Number> {
  using Real = typename Number::DerType::Scalar;
  static constexpr int count = 1 + Number::DerType::SizeAtCompileTime;
  static auto& part(auto& x, Index p) { return p == 0 ? x.value() : x.derivatives().coeffRef(p - 1); }
};

template <class S>
concept VectorOfParts = EigenDense<S> && requires {
  typename NumberParts<typename S::Scalar>::Real;
};

/// A vector's parts, in its own memory.
template <class Numbers>
class PartsBlock {
  using Number = typename Numbers::Scalar;
  using Parts = NumberParts<Number>;
  static constexpr int count = Parts::count, fixed_rows = Numbers::RowsAtCompileTime;

 public:
  using Scalar = typename Parts::Real;
  using Plain = Eigen::Matrix<Scalar, fixed_rows == Eigen::Dynamic ? Eigen::Dynamic : count * fixed_rows,
                              Numbers::ColsAtCompileTime, count * fixed_rows == 1 ? Eigen::RowMajor : Eigen::ColMajor>;
  static constexpr int SizeAtCompileTime = Plain::SizeAtCompileTime;
  static constexpr bool IsRowMajor = false;  // as its numbers are counted in messages

  explicit PartsBlock(Numbers& numbers) : numbers_{&numbers} {}
  [[nodiscard]] Index rows() const { return count * numbers_->rows(); }
  [[nodiscard]] Index cols() const { return numbers_->cols(); }
  [[nodiscard]] Index size() const { return count * numbers_->size(); }
  [[nodiscard]] auto& coeffRef(Index i, Index j) const {
    return Parts::part(numbers_->coeffRef(i / count, j), i % count);
  }
  [[nodiscard]] Scalar operator()(Index i, Index j) const { return coeffRef(i, j); }

 private:
  Numbers* numbers_;
};
template <class To, class Numbers>
void assign_block(To& to, const PartsBlock<Numbers>& from) {
  to.resize(from.rows(), from.cols());
  for (Index j = 0; j < to.cols(); ++j)
    for (Index i = 0; i < to.rows(); ++i) to(i, j) = from(i, j);
}
template <class Numbers, class From>
void assign_block(PartsBlock<Numbers>& to, const From& from) {
  for (Index j = 0; j < to.cols(); ++j)
    for (Index i = 0; i < to.rows(); ++i) to.coeffRef(i, j) = from(i, j);
}
/// numbers = those of these parts
template <class Numbers, class From>
void set_from_parts(Numbers& numbers, const From& from) {
  numbers.resize(from.rows() / NumberParts<typename Numbers::Scalar>::count, from.cols());
  PartsBlock<Numbers> to{numbers};
  assign_block(to, from);
}

/// Schemes step the parts of S's numbers, a vector of reals.
template <VectorOfParts S>
struct Blocks<S> : Blocks<typename PartsBlock<S>::Plain> {
  using Plain = typename PartsBlock<S>::Plain;
  static auto all(auto& y) {
    if constexpr (VectorOfParts<std::remove_cvref_t<decltype(y)>>) return std::tuple{PartsBlock{y}};
    else return std::tie(y);
  }
  static auto solved(auto& y) { return all(y); }
  /// A plain state as numbers.
  static typename S::PlainObject shown(const Plain& y) {
    typename S::PlainObject numbers;
    set_from_parts(numbers, y);
    return numbers;
  }
};
template <VectorOfParts V>
struct Blocks<Motion<V>> : Blocks<Motion<typename PartsBlock<V>::Plain>> {
  using Plain = Motion<typename PartsBlock<V>::Plain>;
  static auto all(auto& y) {
    if constexpr (VectorOfParts<std::remove_cvref_t<decltype(y.r)>>)
      return std::tuple{PartsBlock{y.r}, PartsBlock{y.v}};
    else return std::tie(y.r, y.v);
  }
  static auto solved(auto& y) {
    if constexpr (VectorOfParts<std::remove_cvref_t<decltype(y.v)>>) return std::tuple{PartsBlock{y.v}};
    else return std::tie(y.v);
  }
  static Motion<typename V::PlainObject> shown(const Plain& y) {
    Motion<typename V::PlainObject> numbers;
    set_from_parts(numbers.r, y.r);
    set_from_parts(numbers.v, y.v);
    return numbers;
  }
};

/// Whether a run may have events. Derivatives of AutoDiffScalar would miss that an event's time depends on the parameters, too.
template <class S>
inline constexpr bool may_have_events = true;
template <VectorOfParts S>
inline constexpr bool may_have_events<S> = Eigen::NumTraits<typename S::Scalar>::IsComplex;
template <VectorOfParts V>
inline constexpr bool may_have_events<Motion<V>> = may_have_events<V>;

/// Their time is real.
template <class View>
  requires((MotionLike<View> || FirstOrderLike<View>)&&VectorOfParts<FirstOf<View>>)
struct ViewScalar<View> {
  using type = typename NumberParts<typename FirstOf<View>::Scalar>::Real;
};

/// A force of numbers as one of their parts.
/// @tparam Given  the state that it is given, a vector of numbers or a Motion of two
template <class Given, class F>
class ForceOfParts {
  struct NoMass {};
  static constexpr bool is_motion = !EigenDense<Given>;
  struct VectorRate {
    Given rate;
    static auto blocks(auto& psi) { return std::tie(psi.rate); }
  };
  static auto rate_of() {
    if constexpr (is_motion) return std::type_identity<typename Given::Rate>{};
    else return std::type_identity<VectorRate>{};
  }
  static auto view_of(const Given& y) {
    static constexpr NoMass none{};
    if constexpr (is_motion) return MotionView<decltype(y.r), NoMass>{y.r, y.v, none};
    else return FirstOrderView<Given, NoMass>{y, none};
  }
  using Rate = typename decltype(rate_of())::type;
  using Traits = ForceTraits<Unwrapped<F>, decltype(view_of(std::declval<const Given&>())), Rate>;
  using Block = std::remove_cvref_t<decltype(std::get<0>(Rate::blocks(std::declval<Rate&>())))>;
  using Number = typename Block::Scalar;
  static constexpr int count = NumberParts<Number>::count;
  static_assert(Refusal<Traits::fault, is_motion>::is_said);
  static_assert(!remembers<F>, "phistep: a force of complex or other numbers can't have a history");

  /// Takes a number's entry of a Jacobian as what it makes of each part.
  template <class Sink>
  struct PartsSink {
    Sink& sink;
    void position(Index i, Index j, const auto& x) const {
      each(i, j, x, [this](auto... entry) { sink.position(entry...); });
    }
    void velocity(Index i, Index j, const auto& x) const {
      each(i, j, x, [this](auto... entry) { sink.velocity(entry...); });
    }
    void rate(Index i, Index j, const auto& x) const {
      each(i, j, x, [this](auto... entry) { sink.rate(entry...); });
    }
    static void each(Index i, Index j, const auto& x, auto&& put) {
      using Parts = NumberParts<Number>;
      for (Index q = 0; q < count; ++q) {
        Number unit(0);
        for (Index p = 0; p < count; ++p) Parts::part(unit, p) = p == q ? 1 : 0;
        const Number column = Number(x) * unit;
        for (Index p = 0; p < count; ++p) put(count * i + p, count * j + q, Parts::part(column, p));
      }
    }
  };

 public:
  static constexpr bool uses_time = Traits::uses_time, is_affine = Traits::is_affine;
  template <class View>  // it takes v along, whether the force uses it or not
  static constexpr bool uses_velocity_of = Traits::uses_velocity;
  static constexpr Structure structure =
      Traits::has_jacobian && Traits::structure == Structure::sparse ? Structure::sparse : Structure::dense;

  ForceOfParts(F force) : force_{std::move(force)} {}  // NOLINT(google-explicit-constructor): it takes its place
  ForceOfParts(const ForceOfParts& other) noexcept(std::is_nothrow_copy_constructible_v<F>) : force_{other.force_} {}
  ForceOfParts(ForceOfParts&& other) noexcept : force_{std::move(other.force_)} {}
  ForceOfParts& operator=(const ForceOfParts&) = default;
  ForceOfParts& operator=(ForceOfParts&&) = default;
  ~ForceOfParts() = default;

  void add(auto t, const auto& y, auto& out) {
    take(y);
    auto& psi = std::get<0>(Rate::blocks(rate_));
    psi.resizeLike(unknowns());
    assign_force(unwrap(force_), t, view_of(given_), NoMemory{}, rate_);
    auto& to = std::get<0>(std::remove_cvref_t<decltype(out)>::blocks(out));
    const PartsBlock<Block> parts{psi};
    for (Index j = 0; j < to.cols(); ++j)
      for (Index i = 0; i < to.rows(); ++i) to(i, j) += parts(i, j);
  }
  void add_jacobian(auto t, const auto& y, auto& sink) requires(Traits::has_jacobian) {
    take(y);
    PartsSink<std::remove_reference_t<decltype(sink)>> parts{sink};
    phistep::add_jacobian<true, Rate, Eigen::Dynamic>(unwrap(force_), t, view_of(given_), NoMemory{}, unknowns().size(),
                                                      parts);
  }

 private:
  void take(const auto& y) {
    if constexpr (is_motion) {
      set_from_parts(given_.r, y.r);
      set_from_parts(given_.v, y.v);
    } else {
      set_from_parts(given_, y.y);
    }
  }
  [[nodiscard]] const Block& unknowns() const {
    if constexpr (is_motion) return given_.v;
    else return given_;
  }

  F force_;
  Given given_;  // scratch, as rate_ is
  Rate rate_;
};

/// The force of a state as its stepper calls it.
template <class S, class F>
struct SteppedForce : std::type_identity<F> {};
template <VectorOfParts S, class F>
struct SteppedForce<S, F> : std::type_identity<ForceOfParts<typename S::PlainObject, F>> {};
template <VectorOfParts V, class F>
struct SteppedForce<Motion<V>, F> : std::type_identity<ForceOfParts<Motion<typename V::PlainObject>, F>> {};

/// The force itself, or a new one that calls it.
template <class S, class F>
[[nodiscard]] decltype(auto) as_stepped(F& force) {
  if constexpr (std::is_same_v<typename SteppedForce<S, F>::type, F>) return (force);
  else return typename SteppedForce<S, std::reference_wrapper<F>>::type{std::ref(force)};
}

}}  // namespace phistep::PHISTEP_ABI
