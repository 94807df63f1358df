// A checkpoint's file, read by somebody who knows nothing but what io/checkpoint.hpp and base/archive/archive.hpp say of it; and
// what saving forgets, and when.
#include <phistep/io/checkpoint.hpp>
#include <phistep/phistep.hpp>

#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "support/catch.hpp"
#include "support/shared_force.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;

namespace {

/// What stands under a name: its kind ("f8"), its sizes, and its numbers or its text.
struct Found {
  std::string kind;
  std::vector<std::uint64_t> sizes;
  std::vector<double> numbers;
  std::string text;
};

/// Reads a file by its description, with no line of the library's.
class Walker {
 public:
  explicit Walker(std::string file) : file_{std::move(file)} {
    REQUIRE(file_.substr(0, 8) == "\x89PHI\r\n\x1a\n");
    at_ = 8;
    REQUIRE(number(4) == 2);
    REQUIRE(number(4) == 0);
    const std::uint64_t length = number(8);
    REQUIRE(file_.size() == 24 + length + 8);
    end_ = 24 + length;
    while (at_ < end_) walk("");
  }
  [[nodiscard]] bool has(const std::string& path) const { return found_.count(path) > 0; }
  [[nodiscard]] const Found& operator[](const std::string& path) const { return found_.at(path); }
  /// Whether a name ends like this anywhere.
  [[nodiscard]] bool has_any(const std::string& name) const {
    for (const auto& [path, what] : found_)
      if (path.size() >= name.size() && path.substr(path.size() - name.size()) == name) return true;
    return false;
  }

 private:
  [[nodiscard]] std::uint64_t number(int bytes) {
    std::uint64_t x = 0;
    for (int k = 0; k < bytes; ++k) x |= std::uint64_t{static_cast<unsigned char>(file_.at(at_++))} << 8 * k;
    return x;
  }
  [[nodiscard]] double value(char kind, int width) {
    if (kind == 'w') {
      const double high = value('f', 8);
      return high + value('f', 8);
    }
    const std::uint64_t bits = number(width);
    if (kind == 'f')
      return width == 8 ? std::bit_cast<double>(bits) : std::bit_cast<float>(static_cast<std::uint32_t>(bits));
    const bool negative = kind == 'i' && bits >> (8 * width - 1) != 0;
    return negative ? -static_cast<double>((~bits + 1) << (64 - 8 * width) >> (64 - 8 * width))
                    : static_cast<double>(bits);
  }
  /// One record. False: the end of a section.
  bool walk(const std::string& inside) {
    const char kind = static_cast<char>(number(1));
    const int width = static_cast<int>(number(1)), rank = static_cast<int>(number(1));
    std::string name(number(1), ' ');
    for (char& c : name) c = static_cast<char>(number(1));
    Found one{kind + std::to_string(width), {}, {}, {}};
    for (int k = 0; k < rank; ++k) one.sizes.push_back(number(8));
    if (kind == '}') return false;
    if (kind == '{') {
      while (walk(inside + name + '/')) {
      }
      return true;
    }
    std::uint64_t count = 1;
    for (const std::uint64_t size : one.sizes) count *= size;
    for (std::uint64_t k = 0; k < count; ++k) {
      if (kind == 't') one.text += static_cast<char>(number(1));
      else one.numbers.push_back(value(kind == 'b' ? 'u' : kind, width));
    }
    found_[inside + name] = std::move(one);
    return true;
  }

  std::string file_;
  std::size_t at_ = 0, end_ = 0;
  std::map<std::string, Found> found_;
};

const shared_force::OfState<Vec> decay = [](const Vec& y) -> Vec { return -2 * y - y.cwiseProduct(y); };
const shared_force::OfState<Vec> other_decay = [](const Vec& y) -> Vec { return -3 * y; };
Vec start() { return Vec::LinSpaced(3, 0.5, 2); }

template <class... Parts>
std::string saved(Parts&&... parts) {
  std::ostringstream out;
  save_checkpoint(out, parts...);
  return out.str();
}

}  // namespace

TEST_CASE("a program that knows the format alone finds t and y by name, and no Jacobian") {
  Vec y = start();
  PhiStepper stepper{y, decay, backward_euler};
  double t = 0;
  for (int n = 0; n < 3; ++n, t += 0.125) REQUIRE(stepper.step(y, t, 0.125));
  const Statistics counts = stepper.statistics();
  const Walker file(
      saved("stepper", stepper, "y", y, "t", t, "wide", -1.0L / 3, "note", std::string("half way"), "n", -7));
  CHECK(file["t"].kind == "f8");
  CHECK(file["t"].sizes.empty());
  CHECK(file["t"].numbers == std::vector<double>{0.375});
  CHECK(file["y"].sizes == std::vector<std::uint64_t>{3, 1});
  CHECK(file["y"].numbers == std::vector<double>(y.begin(), y.end()));
  CHECK(file["wide"].kind == "w16");
  CHECK(file["wide"].numbers[0] == -1.0 / 3);
  CHECK(file["note"].text == "half way");
  CHECK(file["n"].numbers[0] == -7);
  CHECK(file["stepper/scheme"].text == "backward_euler");
  CHECK(file["stepper/state"].text == "3 x 1 of f8");
  CHECK(file["stepper/force/counts/force calls"].numbers[0] == static_cast<double>(counts.force_calls));
  // 9 numbers stand nowhere, nor does anything called like that.
  for (const char* absent : {"K", "C", "jacobian", "factors", "pattern", "pace"}) CHECK_FALSE(file.has_any(absent));
}

