// The recursion itself, included by recursion_portable.cpp and recursion_avx2.cpp, which define PALPATE_TARGET. No
// function of another header may be called: it would be compiled for the wrong machine.

/// World axes and origin of every link, one joint after the other.
PALPATE_TARGET void chain_kinematics(const ChainLanes& c, const double* q, ChainState& s) noexcept {
  double R[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  // columns
  double p[3] = {0, 0, 0};
  for (int k = 0; k < c.n; ++k) {
    const ChainLanes::Joint& joint = c.joint[k];
    double B[3][3];
    for (int i = 0; i < 3; ++i) p[i] += R[0][i] * joint.p[0] + R[1][i] * joint.p[1] + R[2][i] * joint.p[2];
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 3; ++i) {
        B[j][i] = R[0][i] * joint.R[j][0] + R[1][i] * joint.R[j][1] + R[2][i] * joint.R[j][2];
      }
    }
    double w[3];
    for (int i = 0; i < 3; ++i) {
      w[i] = joint.aligned >= 0 ? B[joint.aligned][i]
                                : B[0][i] * joint.axis[0] + B[1][i] * joint.axis[1] + B[2][i] * joint.axis[2];
    }
    if (joint.prismatic) {
      for (int i = 0; i < 3; ++i) p[i] += q[k] * w[i];
      for (int j = 0; j < 3; ++j) {
        for (int i = 0; i < 3; ++i) R[j][i] = B[j][i];
      }
    } else {
      const double sine = __builtin_sin(q[k]), cosine = __builtin_cos(q[k]);
      if (joint.aligned >= 0) {
        const int x = (joint.aligned + 1) % 3, y = (joint.aligned + 2) % 3;
        for (int i = 0; i < 3; ++i) {
          R[joint.aligned][i] = B[joint.aligned][i];
          R[x][i] = cosine * B[x][i] + sine * B[y][i];
          R[y][i] = cosine * B[y][i] - sine * B[x][i];
        }
      } else {  // Rodrigues' formula, applied to each column about the world axis w
        for (int j = 0; j < 3; ++j) {
          const double* b = B[j];
          const double along = (1.0 - cosine) * (w[0] * b[0] + w[1] * b[1] + w[2] * b[2]);
          R[j][0] = cosine * b[0] + sine * (w[1] * b[2] - w[2] * b[1]) + along * w[0];
          R[j][1] = cosine * b[1] + sine * (w[2] * b[0] - w[0] * b[2]) + along * w[1];
          R[j][2] = cosine * b[2] + sine * (w[0] * b[1] - w[1] * b[0]) + along * w[2];
        }
      }
    }
    for (int i = 0; i < 3; ++i) {
      s.p[i][k] = p[i];
      for (int j = 0; j < 3; ++j) s.R[3 * j + i][k] = R[j][i];
    }
    if (joint.prismatic) {
      for (int i = 0; i < 3; ++i) s.Jv[i][k] = w[i];
      for (int i = 0; i < 3; ++i) s.Jw[i][k] = 0.0;
    } else {
      for (int i = 0; i < 3; ++i) s.Jw[i][k] = w[i];
      s.Jv[0][k] = p[1] * w[2] - p[2] * w[1];
      s.Jv[1][k] = p[2] * w[0] - p[0] * w[2];
      s.Jv[2][k] = p[0] * w[1] - p[1] * w[0];
    }
  }
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

PALPATE_TARGET inline void sum_forward(Lanes& x, double first) noexcept {
  double sum = first;
  for (int k = 0; k < kLanes; ++k) x[k] = sum += x[k];
}

PALPATE_TARGET inline void sum_backward(Lanes& x) noexcept {
  for (int k = kLanes - 2; k >= 0; --k) x[k] += x[k + 1];
}

/// V and A of every link: sums along the chain, with dJ_k/dt = V_k x J_k.
PALPATE_TARGET inline void motion(const ChainLanes& c, const Lanes& v, const Lanes& a, ChainState& s) noexcept {
  alignas(64) double d[6][kLanes];
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < kLanes; ++k) s.V[i][k] = d[i][k] = s.Jv[i][k] * v[k];
    for (int k = 0; k < kLanes; ++k) s.V[3 + i][k] = d[3 + i][k] = s.Jw[i][k] * v[k];
  }
  for (auto& x : s.V) sum_forward(x, 0.0);
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
  for (int i = 0; i < 3; ++i) sum_forward(s.A[i], -c.g[i]);
  for (int i = 3; i < 6; ++i) sum_forward(s.A[i], 0.0);
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
    s.tau[k] = s.Jv[0][k] * F[0][k] + s.Jv[1][k] * F[1][k] + s.Jv[2][k] * F[2][k] + s.Jw[0][k] * F[3][k] +
               s.Jw[1][k] * F[4][k] + s.Jw[2][k] * F[5][k];
  }
}

/// M and G from the inertia of each link and all that it carries: M_ki = J_i . (I_k J_k) for i <= k.
PALPATE_TARGET inline void composite(const ChainLanes& c, Inertias& b, ChainState& s) noexcept {
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
  for (int k = 0; k < kLanes; ++k) {
    for (int i = 0; i < kLanes; ++i) {
      s.M[k][i] = s.Jv[0][i] * P[0][k] + s.Jv[1][i] * P[1][k] + s.Jv[2][i] * P[2][k] + s.Jw[0][i] * P[3][k] +
                  s.Jw[1][i] * P[4][k] + s.Jw[2][i] * P[5][k];
    }
  }
}

}  // namespace

PALPATE_TARGET void chain_dynamics(const ChainLanes& c, const double* q, const double* v, const double* a,
                                   ChainState& s) noexcept {
  alignas(64) Lanes v_lanes{}, a_lanes{};
  for (int k = 0; k < c.n; ++k) {
    v_lanes[k] = v[k];
    a_lanes[k] = a[k];
  }
  chain_kinematics(c, q, s);
  Inertias b;
  inertias(c, s, b);
  motion(c, v_lanes, a_lanes, s);
  newton_euler(b, s);
  composite(c, b, s);
}
