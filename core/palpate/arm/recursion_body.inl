// The recursion itself, included by recursion_portable.cpp and recursion_avx2.cpp, which define PALPATE_TARGET. It
// calls no function of another header, because the linker might then keep a copy that was compiled for the wrong
// machine.

namespace {

static_assert(kLanes == 8);
using Four = double __attribute__((vector_size(4 * sizeof(double))));
using FourBits = std::int64_t __attribute__((vector_size(4 * sizeof(std::int64_t))));
constexpr int kStride = 16;  // numbers of one link's pose: three axes and the origin, each with a fourth number of zero

/// Sine and cosine of each lane, to within two units in the last place for |x| below a million. The angle is reduced by
/// a multiple of pi/2 with Cody and Waite's three parts; Taylor's series follow. Unlike the C library's functions, the
/// result has the same bits on every machine.
PALPATE_TARGET inline void sines(const Lanes& x, Lanes& sine, Lanes& cosine) noexcept {
  constexpr double kTwoOverPi = 0.63661977236758134308, kRound = 6755399441055744.0;  // 1.5 * 2^52
  constexpr double kPart1 = 0x1.921fb544p+0, kPart2 = 0x1.0b4611a6p-34, kPart3 = 0x1.3198a2e037073p-69;
  constexpr double S[] = {-1.0 / 6.0,         1.0 / 120.0,         -1.0 / 5040.0,          1.0 / 362880.0,
                          -1.0 / 39916800.0, 1.0 / 6227020800.0, -1.0 / 1307674368000.0, 1.0 / 355687428096000.0};
  constexpr double C[] = {1.0 / 24.0,       -1.0 / 720.0,         1.0 / 40320.0,         -1.0 / 3628800.0,
                          1.0 / 479001600.0, -1.0 / 87178291200.0, 1.0 / 20922789888000.0};
  for (int k = 0; k < kLanes; ++k) {
    const double shifted = x[k] * kTwoOverPi + kRound;
    const double n = shifted - kRound;  // the nearest whole number
    const double r = ((x[k] - n * kPart1) - n * kPart2) - n * kPart3, z = r * r;
    const double z2 = z * z, z4 = z2 * z2;
    // The sums in pairs (Estrin), which need not wait for each other: S = (sin r - r) / r^3, C = (cos r - 1 + z/2) / z^2
    const double S_low = (S[0] + S[1] * z) + (S[2] + S[3] * z) * z2, S_high = (S[4] + S[5] * z) + (S[6] + S[7] * z) * z2;
    const double C_low = (C[0] + C[1] * z) + (C[2] + C[3] * z) * z2, C_high = (C[4] + C[5] * z) + C[6] * z2;
    const double s = r + (r * z) * (S_low + S_high * z4);
    const double c = (1.0 - 0.5 * z) + z2 * (C_low + C_high * z4);
    const double odd = n - 2.0 * ((0.5 * n + kRound) - kRound);  // -1, 0 or 1
    const double half = 0.5 * (n - odd);                         // n = 2 half + odd
    const double turned = half - 2.0 * ((0.5 * half + kRound) - kRound);
    const double sign = 1.0 - 2.0 * turned * turned;
    const double even = 1.0 - odd * odd;
    sine[k] = sign * (even * s + odd * c);
    cosine[k] = sign * (even * c - odd * s);
  }
}

/// The same by the C library, for angles that are too large or not finite.
PALPATE_TARGET __attribute__((noinline, cold)) void large_sines(const Lanes& x, Lanes& sine, Lanes& cosine) noexcept {
  for (int k = 0; k < kLanes; ++k) {
    sine[k] = __builtin_sin(x[k]);
    cosine[k] = __builtin_cos(x[k]);
  }
}

/// The lanes of x whose mask is set; zero elsewhere, whatever x contains there.
PALPATE_TARGET inline void select(const LaneMask& mask, const Lanes& x, Lanes& out) noexcept {
  for (int k = 0; k < kLanes; k += 4) {
    FourBits bits, chosen;
    __builtin_memcpy(&bits, x + k, sizeof bits);
    __builtin_memcpy(&chosen, mask + k, sizeof chosen);
    bits &= chosen;
    __builtin_memcpy(out + k, &bits, sizeof bits);
  }
}

/// Sum of the absolute values.
PALPATE_TARGET inline double sum_of_sizes(const Lanes& x) noexcept {
  Lanes sizes;
  for (int k = 0; k < kLanes; ++k) sizes[k] = __builtin_fabs(x[k]);
  for (int k = 0; k < 4; ++k) sizes[k] += sizes[k + 4];
  return (sizes[0] + sizes[1]) + (sizes[2] + sizes[3]);
}

/// Pose of each link in the previous one at q: columns of R, origin.
PALPATE_TARGET inline void joint_poses(const ChainLanes& c, const Lanes& q, Lanes (&T)[12]) noexcept {
  alignas(64) Lanes angle, slide, sine, cosine;
  select(c.revolute, q, angle);
  select(c.prismatic, q, slide);
  sum_of_sizes(angle) < 1e6 ? sines(angle, sine, cosine) : large_sines(angle, sine, cosine);
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < kLanes; ++k) {
      const double x = c.R[i][k], y = c.R[3 + i][k], z = c.R[6 + i][k];
      T[i][k] = cosine[k] * x + sine[k] * y;
      T[3 + i][k] = cosine[k] * y - sine[k] * x;
      T[6 + i][k] = z;
      T[9 + i][k] = c.p[i][k] + slide[k] * z;
    }
  }
}

