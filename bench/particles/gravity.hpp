/// @file
/// Accelerations by softened gravity between all pairs of a Plummer sphere, G = 1, ε = 0.01 in N-body units.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace bench {

/// Particles as arrays of their own on 64-byte lines: what kernels written by hand want.
template <class Scalar>
struct Cluster {
  static constexpr double epsilon = 0.01;
  std::size_t n = 0;  ///< a multiple of 16
  Scalar *x, *y, *z, *m, *ax, *ay, *az;
  explicit Cluster(std::size_t size) : n{size}, memory_(7 * (size + 16) + 64 / sizeof(Scalar)) {
    auto* at = on_a_line(memory_);
    for (Scalar** array : {&x, &y, &z, &m, &ax, &ay, &az}) *array = at, at += size + 16;
  }
  Cluster(const Cluster&) = delete;
  Cluster& operator=(const Cluster&) = delete;

 private:
  static Scalar* on_a_line(std::vector<Scalar>& memory);
  std::vector<Scalar> memory_;
};

/// A kernel that fills ax, ay, az.
template <class Scalar>
struct Kernel {
  std::string name;
  void (*run)(Cluster<Scalar>&);
};
/// The loop of a textbook, and those with AVX-512 instructions where they are compiled in.
template <class Scalar>
[[nodiscard]] std::vector<Kernel<Scalar>> gravity_by_hand();

}  // namespace bench
