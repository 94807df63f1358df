// A tolerance means what it says, as in tolerance.test.cpp: the trapezoidal rule on those that are not stiff. In short:
// tolerance.test.cpp.

#include "accuracy/tolerance_cases.hpp"

TEST_CASE("the error is proportional to the tolerance, and no larger than the problem makes it") {
  problems::for_each_of_ten([](const auto& problem) {
    using Problem = std::remove_cvref_t<decltype(problem)>;
    REQUIRE(problem.stiff == is_stiff<Problem>);
    if constexpr (!is_stiff<Problem>)
      check(problem, problem.name + std::string(", trapezoidal"), phistep::trapezoidal,
            problems::conditioning(problem));
  });
}
