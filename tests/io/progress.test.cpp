#include <phistep/io/progress.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

#include "support/catch.hpp"

using namespace phistep;

namespace {

/// A run of `steps` steps from t0 to t1 that takes 1 s for each unit of t; what it writes.
std::string shown(double t0, double t1, int steps, bool terminal, double end) {
  std::ostringstream out;
  double clock = 100;
  Progress bar{out, end, terminal, [&clock] { return clock; }};
  bar.begin(t0, 0);
  for (int n = 0; n <= steps; ++n) {
    const double t = n == steps ? t1 : t0 + (t1 - t0) / steps * n;
    clock = 100 + std::abs(t - t0);
    bar(t, 0);
  }
  return out.str();
}
auto lines(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }
std::string repeated(const std::string& text, int n) { return n == 0 ? "" : text + repeated(text, n - 1); }

}  // namespace

TEST_CASE("a log: ten lines, one for each tenth done, whatever the steps, with dt and the time left") {
  const std::string all = shown(0, 80, 1024, false, 80);
  CHECK(lines(all) == 10);
  CHECK_THAT(
      all, contains("  10 %  t = 8.04688  dt = 0.078125  1:12 left\n  20 %  t = 16.0156  dt = 0.078125  1:04 left\n"));
  CHECK_THAT(all, contains("  100 %  t = 80  dt = 0.078125  took 1:20\n") && !contains("\r"));
  CHECK(lines(shown(0, 1, 100'000, false, 1)) == 10);
  CHECK(shown(0, 10, 4, false, 10) ==
        "  25 %  t = 2.5  dt = 2.5  0:08 left\n  50 %  t = 5  dt = 2.5  0:05 left\n"
        "  75 %  t = 7.5  dt = 2.5  0:03 left\n  100 %  t = 10  dt = 2.5  took 0:10\n");
  CHECK(shown(0, 10, 1, false, 10) == "  100 %  t = 10  dt = 10  took 0:10\n");
}

TEST_CASE("a log: a step that ends at a tenth but for its last bits is there") {
  std::ostringstream out;
  Progress bar{out, 0.2, false, [] { return 0.0; }};
  double t = 0;
  bar(t, 0);
  for (int n = 1; n <= 100; ++n) t = n == 100 ? 0.2 : t + 0.002, bar(t, 0);
  CHECK(lines(out.str()) == 10);
  for (int tenth = 1; tenth <= 10; ++tenth)
    CHECK_THAT(out.str(), contains("  " + std::to_string(10 * tenth) + " %  t"));
}

TEST_CASE("a terminal: one line with a bar, renewed five times a second, ended by a line break") {
  const std::string all = shown(0, 16, 1024, true, 16);
  CHECK(lines(all) == 1);
  CHECK(all.back() == '\n');
  CHECK_THAT(all, contains("\r  [>" + repeated(" ", 23) + "]   0 %  t = 0"));
  CHECK_THAT(all, contains("\r  [" + repeated("=", 12) + ">" + repeated(" ", 11) + "]  50 %  t = 8."));
  CHECK_THAT(all, contains("\r  [" + repeated("=", 24) + "] 100 %  t = 16  dt = 0.015625  took 0:16"));
  // 16 s, a look each 1/64 s: due after 13 of them.
  CHECK(std::count(all.begin(), all.end(), '\r') == 1024 / 13 + 2);
  for (std::size_t at = 0, next = 0; at != all.npos; at = next) {
    next = all.find('\r', at + 1);
    CHECK((next == all.npos ? all.size() : next) - at < 81);
  }
}

TEST_CASE("an end missed by rounding is the end, once") {
  std::ostringstream out;
  Progress bar{out, 1, true, [] { return 0.0; }};
  for (const double t : {0.0, 1 - 1e-12, 1.0}) bar(t, 0);
  CHECK_THAT(out.str(), contains("100 %  t = 1  dt = 1  took 0:00"));
  CHECK(lines(out.str()) == 1);
  CHECK(out.str().back() == '\n');
}

TEST_CASE("on a terminal a shorter line covers the longer one before it") {
  std::ostringstream out;
  double clock = 0;
  Progress bar{out, 1, true, [&clock] { return clock; }};
  bar(0, 0);
  clock = 1, bar(0.123456, 0);
  const std::size_t longer = out.str().size() - out.str().rfind('\r');
  clock = 2, bar(0.5, 0);
  CHECK(out.str().size() - out.str().rfind('\r') == longer);
}

TEST_CASE("without a known end: the time reached, in a log whenever the run has become twice as old") {
  const std::string log = shown(0, 64, 1024, false, std::nan(""));
  CHECK_THAT(log, contains("  t = 0\n  t = 1\n  t = 2\n  t = 4\n") && !contains("%") && !contains("left"));
  CHECK(lines(log) == 8);
  CHECK_THAT(shown(0, 64, 1024, true, std::nan("")), contains("\r  t = 0\r  t = 0.25") && !contains("\n"));
}

TEST_CASE("progress backward, of a second run, and of a run without a length") {
  CHECK(shown(4, 0, 2, false, 0) == "  50 %  t = 2  dt = -2  0:02 left\n  100 %  t = 0  dt = -2  took 0:04\n");
  std::ostringstream out;
  double clock = 0;
  Progress bar{out, 1, false, [&clock] { return clock; }};
  for (const double t0 : {0.0, -1.0}) {
    bar.begin(t0, 0);
    for (const double t : {t0, (t0 + 1) / 2, 1.0}) bar(t, 0), clock += 1;
  }
  CHECK(out.str() ==
        "  50 %  t = 0.5  dt = 0.5  0:01 left\n  100 %  t = 1  dt = 0.5  took 0:02\n"
        "  50 %  t = 0  dt = 1  0:01 left\n  100 %  t = 1  dt = 1  took 0:02\n");
  CHECK(shown(1, 1, 1, false, 1) == "  t = 1\n");
}

TEST_CASE("seconds as a clock shows them") {
  CHECK(clock_text(0) == "0:00");
  CHECK(clock_text(59.4) == "0:59");
  CHECK(clock_text(59.6) == "1:00");
  CHECK(clock_text(3599) == "59:59");
  CHECK(clock_text(3723) == "1:02:03");
  CHECK(clock_text(360000) == "100:00:00");
  CHECK(clock_text(-1) == "0:00");
}

TEST_CASE("streams that are no terminals, and the short form") {
  std::ostringstream out;
  CHECK_FALSE(is_terminal(out));
  auto bar = progress(out, 1.0);
  bar(0.0, 0), bar(1.0, 0);
  CHECK_THAT(out.str(), contains("  100 %  t = 1  dt = 1  took 0:00\n"));
}
