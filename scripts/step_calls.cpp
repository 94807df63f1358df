// One trapezoidal step of a Motion<Vector2d>, every call counted: compiled and read by step_calls.sh.
#include <phistep/phistep.hpp>

#include <cstdio>

namespace {
constexpr int most = 1 << 16;
void* called[most];
int calls = 0, depth = 0, deepest = 0;
bool counting = false;
}  // namespace

extern "C" {
[[gnu::no_instrument_function]] void __cyg_profile_func_enter(void* function, void* /*from*/) {
  if (!counting) return;
  if (calls < most) called[calls] = function;
  ++calls;
  if (++depth > deepest) deepest = depth;
}
[[gnu::no_instrument_function]] void __cyg_profile_func_exit(void* /*function*/, void* /*from*/) {
  if (counting) --depth;
}
}

[[gnu::no_instrument_function]] int main() {
  const auto spring = [](const Eigen::Vector2d& r) -> Eigen::Vector2d { return -r * (1 + r.squaredNorm()); };
  phistep::Motion<Eigen::Vector2d> y{{1, 0.5}, {0, 0.3}};
  phistep::PhiStepper stepper{y, spring, phistep::trapezoidal};
  if (!stepper.step(y, 0, 0.1)) return 1;
  const auto before = stepper.statistics();
  counting = true;
  const auto report = stepper.step(y, 0.1, 0.1);
  counting = false;
  if (!report) return 1;
  std::printf("calls %d\ndepth %d\niterations %lld\n", calls, deepest,
              static_cast<long long>((stepper.statistics() - before).iterations));
  for (int k = 0; k < calls && k < most; ++k) std::printf("%p\n", called[k]);
}
