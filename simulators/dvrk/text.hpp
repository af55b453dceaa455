// A text of bounded length, so that a servo period can compose messages without allocation.
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <string_view>

namespace palpate::dvrk {

/// Text of bounded length; characters that do not fit are cut off, and a number that does not fit is omitted.
class Text {
 public:
  Text() = default;
  Text(std::string_view words) noexcept { *this << words; }            // NOLINT(google-explicit-constructor)
  Text(const char* words) noexcept : Text(std::string_view(words)) {}  // NOLINT(google-explicit-constructor)

  Text& operator<<(std::string_view words) noexcept {
    const std::size_t n = std::min(words.size(), letters_.size() - size_);
    std::copy_n(words.begin(), n, letters_.begin() + static_cast<std::ptrdiff_t>(size_));
    size_ += n;
    return *this;
  }
  Text& operator<<(long number) noexcept { return print(number); }
  Text& operator<<(double number) noexcept { return print(number, std::chars_format::general, 6); }

  [[nodiscard]] std::string_view view() const noexcept { return {letters_.data(), size_}; }
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  friend bool operator==(const Text& a, std::string_view b) noexcept { return a.view() == b; }

 private:
  template <typename... Format>
  Text& print(Format... number) noexcept {
    char* const end = letters_.data() + letters_.size();
    const auto [after, error] = std::to_chars(letters_.data() + size_, end, number...);
    if (error == std::errc{}) size_ = static_cast<std::size_t>(after - letters_.data());
    return *this;
  }

  std::array<char, 232> letters_{};
  std::size_t size_ = 0;
};

}  // namespace palpate::dvrk
