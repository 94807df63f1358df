/// @file
/// Checkpoints: a run's parts in a file, from which a program with the same parts goes on.
///
///     save_checkpoint("run.checkpoint", run);                  // now and then
///     load_checkpoint("run.checkpoint", run);                  // at the next start; false if the file does not exist
///
/// Any parts may follow: steppers, states, numbers, vectors, types with `void archive(auto& ar)`, each with a name before it
/// or named by its position: save_checkpoint(file, "stepper", stepper, "y", y, "t", t).
///
/// The file holds what later steps depend on: t, y, slopes and lengths carried from step to step, the memory of forces, the
/// controller's numbers, counts. It does not hold Jacobians, factors and their patterns, and saving forgets them: the run
/// that saved and the run that resumes go on with the same bits, at the price of one Jacobian, and those of schemes without
/// any (Euler, Verlet, particles) as if nothing had been saved. A save that fails forgets nothing.
///
/// Parameters and laws of forces, solvers and schemes belong to the program, and are not compared. Compared are the scheme's name,
/// and the names, kinds and shapes of all values. Any program, compiler and machine can read the file; only the same build gives
/// the same bits.
///
///     bytes    what, little-endian
///     8        89 50 48 49 0d 0a 1a 0a (as PNG's: a transfer as text breaks it)
///     4        version of this format
///     4        0
///     8        n, the length of what follows
///     n        the parts, as records (base/archive/archive.hpp)
///     8        CRC-64 of all the above
///
/// What fails any check is refused with a CheckpointError that says which, and nothing has changed.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <istream>
#include <ostream>
#include <random>
#include <span>
#include <string>
#include <system_error>
#include <type_traits>
#include <vector>
#if __has_include(<fcntl.h>) && __has_include(<unistd.h>)
#include <fcntl.h>
#include <unistd.h>
#endif

#include "phistep/base/archive/archive.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// CRC-64/XZ, by the ECMA-182 polynomial, reflected: sees every error that spans at most 64 bits, and all but 2⁻⁶⁴ of the others.
/// Of "123456789" it is 995dc9bbdf1939fa.
/// @param before  that of what came before, if the bytes come in pieces
[[nodiscard]] inline std::uint64_t checksum(std::span<const std::byte> bytes, std::uint64_t before = 0) {
  static constexpr auto table = [] {
    std::array<std::uint64_t, 256> all{};
    for (std::uint64_t i = 0; i < all.size(); ++i) {
      std::uint64_t crc = i;
      for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc % 2 == 1 ? 0xc96c5795d7870f42u : 0);
      all[static_cast<std::size_t>(i)] = crc;
    }
    return all;
  }();
  std::uint64_t crc = ~before;
  for (const std::byte byte : bytes)
    crc = table[static_cast<std::size_t>((crc ^ static_cast<std::uint64_t>(byte)) & 0xff)] ^ crc >> 8;
  return ~crc;
}

/// Raised whenever the meaning of the bytes changes.
inline constexpr std::uint32_t checkpoint_version = 2;

