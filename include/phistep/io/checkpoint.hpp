/// @file
/// Checkpoints: a run's parts in a file, from which a program built alike continues to the bits of the unbroken run.
///
///     save_checkpoint("run.checkpoint", stepper, y, t);        // now and then
///     load_checkpoint("run.checkpoint", stepper, y, t);        // at the next start; false where there is no such file
///
/// Any parts may follow: a run, numbers, vectors, what has `void archive(auto& ar)`. Parameters of forces, solvers and
/// schemes are the program's and not in the file: make the stepper as it was made, with a state of the same sizes.
///
///     bytes    what
///     8        89 50 48 49 0d 0a 1a 0a (as PNG's: a transfer as text breaks it)
///     4        version of this format
///     4        01020304 in the writer's byte order
///     8        checksum of the parts' types: their names hold the library's version and the instruction set, which
///              change bits
///     8        n, the length of what follows
///     n        the parts (core/archive.hpp)
///     8        CRC-64 of all the above
///
/// What fails any check is refused with a CheckpointError that says which, before anything has changed.
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
#include <span>
#include <string>
#include <system_error>
#include <type_traits>
#include <typeinfo>
#include <vector>

#include "phistep/core/archive.hpp"
#include "phistep/core/checksum.hpp"
#include "phistep/core/version.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/parts.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Raised whenever the meaning of the bytes changes.
inline constexpr std::uint32_t checkpoint_version = 1;

namespace detail {

struct CheckpointHeader {
  std::array<unsigned char, 8> magic{0x89, 'P', 'H', 'I', '\r', '\n', 0x1a, '\n'};
  std::uint32_t version = checkpoint_version, byte_order = 0x01020304;
  std::uint64_t types = 0, length = 0;
};
static_assert(sizeof(CheckpointHeader) == 32 && std::has_unique_object_representations_v<CheckpointHeader>);

template <class... Parts>
[[nodiscard]] std::uint64_t checksum_of_types() {
  std::string names;
#ifdef __cpp_rtti
  ((names += typeid(Parts).name(), names += ';'), ...);
#else
  static_assert(sizeof...(Parts) == 0, "phistep: a checkpoint names its parts' types: compile without -fno-rtti");
#endif
  return checksum(std::as_bytes(std::span(names)));
}

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

/// Header and parts, all checked that can be without knowing the parts.
/// @param alone  nothing may follow
inline std::vector<std::byte> read_checkpoint(std::istream& in, const std::string& name, bool alone,
                                              std::uint64_t types) {
  const CheckpointHeader own;
  CheckpointHeader header;
  std::vector<std::byte> bytes;
  read_bytes(in, sizeof header, bytes);
  const bool starts = bytes.size() >= own.magic.size() && std::memcmp(bytes.data(), own.magic.data(), 8) == 0;
  if (!starts) refuse(name, "is not a phistep checkpoint");
  if (bytes.size() < sizeof header) refuse(name, "is truncated: its header is incomplete");
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.byte_order == 0x04030201) refuse(name, "comes from a machine of another byte order");
  if (header.version != own.version)
    refuse(name, "has version " + std::to_string(header.version) + " of the format, this program reads version " +
                     std::to_string(own.version));
  read_bytes(in, header.length, bytes);
  if (bytes.size() - sizeof header < header.length)
    refuse(name, "is truncated: " + std::to_string(bytes.size() - sizeof header) + " bytes of " +
                     std::to_string(header.length) + " are there");
  const std::uint64_t expected = checksum(bytes);
  std::vector<std::byte> end;
  read_bytes(in, sizeof expected, end);
  if (end.size() < sizeof expected) refuse(name, "is truncated: its checksum is incomplete");
  if (std::memcmp(end.data(), &expected, sizeof expected) != 0) refuse(name, "is damaged: its checksum is wrong");
  if (alone && in.peek() != std::istream::traits_type::eof()) refuse(name, "is damaged: it goes on after its end");
  if (header.types != types)
    refuse(name,
           "was written by another program: its stepper, state or force has another type, or the build another "
           "instruction set or version of phistep");
  return bytes;
}

/// States keep their shapes; everything else is what it is.
template <class Part>
[[nodiscard]] decltype(auto) as_part(Part& part) {
  if constexpr (State<Part> && !Restorable<Part>) return StatePart<Part>{part};
  else return (part);
}

template <class... Parts>
void load_parts_of(std::istream& in, const std::string& name, bool alone, Parts&... parts) {
  const std::vector<std::byte> bytes = read_checkpoint(in, name, alone, checksum_of_types<Parts...>());
  Reader reader{std::span(bytes).subspan(sizeof(CheckpointHeader))};
  [&reader](auto&&... part) {
    load_parts(
        reader, [&reader] { reader.finish(); }, part...);
  }(as_part(parts)...);
}

}  // namespace detail

/// Writes a checkpoint of the parts to a stream that was opened as std::ios::binary.
/// @throws CheckpointError where the stream fails
template <class... Parts>
void save_checkpoint(std::ostream& out, const Parts&... parts) {
  Writer writer;
  save_parts(writer, parts...);
  writer.finish();
  detail::CheckpointHeader header;
  header.types = detail::checksum_of_types<Parts...>();
  header.length = writer.bytes().size();
  const auto head = std::as_bytes(std::span(&header, 1));
  const std::uint64_t end = checksum(writer.bytes(), checksum(head));
  const auto put = [&out](std::span<const std::byte> bytes) {
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  };
  put(head);
  put(writer.bytes());
  put(std::as_bytes(std::span(&end, 1)));
  out.flush();
  if (!out) throw CheckpointError("phistep: writing the checkpoint failed");
}

/// Reads what save_checkpoint wrote for parts of the same types, in the same order. @throws CheckpointError
template <class... Parts>
void load_checkpoint(std::istream& in, Parts&... parts) {
  detail::load_parts_of(in, "the stream", false, parts...);
}

/// Writes a checkpoint to a file: beside it first, then by renaming, so that a crash meanwhile leaves the old one.
/// @throws CheckpointError where the file can't be written; the old one is then still there
template <class... Parts>
void save_checkpoint(const std::filesystem::path& path, const Parts&... parts) {
  std::filesystem::path beside = path;
  beside += ".part";
  std::error_code error;
  try {
    std::ofstream out(beside, std::ios::binary);
    if (!out) detail::refuse(beside.string(), "can't be written");
    save_checkpoint(out, parts...);
    out.close();
    if (!out) detail::refuse(beside.string(), "can't be written");
    std::filesystem::rename(beside, path, error);
    if (error) detail::refuse(path.string(), "can't be written: " + error.message());
  } catch (...) {
    std::filesystem::remove(beside, error);
    throw;
  }
}

/// Reads a checkpoint from a file. False, and nothing read, where there is no such file: a first start.
/// @throws CheckpointError where there is one that can't be read or doesn't fit; nothing has changed then
template <class... Parts>
[[nodiscard]] bool load_checkpoint(const std::filesystem::path& path, Parts&... parts) {
  std::error_code error;
  if (!std::filesystem::exists(path, error) && !error) return false;
  std::ifstream in(path, std::ios::binary);
  if (!in) detail::refuse(path.string(), "can't be opened");
  detail::load_parts_of(in, path.string(), true, parts...);
  return true;
}

}  // namespace phistep::inline PHISTEP_ABI
