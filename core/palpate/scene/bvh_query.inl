// Nearest-point traversal, written once for two small vector types: F8 (8 floats) and D4 (4 doubles). It is included
// only by bvh_query_avx2.cpp and bvh_query_portable.cpp, each inside its own namespace and after the definitions of F8,
// D4 and PALPATE_TARGET.

/// Computes the squared distances from p to four triangles and replaces `best` if one is smaller. Every candidate is a
/// point of its triangle, so rounding cannot make a distance too small.
PALPATE_TARGET inline void nearest_in_block(const TriangleBlock& block, const std::int32_t* ids, const double p[3],
                                            BvhHit& best) {
  const D4 zero = D4::all(0.0), one = D4::all(1.0);
  D4 ap[3], e1[3], e2[3];
  for (int k = 0; k < 3; ++k) {
    ap[k] = D4::all(p[k]) - D4::load(block.a[k]);
    e1[k] = D4::load(block.e1[k]);
    e2[k] = D4::load(block.e2[k]);
  }
  const D4 g11 = dot(e1, e1), g12 = dot(e1, e2), g22 = dot(e2, e2);
  // The plane of a triangle is at least as near as the triangle. On the middle line of a tube this skips the many
  // triangles that are as near as the best one, up to rounding errors. The normal of a needle is too uncertain.
  D4 normal[3];
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3, m = (k + 2) % 3;
    normal[k] = e1[l] * e2[m] - e1[m] * e2[l];
  }
  const D4 height = dot(normal, ap), area2 = dot(normal, normal);
  const D4 beyond = D4::all(best.distance2 * (1.0 - 0x1p-40)) * area2 < height * height;
  if (mask_of(beyond & (D4::all(0x1p-20) * g11 * g22 < area2)) == 0xFU) return;
  const D4 d1 = dot(e1, ap), d2 = dot(e2, ap);
  const D4 det = g11 * g22 - g12 * g12;

  // Edges: a-b (v = t, w = 0), a-c (0, t), b-c (1 - t, t). Division by zero gives NaN, which clamp() turns into 0.
  const D4 t_ab = clamp(d1 / g11, zero, one);
  const D4 t_ac = clamp(d2 / g22, zero, one);
  const D4 t_bc = clamp((d2 - d1 + g11 - g12) / (g11 - g12 - g12 + g22), zero, one);
  const auto distance2 = [&](const D4& v, const D4& w) PALPATE_TARGET {
    D4 r[3];
    for (int k = 0; k < 3; ++k) r[k] = ap[k] - v * e1[k] - w * e2[k];
    return dot(r, r);
  };
  D4 v = t_ab, w = zero, least = distance2(t_ab, zero);
  const auto keep_less = [&](const D4& v_new, const D4& w_new, const D4& d_new, const D4& also) PALPATE_TARGET {
    const D4 better = also & (d_new < least);
    v = select(better, v_new, v);
    w = select(better, w_new, w);
    least = select(better, d_new, least);
  };
  const D4 always = zero <= one;
  keep_less(zero, t_ac, distance2(zero, t_ac), always);
  keep_less(one - t_bc, t_bc, distance2(one - t_bc, t_bc), always);

  // Interior of the face: the projection of p, if it lies inside the triangle.
  const D4 fv = (g22 * d1 - g12 * d2) / det, fw = (g11 * d2 - g12 * d1) / det;
  const D4 inside = (zero < fv) & (zero < fw) & (fv + fw < one) & (zero < det);
  keep_less(fv, fw, distance2(fv, fw), inside);

  double least_of[4], v_of[4], w_of[4];
  least.store(least_of);
  int lane = 0;
  for (int i = 1; i < 4; ++i) lane = least_of[i] < least_of[lane] ? i : lane;
  if (least_of[lane] < best.distance2) {
    v.store(v_of);
    w.store(w_of);
    best = {least_of[lane], v_of[lane], w_of[lane], ids[lane]};
  }
}

/// The query point in the coordinates of the boxes.
struct QueryPoint {
  F8 above[3], below[3];  // bounds of the point: rounding to float cannot make a box seem too far
  F8 at[3], slack;        // the rounded point, and the bound of the rounding error of a distance to a disc
};

