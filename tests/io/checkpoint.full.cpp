// Checkpoint files of an implicit stepper, and of everything that has a history. The quick half is checkpoint.test.cpp.
#include <phistep/phistep.hpp>

namespace checkpoint_cases {

struct Scene {
  using State = Eigen::VectorXd;
  static inline int calls = 0;
  static constexpr int carried = 0;  // differences ask for it again
  struct Decay {
    State operator()(const State& y) const {
      ++calls;
      return -2 * y - y.cwiseProduct(y);
    }
  };
  static State start(Eigen::Index n = 2) { return State::LinSpaced(n, 1, 2); }
  static auto make(const State& y) {
    return phistep::PhiStepper{y, Decay{}, phistep::tr_bdf2, phistep::newton({.rtol = 1e-4, .atol = 1e-6})};
  }
  static double& first(State& y) { return y[0]; }
};

}  // namespace checkpoint_cases

#include "io/checkpoint_cases.hpp"

using namespace checkpoint_cases;

TEST_CASE("a file is read back, whatever else it holds, and a first start is told") { is_read_back(); }
TEST_CASE("a stream may hold one checkpoint after another") { one_after_another(); }
TEST_CASE("a stepper that has been elsewhere goes on as well as a new one") { goes_on_as_a_new_one(); }
TEST_CASE("every change of a byte is refused, and changes nothing") { changed_bytes_are_refused(); }
TEST_CASE("every truncation is refused, and so is a file that goes on") { truncations_are_refused(); }
TEST_CASE("files that are something else are refused by name") { other_files_are_refused(); }
TEST_CASE("states of another size are refused") { other_sizes_are_refused(); }
TEST_CASE("bytes that somebody forged are refused or read, never more") { forged_bytes_are_refused_or_read(); }
TEST_CASE("an edit after a restart is noticed, and only an edit") { edits_are_noticed(); }
TEST_CASE("a restart calls no force") { restarts_call_no_force(); }
TEST_CASE("a checkpoint that can't be written leaves the old one") { unwritten_ones_leave_the_old(); }

TEST_CASE("checkpoints of other programs are refused") {
  const Program run(3);
  check_refused(bytes_of(run.stepper, run.y), "the checkpoint has no 2");
  PhiStepper other{Scene::start(), Scene::Decay{}, trapezoidal, newton({.rtol = 1e-4, .atol = 1e-6})};
  check_refused(bytes_of(other, run.y, run.t), "stepper/scheme is \"trapezoidal\", here it is \"tr_bdf2\"");
  const Eigen::VectorXf y = Scene::start().cast<float>();
  PhiStepper single{y, [](const Eigen::VectorXf& x) -> Eigen::VectorXf { return -x; }, tr_bdf2};
  check_refused(bytes_of(single, y, run.t), "state is \"2 x 1 of f4\", here it is \"2 x 1 of f8\"");
}

TEST_CASE("values that nobody can have written are refused") {
  const auto check = [](auto bad, auto&& spoil) {
    const auto good = bad;
    auto to = good;
    CHECK_NOTHROW(load_bytes(bytes_of(good), to));
    spoil(bad);
    CHECK_THROWS_WITH(load_bytes(bytes_of(bad), to), contains("values that can't be"));
  };
  constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max();
  check(Statistics{}, [](Statistics& s) { s.force_calls = most; });
  check(Statistics{}, [](Statistics& s) { s.steps = -1; });
  check(Failure{}, [](Failure& f) { f.iterations = -1; });
  check(Failure{}, [](Failure& f) { f.iterations = std::numeric_limits<int>::max(); });
  check(RunReport{}, [](RunReport& r) { r.statistics.rejections = most; });
}

TEST_CASE("nothing changes where what follows can't be read") {
  unread_rest_changes_nothing();
  Grumpy grumpy;
  // The same through a wrapper, in front of what fails.
  Scene::State y = Scene::start(), y1 = Scene::start();
  Halving a{Scene::make(y), 3}, b{Scene::make(y1), 3};
  REQUIRE(a.step(y, 0.0, 0.1));
  const std::string fresh = bytes_of(b);
  const std::string halving = bytes_of(a, grumpy);
  CHECK_THROWS_AS(load_bytes(halving, b, grumpy), CheckpointError);
  CHECK(bytes_of(b) == fresh);
}
