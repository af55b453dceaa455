// Small signed integers as positions in standard containers.
#pragma once

#include <concepts>
#include <cstddef>

namespace palpate {

/// The position `i`, which must not be negative, as the unsigned type that standard containers take.
[[nodiscard]] constexpr std::size_t to_index(std::integral auto i) noexcept { return static_cast<std::size_t>(i); }

}  // namespace palpate
