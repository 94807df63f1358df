/// @file
/// Keeps every state that it is shown.
#pragma once

#include <Eigen/Core>

#include <vector>

#include "phistep/core/version.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Records times and states: `Recorder<State> recorder; integrate(…, recorder);`, or `every(0.1, std::ref(recorder))`.
template <State S>
class Recorder {
 public:
  using Scalar = ScalarOf<S>;

  void operator()(Scalar t, const S& state) {
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
  /// One column a time: all blocks of the state, one after the other (motion: r, then v).
  [[nodiscard]] auto states() const {
    const Index rows = times_.empty() ? 0 : static_cast<Index>(values_.size()) / size();
    return Eigen::Map<const Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>>(values_.data(), rows, size());
  }
  void archive(auto& ar) { ar(times_, values_); }
  void clear() {
    times_.clear();
    values_.clear();
  }

 private:
  std::vector<Scalar> times_, values_;
};

}  // namespace phistep::inline PHISTEP_ABI
