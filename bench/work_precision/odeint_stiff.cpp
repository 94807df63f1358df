/// @file
/// Boost.Odeint's rows for stiff problems of a few unknowns: rosenbrock4, which is RODAS, on uBLAS vectors as it demands.
#define BOOST_UBLAS_NDEBUG 1
#include <boost/numeric/odeint.hpp>
#include <boost/numeric/ublas/matrix.hpp>
#include <boost/numeric/ublas/vector.hpp>

#include <algorithm>
#include <utility>

#include "odeint.hpp"
#include "problems/e5.hpp"
#include "problems/hires.hpp"
#include "problems/oregonator.hpp"
#include "problems/pollution.hpp"
#include "problems/relaxation.hpp"
#include "problems/robertson.hpp"

namespace work_precision::boost_odeint {
namespace {

using Vector = boost::numeric::ublas::vector<double>;
using Matrix = boost::numeric::ublas::matrix<double>;

template <class Problem>
Answer rosenbrock4(const System& system, double rtol, Film* film) {
  Vector y(static_cast<std::size_t>(system.size()));
  std::copy(system.start.data(), system.start.data() + system.size(), y.begin());
  Answer answer;
  long calls = 0;
  const auto rate = [&calls](const Vector& now, Vector& out, double) {
    if (++calls > most_calls) throw TooMany{};
    Problem::rate(&now[0], &out[0]);
  };
  const auto jacobian = [&answer](const Vector& now, Matrix& J, const double&, Vector& by_time) {
    ++answer.jacobians;
    std::fill(J.data().begin(), J.data().end(), 0.0);
    std::fill(by_time.begin(), by_time.end(), 0.0);
    double* const to = &J.data()[0];
    constexpr int n = Problem::State::RowsAtCompileTime;
    Problem::entries(&now[0], [to](int i, int j, double x) { to[i * n + j] = x; });
  };
  const double end = system.end();
  try {
    answer.steps = static_cast<std::int64_t>(
        integrate(odeint::make_controlled(system.a * rtol, rtol, odeint::rosenbrock4<double>()),
                  std::make_pair(rate, jacobian), y, end, std::min(1e-6, 1e-6 * end), film));
  } catch (const TooMany&) {
    return {};
  } catch (const std::exception&) {  // a singular matrix
    return {};
  }
  answer.y = Eigen::Map<const Eigen::VectorXd>(&y[0], system.size());
  answer.force_calls = calls;
  answer.factorizations = answer.jacobians;
  return answer;
}

template <class Problem>
void add(Table& table) {
  table.add("Odeint", "rosenbrock4", tolerances(),
            [system = table.system](double rtol, Film* film) { return rosenbrock4<Problem>(system, rtol, film); });
}

}  // namespace

void add_stiff(Table& table) {
  if (table.name == "robertson" || table.name == "robertson_late") add<problems::Robertson>(table);
  if (table.name == "e5" || table.name == "e5_late") add<problems::E5>(table);
  if (table.name == "van_der_pol") add<problems::Relaxation>(table);
  if (table.name == "hires") add<problems::Hires>(table);
  if (table.name == "oregonator") add<problems::Oregonator>(table);
  if (table.name == "pollution") add<problems::Pollution>(table);
}

}  // namespace work_precision::boost_odeint

/// Large problems are left out: rosenbrock4 knows dense matrices only.
void work_precision::odeint(Table& table) {
  boost_odeint::add_stiff(table);
  boost_odeint::add_motion(table);
}
