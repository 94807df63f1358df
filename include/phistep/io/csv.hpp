/// @file
/// Tables as comma-separated values: a line of names, then one line a time, t first; every number reads back to its bits.
///
///     write_csv("orbit.csv", recorder);
///     integrate(…, csv(out));                                                      // while the run goes on
///     integrate(…, csv(out, column("E", [](double, const auto& y) { return energy(y); })));
///
/// Components are named by their block (r, v of a motion; y of a plain vector; b0, b1, … else) and their place: r0, r1, …,
/// in a matrix r0_1 for row 0 of column 1. Numbers are written alike in every locale; NaN and infinities are nan, inf, -inf.
#pragma once

#include <cstddef>
#include <fstream>
#include <ostream>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/state/blocks.hpp"
#include "phistep/io/text.hpp"
#include "phistep/run/observers/recorder.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What the k-th block of a state is called.
template <State S>
[[nodiscard]] std::string block_name(std::size_t k) {
  if constexpr (EigenDense<S>) return "y";
  else if constexpr (Blocks<S>::drifts) return k == 0 ? "r" : k == 1 ? "v" : "b" + std::to_string(k);
  else return "b" + std::to_string(k);
}

/// Lines of a table.
struct CsvWriter {
  std::ostream* out;
  std::string line{};

  /// A number, by the fewest digits that read back to its bits; text, quoted where it must be (RFC 4180).
  template <class X>
  void cell(const X& x) {
    if (!line.empty()) line += ',';
    if constexpr (std::is_arithmetic_v<X>) {
      append_number(line, x);
    } else {
      const std::string text{x}, mark = text.find_first_of(",\"\r\n") == std::string::npos ? "" : "\"";
      line += mark;
      for (const char c : text) line.append(c == '"' ? 2 : 1, c);
      line += mark;
    }
  }
  /// The cells that name a block's components, in the order in which they are written: column by column.
  void names(const std::string& block, Index rows, Index cols) {
    for (Index j = 0; j < cols; ++j)
      for (Index i = 0; i < rows; ++i)
        cell(block + std::to_string(rows == 1 && cols > 1 ? j : i) +
             (rows > 1 && cols > 1 ? "_" + std::to_string(j) : ""));
  }
  /// @throws std::runtime_error where the stream fails
  void end_line() {
    line += '\n';
    out->write(line.data(), static_cast<std::streamsize>(line.size()));
    line.clear();
    if (!*out) throw std::runtime_error("phistep: writing comma-separated values failed");
  }
};

/// Everything a recorder holds. An empty one gives the name of the time alone.
template <State S>
void write_csv(std::ostream& out, const Recorder<S>& recorder) {
  CsvWriter table{&out};
  table.cell("t");
  for (std::size_t k = 0; k < Recorder<S>::blocks; ++k)
    table.names(block_name<S>(k), recorder.shape(k).first, recorder.shape(k).second);
  table.end_line();
  const auto times = recorder.times();
  const auto states = recorder.states();
  for (Index n = 0; n < recorder.size(); ++n) {
    table.cell(times[n]);
    for (Index i = 0; i < states.rows(); ++i) table.cell(states(i, n));
    table.end_line();
  }
}
/// @throws std::runtime_error where the file can't be written
template <State S>
void write_csv(const std::string& path, const Recorder<S>& recorder) {
  std::ofstream out(path, std::ios::binary);
  if (!out) throw std::runtime_error("phistep: cannot open " + path + " for writing");
  write_csv(out, recorder);
  out.close();
  if (!out) throw std::runtime_error("phistep: writing " + path + " failed");
}

/// An observer that writes a line each time it is called: the given columns, or without any the whole state.
/// `integrate(…, csv(out))`; `every(0.1, csv(out))` for fewer lines. The names are written once.
/// @throws std::runtime_error where the stream fails; std::invalid_argument where the state's size has changed
template <class... F>
[[nodiscard]] auto csv(std::ostream& out, NamedColumn<F>... columns) {
  return [table = CsvWriter{&out}, columns = std::make_tuple(std::move(columns)...), size = Index{-1}]<State S>(
             auto t, const S& state) mutable {
    const auto blocks = Blocks<S>::all(state);
    const auto line = [&](const auto& first, auto&& of_block, auto&& of_column) {
      table.cell(first);
      if constexpr (sizeof...(F) == 0) for_each_block(of_block, blocks);
      else std::apply([&](auto&... column) { (table.cell(of_column(column)), ...); }, columns);
      table.end_line();
    };
    const Index now = sizeof...(F) == 0 ? count_of(blocks) : 0;
    if (std::exchange(size, size < 0 ? now : size) < 0)
      line(
          "t", [&](auto k, const auto& block) { table.names(block_name<S>(k()), block.rows(), block.cols()); },
          [](auto& column) { return column.name; });
    if (now != size)
      throw std::invalid_argument("phistep: csv(out) has named " + std::to_string(size) +
                                  " components, the state now has " + std::to_string(now));
    line(
        t,
        [&](auto, const auto& block) {
          for (Index j = 0; j < block.cols(); ++j)
            for (Index i = 0; i < block.rows(); ++i) table.cell(block(i, j));
        },
        [&](auto& column) { return column.content(t, state); });
  };
}

}}  // namespace phistep::PHISTEP_ABI
