#include "palpate/arm/arm.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/energy.hpp>
#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/model.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/parsers/urdf.hpp>
#include <stdexcept>

namespace palpate::arm {
namespace {

using ConstRef = Eigen::Ref<const Eigen::VectorXd>;  // the type Pinocchio's library is instantiated for

Pose to_pose(const pinocchio::SE3& X) { return {X.rotation(), X.translation()}; }

std::string join(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

std::vector<std::string> body_names(const pinocchio::Model& model) {
  std::vector<std::string> names;
  for (const auto& frame : model.frames) {
    if (frame.type == pinocchio::BODY) names.push_back(frame.name);
  }
  return names;
}

pinocchio::FrameIndex find_body(const pinocchio::Model& model, const std::string& name, const char* role) {
  if (!model.existBodyName(name)) {
    throw std::runtime_error("the arm's " + std::string(role) + " frame '" + name +
                             "' is not a link of the URDF; its links are: " + join(body_names(model)));
  }
  return model.getBodyId(name);
}

/// The chain from base to tip, every other joint locked at zero.
pinocchio::Model chain(const pinocchio::Model& whole, pinocchio::JointIndex tip) {
  std::vector<bool> on_chain(whole.joints.size(), false);
  for (pinocchio::JointIndex j = tip; j > 0; j = whole.parents[j]) on_chain[j] = true;
  std::vector<pinocchio::JointIndex> locked;
  for (pinocchio::JointIndex j = 1; j < whole.joints.size(); ++j) {
    if (!on_chain[j]) locked.push_back(j);
  }
  if (locked.empty()) return whole;
  pinocchio::Model reduced;
  pinocchio::buildReducedModel(whole, locked, Eigen::VectorXd::Zero(whole.nq), reduced);
  return reduced;
}

pinocchio::Model parse(const std::string& xml) {
  pinocchio::Model whole;
  try {
    pinocchio::urdf::buildModelFromXML(xml, whole);
  } catch (const std::exception& e) {
    throw std::runtime_error("the arm's URDF cannot be read (" + std::string(e.what()) +
                             "); pass the XML text of a <robot>, with every joint's parent and child named");
  }
  for (const auto& link : body_names(whole)) {
    if (whole.existJointName(link) || whole.existFrame(link, pinocchio::FIXED_JOINT)) {
      throw std::runtime_error("the arm's URDF calls a link and a joint '" + link +
                               "': give every link and joint a name of its own");
    }
  }
  return whole;
}

}  // namespace

struct Arm::Impl {
  explicit Impl(const pinocchio::Model& m, const std::string& tip_frame)
      : model(m), data(model), tip_id(model.getBodyId(tip_frame)), tip_joint(model.frames[tip_id].parentJoint) {
    const Eigen::Index n = model.nv;
    q_min = model.lowerPositionLimit;
    q_max = model.upperPositionLimit;
    tau_max = model.upperEffortLimit;
    v_max = model.upperVelocityLimit;
    zero = JointVector::Zero(n);
    spring.along = zero;
    result = v = zero;
    M = JointMatrix::Zero(n, n);
    dynamics = {M, zero, {}, Jacobian::Zero(6, n), Vec6::Zero()};
    J = Jacobian::Zero(6, n);
    for (std::size_t j = 1; j < model.names.size(); ++j) joint_names.push_back(model.names[j]);
    for (std::size_t f = 0; f < model.frames.size(); ++f) {
      if (model.frames[f].type == pinocchio::BODY) {
        link_ids.push_back(f);
        link_names.push_back(model.frames[f].name);
      }
    }
  }

  [[nodiscard]] Pose frame_pose(pinocchio::FrameIndex id) const {
    const auto& frame = model.frames[id];
    return to_pose(data.oMi[frame.parentJoint] * frame.placement);
  }

  /// Columns of data.J are velocities of the point at the base's origin; move them to the tip.
  void tip_jacobian(const Vec3& p_tip, Jacobian& J_tip) const noexcept {
    for (Eigen::Index k = 0; k < model.nv; ++k) {
      const Vec3 w = data.J.col(k).tail<3>();
      J_tip.col(k).head<3>() = data.J.col(k).head<3>() + w.cross(p_tip);
      J_tip.col(k).tail<3>() = w;
    }
  }

