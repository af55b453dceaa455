// The frame in which a stream of poses is reported: its frame_id must stay what it was in the first message.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <string>

namespace palpate::ros {

/// Compares the frame_id of each message with the first one. check() is for the receiving thread and does not allocate;
/// other threads read words().
class FrameName {
 public:
  /// True if the frame is the one of the first message.
  bool check(const std::string& frame_id) noexcept {
    if (!known_) {
      keep(frame_id, first_);
      known_ = true;
      return true;
    }
    if (same(frame_id, first_)) return true;
    if (state_.load(std::memory_order_acquire) == kQuiet) {
      keep(frame_id, other_);
      state_.store(kNew, std::memory_order_release);
    }
    return false;
  }
  /// A sentence about a new frame of `topic`, once per change; empty: none.
  [[nodiscard]] std::string words(const std::string& topic) {
    int expected = kNew;
    if (!state_.compare_exchange_strong(expected, kTold)) return {};
    return topic + " has the frame_id \"" + other_ + "\" instead of \"" + first_ +
           "\": no force. Mend: let the arm report in its first frame, or restart this node with the scene's base for "
           "it";
  }

 private:
  static constexpr int kQuiet = 0, kNew = 1, kTold = 2;
  static constexpr std::size_t kLongest = 63;  // characters that are compared

  static void keep(const std::string& name, char* to) noexcept {
    const std::size_t n = std::min(name.size(), kLongest);
    std::copy_n(name.data(), n, to);
    to[n] = 0;
  }
  static bool same(const std::string& name, const char* kept) noexcept { return name.compare(0, kLongest, kept) == 0; }

  bool known_ = false;
  char first_[kLongest + 1] = {}, other_[kLongest + 1] = {};
  std::atomic<int> state_{kQuiet};
};

}  // namespace palpate::ros
