#include "bullet.hpp"

#ifdef BENCH_HAS_BULLET
#include <btBulletDynamicsCommon.h>

#include <vector>
#endif

namespace bench {

#ifdef BENCH_HAS_BULLET
namespace {
Eigen::Vector3d place_of(const btRigidBody& body) {
  const btVector3& x = body.getWorldTransform().getOrigin();
  return {x.x(), x.y(), x.z()};
}
}  // namespace

struct BulletHeaps::World {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  btStaticPlaneShape floor{btVector3(0, 0, 1), 0};
  btSphereShape sphere{0.5};
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  Eigen::Index stirred;
  Shake shake;
  int done = 0;

  World(const Eigen::Matrix3Xd& centres, bool may_sleep, Eigen::Index how_many, Shake how)
      : stirred{how_many}, shake{std::move(how)} {
    world.setGravity(btVector3(0, 0, -1));
    world.setForceUpdateAllAabbs(false);  // not of sleepers
    const btScalar mass = 1;
    btVector3 inertia;
    sphere.calculateLocalInertia(mass, inertia);
    add({0, btVector3(0, 0, 0), &floor, btVector3(0, 0, 0)});
    for (const auto& x : centres.colwise()) {
      const btVector3 at(static_cast<btScalar>(x[0]), static_cast<btScalar>(x[1]), static_cast<btScalar>(x[2]));
      add({mass, at, &sphere, inertia});
      bodies.back()->setActivationState(may_sleep ? ACTIVE_TAG : DISABLE_DEACTIVATION);
    }
  }
  ~World() {
    for (auto& body : bodies) world.removeRigidBody(body.get());
  }

  struct One {
    btScalar mass;
    btVector3 at;
    btCollisionShape* shape;
    btVector3 inertia;
  };
  void add(const One& one) {
    btRigidBody::btRigidBodyConstructionInfo info(one.mass, nullptr, one.shape, one.inertia);
    info.m_startWorldTransform = btTransform(btQuaternion::getIdentity(), one.at);
    info.m_friction = btScalar(0.7071);  // that of two is the product
    info.m_rollingFriction = info.m_spinningFriction = btScalar(0.05);
    info.m_restitution = btScalar(0.5477);
    // Its defaults, 0.8 m/s, 1 rad/s, for a metre and g = 9.81 m/s².
    info.m_linearSleepingThreshold = btScalar(0.26), info.m_angularSleepingThreshold = btScalar(0.32);
    bodies.push_back(std::make_unique<btRigidBody>(info));
    world.addRigidBody(bodies.back().get());
  }
};

bool BulletHeaps::is_here() { return true; }
BulletHeaps::BulletHeaps(const Eigen::Matrix3Xd& centres, bool may_sleep, Eigen::Index stirred, Shake shake)
    : world_{std::make_unique<World>(centres, may_sleep, stirred, std::move(shake))} {}
void BulletHeaps::steps(int count) {
  World& w = *world_;
  for (int k = 0; k < count; ++k, ++w.done) {
    for (Eigen::Index i = 1; i <= w.stirred; ++i) {
      btRigidBody& body = *w.bodies[static_cast<std::size_t>(i)];
      const Eigen::Vector3d f = w.shake(w.done * dt, place_of(body));
      if (f.isZero()) continue;
      body.activate();
      body.applyCentralForce(
          btVector3(static_cast<btScalar>(f[0]), static_cast<btScalar>(f[1]), static_cast<btScalar>(f[2])));
    }
    w.world.stepSimulation(btScalar(dt), 0);
  }
}
double BulletHeaps::awake() const {
  double count = 0;
  for (std::size_t i = 1; i < world_->bodies.size(); ++i) count += world_->bodies[i]->isActive();
  return count / static_cast<double>(world_->bodies.size() - 1);
}
double BulletHeaps::mean_height() const {
  double sum = 0;
  for (std::size_t i = 1; i < world_->bodies.size(); ++i) sum += place_of(*world_->bodies[i])[2];
  return sum / static_cast<double>(world_->bodies.size() - 1);
}
#else
struct BulletHeaps::World {};
bool BulletHeaps::is_here() { return false; }
BulletHeaps::BulletHeaps(const Eigen::Matrix3Xd&, bool, Eigen::Index, Shake) {}
void BulletHeaps::steps(int) {}
double BulletHeaps::awake() const { return 0; }
double BulletHeaps::mean_height() const { return 0; }
#endif
BulletHeaps::~BulletHeaps() = default;

}  // namespace bench
