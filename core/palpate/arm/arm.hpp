// An arm: a constant model shared by all copies, beside a workspace of its own (Pinocchio behind it).
#pragma once

#include <memory>
#include <string>
#include <vector>

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

/// Everything a simulator needs at one (q, v): M a + bias = tau, and the tip with its Jacobian.
struct Dynamics {
  JointMatrix M;               ///< inertia, full and symmetric
  JointVector bias;            ///< C(q, v) v + G(q)
  Pose X_0T;                   ///< base to tip
  Jacobian J;                  ///< as Arm::jacobian()
  Vec6 Jdot_v = Vec6::Zero();  ///< tip acceleration at zero joint acceleration, linear over angular
};

/// A spring that carries a link: P = -torque sin(x), x = along . q, so it puts  dP/dq = -torque cos(x) along  on the
/// drives. Of a potential, so that no motion round and round can draw energy from it.
struct Counterbalance {
  double torque = 0.0;  ///< what it takes off at x = 0 [N m]; 0 = there is none
  JointVector along;    ///< how far the link turns per joint (n,) [rad/rad]
};

/// Kinematics and dynamics of one serial arm in its base frame. Everything that is noexcept may run in
/// the cycle: no allocation after construction. Copies share the model, own the workspace.
class Arm {
 public:
  /// Throws std::runtime_error naming the file, the frame or joint, and the mend.
  /// The arm is the chain from base to tip; other joints (jaws, drawn parallelograms) stay at zero.
  static Arm from_urdf(const std::string& xml, const std::string& base_frame, const std::string& tip_frame);

  Arm(const Arm&);
  Arm& operator=(const Arm&);
  Arm(Arm&&) noexcept;
  Arm& operator=(Arm&&) noexcept;
  ~Arm();

  [[nodiscard]] int n() const noexcept;
  [[nodiscard]] const std::vector<std::string>& joint_names() const noexcept;
  [[nodiscard]] const JointVector& q_min() const noexcept;
  [[nodiscard]] const JointVector& q_max() const noexcept;
  [[nodiscard]] const JointVector& tau_max() const noexcept;  ///< URDF effort limits [N m, N]
  [[nodiscard]] const JointVector& v_max() const noexcept;    ///< URDF velocity limits [rad/s, m/s]

  /// Kinematics at q, v: fills tip(), jacobian(), twist().
  void update(const JointVector& q, const JointVector& v) noexcept;
  [[nodiscard]] const Pose& tip() const noexcept;           ///< X_0T, base to tip
  [[nodiscard]] const Jacobian& jacobian() const noexcept;  ///< at the tip, in base axes
  [[nodiscard]] Twist twist() const noexcept;               ///< J v

  /// Gravity torque G(q) = dP/dq that holds the masses up (Eq 10); gravity vector in the base frame.
  [[nodiscard]] const JointVector& gravity(const JointVector& q) noexcept;
  /// Torque dP/dq that holds the counterbalance's spring; zero without one.
  [[nodiscard]] JointVector elastic(const JointVector& q) const noexcept;
  /// What holds the arm still: gravity(q) + elastic(q).
  [[nodiscard]] JointVector holding(const JointVector& q) noexcept;
  /// tau = M a + C v + G (rnea).
  [[nodiscard]] const JointVector& inverse_dynamics(const JointVector& q, const JointVector& v,
                                                    const JointVector& a) noexcept;
  /// C(q,v) v + G(q).
  [[nodiscard]] const JointVector& bias(const JointVector& q, const JointVector& v) noexcept;
  /// Full symmetric M(q) (crba).
  [[nodiscard]] const JointMatrix& mass_matrix(const JointVector& q) noexcept;
  /// M, bias, tip and Jacobian in one go: for a simulator, where every microsecond counts ten times a tick.
  const Dynamics& dynamics(const JointVector& q, const JointVector& v) noexcept;
  /// P(q) of the masses, whose gradient is gravity(q) (Eq 10) [J].
  [[nodiscard]] double potential_energy(const JointVector& q) noexcept;
  [[nodiscard]] double elastic_energy(const JointVector& q) const noexcept;  ///< of the spring [J]
  /// Throws std::runtime_error naming what is wrong with it.
  void set_counterbalance(const Counterbalance& spring);
  void set_gravity(const Vec3& g_base) noexcept;  ///< default (0, 0, -9.81)
  /// A copy whose link masses are multiplied by `scale` (a controller's wrong model of the plant); the spring stays.
  [[nodiscard]] Arm with_scaled_masses(const JointVector& scale) const;

  /// Damped Newton from q (in/out), within joint limits. 6-dof goal; a redundant arm stays near q.
  IkResult ik(const Pose& X_0T_goal, JointVector& q, const IkOptions& options = {}) noexcept;

  /// Poses of every link frame at q, in link_names() order; for drawing, not for the cycle.
  [[nodiscard]] std::vector<Pose> link_poses(const JointVector& q);
  [[nodiscard]] const std::vector<std::string>& link_names() const noexcept;

 private:
  struct Impl;
  explicit Arm(std::unique_ptr<Impl> impl) noexcept;
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::arm
