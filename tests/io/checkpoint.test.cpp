// Checkpoint files: read back whole, or refused with nothing changed. (That restarts keep all bits: contract/restart*.)
// Here of a motion by Verlet's scheme, in the full tier of an implicit one.
#include <phistep/io/checkpoint.hpp>
#include <phistep/phistep.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;
namespace fs = std::filesystem;

#if PHISTEP_QUICK
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
#elif PHISTEP_FULL
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
#endif

namespace checkpoint_cases {

/// A folder that goes with the test.
struct Folder {
  fs::path path;
  Folder() : path{fs::temp_directory_path() / ("phistep_checkpoint_" + std::to_string(std::random_device{}()))} {
    fs::create_directory(path);
  }
  ~Folder() { fs::remove_all(path); }
  Folder(const Folder&) = delete;
  [[nodiscard]] fs::path operator/(const char* name) const { return path / name; }
};

inline std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}
inline void write(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}
/// What save_checkpoint would write; nothing is forgotten.
template <class... Parts>
std::string bytes_of(const Parts&... parts) {
  std::ostringstream out;
  detail::write_checkpoint(out, parts...);
  return out.str();
}
template <class... Parts>
void load_bytes(const std::string& bytes, Parts&... parts) {
  std::istringstream in(bytes);
  load_checkpoint(in, parts...);
}
/// The bytes with a checksum that fits.
inline std::string sealed(std::string bytes) {
  bytes.resize(bytes.size() - 8);
  const std::uint64_t end = checksum(std::as_bytes(std::span(bytes)));
  bytes.append(reinterpret_cast<const char*>(&end), sizeof end);
  return bytes;
}

using State = Scene::State;

/// A run that has made a few steps.
struct Program {
  State y;
  double t = 0;
  decltype(Scene::make(State{})) stepper;
  explicit Program(int steps, Eigen::Index n = 2) : y{Scene::start(n)}, stepper{Scene::make(y)} {
    for (int k = 0; k < steps; ++k) step();
  }
  void step() {
    REQUIRE(stepper.step(y, t, 0.1));
    t += 0.1;
  }
  [[nodiscard]] std::string bytes() const { return bytes_of(stepper, y, t); }
  std::string save() {
    std::ostringstream out;
    save_checkpoint(out, stepper, y, t);
    return out.str();
  }
};

/// Can be written, not read.
struct Grumpy {
  void archive(auto& ar) { ar.check(!std::remove_reference_t<decltype(ar)>::reading); }
};
/// Can't be written once n > 0.
struct Stubborn {
  int n = 0;
  void archive(auto& ar) {
    if (n > 0) throw std::runtime_error("stubborn");
    ar(n);
  }
};

/// Refused, for this reason, with every bit as it was.
inline void check_refused(const std::string& bytes, const std::string& why) {
  Program run(2);
  const std::string before = run.bytes();
  try {
    load_bytes(bytes, run.stepper, run.y, run.t);
    FAIL_CHECK("accepted");
  } catch (const CheckpointError& error) {
    CHECK_THAT(error.what(), contains(why));
  }
  CHECK(run.bytes() == before);
}

inline void is_read_back() {
  const Folder folder;
  const fs::path path = folder / "run.checkpoint";
  Program run(3);
  std::vector<double> seen{1, 2, 3};
  std::string note = "half way";
  std::mt19937 random(4);
  random.discard(5);

  Program again(0);
  std::vector<double> saw;
  std::string noted;
  std::mt19937 luck;
  const auto load = [&] { return load_checkpoint(path, again.stepper, again.y, again.t, saw, noted, luck); };
  CHECK_FALSE(load());
  CHECK(again.bytes() == Program(0).bytes());

  save_checkpoint(path, run.stepper, run.y, run.t, seen, note, random);
  CHECK(load());
  CHECK(again.bytes() == run.bytes());
  CHECK(saw == seen);
  CHECK(noted == note);
  CHECK(luck == random);
  CHECK(fs::directory_iterator(folder.path)->path() == path);  // nothing beside it
}

inline void one_after_another() {
  Program a(1), b(3), to(0);
  std::stringstream stream;
  save_checkpoint(stream, a.stepper, a.y, a.t);
  save_checkpoint(stream, b.stepper, b.y, b.t);
  load_checkpoint(stream, to.stepper, to.y, to.t);
  CHECK(to.bytes() == a.bytes());
  load_checkpoint(stream, to.stepper, to.y, to.t);
  CHECK(to.bytes() == b.bytes());
}

inline void goes_on_as_a_new_one() {
  Program run(4), elsewhere(9);
  load_bytes(run.save(), elsewhere.stepper, elsewhere.y, elsewhere.t);
  for (int k = 0; k < 5; ++k) run.step(), elsewhere.step();
  CHECK(elsewhere.bytes() == run.bytes());
}

inline void changed_bytes_are_refused() {
  const std::string good = Program(3).bytes();
  Program run(1);
  const std::string before = run.bytes();
  int accepted = 0, changed = 0;
  for (std::size_t i = 0; i < good.size(); ++i)
    for (int flip = 1; flip < 256; ++flip) {
      std::string bad = good;
      bad[i] = static_cast<char>(bad[i] ^ flip);
      try {
        load_bytes(bad, run.stepper, run.y, run.t);
        ++accepted;
      } catch (const CheckpointError&) {
      }
      if (flip % 51 == 0) changed += run.bytes() != before;
    }
  CHECK(accepted == 0);
  CHECK(changed == 0);
}

