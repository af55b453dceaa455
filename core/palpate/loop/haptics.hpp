// What the hand feels: from where handle and tool are to the wrench on the hand. It knows no arm, only their poses.
#pragma once

#include <array>
#include <string>

#include "palpate/contact/tool.hpp"
#include "palpate/force/force.hpp"
#include "palpate/guidance/guidance.hpp"
#include "palpate/loop/stage_clock.hpp"
#include "palpate/loop/tick.hpp"
#include "palpate/mapping/mapping.hpp"
#include "palpate/scene/snapshot.hpp"
#include "palpate/stability/ledger.hpp"
#include "palpate/stability/stability.hpp"
#include "palpate/types/arms.hpp"
#include "palpate/types/damped_wrench.hpp"
#include "palpate/types/motion.hpp"

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

/// The tool with its spheres.
struct Instrument : ToolState {
  std::array<Vec3, contact::kMaxSpheres> p_WS;  ///< centres of its spheres in W, the first is the tip [m]
};

/// Input of the haptics. The scene outlives the step.
struct HapticsInput {
  double t = 0.0;  ///< now [s]
  Handle handle;
  Instrument tool;
  Controls controls;
  const scene::Snapshot* scene = nullptr;
};

/// Output of the haptics.
struct HapticsOutput {
  ToolGoal mapped;                       ///< the tool's goal, corrected by hard fixtures
  Mat3 R_WT_asked = Mat3::Identity();    ///< the goal's attitude before the correction
  guidance::Output guided;               ///< what the fixtures add
  const ContactSet* contacts = nullptr;  ///< what is touched
  force::ForceTerms force;               ///< of the contacts on the tool
  DampedWrench wanted;                   ///< on the hand, before the stage `stability`
  stability::Output rendered;            ///< on the hand
};

/// Writes the handle's signals of a tick.
void record(const Handle& handle, Tick& tick) noexcept;

class Haptics {
 public:
  /// Throws std::invalid_argument naming an option that cannot be.
  explicit Haptics(const HapticsOptions& options);

  /// One tick: no allocation, no lock, no exception. The answer lives until the next step. `in` up to finish().
  const HapticsOutput& step(const HapticsInput& in) noexcept;
  /// To be called after every step. F: the part of rendered.on_hand.F that the device really renders; the damping of
  /// on_hand adds to it. Books the energy and writes the tick's signals.
  void finish(const HapticsInput& in, const Wrench& F, Tick& tick) noexcept;

  [[nodiscard]] const mapping::Mapping& mapping() const noexcept { return mapping_; }
  [[nodiscard]] bool stale(double now, double stamp) const noexcept { return stability_.stale(now, stamp); }
  /// From now on these fixtures; they outlive it, or the next ones.
  void take(const guidance::Fixtures& fixtures) noexcept { guidance_.take(fixtures); }
  [[nodiscard]] const guidance::Guidance& guidance() const noexcept { return guidance_; }
  /// Another motion scale: the map is caught anew.
  void rescale(double scale) noexcept { mapping_.rescale(scale); }
  /// Contact starts afresh from where the tool is.
  void forget_contacts() noexcept { contact_.reset(); }
  /// Times the stages from now on; the clock outlives the haptics. None: nothing is timed.
  void watch(StageClock* clock) noexcept { clock_ = clock; }
  /// For whoever drives the loop: see contact::Method::collide.
  [[nodiscard]] contact::Tool& contact() noexcept { return contact_; }

 private:
  void mark(Stage stage) noexcept {
    if (clock_ != nullptr) clock_->mark(stage);
  }
  void guide(const HapticsInput& in) noexcept;
  [[nodiscard]] Touch felt(const HapticsInput& in) const noexcept;
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
  StageClock* clock_ = nullptr;
  HapticsOutput out_;
  Touch touch_;  ///< what the tool touched in the last tick
};

}  // namespace palpate::loop
