// A body that moves with another one: how twists go forth and wrenches back (NOTATION.md, "Virtual work").
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate {

/// The twist J V of the body that follows, for the twist V of the one that leads; J is the derivative of the pose of
/// one with respect to that of the other, both as (displacement, rotation vector) in one frame.
[[nodiscard]] inline Twist carried(const Mat6& J, const Twist& V) noexcept {
  Vec6 x;
  x << V.v, V.w;
  const Vec6 y = J * x;
  return {y.head<3>(), y.tail<3>()};
}

/// The wrench J^T F on the body that leads, for the wrench F on the one that follows: both do the same work.
[[nodiscard]] inline Wrench carried_back(const Mat6& J, const Wrench& F) noexcept {
  Vec6 x;
  x << F.f, F.t;
  const Vec6 y = J.transpose() * x;
  return {y.head<3>(), y.tail<3>()};
}

}  // namespace palpate
