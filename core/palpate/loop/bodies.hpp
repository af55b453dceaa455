// Rigid bodies that the tools grasp, push and place, moved by a rigid-body engine beside the loops. Every tool has a
// virtual tool in the engine; a spring and a damper connect both. The engine moves the virtual tool by this coupling
// and by its own contacts, and the hand feels the coupling at every tick, whatever the engine's step.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "palpate/arm/arm.hpp"
#include "palpate/contact/tool.hpp"
#include "palpate/loop/realtime.hpp"
#include "palpate/scene/snapshot.hpp"
#include "palpate/types/mailbox.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::loop {

/// Maximum number of bodies that move, and of tools.
inline constexpr int kMaxBodies = 48;
inline constexpr int kMaxBodyTools = 4;
inline constexpr int kMaxBodyLinks = 2;  ///< of a tool, beside its jaws: shaft and wrist
/// Share of a new velocity of the tool in the filtered one [-], and the delay of this filter [ticks].
inline constexpr double kVelocityFilter = 0.3, kVelocityDelay = (1.0 - kVelocityFilter) / kVelocityFilter;

/// Time without a step of the engine after which the tools feel nothing of it: its thread hangs, or has ended [s].
inline constexpr double kEngineSilent = 0.05;

/// State of a free body inside the engine, as pointers to its arrays.
struct EngineBody {
  double* pose = nullptr;      ///< position [m] and quaternion w x y z, in W (7,)
  double* velocity = nullptr;  ///< linear in W [m/s], angular in the body's frame [rad/s] (6,)
  double* load = nullptr;      ///< force [N] and torque [N m] at the centre of mass, in W (6,)
  Vec3 com = Vec3::Zero();     ///< centre of mass in the body's frame [m]
};

/// A virtual link of an instrument inside the engine, its shaft for instance: a free body with the link's origin.
struct EngineLink {
  EngineBody body;
  int link = -1;             ///< link of the arm
  std::uint32_t joints = 0;  ///< bit j: joint j of the arm moves this link
  double share_w = 1.0;      ///< stiffness and damping against rotation, over those of a tool [-]
};

/// A virtual tool inside the engine: a free body with its origin at T, and a drive for each jaw. The engine damps it by
/// damping + period stiffness of the coupling, implicitly: this is the part of the coupling that depends on its
/// velocity, and the part of the spring that depends on its motion during the step. Shaft and wrist turn against the
/// tool, so each is a free body of its own, coupled to its link of the arm.
struct EngineTool {
  EngineBody body;
  std::vector<EngineLink> links;      ///< at most kMaxBodyLinks; none: shaft and wrist touch nothing
  std::array<double*, 2> jaw{};       ///< goals of the jaws' drives [rad]; null: no jaws
  std::array<double, 2> jaw_ratio{};  ///< goal per jaw angle [-]
  std::array<double*, 2> grip{};      ///< contact of each jaw with each body: found, force (3,) [N]
};

/// A body that moves.
struct MovingBody {
  EngineBody body;
  std::vector<contact::ToolSphere> spheres;  ///< with which it touches the objects of the scene; none: it does not
};

/// Numbers of the engine's state: positions, velocities or the guess of its solver.
struct EngineNumbers {
  double* at = nullptr;
  std::size_t size = 0;
};

/// The coupling and the engine.
struct BodiesOptions {
  void (*step)(const void* model, void* data) = nullptr;  ///< one step of the engine
  const void* model = nullptr;
  void* data = nullptr;
  std::shared_ptr<void> owner;       ///< keeps model, data and all arrays of the engine; null: the caller does
  std::vector<EngineNumbers> state;  ///< all that the engine takes from one step to the next
  double period = 0.001;             ///< of the engine [s]
  double stiffness = 300.0;          ///< of the coupling [N/m]
  double damping = 2.0;              ///< of the coupling [N s/m]
  double stiffness_w = 0.5;          ///< against rotation [N m/rad]
  double damping_w = 0.003;          ///< against rotation [N m s/rad]
  double force_max = 5.0;            ///< largest force of the coupling's spring; beyond it the tool yields [N]
  double release = 0.02;             ///< distance at which a stuck virtual tool is put back to its tool [m]
  Vec3 low = Vec3::Constant(-1.0), high = Vec3::Constant(1.0);  ///< the field: a body outside returns to its start [m]
  std::vector<EngineTool> tools;
  std::vector<MovingBody> bodies;
};

/// What the loop of a tool hands to the engine, of the tool and of its links.
struct ToolMotion {
  Pose X_WT;
  Twist V_WT;        ///< in W
  double jaw = 0.0;  ///< [rad]
  bool known = false;

  /// Takes a new pose, and its velocity by a filter. rate: inverse of the time since the last pose [Hz].
  void move(const Pose& X, double rate) noexcept;
};

/// What the engine hands to the loop of a tool.
struct VirtualTool {
  double t = 0.0;  ///< of the engine [s]
  Pose X_WV;
  Twist V_WV;      ///< in W
  int holds = -1;  ///< number of the body between both jaws; -1: none
  Pose X_WO;       ///< pose of this body
  bool known = false;
};

/// All bodies, for viewers, tasks and records.
struct BodyStates {
  double t = 0.0;                                        ///< of the engine [s]
  std::array<std::array<double, 7>, kMaxBodies> pose{};  ///< position [m] and quaternion w x y z, in W
  std::array<int, kMaxBodies> lost{};                    ///< how often each body left the field or had no finite state
  std::array<std::array<double, 2>, kMaxBodyTools * kMaxBodies> grip{};  ///< force of both jaws on each body [N]
  double delivered = 0.0;  ///< energy that the couplings gave to the engine [J]
  int restarts = 0;        ///< how often the state of the engine was not finite
};

