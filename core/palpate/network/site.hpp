// The follower's end: it plays the operator's motion, keeps force and energy within bounds, and learns the model.
#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "palpate/network/copies.hpp"
#include "palpate/network/estimator.hpp"
#include "palpate/network/modes.hpp"
#include "palpate/network/peer.hpp"
#include "palpate/network/playout.hpp"
#include "palpate/network/port.hpp"
#include "palpate/network/unknown.hpp"
#include "palpate/scene/snapshot.hpp"

namespace palpate::network {

/// Options of the follower's end.
struct SiteOptions : EndOptions {
  double force_cap = 3.0;      ///< largest force on the touched tissue [N]
  double speed = 0.5;          ///< largest speed of the tool's goal [m/s]
  double mass = 0.2;           ///< of the tool, for its kinetic energy [kg]
  double catch_up = 0.05;      ///< the same while the tool aligns with the operator's motion [m/s]
  double turn = 1.5;           ///< largest angular speed of the goal, and of the jaw [rad/s]
  double allowance = 1e-4;     ///< energy that the tool may spend before the hand has put in any [J]
  double capacity = 0.05;      ///< most energy that the account keeps [J]
  EstimatorOptions estimator;  ///< with the stiffness of each object as assumed one
};

/// State of the tool at a tick, in W.
struct SiteInput {
  double t = 0.0;         ///< own clock, which is also the time of the scene [s]
  Pose X;                 ///< measured pose of the tool
  Vec3 v = Vec3::Zero();  ///< measured velocity [m/s]
  double jaw = 0.0;       ///< [rad]
  Vec3 F = Vec3::Zero();  ///< measured force of the environment on the tool [N]
};

/// What the tool shall do.
struct SiteGoal {
  Pose X;                 ///< pose in W
  Vec3 v = Vec3::Zero();  ///< velocity [m/s]
  double jaw = 0.0;       ///< [rad]
  unsigned flags = 0;     ///< bits of Flag
};

/// The surface that is nearest to the tool, as estimated.
struct Near {
  double gap = std::numeric_limits<double>::infinity();  ///< from the tool's sphere to it [m]
  double unsure = 0.0;                                   ///< how much nearer it may be [m]
  Vec3 normal = Vec3::Zero();                            ///< outward, in W
  Vec3 v = Vec3::Zero();                                 ///< its velocity [m/s]
  double K = 0.0;                                        ///< stiffness that it may have [N/m]
};

/// The goal follows the played motion. In contact, with the measured force F and the step dx of the goal,
///
///   -F . dx <= account,     account = allowance + energy of the hand so far - work on the tissue
///
/// where the energy of the hand comes with each packet (the time-domain passivity approach of Ryu, Artigas and Preusche
/// 2010). A goal that was held back catches up as soon as it may, so that positions do not drift apart, and one that
/// has spent too much retreats until the tissue has given it back. The tool comes near to a surface no faster than its
/// kinetic energy is below the account, since drives with a limited force cannot stop a fast tool at the first touch.
/// Beyond kNear of the cap no step goes deeper, and beyond the cap the goal retreats. During an outage the goal rests.
class Site {
 public:
  /// scene: the objects as the operator's end also has them. Throws std::invalid_argument naming an invalid option.
  Site(const SiteOptions& options, scene::Snapshot scene);
  Site(const Site&) = delete;
  Site& operator=(const Site&) = delete;
  /// A packet that arrived at the own time `now` [s].
  void receive(const Datagram& d, double now) noexcept;
  /// The operator has left, or a new one comes: clock, motion and energies of the one before are forgotten, what was
  /// learnt is kept.
  void forget_operator() noexcept;
  /// The tool was moved by others: from the next tick on the goal rests where the tool is measured, until it has
  /// aligned with the operator's motion again.
  void rest() noexcept { started_ = false; }
  /// One tick, dt after the last one [s].
  const SiteGoal& step(const SiteInput& in, double dt) noexcept;
  /// The packet that leaves now.
  [[nodiscard]] Datagram send() const noexcept;

  [[nodiscard]] const Peer& peer() const noexcept { return peer_; }
  [[nodiscard]] const Playout& playout() const noexcept { return playout_; }
  /// Energy that the tool may still spend [J].
  [[nodiscard]] double account() const noexcept { return account_; }

 private:
  void book(const SiteInput& in) noexcept;
  void learn(const SiteInput& in) noexcept;
  void consider(std::size_t i, const SiteInput& in, Touch& touch) noexcept;
  void tell(std::size_t i, const SiteInput& in, Touch touch) noexcept;
  void follow(const SiteInput& in, double dt) noexcept;
  [[nodiscard]] Vec3 allowed(const Vec3& step, const SiteInput& in, double dt) noexcept;
  [[nodiscard]] double pending(const SiteInput& in, const Vec3& out, double left) const noexcept;
  [[nodiscard]] Vec3 slowed(const Vec3& step, double dt) const noexcept;

  SiteOptions options_;
  scene::Snapshot scene_;
  std::vector<Estimator> estimators_;
  std::vector<std::unique_ptr<Copies>> copies_;  ///< one for each estimator; null: a surface that deforms
  Peer peer_;
  Playout playout_;
  Played played_;
  SiteGoal goal_;
  SiteInput in_;
  Near near_;
  int nearest_ = -1;  ///< nearest object; -1: none
  int touched_ = -1;  ///< object that was touched last; -1: none
  Unknown unknown_;   ///< with planes: the last object of the scene
  double account_, hand_in_ = 0.0;
  Port port_;  ///< of the tool: out is work on the tissue
  bool started_ = false, aligning_ = true;
};

}  // namespace palpate::network
