#include "sim/queries.hpp"

#include <cisst_msgs/srv/convert_float64_array.hpp>
#include <crtk_msgs/srv/query_forward_kinematics.hpp>
#include <crtk_msgs/srv/query_inverse_kinematics.hpp>

#include "convert.hpp"
#include "rcl/service.hpp"

namespace palpate::ros {
namespace {

using Forward = crtk_msgs::srv::QueryForwardKinematics;
using Inverse = crtk_msgs::srv::QueryInverseKinematics;
using Convert = cisst_msgs::srv::ConvertFloat64Array;

}  // namespace

Queries::Queries(Node& node, dvrk::System& twin) : twin_(twin) {
  for (int arm = 0; arm < static_cast<int>(twin.arms().size()); ++arm) {
    const std::string& name = twin.arms()[static_cast<std::size_t>(arm)];
    const std::string numbers = std::to_string(twin.joint_names(arm).size()) + " finite numbers";
    std::string forward_needs(name), inverse_needs(name);
    forward_needs.append(": forward kinematics needs ").append(numbers).append(" in jp");
    inverse_needs.append(": cp is out of reach, or jp (where to begin) has not ").append(numbers);
    services_.push_back(std::make_unique<Service<Forward>>(
        node, name + "/forward_kinematics", [=, this](const Forward::Request& request, Forward::Response& response) {
          const std::lock_guard<std::mutex> lock(mutex_);
          Pose cp;
          response.result = twin_.forward_kinematics(arm, dvrk::joints(request.jp), cp);
          put(cp, response.cp);
          if (!response.result) response.message = forward_needs;
        }));
    services_.push_back(std::make_unique<Service<Inverse>>(
        node, name + "/inverse_kinematics", [=, this](const Inverse::Request& request, Inverse::Response& response) {
          const std::lock_guard<std::mutex> lock(mutex_);
          JointVector q = dvrk::joints(request.jp);
          response.result = twin_.inverse_kinematics(arm, pose_of(request.cp), q);
          response.jp.assign(q.data(), q.data() + q.size());
          if (!response.result) response.message = inverse_needs;
        }));
    services_.push_back(std::make_unique<Service<Convert>>(
        node, name + "/actuator_to_joint_position",
        [=, this](const Convert::Request& request, Convert::Response& response) {
          const std::lock_guard<std::mutex> lock(mutex_);
          const JointVector q = twin_.joint_position(arm, dvrk::joints(request.input));  // empty: not feasible
          response.output.assign(q.data(), q.data() + q.size());
        }));
  }
}

Queries::~Queries() = default;

bool Queries::set_base(int arm, const Pose& X_RB) {
  const std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock);
  if (!lock) return false;
  dvrk::Command command;
  command.to = {dvrk::Kind::arm, arm};
  command.verb = dvrk::Verb::set_base_frame;
  command.X = X_RB;
  twin_.apply(command);
  return true;
}

}  // namespace palpate::ros
