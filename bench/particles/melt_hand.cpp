/// @file
/// Lennard-Jones forces by hand: particles and their periodic images in cache order as structs of four doubles, a full
/// list padded to eight, no scatter. With AVX-512 eight structs are loaded and transposed in registers, and 1/r² is the
/// 14-bit reciprocal refined twice; elsewhere two at a time, which is what every x86-64 has.
#include <algorithm>
#include <cstdint>
#include <vector>

#include "melt.hpp"

#ifdef __AVX512F__
#include <immintrin.h>
#endif

namespace bench {
namespace {
struct alignas(32) Vec4 {
  double x, y, z, w;
};

using Two [[gnu::vector_size(16)]] = double;

class RowForce : public HandForce {
 public:
  RowForce(const Scene& scene, double skin) : n_{scene.size()} {
    sort(scene);
    const double range = melt_cutoff + skin, side = scene.side;
    std::vector<std::vector<std::int32_t>> rows(static_cast<std::size_t>(n_));
    add_images(side, range);
    // Slots of images by what they are an image of and how it is shifted.
    Eigen::Matrix3Xd sorted(3, n_);
    for (Eigen::Index i = 0; i < n_; ++i) sorted.col(i) << at(i).x, at(i).y, at(i).z;
    for_each_pair(sorted, side, range, [&](Eigen::Index i, Eigen::Index j, const Eigen::Vector3d& d) {
      rows[static_cast<std::size_t>(i)].push_back(slot_at(j, sorted.col(i) + d, sorted.col(j), side));
      rows[static_cast<std::size_t>(j)].push_back(slot_at(i, sorted.col(j) - d, sorted.col(i), side));
    });
    const auto dummy = static_cast<std::int32_t>(r_.size());
    r_.push_back({1e6, 1e6, 1e6, 0});
    first_.push_back(0);
    for (auto& row : rows) {
      std::sort(row.begin(), row.end());
      list_.insert(list_.end(), row.begin(), row.end());
      while (list_.size() % 8 != 0) list_.push_back(dummy);
      first_.push_back(list_.size());
    }
    f_.resize(static_cast<std::size_t>(n_));
  }

  void compute() override {
    for (std::size_t i = 0; i < f_.size(); ++i) f_[i] = row(i);
  }
  [[nodiscard]] Eigen::Matrix3Xd forces() const override {
    Eigen::Matrix3Xd f(3, n_);
    for (Eigen::Index i = 0; i < n_; ++i) {
      const Vec4& own = f_[static_cast<std::size_t>(i)];
      f.col(order_[static_cast<std::size_t>(i)]) << own.x, own.y, own.z;
    }
    return f;
  }
  [[nodiscard]] std::string name() const override {
#ifdef __AVX512F__
    return "hand, AVX-512 intrinsics";
#else
    return "hand, two at a time";
#endif
  }

 private:
  const Vec4& at(Eigen::Index i) const { return r_[static_cast<std::size_t>(i)]; }

