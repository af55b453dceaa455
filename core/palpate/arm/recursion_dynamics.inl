// The second half of the recursion: dynamics. See recursion_body.inl, which includes it.

namespace {

/// Centre of mass of each link and its inertia about it, in world axes; after about_origin() the first moment and the
/// inertia about the base's origin.
struct alignas(64) Inertias {
  Lanes c[3], I[6];
};

/// Centre of mass and inertia of every link.
PALPATE_TARGET inline void inertias(const ChainLanes& c, const ChainState& s, Inertias& b) noexcept {
  for (int k = 0; k < kLanes; ++k) {
    const double xx = s.R[0][k], xy = s.R[1][k], xz = s.R[2][k];
    const double yx = s.R[3][k], yy = s.R[4][k], yz = s.R[5][k];
    const double zx = s.R[6][k], zy = s.R[7][k], zz = s.R[8][k];
    b.c[0][k] = xx * c.c[0][k] + yx * c.c[1][k] + zx * c.c[2][k] + s.p[0][k];
    b.c[1][k] = xy * c.c[0][k] + yy * c.c[1][k] + zy * c.c[2][k] + s.p[1][k];
    b.c[2][k] = xz * c.c[0][k] + yz * c.c[1][k] + zz * c.c[2][k] + s.p[2][k];
    // R I, then (R I) R^T
    const double ax = xx * c.I[0][k] + yx * c.I[1][k] + zx * c.I[3][k];
    const double ay = xx * c.I[1][k] + yx * c.I[2][k] + zx * c.I[4][k];
    const double az = xx * c.I[3][k] + yx * c.I[4][k] + zx * c.I[5][k];
    const double bx = xy * c.I[0][k] + yy * c.I[1][k] + zy * c.I[3][k];
    const double by = xy * c.I[1][k] + yy * c.I[2][k] + zy * c.I[4][k];
    const double bz = xy * c.I[3][k] + yy * c.I[4][k] + zy * c.I[5][k];
    const double dx = xz * c.I[0][k] + yz * c.I[1][k] + zz * c.I[3][k];
    const double dy = xz * c.I[1][k] + yz * c.I[2][k] + zz * c.I[4][k];
    const double dz = xz * c.I[3][k] + yz * c.I[4][k] + zz * c.I[5][k];
    b.I[0][k] = ax * xx + ay * yx + az * zx;
    b.I[1][k] = ax * xy + ay * yy + az * zy;
    b.I[2][k] = bx * xy + by * yy + bz * zy;
    b.I[3][k] = ax * xz + ay * yz + az * zz;
    b.I[4][k] = bx * xz + by * yz + bz * zz;
    b.I[5][k] = dx * xz + dy * yz + dz * zz;
  }
}

/// x_k <- x_0 + ... + x_k
PALPATE_TARGET inline void sum_forward(Lanes& x) noexcept {
  Four low, high;
  const Four zero = {};
  __builtin_memcpy(&low, x, sizeof low);
  __builtin_memcpy(&high, x + 4, sizeof high);
  low += __builtin_shufflevector(low, zero, 4, 0, 1, 2);
  high += __builtin_shufflevector(high, zero, 4, 0, 1, 2);
  low += __builtin_shufflevector(low, zero, 4, 5, 0, 1);
  high += __builtin_shufflevector(high, zero, 4, 5, 0, 1);
  high += __builtin_shufflevector(low, low, 3, 3, 3, 3);
  __builtin_memcpy(x, &low, sizeof low);
  __builtin_memcpy(x + 4, &high, sizeof high);
}

/// x_k <- x_k + ... + x_7
PALPATE_TARGET inline void sum_backward(Lanes& x) noexcept {
  Four low, high;
  const Four zero = {};
  __builtin_memcpy(&low, x, sizeof low);
  __builtin_memcpy(&high, x + 4, sizeof high);
  low += __builtin_shufflevector(low, zero, 1, 2, 3, 4);
  high += __builtin_shufflevector(high, zero, 1, 2, 3, 4);
  low += __builtin_shufflevector(low, zero, 2, 3, 4, 5);
  high += __builtin_shufflevector(high, zero, 2, 3, 4, 5);
  low += __builtin_shufflevector(high, high, 0, 0, 0, 0);
  __builtin_memcpy(x, &low, sizeof low);
  __builtin_memcpy(x + 4, &high, sizeof high);
}

/// V and A of every link: sums along the chain, with dJ_k/dt = V_k x J_k.
PALPATE_TARGET inline void motion(const ChainLanes& c, const Lanes& v, const Lanes& a, ChainState& s) noexcept {
  alignas(64) double d[6][kLanes];
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < kLanes; ++k) s.V[i][k] = d[i][k] = s.Jv[i][k] * v[k];
    for (int k = 0; k < kLanes; ++k) s.V[3 + i][k] = d[3 + i][k] = s.Jw[i][k] * v[k];
  }
  for (auto& x : s.V) sum_forward(x);
  for (int k = 0; k < kLanes; ++k) {
    const double wx = s.V[3][k], wy = s.V[4][k], wz = s.V[5][k];
    const double vx = s.V[0][k], vy = s.V[1][k], vz = s.V[2][k];
    s.A[0][k] = s.Jv[0][k] * a[k] + (wy * d[2][k] - wz * d[1][k]) + (vy * d[5][k] - vz * d[4][k]);
    s.A[1][k] = s.Jv[1][k] * a[k] + (wz * d[0][k] - wx * d[2][k]) + (vz * d[3][k] - vx * d[5][k]);
    s.A[2][k] = s.Jv[2][k] * a[k] + (wx * d[1][k] - wy * d[0][k]) + (vx * d[4][k] - vy * d[3][k]);
    s.A[3][k] = s.Jw[0][k] * a[k] + (wy * d[5][k] - wz * d[4][k]);
    s.A[4][k] = s.Jw[1][k] * a[k] + (wz * d[3][k] - wx * d[5][k]);
    s.A[5][k] = s.Jw[2][k] * a[k] + (wx * d[4][k] - wy * d[3][k]);
  }
  for (auto& x : s.A) sum_forward(x);
  for (int i = 0; i < 3; ++i) {
    for (double& x : s.A[i]) x -= c.g[i];
  }
}

