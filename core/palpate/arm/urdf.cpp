// Reads the chain of an arm from a URDF. urdfdom, the parser behind Pinocchio's, reads the XML: Pinocchio's own header
// for it takes more than a minute to compile.
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <set>
#include <stdexcept>

#include "palpate/arm/chain.hpp"

namespace palpate::arm {
namespace {

Vec3 to_vector(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

Pose to_pose(const urdf::Pose& X) {
  const urdf::Rotation& q = X.rotation;
  return {Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix(), to_vector(X.position)};
}

urdf::ModelInterfaceSharedPtr parse(const std::string& xml) {
  std::string why = "it is no valid robot";
  urdf::ModelInterfaceSharedPtr robot;
  try {
    robot = urdf::parseURDF(xml);
  } catch (const std::exception& e) {
    why = e.what();
  }
  if (!robot || !robot->getRoot()) {
    throw std::runtime_error("the arm's URDF cannot be read (" + why +
                             "); pass the XML text of a <robot>, with every joint's parent and child named");
  }
  for (const auto& [name, link] : robot->links_) {
    if (robot->joints_.contains(name)) {
      throw std::runtime_error("the arm's URDF calls a link and a joint '" + name +
                               "': give every link and joint a name of its own");
    }
  }
  return robot;
}

bool moves(const urdf::Joint& joint) { return joint.type != urdf::Joint::FIXED && joint.type != urdf::Joint::UNKNOWN; }

/// Range of a joint of type "continuous", to both sides [rad]: two turns, as searches need an end.
constexpr double kContinuous = 2.0 * std::numbers::pi;

/// Refuses a joint that is not continuous, nor revolute or prismatic with limits.
void check(const urdf::Joint& joint) {
  if (joint.type == urdf::Joint::CONTINUOUS) return;
  if (joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::PRISMATIC) {
    const double low = joint.limits ? joint.limits->lower : 0.0, high = joint.limits ? joint.limits->upper : 0.0;
    if (low < high && std::isfinite(low) && std::isfinite(high)) return;
    throw std::runtime_error("joint '" + joint.name + "' of the arm has the limits " + std::to_string(low) + " to " +
                             std::to_string(high) +
                             ": give it <limit lower=... upper=...> with lower below upper [rad, m]");
  }
  throw std::runtime_error("joint '" + joint.name + "' of the arm is of an unsupported type (" +
                           (joint.type == urdf::Joint::PLANAR ? "planar" : "floating") +
                           "): revolute, continuous and prismatic joints are supported; lock it with type=\"fixed\"");
}

/// Adds a rigid body, given in the link's axes, to the link.
void add_body(const urdf::Inertial& body, const Pose& X_link, Link& link) {
  const Pose X = X_link * to_pose(body.origin);
  Mat3 I;
  I << body.ixx, body.ixy, body.ixz, body.ixy, body.iyy, body.iyz, body.ixz, body.iyz, body.izz;
  const double mass = link.mass + body.mass;
  if (!(mass > 0.0)) {
    link.inertia += X.R * I * X.R.transpose();
    return;
  }
  const Vec3 apart = X.p - link.com;
  const Mat3 parallel = apart.squaredNorm() * Mat3::Identity() - apart * apart.transpose();
  link.inertia += X.R * I * X.R.transpose() + (link.mass * body.mass / mass) * parallel;
  link.com = (link.mass * link.com + body.mass * X.p) / mass;
  link.mass = mass;
}

/// Walks the tree of links, parents first; joints that are not on the chain stay at zero.
class ChainReader {
 public:
  ChainReader(const urdf::ModelInterface& robot, const std::string& base, const std::string& tip) : tip_(tip) {
    for (urdf::LinkConstSharedPtr link = find(robot, tip, "tip"); link; link = link->getParent()) {
      if (link->parent_joint && moves(*link->parent_joint)) on_chain_.insert(link->parent_joint->name);
    }
    if (find(robot, base, "base") != robot.getRoot()) {
      throw std::runtime_error("the arm's base frame '" + base +
                               "' is not the root of the URDF; name the root link, or make this link the root");
    }
    if (on_chain_.empty() || on_chain_.size() > kMaxJoints) {
      throw std::runtime_error("the chain from '" + base + "' to '" + tip + "' has " +
                               std::to_string(on_chain_.size()) + " degrees of freedom; 1 to " +
                               std::to_string(kMaxJoints) + " revolute, continuous or prismatic joints are supported");
    }
    const auto joints = static_cast<Eigen::Index>(on_chain_.size());
    Facts& facts = chain_.facts;
    facts.q_min = facts.q_max = facts.tau_max = facts.v_max = JointVector::Zero(joints);
    facts.orients = joints >= 6;
    visit(*robot.getRoot(), {-1, {}});
    add_segments();
  }

  [[nodiscard]] Chain chain() && { return std::move(chain_); }

 private:
  /// The link and all that it carries, parents first.
  static std::string names(const urdf::Link& link) {
    std::string text = link.name;
    for (const urdf::LinkSharedPtr& child : link.child_links) text += ", " + names(*child);
    return text;
  }

  static urdf::LinkConstSharedPtr find(const urdf::ModelInterface& robot, const std::string& name, const char* role) {
    if (urdf::LinkConstSharedPtr link = robot.getLink(name)) return link;
    throw std::runtime_error("the arm's " + std::string(role) + " frame '" + name +
                             "' is not a link of the URDF; its links are: " + names(*robot.getRoot()));
  }

  void visit(const urdf::Link& link, const FixedFrame& frame) {
    chain_.frames.push_back(frame);
    chain_.facts.link_names.push_back(link.name);
    if (link.name == tip_) chain_.tip = frame;
    if (link.inertial && frame.link >= 0) {
      add_body(*link.inertial, frame.X_link, chain_.links[static_cast<std::size_t>(frame.link)]);
    }
    for (const urdf::LinkSharedPtr& child : link.child_links) {
      const urdf::Joint& joint = *child->parent_joint;
      const Pose X = frame.X_link * to_pose(joint.parent_to_joint_origin_transform);
      visit(*child, on_chain_.contains(joint.name) ? add_joint(joint, X) : FixedFrame{frame.link, X});
    }
  }

  FixedFrame add_joint(const urdf::Joint& joint, const Pose& X_parent) {
    check(joint);
    const auto k = static_cast<Eigen::Index>(chain_.links.size());
    Link link;
    link.X_parent = X_parent;
    link.axis = to_vector(joint.axis).normalized();
    link.prismatic = joint.type == urdf::Joint::PRISMATIC;
    chain_.links.push_back(link);
    Facts& facts = chain_.facts;
    facts.joint_names.push_back(joint.name);
    const bool continuous = joint.type == urdf::Joint::CONTINUOUS;  // its lower and upper limits mean nothing
    facts.q_min[k] = continuous ? -kContinuous : joint.limits->lower;
    facts.q_max[k] = continuous ? kContinuous : joint.limits->upper;
    facts.tau_max[k] = joint.limits ? joint.limits->effort : 0.0;
    facts.v_max[k] = joint.limits ? joint.limits->velocity : 0.0;
    return {static_cast<int>(k), {}};
  }

  /// Straight pieces from each joint to the next, and from the last one to the tip.
  void add_segments() {
    const auto add = [this](int carrier, const Vec3& end) {
      for (std::size_t f = 0; f < chain_.frames.size(); ++f) {
        const FixedFrame& frame = chain_.frames[f];
        if (frame.link != carrier || !frame.X_link.R.isIdentity(1e-12) || !frame.X_link.p.isZero(1e-12)) continue;
        if (end.norm() > 1e-6) chain_.facts.segments.push_back({chain_.facts.link_names[f], end});
        return;
      }
    };
    for (std::size_t k = 0; k < chain_.links.size(); ++k) add(static_cast<int>(k) - 1, chain_.links[k].X_parent.p);
    add(chain_.tip.link, chain_.tip.X_link.p);
  }

  std::string tip_;
  std::set<std::string> on_chain_;
  Chain chain_;
};

}  // namespace

Chain chain_from_urdf(const std::string& xml, const std::string& base_frame, const std::string& tip_frame) {
  return ChainReader(*parse(xml), base_frame, tip_frame).chain();
}

}  // namespace palpate::arm
