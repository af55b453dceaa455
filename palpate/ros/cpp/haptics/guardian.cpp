#include "haptics/guardian.hpp"

#include <poll.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <geometry_msgs/msg/wrench_stamped.hpp>
#include <thread>

#include "palpate/loop/realtime.hpp"
#include "rcl/node.hpp"
#include "rcl/publisher.hpp"

namespace palpate::ros {
namespace {

using loop::now_ns;

std::int64_t nanoseconds(double seconds) { return static_cast<std::int64_t>(1e9 * seconds); }

/// Watches a process through a pidfd, which stays valid when the process id is used again.
class Life {
 public:
  explicit Life(int pid) : fd_(static_cast<int>(syscall(SYS_pidfd_open, pid, 0))) {
    if (fd_ < 0) throw std::runtime_error("cannot watch process " + std::to_string(pid) + ": " + std::strerror(errno));
  }
  ~Life() { close(fd_); }
  Life(const Life&) = delete;
  Life& operator=(const Life&) = delete;
  /// Waits at most `ns` [ns] for the end of the process; returns true if it has ended.
  [[nodiscard]] bool ended(std::int64_t ns) const noexcept {
    pollfd wait{.fd = fd_, .events = POLLIN, .revents = 0};
    const timespec most{.tv_sec = ns / 1'000'000'000, .tv_nsec = ns % 1'000'000'000};
    return ppoll(&wait, 1, &most, nullptr) > 0;
  }

 private:
  int fd_;
};

}  // namespace

bool guard(const std::shared_ptr<Context>& context, const GuardianOptions& options) {
  const SharedHeartbeat beat(options.beat_fd);
  const Life life(options.node_pid);
  Node node(context, options.node_name);
  const Publisher<geometry_msgs::msg::WrenchStamped> wrench(node, options.wrench_topic);
  geometry_msgs::msg::WrenchStamped zero;
  loop::schedule({.allow_priority = true, .allow_affinity = false, .priority = 85, .spin_us = 0.0});
  const auto send = [&] {
    if (beat->commanding == 0) return;
    timespec t{};
    clock_gettime(CLOCK_REALTIME, &t);
    zero.header.stamp.sec = static_cast<std::int32_t>(t.tv_sec);
    zero.header.stamp.nanosec = static_cast<std::uint32_t>(t.tv_nsec);
    if (const Status sent = wrench.publish(zero); !sent) node.problem(sent.problem);
  };
  const std::int64_t period = nanoseconds(options.period), silence = nanoseconds(options.silence);
  std::int64_t died = 0, looked = now_ns(), took = 0;
  for (;;) {
    const bool dead = died != 0 || life.ended(period);
    if (died != 0) std::this_thread::sleep_for(std::chrono::nanoseconds(period));
    const std::int64_t now = now_ns(), beaten = beat->node.load();
    beat->guardian = now;
    beat->listeners = static_cast<std::uint32_t>(wrench.listeners());
    // True if the guardian itself was suspended: the silence of the node is not known yet.
    const bool away = now - looked > silence;
    looked = now;
    if (beat->finished != 0) {
      for (int i = 0; i < 5; ++i) send();
      return true;
    }
    if (dead && died == 0) {
      died = took = now;
      ++beat->taken;
    }
    if (died != 0 && now - died > nanoseconds(options.insist)) return false;
    const bool taken = beat->taken != beat->seen;
    if (!taken && !away && beaten != 0 && now - beaten > silence) {
      took = now;
      beat->silence = std::max(beat->silence.load(), now - beaten);
      ++beat->taken;
    }
    // The arm keeps the zero wrench. Sending for longer would disturb the next program that uses the arm.
    if (beat->taken != beat->seen && now - took < nanoseconds(options.insist)) send();
  }
}

}  // namespace palpate::ros
