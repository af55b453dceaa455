// The paper's pipeline, for comparison: Algorithm 1 on Coal's collision points, at two rates as in the authors' nodes.
// Its methods differ only in the source of the normal, a NormalRule.
//
// collide() computes lines 2-5 at Options::collision_rate. step() computes lines 5-8 at the rate of the cycle, with the
// newest tool position. The delay between them is one collision period: at each collision instant k / collision_rate,
// step() posts the position of the tool and starts to use the answer to the request of the previous instant. In
// lockstep the result depends only on the path of the tool. In real time a late answer is used one instant later.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>

#include "palpate/collision/algorithm1.hpp"
#include "palpate/contact/contact.hpp"
#include "palpate/types/mailbox.hpp"

namespace palpate::collision {

/// Collision of the tool's sphere with one object, in the object's frame O.
struct Collision {
  const CollisionPoints& points;  ///< at least one collision point
  Vec3 p_OT;                      ///< centre of the sphere [m]
  double radius;                  ///< radius of the sphere [m]
};

/// Lines 3-5 of Algorithm 1 for one object. A rule may have a state. It is called at collision instants, outside of the
/// cycle.
class NormalRule {
 public:
  virtual ~NormalRule() = default;
  /// Called at an instant without collision. v_OT: velocity of the tool relative to the object, in O [m/s].
  virtual void free(const Vec3& v_OT) = 0;
  /// Returns the contact plane for a collision. A zero normal means that the rule cannot determine it: no force.
  virtual algorithm1::GrownPlane touch(const Collision& collision) = 0;
};

/// Contact method with a NormalRule per object; see the top of this file.
class CollisionMethod final : public contact::Method {
 public:
  /// Makes a new rule for one object.
  using MakeRule = std::unique_ptr<NormalRule> (*)();
  CollisionMethod(const contact::Options& options, MakeRule make_rule);

  void reset() noexcept override;
  const ContactSet& step(const scene::Snapshot& scene, const Vec3& p_WT, const Vec3& v_WT, double t) noexcept override;
  [[nodiscard]] bool asynchronous() const noexcept override { return true; }
  [[nodiscard]] bool stiff_along_axes() const noexcept override { return true; }
  void collide(const scene::Snapshot& scene) override;
  void check(const scene::Snapshot& scene) const override;

 private:
  /// Tool state posted by step() for collide().
  struct Request {
    std::array<Pose, kMaxContacts> X_WO;  ///< poses of the objects
    std::array<Vec3, kMaxContacts> v_OT;  ///< velocity of the tool relative to each object, in O [m/s]
    std::size_t objects = 0;
    Vec3 p_WT = Vec3::Zero();
    std::uint64_t number = 0;  ///< sequence number; 0: no request yet
    std::uint64_t epoch = 0;   ///< number of reset() calls: answers to requests from before a reset are discarded
  };
  /// Contact plane of one object.
  struct ContactPlane {
    int object = -1;               ///< index of the object in the snapshot
    std::uint64_t mesh = 0;        ///< id of the mesh; a plane is discarded when its object has left the scene
    algorithm1::GrownPlane plane;  ///< expressed in O, so that it moves with the object
  };
  /// Result of collide(): the first `size` planes are valid.
  struct Answer {
    std::array<ContactPlane, kMaxContacts> planes;
    int size = 0;
    std::uint64_t epoch = 0;
  };

  void post(const scene::Snapshot& scene, const Vec3& p_WT, const Vec3& v_WT, double t) noexcept;

  // Used by step().
  double rate_;
  double collision_index_ = -1.0;  // number of the present collision instant, counted from t = 0; negative: none yet
  Request request_;
  Answer current_answer_;
  ContactSet set_;
  Mailbox<Request> requests_;
  Mailbox<Answer> answers_;

  // Used by collide().
  double radius_;
  CoalSurface surface_;
  MakeRule make_rule_;
  std::map<std::pair<std::size_t, std::uint64_t>, std::unique_ptr<NormalRule>> rules_;  // by object index and mesh id
  std::uint64_t answered_ = 0, epoch_ = 0;
};

}  // namespace palpate::collision
