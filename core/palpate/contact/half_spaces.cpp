#include "palpate/contact/half_spaces.hpp"

#include <algorithm>
#include <utility>

namespace palpate::contact {
namespace {

constexpr double kParallel = 1e-14;  // a smaller Gram determinant means linearly dependent normals

/// Projects g onto the intersection of the planes of the set, x = g + sum lambda_i n_i. Returns false if the normals
/// are linearly dependent or a multiplier lambda_i is negative.
bool solve(const HalfSpace* h, Projection& set, const Vec3& g, Vec3& lambda) {
  Mat3 G = Mat3::Identity();
  Vec3 b = Vec3::Zero();
  for (int i = 0; i < set.active; ++i) {
    b[i] = -h[set.index[static_cast<std::size_t>(i)]].gap(g);
    for (int j = 0; j < set.active; ++j)
      G(i, j) = h[set.index[static_cast<std::size_t>(i)]].normal.dot(h[set.index[static_cast<std::size_t>(j)]].normal);
  }
  if (set.active == 1) {
    lambda = b;
  } else {
    const double det = G.determinant();
    if (!(det > kParallel)) return false;
    // Cramer's rule: for at most 3 x 3 it needs no decomposition, which could allocate or branch.
    Mat3 adjugate;
    adjugate.col(0) = G.row(1).cross(G.row(2)).transpose();
    adjugate.col(1) = G.row(2).cross(G.row(0)).transpose();
    adjugate.col(2) = G.row(0).cross(G.row(1)).transpose();
    lambda = adjugate * b / det;
  }
  set.x = g;
  for (int i = 0; i < set.active; ++i) {
    if (lambda[i] < 0.0) return false;
    set.x += lambda[i] * h[set.index[static_cast<std::size_t>(i)]].normal;
  }
  return true;
}

/// True if the candidate satisfies the half-space `added` and the active half-spaces of `old`.
bool satisfies(const HalfSpace* h, const Projection& candidate, const Projection& old, int added, double slack) {
  if (h[added].gap(candidate.x) < -slack) return false;
  for (int i = 0; i < old.active; ++i)
    if (h[old.index[static_cast<std::size_t>(i)]].gap(candidate.x) < -slack) return false;
  return true;
}

/// Sorts the active half-spaces by their multipliers, the largest first.
void strongest_first(Projection& set, Vec3& lambda) {
  for (int i = 1; i < set.active; ++i) {
    for (int j = i; j > 0 && lambda[j] > lambda[j - 1]; --j) {
      std::swap(lambda[j], lambda[j - 1]);
      std::swap(set.index[static_cast<std::size_t>(j)], set.index[static_cast<std::size_t>(j - 1)]);
    }
  }
}

/// Adds the half-space `added` to the active set. The new solution is active in `added` and in some of the old
/// half-spaces. Returns false if no such set solves the problem.
bool extend(const HalfSpace* h, Projection& set, int added, const Vec3& g, double slack) {
  const Projection old = set;
  for (int size = 1; size <= 3; ++size) {  // the smallest sets first: they are the cheapest and the best conditioned
    for (unsigned mask = 0; mask < (1U << old.active); ++mask) {
      if (__builtin_popcount(mask) != size - 1) continue;
      Projection candidate;
      candidate.index[0] = added;
      candidate.active = 1;
      for (int i = 0; i < old.active; ++i) {
        if ((mask >> i & 1U) != 0)
          candidate.index[static_cast<std::size_t>(candidate.active++)] = old.index[static_cast<std::size_t>(i)];
      }
      Vec3 lambda;
      if (!solve(h, candidate, g, lambda) || !satisfies(h, candidate, old, added, slack)) continue;
      strongest_first(candidate, lambda);
      set = candidate;
      return true;
    }
  }
  return false;
}

}  // namespace

Projection project(const HalfSpace* half_spaces, int n, const Vec3& g, double slack) noexcept {
  Projection set;
  set.x = g;
  for (int step = 0; step < 3 * kMaxHalfSpaces; ++step) {  // terminates, because the distance to g grows in each step
    int worst = -1;
    double least = -slack;
    for (int i = 0; i < n; ++i) {
      const double gap = half_spaces[i].gap(set.x);
      if (gap < least) {
        least = gap;
        worst = i;
      }
    }
    if (worst < 0) return set;
    if (!extend(half_spaces, set, worst, g, slack)) break;
  }
  set.feasible = false;
  return set;
}

}  // namespace palpate::contact
