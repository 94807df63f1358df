/// @file
/// Checkpoints of a run whose state is spread over ranks: each rank writes its part, and one file names them.
///
///     save_on_ranks(y, "run.checkpoint", run);        // on all ranks of the field y; checkpoint.hpp has the rest
///     load_on_ranks(y, "run.checkpoint", run);        // on as many ranks as saved it; false: no such file
///
/// In save s rank k writes run.checkpoint.s.k, a checkpoint of its own; when all have, rank 0 writes run.checkpoint, with the number
/// of the save and of the ranks, and the parts of the save before go. A crash at any time leaves one that is whole. All ranks
/// see one file system.
#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <span>
#include <string>
#include <system_error>
#include <vector>

#include "phistep/base/state/field.hpp"
#include "phistep/base/state/ranks.hpp"
#include "phistep/io/checkpoint.hpp"

namespace phistep { inline namespace PHISTEP_ABI {
namespace detail {

/// Runs f() on each rank. Where it throws on any, all throw: that rank what f() threw, the others a CheckpointError.
template <class Ops>
void on_all_ranks(const Field<Ops>& ranks, const std::filesystem::path& path, auto&& f) {
  try {
    static_cast<void>(ask_all_ranks(ranks, [&f] { return f(), true; }));
  } catch (const ThrownElsewhere&) {
    refuse(path.string(), "can't be used on another rank");
  }
}

/// The contents of the file that names the parts.
struct RankManifest {
  static constexpr const char* part_name = "manifest";
  int save = 0, ranks = 0;
  void archive(auto& ar) { ar("save", save, "ranks", ranks); }
  [[nodiscard]] auto stamp(int rank) const {
    return "rank " + std::to_string(rank) + " of " + std::to_string(ranks) + ", save " + std::to_string(save);
  }
  [[nodiscard]] std::filesystem::path part(const std::filesystem::path& path, int rank) const {
    return path.string() + '.' + std::to_string(save) + '.' + std::to_string(rank);
  }
};
/// What the part of one rank begins with: it tells which save and which rank the part belongs to.
struct RankStamp {
  static constexpr const char* part_name = "stamp";
  std::string text;
  void archive(auto& ar) { ar.fact("part", text); }
};

}  // namespace detail

/// Writes the parts of each rank. @param ranks  any field that lives on these ranks
/// @throws CheckpointError on all ranks where one can't write; then the save before is still there, and the parts are unchanged
template <class Ops, class... Parts>
void save_on_ranks(const Field<Ops>& ranks, const std::filesystem::path& path, Parts&&... parts) {
  const int rank = Ops::rank(ranks.handle());
  detail::RankManifest before, now;
  try {
    static_cast<void>(load_checkpoint(path, before));
  } catch (const CheckpointError&) {  // a file that can't be read is replaced
  }
  now = {Ops::most(ranks.handle(), before.save) + 1, Ops::ranks(ranks.handle())};
  detail::on_all_ranks(ranks, path, [&] {
    detail::write_file(now.part(path, rank), [&](std::ostream& out) {
      detail::write_checkpoint(out, detail::RankStamp{now.stamp(rank)}, parts...);
    });
  });
  detail::on_all_ranks(ranks, path, [&] {
    if (rank == 0) save_checkpoint(path, now);
  });
  (detail::forget_unsaved(parts), ...);
  std::error_code error;
  for (int k = rank; k < before.ranks; k += now.ranks) std::filesystem::remove(before.part(path, k), error);
}

/// Reads a checkpoint that the same number of ranks has saved. Returns false, and changes nothing, if there is no such file.
/// @throws CheckpointError on all ranks where one of them can't read its part; nothing has changed then
template <class Ops, class... Parts>
[[nodiscard]] bool load_on_ranks(const Field<Ops>& ranks, const std::filesystem::path& path, Parts&&... parts) {
  std::error_code error;
  const bool is_there = std::filesystem::exists(path, error);
  if (Ops::most(ranks.handle(), is_there ? 1 : 0) == 0) return false;
  const int rank = Ops::rank(ranks.handle()), all = Ops::ranks(ranks.handle());
  detail::RankManifest manifest;
  std::vector<std::byte> bytes;
  detail::on_all_ranks(ranks, path, [&] {
    if (!load_checkpoint(path, manifest)) detail::refuse(path.string(), "is not seen by all ranks");
    if (manifest.ranks != all)
      detail::refuse(path.string(),
                     "was written by " + std::to_string(manifest.ranks) + " ranks, here are " + std::to_string(all) +
                         ": start as many, or read the state from a file that the vectors' library has written");
    const std::string part = manifest.part(path, rank).string();
    std::ifstream in(part, std::ios::binary);
    if (!in) detail::refuse(part, "can't be opened");
    bytes = detail::read_checkpoint(in, part, true);
  });
  // No rank keeps what it has read before all ranks have read theirs.
  Reader reader{std::span(bytes).subspan(detail::checkpoint_head)};
  detail::RankStamp stamp{manifest.stamp(rank)};
  reader.load_by([&](auto&& read) { detail::on_all_ranks(ranks, path, read); }, stamp, parts...);
  return true;
}

}}  // namespace phistep::PHISTEP_ABI
