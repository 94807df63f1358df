// A tolerance means what it says, as in tolerance.test.cpp: velocity Verlet on the motions. In short:
// tolerance.test.cpp.

#include "accuracy/tolerance_cases.hpp"

TEST_CASE("the error is proportional to the tolerance, and no larger than the problem makes it") {
  problems::for_each_of_ten([](const auto& problem) {
    using Problem = std::remove_cvref_t<decltype(problem)>;
    if constexpr (Problem::is_motion)
      check(problem, problem.name + std::string(", velocity Verlet"), phistep::velocity_verlet,
            problems::conditioning(problem));
  });
}
