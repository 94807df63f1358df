/// @file
/// Keeps every state that it is shown.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include "phistep/base/state/blocks.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Records times and states: `Recorder<State> recorder; integrate(…, recorder);`, or `every(0.1, std::ref(recorder))`.
template <State S>
class Recorder {
 public:
  using Scalar = ScalarOf<S>;
  using KeepsStates = void;
  static constexpr std::size_t blocks = std::tuple_size_v<decltype(Blocks<S>::all(std::declval<PlainState<S>&>()))>;

  /// @throws std::invalid_argument where the state has another shape than those before it.
  void operator()(Scalar t, const S& state) {
    Shapes shapes;
    for_each_block([&shapes](auto k, const auto& block) { shapes.col(k) << block.rows(), block.cols(); },
                   Blocks<S>::all(state));
    if (!times_.empty() && (shapes != shapes_).any())
      throw std::invalid_argument("phistep: a Recorder keeps states of one shape; clear() it before another");
    // Room for both first: a time without its state would shift all that is kept.
    grow(times_, 1);
    grow(values_, static_cast<std::size_t>(numbers_of(shapes)));
    shapes_ = shapes;
    times_.push_back(t);
    for_each_block(
        [this](auto, const auto& block) {
          for (Index j = 0; j < block.cols(); ++j)
            for (Index i = 0; i < block.rows(); ++i) values_.push_back(block(i, j));
        },
        Blocks<S>::all(state));
  }
  [[nodiscard]] Index size() const { return static_cast<Index>(times_.size()); }
  /// The times, in order. [time]
  [[nodiscard]] auto times() const {
    return Eigen::Map<const Eigen::Matrix<Scalar, Eigen::Dynamic, 1>>(times_.data(), size());
  }
  /// One column a time: all blocks of the state, one after the other (motion: r, then v), each column by column.
  [[nodiscard]] auto states() const { return rows(0, stride()); }
  /// The k-th block alone, one column a time.
  [[nodiscard]] auto block(std::size_t k) const {
    if (k >= blocks) throw std::out_of_range("phistep: Recorder::block(k) of a state with fewer blocks");
    const auto n = static_cast<Index>(k);
    return rows(numbers_of(shapes_.leftCols(n)), shapes_.col(n).prod());
  }
  [[nodiscard]] auto position() const requires(Blocks<S>::drifts) { return block(0); }  ///< r [length], a column a time
  [[nodiscard]] auto velocity() const requires(Blocks<S>::drifts) { return block(1); }  ///< v [length/time]
  /// Rows and columns of the k-th block as it was in the state; 0 before the first.
  [[nodiscard]] std::pair<Index, Index> shape(std::size_t k) const {
    return {shapes_(0, static_cast<Index>(k)), shapes_(1, static_cast<Index>(k))};
  }

  /// All that it has, for a checkpoint.
  void archive(auto& ar) {
    ar("times", times_, "values", values_, "shapes", shapes_);
    const auto all = static_cast<Index>(values_.size());
    for (const auto& shape : shapes_.colwise())
      ar.check(0 <= shape[0] && 0 <= shape[1] && (shape[1] == 0 || shape[0] <= all / shape[1]));
    ar.check(all == numbers_of(shapes_) * size());
  }
  void clear() {
    times_.clear();
    values_.clear();
    shapes_.setZero();
  }

 private:
  using Shapes = Eigen::Array<Index, 2, static_cast<int>(blocks)>;  // rows and columns of each block
  [[nodiscard]] static Index numbers_of(const auto& shapes) { return shapes.colwise().prod().sum(); }
  static void grow(std::vector<Scalar>& list, std::size_t by) {
    if (list.capacity() - list.size() < by) list.reserve(std::max(2 * list.size(), list.size() + by));
  }
  [[nodiscard]] Index stride() const { return times_.empty() ? 0 : static_cast<Index>(values_.size()) / size(); }
  [[nodiscard]] auto rows(Index first, Index n) const {
    using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
    return Eigen::Map<const Matrix, 0, Eigen::OuterStride<>>(values_.data() + first, n, size(),
                                                             Eigen::OuterStride<>(stride()));
  }

  std::vector<Scalar> times_, values_;
  Shapes shapes_ = Shapes::Zero();
};

}}  // namespace phistep::PHISTEP_ABI
