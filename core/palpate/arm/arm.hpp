// An arm: a mechanism (serial or any other, mechanism.hpp) with its counterbalance and a workspace of its own.
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
  double damping = 0.0;            ///< of the last step: large near singularities and for goals out of reach
};

struct IkOptions {
  int max_iterations = 20;
  double position_tolerance = 1e-8;     ///< [m]
  double orientation_tolerance = 1e-8;  ///< [rad]
  double damping = 1e-6;                ///< floor of the damping, which grows with the error that remains
};

/// A spring that carries a link: P = -torque sin(x), x = along . q, so it puts  dP/dq = -torque cos(x) along  on the
/// drives. Of a potential, so that no motion round and round can draw energy from it.
struct Counterbalance {
  double torque = 0.0;  ///< what it takes off at x = 0 [N m]; 0 = there is none
  JointVector along;    ///< how far the link turns per joint (n,) [rad/rad]
};

/// Kinematics and dynamics of one arm in its base frame. Everything that is noexcept may run in the cycle: no
/// allocation after construction. A copy shares nothing.
class Arm {
 public:
  explicit Arm(std::unique_ptr<Mechanism> mechanism);
  /// Throws std::runtime_error naming the file, the frame or joint, and the mend.
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
  /// Can its tip be turned at will? Otherwise it is placed only, and its orientation comes as it comes.
  [[nodiscard]] bool orients() const noexcept { return facts().orients; }

  /// Kinematics at q, v: fills tip(), jacobian(), twist().
  void update(const JointVector& q, const JointVector& v) noexcept;
  /// Kinematics and dynamics at q, v in one pass: fills tip(), jacobian(), twist() and state().
  const Dynamics& dynamics(const JointVector& q, const JointVector& v) noexcept;
  /// The same for a plant. It leaves tip(), jacobian(), twist() and state() as they are.
  void lane_dynamics(const JointVector& q, const JointVector& v, LaneDynamics& d) noexcept {
    mechanism_->lane_dynamics(q, v, d);
  }
  [[nodiscard]] const Pose& tip() const noexcept { return state_.X_0T; }        ///< X_0T, base to tip
  [[nodiscard]] const Jacobian& jacobian() const noexcept { return state_.J; }  ///< at the tip, in base axes
  /// Result of the last dynamics(); update() and ik() move its tip and Jacobian alone.
  [[nodiscard]] const Dynamics& state() const noexcept { return state_; }
  [[nodiscard]] Twist twist() const noexcept;  ///< J v
  /// X_0link of link_names()[link] at the joints of the last call that computed kinematics.
  [[nodiscard]] Pose link_pose(int link) const noexcept { return mechanism_->link_pose(link); }

  /// Gravity torque G(q) = dP/dq that holds the masses up (Eq 10); gravity vector in the base frame.
  [[nodiscard]] const JointVector& gravity(const JointVector& q) noexcept;
  /// What holds the arm still: the identified model where there is one, else gravity(q) and the counterbalance.
  [[nodiscard]] JointVector holding(const JointVector& q) noexcept;
  /// The same where G = gravity(q) is known already.
  [[nodiscard]] JointVector holding(const JointVector& q, const JointVector& G) noexcept;
  /// What of it is not of the masses (springs, cables): holding(q) - gravity(q).
  [[nodiscard]] JointVector elastic(const JointVector& q) noexcept;
  /// tau = M a + C v + G.
  [[nodiscard]] const JointVector& inverse_dynamics(const JointVector& q, const JointVector& v,
                                                    const JointVector& a) noexcept;
  /// C(q,v) v + G(q).
  [[nodiscard]] const JointVector& bias(const JointVector& q, const JointVector& v) noexcept;
  /// Full symmetric M(q).
  [[nodiscard]] const JointMatrix& mass_matrix(const JointVector& q) noexcept;
  /// P(q) of the masses, whose gradient is gravity(q) (Eq 10) [J].
  [[nodiscard]] double potential_energy(const JointVector& q) noexcept { return mechanism_->potential_energy(q); }
  [[nodiscard]] double elastic_energy(const JointVector& q) noexcept;  ///< whose gradient is elastic(q) [J]
  /// Throws std::runtime_error naming what is wrong with it.
  void set_counterbalance(const Counterbalance& spring);
  /// Regressor of gravity and its potential, linear in the links' first moments; empty for a device without one.
  [[nodiscard]] const GravityRegressor& gravity_regressor(const JointVector& q) noexcept;
  [[nodiscard]] Eigen::VectorXd moments() const { return mechanism_->moments(); }  ///< Pi of the model file (4n)
  /// An identified model in place of masses and counterbalance for whatever holds the arm; inertia stays that of the
  /// masses. Throws std::invalid_argument naming what does not fit.
  void set_gravity_model(GravityTerms terms, Eigen::VectorXd theta);
  /// Default (0, 0, -9.81).
  void set_gravity(const Vec3& g_base) noexcept { mechanism_->set_gravity(g_base); }
  /// A copy whose link masses are multiplied by `scale` (a controller's wrong model of the plant); spring and
  /// identified gravity stay.
  [[nodiscard]] Arm with_scaled_masses(const JointVector& scale) const;

  /// Y (n, 10n) of M a + C v + G = Y pi, Pinocchio's order of a link's ten (regressor.hpp); empty for a device that is
  /// not made of links. Allocates.
  [[nodiscard]] Eigen::MatrixXd torque_regressor(const JointVector& q, const JointVector& v, const JointVector& a) {
    return mechanism_->torque_regressor(q, v, a);
  }
  [[nodiscard]] Eigen::VectorXd inertial_parameters() const { return mechanism_->inertial_parameters(); }  ///< pi (10n)
  /// A copy made of other links and nothing else: no counterbalance, no identified gravity. Throws std::runtime_error
  /// naming the link whose mass or inertia cannot be.
  [[nodiscard]] Arm with_inertial_parameters(const Eigen::VectorXd& pi) const;

  /// Closed form where the device has one, else damped Newton from q (in/out), within joint limits. A redundant arm
  /// stays near q; an arm that does not orient() is placed, and the goal's orientation ignored.
  IkResult ik(const Pose& X_0T_goal, JointVector& q, const IkOptions& options = {}) noexcept;

  /// Poses of every link frame at q, in link_names() order; for drawing, not for the cycle.
  [[nodiscard]] std::vector<Pose> link_poses(const JointVector& q);
  [[nodiscard]] const std::vector<std::string>& link_names() const noexcept { return facts().link_names; }
  /// The arm as sticks, for drawing.
  [[nodiscard]] const std::vector<Segment>& segments() const noexcept { return facts().segments; }

 private:
  [[nodiscard]] const Facts& facts() const noexcept { return mechanism_->facts(); }

  std::unique_ptr<Mechanism> mechanism_;
  Counterbalance spring_;
  std::optional<GravityModel> identified_;
  GravityRegressor regressor_;
  JointVector zero_, result_, v_;
  Dynamics state_, work_;  ///< at the joints of update() and dynamics(); of the queries in between
};

}  // namespace palpate::arm