/// Rows, of which each has four numbers, transposed. `from` and `to`: first row; the others follow at these distances.
PALPATE_TARGET inline void transpose(const double* from, std::ptrdiff_t from_distance, double* to,
                                     int rows = 4) noexcept {
  Four a, b, c, d;
  __builtin_memcpy(&a, from, sizeof a);
  __builtin_memcpy(&b, from + from_distance, sizeof b);
  __builtin_memcpy(&c, from + 2 * from_distance, sizeof c);
  __builtin_memcpy(&d, from + 3 * from_distance, sizeof d);
  const Four ab_even = __builtin_shufflevector(a, b, 0, 4, 2, 6), ab_odd = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Four cd_even = __builtin_shufflevector(c, d, 0, 4, 2, 6), cd_odd = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  a = __builtin_shufflevector(ab_even, cd_even, 0, 1, 4, 5);
  b = __builtin_shufflevector(ab_odd, cd_odd, 0, 1, 4, 5);
  c = __builtin_shufflevector(ab_even, cd_even, 2, 3, 6, 7);
  d = __builtin_shufflevector(ab_odd, cd_odd, 2, 3, 6, 7);
  __builtin_memcpy(to, &a, sizeof a);
  __builtin_memcpy(to + kLanes, &b, sizeof b);
  __builtin_memcpy(to + std::ptrdiff_t{2} * kLanes, &c, sizeof c);
  if (rows == 4) __builtin_memcpy(to + std::ptrdiff_t{3} * kLanes, &d, sizeof d);
}

/// A pose whose columns and origin have a fourth number of zero.
struct Frame {
  Four x, y, z, p;
};

/// Pose of the tip, and the Jacobian moved from the base's origin to it.
PALPATE_TARGET inline void place_tip(const ChainLanes& c, const Frame& last, ChainState& s) noexcept {
  for (int i = 0; i < 4; ++i) {
    Four column = last.x * c.tip[i][0] + (last.y * c.tip[i][1] + last.z * c.tip[i][2]);
    if (i == 3) column += last.p;
    __builtin_memcpy(s.tip[i], &column, sizeof column);
  }
  const double x = s.tip[3][0], y = s.tip[3][1], z = s.tip[3][2];
  for (int k = 0; k < kLanes; ++k) {
    const double wx = s.Jw[0][k], wy = s.Jw[1][k], wz = s.Jw[2][k];
    s.J[0][k] = s.Jv[0][k] + (wy * z - wz * y);
    s.J[1][k] = s.Jv[1][k] + (wz * x - wx * z);
    s.J[2][k] = s.Jv[2][k] + (wx * y - wy * x);
    s.J[3][k] = wx;
    s.J[4][k] = wy;
    s.J[5][k] = wz;
  }
}

}  // namespace

