// Control laws: what the drives add to the force that is rendered. A new one is one file and one line in law.cpp.
#pragma once

#include <memory>
#include <string>

#include "palpate/types/spatial.hpp"

namespace palpate::torque {

/// Of all laws; each reads what concerns it.
struct LawOptions {
  bool shape_inertia = false;     ///< impedance: the handle weighs virtual_mass; needs a load cell
  double virtual_mass = 0.5;      ///< that the hand shall feel: admittance, and impedance with shape_inertia [kg]
  double virtual_damping = 2.0;   ///< the same, admittance [N s/m]
  double servo_bandwidth = 12.0;  ///< of the position loop inside admittance [Hz]
};

/// What a law is told at every tick; all in L.
struct LawInput {
  /// The arm's inertia at the handle: force over moment per acceleration of its place, its orientation kept [kg, kg m].
  Eigen::Matrix<double, 6, 3> Lambda = Eigen::Matrix<double, 6, 3>::Identity();
  Wrench Gamma_v;  ///< Coriolis and centripetal wrench at the handle; no moment for an arm that does not orient()
  Vec3 p_LH = Vec3::Zero();      ///< [m]
  Vec3 v_LH = Vec3::Zero();      ///< [m/s]
  Vec3 F_H_L = Vec3::Zero();     ///< to be rendered on the hand [N]
  Vec3 F_hand_L = Vec3::Zero();  ///< of the hand on the arm, measured; zero when unknown [N]
  Mat3 B_L = Mat3::Zero();       ///< damping by directions, for a law that takes it [N s/m]
};

/// What accelerates the handle by a [m/s^2] and leaves its orientation alone.
[[nodiscard]] inline Wrench inertia(const LawInput& in, const Vec3& a) noexcept {
  const Vec6 F = in.Lambda * a;
  return {F.head<3>(), F.tail<3>()};
}

class Law {
 public:
  virtual ~Law() = default;
  /// Wrench at the handle beside the one that is rendered: tau_force = J^T (F_H_L + this).
  virtual Wrench step(const LawInput& in) noexcept = 0;
  /// Forget: the arm was lost out of sight, or starts.
  virtual void reset() noexcept {}
  /// Must the hand's force be measured? Without it the law renders as `stiffness` does.
  [[nodiscard]] virtual bool needs_load_cell() const noexcept { return false; }
  /// Its virtual handle is damped by LawInput::B_L.
  [[nodiscard]] virtual bool takes_damping() const noexcept { return false; }
  /// What of the arm's own dynamics the hand feels beside the rendered force, at the handle's acceleration a [N].
  [[nodiscard]] virtual Vec3 neglected(const LawInput& in, const Vec3& a) const noexcept = 0;
};

/// name: stiffness, impedance or admittance. dt: period of the cycle [s]. Throws std::invalid_argument naming what
/// cannot be.
[[nodiscard]] std::unique_ptr<Law> make_law(const std::string& name, const LawOptions& options, double dt);

// The table's entries; each has a file of its own.
[[nodiscard]] std::unique_ptr<Law> make_stiffness(const LawOptions& options, double dt);
[[nodiscard]] std::unique_ptr<Law> make_impedance(const LawOptions& options, double dt);
[[nodiscard]] std::unique_ptr<Law> make_admittance(const LawOptions& options, double dt);

}  // namespace palpate::torque
