#pragma once

// Properties over generated cases. A property is a function of a Source that draws what it needs and throws (require,
// bound) where it doesn't hold; what fails is shrunk, and printed with its seed.
//
// A case is the list of the choices it drew, small numbers being simple ones. Shrinking leaves choices out and makes them
// smaller, and runs the property on what is left: whatever was made of the choices shrinks with them, sequences of
// operations and sizes that others depend on included, and never leaves the bounds it was drawn in (after D. R. MacIver's
// Hypothesis). RapidCheck would do as well, but Debian's is bound to one standard library, and takes seeds from the
// environment alone.

#include <Eigen/Core>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <functional>
#include <initializer_list>
#include <iomanip>
#include <iostream>
#include <limits>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "support/catch.hpp"
#include "support/figures.hpp"

namespace property {

/// The case doesn't hold.
struct Broken : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// The case is none of those that the property is about.
struct Discarded {};

[[nodiscard]] inline std::uint64_t seed() {
  static const std::uint64_t chosen = [] {
    const char* given = std::getenv("PHISTEP_SEED");
    const std::uint64_t it = given != nullptr ? std::strtoull(given, nullptr, 10) : 20261121;
    std::cout << "properties: cases drawn with seed " << it << " (PHISTEP_SEED replaces it)" << std::endl;
    return it;
  }();
  return chosen;
}

/// Where a case draws its choices: from random numbers, or from a list, with zeros after its end.
class Source {
 public:
  using Tape = std::vector<std::uint64_t>;

  explicit Source(std::uint64_t seed) : random_{seed}, fresh_{true} {}
  explicit Source(Tape tape, bool tells = false) : given_{std::move(tape)}, tells_{tells} {}

  /// 0 … bound − 1
  [[nodiscard]] std::uint64_t below(std::uint64_t bound) {
    std::uint64_t choice = 0;
    if (fresh_) choice = random_() % bound;
    else if (used_.size() < given_.size()) choice = std::min(given_[used_.size()], bound - 1);
    used_.push_back(choice);
    return choice;
  }
  /// Whether there is one more of a list: `mean` of them on average.
  [[nodiscard]] bool more(std::uint64_t mean) { return below(mean + 1) != 0; }
  [[nodiscard]] bool flag(const char* name) { return told(name, below(2) == 1); }
  /// low … high, low the simplest
  [[nodiscard]] int integer(const char* name, int low, int high) {
    return told(name, low + static_cast<int>(below(static_cast<std::uint64_t>(high - low) + 1)));
  }
  /// Which of some names.
  [[nodiscard]] std::size_t one_of(const char* name, std::initializer_list<const char*> names) {
    const auto k = static_cast<std::size_t>(below(names.size()));
    told(name, *(names.begin() + k));
    return k;
  }
  /// low ≤ x ≤ high, with few bits or with many
  [[nodiscard]] double real(const char* name, double low, double high) { return told(name, between(low, high)); }
  /// 10^low … 10^high
  [[nodiscard]] double decades(const char* name, double low, double high) {
    return told(name, std::pow(10, between(low, high)));
  }
  /// −size … size, 0 the simplest
  [[nodiscard]] double number(const char* name, double size) { return told(name, symmetric(size)); }
  [[nodiscard]] Eigen::VectorXd numbers(const char* name, Eigen::Index n, double size) {
    Eigen::VectorXd x(n);
    for (double& each : x) each = symmetric(size);
    if (tells_) say(name, "", x.transpose());
    return x;
  }
  [[nodiscard]] Eigen::MatrixXd matrix(const char* name, Eigen::Index rows, Eigen::Index cols, double size) {
    Eigen::MatrixXd x(rows, cols);
    for (double& each : x.reshaped()) each = symmetric(size);
    if (tells_) say(name, "\n", x);
    return x;
  }
  /// A line of the story.
  void tell(const std::string& line) {
    if (tells_) story_ << "    " << line << '\n';
  }

  void require(bool holds, std::string_view what) const {
    if (!holds) throw Broken(std::string(what));
  }
  /// error ≤ limit; how near it comes is remembered.
  void bound(double error, double limit, std::string_view what) {
    // Where nothing may be lost, nothing is lost.
    const double part = error == 0 ? 0 : error / limit;
    worst_ = std::max(worst_, std::isnan(part) ? std::numeric_limits<double>::infinity() : part);
    if (part <= 1) return;
    std::ostringstream out;
    out << what << ": " << error << " where " << limit << " is allowed";
    throw Broken(out.str());
  }
  void assume(bool so) const {
    if (!so) throw Discarded{};
  }

  [[nodiscard]] const Tape& tape() const { return used_; }
  [[nodiscard]] double worst() const { return worst_; }
  [[nodiscard]] std::string story() const { return story_.str(); }

 private:
  [[nodiscard]] double between(double low, double high) {
    const std::uint64_t bits = below(53), parts = std::uint64_t{1} << bits;
    return low + (high - low) * (static_cast<double>(below(parts + 1)) / static_cast<double>(parts));
  }
  [[nodiscard]] double symmetric(double size) {
    const bool negative = below(2) == 1;
    const double x = between(0, size);
    return negative ? -x : x;
  }
  template <class T>
  T told(const char* name, T value) {
    if (tells_) say(name, "", value);
    return value;
  }
  void say(const char* name, const char* gap, const auto& value) {
    story_ << "    " << name << " = " << gap << std::setprecision(17) << std::boolalpha << value << '\n';
  }