/// Newton and Euler: force m a and torque I u + w x I w of every link at its centre of mass, summed from the tip about
/// the origin; tau = J . F.
PALPATE_TARGET inline void newton_euler(const ChainLanes& chain, const Inertias& b, ChainState& s) noexcept {
  alignas(64) double F[6][kLanes];
  for (int k = 0; k < kLanes; ++k) {
    const double wx = s.V[3][k], wy = s.V[4][k], wz = s.V[5][k], ux = s.A[3][k], uy = s.A[4][k], uz = s.A[5][k];
    const double cx = b.c[0][k], cy = b.c[1][k], cz = b.c[2][k], m = chain.m[k];
    const double vx = s.V[0][k] + (wy * cz - wz * cy);
    const double vy = s.V[1][k] + (wz * cx - wx * cz);
    const double vz = s.V[2][k] + (wx * cy - wy * cx);
    const double fx = m * (s.A[0][k] + (uy * cz - uz * cy) + (wy * vz - wz * vy));
    const double fy = m * (s.A[1][k] + (uz * cx - ux * cz) + (wz * vx - wx * vz));
    const double fz = m * (s.A[2][k] + (ux * cy - uy * cx) + (wx * vy - wy * vx));
    const double lx = b.I[0][k] * wx + b.I[1][k] * wy + b.I[3][k] * wz;
    const double ly = b.I[1][k] * wx + b.I[2][k] * wy + b.I[4][k] * wz;
    const double lz = b.I[3][k] * wx + b.I[4][k] * wy + b.I[5][k] * wz;
    F[0][k] = fx;
    F[1][k] = fy;
    F[2][k] = fz;
    F[3][k] = b.I[0][k] * ux + b.I[1][k] * uy + b.I[3][k] * uz + (wy * lz - wz * ly) + (cy * fz - cz * fy);
    F[4][k] = b.I[1][k] * ux + b.I[2][k] * uy + b.I[4][k] * uz + (wz * lx - wx * lz) + (cz * fx - cx * fz);
    F[5][k] = b.I[3][k] * ux + b.I[4][k] * uy + b.I[5][k] * uz + (wx * ly - wy * lx) + (cx * fy - cy * fx);
  }
  for (auto& x : F) sum_backward(x);
  for (int k = 0; k < kLanes; ++k) {
    s.bias[k] = s.Jv[0][k] * F[0][k] + s.Jv[1][k] * F[1][k] + s.Jv[2][k] * F[2][k] + s.Jw[0][k] * F[3][k] +
                s.Jw[1][k] * F[4][k] + s.Jw[2][k] * F[5][k];
  }
}