TEST_CASE("a run's file has its names: t, the state's blocks, the controller's numbers") {
  Motion<Vec> y{start(), Vec::Ones(3)};
  PhiStepper stepper{y, [](const Vec& r) -> Vec { return -r; }, velocity_verlet};
  Run run{stepper, y, {0, 1}, tolerance{.rtol = 1e-4}};
  for (int n = 0; n < 3; ++n) REQUIRE(run.advance());
  const Walker file(saved(run));
  CHECK(file["run/clock/t"].numbers == std::vector<double>{run.time()});
  CHECK(file["run/state/r"].numbers == std::vector<double>(y.r.begin(), y.r.end()));
  CHECK(file["run/state/v"].numbers == std::vector<double>(y.v.begin(), y.v.end()));
  CHECK(file["run/stepper/scheme"].text == "velocity_verlet");
  CHECK(file["run/control/step/size"].numbers.size() == 1);
  CHECK(file["run/report/counts/steps"].numbers[0] == 3);
}

TEST_CASE("a force of another law loads: its name and shape are all that there is") {
  Vec y = start(), z = start();
  PhiStepper stepper{y, decay, tr_bdf2};
  REQUIRE(stepper.step(y, 0, 0.1));
  const std::string file = saved(stepper, y);
  PhiStepper other{z, other_decay, tr_bdf2};
  std::istringstream in(file);
  CHECK_NOTHROW(load_checkpoint(in, other, z));
  CHECK(z == y);
}

TEST_CASE("saving forgets Jacobians and factors, at the price of one; a save that fails forgets nothing") {
  Vec y = start(), z = start();
  PhiStepper kept{y, decay, backward_euler, newton({.rtol = 1e-4, .atol = 1e-6})};
  PhiStepper saving{z, decay, backward_euler, newton({.rtol = 1e-4, .atol = 1e-6})};
  const auto jacobians = [](auto& stepper, Vec& state, int n) {
    const auto before = stepper.statistics().jacobians;
    REQUIRE(stepper.step(state, 0.01 * n, 0.01));
    return stepper.statistics().jacobians - before;
  };
  CHECK(jacobians(kept, y, 0) == 1);
  CHECK(jacobians(saving, z, 0) == 1);
  std::ostringstream cut;
  cut.setstate(std::ios::badbit);
  CHECK_THROWS_AS(save_checkpoint(cut, saving, z), CheckpointError);
  CHECK_THROWS_AS(save_checkpoint("no/such/folder/file", saving, z), CheckpointError);
  CHECK(jacobians(kept, y, 1) == 0);
  CHECK(jacobians(saving, z, 1) == 0);
  CHECK(y == z);
  static_cast<void>(saved(saving, z));
  CHECK(jacobians(kept, y, 2) == 0);
  CHECK(jacobians(saving, z, 2) == 1);
  CHECK((y - z).norm() < 1e-4 * y.norm());
}

TEST_CASE("a controller's numbers that can't be are refused") {
  const auto check = [](auto good, const char* name, double bad) {
    // Everything as it was written, but for one number.
    Writer out;
    out("x", good);
    std::string bytes(reinterpret_cast<const char*>(out.bytes().data()), out.bytes().size());
    const std::string called = static_cast<char>(std::string(name).size()) + std::string(name);
    std::size_t at = bytes.find(called);
    REQUIRE(at != std::string::npos);
    at += called.size() + 8 * static_cast<std::size_t>(bytes[at - 1]);  // behind the sizes
    std::memcpy(bytes.data() + at, &bad, sizeof bad);
    const std::vector<std::byte> copy(reinterpret_cast<const std::byte*>(bytes.data()),
                                      reinterpret_cast<const std::byte*>(bytes.data()) + bytes.size());
    Reader in{copy};
    CHECK_THROWS_WITH(in("x", good), contains("values that can't be"));
  };
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, infinity, -1.0}) {
    check(VariableStep<double>{}, "size", bad);
    ErrorNorm<Vec> norm;
    REQUIRE(norm.begin(tolerance{.rtol = 1e-3}, start()));
    norm.remember(start());
    for (const char* name : {"sizes", "largest", "noise", "longest"}) check(norm, name, bad);
  }
  for (const double bad : {nan, infinity}) {
    check(StepSize{StepFilter::predictive, 2, 1}, "past", bad);
    check(StepSize{StepFilter::H211b, 2, 1}, "ratio", bad);
    check(StepSize{StepFilter::H211b, 2, 1}, "past", bad);
    Trace<Vec> trace;
    trace.resize(start());
    check(trace, "dt_before", bad);
    trace.knows_start = true;
    check(trace, "start", bad);
    trace.dt_before = 0.1;
    check(trace, "before", bad);
  }
}
