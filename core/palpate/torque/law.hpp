// Control laws: the wrench that the drives add to the rendered force. A new law needs one file and one line in law.cpp.
#pragma once

#include <memory>
#include <string>

#include "palpate/types/spatial.hpp"

namespace palpate::torque {

/// Options of all control laws. Each law reads its own options only.
struct ControlLawOptions {
  bool shape_inertia = false;     ///< impedance: the handle feels like virtual_mass; needs a load cell
  double virtual_mass = 0.5;      ///< felt mass, for admittance, and for impedance with shape_inertia [kg]
  double virtual_damping = 2.0;   ///< felt damping, for admittance [N s/m]
  double servo_bandwidth = 12.0;  ///< bandwidth of the position loop of admittance [Hz]
};

/// Input of a control law at every tick. All quantities are expressed in L.
struct ControlLawInput {
  /// Inertia of the arm at the handle: rows of force over rows of moment per linear acceleration of the handle, with
  /// constant orientation [kg, kg m].
  Eigen::Matrix<double, 6, 3> Lambda = Eigen::Matrix<double, 6, 3>::Identity();
  Wrench Gamma_v;  ///< Coriolis and centripetal wrench at the handle; the moment is zero unless the arm orients()
  Vec3 p_LH = Vec3::Zero();      ///< position of the handle [m]
  Vec3 v_LH = Vec3::Zero();      ///< velocity of the handle [m/s]
  Vec3 F_H_L = Vec3::Zero();     ///< force to render on the hand [N]
  Vec3 F_hand_L = Vec3::Zero();  ///< measured force of the hand on the arm; zero when unknown [N]
  Mat3 B_L = Mat3::Zero();       ///< damping matrix to render, for laws that take damping [N s/m]
};

/// Wrench that accelerates the handle by a [m/s^2] without changing its orientation [N, N m].
[[nodiscard]] inline Wrench inertia(const ControlLawInput& in, const Vec3& a) noexcept {
  const Vec6 F = in.Lambda * a;
  return {F.head<3>(), F.tail<3>()};
}

/// Interface of a control law.
class ControlLaw {
 public:
  virtual ~ControlLaw() = default;
  /// Wrench at the handle that the law adds to the rendered wrench [N, N m]: tau_force = J^T (F_H_L + result).
  virtual Wrench step(const ControlLawInput& in) noexcept = 0;
  /// Discards the state of the law: at start-up, and when the leader state becomes stale.
  virtual void reset() noexcept {}
  /// True if the law needs the measured force of the hand. Without a load cell, the torque stage renders as with
  /// `stiffness`.
  [[nodiscard]] virtual bool needs_load_cell() const noexcept { return false; }
  /// True if the law itself renders the damping ControlLawInput::B_L.
  [[nodiscard]] virtual bool renders_damping() const noexcept { return false; }
  /// True if the hand does not feel the arm's friction, or not all of it: no energy that friction takes may then be
  /// counted as taken from the hand.
  [[nodiscard]] virtual bool removes_friction() const noexcept { return false; }
  /// Force of the arm's own dynamics in L [N] that the hand feels in addition to the rendered force, at the
  /// acceleration a of the handle [m/s^2].
  [[nodiscard]] virtual Vec3 neglected_force(const ControlLawInput& in, const Vec3& a) const noexcept = 0;
};

/// Makes the control law `name`: stiffness, impedance or admittance. dt: period of the cycle [s]. Throws
/// std::invalid_argument with the name of an invalid option or of an unknown law.
[[nodiscard]] std::unique_ptr<ControlLaw> make_control_law(const std::string& name, const ControlLawOptions& options,
                                                           double dt);

// The control laws in the table of law.cpp. Each has its own file.
[[nodiscard]] std::unique_ptr<ControlLaw> make_stiffness(const ControlLawOptions& options, double dt);
[[nodiscard]] std::unique_ptr<ControlLaw> make_impedance(const ControlLawOptions& options, double dt);
[[nodiscard]] std::unique_ptr<ControlLaw> make_admittance(const ControlLawOptions& options, double dt);

}  // namespace palpate::torque