inline void truncations_are_refused() {
  const std::string good = Program(3).bytes();
  for (std::size_t n = 0; n < good.size(); ++n)
    check_refused(good.substr(0, n), n < 8 ? "is not a phistep checkpoint" : "is truncated");
  const Folder folder;
  write(folder / "long", good + "x");
  Program run(1);
  const std::string before = run.bytes();
  CHECK_THROWS_WITH(static_cast<void>(load_checkpoint(folder / "long", run.stepper, run.y, run.t)),
                    contains("goes on after its end") && contains("long"));
  CHECK(run.bytes() == before);
}

inline void other_files_are_refused() {
  std::string good = Program(3).bytes();
  check_refused("", "is not a phistep checkpoint");
  check_refused("t,y\n0,1\n0.1,0.9\nand so on, a table of numbers\n", "is not a phistep checkpoint");
  std::string text = good;
  text.erase(text.find('\r'), 1);  // what a transfer as text does
  check_refused(text, "is not a phistep checkpoint");
  std::string version = good;
  ++version[8];
  check_refused(sealed(version), "version 3 of the format, this program reads version 2");
  std::string damaged = good;
  damaged[damaged.size() / 2] ^= 1;
  check_refused(damaged, "is damaged: its checksum is wrong");
  const Folder folder;
  Program run(1);
  CHECK_THROWS_AS(static_cast<void>(load_checkpoint(folder.path, run.stepper, run.y, run.t)), CheckpointError);
}

inline void other_sizes_are_refused() {
  for (const int steps : {0, 3}) {
    const Program larger(steps, 3);
    check_refused(larger.bytes(), "stepper/state is \"3 x 1");
    const Program same(steps);
    check_refused(bytes_of(same.stepper, larger.y, same.t),
                  "of another size");  // found when the stepper is read already
    check_refused(bytes_of(larger.stepper, same.y, same.t), "stepper/state is \"3 x 1");
  }
}

inline void forged_bytes_are_refused_or_read() {
  // With a checksum that fits: beyond it, only the reader's own care is left. (Sanitizers look on.)
  const std::string good = Program(3).bytes();
  std::mt19937 random(8);
  int refused = 0;
  for (std::size_t i = 32; i + 8 < good.size(); ++i)
    for (const int value : {0, 1, 0x7f, 0xff}) {
      std::string bad = good;
      bad[i] = static_cast<char>(value);
      Program run(1);
      try {
        load_bytes(sealed(bad), run.stepper, run.y, run.t);
      } catch (const CheckpointError&) {
        ++refused;
      }
    }
  CHECK(refused > 0);
}

inline void edits_are_noticed() {
  Program run(3);
  const std::string bytes = run.save();
  const auto calls_of_a_step = [&bytes](bool edited) {
    Program again(0);
    load_bytes(bytes, again.stepper, again.y, again.t);
    if (edited) Scene::first(again.y) = std::nextafter(Scene::first(again.y), 2.0);
    const auto before = again.stepper.statistics().force_calls;
    again.step();
    return std::pair{again.stepper.statistics().force_calls - before, again.bytes()};
  };
  const auto [untouched, same] = calls_of_a_step(false);
  const auto [noticed, other] = calls_of_a_step(true);
  CHECK(noticed == untouched + Scene::carried);  // Ψ at the edited state
  CHECK(other != same);
  run.step();
  CHECK(run.bytes() == same);
}

inline void restarts_call_no_force() {
  const std::string bytes = Program(3).bytes();
  Program again(0);
  Scene::calls = 0;
  load_bytes(bytes, again.stepper, again.y, again.t);
  CHECK(Scene::calls == 0);
}

inline void unwritten_ones_leave_the_old() {
  const Folder folder;
  const fs::path path = folder / "run.checkpoint";
  save_checkpoint(path, Stubborn{0});
  const std::string old = read(path);
  CHECK_THROWS_WITH(save_checkpoint(path, Stubborn{1}), contains("stubborn"));
  CHECK(read(path) == old);
  CHECK(std::distance(fs::directory_iterator{path.parent_path()}, {}) == 1);  // nothing is left beside it
  CHECK_THROWS_WITH(save_checkpoint(folder / "no/such/folder", 1), contains("can't be written"));
}

/// A link to the checkpoint of the day is not replaced by a file, though there is none behind it yet.
inline void links_stay() {
  const Folder folder;
  const fs::path link = folder / "latest", file = folder / "monday";
  fs::create_symlink("monday", link);
  for (const double x : {1.0, 2.0}) {
    save_checkpoint(link, x);
    CHECK(fs::is_symlink(link));
    double there = 0;
    REQUIRE(load_checkpoint(file, there));
    CHECK(there == x);
  }
  const fs::path circle = folder / "circle";
  fs::create_symlink("circle", circle);
  save_checkpoint(circle, 3.0);
  double there = 0;
  REQUIRE(load_checkpoint(circle, there));
  CHECK(there == 3);
}

inline void unread_rest_changes_nothing() {
  const Program run(3);
  Program to(1);
  double extra = 0;
  Grumpy grumpy;
  const std::string before = to.bytes(), bytes = bytes_of(run.t, run.stepper, run.y, 5.0, grumpy);
  CHECK_THROWS_WITH(load_bytes(bytes, to.t, to.stepper, to.y, extra, grumpy), contains("values that can't be"));
  CHECK(to.bytes() == before);
  CHECK(extra == 0);
}

}  // namespace checkpoint_cases

using namespace checkpoint_cases;

#if PHISTEP_QUICK

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
TEST_CASE("a link to a checkpoint stays a link") { links_stay(); }

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

#elif PHISTEP_FULL
// Checkpoint files of an implicit stepper, and of everything that has a history.

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
TEST_CASE("a link to a checkpoint stays a link") { links_stay(); }

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

#endif
