// A serial arm described by a URDF.
#pragma once

#include "palpate/arm/mechanism.hpp"
#include "palpate/arm/recursion.hpp"

namespace palpate::arm {

/// The chain from base to tip; all other joints (jaws, parallelograms that are only drawn) stay at zero. Throws
/// std::runtime_error naming the frame or joint, and the remedy.
[[nodiscard]] std::unique_ptr<Mechanism> serial_arm(const std::string& xml, const std::string& base_frame,
                                                    const std::string& tip_frame);

/// Constants of the recursion for this chain, for tests that compare its builds.
[[nodiscard]] ChainLanes chain_lanes(const std::string& xml, const std::string& base_frame,
                                     const std::string& tip_frame);

}  // namespace palpate::arm