  void sort(const Scene& scene) {
    const int bins = std::max(1, static_cast<int>(scene.side / 1.4));
    const Eigen::Matrix3Xd in = scene.r.array() - scene.side * (scene.r.array() / scene.side).floor();
    const auto bin = [&](Eigen::Index i) {
      const auto c = [&](int a) { return std::min(bins - 1, static_cast<int>(in(a, i) / scene.side * bins)); };
      return (c(2) * bins + c(1)) * bins + c(0);
    };
    for (Eigen::Index i = 0; i < n_; ++i) order_.push_back(i);
    std::stable_sort(order_.begin(), order_.end(), [&](auto a, auto b) { return bin(a) < bin(b); });
    for (const Eigen::Index i : order_) r_.push_back({in(0, i), in(1, i), in(2, i), 0});
  }
  void add_images(double side, double range) {
    image_.assign(static_cast<std::size_t>(27 * n_), -1);
    for (int k = 0; k < 27; ++k)
      for (Eigen::Index i = 0; i < n_; ++i) {
        const Vec4 own = at(i);
        const Vec4 r{own.x + (k % 3 - 1) * side, own.y + (k / 3 % 3 - 1) * side, own.z + (k / 9 - 1) * side, 0};
        const auto inside = [&](double x) { return x > -range && x < side + range; };
        auto& slot = image_[static_cast<std::size_t>(27 * i + k)];
        if (k == 13) slot = static_cast<std::int32_t>(i);
        else if (inside(r.x) && inside(r.y) && inside(r.z)) {
          slot = static_cast<std::int32_t>(r_.size());
          r_.push_back(r);
        }
      }
  }
  /// The image of j that stands at `where`.
  [[nodiscard]] std::int32_t slot_at(Eigen::Index j, const Eigen::Vector3d& where, const Eigen::Vector3d& home,
                                     double side) const {
    const Eigen::Array3i k = ((where - home) / side).array().round().cast<int>();
    return image_[static_cast<std::size_t>(27 * j + (k.z() + 1) * 9 + (k.y() + 1) * 3 + k.x() + 1)];
  }

#ifdef __AVX512F__
  [[nodiscard]] Vec4 row(std::size_t i) const {
    using V = __m512d;
    const V x = _mm512_set1_pd(r_[i].x), y = _mm512_set1_pd(r_[i].y), z = _mm512_set1_pd(r_[i].z);
    const V one = _mm512_set1_pd(1), square = _mm512_set1_pd(melt_cutoff * melt_cutoff);
    const __m512i low = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13),
                  high = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
    V fx = _mm512_setzero_pd(), fy = fx, fz = fx;
    for (std::size_t q = first_[i]; q < first_[i + 1]; q += 8) {
      const std::int32_t* const j = list_.data() + q;
      const auto load = [&](int a, int b) {
        const auto address = [&](int k) { return &r_[static_cast<std::size_t>(j[k])].x; };
        return _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_load_pd(address(a))), _mm256_load_pd(address(b)), 1);
      };
      const V r0 = load(0, 4), r1 = load(1, 5), r2 = load(2, 6), r3 = load(3, 7);
      const V t0 = _mm512_unpacklo_pd(r0, r1), t1 = _mm512_unpackhi_pd(r0, r1);
      const V t2 = _mm512_unpacklo_pd(r2, r3), t3 = _mm512_unpackhi_pd(r2, r3);
      const V dx = x - _mm512_permutex2var_pd(t0, low, t2), dy = y - _mm512_permutex2var_pd(t1, low, t3);
      const V dz = z - _mm512_permutex2var_pd(t0, high, t2);
      const V d2 = dx * dx + dy * dy + dz * dz;
      V inverse = _mm512_rcp14_pd(d2);
      for (int k = 0; k < 2; ++k) inverse = _mm512_fmadd_pd(inverse, _mm512_fnmadd_pd(d2, inverse, one), inverse);
      const V s6 = inverse * inverse * inverse;
      const V all = _mm512_set1_pd(48) * s6 * (s6 - _mm512_set1_pd(0.5)) * inverse;
      const V f = _mm512_maskz_mov_pd(_mm512_cmp_pd_mask(d2, square, _CMP_LT_OQ), all);
      fx = _mm512_fmadd_pd(f, dx, fx);
      fy = _mm512_fmadd_pd(f, dy, fy);
      fz = _mm512_fmadd_pd(f, dz, fz);
    }
    return {_mm512_reduce_add_pd(fx), _mm512_reduce_add_pd(fy), _mm512_reduce_add_pd(fz), 0};
  }
#else
  [[nodiscard]] Vec4 row(std::size_t i) const {
    using V = Two;
    const Vec4 own = r_[i];
    const V x{own.x, own.x}, y{own.y, own.y}, z{own.z, own.z};
    V fx{}, fy{}, fz{};
    for (std::size_t q = first_[i]; q < first_[i + 1]; q += 2) {
      const Vec4 &a = r_[static_cast<std::size_t>(list_[q])], &b = r_[static_cast<std::size_t>(list_[q + 1])];
      const V dx = x - V{a.x, b.x}, dy = y - V{a.y, b.y}, dz = z - V{a.z, b.z};
      const V d2 = dx * dx + dy * dy + dz * dz, inverse = 1 / d2;
      const V s6 = inverse * inverse * inverse;
      const V all = 48 * s6 * (s6 - 0.5) * inverse, f = d2 < melt_cutoff * melt_cutoff ? all : V{};
      fx += f * dx;
      fy += f * dy;
      fz += f * dz;
    }
    return {fx[0] + fx[1], fy[0] + fy[1], fz[0] + fz[1], 0};
  }
#endif

  Eigen::Index n_;
  std::vector<Eigen::Index> order_;
  std::vector<Vec4> r_, f_;
  std::vector<std::int32_t> image_, list_;
  std::vector<std::size_t> first_;
};
}  // namespace

std::unique_ptr<HandForce> hand_force(const Scene& scene, double skin) {
  return std::make_unique<RowForce>(scene, skin);
}

}  // namespace bench
