// Threads take every number once, in parts that begin where they may.
#include <phistep/base/machine/shares.hpp>

#include <atomic>
#include <vector>

#include "support/catch.hpp"
#include "support/threads.hpp"

using namespace phistep;

TEST_CASE("the parts of a pass have every number once, whatever the number of threads") {
  for (const int threads : {1, 2, 3, 7}) {
    const phistep_test::Threads some{threads};
    for (const std::ptrdiff_t n : {0, 1, 63, 64, 65, 1000, 4096})
      for (const std::ptrdiff_t least : {0, 5000}) {
        std::vector<int> seen(static_cast<std::size_t>(n), 0);
        std::atomic<int> parts = 0, misplaced = 0;
        const auto take = [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
          ++parts;
          misplaced += begin % 64 != 0 || (end % 64 != 0 && end != n) ? 1 : 0;
          for (std::ptrdiff_t i = begin; i < end; ++i) ++seen[static_cast<std::size_t>(i)];
        };
        for_each_range(n, 64, take, static_cast<std::size_t>(least));
        CAPTURE(threads, n, least);
        CHECK(seen == std::vector<int>(static_cast<std::size_t>(n), 1));
        CHECK(misplaced == 0);
        if (n < least) CHECK(parts == 1);  // by the caller
        else CHECK(parts <= threads);
        if (n == 4096 && least == 0) CHECK(parts == threads);
      }
  }
}
