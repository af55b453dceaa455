#include "dvrk/body.hpp"

namespace palpate::dvrk {
namespace {

plant::HandOptions no_hand() noexcept {
  plant::HandOptions hand;
  hand.mass = hand.damping = hand.stiffness = 0.0;
  hand.inertia = hand.rotational_damping = hand.rotational_stiffness = 0.0;
  return hand;
}

/// An arm moved by torques: tau = P (q_goal - q) + D (v_goal - v) + feed-forward in position control, else the ordered
/// tau; |tau| <= tau_max.
class DynamicBody final : public Body {
 public:
  explicit DynamicBody(const ArmSpec& spec)
      : spec_(spec.hand),
        P_(spec.P),
        D_(spec.D),
        tau_max_(spec.leader.tau_max),
        leader_(spec.model, spec.leader, no_hand()),
        command_(spec.model.n()) {}

  void reset(const JointVector& q) noexcept override {
    leader_.reset(q);
    command(Order{});
    observe();
  }

  void command(const Order& order) noexcept override {
    measured_.tau = JointVector::Zero(tau_max_.size());
    if (order.on) {
      for (Eigen::Index k = 0; k < tau_max_.size(); ++k) {
        const bool by_torque = order.by_torque[static_cast<std::size_t>(k)];
        const double servo =
            by_torque ? 0.0
                      : P_[k] * (order.q[k] - leader_.measured().q[k]) + D_[k] * (order.v[k] - leader_.measured().v[k]);
        measured_.tau[k] = std::clamp(order.tau[k] + servo, -tau_max_[k], tau_max_[k]);
      }
    }
    command_.tau_gravity = measured_.tau;  // this term has no timeout in the drives, as on the real arm
    leader_.command(command_);
  }

  void step(double dt, const Surroundings& around) noexcept override {
    if (around.held != held_) leader_.grip(around.held ? spec_ : no_hand());
    held_ = around.held;
    leader_.step(dt, around.X_hand, {}, around.F);
    observe();
  }

  [[nodiscard]] const JointState& measured() const noexcept override { return measured_; }
  [[nodiscard]] JointState truth() const noexcept override { return {leader_.q(), leader_.v(), measured_.tau}; }
  [[nodiscard]] const Wrench& F_hand() const noexcept override { return leader_.load_cell(); }

 private:
  void observe() noexcept {
    measured_.q = leader_.measured().q;
    measured_.v = leader_.measured().v;
  }

  plant::HandOptions spec_;
  JointVector P_, D_, tau_max_;
  plant::Leader leader_;
  LeaderCommand command_;
  JointState measured_;
  bool held_ = false;
};

/// An arm whose joints follow their goals by servos (plant::Follower). In torque control the joints stay in place, as
/// in the kinematic simulation of the real component. The reported torque is that of the drives: it balances the
/// weight, less the force on the tip.
class ServoBody final : public Body {
 public:
  explicit ServoBody(const ArmSpec& spec) : model_(spec.model), follower_(spec.model, spec.follower) {}

  void reset(const JointVector& q) noexcept override {
    follower_.reset(q, 0.0);
    goal_.q = follower_.measured().q;
    measured_ = {goal_.q, JointVector::Zero(q.size()), JointVector::Zero(q.size())};
  }

  void command(const Order& order) noexcept override {
    const JointVector& q = follower_.measured().q;
    measured_.v = follower_.v();
    measured_.q = q;
    measured_.tau = JointVector::Zero(q.size());
    if (!order.on) goal_.q = q;
    if (order.on) {
      model_.update(q, measured_.v);
      const Jacobian& J = model_.jacobian();
      const JointVector holding = model_.holding(q);
      for (Eigen::Index k = 0; k < q.size(); ++k) {
        const bool by_torque = order.by_torque[static_cast<std::size_t>(k)];
        goal_.q[k] = by_torque ? q[k] : order.q[k];
        const double pushed = J.col(k).head<3>().dot(F_.f) + J.col(k).tail<3>().dot(F_.t);
        const double tau_max = model_.tau_max()[k];
        measured_.tau[k] = std::clamp(by_torque ? order.tau[k] : holding[k] - pushed, -tau_max, tau_max);
      }
    }
    follower_.command(goal_);
  }

  void step(double dt, const Surroundings& around) noexcept override {
    F_ = around.F;
    follower_.step(dt);
  }

  [[nodiscard]] const JointState& measured() const noexcept override { return measured_; }
  [[nodiscard]] JointState truth() const noexcept override {
    return {follower_.measured().q, measured_.v, measured_.tau};
  }
  [[nodiscard]] const Wrench& F_hand() const noexcept override { return none_; }

 private:
  arm::Arm model_;
  plant::Follower follower_;
  FollowerCommand goal_;
  JointState measured_;
  Wrench F_, none_;
};

}  // namespace

std::unique_ptr<Body> make_body(const ArmSpec& spec) {
  std::unique_ptr<Body> body;
  if (spec.dynamic) {
    body = std::make_unique<DynamicBody>(spec);
  } else {
    body = std::make_unique<ServoBody>(spec);
  }
  body->reset(spec.start);
  return body;
}

}  // namespace palpate::dvrk
