// An arm: a mechanism (serial or any other, see mechanism.hpp) with its counterbalance and its own workspace.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "palpate/arm/gravity_model.hpp"
#include "palpate/arm/mechanism.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::arm {

struct IkResult {
  bool converged = false;
  int iterations = 0;
  double position_error = 0.0;     ///< [m]
  double orientation_error = 0.0;  ///< [rad]
  double damping = 0.0;            ///< damping of the last step: large near singularities and for goals out of reach
  double step = 0.0;               ///< largest change of a joint in the last step; 0: there was none [rad, m]
};

struct IkOptions {
  int max_iterations = 20;
  double position_tolerance = 1e-8;     ///< [m]
  double orientation_tolerance = 1e-8;  ///< [rad]
  double damping = 1e-6;                ///< smallest damping; the damping grows with the remaining error
  double length = 0.1;  ///< position error that counts as much as one radian, where the goal is out of reach [m]
};

/// A spring that carries a link. Its potential is P = -torque sin(x) with x = along . q, so it loads the drives with
/// dP/dq = -torque cos(x) along. Because the torque has a potential, no closed motion can draw energy from it.
struct Counterbalance {
  double torque = 0.0;  ///< torque that the spring bears at x = 0 [N m]; 0 = no spring
  JointVector along;    ///< rotation of the link per rotation of each joint (n,) [rad/rad]
};

/// Kinematics and dynamics of one arm in its base frame. Functions that are noexcept may run in the cycle: they do not
/// allocate. A copy shares nothing with its original.
class Arm {
 public:
  explicit Arm(std::unique_ptr<Mechanism> mechanism);
  /// Throws std::runtime_error naming the file, the frame or joint, and the remedy.
  /// The arm is the chain from base to tip; other joints (jaws, drawn parallelograms) stay at zero.
  static Arm from_urdf(const std::string& xml, const std::string& base_frame, const std::string& tip_frame);

  Arm(const Arm& other);
  Arm& operator=(const Arm& other);
  Arm(Arm&&) noexcept = default;
  Arm& operator=(Arm&&) noexcept = default;
  ~Arm() = default;

  [[nodiscard]] int n() const noexcept { return static_cast<int>(facts().q_min.size()); }
  [[nodiscard]] const std::vector<std::string>& joint_names() const noexcept { return facts().joint_names; }
  [[nodiscard]] const JointVector& q_min() const noexcept { return facts().q_min; }
  [[nodiscard]] const JointVector& q_max() const noexcept { return facts().q_max; }
  [[nodiscard]] const JointVector& tau_max() const noexcept { return facts().tau_max; }  ///< drive limits [N m, N]
  [[nodiscard]] const JointVector& v_max() const noexcept { return facts().v_max; }      ///< speed limits [rad/s, m/s]
  /// True if the orientation of the tip can be commanded; otherwise only its position can.
  [[nodiscard]] bool orients() const noexcept { return facts().orients; }

  /// Kinematics at q, v: fills tip(), jacobian(), twist().
  void update(const JointVector& q, const JointVector& v) noexcept;
  /// Kinematics and dynamics at q, v in one pass: fills tip(), jacobian(), twist() and state().
  const Dynamics& dynamics(const JointVector& q, const JointVector& v) noexcept;
  /// The same for a plant with a body at its tip, in `work` or in a place of the arm that the next call of any function
  /// overwrites. It does not change tip(), jacobian(), twist() and state().
  const LaneDynamics& lane_dynamics(const JointVector& q, const JointVector& v, const TipBody& body,
                                    LaneDynamics& work) noexcept {
    return mechanism_->lane_dynamics(q, v, body, work);
  }
  [[nodiscard]] const Pose& tip() const noexcept { return state_.X_0T; }        ///< X_0T, base to tip
  [[nodiscard]] const Jacobian& jacobian() const noexcept { return state_.J; }  ///< at the tip, in base axes
  /// Result of the last dynamics(); update() and ik() change only its tip and Jacobian.
  [[nodiscard]] const Dynamics& state() const noexcept { return state_; }
  [[nodiscard]] Twist twist() const noexcept;  ///< J v
  /// X_0link of link_names()[link] at the joints of the last call that computed kinematics.
  [[nodiscard]] Pose link_pose(int link) const noexcept { return mechanism_->link_pose(link); }

