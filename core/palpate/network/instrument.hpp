// A simulated instrument at the site: a mass on a position servo that touches the objects of a scene.
#pragma once

#include <cstdint>
#include <random>

#include "palpate/contact/tool.hpp"
#include "palpate/network/site.hpp"
#include "palpate/scene/snapshot.hpp"

namespace palpate::network {

/// Options of the instrument.
struct InstrumentOptions {
  double mass = 0.2;        ///< [kg]
  double bandwidth = 30.0;  ///< natural frequency of its servo [Hz]
  double drive_cap = 3.0;   ///< largest force of its drives [N]
  double noise = 0.005;     ///< standard deviation of the measured force [N]
  double quantum = 1e-5;    ///< resolution of the measured position [m]
  int substeps = 4;         ///< per tick of the site
};

/// m x'' = F_drive + F_contact,   F_drive = cap(m w^2 (goal - x) + 2 m w (v_goal - v) - F_lagging)
///
/// F_lagging is the contact's force through a low-pass: the servo has no lasting error under load. Steps are
/// semi-implicit.
class Instrument {
 public:
  /// world: the objects as they really are. Throws std::invalid_argument naming an invalid option.
  Instrument(const InstrumentOptions& options, double radius, scene::Snapshot world, std::uint64_t seed);
  /// Puts the tool at a pose in W, at rest. Its orientation follows the goal at once.
  void place(const Pose& X) noexcept {
    goal_.X = X;
    x_ = X.p;
  }
  /// One tick of length dt with this goal, beginning at the time t of the scene [s].
  void step(const SiteGoal& goal, double t, double dt) noexcept;
  /// What the sensors report at the time t [s].
  [[nodiscard]] SiteInput measure(double t) noexcept;
  [[nodiscard]] const Vec3& x() const noexcept { return x_; }
  /// True force of the tissue at the last substep [N].
  [[nodiscard]] const Vec3& force() const noexcept { return F_; }
  /// Largest force of the tissue so far [N].
  [[nodiscard]] double largest() const noexcept { return largest_; }
  /// Work on the tissue since the start, by the trapezoidal rule over the substeps [J].
  [[nodiscard]] double work() const noexcept { return work_; }
  [[nodiscard]] scene::Snapshot& world() noexcept { return world_; }

 private:
  InstrumentOptions options_;
  scene::Snapshot world_;
  contact::Tool contact_;
  std::mt19937_64 random_;
  SiteGoal goal_;
  Vec3 x_ = Vec3::Zero(), v_ = Vec3::Zero(), F_ = Vec3::Zero(), lagging_ = Vec3::Zero();
  double largest_ = 0.0, work_ = 0.0;
};

}  // namespace palpate::network
