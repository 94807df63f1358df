/// @file
/// The guarded update: write arrays elementwise and learn, from the same pass, whether every number written is finite.
///
///     Input r{…}, v{…}, f{…};
///     bool finite = update(n, [=](auto i, auto& r1, auto& v1) { r1 = r[i] + h * v[i]; v1 = v[i] + a * f[i]; }, …);
///
/// A step writes beside the old state and commits by swap: on `false` nothing of the old state has been touched.
/// Why it has this form (measured, g++ 12 and clang 14, SSE2 to AVX-512, 1e3 to 1e6 particles):
///  · Beyond the caches an ordinary store first reads the line it overwrites; a streaming store doesn't, so that writing
///    beside the state moves no more bytes than a loop in place. Compilers emit no streaming stores by themselves, hence packets:
///    the kernel is generic in i, and computes numbers where i is an index, packets where i is a From. Filling a block in L1 by
///    the ordinary loop and streaming that out was 1.0 to 1.5 times slower, depending on the compiler.
///  · Large arrays are shared by threads. Which thread writes a number changes none of its bits.
///  · g++ vectorizes no loop of unknown length at -O2: there its baseline code uses packets, too, and the guarded update takes
///    1.5 in place of 2.8 ns a particle. But not where g++ contracts to FMA: the tail and the packets must round alike.
#pragma once

#include <atomic>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/machine/shares.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/base/numbers/pack.hpp"

#if defined(__SSE2__) && defined(__GNUC__) && !defined(PHISTEP_NO_SIMD)
#define PHISTEP_DETAIL_STREAMS 1
#else
#define PHISTEP_DETAIL_STREAMS 0
#endif
#if PHISTEP_DETAIL_STREAMS && !defined(__clang__) && !defined(__FMA__)
#define PHISTEP_DETAIL_PACKETS 1
#else
#define PHISTEP_DETAIL_PACKETS 0
#endif

