#include "palpate/arm/serial.hpp"

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

#include "palpate/arm/regressor.hpp"

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

/// Names the first joint of the chain that is not revolute or prismatic with limits.
void check_joints(const pinocchio::Model& model) {
  for (pinocchio::JointIndex j = 1; j < model.joints.size(); ++j) {
    const std::string kind = model.joints[j].shortname();
    if (model.joints[j].nq() == 1) {
      const double low = model.lowerPositionLimit[model.joints[j].idx_q()];
      const double high = model.upperPositionLimit[model.joints[j].idx_q()];
      if (low < high && std::isfinite(low) && std::isfinite(high)) continue;
      throw std::runtime_error("joint '" + model.names[j] + "' of the arm has the limits " + std::to_string(low) +
                               " to " + std::to_string(high) +
                               ": give it <limit lower=... upper=...> with lower below upper [rad, m]");
    }
    const bool continuous = kind.starts_with("JointModelRUB");
    throw std::runtime_error("joint '" + model.names[j] + "' of the arm is of an unsupported type (" +
                             (continuous ? "continuous" : kind) + "): revolute and prismatic joints are supported; " +
                             (continuous ? "make it revolute, with a limit" : "lock it with type=\"fixed\""));
  }
}

/// The bones of the chain: from each joint to the next, and from the last to the tip.
std::vector<Segment> bones(const pinocchio::Model& model, pinocchio::FrameIndex tip) {
  const auto link_of = [&model](pinocchio::JointIndex joint) {
    for (const auto& frame : model.frames) {
      if (frame.type == pinocchio::BODY && frame.parentJoint == joint && frame.placement.isIdentity(1e-12)) {
        return frame.name;
      }
    }
    return std::string();
  };
  std::vector<Segment> segments;
  const auto add = [&](pinocchio::JointIndex joint, const Vec3& end) {
    const std::string link = link_of(joint);
    if (!link.empty() && end.norm() > 1e-6) segments.push_back({link, end});
  };
  for (pinocchio::JointIndex j = 1; j < model.joints.size(); ++j) {
    add(model.parents[j], model.jointPlacements[j].translation());
  }
  add(model.frames[tip].parentJoint, model.frames[tip].placement.translation());
  return segments;
}

class Serial final : public Mechanism {
 public:
  Serial(const pinocchio::Model& model, const std::string& tip_frame)
      : model_(model), data_(model_), tip_id_(model_.getBodyId(tip_frame)) {
    facts_.q_min = model_.lowerPositionLimit;
    facts_.q_max = model_.upperPositionLimit;
    facts_.tau_max = model_.upperEffortLimit;
    facts_.v_max = model_.upperVelocityLimit;
    facts_.orients = model_.nv >= 6;
    facts_.segments = bones(model_, tip_id_);
    zero_ = JointVector::Zero(model_.nv);
    for (std::size_t j = 1; j < model_.names.size(); ++j) facts_.joint_names.push_back(model_.names[j]);
    for (std::size_t f = 0; f < model_.frames.size(); ++f) {
      if (model_.frames[f].type == pinocchio::BODY) {
        link_ids_.push_back(f);
        facts_.link_names.push_back(model_.frames[f].name);
      }
    }
  }
  Serial(const Serial&) = default;
  [[nodiscard]] std::unique_ptr<Mechanism> clone() const override { return std::make_unique<Serial>(*this); }
  [[nodiscard]] const Facts& facts() const noexcept override { return facts_; }

  void kinematics(const JointVector& q, Pose& X_0T, Jacobian& J) noexcept override {
    pinocchio::computeJointJacobians(model_, data_, ConstRef(q));
    X_0T = frame_pose(tip_id_);
    tip_jacobian(X_0T.p, J);
  }

  void dynamics(const JointVector& q, const JointVector& v, Dynamics& d) noexcept override {
    mass_matrix(q, d);  // also oMi and J
    d.X_0T = frame_pose(tip_id_);
    tip_jacobian(d.X_0T.p, d.J);
    bias_and_drift(v, d);
  }

