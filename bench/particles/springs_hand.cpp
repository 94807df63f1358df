#include "springs.hpp"

namespace bench {
namespace {
struct Vec3 {
  double x, y, z;
};

/// Both ends at once, and the array of forces cleared in the pass that uses it.
class Scatter : public SheetStepper {
 public:
  explicit Scatter(const Sheet& sheet) : ends_{sheet.ends}, lengths_{sheet.lengths} {
    for (const auto& r : sheet.r.colwise()) r_.push_back({r.x(), r.y(), r.z()});
    v_.resize(r_.size());
    f_.resize(r_.size());
  }
  void step(int times) override {
    for (int n = 0; n < times; ++n) {
      for (std::size_t s = 0; s < ends_.size(); ++s) {
        const auto [i, j] = ends_[s];
        const Vec3 a = r_[static_cast<std::size_t>(i)], b = r_[static_cast<std::size_t>(j)];
        const double x = b.x - a.x, y = b.y - a.y, z = b.z - a.z;
        const double pull = Sheet::k * (1 - lengths_[s] / std::sqrt(x * x + y * y + z * z));
        Vec3 &fi = f_[static_cast<std::size_t>(i)], &fj = f_[static_cast<std::size_t>(j)];
        fi = {fi.x + pull * x, fi.y + pull * y, fi.z + pull * z};
        fj = {fj.x - pull * x, fj.y - pull * y, fj.z - pull * z};
      }
      for (std::size_t i = 0; i < r_.size(); ++i) {
        Vec3 &v = v_[i], &r = r_[i], &f = f_[i];
        v = {v.x + Sheet::dt * f.x, v.y + Sheet::dt * f.y, v.z + Sheet::dt * f.z};
        r = {r.x + Sheet::dt * v.x, r.y + Sheet::dt * v.y, r.z + Sheet::dt * v.z};
        f = {0, 0, 0};
      }
    }
  }
  [[nodiscard]] Eigen::Matrix3Xd positions() const override {
    return Eigen::Map<const Eigen::Matrix3Xd>(&r_[0].x, 3, static_cast<Eigen::Index>(r_.size()));
  }

 private:
  std::vector<std::pair<int, int>> ends_;
  std::vector<double> lengths_;
  std::vector<Vec3> r_, v_, f_{};
};

/// Every particle sums over its own springs: each spring twice, but no scatter; eight particles in step, their springs
/// padded to the longest row, and the update in the same pass, into a second array.
class Rows : public SheetStepper {
  static constexpr std::size_t lanes = 8;

 public:
  explicit Rows(const Sheet& sheet) : n_{static_cast<std::size_t>(sheet.r.cols())} {
    std::vector<std::vector<std::pair<int, double>>> springs(n_);
    for (std::size_t s = 0; s < sheet.springs(); ++s) {
      const auto [i, j] = sheet.ends[s];
      springs[static_cast<std::size_t>(i)].emplace_back(j, sheet.lengths[s]);
      springs[static_cast<std::size_t>(j)].emplace_back(i, sheet.lengths[s]);
    }
    const std::size_t chunks = (n_ + lanes - 1) / lanes;
    first_.push_back(0);
    for (std::size_t c = 0; c < chunks; ++c) {
      std::size_t longest = 0;
      const auto row = [&](std::size_t lane) { return std::min(c * lanes + lane, n_ - 1); };
      for (std::size_t lane = 0; lane < lanes; ++lane) longest = std::max(longest, springs[row(lane)].size());
      for (std::size_t w = 0; w < longest; ++w)
        for (std::size_t lane = 0; lane < lanes; ++lane) {
          const auto& own = springs[row(lane)];
          other_.push_back(w < own.size() ? own[w].first : static_cast<int>(row(lane)));
          length_.push_back(w < own.size() ? own[w].second : 0);
        }
      first_.push_back(other_.size());
    }
    for (auto* to : {&x_, &next_}) to->setZero(static_cast<Eigen::Index>(chunks * lanes), 3);
    v_.setZero(x_.rows(), 3);
    x_.topRows(sheet.r.cols()) = sheet.r.transpose();
  }
  void step(int times) override {
    for (int n = 0; n < times; ++n) {
      const double *const x = x_.col(0).data(), *const y = x_.col(1).data(), *const z = x_.col(2).data();
      double *const nx = next_.col(0).data(), *const ny = next_.col(1).data(), *const nz = next_.col(2).data();
      double *const vx = v_.col(0).data(), *const vy = v_.col(1).data(), *const vz = v_.col(2).data();
      for (std::size_t c = 0; c + 1 < first_.size(); ++c) {
        const std::size_t i = c * lanes;
        alignas(64) double ax[lanes] = {}, ay[lanes] = {}, az[lanes] = {};
        for (std::size_t w = first_[c]; w < first_[c + 1]; w += lanes) {
          const int* const j = other_.data() + w;
          const double* const length = length_.data() + w;
#pragma GCC ivdep
          for (std::size_t lane = 0; lane < lanes; ++lane) {
            const double dx = x[j[lane]] - x[i + lane], dy = y[j[lane]] - y[i + lane], dz = z[j[lane]] - z[i + lane];
            const double pull = Sheet::k * (1 - length[lane] / std::sqrt(dx * dx + dy * dy + dz * dz + 1e-300));
            ax[lane] += pull * dx;
            ay[lane] += pull * dy;
            az[lane] += pull * dz;
          }
        }
#pragma GCC ivdep
        for (std::size_t lane = 0; lane < lanes; ++lane) {
          vx[i + lane] += Sheet::dt * ax[lane];
          vy[i + lane] += Sheet::dt * ay[lane];
          vz[i + lane] += Sheet::dt * az[lane];
          nx[i + lane] = x[i + lane] + Sheet::dt * vx[i + lane];
          ny[i + lane] = y[i + lane] + Sheet::dt * vy[i + lane];
          nz[i + lane] = z[i + lane] + Sheet::dt * vz[i + lane];
        }
      }
      x_.swap(next_);
    }
  }
  [[nodiscard]] Eigen::Matrix3Xd positions() const override {
    return x_.topRows(static_cast<Eigen::Index>(n_)).transpose();
  }

 private:
  std::size_t n_;
  std::vector<std::size_t> first_;
  std::vector<int> other_;
  std::vector<double> length_;
  Eigen::Matrix<double, Eigen::Dynamic, 3> x_, next_, v_;
};
}  // namespace

std::unique_ptr<SheetStepper> hand_scatter(const Sheet& sheet) { return std::make_unique<Scatter>(sheet); }
std::unique_ptr<SheetStepper> hand_rows(const Sheet& sheet) { return std::make_unique<Rows>(sheet); }

}  // namespace bench