namespace detail {

struct CheckpointHead {
  std::array<unsigned char, 8> magic{0x89, 'P', 'H', 'I', '\r', '\n', 0x1a, '\n'};
  std::uint32_t version = checkpoint_version, zero = 0;
  std::uint64_t length = 0;
};
inline constexpr std::size_t checkpoint_head = sizeof(CheckpointHead);

[[noreturn]] inline void refuse(const std::string& name, const std::string& why) {
  throw CheckpointError("phistep: " + name + ' ' + why);
}

/// Up to n more bytes of a stream: a false length costs no more memory than there is file.
inline void read_bytes(std::istream& in, std::uint64_t n, std::vector<std::byte>& to) {
  while (n > 0 && in) {
    const auto piece = static_cast<std::size_t>(std::min<std::uint64_t>(n, 1 << 20));
    const std::size_t before = to.size();
    to.resize(before + piece);
    in.read(reinterpret_cast<char*>(to.data() + before), static_cast<std::streamsize>(piece));
    const auto got = static_cast<std::size_t>(in.gcount());
    to.resize(before + got);
    n -= got;
  }
}

/// Reads header and parts, and checks all that can be checked without knowing the parts.
/// @param alone  nothing may follow them in the stream
inline std::vector<std::byte> read_checkpoint(std::istream& in, const std::string& name, bool alone) {
  std::vector<std::byte> bytes, end;
  CheckpointHead head;
  std::uint64_t sum = 0;
  read_bytes(in, checkpoint_head, bytes);
  if (!bytes.empty()) std::memcpy(&head, bytes.data(), bytes.size());
  if (bytes.size() < head.magic.size() || head.magic != CheckpointHead{}.magic)
    refuse(name, "is not a phistep checkpoint");
  if (bytes.size() < checkpoint_head) refuse(name, "is truncated: its header is incomplete");
  if (head.version != checkpoint_version)
    refuse(name, "has version " + std::to_string(head.version) + " of the format, this program reads version " +
                     std::to_string(checkpoint_version));
  read_bytes(in, head.length, bytes);
  if (bytes.size() - checkpoint_head < head.length)
    refuse(name, "is truncated: " + std::to_string(bytes.size() - checkpoint_head) + " bytes of " +
                     std::to_string(head.length) + " are there");
  read_bytes(in, sizeof sum, end);
  if (end.size() < sizeof sum) refuse(name, "is truncated: its checksum is incomplete");
  std::memcpy(&sum, end.data(), sizeof sum);
  if (sum != checksum(bytes)) refuse(name, "is damaged: its checksum is wrong");
  if (alone && in.peek() != std::istream::traits_type::eof()) refuse(name, "is damaged: it goes on after its end");
  return bytes;
}

template <class... Parts>
void load_parts_of(std::istream& in, const std::string& name, bool alone, Parts&... parts) {
  const std::vector<std::byte> bytes = read_checkpoint(in, name, alone);
  Reader reader{std::span(bytes).subspan(checkpoint_head)};
  reader.load(parts...);
}

/// Waits until a file is on the disk, where the system can; false where that fails.
inline bool reach_disk([[maybe_unused]] const std::filesystem::path& file) {
#if __has_include(<fcntl.h>) && __has_include(<unistd.h>)
  const int opened = ::open(file.c_str(), O_RDONLY);
  const bool done = opened >= 0 && ::fsync(opened) == 0;
  return (opened < 0 || ::close(opened) == 0) && done;
#else
  return true;
#endif
}

template <class... Parts>
void write_checkpoint(std::ostream& out, const Parts&... parts) {
  Writer writer;
  writer.save(parts...);
  const CheckpointHead head{.length = writer.bytes().size()};
  const std::span<const std::byte> start = std::as_bytes(std::span(&head, 1));
  const std::uint64_t sum = checksum(writer.bytes(), checksum(start));
  for (const std::span<const std::byte> bytes : {start, writer.bytes(), {std::as_bytes(std::span(&sum, 1))}})
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  out.flush();
  if (!out) throw CheckpointError("phistep: writing the checkpoint failed");
}

/// Lets write(stream) write a file: beside it first, on the disk, then by renaming. A link is followed to its file. The
/// random name beside it keeps two writers apart.
void write_file(const std::filesystem::path& path, auto&& write) {
  std::error_code error;
  std::filesystem::path there = path;
  for (int links = 0; links < 40 && is_symlink(there, error); ++links)  // links may lead in a circle
    there = there.parent_path() / std::filesystem::read_symlink(there);
  std::random_device random;
  const std::filesystem::path beside = there.string() + '.' + std::to_string(random()) + ".part";
  try {
    std::ofstream out(beside, std::ios::binary);
    if (!out) refuse(beside.string(), "can't be written");
    write(out);
    out.close();
    if (!out || !reach_disk(beside)) refuse(beside.string(), "can't be written");
    std::filesystem::rename(beside, there, error);
    if (error) refuse(path.string(), "can't be written: " + error.message());
  } catch (...) {
    std::filesystem::remove(beside, error);
    throw;
  }
}

/// After a save: what the file doesn't hold.
template <class Part>
void forget_unsaved(Part& part) {
  if constexpr (HasUnsaved<std::remove_const_t<Part>>) {
    static_assert(!std::is_const_v<Part>,
                  "phistep: saving forgets Jacobians and factors: a stepper or run that has them can't be const here");
    if constexpr (!std::is_const_v<Part>) part.forget_unsaved();
  }
}

}  // namespace detail

/// Writes a checkpoint of the parts to a stream that was opened as std::ios::binary, and forgets what is not in it.
/// @throws CheckpointError where the stream fails; nothing is forgotten then
template <class... Parts>
void save_checkpoint(std::ostream& out, Parts&&... parts) {
  detail::write_checkpoint(out, parts...);
  (detail::forget_unsaved(parts), ...);
}

/// Reads what save_checkpoint wrote for parts of the same names, kinds and shapes. @throws CheckpointError
template <class... Parts>
void load_checkpoint(std::istream& in, Parts&&... parts) {
  detail::load_parts_of(in, "the stream", false, parts...);
}

/// Writes a checkpoint to a file: beside it first, then by renaming, so that a crash meanwhile, of the machine too, leaves the old one.
/// @throws CheckpointError where the file can't be written; the old one is then still there, and nothing is forgotten
template <class... Parts>
void save_checkpoint(const std::filesystem::path& path, Parts&&... parts) {
  detail::write_file(path, [&](std::ostream& out) { detail::write_checkpoint(out, parts...); });
  (detail::forget_unsaved(parts), ...);
}

/// Reads a checkpoint from a file. False, and nothing read, where there is no such file: a first start.
/// @throws CheckpointError where there is one that can't be read or doesn't fit; nothing has changed then
template <class... Parts>
[[nodiscard]] bool load_checkpoint(const std::filesystem::path& path, Parts&&... parts) {
  std::error_code error;
  if (!std::filesystem::exists(path, error) && !error) return false;
  std::ifstream in(path, std::ios::binary);
  if (!in) detail::refuse(path.string(), "can't be opened");
  detail::load_parts_of(in, path.string(), true, parts...);
  return true;
}

}}  // namespace phistep::PHISTEP_ABI
