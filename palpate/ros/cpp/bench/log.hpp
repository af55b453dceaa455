// A log that one thread writes and other threads read, without a lock, so that readers never delay the writer.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <vector>

namespace palpate::ros {

/// Grows in blocks that never move. Once all blocks are full, further entries are dropped.
template <class T>
class Log {
 public:
  /// Appends an entry; from one thread only. Allocates once every kPiece entries.
  void add(const T& note) {
    const std::size_t n = size_.load(std::memory_order_relaxed);
    if (n == kPiece * pieces_.size()) return;
    auto& piece = pieces_[n / kPiece];
    if (!piece) piece = std::make_unique<T[]>(kPiece);
    piece[n % kPiece] = note;
    size_.store(n + 1, std::memory_order_release);
  }
  /// A copy of all entries so far; from any thread.
  [[nodiscard]] std::vector<T> all() const {
    const std::size_t n = size_.load(std::memory_order_acquire);
    std::vector<T> notes(n);
    for (std::size_t i = 0; i < n; i += kPiece) {
      std::copy_n(pieces_[i / kPiece].get(), std::min(kPiece, n - i), notes.begin() + static_cast<std::ptrdiff_t>(i));
    }
    return notes;
  }

 private:
  static constexpr std::size_t kPiece = 8192;
  std::array<std::unique_ptr<T[]>, 512> pieces_;
  std::atomic<std::size_t> size_{0};
};

}  // namespace palpate::ros
