// Sorted by key, equal keys in their order, whatever the number of threads.
#include <phistep/particles/neighbors/cell_order.hpp>

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include "support/catch.hpp"
#include "support/threads.hpp"

using namespace phistep;

TEST_CASE("a radix sort is the stable sort, with one thread and several, of keys of few bits and of many") {
  struct Keyed {
    std::uint64_t key;
    std::uint32_t entry;
    bool operator==(const Keyed&) const = default;
  };
  RadixSort<Keyed> sort;  // for all of them
  std::mt19937_64 random(7);
  for (const std::size_t n : {0u, 1u, 5000u, 40'000u})
    for (const std::uint64_t top : {std::uint64_t{0}, std::uint64_t{900}, std::uint64_t{2048}, ~std::uint64_t{0}}) {
      std::vector<Keyed> items(n);
      for (std::uint32_t k = 0; k < n; ++k) items[k] = {top == 0 ? 0 : random() % top, k};
      if (n > 7) items[7].key = top;
      std::vector<Keyed> right = items;
      std::stable_sort(right.begin(), right.end(), [](const Keyed& a, const Keyed& b) { return a.key < b.key; });
      for (const int threads : {1, 2, 3, 7}) {
        const phistep_test::Threads some{threads};
        std::vector<Keyed> sorted = items;
        sort(sorted, top);
        CAPTURE(n, top, threads);
        CHECK((sorted == right));
      }
    }
}