  /// Newton-Euler in world axes, on top of what crba left in data.J and data.oMi (three times the speed of another
  /// rnea). Spatial accelerations are those of the point at the base's origin; gravity is an acceleration upwards.
  /// Along a serial chain the velocity of link k is the sum of J_i v_i, and dJ_k/dt = V_k x J_k.
  void bias_and_drift(const JointVector& v_now, Dynamics& d) const noexcept {
    const Vec3 g = model.gravity.linear();
    const Eigen::Index n = model.nv;
    Vec3 v0 = Vec3::Zero(), w = Vec3::Zero(), a0 = -g, alpha = Vec3::Zero();
    std::array<Vec3, kMaxJoints> force, moment;  // of each link's own motion, about the origin
    for (Eigen::Index k = 0; k < n; ++k) {
      const auto link = static_cast<std::size_t>(k);
      const Vec3 dv = data.J.col(k).head<3>() * v_now[k];
      const Vec3 dw = data.J.col(k).tail<3>() * v_now[k];
      a0 += w.cross(dv) + v0.cross(dw);
      alpha += w.cross(dw);
      v0 += dv;
      w += dw;
      const auto& R = data.oMi[link + 1].rotation();
      const auto& body = model.inertias[link + 1];
      const Vec3 com = R * body.lever() + data.oMi[link + 1].translation();
      const Vec3 w_body = R.transpose() * w;
      const Vec3 alpha_body = R.transpose() * alpha;
      const Vec3 spin = body.inertia() * alpha_body + w_body.cross(body.inertia() * w_body);
      force[link] = body.mass() * (a0 + alpha.cross(com) + w.cross(v0 + w.cross(com)));
      moment[link] = R * spin + com.cross(force[link]);
    }
    Vec3 f = Vec3::Zero(), m = Vec3::Zero();
    for (Eigen::Index k = n - 1; k >= 0; --k) {
      f += force[static_cast<std::size_t>(k)];
      m += moment[static_cast<std::size_t>(k)];
      d.bias[k] = data.J.col(k).head<3>().dot(f) + data.J.col(k).tail<3>().dot(m);
    }
    const Vec3& p = d.X_0T.p;
    d.Jdot_v << a0 + g + alpha.cross(p) + w.cross(v0 + w.cross(p)), alpha;
  }

