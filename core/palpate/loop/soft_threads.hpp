// Threads of the soft bodies that step beside the cycle, one for each body.
#pragma once

#include <memory>
#include <vector>

#include "palpate/loop/realtime.hpp"
#include "palpate/scene/snapshot.hpp"

namespace palpate::loop {

/// The threads. One thread at a time may call the functions, but never the loop.
class SoftThreads {
 public:
  SoftThreads() = default;
  ~SoftThreads() { stop(); }
  SoftThreads(const SoftThreads&) = delete;
  SoftThreads& operator=(const SoftThreads&) = delete;

  /// Starts the threads for the bodies of a scene as the loop renders it.
  void start(const scene::Snapshot& rendered);
  /// After start(): continues with the bodies of another scene. Those of both scenes keep their threads.
  void update(const scene::Snapshot& rendered);
  void stop();

 private:
  struct Running {
    std::shared_ptr<const scene::Surface> surface;
    std::unique_ptr<RealTimeThread> thread;
  };
  bool started_ = false;
  std::vector<Running> running_;
};

}  // namespace palpate::loop
