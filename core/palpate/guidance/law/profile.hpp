// What laws share: a force along what is wanted, with damping that is never a jump and never pulls the other way.
#pragma once

#include <algorithm>

#include "palpate/guidance/fixture.hpp"

namespace palpate::guidance {

/// Deviation over which the damping comes in: at the border of a fixture a moving hand feels no step [m], [rad].
inline constexpr double kComesIn = 2e-4, kComesInTurn = 5e-3;

/// Along `want.along`: f - B r s, r the gap's rate and s = f / (K come-in) at most 1; within 0..most. The force beside
/// a moment is the spring's alone. f: of the spring [N, N m]; K, B: of place or of turning, as the want is.
inline Pull along(const Want& want, const Twist& V_WT, double f, double K, double B, double most) noexcept {
  Pull out;
  if (f <= 0.0) return out;
  const double in = K * (want.turns ? kComesInTurn : kComesIn);
  const double damping = -B * std::min(f / in, 1.0) * want.rate(V_WT);
  const double sum = std::clamp(f + damping, 0.0, most);
  out.F = {(want.turns ? f : sum) * want.along.f, sum * want.along.t};
  return out;
}

}  // namespace palpate::guidance