  pinocchio::Model model;
  pinocchio::Data data;
  pinocchio::FrameIndex tip_id;
  pinocchio::JointIndex tip_joint;
  std::vector<std::string> joint_names, link_names;
  std::vector<pinocchio::FrameIndex> link_ids;
  JointVector q_min, q_max, tau_max, v_max, zero, result, v;
  Counterbalance spring;
  JointMatrix M;
  Dynamics dynamics;
  Pose X_0T;
  Jacobian J;
};

Arm Arm::from_urdf(const std::string& xml, const std::string& base_frame, const std::string& tip_frame) {
  const pinocchio::Model whole = parse(xml);
  const auto base = find_body(whole, base_frame, "base");
  const auto tip = find_body(whole, tip_frame, "tip");
  if (whole.frames[base].parentJoint != 0 || !whole.frames[base].placement.isIdentity(1e-12)) {
    throw std::runtime_error("the arm's base frame '" + base_frame +
                             "' is not the root of the URDF; name the root link, or make this link the root");
  }
  pinocchio::Model model = chain(whole, whole.frames[tip].parentJoint);
  if (model.nv < 1 || model.nv > kMaxJoints || model.nq != model.nv) {
    throw std::runtime_error("the chain from '" + base_frame + "' to '" + tip_frame + "' has " +
                             std::to_string(model.nv) + " degrees of freedom; 1 to " + std::to_string(kMaxJoints) +
                             " revolute or prismatic joints are supported (give continuous joints a limit)");
  }
  Arm arm(std::make_unique<Impl>(model, tip_frame));
  arm.update(arm.impl_->zero, arm.impl_->zero);
  return arm;
}

Arm::Arm(std::unique_ptr<Impl> impl) noexcept : impl_(std::move(impl)) {}
Arm::Arm(const Arm& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
Arm& Arm::operator=(const Arm& other) {
  if (this != &other) impl_ = std::make_unique<Impl>(*other.impl_);
  return *this;
}
Arm::Arm(Arm&&) noexcept = default;
Arm& Arm::operator=(Arm&&) noexcept = default;
Arm::~Arm() = default;

int Arm::n() const noexcept { return impl_->model.nv; }
const std::vector<std::string>& Arm::joint_names() const noexcept { return impl_->joint_names; }
const JointVector& Arm::q_min() const noexcept { return impl_->q_min; }
const JointVector& Arm::q_max() const noexcept { return impl_->q_max; }
const JointVector& Arm::tau_max() const noexcept { return impl_->tau_max; }
const JointVector& Arm::v_max() const noexcept { return impl_->v_max; }
const std::vector<std::string>& Arm::link_names() const noexcept { return impl_->link_names; }
const Pose& Arm::tip() const noexcept { return impl_->X_0T; }
const Jacobian& Arm::jacobian() const noexcept { return impl_->J; }

void Arm::update(const JointVector& q, const JointVector& v) noexcept {
  pinocchio::computeJointJacobians(impl_->model, impl_->data, ConstRef(q));
  impl_->X_0T = impl_->frame_pose(impl_->tip_id);
  impl_->tip_jacobian(impl_->X_0T.p, impl_->J);
  impl_->v = v;
}

Twist Arm::twist() const noexcept {
  const Vec6 V = impl_->J * impl_->v;
  return {V.head<3>(), V.tail<3>()};
}

const JointVector& Arm::gravity(const JointVector& q) noexcept {
  impl_->result = pinocchio::computeGeneralizedGravity(impl_->model, impl_->data, ConstRef(q));
  return impl_->result;
}

JointVector Arm::elastic(const JointVector& q) const noexcept {
  const Counterbalance& s = impl_->spring;
  return -s.torque * std::cos(s.along.dot(q)) * s.along;
}

JointVector Arm::holding(const JointVector& q) noexcept { return gravity(q) + elastic(q); }

double Arm::elastic_energy(const JointVector& q) const noexcept {
  return -impl_->spring.torque * std::sin(impl_->spring.along.dot(q));
}

void Arm::set_counterbalance(const Counterbalance& spring) {
  if (spring.along.size() != n() || !spring.along.allFinite() || !std::isfinite(spring.torque)) {
    throw std::runtime_error("a counterbalance needs a finite torque [N m] and " + std::to_string(n()) +
                             " finite numbers along, one per joint; got " + std::to_string(spring.torque) +
                             " N m and " + std::to_string(spring.along.size()) + " numbers");
  }
  impl_->spring = spring;
}

const JointVector& Arm::inverse_dynamics(const JointVector& q, const JointVector& v, const JointVector& a) noexcept {
  impl_->result = pinocchio::rnea(impl_->model, impl_->data, ConstRef(q), ConstRef(v), ConstRef(a));
  return impl_->result;
}

const JointVector& Arm::bias(const JointVector& q, const JointVector& v) noexcept {
  return inverse_dynamics(q, v, impl_->zero);
}

const JointMatrix& Arm::mass_matrix(const JointVector& q) noexcept {
  pinocchio::crba(impl_->model, impl_->data, ConstRef(q), pinocchio::Convention::WORLD);
  impl_->M = impl_->data.M.selfadjointView<Eigen::Upper>();  // crba fills the upper triangle only
  return impl_->M;
}

const Dynamics& Arm::dynamics(const JointVector& q, const JointVector& v) noexcept {
  Dynamics& d = impl_->dynamics;
  pinocchio::crba(impl_->model, impl_->data, ConstRef(q), pinocchio::Convention::WORLD);  // also oMi and J
  d.M = impl_->data.M.selfadjointView<Eigen::Upper>();
  d.X_0T = impl_->frame_pose(impl_->tip_id);
  impl_->tip_jacobian(d.X_0T.p, d.J);
  impl_->bias_and_drift(v, d);
  return d;
}

double Arm::potential_energy(const JointVector& q) noexcept {
  return pinocchio::computePotentialEnergy(impl_->model, impl_->data, ConstRef(q));
}

void Arm::set_gravity(const Vec3& g_base) noexcept { impl_->model.gravity.linear() = g_base; }

Arm Arm::with_scaled_masses(const JointVector& scale) const {
  if (scale.size() != n() || !(scale.array() > 0.0).all()) {
    throw std::runtime_error("with_scaled_masses needs " + std::to_string(n()) +
                             " factors above zero, one per moving link; got " + std::to_string(scale.size()) +
                             " (1 leaves a link as it is)");
  }
  Arm copy(*this);
  for (int j = 0; j < n(); ++j) {
    auto& Y = copy.impl_->model.inertias[static_cast<std::size_t>(j) + 1];
    Y.mass() *= scale[j];
    Y.inertia().data() *= scale[j];
  }
  return copy;
}

std::vector<Pose> Arm::link_poses(const JointVector& q) {
  pinocchio::forwardKinematics(impl_->model, impl_->data, ConstRef(q));
  std::vector<Pose> poses;
  poses.reserve(impl_->link_ids.size());
  for (const auto id : impl_->link_ids) poses.push_back(impl_->frame_pose(id));
  return poses;
}

}  // namespace palpate::arm