namespace phistep { inline namespace PHISTEP_ABI {

#if PHISTEP_DETAIL_STREAMS
/// 16 bytes of numbers: wide enough where memory is the limit, and a line's stores are joined in the write buffers.
template <class Scalar>
using Packet = Pack<Scalar, 16 / static_cast<int>(sizeof(Scalar))>;
/// The place of one.
template <class Scalar>
using PacketPlace = From<Scalar, Packet<Scalar>::width>;
inline void stream(Packet<double> x, double* p) { _mm_stream_pd(p, x.x); }
inline void stream(Packet<float> x, float* p) { _mm_stream_ps(p, x.x); }
#endif

/// An array that a kernel reads, as numbers or as packets.
template <class Scalar>
struct Input {
  const Scalar* data;
  [[gnu::always_inline]] Scalar operator[](std::ptrdiff_t i) const { return data[i]; }
  template <int width>
  [[gnu::always_inline]] auto operator[](From<Scalar, width> from) const {
    return from(data);
  }
};
template <class Scalar>
Input(const Scalar*) -> Input<Scalar>;

/// h/m for every component alike.
template <class Scalar>
struct UniformFactor {
  Scalar factor;
  [[gnu::always_inline]] Scalar operator()(auto) const { return factor; }
};

/// h/m_i, for a kernel.
template <class Scalar>
struct ComponentFactor {
  Scalar h;
  Input<Scalar> inverse_mass;
  [[gnu::always_inline]] auto operator()(auto i) const { return h * inverse_mass[i]; }
};

/// [bytes] Size of one array from which outputs bypass the caches: a step over five such arrays fills the last of them.
/// Measured crossover with 32 MiB of L3: 5 MiB (forward Euler) and 6 MiB (velocity Verlet).
[[nodiscard]] inline std::ptrdiff_t stream_from() { return last_cache() / 16 * 3; }

namespace detail {

#if PHISTEP_DETAIL_STREAMS
template <class Kernel, class Scalar, class... Scalars>
inline constexpr bool takes_packets = false;
template <class Kernel, class Scalar, std::same_as<Scalar>... Scalars>
  requires(sizeof(Scalar) == 4 || sizeof(Scalar) == 8)
inline constexpr bool takes_packets<Kernel, Scalar, Scalars...> =
    std::invocable<Kernel&, PacketPlace<Scalar>, Packet<Scalar>&, Packet<Scalars>&...>;

/// put(kernel's outputs for the packet at i, where to), and the witness sees them: `troubles` is NaN where one isn't finite.
template <class Witness, class Kernel, class Scalar, class... Scalars>
[[gnu::always_inline]] inline void fill_packet(std::ptrdiff_t i, Kernel& kernel, auto put, Packet<Scalar>& troubles,
                                               Scalar* to, Scalars*... more) {
  [&](Packet<Scalar> x, auto... y) PHISTEP_DETAIL_INLINED {
    kernel(PacketPlace<Scalar>{i}, x, y...);
    put(x, to + i);
    (put(y, more + i), ...);
    if constexpr (!std::is_same_v<Witness, NoWitness<Scalar>>) {
      troubles = bit_or(troubles, x - x);
      ((troubles = bit_or(troubles, y - y)), ...);
    }
  }(Packet<Scalar>{}, Packet<Scalars>{}...);
}
#endif

/// to[i] = kernel's outputs for first ≤ i < end, one by one. They pass through locals, so that a kernel may write one output
/// before it reads an input of the same i, though both be one array.
template <class Witness, class Kernel, class Scalar, std::same_as<Scalar>... Scalars>
[[gnu::always_inline]] inline void fill_numbers(std::ptrdiff_t first, std::ptrdiff_t end, const Kernel& kernel,
                                                Witness& witness, Scalar* to, Scalars*... more) {
  const auto one = [&](std::ptrdiff_t i, Scalar x, Scalars... y) {
    kernel(i, x, y...);
    to[i] = x;
    ((more[i] = y), ...);
    witness.see(x);
    (witness.see(y), ...);
  };
  if constexpr (sizeof(Scalar) == 4 || sizeof(Scalar) == 8) {
    PHISTEP_DETAIL_ELEMENTWISE
    for (std::ptrdiff_t i = first; i < end; ++i) one(i, Scalar{}, Scalars{}...);
  } else {  // no registers hold several long doubles
    for (std::ptrdiff_t i = first; i < end; ++i) one(i, Scalar{}, Scalars{}...);
  }
}

/// The same in packets where that helps, by a kernel of its own, whose places no store of the loop can change.
template <class Witness, class Kernel, class Scalar, std::same_as<Scalar>... Scalars>
Witness fill(std::ptrdiff_t first, std::ptrdiff_t end, const Kernel kernel, Scalar* to, Scalars*... more) {
  Witness witness;
#if PHISTEP_DETAIL_PACKETS
  if constexpr (takes_packets<const Kernel, Scalar, Scalars...>) {
    constexpr std::ptrdiff_t width = Packet<Scalar>::width;
    Packet<Scalar> troubles{0}, others{0};  // two chains: neither waits for the other
    const auto store = [](auto x, Scalar* p) { x.store(p); };
    for (; first + 2 * width <= end; first += 2 * width) {
      fill_packet<Witness>(first, kernel, store, troubles, to, more...);
      fill_packet<Witness>(first + width, kernel, store, others, to, more...);
    }
    for (; first + width <= end; first += width) fill_packet<Witness>(first, kernel, store, troubles, to, more...);
    witness.see(sum(bit_or(troubles, others)));
  }
#endif
  fill_numbers(first, end, kernel, witness, to, more...);
  return witness;
}

/// For few numbers, where the kernel stays as it was made: a copy of pointers just written one by one would be waited for.
template <class Witness, class Kernel, class Scalar, std::same_as<Scalar>... Scalars>
Witness fill_few(std::ptrdiff_t n, const Kernel& kernel, Scalar* to, Scalars*... more) {
  Witness witness;
  fill_numbers(0, n, kernel, witness, to, more...);
  return witness;
}

#if PHISTEP_DETAIL_STREAMS
inline bool is_packet_aligned(const void* p) { return reinterpret_cast<std::uintptr_t>(p) % 16 == 0; }

/// fill() by stores that bypass the caches, for a cache line or more. Outputs are aligned to 16 bytes and overlap no input.
template <class Kernel, class Scalar, std::same_as<Scalar>... Scalars>
[[nodiscard]] FiniteWitness<Scalar> fill_streaming(std::ptrdiff_t i, std::ptrdiff_t end, Kernel kernel, Scalar* to,
                                                   Scalars*... more) {
  using Witness = FiniteWitness<Scalar>;
  constexpr std::ptrdiff_t width = Packet<Scalar>::width, line = 64 / sizeof(Scalar);
  Packet<Scalar> troubles{0};
  for (; i + line <= end; i += line)
    for (std::ptrdiff_t j = i; j < i + line; j += width)
      fill_packet<Witness>(
          j, kernel, [](auto x, Scalar* p) { stream(x, p); }, troubles, to, more...);
  _mm_sfence();  // streamed stores are ordered with nothing: another thread may read the result next
  // The rest as packets too, the last of them overlapping: a number's bits must not depend on where it stands.
  for (; i < end; i += width)
    fill_packet<Witness>(
        i + width <= end ? i : end - width, kernel, [](auto x, Scalar* p) { x.store(p); }, troubles, to, more...);
  Witness witness;
  witness.see(sum(troubles));
  return witness;
}
#endif
/// fill(first, end) → witness, for 0 … n − 1, by threads where that is much. Whether all numbers are finite.
[[nodiscard]] inline bool fill_shares(std::ptrdiff_t n, const auto& fill) {
  if (n < static_cast<std::ptrdiff_t>(shared_from)) return fill(std::ptrdiff_t{0}, n).all_finite();
  std::atomic<bool> finite{true};
  for_each_range(n, 64, [&](std::ptrdiff_t first, std::ptrdiff_t end) {
    if (!fill(first, end).all_finite()) finite = false;
  });
  return finite;
}
}  // namespace detail

/// kernel(i, x…) sets each x from the inputs at i alone; out…[i] = x…, for 0 ≤ i < n. Returns whether all are finite.
/// An output may be an input, as a whole.
template <class Kernel, class Scalar, std::same_as<Scalar>... Scalars>
[[nodiscard]] bool update_in_place(std::ptrdiff_t n, const Kernel& kernel, Scalar* out, Scalars*... more) {
  if (n < 8) return detail::fill_few<FiniteWitness<Scalar>>(n, kernel, out, more...).all_finite();
  return detail::fill_shares(n, [&](std::ptrdiff_t first, std::ptrdiff_t end) {
    return detail::fill<FiniteWitness<Scalar>>(first, end, kernel, out, more...);
  });
}
/// The same where every result is known to be finite.
template <class Kernel, class Scalar, std::same_as<Scalar>... Scalars>
void update_in_place_unwatched(std::ptrdiff_t n, Kernel kernel, Scalar* out, Scalars*... more) {
  for_each_range(n, 64, [=](std::ptrdiff_t first, std::ptrdiff_t end) {
    detail::fill<NoWitness<Scalar>>(first, end, kernel, out, more...);
  });
}

/// The same for outputs that overlap no input. A kernel for indices alone is accepted, but never streams.
template <class Kernel, class Scalar, std::same_as<Scalar>... Scalars>
[[nodiscard]] bool update(std::ptrdiff_t n, const Kernel& kernel, Scalar* out, Scalars*... more) {
#if PHISTEP_DETAIL_STREAMS
  if constexpr (detail::takes_packets<Kernel, Scalar, Scalars...>)
    if (n >= stream_from() / static_cast<std::ptrdiff_t>(sizeof(Scalar)) && detail::is_packet_aligned(out) &&
        (detail::is_packet_aligned(more) && ...))
      return detail::fill_shares(n, [=](std::ptrdiff_t first, std::ptrdiff_t end) {
        return detail::fill_streaming(first, end, kernel, out, more...);
      });
#endif
  return update_in_place(n, kernel, out, more...);
}

namespace detail {
/// The numbers from `from` to n, unrolled; 0 where all are finite, else NaN.
template <std::ptrdiff_t n, std::ptrdiff_t from, class Kernel, class Scalar, std::same_as<Scalar>... Scalars>
[[nodiscard, gnu::always_inline]] inline Scalar fill_one_by_one(Kernel kernel, Scalar* out, Scalars*... more) {
  // A sum of 0·x beats the bit test here: one dependent chain less, and no move between register files.
  Scalar witness{0};
  const auto one = [&](std::ptrdiff_t i, Scalar x, Scalars... y) PHISTEP_DETAIL_INLINED {
    kernel(i, x, y...);
    out[i] = x;
    ((more[i] = y), ...);
    witness += Scalar{0} * x;
    ((witness += Scalar{0} * y), ...);
  };
  [&]<std::size_t... i>(std::index_sequence<i...>) PHISTEP_DETAIL_INLINED {
    (one(from + static_cast<std::ptrdiff_t>(i), Scalar{}, Scalars{}...), ...);
  }
  (std::make_index_sequence<static_cast<std::size_t>(n - from)>{});
  return witness;
}
}  // namespace detail

/// `update` for the few numbers of a small fixed state, known at compile time and unrolled: it stays in registers. Number by
/// number, for inputs that were just written so: a packet of them would be waited for.
template <std::ptrdiff_t n, class Kernel, class Scalar, std::same_as<Scalar>... Scalars>
[[nodiscard, gnu::always_inline]] inline bool update_one_by_one(Kernel kernel, Scalar* out, Scalars*... more) {
  return detail::fill_one_by_one<n, 0>(kernel, out, more...) == Scalar{0};
}
/// The same in packets, for inputs that were written in packets, and outputs that will be read so.
template <std::ptrdiff_t n, class Kernel, class Scalar, std::same_as<Scalar>... Scalars>
[[nodiscard, gnu::always_inline]] inline bool update_unrolled(Kernel kernel, Scalar* out, Scalars*... more) {
#if PHISTEP_DETAIL_STREAMS && !defined(__clang__)
  if constexpr (detail::takes_packets<Kernel, Scalar, Scalars...>) {
    constexpr std::ptrdiff_t width = Packet<Scalar>::width, packets = n / width;
    Packet<Scalar> troubles{0};
    [&]<std::size_t... i>(std::index_sequence<i...>) PHISTEP_DETAIL_INLINED {
      (detail::fill_packet<FiniteWitness<Scalar>>(
           static_cast<std::ptrdiff_t>(i) * width, kernel, [](auto x, Scalar* p) PHISTEP_DETAIL_INLINED { x.store(p); },
           troubles, out, more...),
       ...);
    }
    (std::make_index_sequence<static_cast<std::size_t>(packets)>{});
    return detail::fill_one_by_one<n, packets * width>(kernel, out, more...) + sum(troubles) == Scalar{0};
  }
#endif
  return update_one_by_one<n>(kernel, out, more...);
}

}}  // namespace phistep::PHISTEP_ABI
