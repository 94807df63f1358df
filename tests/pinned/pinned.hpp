// Runs whose bits and whose work are pinned. Each has a name, and prints the hash of what it ends with:
//
//     phistep_pinned                 all runs
//     phistep_pinned --only NAME     that one (callgrind counts its instructions); "nothing" is none
//
// hashes.txt has what they print under the portable flags of scripts/compatibility.sh, by every compiler; counts.txt the
// instructions of some, at -O2; check.py compares. No run takes a sine or an exponential of the C library's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

namespace pinned {

/// FNV-1a, 64 bits, of the bytes of numbers.
class Hash {
 public:
  void add(double x) {
    unsigned char bytes[sizeof x];
    std::memcpy(bytes, &x, sizeof x);
    for (const unsigned char byte : bytes) value_ = (value_ ^ byte) * 0x100000001b3u;
  }
  /// A motion, particles with or without spin, or a matrix.
  void add(const auto& y) {
    if constexpr (requires { y.r, y.v; }) {
      add(y.r), add(y.v);
      if constexpr (requires { y.omega; }) add(y.omega);
    } else {
      for (std::ptrdiff_t i = 0; i < y.size(); ++i) add(y.data()[i]);
    }
  }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

inline std::string only;
inline int failed = 0;

/// A failed step or run ends the program with an error: its hash would pin nonsense.
inline void good(const auto& report) {
  if (report) return;
  std::fprintf(stderr, "%s\n", report.message().c_str());
  ++failed;
}
/// f(hash), unless another run is asked for.
void run(const std::string& name, auto&& f) {
  if (!only.empty() && only != name) return;
  Hash hash;
  f(hash);
  std::printf("%-44s %016llx\n", name.c_str(), static_cast<unsigned long long>(hash.value()));
}

/// What a file pins: a function that calls `run`.
using Group = void (*)();
inline std::vector<Group>& groups() {
  static std::vector<Group> all;
  return all;
}
inline bool added(Group group) {
  groups().push_back(group);
  return true;
}

}  // namespace pinned
