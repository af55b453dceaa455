// What the hand feels: from where handle and tool are to the wrench on the hand. It knows no arm, only their poses.
#pragma once

#include <array>
#include <string>

#include "palpate/contact/tool.hpp"
#include "palpate/force/force.hpp"
#include "palpate/guidance/guidance.hpp"
#include "palpate/loop/tick.hpp"
#include "palpate/mapping/mapping.hpp"
#include "palpate/scene/snapshot.hpp"
#include "palpate/stability/ledger.hpp"
#include "palpate/stability/stability.hpp"
#include "palpate/types/arms.hpp"

namespace palpate::loop {

struct HapticsOptions {
  double rate = 1000.0;          ///< [Hz]
  std::string method = "proxy";  ///< of contact
  contact::Options contact;
  mapping::Options mapping;
  guidance::Options guidance;
  force::Source source = force::Source::contact;
  stability::Options stability;
  Pose X_WL;  ///< leader base in the world
};

/// The operator's handle, however its pose is known.
struct Handle {
  double t = 0.0;              ///< stamp [s]
  bool good = false;           ///< finite, valid and fresh; otherwise what follows is the last that was
  Pose X_LH;                   ///< measured
  Twist V_LH;                  ///< of it
  double gripper = 0.0;        ///< pinch [rad]
  JointVector q;               ///< the device's measured joints, for its friction; may be empty
  bool takes_damping = false;  ///< HapticsOutput::B_H_L is felt as such
  double F_hand = -1.0;        ///< of the operator, where a load cell tells it; below zero: none does [N]
};

/// The tool, however its pose is known.
struct Instrument {
  double t = 0.0;                               ///< stamp [s]
  bool good = false;                            ///< as of Handle
  bool reached = true;                          ///< it could take the last goal
  Pose X_WT;                                    ///< measured
  double jaw = 0.0;                             ///< measured [rad]
  std::array<Vec3, contact::kMaxSpheres> p_WS;  ///< centres of its spheres, the first is the tip [m]
  Vec3 F_estimate_W = Vec3::Zero();  ///< of the environment on it, where the source of the force asks for it [N]
  const guidance::Joints* joints = nullptr;  ///< where they are known: hard fixtures keep to their limits
};

/// All that the haptics are told. The scene outlives the step.
struct HapticsInput {
  double t = 0.0;  ///< now [s]
  Handle handle;
  Instrument tool;
  Controls controls;
  const scene::Snapshot* scene = nullptr;
};

/// Throws std::invalid_argument naming what a console cannot say. Not for the cycle.
void check(const Controls& controls);

/// All that they answer.
struct HapticsOutput {
  mapping::Output mapped;                         ///< the tool's goal, corrected by hard fixtures
  Mat3 R_WT_asked = Mat3::Identity();             ///< the goal's attitude before they correct it
  guidance::Output guided;                        ///< what the fixtures add
  Mat3 B_H_L = Mat3::Zero();                      ///< of it, damping at the handle for a master that takes it [N s/m]
  Wrench F_B_L;                                   ///< what that damping wants the hand to be given
  const ContactSet* contacts = nullptr;  ///< what is touched
  force::ForceTerms force;                        ///< of it on the tool
  Wrench wanted;                                  ///< on the hand, F_B_L in it, before the stage `stability`
  stability::Output rendered;                     ///< on the hand, F_B_L in it
  Wrench beside;                                  ///< of it, what the master renders beside B_H_L
};

/// Its signals of a tick.
void record(const Handle& handle, Tick& tick) noexcept;

class Haptics {
 public:
  /// Throws std::invalid_argument naming an option that cannot be.
  explicit Haptics(const HapticsOptions& options);

  /// One tick: no allocation, no lock, no exception. The answer lives until the next step. `in` up to finish().
  const HapticsOutput& step(const HapticsInput& in) noexcept;
  /// What the device truly renders of `beside`, to be told after every step: books the energy, writes the tick's
  /// signals.
  void finish(const HapticsInput& in, const Wrench& beside, Tick& tick) noexcept;

  [[nodiscard]] const mapping::Mapping& mapping() const noexcept { return mapping_; }
  [[nodiscard]] bool stale(double now, double stamp) const noexcept { return stability_.stale(now, stamp); }
  /// From now on these fixtures; they outlive it, or the next ones.
  void take(const guidance::Fixtures& fixtures) noexcept { guidance_.take(fixtures); }
  [[nodiscard]] const guidance::Guidance& guidance() const noexcept { return guidance_; }
  /// Another motion scale: the map is caught anew.
  void rescale(double scale) noexcept { mapping_.rescale(scale); }
  /// Contact starts afresh from where the tool is.
  void forget_contacts() noexcept { contact_.reset(); }
  /// For whoever drives the loop: see contact::Method::collide.
  [[nodiscard]] contact::Tool& contact() noexcept { return contact_; }

 private:
  void guide(const HapticsInput& in) noexcept;
  [[nodiscard]] Wrench felt(const HapticsInput& in) const noexcept;
  void share_out(const Handle& handle) noexcept;
  [[nodiscard]] stability::Output stabilise(const HapticsInput& in) noexcept;
  stability::Energy book(const HapticsInput& in, const Wrench& F_H_L) noexcept;
  void record(const HapticsInput& in, Tick& tick) const noexcept;
  void record_guidance(Tick& tick) const noexcept;
  void record_touches(double stiffness_scale, Tick& tick) const noexcept;
  void record_stability(const HapticsInput& in, const Wrench& F_H_L, const stability::Energy& energy,
                        Tick& tick) const noexcept;

  HapticsOptions options_;
  mapping::Mapping mapping_;
  guidance::Guidance guidance_;
  contact::Tool contact_;
  stability::Stability stability_;
  stability::Ledger ledger_;
  HapticsOutput out_;
  Wrench F_B_L_;            ///< what the damping gives, once caps and passivity have taken their share
  Wrench felt_;             ///< of what the tool touches, in W: in the last tick
  double stiffness_ = 0.0;  ///< along it, on the tool's side; 0 when it is not known [N/m]
};

}  // namespace palpate::loop
