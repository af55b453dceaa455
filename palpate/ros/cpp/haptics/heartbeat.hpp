// Memory shared by the haptic node and its guardian, so that each process can read the other's state at any time.
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

/// State of both processes. All fields start at zero; times are on the monotonic clock [ns].
struct Heartbeat {
  std::atomic<std::int64_t> node;      ///< time of the node's last heartbeat; zero before the first [ns]
  std::atomic<std::int64_t> guardian;  ///< time of the guardian's last check [ns]
  std::atomic<std::uint32_t> taken;    ///< number of takeovers by the guardian
  std::atomic<std::uint32_t> seen;  ///< number of takeovers the node has acknowledged; it may push if equal to `taken`
  std::atomic<std::uint32_t> finished;    ///< 1: the node ended cleanly, and its last wrench was zero
  std::atomic<std::uint32_t> commanding;  ///< 1: the node sends wrenches; the guardian sends none otherwise
  std::atomic<std::uint32_t> listeners;   ///< number of subscribers of the guardian's wrenches
  std::atomic<std::int64_t> silence;      ///< longest silence of the node at a takeover [ns]
};
static_assert(std::atomic<std::int64_t>::is_always_lock_free, "shared between processes");

/// Maps the Heartbeat behind a file descriptor (memfd_create) for the lifetime of the object.
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