  /// Gravity torque G(q) = dP/dq that balances the weight of the masses (Eq 10) [N m, N].
  [[nodiscard]] const JointVector& gravity(const JointVector& q) noexcept;
  /// Torque that holds the arm still: the identified gravity model if there is one, otherwise gravity(q) + elastic(q).
  [[nodiscard]] JointVector holding(const JointVector& q) noexcept;
  /// The same for a known G = gravity(q).
  [[nodiscard]] JointVector holding(const JointVector& q, const JointVector& G) noexcept;
  /// Torque of springs and cables: holding(q) - gravity(q).
  [[nodiscard]] JointVector elastic(const JointVector& q) noexcept;
  /// The same over all lanes, zero beyond the last joint, as q must be.
  void elastic(const JointVector& q, Lanes& tau) noexcept;
  /// tau = M a + C v + G.
  [[nodiscard]] const JointVector& inverse_dynamics(const JointVector& q, const JointVector& v,
                                                    const JointVector& a) noexcept;
  /// C(q,v) v + G(q).
  [[nodiscard]] const JointVector& bias(const JointVector& q, const JointVector& v) noexcept;
  /// Full symmetric M(q).
  [[nodiscard]] const JointMatrix& mass_matrix(const JointVector& q) noexcept;
  /// Potential energy P(q) of the masses; its gradient is gravity(q) (Eq 10) [J].
  [[nodiscard]] double potential_energy(const JointVector& q) noexcept { return mechanism_->potential_energy(q); }
  [[nodiscard]] double elastic_energy(
      const JointVector& q) noexcept;  ///< potential energy with the gradient elastic(q) [J]
  /// Throws std::runtime_error if a number is not finite or `along` does not have n entries.
  void set_counterbalance(const Counterbalance& spring);
  /// Regressor of gravity and its potential, linear in the links' first moments; empty for a device that has no links.
  [[nodiscard]] const GravityRegressor& gravity_regressor(const JointVector& q) noexcept;
  [[nodiscard]] Eigen::VectorXd moments() const {
    return mechanism_->moments();
  }  ///< Pi according to the model file (4n)
  /// Replaces masses and counterbalance in holding() by an identified model; the inertia stays that of the masses.
  /// Throws std::invalid_argument naming the term that does not fit.
  void set_gravity_model(GravityTerms terms, Eigen::VectorXd theta);
  /// Default (0, 0, -9.81).
  void set_gravity(const Vec3& g_base) noexcept { mechanism_->set_gravity(g_base); }
  /// A copy whose link masses are multiplied by `scale` (a controller's wrong model of the plant); spring and
  /// identified gravity stay.
  [[nodiscard]] Arm with_scaled_masses(const JointVector& scale) const;

  /// Y (n, 10n) of M a + C v + G = Y pi, with the ten parameters of each link in Pinocchio's order (regressor.hpp);
  /// empty for a device that is not made of links. Allocates.
  [[nodiscard]] Eigen::MatrixXd torque_regressor(const JointVector& q, const JointVector& v, const JointVector& a) {
    return mechanism_->torque_regressor(q, v, a);
  }
  [[nodiscard]] Eigen::VectorXd inertial_parameters() const { return mechanism_->inertial_parameters(); }  ///< pi (10n)
  /// A copy with other links, without counterbalance and identified gravity. Throws std::runtime_error naming the link
  /// whose mass or inertia is not physical.
  [[nodiscard]] Arm with_inertial_parameters(const Eigen::VectorXd& pi) const;

  /// Joints that bring the tip to the goal, within the joint limits: in closed form if the device has one, otherwise by
  /// damped Newton steps from q (in/out). A redundant arm stays near q. An arm that does not orient() ignores the
  /// goal's orientation.
  IkResult ik(const Pose& X_0T_goal, JointVector& q, const IkOptions& options = {}) noexcept;
  /// Derivative of the tip's pose with respect to a goal out of reach, where q, found by ik() with the same `length`,
  /// are the joints whose tip is nearest to the goal; both as (displacement, rotation vector) in base axes. Zero if the
  /// tip at q is not nearest. Changes tip() and jacobian() like update().
  [[nodiscard]] Mat6 nearest_derivative(const Pose& X_0T_goal, const JointVector& q, double length) noexcept;

  /// Poses of every link frame at q, in link_names() order; for drawing, not for the cycle.
  [[nodiscard]] std::vector<Pose> link_poses(const JointVector& q);
  [[nodiscard]] const std::vector<std::string>& link_names() const noexcept { return facts().link_names; }
  /// Line segments of the links, for drawing.
  [[nodiscard]] const std::vector<Segment>& segments() const noexcept { return facts().segments; }

 private:
  [[nodiscard]] const Facts& facts() const noexcept { return mechanism_->facts(); }

  std::unique_ptr<Mechanism> mechanism_;
  Counterbalance spring_;
  Lanes along_{};  ///< spring_.along
  std::optional<GravityModel> identified_;
  GravityRegressor regressor_;
  JointVector zero_, result_, v_;
  Dynamics state_, work_;  ///< at the joints of update() and dynamics(); scratch for the other queries
};

}  // namespace palpate::arm
