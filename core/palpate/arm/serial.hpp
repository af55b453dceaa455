// A serial arm of a URDF (Pinocchio behind it).
#pragma once

#include "palpate/arm/mechanism.hpp"
#include "palpate/arm/recursion.hpp"

namespace palpate::arm {

/// Throws std::runtime_error naming the frame or joint, and the mend.
/// The arm is the chain from base to tip; other joints (jaws, drawn parallelograms) stay at zero.
[[nodiscard]] std::unique_ptr<Mechanism> serial_arm(const std::string& xml, const std::string& base_frame,
                                                    const std::string& tip_frame);

/// Constants of the recursion for this chain, for tests that compare its two builds.
[[nodiscard]] ChainLanes chain_lanes(const std::string& xml, const std::string& base_frame,
                                     const std::string& tip_frame);

}  // namespace palpate::arm