/// Squared lower bounds of the distances to a node's children, from their boxes and discs.
PALPATE_TARGET inline F8 least_distance2(const BvhNode& node, const QueryPoint& p) {
  const F8 zero = F8::all(0.0F);
  F8 box = zero, far2 = zero, height = zero;
  for (int k = 0; k < 3; ++k) {
    const F8 d = max(max(F8::load(node.lo[k]) - p.above[k], p.below[k] - F8::load(node.hi[k])), zero);
    const F8 v = p.at[k] - F8::load(node.centre[k]);
    box = box + d * d;
    far2 = far2 + v * v;
    height = height + v * F8::load(node.normal[k]);
  }
  // max() turns NaN into zero. The box alone is then the bound.
  const F8 aside2 = far2 * F8::all(1.0F - 0x1p-19F) - height * height;
  const F8 up = max(max(height, zero - height) - F8::load(node.half) - p.slack, zero);
  const F8 aside = max(root(max(aside2, zero)) - F8::load(node.radius) - p.slack, zero);
  return max(box, up * up + aside * aside);
}

/// Traverses the tree depth first and the nearest child first. Children farther than the best point so far are skipped.
/// Beyond `exact_within` children that are not nearer than far_bound() are skipped, too.
PALPATE_TARGET inline BvhHit closest_in(const Bvh& bvh, const double p[3], const BvhHit& start, double exact_within) {
  BvhHit best = start;
  QueryPoint query;
  double farthest = 1.0;
  for (int k = 0; k < 3; ++k) {
    const double x = (p[k] - bvh.centre[k]) * bvh.scale;
    const double size = x < 0 ? -x : x, slack = 0x1p-22 * size;
    // p is NaN, infinite, or so far that squares overflow: nothing is near. max() would hide a NaN, and then unused
    // children seem near.
    if (!(size < 0x1p60)) return start;
    query.above[k] = F8::all(static_cast<float>(x + slack));
    query.below[k] = F8::all(static_cast<float>(x - slack));
    query.at[k] = F8::all(static_cast<float>(x));
    farthest = size > farthest ? size : farthest;
  }
  query.slack = F8::all(static_cast<float>(0x1p-19 * farthest));
  const double scale2 = bvh.scale * bvh.scale * (1.0 + 0x1p-20), exact2 = exact_within * exact_within;
  // The limit is always finite: unused children are infinitely far and must be beyond the limit.
  const auto limit_of = [scale2, exact2](double distance2) PALPATE_TARGET {
    constexpr double kFarthest = 0x1.fffffep127;  // the largest finite float
    const double far2 = kFar * kFar * distance2 > exact2 ? kFar * kFar * distance2 : exact2;
    const double limit2 = (distance2 <= exact2 ? distance2 : far2) * scale2;
    return static_cast<float>(limit2 < kFarthest ? limit2 : kFarthest);
  };
  float limit = limit_of(best.distance2);

  struct Entry {
    float distance2;
    std::int32_t child;
  };
  Entry stack[7 * kBvhLevels + 1];  // visiting a node removes one entry and adds at most eight
  int top = 0;
  stack[top++] = {0.0F, 0};
  while (top > 0) {
    const Entry entry = stack[--top];
    if (entry.distance2 > limit) continue;
    if (entry.child < 0) {
      const double before = best.distance2;
      const auto block = static_cast<std::size_t>(~entry.child);
      nearest_in_block(bvh.blocks[block], &bvh.ids[4 * block], p, best);
      if (best.distance2 < before) limit = limit_of(best.distance2);
      continue;
    }
    const BvhNode& node = bvh.nodes[static_cast<std::size_t>(entry.child)];
    const F8 least = least_distance2(node, query);
    float distance2[8];
    least.store(distance2);
    const int first = top;
    for (unsigned mask = mask_of(least <= F8::all(limit)); mask != 0; mask &= mask - 1) {
      const int lane = __builtin_ctz(mask);
      Entry child{distance2[lane], node.child[lane]};
      int i = top++;  // insertion sort: the nearest child ends on top
      for (; i > first && stack[i - 1].distance2 < child.distance2; --i) stack[i] = stack[i - 1];
      stack[i] = child;
    }
  }
  return best;
}