  void mass_matrix(const JointVector& q, Dynamics& d) noexcept override {
    pinocchio::crba(model_, data_, ConstRef(q), pinocchio::Convention::WORLD);
    d.M = data_.M.selfadjointView<Eigen::Upper>();  // crba fills the upper triangle only
  }

  void gravity(const JointVector& q, Dynamics& /*work*/, JointVector& G) noexcept override {
    G = pinocchio::computeGeneralizedGravity(model_, data_, ConstRef(q));
  }

  void inverse_dynamics(const JointVector& q, const JointVector& v, const JointVector& a, Dynamics& /*work*/,
                        JointVector& tau) noexcept override {
    tau = pinocchio::rnea(model_, data_, ConstRef(q), ConstRef(v), ConstRef(a));
  }

  /// A link's point p moves with v0_j + w_j x p about joint j and before; P = -g . sum (m p_k + R_k m c_k).
  void gravity_regressor(const JointVector& q, GravityRegressor& out) noexcept override {
    pinocchio::computeJointJacobians(model_, data_, ConstRef(q));
    const Vec3 g = model_.gravity.linear();
    const Eigen::Index n = model_.nv;
    out.Y.setZero(n, 4 * n);
    out.P.resize(4 * n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const auto& X_0k = data_.oMi[static_cast<std::size_t>(k) + 1];
      out.P[4 * k] = -g.dot(X_0k.translation());
      out.P.segment<3>(4 * k + 1) = -X_0k.rotation().transpose() * g;
      for (Eigen::Index j = 0; j <= k; ++j) {
        const Vec3 w = data_.J.col(j).tail<3>();
        out.Y(j, 4 * k) = -g.dot(data_.J.col(j).head<3>() + w.cross(X_0k.translation()));
        out.Y.block<1, 3>(j, 4 * k + 1) = -X_0k.rotation().transpose() * g.cross(w);
      }
    }
  }

  [[nodiscard]] Eigen::VectorXd moments() const override {
    Eigen::VectorXd Pi(4 * model_.nv);
    for (Eigen::Index k = 0; k < model_.nv; ++k) {
      const auto& body = model_.inertias[static_cast<std::size_t>(k) + 1];
      Pi.segment<4>(4 * k) << body.mass(), body.mass() * body.lever();
    }
    return Pi;
  }

  [[nodiscard]] double potential_energy(const JointVector& q) noexcept override {
    return pinocchio::computePotentialEnergy(model_, data_, ConstRef(q));
  }

  void set_gravity(const Vec3& g_base) noexcept override { model_.gravity.linear() = g_base; }

  void scale_masses(const JointVector& scale) override {
    for (int j = 0; j < model_.nv; ++j) {
      auto& Y = model_.inertias[static_cast<std::size_t>(j) + 1];
      Y.mass() *= scale[j];
      Y.inertia().data() *= scale[j];
    }
  }

  [[nodiscard]] Pose link_pose(int link) const noexcept override {
    return frame_pose(link_ids_[static_cast<std::size_t>(link)]);
  }

  [[nodiscard]] Eigen::MatrixXd torque_regressor(const JointVector& q, const JointVector& v,
                                                 const JointVector& a) override {
    return arm::torque_regressor(model_, data_, q, v, a);
  }

  [[nodiscard]] Eigen::VectorXd inertial_parameters() const override {
    Eigen::VectorXd pi(10 * model_.nv);
    for (Eigen::Index j = 0; j < model_.nv; ++j) {
      pi.segment<10>(10 * j) = model_.inertias[static_cast<std::size_t>(j) + 1].toDynamicParameters();
    }
    return pi;
  }

  void set_inertial_parameters(const Eigen::VectorXd& pi) override {
    for (Eigen::Index j = 0; j < model_.nv; ++j) {
      model_.inertias[static_cast<std::size_t>(j) + 1] =
          pinocchio::Inertia::FromDynamicParameters(pi.segment<10>(10 * j));
    }
  }

