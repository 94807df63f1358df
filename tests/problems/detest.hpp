#pragma once

// DETEST: the 25 problems of T. E. Hull, W. H. Enright, B. M. Fellen & A. E. Sedgwick, Comparing numerical methods for
// ordinary differential equations, SIAM J. Numer. Anal. 9 (1972) 603, all of them smooth and not stiff, from t = 0 to 20
// (also W. H. Enright & J. D. Pryce, ACM Trans. Math. Softw. 13 (1987) 1; Hairer, Nørsett & Wanner, Solving ODEs I,
// sect. II.10).

#include "problems/detest/moderate.hpp"
#include "problems/detest/orbits.hpp"
#include "problems/detest/second_order.hpp"
#include "problems/detest/single.hpp"
#include "problems/detest/small.hpp"

namespace problems {

/// f(P{}) for a problem P of each.
template <class F>
void for_each_of_detest(F&& f) {
  using namespace detest;
  f(A1{}), f(A2{}), f(A3{}), f(A4{}), f(A5{});
  f(B1{}), f(B2{}), f(B3{}), f(B4{}), f(B5{});
  f(C1{}), f(C2{}), f(C3{}), f(C4{}), f(C5{});
  f(D1{}), f(D2{}), f(D3{}), f(D4{}), f(D5{});
  f(E1{}), f(E2{}), f(E3{}), f(E4{}), f(E5{});
}

}  // namespace problems
