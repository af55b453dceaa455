// A wait-free queue of fixed size from the loop to the recorder, for one writer and one reader.
#pragma once

#include <atomic>
#include <bit>
#include <cstdint>
#include <vector>

namespace palpate::loop {

/// A ring buffer for one writer and one reader.
template <typename T>
class Ring {
 public:
  /// at_least: capacity, rounded up to a power of two. opened: false defers the allocation to open(), because the slots
  /// for ticks take megabytes and a loop in lockstep does not use them.
  explicit Ring(std::size_t at_least, bool opened = true) : capacity_(std::bit_ceil(at_least)) {
    if (opened) open();
  }

  /// Allocates the slots unless they exist. Neither writer nor reader may use the queue meanwhile.
  void open() { slots_.resize(capacity_); }
  /// Appends a value. Returns false, and counts the value as dropped, if the queue is full or not open.
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
  /// Takes the oldest value. Returns false if the queue is empty.
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
  alignas(64) std::atomic<std::uint64_t> head_{0};  // cache line of the writer
  std::atomic<std::uint64_t> dropped_{0};
  std::size_t capacity_;
  std::vector<T> slots_;
  alignas(64) std::atomic<std::uint64_t> tail_{0};  // cache line of the reader
};

}  // namespace palpate::loop
