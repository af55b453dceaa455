// Conversion of signed integers to container indices.
#pragma once

#include <concepts>
#include <cstddef>

namespace palpate {

/// Converts `i`, which must not be negative, to the unsigned index type of the standard containers.
[[nodiscard]] constexpr std::size_t to_index(std::integral auto i) noexcept { return static_cast<std::size_t>(i); }

}  // namespace palpate