  std::mt19937_64 random_;
  Tape given_, used_;
  bool fresh_ = false, tells_ = false;
  double worst_ = 0;
  std::ostringstream story_;
};

using Property = std::function<void(Source&)>;

struct Result {
  int cases = 0, discarded = 0;
  double worst = 0;   ///< largest error over its bound
  std::string story;  ///< of the smallest case that fails; empty: none does
};

namespace detail {

/// Why a case fails; empty where it holds or doesn't count.
[[nodiscard]] inline std::string run(const Property& property, Source& source, bool* discarded = nullptr) {
  try {
    property(source);
  } catch (const Discarded&) {
    if (discarded != nullptr) *discarded = true;
  } catch (const Broken& broken) {
    return broken.what();
  } catch (const std::exception& error) {
    return std::string("throws ") + error.what();
  }
  return {};
}

/// Smaller: shorter, or as long and lower.
[[nodiscard]] inline bool simpler(const Source::Tape& a, const Source::Tape& b) {
  return a.size() != b.size() ? a.size() < b.size() : a < b;
}

/// What went wrong, without figures.
[[nodiscard]] inline std::string kind_of(const std::string& why) { return why.substr(0, why.find(':')); }

/// The simplest case that still fails in the same way, as far as `budget` runs find it.
[[nodiscard]] inline Source::Tape shrink(const Property& property, Source::Tape best, const std::string& why, int& runs,
                                         int budget) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  const auto improves = [&](Source::Tape tape) {
    if (std::chrono::steady_clock::now() > end) runs = budget;  // a case may be dear
    if (runs >= budget || !simpler(tape, best)) return false;
    ++runs;
    Source source{std::move(tape)};
    if (kind_of(run(property, source)) != why || !simpler(source.tape(), best)) return false;
    best = source.tape();
    return true;
  };
  const auto without = [&best](std::size_t from, std::size_t n) {
    Source::Tape tape = best;
    const auto at = tape.begin() + static_cast<std::ptrdiff_t>(from);
    tape.erase(at, at + static_cast<std::ptrdiff_t>(n));
    return tape;
  };
  const auto with = [&best](std::size_t at, std::uint64_t choice) {
    Source::Tape tape = best;
    tape[at] = choice;
    return tape;
  };
  for (bool improved = true; improved && runs < budget;) {
    improved = false;
    for (std::size_t n = std::max<std::size_t>(best.size() / 2, 1); n > 0; n = n > 12 ? n / 2 : n - 1)
      for (std::size_t i = 0; i + n <= best.size();)
        if (improves(without(i, n))) improved = true;
        else ++i;
    for (std::size_t i = 0; i < best.size(); ++i) {
      if (best[i] == 0) continue;
      if (improves(with(i, 0))) {
        improved = true;
        continue;
      }
      // The least that fails between 0, which doesn't, and here.
      for (std::uint64_t low = 0; i < best.size() && best[i] > low + 1;) {
        const std::uint64_t middle = low + (best[i] - low) / 2;
        if (improves(with(i, middle))) improved = true;
        else low = middle;
        if (runs >= budget) break;
      }
      // One less of something, and what belonged to it.
      for (std::size_t n = 1; n <= 9 && i < best.size() && best[i] > 0; ++n)
        for (std::size_t j = i + 1; j + n <= best.size() && best[i] > 0; ++j) {
          Source::Tape tape = without(j, n);
          --tape[i];
          if (improves(std::move(tape))) improved = true;
        }
    }
  }
  return best;
}

}  // namespace detail

/// Runs `property` on so many cases, those it discards not counted.
[[nodiscard]] inline Result run(const std::string& name, int cases, const Property& property) {
  Result result;
  std::uint64_t hash = seed();
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  auto told = std::chrono::steady_clock::now();
  while (result.cases < cases) {
    if (const auto now = std::chrono::steady_clock::now(); now - told > std::chrono::seconds(10)) {
      figures::progress(name + ": " + std::to_string(result.cases) + " of " + std::to_string(cases));
      told = now;
    }
    if (result.discarded > 20 * cases) {
      result.story = "only " + std::to_string(result.cases) + " cases of " + std::to_string(cases) + " found";
      break;
    }
    const auto number = static_cast<std::uint64_t>(result.cases + result.discarded);
    Source source{hash + number * 0x9e3779b97f4a7c15u};
    bool discarded = false;
    const std::string why = detail::run(property, source, &discarded);
    ++(discarded ? result.discarded : result.cases);
    result.worst = std::max(result.worst, source.worst());
    if (why.empty()) continue;
    int runs = 0;
    Source smallest{detail::shrink(property, source.tape(), detail::kind_of(why), runs, 5000), true};
    const std::string reason = detail::run(property, smallest);
    std::ostringstream out;
    out << "seed " << seed() << ", case " << number << ": " << why << "\n  shrunk from " << source.tape().size()
        << " choices to " << smallest.tape().size() << " in " << runs << " runs:\n"
        << smallest.story() << "  " << reason;
    result.story = out.str();
    break;
  }
  return result;
}

/// A test: no case may fail.
inline Result check(const std::string& name, int cases, const Property& property) {
  Result result = run(name, cases, property);
  CAPTURE(name, result.cases, result.discarded);
  INFO(result.story);
  CHECK(result.story.empty());
  return result;
}

/// The same with rows for the stress run's summary: how many cases hold, and how near the worst came to its bound.
inline void report(const std::string& claim, int cases, const Property& property) {
  const Result result = check(claim, cases, property);
  const bool holds = result.story.empty();
  figures::row(claim, "generated cases that hold", std::to_string(holds ? result.cases : result.cases - 1),
               std::to_string(cases), holds);
  if (result.worst > 0) figures::at_most(1, result.worst, claim, "worst error / its bound");
}

}  // namespace property
