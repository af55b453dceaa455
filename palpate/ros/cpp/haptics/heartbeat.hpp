// What the haptic node and its guardian share: a page of memory, so that neither needs the other to be well.
#pragma once

#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>

namespace palpate::ros {

/// All zero at first. Times are of the monotonic clock [ns].
struct Heartbeat {
  std::atomic<std::int64_t> node;         ///< of the node's last sign of life; zero before the first
  std::atomic<std::int64_t> guardian;     ///< of the guardian's last look
  std::atomic<std::uint32_t> taken;       ///< how often the guardian has taken over
  std::atomic<std::uint32_t> seen;        ///< how much of that the node knows: equal to `taken` when it may push
  std::atomic<std::uint32_t> finished;    ///< 1: the node ended well, its last wrench was zero
  std::atomic<std::uint32_t> commanding;  ///< 1: the node sends wrenches; where it must not, the guardian must not
  std::atomic<std::uint32_t> listeners;   ///< of the guardian's wrenches
  std::atomic<std::int64_t> silence;      ///< longest that the node was silent when the guardian took over [ns]
};
static_assert(std::atomic<std::int64_t>::is_always_lock_free, "shared between processes");

/// The page behind a file descriptor (memfd_create), mapped for as long as this lives.
class SharedHeartbeat {
 public:
  explicit SharedHeartbeat(int fd) {
    void* page = MAP_FAILED;
    if (ftruncate(fd, sizeof(Heartbeat)) == 0) {
      page = mmap(nullptr, sizeof(Heartbeat), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    }
    if (page == MAP_FAILED) throw std::runtime_error(std::string("cannot share memory: ") + std::strerror(errno));
    heartbeat_ = static_cast<Heartbeat*>(page);
  }
  ~SharedHeartbeat() { munmap(heartbeat_, sizeof(Heartbeat)); }
  SharedHeartbeat(const SharedHeartbeat&) = delete;
  SharedHeartbeat& operator=(const SharedHeartbeat&) = delete;

  Heartbeat* operator->() const noexcept { return heartbeat_; }

 private:
  Heartbeat* heartbeat_;
};

}  // namespace palpate::ros
