#include "sim/frames.hpp"

#include <tf2_msgs/msg/tf_message.hpp>

#include "convert.hpp"
#include "rcl/publisher.hpp"

namespace palpate::ros {
namespace {

constexpr std::int64_t kFramePeriod = 20'000'000;  // [ns]

}  // namespace

struct Frames::Publishing {
  explicit Publishing(Node& node) : publisher(node, "/tf", Qos{.depth = 100}) {}
  Publisher<tf2_msgs::msg::TFMessage> publisher;
  tf2_msgs::msg::TFMessage message;
};

std::string reference_of(const std::string& arm, const dvrk::ArmState& state) {
  return state.reference.empty() ? arm + "_base" : std::string(state.reference);
}

Frames::Frames(Node& node, const dvrk::System& robot)
    : node_(node), arms_(robot.arms()), to_(std::make_unique<Publishing>(node)) {}
Frames::~Frames() = default;

bool Frames::due(std::int64_t now) noexcept {
  if (now - sent_ < kFramePeriod) return false;
  sent_ = now;
  return to_->publisher.listeners() > 0;
}

void Frames::add(int arm, const dvrk::ArmState& state, std::int64_t time_ns) {
  const std::string& name = arms_[static_cast<std::size_t>(arm)];
  const auto edge = [&](const std::string& parent, const std::string& child, const Pose& X) {
    geometry_msgs::msg::TransformStamped t;
    t.header.stamp = stamp(time_ns);
    t.header.frame_id = parent;
    t.child_frame_id = child;
    put(X.p, t.transform.translation);
    put(X.R, t.transform.rotation);
    to_->message.transforms.push_back(t);
  };
  const bool carried = state.setup_js.q.size() > 0;
  if (carried) edge("Cart", name + "_base", state.local_setup_cp);
  if (!state.cartesian_valid) return;
  // Each frame has one parent: what is told in another arm's frame is shown below its own base.
  edge(name + "_base", name, carried ? state.local_measured_cp : state.measured_cp);
}

void Frames::send() {
  if (const Status sent = to_->publisher.publish(to_->message); !sent) node_.problem(sent.problem);
  to_->message.transforms.clear();
}

}  // namespace palpate::ros