/// World axes and origin of each link: the product of the joints' poses, one after the other.
PALPATE_TARGET void chain_kinematics(const ChainLanes& c, const Lanes& q, ChainState& s) noexcept {
  alignas(64) Lanes T[12];
  joint_poses(c, q, T);
  alignas(64) double world[kLanes][kStride];  // axes x, y, z and origin of each link, four numbers each
  Four x = {1, 0, 0, 0}, y = {0, 1, 0, 0}, z = {0, 0, 1, 0}, p = {0, 0, 0, 0};
  Frame last = {x, y, z, p};
  for (int k = 0; k < kLanes; ++k) {
    if (k < c.n) {
      p += x * T[9][k] + y * T[10][k] + z * T[11][k];
      const Four x_next = x * T[0][k] + y * T[1][k] + z * T[2][k];
      const Four y_next = x * T[3][k] + y * T[4][k] + z * T[5][k];
      z = x * T[6][k] + y * T[7][k] + z * T[8][k];
      x = x_next;
      y = y_next;
      last = {x, y, z, p};
    } else {
      x = y = z = p = Four{};
    }
    __builtin_memcpy(world[k], &x, sizeof x);
    __builtin_memcpy(world[k] + 4, &y, sizeof y);
    __builtin_memcpy(world[k] + 8, &z, sizeof z);
    __builtin_memcpy(world[k] + 12, &p, sizeof p);
  }
  for (int k = 0; k < kLanes; k += 4) {
    for (std::ptrdiff_t j = 0; j < 3; ++j) transpose(world[k] + 4 * j, kStride, s.R[3 * j] + k, 3);
    transpose(world[k] + 12, kStride, s.p[0] + k, 3);
  }
  for (int k = 0; k < kLanes; ++k) {
    const double wx = s.R[6][k], wy = s.R[7][k], wz = s.R[8][k], px = s.p[0][k], py = s.p[1][k], pz = s.p[2][k];
    const double turns = c.turns[k], slides = c.slides[k];
    s.Jw[0][k] = turns * wx;
    s.Jw[1][k] = turns * wy;
    s.Jw[2][k] = turns * wz;
    s.Jv[0][k] = turns * (py * wz - pz * wy) + slides * wx;
    s.Jv[1][k] = turns * (pz * wx - px * wz) + slides * wy;
    s.Jv[2][k] = turns * (px * wy - py * wx) + slides * wz;
  }
  place_tip(c, last, s);
}

