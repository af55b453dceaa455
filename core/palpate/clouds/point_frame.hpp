// The part of a depth camera's frame that becomes a surface.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "palpate/types/spatial.hpp"

namespace palpate::clouds {

/// A ball in W.
struct Ball {
  Vec3 p = Vec3::Zero();  ///< centre [m]
  double radius = 0.0;    ///< radius [m]
};

/// Number of points of a frame by what became of them.
struct FrameCount {
  std::size_t used = 0;     ///< used for the surface
  std::size_t invalid = 0;  ///< not finite, or at the camera itself
  std::size_t outside = 0;  ///< outside the region
  std::size_t tool = 0;     ///< on the tool
};

/// Points in W [m] of a frame of 3n coordinates in the camera's frame C [m], in its order: those that are finite,
/// inside the ball `region` and outside all balls of the tool. The frame is read in the precision of the camera.
std::vector<double> usable_points(std::span<const float> points_C, const Pose& X_WC, const Ball& region,
                                  std::span<const Ball> tool, FrameCount& count);
/// The same with double precision.
std::vector<double> usable_points(std::span<const double> points_C, const Pose& X_WC, const Ball& region,
                                  std::span<const Ball> tool, FrameCount& count);

}  // namespace palpate::clouds
