// Checkpoint files: read back whole, or refused with nothing changed. (That restarts keep all bits: contract/restart*.)
// Here of a motion by Verlet's scheme, in checkpoint.full.cpp of an implicit one.
#include <phistep/phistep.hpp>

namespace checkpoint_cases {

struct Scene {
  using Vec = Eigen::VectorXd;
  using State = phistep::Motion<Vec>;
  static inline int calls = 0;
  static constexpr int carried = 1;
  struct Pull {
    Vec operator()(const Vec& r) const {
      ++calls;
      return -2 * r - r.cwiseProduct(r);
    }
  };
  static State start(Eigen::Index n = 2) { return {Vec::LinSpaced(n, 1, 2), Vec::LinSpaced(n, 0, 1)}; }
  static auto make(const State& y) { return phistep::PhiStepper{y, Pull{}, phistep::velocity_verlet}; }
  static double& first(State& y) { return y.r[0]; }
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
  check_refused(bytes_of(run.y, run.stepper, run.t), "has no stepper: where it should be there is 0");
  check_refused(bytes_of(run.stepper, run.y, 1.0f), "2 is of another kind: f4 there, f8 here");
  check_refused(bytes_of(run.stepper, run.y, run.t, 3), "holds 3, which this program has no place for");
  check_refused(bytes_of(run.stepper, run.y, "time", run.t), "has no 2: where it should be there is time");
  PhiStepper other{Scene::start(), Scene::Pull{}, symplectic_euler};
  check_refused(bytes_of(other, run.y, run.t),
                "stepper/scheme is \"symplectic_euler\", here it is \"velocity_verlet\"");
}

TEST_CASE("nothing changes where what follows can't be read") { unread_rest_changes_nothing(); }

// A program is edited: an unrelated lambda is written before the force, whose type is called {lambda#2} from then on.
TEST_CASE("a checkpoint is read after an unrelated lambda was written before the force") {
  using Vec = Eigen::Vector2d;
  const auto before_the_edit = [](const Vec& r) -> Vec { return -2 * r; };  // the same force twice: as it was called …
  const auto after_the_edit = [](const Vec& r) -> Vec { return -2 * r; };   // … and as it is called now
  const auto start = [](Motion<Vec>& y) { y = {Vec{1, 2}, Vec{0, 1}}; };
  Motion<Vec> y, other;
  start(y);
  start(other);
  double t = 0.1, other_t = 0;
  PhiStepper stepper{y, before_the_edit, velocity_verlet};
  REQUIRE(stepper.step(y, 0, 0.1));
  const std::string bytes = bytes_of(stepper, y, t);
  PhiStepper resumed{other, after_the_edit, velocity_verlet};
  CHECK_NOTHROW(load_bytes(bytes, resumed, other, other_t));
  CHECK(other_t == t);
  CHECK((other.r == y.r && other.v == y.v));
  REQUIRE(stepper.step(y, 0.1, 0.1));
  REQUIRE(resumed.step(other, 0.1, 0.1));
  CHECK((other.r == y.r && other.v == y.v));
}