namespace {

/// Mass, first moment and inertia about the world's origin: of each link, or of a link and all that it carries.
struct alignas(64) Inertias {
  Lanes m, h[3], I[6];
};

/// Inertia of every link in world axes about the base's origin.
PALPATE_TARGET inline void inertias(const ChainLanes& c, const ChainState& s, Inertias& b) noexcept {
  for (int k = 0; k < kLanes; ++k) {
    const double xx = s.R[0][k], xy = s.R[1][k], xz = s.R[2][k];
    const double yx = s.R[3][k], yy = s.R[4][k], yz = s.R[5][k];
    const double zx = s.R[6][k], zy = s.R[7][k], zz = s.R[8][k];
    const double m = c.m[k];
    const double cx = xx * c.c[0][k] + yx * c.c[1][k] + zx * c.c[2][k] + s.p[0][k];
    const double cy = xy * c.c[0][k] + yy * c.c[1][k] + zy * c.c[2][k] + s.p[1][k];
    const double cz = xz * c.c[0][k] + yz * c.c[1][k] + zz * c.c[2][k] + s.p[2][k];
    const double hx = m * cx, hy = m * cy, hz = m * cz;
    b.m[k] = m, b.h[0][k] = hx, b.h[1][k] = hy, b.h[2][k] = hz;
    // R I, then (R I) R^T and the parallel axes
    const double ax = xx * c.I[0][k] + yx * c.I[1][k] + zx * c.I[3][k];
    const double ay = xx * c.I[1][k] + yx * c.I[2][k] + zx * c.I[4][k];
    const double az = xx * c.I[3][k] + yx * c.I[4][k] + zx * c.I[5][k];
    const double bx = xy * c.I[0][k] + yy * c.I[1][k] + zy * c.I[3][k];
    const double by = xy * c.I[1][k] + yy * c.I[2][k] + zy * c.I[4][k];
    const double bz = xy * c.I[3][k] + yy * c.I[4][k] + zy * c.I[5][k];
    const double dx = xz * c.I[0][k] + yz * c.I[1][k] + zz * c.I[3][k];
    const double dy = xz * c.I[1][k] + yz * c.I[2][k] + zz * c.I[4][k];
    const double dz = xz * c.I[3][k] + yz * c.I[4][k] + zz * c.I[5][k];
    b.I[0][k] = ax * xx + ay * yx + az * zx + (hy * cy + hz * cz);
    b.I[1][k] = ax * xy + ay * yy + az * zy - hx * cy;
    b.I[2][k] = bx * xy + by * yy + bz * zy + (hx * cx + hz * cz);
    b.I[3][k] = ax * xz + ay * yz + az * zz - hx * cz;
    b.I[4][k] = bx * xz + by * yz + bz * zz - hy * cz;
    b.I[5][k] = dx * xz + dy * yz + dz * zz + (hx * cx + hy * cy);
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

/// Newton and Euler: F = I A + V x* I V of every link about the origin, summed from the tip; tau = J . F.
PALPATE_TARGET inline void newton_euler(const Inertias& b, ChainState& s) noexcept {
  alignas(64) double F[6][kLanes];
  for (int k = 0; k < kLanes; ++k) {
    const double vx = s.V[0][k], vy = s.V[1][k], vz = s.V[2][k], wx = s.V[3][k], wy = s.V[4][k], wz = s.V[5][k];
    const double ax = s.A[0][k], ay = s.A[1][k], az = s.A[2][k], ux = s.A[3][k], uy = s.A[4][k], uz = s.A[5][k];
    const double m = b.m[k], hx = b.h[0][k], hy = b.h[1][k], hz = b.h[2][k];
    const double px = m * vx + (wy * hz - wz * hy);  // momentum
    const double py = m * vy + (wz * hx - wx * hz);
    const double pz = m * vz + (wx * hy - wy * hx);
    const double lx = b.I[0][k] * wx + b.I[1][k] * wy + b.I[3][k] * wz + (hy * vz - hz * vy);
    const double ly = b.I[1][k] * wx + b.I[2][k] * wy + b.I[4][k] * wz + (hz * vx - hx * vz);
    const double lz = b.I[3][k] * wx + b.I[4][k] * wy + b.I[5][k] * wz + (hx * vy - hy * vx);
    F[0][k] = m * ax + (uy * hz - uz * hy) + (wy * pz - wz * py);
    F[1][k] = m * ay + (uz * hx - ux * hz) + (wz * px - wx * pz);
    F[2][k] = m * az + (ux * hy - uy * hx) + (wx * py - wy * px);
    F[3][k] = b.I[0][k] * ux + b.I[1][k] * uy + b.I[3][k] * uz + (hy * az - hz * ay) + (wy * lz - wz * ly) +
              (vy * pz - vz * py);
    F[4][k] = b.I[1][k] * ux + b.I[2][k] * uy + b.I[4][k] * uz + (hz * ax - hx * az) + (wz * lx - wx * lz) +
              (vz * px - vx * pz);
    F[5][k] = b.I[3][k] * ux + b.I[4][k] * uy + b.I[5][k] * uz + (hx * ay - hy * ax) + (wx * ly - wy * lx) +
              (vx * py - vy * px);
  }
  for (auto& x : F) sum_backward(x);
  for (int k = 0; k < kLanes; ++k) {
    s.bias[k] = s.Jv[0][k] * F[0][k] + s.Jv[1][k] * F[1][k] + s.Jv[2][k] * F[2][k] + s.Jw[0][k] * F[3][k] +
                s.Jw[1][k] * F[4][k] + s.Jw[2][k] * F[5][k];
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
  sum_backward(b.m);
  for (auto& x : b.h) sum_backward(x);
  for (auto& x : b.I) sum_backward(x);
  alignas(64) double P[6][kLanes];  // momentum of a unit velocity of each joint
  for (int k = 0; k < kLanes; ++k) {
    const double vx = s.Jv[0][k], vy = s.Jv[1][k], vz = s.Jv[2][k], wx = s.Jw[0][k], wy = s.Jw[1][k], wz = s.Jw[2][k];
    const double m = b.m[k], hx = b.h[0][k], hy = b.h[1][k], hz = b.h[2][k];
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
  newton_euler(b, s);
  composite(c, body, b, s);
}
