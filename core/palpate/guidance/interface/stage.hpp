// What a loop knows of the stage `guidance`: fixtures make the stage that renders them. Without fixtures a loop has no
// stage, and the libraries of the core alone suffice.
#pragma once

#include <memory>
#include <utility>

#include "palpate/guidance/interface/options.hpp"
#include "palpate/scene/frame.hpp"
#include "palpate/types/damped_wrench.hpp"
#include "palpate/types/motion.hpp"

namespace palpate::guidance {

/// Input of the stage at every tick, in W.
struct Input {
  double t = 0.0;        ///< time of the tick [s]
  ToolGoal goal;         ///< commanded goal from the mapping; while it is not engaged, the hand feels no fixture
  ToolState tool;        ///< measured state of the tool
  ToolForce tool_force;  ///< contact force on the tool
  Handle handle;         ///< used: the operator's force, and whether the device renders damping
  double pedal = 1.0;    ///< guidance pedal, 0-1
};

/// Energies of all fixtures [J].
struct FixtureEnergy {
  double potential = 0.0;  ///< stored by the fixtures that act, at full authority
  double present = 0.0;    ///< stored by them at their present authority
  double credit = 0.0;     ///< stored by those whose authority rose without motion of the hand, by that rise
};

/// Output of the stage, in W.
struct Output {
  Pose X_WT_goal;                  ///< corrected goal; exactly the mapped goal if no hard fixture corrects it
  Mat6 J_goal = Mat6::Identity();  ///< derivative of the corrected with respect to the mapped goal: maps the twist that
                                   ///< the hand gives the tool, and by its transpose the wrench on the tool
  DampedWrench on_tool;            ///< wrench of the fixtures at the mapped goal; its B is zero unless the device
                                   ///< renders damping
  int strongest = -1;              ///< index of the fixture with the largest wrench; -1: no fixture exerts one
  double gap = 0.0;                ///< gap of that fixture, or without force the smallest gap [m, rad]
  Vec3 correction = Vec3::Zero();  ///< corrected minus mapped position of the goal [m]
  FixtureEnergy energy;            ///< energies of the fixtures
  unsigned status = 0;             ///< bits of Status
};

class FixtureList;

/// The stage with the state of all fixtures, as a loop calls it.
class Stage {
 public:
  Stage() = default;
  virtual ~Stage() = default;
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  /// Replaces the fixtures from the next step on; `fixtures` must outlive their use. A fixture keeps the state of the
  /// previous one with the same name.
  virtual void take(const FixtureList& fixtures) noexcept = 0;
  /// One tick, without allocation, lock or exception. The result is valid until the next step.
  virtual const Output& step(const Input& in) noexcept = 0;
  /// Summed stiffness of all active fixtures along the direction of the force F_T_W [N/m].
  [[nodiscard]] virtual double stiffness_along(const Vec3& F_T_W) const noexcept = 0;
};

struct Fixtures;

/// Fixtures as a loop takes them: immutable, and replaced as a whole. This base class has none.
class FixtureList {
 public:
  explicit FixtureList(std::shared_ptr<scene::LiveFrame> tool_frame = nullptr) : tool(std::move(tool_frame)) {}
  virtual ~FixtureList() = default;

  /// The fixtures; null if there are none.
  [[nodiscard]] virtual const Fixtures* fixtures() const noexcept { return nullptr; }
  /// A new stage for a loop with the period dt [s]; null if there are no fixtures.
  [[nodiscard]] virtual std::unique_ptr<Stage> make_stage(const Options& /*options*/, double /*dt*/) const {
    return nullptr;
  }
  /// Throws std::invalid_argument naming the fixture, the value and the remedy.
  virtual void check() const {}

  /// Receives the tool's pose at every tick, for geometries attached to the tool; may be null.
  std::shared_ptr<scene::LiveFrame> tool;

 protected:
  FixtureList(const FixtureList&) = default;
  FixtureList(FixtureList&&) = default;
  FixtureList& operator=(const FixtureList&) = default;
  FixtureList& operator=(FixtureList&&) = default;
};

/// Fixtures with the stage of a loop that renders them; without a stage before the loop's first fixture.
struct ActiveFixtures {
  std::shared_ptr<const FixtureList> fixtures;
  std::shared_ptr<Stage> stage;
};

}  // namespace palpate::guidance
