// Hand-over between a loop and everybody else. Neither side ever waits.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <utility>

namespace palpate {

/// The newest value, one writer, one reader: three slots, so that each side always owns one.
template <typename T>
class Mailbox {
 public:
  void write(const T& value) noexcept {
    slots_[static_cast<std::size_t>(writer_)] = value;
    writer_ = middle_.exchange(writer_ | kFresh, std::memory_order_acq_rel) & ~kFresh;
  }
  /// The newest value written, or the one read before.
  const T& read() noexcept {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) != 0) {
      reader_ = middle_.exchange(reader_, std::memory_order_acq_rel) & ~kFresh;
    }
    return slots_[static_cast<std::size_t>(reader_)];
  }

 private:
  static constexpr int kFresh = 4;
  std::array<T, 3> slots_{};
  std::atomic<int> middle_{1};
  int writer_ = 0, reader_ = 2;
};

/// A whole new object for the loop, without a release of memory in the loop: what it drops waits in a list until the
/// giver comes by again.
template <typename T>
class Handover {
 public:
  explicit Handover(std::shared_ptr<const T> first) : current_(new Node{std::move(first), nullptr}) {}
  ~Handover() {
    release(incoming_.load());
    release(retired_.load());
    delete current_;
  }
  Handover(const Handover&) = delete;
  Handover& operator=(const Handover&) = delete;

  /// The giver's side (one at a time).
  void give(std::shared_ptr<const T> next) {
    release(incoming_.exchange(new Node{std::move(next), nullptr}, std::memory_order_acq_rel));
    release(retired_.exchange(nullptr, std::memory_order_acquire));
  }
  /// The loop's side. True when there is a new object.
  bool take() noexcept {
    Node* next = incoming_.exchange(nullptr, std::memory_order_acq_rel);
    if (next == nullptr) {
      return false;
    }
    // Only give() competes, and it empties the list: one repetition at most per gift.
    current_->next = retired_.load(std::memory_order_relaxed);
    while (!retired_.compare_exchange_weak(current_->next, current_, std::memory_order_release)) {
    }
    current_ = next;
    return true;
  }
  [[nodiscard]] const T& current() const noexcept { return *current_->value; }

 private:
  struct Node {
    std::shared_ptr<const T> value;
    Node* next;
  };
  static void release(Node* node) {
    while (node != nullptr) {
      delete std::exchange(node, node->next);
    }
  }

  std::atomic<Node*> incoming_{nullptr}, retired_{nullptr};
  Node* current_;
};

}  // namespace palpate
