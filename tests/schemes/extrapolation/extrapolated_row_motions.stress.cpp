// Extrapolated steps under a tolerance, motions; the quick half is in extrapolated.test.cpp.
#include "schemes/extrapolation/extrapolated_row_cases.hpp"

TEST_CASE("the error is proportional to the tolerance, from 1e-2 to where double ends") {
  problems::for_each_of_ten([](const auto& problem) {
    if constexpr (std::remove_cvref_t<decltype(problem)>::is_motion) extrapolated_row_cases::check_problem(problem);
  });
}
