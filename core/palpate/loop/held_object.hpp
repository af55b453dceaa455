// A rigid object that the jaws of several instruments can hold and hand over: a rod with round ends, such as a needle.
// Every loop runs the same law on what the others have published, so that all agree who carries the object.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "palpate/contact/capsules.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::loop {

/// The rod and its law. Jaws that stand on both sides of the rod and touch it hold it; it is then fixed to the tool. A
/// second pair of jaws may hold it as well; a spring between both grips is then felt by both hands.
struct RodOptions {
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();  ///< ends of the axis in the rod's frame O [m]
  double radius = 0.0;                      ///< [m]; 0: there is no rod
  Pose X_WO;                                ///< pose at the start
  double stiffness = 500.0;                 ///< of the spring between two grips [N/m]
  double hold = 3.0;                        ///< largest force of this spring; beyond it the rod slips in the jaws [N]
};

/// What a loop publishes about the rod.
struct Grip {
  bool holds = false;
  std::uint64_t since = 0;                      ///< order in which the grips closed
  std::uint64_t moved = 0;                      ///< order of X_WO: the newest is the pose of the rod
  Pose X_WO;                                    ///< pose of the rod: as it is carried, or as it was left
  Vec3 a_W = Vec3::Zero(), b_W = Vec3::Zero();  ///< ends of the rod as this grip holds them [m]
};

/// A jaw of the own instrument: its capsule in W and the side on which it moves.
struct Jaw {
  contact::Capsule capsule;
  int side = 0;  ///< 0 or 1
};

/// How the own instrument holds the rod.
enum class Holding : std::uint8_t { none, carries, holds_too };

/// The rod as one loop knows it.
class HeldObject {
 public:
  /// Throws std::invalid_argument naming an invalid value.
  explicit HeldObject(const RodOptions& options);

  /// One tick: opens or closes the own grip and moves the rod. `jaws` are those of the tool at X_WT, `others` the grips
  /// of the other instruments; `order` is a number larger than all before.
  void step(const Pose& X_WT, std::span<const Jaw> jaws, std::span<const Grip> others, std::uint64_t order) noexcept;
  /// Computes the force of the spring between the own grip and each other one. It acts at both ends of the rod, half of
  /// it at each, and is opposite for both tools bit by bit.
  void pull(std::span<const Grip> others) noexcept;
  [[nodiscard]] const Grip& grip() const noexcept { return own_; }
  [[nodiscard]] Holding holding() const noexcept { return holding_; }
  [[nodiscard]] const Pose& X_WO() const noexcept { return X_WO_; }
  /// Wrench of the other grips on the own tool, about the origin of W.
  [[nodiscard]] const Wrench& F_W() const noexcept { return F_W_; }
  /// Its stiffness [N/m]; zero without force.
  [[nodiscard]] double stiffness() const noexcept { return stiffness_; }

 private:
  [[nodiscard]] bool holds(std::span<const Jaw> jaws, const Pose& X_WO) const noexcept;

  RodOptions options_;
  Grip own_;
  Pose X_WO_, X_TO_;
  Pose slack_;  ///< pose of the carried rod in the frame of the grip, which goes to zero after the first grip opened
  Holding holding_ = Holding::none;
  Wrench F_W_;
  double stiffness_ = 0.0;
};

}  // namespace palpate::loop
