/// @file
/// The heaps of row `skipping` in Bullet, a rigid-body engine of games: contacts are impulses, found by iterations, at steps
/// that are some 25 times as long as those of contacts with springs.
#pragma once

#include <Eigen/Core>

#include <functional>
#include <memory>

namespace bench {

/// Shakes a body: its force by time and place. [force]
using Shake = std::function<Eigen::Vector3d(double, const Eigen::Vector3d&)>;

/// Spheres of diameter and mass 1 on a floor, g = 1.
class BulletHeaps {
 public:
  static constexpr double dt = 0.05;  ///< as 1/60 s is for a metre and g = 9.81 m/s²
  static bool is_here();              ///< compiled with Bullet

  /// @param stirred  so many, the first, are shaken
  BulletHeaps(const Eigen::Matrix3Xd& centres, bool may_sleep, Eigen::Index stirred, Shake shake);
  ~BulletHeaps();
  BulletHeaps(const BulletHeaps&) = delete;
  BulletHeaps& operator=(const BulletHeaps&) = delete;
  void steps(int count);
  [[nodiscard]] double awake() const;        ///< share of the bodies
  [[nodiscard]] double mean_height() const;  ///< [length]

 private:
  struct World;
  std::unique_ptr<World> world_;
};

}  // namespace bench
