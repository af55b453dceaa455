// The haptic cycle: states in, torques out. The only file that sees every stage.
#pragma once

#include <array>
#include <string>

#include "palpate/arm/arm.hpp"
#include "palpate/contact/tool.hpp"
#include "palpate/force/estimate.hpp"
#include "palpate/force/force.hpp"
#include "palpate/loop/tick.hpp"
#include "palpate/mapping/mapping.hpp"
#include "palpate/scene/snapshot.hpp"
#include "palpate/stability/ledger.hpp"
#include "palpate/stability/stability.hpp"
#include "palpate/torque/torque.hpp"
#include "palpate/types/arms.hpp"

namespace palpate::loop {

struct CycleOptions {
  double rate = 1000.0;          ///< [Hz]
  std::string method = "proxy";  ///< of contact
  contact::Options contact;
  mapping::Options mapping;
  force::Source source = force::Source::contact;
  force::EstimateOptions estimate;  ///< of the force, where the source asks for it
  stability::Options stability;
  torque::Options torque;
  Pose X_WL;  ///< leader base in the world
  Pose X_WB;  ///< follower base in the world
};

/// All that a cycle is told. The scene outlives the step.
struct CycleInput {
  double t = 0.0;  ///< now [s]
  LeaderState leader;
  FollowerState follower;
  Controls controls;
  const scene::Snapshot* scene = nullptr;
};

/// All that a cycle answers.
struct CycleOutput {
  Tick tick{};
  LeaderCommand leader;
  FollowerCommand follower;
};

class Cycle {
 public:
  /// leader: the controller's model, which may differ from the arm itself. Throws std::invalid_argument naming an
  /// option that cannot be.
  Cycle(const CycleOptions& options, arm::Arm leader, arm::Arm follower);

  /// One cycle: no allocation, no lock, no exception, whatever the input. The answer lives until the next step.
  CycleOutput& step(const CycleInput& in) noexcept;

  [[nodiscard]] const mapping::Mapping& mapping() const noexcept { return mapping_; }
  /// Another scene: contact starts afresh from where the tool is.
  void forget_contacts() noexcept { contact_.reset(); }
  /// For whoever drives the cycle: see contact::Method::collide.
  [[nodiscard]] contact::Tool& contact() noexcept { return contact_; }

 private:
  bool trust(const CycleInput& in) noexcept;
  void hold_up() noexcept;
  void locate() noexcept;
  bool reach(const Pose& X_WT_goal, double jaw) noexcept;
  Wrench felt(const force::ForceTerms& force) noexcept;
  stability::Output stabilise(const Wrench& wanted, bool engaged, const Vec3& F_T_W,
                              const contact::ContactSet& contacts, const CycleInput& in) noexcept;
  void book(const stability::Output& rendered, const Wrench& wanted, const contact::ContactSet& contacts,
            const force::ForceTerms& force, const CycleInput& in) noexcept;
  void record_stability(const stability::Output& rendered, const stability::Energy& energy) noexcept;
  void record(const mapping::Output& mapped, const contact::ContactSet& contacts, const force::ForceTerms& force,
              double stiffness_scale) noexcept;
  void record_touches(const contact::ContactSet& contacts, double stiffness_scale) noexcept;
  void record_leader() noexcept;

  CycleOptions options_;
  arm::Arm leader_, follower_;
  contact::Tool contact_;
  mapping::Mapping mapping_;
  std::unique_ptr<force::Estimate> estimate_;  ///< none when the source does not ask for it
  stability::Stability stability_;
  stability::Ledger ledger_;
  torque::Torque torque_;

  // The last states worth trusting.
  LeaderState leader_state_;
  FollowerState follower_state_;
  JointVector zero_;    ///< follower joint velocities: not needed, not measured
  JointVector q_step_;  ///< most that the follower's joints may turn in a cycle [rad, m]
  bool leader_known_ = false, follower_known_ = false, leader_good_ = false, follower_good_ = false;
  bool reached_ = true;
  Pose X_LH_, X_WT_;
  Twist V_LH_;
  std::array<Vec3, contact::kMaxSpheres> p_WS_;  ///< centres of the tool's spheres, the first is the tip
  CycleOutput out_;
};

}  // namespace palpate::loop
