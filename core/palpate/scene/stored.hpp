// An array that owns its values, or reads them where a stored image holds them.
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace palpate::scene {

/// Values that are made once and then only read. Those of an image stay in it: it may be a file that is mapped into
/// memory, of which the system loads only the pages that are used.
template <class T>
class Stored {
 public:
  Stored() = default;
  Stored(std::vector<T> values) : own_(std::move(values)), data_(own_.data()), size_(own_.size()) {}  // NOLINT
  /// Copies the values, also those of an image.
  Stored(const Stored& other) : Stored(std::vector<T>(other.begin(), other.end())) {}
  Stored(Stored&& other) noexcept
      : own_(std::move(other.own_)), data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}
  Stored& operator=(Stored other) noexcept {
    own_ = std::move(other.own_);
    data_ = other.data_;
    size_ = other.size_;
    return *this;
  }
  ~Stored() = default;

  /// The values of an image, which must outlive them.
  static Stored inside(std::span<const T> values) {
    Stored found;
    found.data_ = values.data();
    found.size_ = values.size();
    return found;
  }

  [[nodiscard]] const T* data() const noexcept { return data_; }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  [[nodiscard]] const T& operator[](std::size_t i) const noexcept { return data_[i]; }
  [[nodiscard]] const T* begin() const noexcept { return data_; }
  [[nodiscard]] const T* end() const noexcept { return data_ + size_; }
  /// The own values, to change them; empty for those of an image.
  [[nodiscard]] std::span<T> own() noexcept { return own_; }
  /// Takes the own values out, and leaves the array empty.
  [[nodiscard]] std::vector<T> take() noexcept {
    data_ = nullptr;
    size_ = 0;
    return std::move(own_);
  }

 private:
  std::vector<T> own_;
  const T* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace palpate::scene