/// First moment and inertia about the base's origin, by the theorem of parallel axes.
PALPATE_TARGET inline void about_origin(const ChainLanes& chain, Inertias& b) noexcept {
  for (int k = 0; k < kLanes; ++k) {
    const double cx = b.c[0][k], cy = b.c[1][k], cz = b.c[2][k], m = chain.m[k];
    const double hx = m * cx, hy = m * cy, hz = m * cz;
    b.c[0][k] = hx;
    b.c[1][k] = hy;
    b.c[2][k] = hz;
    b.I[0][k] += hy * cy + hz * cz;
    b.I[1][k] -= hx * cy;
    b.I[2][k] += hx * cx + hz * cz;
    b.I[3][k] -= hx * cz;
    b.I[4][k] -= hy * cz;
    b.I[5][k] += hx * cx + hy * cy;
  }
}

/// Copies the lower triangle of a block of four rows and columns at (k, k) into the upper one.
PALPATE_TARGET inline void mirror_block(Lanes (&M)[kLanes], int k) noexcept {
  alignas(64) Lanes transposed[4];
  transpose(M[k] + k, kLanes, transposed[0]);
  Four below[4], above[4];
  for (int i = 0; i < 4; ++i) {
    __builtin_memcpy(&below[i], M[k + i] + k, sizeof(Four));
    __builtin_memcpy(&above[i], transposed[i], sizeof(Four));
  }
  below[0] = __builtin_shufflevector(below[0], above[0], 0, 5, 6, 7);
  below[1] = __builtin_shufflevector(below[1], above[1], 0, 1, 6, 7);
  below[2] = __builtin_shufflevector(below[2], above[2], 0, 1, 2, 7);
  for (int i = 0; i < 3; ++i) __builtin_memcpy(M[k + i] + k, &below[i], sizeof(Four));
}

/// Copies the lower triangle of M into the upper one. Whole vectors, which the next reader need not wait for.
PALPATE_TARGET inline void mirror(Lanes (&M)[kLanes]) noexcept {
  transpose(M[4], kLanes, M[0] + 4);
  mirror_block(M, 0);
  mirror_block(M, 4);
}

/// Adds the momentum of the body at the tip at a unit velocity of each joint.
PALPATE_TARGET inline void carry(const TipBody& body, const ChainState& s, double (&P)[6][kLanes]) noexcept {
  const double x = s.tip[3][0], y = s.tip[3][1], z = s.tip[3][2];
  for (int k = 0; k < kLanes; ++k) {
    const double px = body.mass * s.J[0][k], py = body.mass * s.J[1][k], pz = body.mass * s.J[2][k];
    P[0][k] += px;
    P[1][k] += py;
    P[2][k] += pz;
    P[3][k] += body.inertia * s.Jw[0][k] + (y * pz - z * py);
    P[4][k] += body.inertia * s.Jw[1][k] + (z * px - x * pz);
    P[5][k] += body.inertia * s.Jw[2][k] + (x * py - y * px);
  }
}

