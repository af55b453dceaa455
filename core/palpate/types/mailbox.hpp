// Exchange of data between a real-time loop and other threads. Neither side ever waits.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <utility>

namespace palpate {

/// Mailbox that holds the newest value, for one writer and one reader. The writer and the reader own one of the three
/// slots each and exchange it with the third.
template <typename T>
class Mailbox {
 public:
  Mailbox() = default;
  /// `first` is read until the first write(). A container of its size is later written without allocation.
  explicit Mailbox(const T& first) : slots_{first, first, first} {}

  /// Publishes a value by copy assignment, which must not throw. Only the writer may call it.
  void write(const T& value) noexcept {
    slots_[static_cast<std::size_t>(writer_)] = value;
    writer_ = middle_.exchange(writer_ | kFresh, std::memory_order_acq_rel) & ~kFresh;
  }
  /// Newest published value; before the first write() that of the constructor. The reference is valid until the next
  /// read(). Only the reader may call it.
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

/// Hands objects over to a loop, which never frees memory: replaced objects wait in a list until the next publish()
/// frees them. With a const T nobody changes them; otherwise only the loop may.
template <typename T>
class Handover {
 public:
  /// `first` is the current object until the first update() that returns true.
  explicit Handover(std::shared_ptr<T> first) : current_(new Node{std::move(first), nullptr}) {}
  ~Handover() {
    release(incoming_.load());
    release(retired_.load());
    delete current_;
  }
  Handover(const Handover&) = delete;
  Handover& operator=(const Handover&) = delete;

  /// Offers `next` to the loop and frees the objects that the loop has replaced. One thread at a time may call it, but
  /// never the loop.
  void publish(std::shared_ptr<T> next) {
    release(incoming_.exchange(new Node{std::move(next), nullptr}, std::memory_order_acq_rel));
    release(retired_.exchange(nullptr, std::memory_order_acquire));
  }
  /// Makes the newest offered object the current one. Returns false when no new object is offered. Only the loop may
  /// call it.
  bool update() noexcept {
    if (incoming_.load(std::memory_order_relaxed) == nullptr) return false;  // an exchange waits for all stores before
    Node* next = incoming_.exchange(nullptr, std::memory_order_acq_rel);
    if (next == nullptr) {
      return false;
    }
    // Only publish() competes, and it empties the list: the exchange repeats at most once per publish().
    current_->next = retired_.load(std::memory_order_relaxed);
    while (!retired_.compare_exchange_weak(current_->next, current_, std::memory_order_release)) {
    }
    current_ = next;
    return true;
  }
  /// The object that the loop uses at present.
  [[nodiscard]] T& current() const noexcept { return *current_->value; }

 private:
  struct Node {
    std::shared_ptr<T> value;
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
