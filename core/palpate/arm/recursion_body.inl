// The recursion itself, included by recursion_portable.cpp, recursion_avx2.cpp and recursion_avx512.cpp, which define
// PALPATE_TARGET. It calls no function of another header, because the linker might then keep a copy that was compiled
// for the wrong machine.

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
  constexpr double S[] = {-1.0 / 6.0,        1.0 / 120.0,        -1.0 / 5040.0,          1.0 / 362880.0,
                          -1.0 / 39916800.0, 1.0 / 6227020800.0, -1.0 / 1307674368000.0, 1.0 / 355687428096000.0};
  constexpr double C[] = {1.0 / 24.0,        -1.0 / 720.0,         1.0 / 40320.0,         -1.0 / 3628800.0,
                          1.0 / 479001600.0, -1.0 / 87178291200.0, 1.0 / 20922789888000.0};
  for (int k = 0; k < kLanes; ++k) {
    const double shifted = x[k] * kTwoOverPi + kRound;
    const double n = shifted - kRound;  // the nearest whole number
    const double r = ((x[k] - n * kPart1) - n * kPart2) - n * kPart3, z = r * r;
    const double z2 = z * z, z4 = z2 * z2;
    // The sums in pairs (Estrin), which need not wait for each other: S = (sin r - r) / r^3, C = (cos r - 1 + z/2) /
    // z^2
    const double S_low = (S[0] + S[1] * z) + (S[2] + S[3] * z) * z2,
                 S_high = (S[4] + S[5] * z) + (S[6] + S[7] * z) * z2;
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

#include "palpate/arm/recursion_dynamics.inl"
