// A queue from the loop to the recorder: one writer, one reader, wait-free, of fixed size.
#pragma once

#include <atomic>
#include <bit>
#include <cstdint>
#include <vector>

namespace palpate::loop {

template <typename T>
class Ring {
 public:
  /// opened: false leaves the slots, which are megabytes for ticks, to open(): a loop that only ever runs in lockstep
  /// needs none.
  explicit Ring(std::size_t at_least, bool opened = true) : capacity_(std::bit_ceil(at_least)) {
    if (opened) open();
  }

  /// Allocates the slots, unless they are there; while neither end is in use.
  void open() { slots_.resize(capacity_); }
  /// False, and counted, when the queue is not open or the reader is too slow: the newest is lost, the loop goes on.
  bool push(const T& value) noexcept {
    const std::uint64_t head = head_.load(std::memory_order_relaxed);
    if (head - tail_.load(std::memory_order_acquire) == slots_.size()) {
      dropped_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    slots_[head & (slots_.size() - 1)] = value;
    head_.store(head + 1, std::memory_order_release);
    return true;
  }
  bool pop(T& value) noexcept {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    if (tail == head_.load(std::memory_order_acquire)) {
      return false;
    }
    value = slots_[tail & (slots_.size() - 1)];
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }
  [[nodiscard]] std::size_t size() const noexcept {
    return head_.load(std::memory_order_acquire) - tail_.load(std::memory_order_acquire);
  }
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  alignas(64) std::atomic<std::uint64_t> head_{0};  // the writer's cache line
  std::atomic<std::uint64_t> dropped_{0};
  std::size_t capacity_;
  std::vector<T> slots_;
  alignas(64) std::atomic<std::uint64_t> tail_{0};  // the reader's
};

}  // namespace palpate::loop
