// Checkpoints through streams that fail at every byte: what is refused has changed nothing, what was there before is still
// there, and the run that failed to save goes on.
#include <phistep/io.hpp>
#include <phistep/phistep.hpp>

#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <ios>
#include <iterator>
#include <random>
#include <sstream>
#include <stdexcept>
#include <streambuf>
#include <string>

#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::Vector2d;

namespace {

/// Takes or gives `room` bytes, then nothing more, or throws.
class Narrow : public std::streambuf {
 public:
  explicit Narrow(std::size_t room, bool throws, std::string text = {})
      : text_{std::move(text)}, room_{room}, throws_{throws} {
    setg(text_.data(), text_.data(), text_.data() + std::min(room_, text_.size()));
  }

 protected:
  int_type overflow(int_type c) override {
    if (taken_ == room_) return give_up();
    ++taken_;
    return c;
  }
  std::streamsize xsputn(const char*, std::streamsize n) override {  // a short write
    const auto fits = std::min(static_cast<std::size_t>(n), room_ - taken_);
    taken_ += fits;
    if (fits < static_cast<std::size_t>(n) && throws_) give_up();
    return static_cast<std::streamsize>(fits);
  }
  int_type underflow() override { return text_.size() <= room_ ? traits_type::eof() : give_up(); }
  int sync() override { return taken_ < room_ ? 0 : -1; }

 private:
  int_type give_up() const {
    if (throws_) throw std::ios_base::failure("the wire was cut");
    return traits_type::eof();
  }
  std::string text_;
  std::size_t room_, taken_ = 0;
  bool throws_;
};

/// While it lives, files hold so many bytes and no more.
class FullDisk {
 public:
  explicit FullDisk(rlim_t room) : signal_{std::signal(SIGXFSZ, SIG_IGN)} {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{room, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, signal_);
  }

 private:
  void (*signal_)(int);
  rlimit before_{};
};

struct Whole {
  Motion<Vec> y{Vec{1, 0}, Vec{0, 1}};
  PhiStepper<Motion<Vec>, Vec (*)(const Vec&), VelocityVerlet> stepper{y, [](const Vec& r) -> Vec { return -r; },
                                                                       velocity_verlet};
  Recorder<Motion<Vec>> recorder;
  Run<decltype(stepper), Motion<Vec>, FixedStep, Recorder<Motion<Vec>>&> run{
      stepper, y, {0.0, 1.0}, fixed(0.1), recorder};
  [[nodiscard]] std::string bytes() const {
    std::ostringstream out;
    save_checkpoint(out, run);
    return out.str();
  }
};

}  // namespace

TEST_CASE("a stream that takes no more, at every byte: told, and the run goes on") {
  Whole whole;
  for (int n = 0; n < 4; ++n) REQUIRE(whole.run.advance());
  const std::string good = whole.bytes();
  int accepted = 0, changed = 0, others = 0;
  for (const bool throws : {false, true})
    for (const bool enabled : {false, true})
      for (std::size_t room = 0; room <= good.size(); ++room) {
        Narrow buffer(room, throws);
        std::ostream out(&buffer);
        if (enabled) out.exceptions(std::ios::badbit | std::ios::failbit);
        try {
          save_checkpoint(out, whole.run);
          ++accepted;
        } catch (const CheckpointError&) {
        } catch (const std::ios_base::failure&) {
          others += !enabled;
        }
        changed += whole.bytes() != good;
      }
  CHECK(accepted == 0);  // the last byte fits, but the flush fails
  CHECK(changed == 0);
  CHECK(others == 0);
  while (whole.run.advance()) {
  }
  Whole unbroken;
  REQUIRE(unbroken.run.finish());
  CHECK(whole.run.report());
  CHECK((whole.y.r == unbroken.y.r && whole.y.v == unbroken.y.v));
}

TEST_CASE(
    "a stream that gives no more, at every byte: refused, nothing changed, and the whole one is read afterwards") {
  Whole whole;
  for (int n = 0; n < 4; ++n) REQUIRE(whole.run.advance());
  const std::string good = whole.bytes();
  int accepted = 0, changed = 0, others = 0;
  for (const bool throws : {false, true})
    for (const bool enabled : {false, true})
      for (std::size_t room = 0; room < good.size(); ++room) {
        Whole other;
        for (int n = 0; n < 2; ++n) REQUIRE(other.run.advance());
        const std::string before = other.bytes();
        Narrow buffer(room, throws, good);
        std::istream in(&buffer);
        if (enabled) in.exceptions(std::ios::badbit | std::ios::failbit);
        try {
          load_checkpoint(in, other.run);
          ++accepted;
        } catch (const CheckpointError&) {
        } catch (const std::ios_base::failure&) {
          others += !enabled;
        }
        changed += other.bytes() != before;
        std::istringstream again(good);
        load_checkpoint(again, other.run);
        changed += other.bytes() != good;
      }
  CHECK(accepted == 0);
  CHECK(changed == 0);
  CHECK(others == 0);
}

TEST_CASE("a full disk: told, and the old checkpoint is still there") {
  namespace fs = std::filesystem;
  if (!fs::exists("/dev/full")) return;
  Whole whole;
  REQUIRE(whole.run.advance());
  const std::string good = whole.bytes();
  std::ofstream full("/dev/full", std::ios::binary);
  CHECK_THROWS_AS(save_checkpoint(full, whole.run), CheckpointError);
  CHECK(whole.bytes() == good);

  const fs::path folder = fs::temp_directory_path() / ("phistep_streams_" + std::to_string(std::random_device{}()));
  fs::create_directory(folder);
  const fs::path path = folder / "run.checkpoint";
  save_checkpoint(path, whole.run);
  REQUIRE(whole.run.advance());
  {
    const FullDisk disk{100};
    CHECK_THROWS_AS(save_checkpoint(path, whole.run), CheckpointError);
  }
  CHECK(std::distance(fs::directory_iterator(folder), fs::directory_iterator{}) == 1);  // nothing is left beside
  Whole other;
  CHECK(load_checkpoint(path, other.run));
  CHECK(other.bytes() == good);
  fs::remove_all(folder);
}

TEST_CASE("a csv on a full disk is an exception, and the run goes on without it") {
  Whole unbroken;
  REQUIRE(unbroken.run.finish());
  Motion<Vec> y{Vec{1, 0}, Vec{0, 1}};
  PhiStepper stepper{y, [](const Vec& r) -> Vec { return -r; }, velocity_verlet};
  for (std::size_t room = 0; room < 200; room += 7) {
    y = {Vec{1, 0}, Vec{0, 1}};
    Narrow buffer(room, true);
    std::ostream out(&buffer);
    std::ostringstream elsewhere;
    out.exceptions(std::ios::badbit | std::ios::failbit);
    Run run{stepper, y, {0.0, 1.0}, fixed(0.1), csv(out)};
    int thrown = 0;
    for (bool more = true; more;) {
      try {
        more = run.advance();
      } catch (const std::runtime_error&) {
        ++thrown;
        out.rdbuf(elsewhere.rdbuf());
      }
    }
    CHECK(thrown == 1);
    CHECK((y.r == unbroken.y.r && y.v == unbroken.y.v));
  }
}