/// Wrench of the coupling on the tool.
struct BodyContact {
  Wrench F_T_W;                  ///< about T, in W, with those of the links
  Vec3 F_held_W = Vec3::Zero();  ///< force of the tip's coupling alone [N]
  double stiffness = 0.0;        ///< [N/m]; 0 while the virtual tool is not known
  int holds = -1;
  Pose X_WO;
};

/// The wrench of the coupling on T, in W; on the virtual tool acts the opposite. share_w: factor of the stiffness and
/// the damping against rotation.
[[nodiscard]] Wrench coupling_wrench(const BodiesOptions& options, const ToolMotion& tool,
                                     const VirtualTool& virtual_tool, double share_w = 1.0) noexcept;

/// The wrench on the tip that does the same work as a wrench on a link, for every motion of the tip: tau = J_S' F_S at
/// the joints in the mask, and F_T = pinv(J_T)' tau. All in base axes; F_S about p_S.
[[nodiscard]] Wrench carried_to_tip(const arm::Arm& arm, const Vec3& p_S, std::uint32_t joints,
                                    const Wrench& F_S) noexcept;

/// The engine and its mailboxes. One thread steps the engine; each tool has a loop.
class Bodies {
 public:
  /// Throws std::invalid_argument naming an invalid value.
  Bodies(BodiesOptions options, std::shared_ptr<const scene::Snapshot> scene);
  ~Bodies() { stop(); }
  Bodies(const Bodies&) = delete;
  Bodies& operator=(const Bodies&) = delete;

  [[nodiscard]] const BodiesOptions& options() const noexcept { return options_; }
  /// Called by the loop of a tool; or another number: a link of one.
  void write(std::size_t tool, const ToolMotion& motion) noexcept { to_engine_[tool].write(motion); }
  [[nodiscard]] const VirtualTool& read(std::size_t tool) noexcept { return to_loop_[tool].read(); }

  /// Lockstep: advances the engine by dt [s], in whole steps.
  void advance(double dt) noexcept;
  /// Real time: the engine steps in a thread of its own.
  void start();
  void stop();
  [[nodiscard]] bool running() const noexcept { return thread_.running(); }
  /// Compute time of a step of the engine.
  [[nodiscard]] const Histogram& step_time() const noexcept { return step_time_; }
  /// The newest states; from any thread but the loop's and the engine's.
  [[nodiscard]] BodyStates states();
  /// Counts that a tool feels nothing since the engine stands still.
  void count_silence() noexcept { silences_.fetch_add(1, std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t silences() const noexcept { return silences_.load(std::memory_order_relaxed); }

 private:
  void step() noexcept;
  void drive(const EngineBody& body, std::size_t number, double share_w) noexcept;
  void press(std::size_t body) noexcept;
  void bring_back(std::size_t body) noexcept;
  [[nodiscard]] bool sound() const noexcept;
  void restart() noexcept;
  void publish() noexcept;
  [[nodiscard]] VirtualTool seen(const EngineBody& body, std::size_t number) const noexcept;

  BodiesOptions options_;
  std::shared_ptr<const scene::Snapshot> scene_;
  std::vector<std::unique_ptr<contact::Tool>> touch_;  ///< of each body; null: it touches no object
  std::vector<std::array<double, 7>> start_;           ///< pose of each body at the start
  std::vector<std::vector<double>> first_;             ///< state of the engine at the start
  static constexpr std::size_t kCoupled = (1 + kMaxBodyLinks) * kMaxBodyTools;  ///< the tools, and their links
  std::array<Mailbox<ToolMotion>, kCoupled> to_engine_;
  std::array<Mailbox<VirtualTool>, kCoupled> to_loop_;
  std::array<bool, kCoupled> placed_{};
  Mailbox<BodyStates> shown_;
  BodyStates states_;
  double due_ = 0.0;  ///< time that the engine has to catch up [s]
  std::mutex readers_;
  std::atomic<std::uint64_t> silences_{0};
  RealTimeThread thread_;
  Histogram step_time_;
};

/// The tool of one loop among the bodies.
class BodyPort {
 public:
  /// Throws std::invalid_argument naming an invalid value.
  BodyPort(std::shared_ptr<Bodies> bodies, int tool, const arm::Arm& arm);
  /// Hands the measured tool to the engine, after a tick. rate: inverse of the time since the last tick [Hz]. arm: the
  /// arm of the tool at its joints, with its base at X_WA.
  void publish(const Pose& X_WT, double jaw, double rate, const arm::Arm& arm, const Pose& X_WA) noexcept;
  /// The coupling's wrench on the tool as published, with those of its links; none while the engine is silent. arm: as
  /// published.
  [[nodiscard]] const BodyContact& step(const arm::Arm& arm) noexcept;

 private:
  [[nodiscard]] const EngineTool& tool() const noexcept { return bodies_->options().tools[tool_]; }
  void add_link(std::size_t number, const arm::Arm& arm) noexcept;

  std::shared_ptr<Bodies> bodies_;
  std::size_t tool_;
  ToolMotion motion_;
  std::array<ToolMotion, kMaxBodyLinks> links_;
  Pose X_WA_;
  BodyContact out_;
  bool quiet_ = false;                 // the engine is silent
  double heard_ = 0.0, silent_ = 0.0;  // newest time of the engine, and time of this loop since it was new [s]
};

}  // namespace palpate::loop
