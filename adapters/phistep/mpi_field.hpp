/// @file
/// What the fields of libraries on MPI share: reductions, and right-hand sides that are functions of the library's vectors.
#pragma once

#include <mpi.h>

#include <concepts>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "phistep/fields.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Operations on a field whose ranks are those of `Own::communicator(x)`; MPI_COMM_NULL is this one process.
template <class Own, std::floating_point Number>
struct MpiFieldOps : ArrayFieldOps<Own, Number> {
  static void total(auto x, std::span<double> mine) { reduce(x, mine, MPI_SUM); }
  static void greatest(auto x, std::span<double> mine) { reduce(x, mine, MPI_MAX); }
  static int rank(auto x) {
    int mine = 0;
    if (Own::communicator(x) != MPI_COMM_NULL) MPI_Comm_rank(Own::communicator(x), &mine);
    return mine;
  }
  static int ranks(auto x) {
    int all = 1;
    if (Own::communicator(x) != MPI_COMM_NULL) MPI_Comm_size(Own::communicator(x), &all);
    return all;
  }

 private:
  static void reduce(auto x, std::span<double> mine, MPI_Op how) {
    const MPI_Comm ranks = Own::communicator(x);
    if (ranks == MPI_COMM_NULL) return;
    if (MPI_Allreduce(MPI_IN_PLACE, mine.data(), static_cast<int>(mine.size()), MPI_DOUBLE, how, ranks) != MPI_SUCCESS)
      throw std::runtime_error("MPI: a reduction failed");
  }
};

/// f(arguments…); an error code that it returns becomes an exception on the rank that got it.
template <class Ops>
void call_checked(auto&& f, auto&&... arguments) {
  if constexpr (std::is_void_v<decltype(f(arguments...))>) f(arguments...);
  else Ops::check(f(arguments...));
}

/// Ψ as a function f(t, y, rate), or f(y, rate) where it doesn't depend on t, of handles, which sets all numbers of `rate`;
/// of a motion f(t, r, v, force). It may return an error code. Every rank calls it equally often.
template <class Ops, class F>
class HandleForce {
  using Handle = typename Ops::Handle;

 public:
  explicit HandleForce(F f) : f_{std::move(f)} {}
  const Field<Ops>& operator()(const Field<Ops>& y, double t) requires std::invocable<F&, double, Handle, Handle> {
    return rate_like(y, t, y.handle());
  }
  const Field<Ops>& operator()(const Field<Ops>& y) requires std::invocable<F&, Handle, Handle> {
    return rate_like(y, y.handle());
  }
  const Field<Ops>& operator()(const Field<Ops>& r, const Field<Ops>& v,
                               double t) requires std::invocable<F&, double, Handle, Handle, Handle> {
    return rate_like(v, t, r.handle(), v.handle());
  }

 private:
  const Field<Ops>& rate_like(const Field<Ops>& y, auto... arguments) {
    rate_.take_shape(y);
    call_checked<Ops>(f_, arguments..., rate_.handle());
    return rate_;
  }
  F f_;
  Field<Ops> rate_;
};

}}  // namespace phistep::PHISTEP_ABI