 private:
  [[nodiscard]] Pose frame_pose(pinocchio::FrameIndex id) const noexcept {
    const auto& frame = model_.frames[id];
    return to_pose(data_.oMi[frame.parentJoint] * frame.placement);
  }

  /// Columns of data_.J are velocities of the point at the base's origin; move them to the tip.
  void tip_jacobian(const Vec3& p_tip, Jacobian& J_tip) const noexcept {
    for (Eigen::Index k = 0; k < model_.nv; ++k) {
      const Vec3 w = data_.J.col(k).tail<3>();
      J_tip.col(k).head<3>() = data_.J.col(k).head<3>() + w.cross(p_tip);
      J_tip.col(k).tail<3>() = w;
    }
  }

  /// Newton-Euler in world axes, on top of what crba left in data_.J and data_.oMi (three times the speed of another
  /// rnea). Spatial accelerations are those of the point at the base's origin; gravity is an acceleration upwards.
  /// Along a serial chain the velocity of link k is the sum of J_i v_i, and dJ_k/dt = V_k x J_k.
  void bias_and_drift(const JointVector& v_now, Dynamics& d) const noexcept {
    const Vec3 g = model_.gravity.linear();
    const Eigen::Index n = model_.nv;
    Vec3 v0 = Vec3::Zero(), w = Vec3::Zero(), a0 = -g, alpha = Vec3::Zero();
    std::array<Vec3, kMaxJoints> force, moment;  // of each link's own motion, about the origin
    for (Eigen::Index k = 0; k < n; ++k) {
      const auto link = static_cast<std::size_t>(k);
      const Vec3 dv = data_.J.col(k).head<3>() * v_now[k];
      const Vec3 dw = data_.J.col(k).tail<3>() * v_now[k];
      a0 += w.cross(dv) + v0.cross(dw);
      alpha += w.cross(dw);
      v0 += dv;
      w += dw;
      const auto& R = data_.oMi[link + 1].rotation();
      const auto& body = model_.inertias[link + 1];
      const Vec3 com = R * body.lever() + data_.oMi[link + 1].translation();
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
      d.bias[k] = data_.J.col(k).head<3>().dot(f) + data_.J.col(k).tail<3>().dot(m);
    }
    const Vec3& p = d.X_0T.p;
    d.Jdot_v << a0 + g + alpha.cross(p) + w.cross(v0 + w.cross(p)), alpha;
  }

  pinocchio::Model model_;
  pinocchio::Data data_;
  pinocchio::FrameIndex tip_id_;
  std::vector<pinocchio::FrameIndex> link_ids_;
  Facts facts_;
  JointVector zero_;
};

}  // namespace

std::unique_ptr<Mechanism> serial_arm(const std::string& xml, const std::string& base_frame,
                                      const std::string& tip_frame) {
  const pinocchio::Model whole = parse(xml);
  const auto base = find_body(whole, base_frame, "base");
  const auto tip = find_body(whole, tip_frame, "tip");
  if (whole.frames[base].parentJoint != 0 || !whole.frames[base].placement.isIdentity(1e-12)) {
    throw std::runtime_error("the arm's base frame '" + base_frame +
                             "' is not the root of the URDF; name the root link, or make this link the root");
  }
  pinocchio::Model model = chain(whole, whole.frames[tip].parentJoint);
  if (model.nv < 1 || model.nv > kMaxJoints) {
    throw std::runtime_error("the chain from '" + base_frame + "' to '" + tip_frame + "' has " +
                             std::to_string(model.nv) + " degrees of freedom; 1 to " + std::to_string(kMaxJoints) +
                             " revolute or prismatic joints are supported (give continuous joints a limit)");
  }
  check_joints(model);
  return std::make_unique<Serial>(model, tip_frame);
}

}  // namespace palpate::arm
