// Which linear system serves which matrix: the table, row by row, and as docs/reference/solvers.md has it.
#include <phistep/step/matrix/choice.hpp>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <string_view>

#include "support/catch.hpp"

using namespace phistep;

namespace {

constexpr SystemKind kind(const MatrixFacts& W) { return system_row(W).kind; }

/// As the page has it.
std::string as_markdown() {
  std::string table = "| the force is | `solver_name()` |\n|---|---|\n";
  for (const SystemRow& row : systems) table += std::string("| ") + row.serves + " | " + row.name + " |\n";
  return table;
}

}  // namespace

TEST_CASE("choice: each row is the first that takes some matrix") {
  using enum Structure;
  static_assert(kind({.structure = sparse, .matrix_free = true}) == SystemKind::matrix_free);
  static_assert(kind({.structure = sparse, .own_solver = true, .preconditioned = true}) == SystemKind::preconditioned);
  static_assert(kind({.structure = none, .own_solver = true}) == SystemKind::own);
  static_assert(kind({.structure = none}) == SystemKind::diagonal);
  static_assert(kind({.structure = diagonal, .n = 3}) == SystemKind::diagonal);
  static_assert(kind({.structure = local, .block = 3}) == SystemKind::particles);
  static_assert(kind({.structure = local, .n = 3, .block = 3}) == SystemKind::dense);  // one particle
  static_assert(kind({.structure = dense, .n = 12, .static_pattern = true}) == SystemKind::static_pattern);
  static_assert(kind({.structure = dense}) == SystemKind::dense);
  static_assert(kind({.structure = dense, .n = 12}) == SystemKind::dense);
  static_assert(kind({.structure = network, .symmetric = true, .block = 3}) == SystemKind::edges);
  static_assert(kind({.structure = network, .n = 24, .symmetric = true, .block = 3}) == SystemKind::dense);
  static_assert(kind({.structure = network, .n = 27, .symmetric = true, .block = 3}) == SystemKind::edges);
  static_assert(kind({.structure = network, .block = 3}) == SystemKind::sparse_either);  // dashpots, say
  static_assert(kind({.structure = network, .symmetric = true, .block = 4}) == SystemKind::sparse_either);
  static_assert(kind({.structure = network, .n = 27, .block = 3}) == SystemKind::sparse_either);
  static_assert(kind({.structure = banded, .symmetric = true}) == SystemKind::banded);
  static_assert(kind({.structure = sparse, .symmetric = true}) == SystemKind::symmetric_sparse);
  static_assert(kind({.structure = sparse}) == SystemKind::sparse_either);
  static_assert(kind({.structure = sparse, .iterated = true, .differenced = true}) == SystemKind::sparse_either);
  static_assert(kind({.structure = sparse, .constant = true, .differenced = true}) == SystemKind::sparse_either);
  static_assert(kind({.structure = sparse, .differenced = true}) == SystemKind::sparse);
  static_assert(kind({.structure = sparse, .iterated = true, .shifted = true}) == SystemKind::sparse);

  std::set<SystemKind> kinds;
  std::set<std::string_view> names;
  for (const SystemRow& row : systems) kinds.insert(row.kind), names.insert(row.name);
  CHECK(kinds.size() == systems.size());
  CHECK(names.size() == systems.size());
}

TEST_CASE("choice: docs/reference/solvers.md has this table") {
  const auto page = std::filesystem::path(PHISTEP_SOURCE_DIR) / "docs/reference/solvers.md";
  std::ifstream in(page);
  REQUIRE(in);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  CHECK_THAT(text, contains(as_markdown()));
}
