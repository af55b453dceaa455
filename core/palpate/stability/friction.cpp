#include "palpate/stability/friction.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace palpate::stability {

Dissipation::Dissipation(CertainFriction friction, double dt) : friction_(std::move(friction)), dt_(dt) {
  const Eigen::Index n = friction_.coulomb.size();
  for (JointVector* x : {&friction_.viscous, &friction_.quantum}) {
    if (x->size() == 0) *x = JointVector::Zero(n);
  }
  for (const JointVector* x : {&friction_.coulomb, &friction_.viscous, &friction_.quantum}) {
    if (x->size() != n || !(x->array() >= 0.0).all() || !x->allFinite()) {
      throw std::invalid_argument("stability.friction: coulomb, viscous and quantum need one entry per joint each (" +
                                  std::to_string(n) + "), finite, none below zero");
    }
  }
}

double Dissipation::step(const JointVector& q, double dt) noexcept {
  const Eigen::Index n = friction_.coulomb.size();
  if (q.size() != n || n == 0) return 0.0;
  if (shortest_.size() != n) {
    shortest_ = q;
    time_at_rest_ = JointVector::Zero(n);
    uncounted_ = 0.5 * friction_.quantum;
    return 0.0;
  }
  double heat = 0.0;
  for (Eigen::Index k = 0; k < n; ++k) {
    const double half = 0.5 * friction_.quantum[k];
    const double shortest = std::clamp(shortest_[k], q[k] - half, q[k] + half);
    const double begun = std::min(uncounted_[k], std::abs(shortest - shortest_[k]));
    const double moved = std::abs(shortest - shortest_[k]) - begun;
    uncounted_[k] -= begun;
    if (begun > 0.0) shortest_[k] = shortest;
    // The time between two edges of an encoder may exceed the time between the ticks that saw them by one period.
    time_at_rest_[k] += dt;
    if (moved > 0.0) {
      const double time = time_at_rest_[k] + (half > 0.0 ? dt : 0.0);
      heat += friction_.coulomb[k] * moved + friction_.viscous[k] * moved * moved / time;
      shortest_[k] = shortest;
      time_at_rest_[k] = 0.0;
    }
  }
  return heat;
}

}  // namespace palpate::stability
