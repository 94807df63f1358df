// A tolerance means what it says, as in tolerance.test.cpp: TR-BDF2 on the other five. In short:
// tolerance.test.cpp.

#include "accuracy/tolerance_cases.hpp"

TEST_CASE("the error is proportional to the tolerance, and no larger than the problem makes it") {
  problems::for_each_of_ten([](const auto& problem) {
    using Problem = std::remove_cvref_t<decltype(problem)>;
    if constexpr (!is_of_first_five<Problem>)
      check(problem, problem.name + std::string(", TR-BDF2"), phistep::tr_bdf2, problems::conditioning(problem));
  });
}
