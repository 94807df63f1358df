#pragma once

// Answers of a scheme on random problems beside the exact ones: what the files accuracy/truth*.full.cpp need.

#include <cstdint>
#include <cstdlib>
#include <string>

#include "accuracy/truth/linear.hpp"
#include "accuracy/truth/schemes.hpp"
#include "support/catch.hpp"

namespace {

using namespace truth;

std::uint64_t seed() {
  const char* text = std::getenv("PHISTEP_SEED");
  return text ? std::strtoull(text, nullptr, 10) : 7;
}

using Scheme = Answer (*)(const Problem&, double rtol);

/// Three tolerances.
[[maybe_unused]] void check(const Problem& problem, const char* name, Scheme scheme) {
  for (const double rtol : {1e-2, 1e-4, 1e-6}) {
    const Result result = judge(0, 0, problem, rtol, scheme(problem, rtol));
    CAPTURE(seed(), problem.name, problem.kappa, name, rtol, result.share, result.drift);
    CHECK(result.share >= 0);  // none fails here
    CHECK(result.share <= 100);
    // Mass is kept, to what rounding makes of f.
    CHECK(result.roundings <= 100);
  }
}

}  // namespace
