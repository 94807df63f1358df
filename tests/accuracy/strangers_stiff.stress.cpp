// Robertson's reactions to 1e11 and the advice for them, as a newcomer asks: with rtol alone.
#include <phistep/advise.hpp>

#include "accuracy/mechanisms.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "problems/robertson.hpp"
#include "support/catch.hpp"

namespace {

using mechanisms::Vec;

/// |y₁ − exact| at 1e11 in units of rtol; 1e300 where the run fails. It was 1 at the start, and is 2.08e-8.
double late_error(auto scheme, const phistep::tolerance& control) {
  mechanisms::Member m = mechanisms::known_problem<problems::Robertson>("", problems::Robertson::late);
  m.rates.unit = Vec::Ones(3);
  const mechanisms::End end = run(m.rates, m.start, m.time, scheme, control);
  return end.report ? std::abs(end.y[0] - problems::Robertson::exact_late()[0]) / control.rtol : 1e300;
}
double by_name(const std::string& scheme, double rtol) {
  const phistep::tolerance control{.rtol = rtol, .max_steps = 100'000};
  if (scheme == "radau") return late_error(phistep::radau, control);
  if (scheme == "rodas5p") return late_error(phistep::rodas5p, control);
  if (scheme == "rodas4p2") return late_error(phistep::rodas4p2, control);
  return 1e300;  // no other scheme is for stiff problems
}

}  // namespace

TEST_CASE("Robertson to 1e11 by radau: with a small atol y1 is right") {
  for (const double rtol : {1e-3, 1e-4, 1e-5})
    CHECK(late_error(phistep::radau, {.rtol = rtol, .atol = 1e-12 * rtol, .max_steps = 100'000}) < 100);
}
TEST_CASE("Robertson to 1e11 by radau: with rtol alone y1 is right") {
  double worst = 0;
  for (const double rtol : {1e-3, 1e-4, 1e-5}) worst = std::max(worst, by_name("radau", rtol));
  CHECK(worst < 100);
}

TEST_CASE("advise: the lines for Robertson to 1e11 work, or a warning tells that they may not") {
  mechanisms::Rates rates = mechanisms::known_problem<problems::Robertson>("", 0).rates;
  rates.unit = Vec::Ones(3);
  bool good = true;
  for (const double rtol : {1e-3, 1e-5}) {
    const phistep::Advice advice =
        phistep::advise(Vec{{1, 0, 0}}, rates, {0, problems::Robertson::late}, phistep::tolerance{.rtol = rtol});
    good = good && (!advice.warnings.empty() || by_name(advice.scheme, rtol) < 100);
  }
  CHECK(good);
}
