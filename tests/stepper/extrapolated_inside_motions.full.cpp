// What an extrapolated step tells of the solution between its ends, motions; the quick half is extrapolated_inside.test.cpp.
#include "stepper/extrapolated_inside_cases.hpp"

TEST_CASE("inside of steps the solution is known to the tolerance, and at their ends as it is") {
  problems::for_each_of_ten([](const auto& problem) {
    if constexpr (std::remove_cvref_t<decltype(problem)>::is_motion) extrapolated_inside_cases::check_problem(problem);
  });
}
