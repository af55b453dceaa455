// The paper's pipeline, for comparison: Algorithm 1 on Coal's collision points, at two rates as the authors' nodes had.
// Its methods differ in one thing, where the normal comes from: a Rule.
//
// collide() does lines 2-5 at Options::collision_rate, step() lines 5-8 at the rate of the cycle with the newest tool
// position. Between them lies one collision period: step() posts the tool's position at each collision instant
// k / collision_rate and shows from then on what was posted at the instant before. In lockstep this is a function of
// the path alone; in real time an answer that is late is shown an instant later.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>

#include "palpate/contact/algorithm1.hpp"
#include "palpate/contact/contact.hpp"
#include "palpate/types/mailbox.hpp"

namespace palpate::contact {

/// One collision of the tool's sphere with one object, in the object's frame O.
struct Collision {
  const CollisionPoints& points;  ///< one at least
  Vec3 p_OT;                      ///< the sphere's centre [m]
  double radius;                  ///< of the sphere [m]
};

/// Lines 3-5 for one object, with a memory of its own. Called at collision instants, outside of the cycle.
class Rule {
 public:
  virtual ~Rule() = default;
  /// The tool was free of the object, moving at v_OT [m/s].
  virtual void free(const Vec3& v_OT) = 0;
  /// Which way is out, and where would the sphere be free? A zero normal when the rule cannot tell: no force.
  virtual algorithm1::Plane touch(const Collision& collision) = 0;
};

class CollisionMethod final : public Method {
 public:
  using MakeRule = std::unique_ptr<Rule> (*)();
  CollisionMethod(const Options& options, MakeRule make_rule);

  void reset() noexcept override;
  const ContactSet& step(const scene::Snapshot& scene, const Vec3& p_WT, const Vec3& v_WT, double t) noexcept override;
  [[nodiscard]] bool asynchronous() const noexcept override { return true; }
  void collide(const scene::Snapshot& scene) override;
  void check(const scene::Snapshot& scene) const override;

 private:
  struct Request {
    Vec3 p_WT = Vec3::Zero(), v_WT = Vec3::Zero();
    double t = 0.0;            ///< objects are where they were then
    std::uint64_t number = 0;  ///< 0: nothing asked yet
    std::uint64_t epoch = 0;   ///< counts reset(): what was asked before it is not shown after it
  };
  struct Found {
    int object = -1;
    std::uint64_t mesh = 0;   ///< its id: an answer about a scene that was swapped away is not shown
    algorithm1::Plane plane;  ///< in O, so that it goes with an object that moves
  };
  struct Answer {
    std::array<Found, kMaxContacts> found;
    int size = 0;
    std::uint64_t epoch = 0;
  };

  // The cycle's side.
  double rate_;
  double instant_ = -1.0;  // collision instants since t = 0; below zero: none yet
  Request request_;
  Answer shown_;
  ContactSet set_;
  Mailbox<Request> requests_;
  Mailbox<Answer> answers_;

  // The side of collide().
  double radius_;
  CoalSurface surface_;
  MakeRule make_rule_;
  std::map<std::pair<std::size_t, std::uint64_t>, std::unique_ptr<Rule>> rules_;  // by object's index and mesh id
  std::uint64_t answered_ = 0, epoch_ = 0;
};

}  // namespace palpate::contact
