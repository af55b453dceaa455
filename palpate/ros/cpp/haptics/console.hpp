// What the console, the arms and the graph say beside the states: the gates of the cycle. A thread of its own; the
// cycle reads the answer and never waits.
#pragma once

#include <atomic>
#include <condition_variable>
#include <crtk_msgs/msg/operating_state.hpp>
#include <list>
#include <memory>
#include <mutex>
#include <sensor_msgs/msg/joy.hpp>
#include <std_msgs/msg/bool.hpp>
#include <std_msgs/msg/float64.hpp>
#include <std_msgs/msg/string.hpp>
#include <string>
#include <thread>
#include <vector>

#include "haptics/ear.hpp"
#include "haptics/names.hpp"
#include "palpate/loop/crtk_cycle.hpp"
#include "rcl/publisher.hpp"
#include "rcl/spinner.hpp"

namespace palpate::ros {

class Console {
 public:
  /// writers: names of the nodes that may write wrenches (ours and the guardian's). device: how it takes wrenches.
  Console(std::shared_ptr<Context> context, const HapticNames& names, std::vector<std::string> writers,
          const loop::CrtkOptions& device);
  ~Console();
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  /// For the cycle: no lock, no wait. What is over since the last call is told once.
  [[nodiscard]] loop::CrtkGates gates() noexcept;
  /// Motion scale of the other teleoperation; zero: not told.
  [[nodiscard]] double scale() const noexcept { return scale_.load(std::memory_order_relaxed); }

  /// What has happened since the last call, in words.
  [[nodiscard]] std::vector<std::string> news();
  void tell(std::string words);

 private:
  enum Gate : unsigned {
    kFollowing = 1u,
    kOperator = 2u,
    kClutch = 4u,
    kLeader = 8u,
    kFollower = 16u,
    kWriter = 32u,
    kOther = 64u,
    kCamera = 128u,
    kDeaf = 256u  ///< nobody listens to the frame of the wrench
  };
  /// Somebody's teleoperation on our leader.
  struct Teleop {
    Teleop(Node& node, const std::string& name, Console& console);
    [[nodiscard]] bool on() const noexcept { return enabled || following; }
    std::string name;
    std::atomic<bool> following{false}, enabled{true};  ///< on, until it says that it is not
    std::atomic<bool> told{false};
    int looks = 0;
    Ear<std_msgs::msg::Bool> following_ear;
    Ear<std_msgs::msg::String> state_ear;
  };

  /// Sets a gate; true when that is a change.
  bool set(Gate gate, bool on) noexcept;
  void follow(bool on);
  void state(Gate gate, const std::string& arm, const crtk_msgs::msg::OperatingState& told);
  void pedal(Gate gate, bool down, bool good);
  void make_ready();
  void set_back(Publisher<std_msgs::msg::Bool>& to, bool right, const char* words);
  void look_round();
  void look_for_writers();
  void look_for_teleops();

  HapticNames names_;
  std::vector<std::string> writers_;
  const bool absolute_frame_;  ///< wrenches in the base's frame; otherwise in the tip's
  const bool needs_frame_;     ///< no force while nobody listens to that
  std::atomic<bool> meddled_{false};
  std::atomic<unsigned> gates_{0};
  std::atomic<double> scale_{0.0};
  std::mutex mutex_, telling_;  // of the news; of those who publish
  std::vector<std::string> news_;

  Node node_;
  Publisher<std_msgs::msg::Bool> absolute_, gravity_;
  Ear<std_msgs::msg::Bool> absolute_ear_, gravity_ear_;
  Ear<crtk_msgs::msg::OperatingState> leader_;
  std::optional<Ear<crtk_msgs::msg::OperatingState>> follower_;
  Ear<sensor_msgs::msg::Joy> operator_, clutch_, camera_;
  std::optional<Ear<std_msgs::msg::Bool>> following_;
  std::optional<Ear<std_msgs::msg::Float64>> scale_ear_;
  std::list<Teleop> others_;
  std::size_t listeners_ = 0;
  int looks_ = 0;
  std::string other_;  ///< that is on, as it was told
  int nameless_ = 0;   ///< looks, one after the other, at writers whose node is not known
  Spinner spinner_;
  std::condition_variable woken_;
  bool stop_ = false;
  std::thread looker_;
};

}  // namespace palpate::ros
