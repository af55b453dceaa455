// Checks the payload of a command to an arm.
#pragma once

#include "dvrk/messages.hpp"

namespace palpate::dvrk {

/// The reason why an arm of n joints cannot use the payload, such as a number that is not finite; empty if it can.
[[nodiscard]] Text payload_refusal(const Command& command, const VerbEntry& verb, Eigen::Index n) noexcept;

}  // namespace palpate::dvrk
