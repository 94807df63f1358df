/// @file
/// Boost.Odeint's rows: Dormand-Prince 5(4), Fehlberg 7(8), Bulirsch-Stoer on arrays of fixed size, the problem inlined.
#include <algorithm>
#include <array>
#include <boost/numeric/odeint.hpp>
#include <exception>

#include "../work_precision/odeint.hpp"
#include "problems/detest.hpp"
#include "problems/smooth.hpp"
#include "tables.hpp"

namespace work_precision::smooth {
namespace {

using namespace boost_odeint;

template <class P>
using State = std::array<double, P::n>;

template <class P>
struct Flow {
  long& calls;
  void operator()(const State<P>& y, State<P>& out, double t) const {
    if (++calls > most_calls) throw TooMany{};
    P::rate(t, y.data(), out.data());
  }
};

template <class P, class Stepper>
Answer run(const Stepper& stepper, Film* film) {
  State<P> y = P::start();
  Answer answer;
  long calls = 0;
  try {
    answer.steps = static_cast<std::int64_t>(boost_odeint::integrate(stepper, Flow<P>{calls}, y, P::end, 1e-3, film));
  } catch (const TooMany&) {
    return {};
  } catch (const std::exception&) {  // a step that can't be made
    return {};
  }
  answer.y = Eigen::Map<const Eigen::VectorXd>(y.data(), static_cast<Eigen::Index>(y.size()));
  answer.force_calls = calls;
  return answer;
}

template <class P>
void add(Table& table) {
  namespace od = boost_odeint::odeint;
  const double a = table.system.a;
  table.add("Odeint", "dopri5", tolerances(), [a](double rtol, Film* film) {
    return run<P>(od::make_controlled(a * rtol, rtol, od::runge_kutta_dopri5<State<P>>()), film);
  });
  table.add("Odeint", "fehlberg78", tolerances(), [a](double rtol, Film* film) {
    return run<P>(od::make_controlled(a * rtol, rtol, od::runge_kutta_fehlberg78<State<P>>()), film);
  });
  table.add("Odeint", "Bulirsch-Stoer", tolerances(), [a](double rtol, Film* film) {
    return run<P>(od::bulirsch_stoer<State<P>>(a * rtol, rtol, 1.0, 1.0), film);
  });
}

}  // namespace

void odeint(Table& table) {
  const auto add_if = [&](auto problem) {
    using P = decltype(problem);
    if (table.name == P::name) add<P>(table);
  };
  problems::for_each_of_detest(add_if);
  problems::for_each_smooth(add_if);
}

}  // namespace work_precision::smooth
