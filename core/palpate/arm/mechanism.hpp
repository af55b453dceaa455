// Interface of a device: geometry and dynamics in its base frame. A new kind of arm is one file that implements it.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "palpate/arm/lane_dynamics.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::arm {

/// Equation of motion M a + bias = tau at one (q, v), and the tip with its Jacobian.
struct Dynamics {
  JointMatrix M;               ///< inertia, full and symmetric
  JointVector bias;            ///< C(q, v) v + G(q)
  JointVector G;               ///< gravity torque G(q)
  Pose X_0T;                   ///< base to tip
  Jacobian J;                  ///< as Arm::jacobian()
  Vec6 Jdot_v = Vec6::Zero();  ///< tip acceleration at zero joint acceleration, linear over angular
};

/// A line segment of a link, for drawing: from the link's origin to `end`, in the link's axes [m].
struct Segment {
  std::string link;
  Vec3 end = Vec3::Zero();
};

/// Constants of a device.
struct Facts {
  std::vector<std::string> joint_names, link_names;
  JointVector q_min, q_max;  ///< [rad, m]
  JointVector tau_max;       ///< drive limits [N m, N]
  JointVector v_max;         ///< speed limits [rad/s, m/s]
  bool orients = true;       ///< the orientation of the tip can be commanded, besides its position
  std::vector<Segment> segments;
};

/// Gravity, linear in each link's mass and first moment Pi = (m, m c_x, m c_y, m c_z, next link ..), c in the link's
/// axes (Eqs 10-12):  dP/dq = Y Pi,  P = P_row Pi.
struct GravityRegressor {
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxJoints, 4 * kMaxJoints> Y;  ///< (n, 4n)
  Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, 4 * kMaxJoints> P;          ///< (4n)
};

/// One device. Functions that are noexcept run in the cycle: they do not allocate.
class Mechanism {
 public:
  Mechanism() = default;
  virtual ~Mechanism() = default;
  Mechanism& operator=(const Mechanism&) = delete;
  [[nodiscard]] virtual std::unique_ptr<Mechanism> clone() const = 0;
  [[nodiscard]] virtual const Facts& facts() const noexcept = 0;

  /// The tip and its 6 x n Jacobian, linear over angular rows, in base axes.
  virtual void kinematics(const JointVector& q, Pose& X_0T, Jacobian& J) noexcept = 0;
  /// Kinematics and dynamics at (q, v).
  virtual void dynamics(const JointVector& q, const JointVector& v, Dynamics& d) noexcept = 0;
  /// The same for a plant that carries a body at its tip: in `work`, or in a place of the mechanism that the next call
  /// of any function overwrites.
  virtual const LaneDynamics& lane_dynamics(const JointVector& q, const JointVector& v, const TipBody& body,
                                            LaneDynamics& work) noexcept;
  /// Potential energy P(q) of the masses [J]; Dynamics::G is its gradient.
  [[nodiscard]] virtual double potential_energy(const JointVector& q) noexcept = 0;
  /// Gravity's acceleration in base axes [m/s^2].
  virtual void set_gravity(const Vec3& g_base) noexcept = 0;
  /// Multiplies mass and inertia of each moving link by a factor (n,).
  virtual void scale_masses(const JointVector& scale) = 0;
  /// X_0link of link_names[link] at the joints of the last kinematics() or dynamics().
  [[nodiscard]] virtual Pose link_pose(int link) const noexcept = 0;

  /// Y of M a + C v + G = Y pi (n, 10n), regressor.hpp; empty for a device that is not made of links. May allocate.
  [[nodiscard]] virtual Eigen::MatrixXd torque_regressor(const JointVector& /*q*/, const JointVector& /*v*/,
                                                         const JointVector& /*a*/) {
    return {};
  }
  /// pi (10n) of its links; empty if torque_regressor() is empty.
  [[nodiscard]] virtual Eigen::VectorXd inertial_parameters() const { return {}; }
  /// Replaces the parameters of the links, in the order of inertial_parameters().
  virtual void set_inertial_parameters(const Eigen::VectorXd& /*pi*/) {}

  // The default uses dynamics(); a device may override it by a faster method.
  virtual void inverse_dynamics(const JointVector& q, const JointVector& v, const JointVector& a, Dynamics& work,
                                JointVector& tau) noexcept;
  /// Y and P at q. A device that is not a chain of links leaves them empty.
  virtual void gravity_regressor(const JointVector& /*q*/, GravityRegressor& /*out*/) noexcept {}
  /// Pi according to the model file (4n); empty for a device without regressor.
  [[nodiscard]] virtual Eigen::VectorXd moments() const { return {}; }
  /// Joints for a position of the tip. False if the device has no closed form or the position is out of reach.
  virtual bool closed_form(const Vec3& /*p_0T*/, JointVector& /*q*/) const noexcept { return false; }

 protected:
  Mechanism(const Mechanism&) = default;
};

/// Parameters of a device by name, as given in its model file.
using Parameters = std::map<std::string, std::vector<double>>;

/// A device that is not described by a URDF, by the name of its kind (listed in devices.cpp). Throws std::runtime_error
/// naming the parameter, the required value and the given one.
[[nodiscard]] std::unique_ptr<Mechanism> make_mechanism(const std::string& kind, const Parameters& parameters);

}  // namespace palpate::arm
