// A few unknowns of first order, stiff and not.
#include "problems/brusselator.hpp"
#include "problems/e5.hpp"
#include "problems/hires.hpp"
#include "problems/oregonator.hpp"
#include "problems/pollution.hpp"
#include "problems/prothero_robinson.hpp"
#include "problems/ring_modulator.hpp"
#include "problems/robertson.hpp"

#include "rows.hpp"

void automatic::small_problems() {
  using namespace problems;
  const ProtheroRobinson mild{-10};
  measure(problem("Prothero-Robinson, lambda = -10", mild.exact(0), mild, 10, mild.exact(10), 1.0));
  const auto decay = [](const Eigen::Vector2d& y) -> Eigen::Vector2d { return {-1e6 * (y[0] - y[1]), -y[1]}; };
  const double left = std::exp(-1.0);
  measure(problem("decay at rate 1e6", Eigen::Vector2d(1e6 / (1e6 - 1), 1), decay, 1,
                  Eigen::Vector2d(1e6 / (1e6 - 1) * left, left), 1e-3));
  measure(problem("Brusselator", Brusselator::start(), Brusselator{}, Brusselator::end, Brusselator::exact(), 1.0));
  measure(problem("HIRES", Hires::start(), Hires{}, Hires::end, Hires::exact(), 1e-4));
  measure(problem("Robertson to 40", Robertson::start(), Robertson{}, Robertson::end, Robertson::exact(), 1e-6));
  measure(
      problem("Robertson to 1e11", Robertson::start(), Robertson{}, Robertson::late, Robertson::exact_late(), 1e-8));
  measure(problem("Oregonator", Oregonator::start(), Oregonator{}, Oregonator::end, Oregonator::exact(), 1e-6));
  measure(problem("E5 to 1e5", E5::start(), E5{}, 1e5, E5::at_1e5(), 1e-12));
  measure(problem("E5 to 1e11", E5::start(), E5{}, 1e11, E5::at_1e11(), 1e-22));
  measure(problem("Pollution", Pollution::start(), Pollution{}, Pollution::end, Pollution::exact(), 1e-4));
}
