#include "sim/measures.hpp"

#include <crtk_msgs/msg/cartesian_state.hpp>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <geometry_msgs/msg/quaternion_stamped.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <geometry_msgs/msg/wrench_stamped.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <std_msgs/msg/float64_multi_array.hpp>

#include "convert.hpp"
#include "rcl/publisher.hpp"
#include "sim/frames.hpp"

namespace palpate::ros {

struct ArmMeasures::TopicPublisher {
  TopicPublisher() = default;
  virtual ~TopicPublisher() = default;
  TopicPublisher(const TopicPublisher&) = delete;
  TopicPublisher& operator=(const TopicPublisher&) = delete;
  virtual void find_subscribers() = 0;  ///< checks whether the topic has subscribers
  virtual Status publish(const dvrk::ArmState& state, std::int64_t time_ns) = 0;
};

namespace {

using dvrk::ArmState;

constexpr unsigned kMtm = static_cast<unsigned>(dvrk::ArmKind::mtm), kPsm = static_cast<unsigned>(dvrk::ArmKind::psm);
constexpr std::int64_t kLook = 20'000'000;  // interval of the checks for subscribers [ns]

constexpr std::string_view kSetup = "SUJ/";  // name of the setup joints, before that of the arm that they carry

bool always(const ArmState&) { return true; }
bool joints_valid(const ArmState& s) { return s.joints_valid; }
bool cartesian_valid(const ArmState& s) { return s.cartesian_valid; }
bool base_valid(const ArmState& s) { return s.cartesian_valid && s.base_frame_valid; }
bool jaw_valid(const ArmState& s) { return s.jaw_valid; }

/// A topic of an arm: its name, its value, the condition of validity and the kinds of arms that publish it.
template <class Value>
struct Row {
  const char* topic;
  Value (*value)(const ArmState&);
  bool (*valid)(const ArmState&);
  unsigned arms = dvrk::kEveryArm;
};

struct Cartesian {
  Pose X;
  Twist V;
  Wrench F;
};

constexpr Row<dvrk::JointState> kJoints[] = {
    {"measured_js", [](const ArmState& s) { return s.measured_js; }, joints_valid},
    {"setpoint_js", [](const ArmState& s) { return s.setpoint_js; }, joints_valid},
    {"gravity_compensation/setpoint_js",
     [](const ArmState& s) { return dvrk::JointState{{}, {}, s.gravity_compensation}; }, joints_valid},
    {"gripper/measured_js", [](const ArmState& s) { return s.gripper; }, always, kMtm},
    {"jaw/measured_js", [](const ArmState& s) { return s.jaw_measured_js; }, jaw_valid, kPsm},
    {"jaw/setpoint_js", [](const ArmState& s) { return s.jaw_setpoint_js; }, jaw_valid, kPsm},
};
constexpr Row<Pose> kPoses[] = {
    {"measured_cp", [](const ArmState& s) { return s.measured_cp; }, base_valid},
    {"setpoint_cp", [](const ArmState& s) { return s.setpoint_cp; }, base_valid},
    {"local/measured_cp", [](const ArmState& s) { return s.local_measured_cp; }, cartesian_valid},
    {"local/setpoint_cp", [](const ArmState& s) { return s.local_setpoint_cp; }, cartesian_valid},
};
/// Topics of the setup joints that carry an arm, below SUJ/.
constexpr Row<dvrk::JointState> kSetupJoints[] = {
    {"measured_js", [](const ArmState& s) { return s.setup_js; }, always},
};
constexpr Row<Pose> kSetupPoses[] = {
    {"measured_cp", [](const ArmState& s) { return s.setup_cp; }, always},
    {"local/measured_cp", [](const ArmState& s) { return s.local_setup_cp; }, always},
};
constexpr Row<Twist> kTwists[] = {
    {"measured_cv", [](const ArmState& s) { return s.measured_cv; }, base_valid},
    {"setpoint_cv", [](const ArmState& s) { return s.setpoint_cv; }, base_valid},
    {"local/measured_cv", [](const ArmState& s) { return s.local_measured_cv; }, cartesian_valid},
    {"local/setpoint_cv", [](const ArmState& s) { return s.local_setpoint_cv; }, cartesian_valid},
};
constexpr Row<Wrench> kWrenches[] = {
    {"body/measured_cf", [](const ArmState& s) { return s.body_measured_cf; }, cartesian_valid},
    {"spatial/measured_cf", [](const ArmState& s) { return s.spatial_measured_cf; }, cartesian_valid},
    // Force of the simulated hand.
    {"hand/measured_cf", [](const ArmState& s) { return s.F_hand; }, cartesian_valid, kMtm},
};
constexpr Row<Jacobian> kJacobians[] = {
    {"body/jacobian", [](const ArmState& s) { return s.body_jacobian; }, cartesian_valid},
    {"spatial/jacobian", [](const ArmState& s) { return s.spatial_jacobian; }, cartesian_valid},
};
constexpr Row<Cartesian> kCartesians[] = {
    {"measured_cs", [](const ArmState& s) { return Cartesian{s.measured_cp, s.measured_cv, s.measured_cf}; },
     base_valid},
};

// ---- Functions that copy a value into each message type.

void write(const JointVector& x, std::vector<double>& numbers) { numbers.assign(x.data(), x.data() + x.size()); }
void write(const dvrk::JointState& js, sensor_msgs::msg::JointState& m) {
  write(js.q, m.position);
  write(js.v, m.velocity);
  write(js.tau, m.effort);
}
void write(const Pose& X, geometry_msgs::msg::PoseStamped& m) { put(X, m.pose); }
void write(const Twist& V, geometry_msgs::msg::TwistStamped& m) { put(V, m.twist); }
void write(const Wrench& F, geometry_msgs::msg::WrenchStamped& m) { put(F, m.wrench); }
void write(const Jacobian& J, std_msgs::msg::Float64MultiArray& m) {
  const auto rows = static_cast<std::uint32_t>(J.rows()), cols = static_cast<std::uint32_t>(J.cols());
  m.layout.dim.resize(2);
  m.layout.dim[0].label = "rows";
  m.layout.dim[0].size = rows;
  m.layout.dim[0].stride = rows * cols;
  m.layout.dim[1].label = "cols";
  m.layout.dim[1].size = cols;
  m.layout.dim[1].stride = cols;
  m.data.resize(std::size_t{rows} * cols);
  for (Eigen::Index i = 0; i < J.rows(); ++i)
    for (Eigen::Index k = 0; k < J.cols(); ++k) m.data[static_cast<std::size_t>(i * J.cols() + k)] = J(i, k);
}
void write(const Cartesian& c, crtk_msgs::msg::CartesianState& m) {
  put(c.X, m.pose);
  put(c.V, m.twist);
  put(c.F, m.wrench);
}
template <class Msg>
void sign(Msg& m, std::int64_t time_ns, bool valid) {
  if constexpr (requires { m.header; }) m.header.stamp = stamp(valid ? time_ns : 0);
  if constexpr (requires { m.pose_is_valid; })
    m.pose_is_valid.data = m.twist_is_valid.data = m.wrench_is_valid.data = valid;
}

template <class Value, class Msg>
struct MeasurePublisher final : ArmMeasures::TopicPublisher {
  MeasurePublisher(Node& node, const std::string& arm, const Row<Value>& row, const std::vector<std::string>& joints)
      : row(row), name(arm), publisher(node, arm + "/" + row.topic) {
    of_setup = arm.starts_with(kSetup);
    referred =
        !of_setup && (arm + "/" + row.topic).ends_with("_cp") && !std::string_view(row.topic).starts_with("local");
    if constexpr (requires { message.header; }) message.header.frame_id = of_setup ? "Cart" : arm + "_base";
    if constexpr (requires { message.name; }) message.name = joints;
  }
  void find_subscribers() override { has_subscribers = publisher.listeners() > 0; }
  Status publish(const ArmState& state, std::int64_t time_ns) override {
    if (!has_subscribers) return {};
    if constexpr (requires { message.header; }) {
      if (referred) message.header.frame_id = reference_of(name, state);
      if (of_setup && !state.reference.empty()) message.header.frame_id = local ? "Cart" : std::string(state.reference);
    }
    write(row.value(state), message);
    sign(message, time_ns, row.valid(state));
    return publisher.publish(message);
  }
  Row<Value> row;
  std::string name;  ///< of the component
  bool of_setup = false, local = std::string_view(row.topic).starts_with("local");
  bool referred = false;  ///< told in the frame of the reference arm
  Publisher<Msg> publisher;
  Msg message;
  bool has_subscribers = false;
};

template <class Msg, class Value, std::size_t N>
void add(std::vector<std::unique_ptr<ArmMeasures::TopicPublisher>>& publishers, Node& node, const std::string& arm,
         dvrk::ArmKind kind, const std::vector<std::string>& joints, const Row<Value> (&rows)[N]) {
  for (const Row<Value>& row : rows) {
    if ((row.arms & static_cast<unsigned>(kind)) == 0) continue;
    const std::string_view topic = row.topic;
    const bool one = topic.starts_with("gripper") || topic.starts_with("jaw");
    const auto names = one ? std::vector<std::string>{std::string(topic.substr(0, topic.find('/')))} : joints;
    publishers.push_back(std::make_unique<MeasurePublisher<Value, Msg>>(node, arm, row, names));
  }
}

}  // namespace

ArmMeasures::ArmMeasures(Node& node, const std::string& name, dvrk::ArmKind kind,
                         const std::vector<std::string>& joints)
    : node_(node) {
  add<sensor_msgs::msg::JointState>(publishers_, node, name, kind, joints, kJoints);
  add<geometry_msgs::msg::PoseStamped>(publishers_, node, name, kind, joints, kPoses);
  add<geometry_msgs::msg::TwistStamped>(publishers_, node, name, kind, joints, kTwists);
  add<geometry_msgs::msg::WrenchStamped>(publishers_, node, name, kind, joints, kWrenches);
  add<std_msgs::msg::Float64MultiArray>(publishers_, node, name, kind, joints, kJacobians);
  add<crtk_msgs::msg::CartesianState>(publishers_, node, name, kind, joints, kCartesians);
  if (kind == dvrk::ArmKind::mtm) return;
  const std::string carrying = std::string(kSetup) + name;
  const std::vector<std::string> setup{"lift", "shoulder", "elbow", "wrist", "tilt", "roll"};
  add<sensor_msgs::msg::JointState>(publishers_, node, carrying, kind, setup, kSetupJoints);
  add<geometry_msgs::msg::PoseStamped>(publishers_, node, carrying, kind, setup, kSetupPoses);
}

ArmMeasures::~ArmMeasures() = default;

void ArmMeasures::publish(const dvrk::ArmState& state, std::int64_t time_ns) {
  const bool look = time_ns - looked_ns_ >= kLook || time_ns < looked_ns_;
  if (look) looked_ns_ = time_ns;
  for (const auto& publisher : publishers_) {
    if (look) publisher->find_subscribers();
    if (const Status published = publisher->publish(state, time_ns); !published) node_.problem(published.problem);
  }
}

struct TeleopMeasures::TopicPublisher {
  TopicPublisher(Node& node, const std::string& topic) : publisher(node, topic) {}
  Publisher<geometry_msgs::msg::QuaternionStamped> publisher;
  geometry_msgs::msg::QuaternionStamped message;
};

TeleopMeasures::TeleopMeasures(Node& node, const std::string& name)
    : node_(node), alignment_(std::make_unique<TopicPublisher>(node, name + "/alignment_offset")) {}
TeleopMeasures::~TeleopMeasures() = default;

void TeleopMeasures::publish(const dvrk::TeleopState& state, std::int64_t time_ns) {
  put(state.alignment_offset, alignment_->message.quaternion);
  alignment_->message.header.stamp = stamp(time_ns);
  if (const Status published = alignment_->publisher.publish(alignment_->message); !published)
    node_.problem(published.problem);
}

}  // namespace palpate::ros