/// M and G from the inertia of each link and all that it carries: M_ki = J_i . (I_k J_k) for i <= k.
PALPATE_TARGET inline void composite(const ChainLanes& c, const TipBody& body, Inertias& b, ChainState& s) noexcept {
  about_origin(c, b);
  for (auto& x : b.c) sum_backward(x);
  for (auto& x : b.I) sum_backward(x);
  alignas(64) double P[6][kLanes];  // momentum of a unit velocity of each joint
  for (int k = 0; k < kLanes; ++k) {
    const double vx = s.Jv[0][k], vy = s.Jv[1][k], vz = s.Jv[2][k], wx = s.Jw[0][k], wy = s.Jw[1][k], wz = s.Jw[2][k];
    const double m = c.m_carried[k], hx = b.c[0][k], hy = b.c[1][k], hz = b.c[2][k];
    P[0][k] = m * vx + (wy * hz - wz * hy);
    P[1][k] = m * vy + (wz * hx - wx * hz);
    P[2][k] = m * vz + (wx * hy - wy * hx);
    P[3][k] = b.I[0][k] * wx + b.I[1][k] * wy + b.I[3][k] * wz + (hy * vz - hz * vy);
    P[4][k] = b.I[1][k] * wx + b.I[2][k] * wy + b.I[4][k] * wz + (hz * vx - hx * vz);
    P[5][k] = b.I[3][k] * wx + b.I[4][k] * wy + b.I[5][k] * wz + (hx * vy - hy * vx);
    s.G[k] = -(c.g[0] * P[0][k] + c.g[1] * P[1][k] + c.g[2] * P[2][k]);
  }
  carry(body, s, P);
  for (int k = 0; k < kLanes; ++k) {
    for (int i = 0; i < (k < 4 ? 4 : kLanes); ++i) {
      s.M[k][i] = s.Jv[0][i] * P[0][k] + s.Jv[1][i] * P[1][k] + s.Jv[2][i] * P[2][k] + s.Jw[0][i] * P[3][k] +
                  s.Jw[1][i] * P[4][k] + s.Jw[2][i] * P[5][k];
    }
  }
  mirror(s.M);
}

/// Acceleration of the tip without joint acceleration, if s.A is that of no joint acceleration.
PALPATE_TARGET inline void drift(const ChainLanes& c, ChainState& s) noexcept {
  const int last = c.n > 0 ? c.n - 1 : 0;
  const double x = s.tip[3][0], y = s.tip[3][1], z = s.tip[3][2];
  const double wx = s.V[3][last], wy = s.V[4][last], wz = s.V[5][last];
  const double ax = s.A[3][last], ay = s.A[4][last], az = s.A[5][last];
  const double vx = s.V[0][last] + (wy * z - wz * y);
  const double vy = s.V[1][last] + (wz * x - wx * z);
  const double vz = s.V[2][last] + (wx * y - wy * x);
  s.Jdot_v[0] = s.A[0][last] + c.g[0] + (ay * z - az * y) + (wy * vz - wz * vy);
  s.Jdot_v[1] = s.A[1][last] + c.g[1] + (az * x - ax * z) + (wz * vx - wx * vz);
  s.Jdot_v[2] = s.A[2][last] + c.g[2] + (ax * y - ay * x) + (wx * vy - wy * vx);
  s.Jdot_v[4] = ax;
  s.Jdot_v[5] = ay;
  s.Jdot_v[6] = az;
}

}  // namespace

PALPATE_TARGET void chain_dynamics(const ChainLanes& c, const Lanes& q, const Lanes& v, const Lanes& a,
                                   const TipBody& body, ChainState& s) noexcept {
  alignas(64) Lanes v_chain, a_chain;
  select(c.joints, v, v_chain);
  select(c.joints, a, a_chain);
  chain_kinematics(c, q, s);
  Inertias b;
  inertias(c, s, b);
  motion(c, v_chain, a_chain, s);
  drift(c, s);
  newton_euler(c, b, s);
  composite(c, body, b, s);
}
