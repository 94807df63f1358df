/// @file
/// Boost.Odeint's rows for motions: Dormand-Prince 5(4), Fehlberg 7(8), Bulirsch-Stoer, on arrays of fixed size.
#include <algorithm>
#include <array>
#include <boost/numeric/odeint.hpp>
#include <string>
#include <utility>
#include <vector>

#include "odeint.hpp"
#include "problems/kepler_force.hpp"
#include "problems/outer_solar_system.hpp"
#include "problems/pleiades.hpp"

namespace work_precision::boost_odeint {
namespace {

template <class Force>
constexpr std::size_t unknowns = 2 * static_cast<std::size_t>(Force::Vector::RowsAtCompileTime);

template <class Force>
struct Motion {
  using State = std::array<double, unknowns<Force>>;
  long& calls;
  void operator()(const State& y, State& out, double) const {
    constexpr std::size_t n = unknowns<Force> / 2;
    if (++calls > most_calls) throw TooMany{};
    std::copy(y.begin() + n, y.end(), out.begin());
    Force::acceleration(y.data(), out.data() + n);
  }
};

template <class Force, class Stepper>
Answer run(const System& system, const Stepper& stepper, Film* film) {
  using State = typename Motion<Force>::State;
  State y;
  std::copy(system.start.data(), system.start.data() + y.size(), y.begin());
  Answer answer;
  long calls = 0;
  const Motion<Force> f{calls};
  const double end = system.end(), first = 1e-6 * end;
  try {
    answer.steps = static_cast<std::int64_t>(integrate(stepper, f, y, end, first, film));
  } catch (const TooMany&) {
    return {};
  } catch (const std::exception&) {
    return {};
  }
  answer.y = Eigen::Map<const Eigen::VectorXd>(y.data(), static_cast<Eigen::Index>(y.size()));
  answer.force_calls = calls;
  return answer;
}

template <class Force>
void add(Table& table) {
  using State = typename Motion<Force>::State;
  const System& system = table.system;
  table.add("Odeint", "dopri5", tolerances(), [system](double rtol, Film* film) {
    return run<Force>(system, odeint::make_controlled(system.a * rtol, rtol, odeint::runge_kutta_dopri5<State>()),
                      film);
  });
  table.add("Odeint", "fehlberg78", tolerances(), [system](double rtol, Film* film) {
    return run<Force>(system, odeint::make_controlled(system.a * rtol, rtol, odeint::runge_kutta_fehlberg78<State>()),
                      film);
  });
  table.add("Odeint", "Bulirsch-Stoer", tolerances(), [system](double rtol, Film* film) {
    return run<Force>(system, odeint::bulirsch_stoer<State>(system.a * rtol, rtol, 1.0, 1.0), film);
  });
}

}  // namespace

void add_motion(Table& table) {
  if (table.name == "kepler") add<problems::KeplerForce>(table);
  if (table.name == "pleiades") add<problems::Pleiades>(table);
  if (table.name == "outer_solar_system") add<problems::OuterSolarSystem>(table);
}

}  // namespace work_precision::boost_odeint
